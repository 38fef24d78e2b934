//! Wavefront OBJ: <https://paulbourke.net/dataformats/obj/>.
//!
//! The surface is in the lines `v` and `f`; all others (normals, textures, groups, materials, curves) are passed over, and no file that
//! one of them names is opened. The text is cut at ends of lines into pieces that all threads understand; vertices that a face counts
//! back from itself are counted from the piece's first vertex until all pieces' vertices are known.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::cursor::Cursor;
use super::points::{is_coordinate, mesh, no_coordinate};
use super::text::{self, Piece};
use super::{Stop, Surface, Task, with_room};

/// Lines, or corners of one face, between two looks at whether to go on.
const STEPS: usize = 1 << 12;

/// Reads an OBJ file.
pub(super) fn read(bytes: &[u8], task: &Task<'_>) -> Result<Surface, Stop> {
    let bytes_at = if bytes.starts_with(b"\xEF\xBB\xBF") {
        3
    } else {
        0
    };
    let pieces = text::pieces(&bytes[bytes_at..], |text, at| !is_continued(&text[..at]));
    let triangles = AtomicUsize::new(0);
    let parts = pieces.par_iter().map(|piece| part(piece, &triangles, task));
    let parts: Vec<_> = parts.collect();
    // The first fault of the file, whichever thread was first.
    let parts: Result<Vec<Part>, Stop> = parts.into_iter().collect();
    let surface = parts.and_then(|parts| whole(parts, &pieces, task));
    surface.map_err(|stop| stop.moved(bytes_at))
}

/// Whether a line that ends here goes on in the next.
fn is_continued(text: &[u8]) -> bool {
    let line = text.strip_suffix(b"\n").unwrap_or(text);
    line.strip_suffix(b"\r").unwrap_or(line).ends_with(b"\\")
}

/// What a piece holds.
#[derive(Default)]
struct Part {
    points: Vec<[f64; 3]>,
    /// By numbers from 0 of the whole file, or from the piece's first vertex, where they may be less than it.
    triangles: Vec<[i32; 3]>,
    /// For each triangle which corners count from the piece's first vertex, as bits; empty where none does.
    from_piece: Vec<u8>,
    skipped: usize,
}

/// A corner of a face.
#[derive(Clone, Copy, Default)]
struct Corner {
    number: i32,
    is_from_piece: bool,
}

impl Part {
    #[inline]
    fn add(&mut self, corners: [Corner; 3]) {
        let bits = corners.iter().rev();
        let bits = bits.fold(0, |bits, corner| bits << 1 | u8::from(corner.is_from_piece));
        if bits != 0 && self.from_piece.is_empty() {
            self.from_piece.resize(self.triangles.len(), 0);
        }
        self.triangles.push(corners.map(|corner| corner.number));
        if bits != 0 || !self.from_piece.is_empty() {
            self.from_piece.push(bits);
        }
    }
}

