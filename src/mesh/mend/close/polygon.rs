//! A loop in space cut into triangles without new vertices.
//!
//! In its plane, by ears, where it is nearly flat and does not cross itself there. Else by least area: for each two vertices of the loop the
//! best triangle over the chord between them, shorter chords first (Barequet and Sharir 1995, as in Liepa 2003 section 2), in a time that grows
//! with the cube of the number of vertices; longer loops are first halved along short chords.

use earcut::Earcut;
use glam::{DVec2, DVec3};

use crate::mesh::mend::surface::Surface;
use crate::mesh::mend::{MendError, Work};
use crate::mesh::report::Face;

/// Vertices of a loop that ears are clipped of: the time may grow with the square.
const EARS_MOST: usize = 20_000;

/// How far from its plane a loop may be, as a part of its width, to be closed in it.
const FLAT: f64 = 0.1;

/// Vertices of a loop whose least area is looked for.
const LEAST_MOST: usize = 240;

/// Vertices from which chords that halve a longer loop are tried.
const TRIED: usize = 128;

/// How a loop was closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut {
    /// By ears, in its plane.
    Ears,
    /// By triangles of least area.
    LeastArea,
    /// It is to be closed by a fan around its centre.
    Fan,
}

/// Triangles that close a loop, in its direction.
pub(super) fn triangles(
    surface: &Surface,
    around: &[u32],
    work: &mut Work,
) -> Result<(Cut, Vec<Face>), MendError> {
    if let Some(faces) = ears(surface, around).filter(|faces| are_new(surface, around, faces)) {
        return Ok((Cut::Ears, faces));
    }
    let faces = least_area(surface, around, work)?;
    let whole = faces.filter(|faces| are_new(surface, around, faces));
    Ok(match whole {
        Some(faces) => (Cut::LeastArea, faces),
        None => (Cut::Fan, Vec::new()),
    })
}

/// Whether all their edges but those of the loop are none yet.
fn are_new(surface: &Surface, around: &[u32], faces: &[Face]) -> bool {
    let mut loops: Vec<[u32; 2]> = around
        .iter()
        .zip(around.iter().cycle().skip(1))
        .map(|(from, to)| [*from.min(to), *from.max(to)])
        .collect();
    loops.sort_unstable();
    let edges = faces
        .iter()
        .flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
    let mut chords = edges.filter(|[a, b]| loops.binary_search(&[*a.min(b), *a.max(b)]).is_err());
    chords.all(|chord| !surface.is_edge(chord))
}

/// Newell's normal: its length is twice the area in the plane.
fn newell(points: &[DVec3]) -> DVec3 {
    let first = points.first().copied().unwrap_or_default();
    let pairs = points.windows(2);
    pairs
        .map(|pair| (pair[0] - first).cross(pair[1] - first))
        .sum()
}

fn ears(surface: &Surface, around: &[u32]) -> Option<Vec<Face>> {
    if around.len() > EARS_MOST {
        return None;
    }
    let points: Vec<DVec3> = around
        .iter()
        .map(|vertex| surface.points[*vertex as usize])
        .collect();
    let doubled = newell(&points);
    let normal = doubled.try_normalize()?;
    let centre: DVec3 = points.iter().sum::<DVec3>() / points.len() as f64;
    let off = points
        .iter()
        .map(|point| (*point - centre).dot(normal).abs())
        .fold(0.0, f64::max);
    // As wide as a square of the same area.
    let width = (doubled.length() / 2.0).sqrt();
    if off > FLAT * width {
        return None;
    }
    let (right, up) = normal.any_orthonormal_pair();
    let up = up * right.cross(up).dot(normal).signum();
    let flat: Vec<[f64; 2]> = points
        .iter()
        .map(|point| {
            let from = *point - centre;
            DVec2::new(from.dot(right), from.dot(up)).to_array()
        })
        .collect();
    let mut indices: Vec<u32> = Vec::new();
    Earcut::new().earcut_slice(&flat, &[], &mut indices);
    let place = |at: u32| flat.get(at as usize).copied().map(DVec2::from);
    let mut covered = 0.0;
    let mut faces = Vec::with_capacity(around.len());
    for ear in indices.chunks_exact(3) {
        let [a, b, c] = [place(ear[0])?, place(ear[1])?, place(ear[2])?];
        let area = (b - a).perp_dot(c - a);
        covered += area.abs();
        let face = [ear[0], ear[1], ear[2]].map(|at| around.get(at as usize).copied());
        let [Some(a), Some(b), Some(c)] = face else {
            return None;
        };
        faces.push(if area < 0.0 { [a, c, b] } else { [a, b, c] });
    }
    // All of the polygon once, by all its vertices: it is simple.
    let whole = (covered - doubled.length()).abs() <= 1e-6 * doubled.length();
    (whole && faces.len() + 2 == around.len()).then_some(faces)
}

