//! ASCII STL: `solid NAME`, then facets of nine or ten words on seven lines, then `endsolid NAME`, as many solids as there are.
//!
//! The text is cut before lines that begin with `facet`. A few pieces are understood by all threads while the corners of the last few
//! are joined, so that the corners of the whole file, six times the vertices, never stand in memory at once.

use rayon::prelude::*;

use super::super::cursor::Cursor;
use super::super::points::{is_coordinate, no_coordinate};
use super::super::text::{self, Piece};
use super::super::{Stop, Surface, Task};
use super::Joined;

/// Pieces that a thread understands before the corners are joined.
const PIECES: usize = 2;
/// Bytes of the shortest facet.
const SHORTEST: usize = 54;
/// Lines between two looks at whether to go on.
const LINES: usize = 1 << 12;

/// Corners of a facet.
type Facet = [[f64; 3]; 3];

/// Reads an ASCII STL file.
pub(in crate::mesh::read) fn read(bytes: &[u8], task: &Task<'_>) -> Result<Surface, Stop> {
    let pieces = text::pieces(bytes, |text, at| {
        let mut cursor = Cursor::new(text, at);
        cursor.skip_blanks();
        cursor.word().eq_ignore_ascii_case(b"facet")
    });
    let mut joined: Option<Joined<f64>> = None;
    let mut is_open = false;
    let mut last: Vec<Facets> = Vec::new();
    for pieces in pieces.chunks(PIECES * rayon::current_num_threads()) {
        let (next, done) = rayon::join(
            || facets(pieces, task),
            || match &mut joined {
                Some(joined) => join(joined, std::mem::take(&mut last), task),
                None => Ok(()),
            },
        );
        done?;
        last = next?;
        if joined.is_none() {
            joined = Some(Joined::with_room(expected(&last, pieces, bytes.len()))?);
        }
        for facets in &last {
            is_open = facets.leaves_open.unwrap_or(is_open);
        }
    }
    let mut joined = match joined {
        Some(joined) => joined,
        None => Joined::with_room(0)?,
    };
    join(&mut joined, last, task)?;
    if is_open {
        let problem =
            "is the end, but the solid has no `endsolid`: the file is cut short, save it again";
        return Err(Stop::fault(bytes.trim_ascii_end().len(), problem));
    }
    joined.into_surface(task)
}

/// How many facets there will be in a file of so many bytes, by those of its first pieces.
fn expected(facets: &[Facets], pieces: &[Piece<'_>], bytes: usize) -> usize {
    let found: usize = facets.iter().map(|facets| facets.corners.len()).sum();
    let read: usize = pieces.iter().map(|piece| piece.text.len()).sum();
    if read == bytes {
        return found;
    }
    let all = found.saturating_mul(bytes) / read.max(1);
    // Numbers may get shorter.
    (all + all / 64 + 1).min(bytes / SHORTEST)
}

/// What a piece holds.
#[derive(Default)]
struct Facets {
    corners: Vec<Facet>,
    /// Whether it ends within a solid; unknown where none begins or ends.
    leaves_open: Option<bool>,
}

fn facets(pieces: &[Piece<'_>], task: &Task<'_>) -> Result<Vec<Facets>, Stop> {
    let facets = pieces.par_iter().map(|piece| of_piece(piece, task));
    let facets: Vec<_> = facets.collect();
    // The first fault of the file, whichever thread was first.
    facets.into_iter().collect()
}

fn join(joined: &mut Joined<f64>, facets: Vec<Facets>, task: &Task<'_>) -> Result<(), Stop> {
    for facet in facets.iter().flat_map(|facets| &facets.corners) {
        joined.add(*facet, task)?;
    }
    Ok(())
}

/// Reads the facets of a piece, which begins with a facet or with the file.
fn of_piece(piece: &Piece<'_>, task: &Task<'_>) -> Result<Facets, Stop> {
    let mut facets = Facets::default();
    let mut cursor = Cursor::new(piece.text, 0);
    // Corners of the facet that is open.
    let mut open: Option<(Facet, usize)> = None;
    for line in 0.. {
        if line % LINES == 0 {
            task.go_on()?;
        }
        cursor.skip_space();
        let at = cursor.at;
        let fault = |problem: &str| Err(Stop::fault(piece.at + at, problem));
        let word = cursor.word();
        match word {
            b"" => break,
            b"vertex" | b"VERTEX" | b"Vertex" => match &mut open {
                Some((corners, count)) if *count < 3 => {
                    corners[*count] = vertex(&mut cursor).map_err(|stop| stop.moved(piece.at))?;
                    *count += 1;
                }
                Some(_) => {
                    return fault("is a fourth vertex: facets have three, cut it into triangles");
                }
                None => return fault("is a vertex outside of any facet: save the file again"),
            },
            _ => match word.to_ascii_lowercase().as_slice() {
                b"facet" if open.is_none() => open = Some(Default::default()),
                b"endfacet" => match open.take() {
                    Some((corners, 3)) => facets.corners.push(corners),
                    _ => {
                        return fault(
                            "ends a facet that has not three vertices: mend or remove it",
                        );
                    }
                },
                b"solid" | b"endsolid" | b"facet" if open.is_some() => {
                    return fault("begins while a facet is open: end it with `endfacet`");
                }
                b"solid" => facets.leaves_open = Some(true),
                b"endsolid" => facets.leaves_open = Some(false),
                b"outer" | b"endloop" => {}
                _ => return fault("begins with no word of STL: remove the line"),
            },
        }
        cursor.skip_line();
    }
    if open.is_some() {
        let end = piece.at + piece.text.trim_ascii_end().len();
        let problem = "is the end, amid a facet: the file is cut short, save it again";
        return Err(Stop::fault(end, problem));
    }
    Ok(facets)
}

/// Three numbers.
fn vertex(cursor: &mut Cursor<'_>) -> Result<[f64; 3], Stop> {
    let mut point = [0.0; 3];
    for coordinate in &mut point {
        cursor.skip_blanks();
        let at = cursor.at;
        let Some(value) = cursor.number() else {
            let problem = format!(
                "has {} where a coordinate stands: a vertex has three numbers",
                cursor.shown()
            );
            return Err(Stop::fault(at, problem));
        };
        if !is_coordinate(value) {
            return Err(no_coordinate(at, value));
        }
        *coordinate = value;
    }
    Ok(point)
}