/// Puts the pieces' vertices and triangles together.
fn whole(mut parts: Vec<Part>, pieces: &[Piece<'_>], task: &Task<'_>) -> Result<Surface, Stop> {
    let vertices = parts.iter().map(|part| part.points.len()).sum();
    task.check_vertices(vertices)?;
    let mut points = with_room(vertices)?;
    let mut starts = with_room(parts.len())?;
    for part in &mut parts {
        task.go_on()?;
        starts.push(points.len());
        points.append(&mut std::mem::take(&mut part.points));
    }
    let mut surface = Surface {
        mesh: mesh(points, Vec::new()),
        skipped_faces: parts.iter().map(|part| part.skipped).sum(),
        ..Surface::default()
    };
    let count = parts.iter().map(|part| part.triangles.len()).sum();
    task.check_triangles(count)?;
    let mut triangles = with_room(count)?;
    for ((part, piece), start) in parts.into_iter().zip(pieces).zip(starts) {
        task.go_on()?;
        for (at, corners) in part.triangles.iter().enumerate() {
            let bits = part.from_piece.get(at).copied().unwrap_or(0);
            let Some(corners) = numbers(*corners, bits, start, vertices) else {
                return Err(out_of_range(piece, at, start, vertices));
            };
            triangles.push(corners);
        }
    }
    surface.mesh.triangles = triangles;
    Ok(surface)
}

/// A triangle's vertices by their numbers in the whole file, where all are there.
#[inline]
fn numbers(corners: [i32; 3], bits: u8, start: usize, vertices: usize) -> Option<[u32; 3]> {
    let mut numbers = [0; 3];
    for (place, (to, corner)) in numbers.iter_mut().zip(corners).enumerate() {
        let base = if bits >> place & 1 == 1 { start } else { 0 };
        let number = usize::try_from(i64::from(corner) + base as i64).ok()?;
        *to = u32::try_from(number).ok().filter(|_| number < vertices)?;
    }
    Some(numbers)
}

/// The fault of a piece's triangle by its number: its line is looked for again, since it was not kept.
fn out_of_range(piece: &Piece<'_>, triangle: usize, start: usize, vertices: usize) -> Stop {
    let task = Task {
        limits: &super::ReadLimits::default(),
        cancel: &std::sync::atomic::AtomicBool::new(false),
    };
    let mut reader = Reader::new(piece, &task);
    let mut at = piece.at;
    while reader.part.triangles.len() <= triangle {
        at = piece.at + reader.cursor.at;
        if !matches!(reader.line(), Ok(true)) {
            break;
        }
    }
    let problem = format!(
        "names a vertex that is not there (there are {vertices} in the file, {} before this line): mend or remove the face",
        start + reader.part.points.len()
    );
    Stop::fault(at, problem)
}

/// Reads a piece.
fn part(piece: &Piece<'_>, triangles: &AtomicUsize, task: &Task<'_>) -> Result<Part, Stop> {
    let mut reader = Reader::new(piece, task);
    let read = (|| {
        while reader.line()? {}
        Ok(())
    })();
    read.map_err(|stop: Stop| stop.moved(piece.at))?;
    let mut part = reader.part;
    let count = part.triangles.len();
    task.check_triangles(count + triangles.fetch_add(count, Ordering::Relaxed))?;
    part.points.shrink_to_fit();
    part.triangles.shrink_to_fit();
    part.from_piece.shrink_to_fit();
    Ok(part)
}

/// Goes through a piece line by line.
struct Reader<'a> {
    cursor: Cursor<'a>,
    task: &'a Task<'a>,
    part: Part,
    steps: usize,
}

impl<'a> Reader<'a> {
    fn new(piece: &Piece<'a>, task: &'a Task<'a>) -> Self {
        Self {
            cursor: Cursor::new(piece.text, 0),
            task,
            part: Part::default(),
            steps: 0,
        }
    }

    /// Counts a line or a corner.
    #[inline]
    fn step(&mut self) -> Result<(), Stop> {
        self.steps += 1;
        if self.steps.is_multiple_of(STEPS) {
            self.task.go_on()?;
            self.task.check_triangles(self.part.triangles.len())?;
        }
        Ok(())
    }

    /// Reads a line, and says whether there was one.
    fn line(&mut self) -> Result<bool, Stop> {
        self.step()?;
        self.cursor.skip_space();
        let Some(byte) = self.cursor.peek() else {
            return Ok(false);
        };
        let at = self.cursor.at;
        let next = self.cursor.bytes.get(at + 1);
        let is_word = next.is_none_or(|byte| byte.is_ascii_whitespace() || *byte == b'\\');
        self.cursor.at += 1;
        match byte {
            b'v' if is_word => self.vertex()?,
            b'f' if is_word => self.face()?,
            byte if byte.is_ascii_control() => {
                let problem =
                    "begins with a byte that no text has: the file is damaged, save it again";
                return Err(Stop::fault(at, problem));
            }
            _ => {}
        }
        self.cursor.skip_line();
        Ok(true)
    }