/// Triangles of least area that make no edge that is there; None where there are none.
fn least_area(
    surface: &Surface,
    around: &[u32],
    work: &mut Work,
) -> Result<Option<Vec<Face>>, MendError> {
    let mut faces = Vec::with_capacity(around.len());
    let mut open = vec![around.to_vec()];
    while let Some(part) = open.pop() {
        work.go_on()?;
        if part.len() <= LEAST_MOST {
            match table(surface, &part, work)? {
                Some(found) => faces.extend(found),
                None => return Ok(None),
            }
            continue;
        }
        let Some((from, to)) = short_chord(surface, &part) else {
            return Ok(None);
        };
        let inner = part[from..=to].to_vec();
        let outer = part[to..].iter().chain(&part[..=from]).copied();
        open.push(outer.collect());
        open.push(inner);
    }
    Ok(Some(faces))
}

/// A short chord that leaves a quarter of the loop at least on each side.
fn short_chord(surface: &Surface, around: &[u32]) -> Option<(usize, usize)> {
    let len = around.len();
    let point = |at: usize| surface.points[around[at] as usize];
    let starts = (0..len / 2).step_by((len / 2).div_ceil(TRIED));
    let chords = starts.flat_map(|from| {
        let ends = from + len / 4..(from + len - len / 4).min(len);
        ends.map(move |to| (point(from).distance_squared(point(to)), from, to))
    });
    let mut chords: Vec<_> = chords.collect();
    chords.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    chords
        .into_iter()
        .find(|(_, from, to)| !surface.is_edge([around[*from], around[*to]]))
        .map(|(_, from, to)| (from, to))
}

fn table(surface: &Surface, part: &[u32], work: &Work) -> Result<Option<Vec<Face>>, MendError> {
    let len = part.len();
    let points: Vec<DVec3> = part
        .iter()
        .map(|vertex| surface.points[*vertex as usize])
        .collect();
    let is_side = |from: usize, to: usize| to == from + 1 || (from == 0 && to == len - 1);
    // Twice the least area over each chord, and the vertex of the triangle on it.
    let mut best = vec![(0.0_f64, 0_usize); len * len];
    for span in 2..len {
        work.go_on()?;
        for from in 0..len - span {
            let to = from + span;
            let barred = !is_side(from, to) && surface.is_edge([part[from], part[to]]);
            let mut least = (f64::INFINITY, 0);
            for middle in (from + 1..to).filter(|_| !barred) {
                let (a, b, c) = (points[from], points[middle], points[to]);
                let area = best[from * len + middle].0
                    + best[middle * len + to].0
                    + (b - a).cross(c - a).length();
                if area < least.0 {
                    least = (area, middle);
                }
            }
            best[from * len + to] = least;
        }
    }
    if len < 3 || !best[len - 1].0.is_finite() {
        return Ok(None);
    }
    let mut faces = Vec::with_capacity(len);
    let mut open = vec![(0, len - 1)];
    while let Some((from, to)) = open.pop() {
        if to - from < 2 {
            continue;
        }
        let (_, middle) = best[from * len + to];
        faces.push([part[from], part[middle], part[to]]);
        open.extend([(from, middle), (middle, to)]);
    }
    Ok(Some(faces))
}