    /// Passes blanks, and ends of lines after a backslash.
    #[inline]
    fn skip_blanks(&mut self) {
        loop {
            self.cursor.skip_blanks();
            let rest = self.cursor.bytes.get(self.cursor.at..).unwrap_or_default();
            match rest {
                [b'\\', b'\n', ..] => self.cursor.at += 2,
                [b'\\', b'\r', b'\n', ..] => self.cursor.at += 3,
                _ => return,
            }
        }
    }

    /// Reads three coordinates; a weight or colours after them are passed over.
    fn vertex(&mut self) -> Result<(), Stop> {
        let mut point = [0.0; 3];
        for coordinate in &mut point {
            self.skip_blanks();
            let at = self.cursor.at;
            let Some(value) = self.number() else {
                let problem = format!(
                    "has {} where a coordinate stands: a vertex has three numbers",
                    self.cursor.shown()
                );
                return Err(Stop::fault(at, problem));
            };
            if !is_coordinate(value) {
                return Err(no_coordinate(at, value));
            }
            *coordinate = value;
        }
        self.part.points.push(point);
        self.finish_line()
    }

    /// The number that stands here, a backslash may end it.
    #[inline]
    fn number(&mut self) -> Option<f64> {
        self.cursor.number().or_else(|| {
            let rest = self.cursor.bytes.get(self.cursor.at..)?;
            let end = rest.iter().take(64).position(|&byte| byte == b'\\')?;
            let value = Cursor::new(&rest[..end], 0).number()?;
            self.cursor.at += end;
            Some(value)
        })
    }

    /// Reads a polygon and cuts it into triangles from its first vertex.
    fn face(&mut self) -> Result<(), Stop> {
        let mut first = Corner::default();
        let mut last = Corner::default();
        for count in 0_usize.. {
            self.step()?;
            self.skip_blanks();
            if matches!(self.cursor.peek(), None | Some(b'\n' | b'#')) {
                self.part.skipped += usize::from(count < 3);
                return Ok(());
            }
            let corner = self.corner()?;
            match count {
                0 => first = corner,
                1 => {}
                _ => self.part.add([first, last, corner]),
            }
            last = corner;
        }
        Ok(())
    }

    /// Reads `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    #[inline]
    fn corner(&mut self) -> Result<Corner, Stop> {
        let at = self.cursor.at;
        let number = self.cursor.integer();
        while matches!(self.cursor.peek(), Some(b'/' | b'-' | b'0'..=b'9')) {
            self.cursor.at += 1;
        }
        let ends = matches!(self.cursor.peek(), None | Some(b'\\'))
            || self
                .cursor
                .peek()
                .is_some_and(|byte| byte.is_ascii_whitespace());
        let number = number.filter(|&number| ends && number != 0);
        let corner = number.and_then(|number| self.numbered(number));
        corner.ok_or_else(|| {
            let problem = format!(
                "has {} as a face's corner: it is v, v/vt, v//vn or v/vt/vn, whole numbers from 1 on, or from −1 back",
                Cursor::new(self.cursor.bytes, at).shown()
            );
            Stop::fault(at, problem)
        })
    }

    /// A vertex counted from 1, or back from the last one.
    #[inline]
    fn numbered(&self, number: i64) -> Option<Corner> {
        let is_from_piece = number < 0;
        let number = if is_from_piece {
            number + i64::try_from(self.part.points.len()).ok()?
        } else {
            number - 1
        };
        Some(Corner {
            number: i32::try_from(number).ok()?,
            is_from_piece,
        })
    }

    /// Passes what is left of a line, and the lines that continue it.
    #[inline]
    fn finish_line(&mut self) -> Result<(), Stop> {
        loop {
            self.step()?;
            let from = self.cursor.at;
            self.cursor.skip_line();
            let line = self.cursor.bytes.get(from..self.cursor.at);
            if !line.is_some_and(is_continued) {
                // Before the line's end again: whoever reads lines passes it.
                self.cursor.at -= usize::from(line.is_some_and(|line| line.ends_with(b"\n")));
                return Ok(());
            }
        }
    }
}
