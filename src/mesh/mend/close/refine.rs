//! A cap's triangles made as large as those around (Liepa 2003 section 3, after Pfeifle and Seidel 1996).
//!
//! Each vertex has a density, the mean length of the edges that it had before it was closed; a triangle whose middle is farther from its
//! corners than their densities and its own gets a vertex there with the mean of their densities. Then edges are flipped until each is the shorter
//! way across, which keeps triangles round, and the whole again until nothing is too large.

use std::collections::BTreeSet;

use glam::DVec3;

use crate::mesh::mend::surface::Surface;
use crate::mesh::mend::{MendError, Work, cross};
use crate::mesh::report::NONE;

/// Vertices that a cap is made for; where it would have more it is made of larger triangles.
const WANTED: f64 = 10_000.0;

/// Rounds of dividing; each takes a third of the area of all that is too large.
const ROUNDS: usize = 64;

/// Rounds of flipping between two of dividing.
const FLIPS: usize = 16;

/// Triangles between two looks at whether to go on.
const BLOCK: usize = 1 << 10;

/// The mean length of edges at each vertex.
pub(super) fn densities(surface: &Surface, around: &[u32]) -> Vec<f64> {
    let mut ring = Vec::new();
    around
        .iter()
        .map(|vertex| {
            surface.ring(*vertex, &mut ring);
            let sum: f64 = ring
                .iter()
                .map(|(other, _)| surface.length([*vertex, *other]))
                .sum();
            sum / ring.len().max(1) as f64
        })
        .collect()
}

/// Refines the cap of a loop: triangles from `first` on, with vertices from `start` on inside. False where it stays too coarse, since
/// there is room for so many vertices only.
pub(super) fn refine(
    surface: &mut Surface,
    around: &[u32],
    densities: &[f64],
    first: usize,
    start: usize,
    room: usize,
    work: &Work,
) -> Result<bool, MendError> {
    let mut outer: Vec<(u32, f64)> = around
        .iter()
        .copied()
        .zip(densities.iter().copied())
        .collect();
    outer.sort_unstable_by_key(|(vertex, _)| *vertex);
    let mean = densities.iter().sum::<f64>() / densities.len().max(1) as f64;
    let scale = coarseness(surface, first, mean);
    outer.iter_mut().for_each(|(_, density)| *density *= scale);
    let mean = mean * scale;
    let mut cap = CapMesh {
        surface,
        outer,
        inner: Vec::new(),
        first,
        start,
    };
    cap.inner = vec![mean; cap.surface.points.len() - start];
    let before = cap.inner.len();
    cap.relax(work)?;
    for _ in 0..ROUNDS {
        let wanted = cap.too_large(work)?;
        if wanted.is_empty() {
            return Ok(true);
        }
        if cap.inner.len() - before + wanted.len() > room {
            return Ok(false);
        }
        for (triangle, point, density) in wanted {
            cap.surface.split_triangle(triangle, point);
            cap.inner.push(density);
        }
        cap.relax(work)?;
    }
    Ok(true)
}

/// How many times as long as around edges have to be, so that there are not too many.
fn coarseness(surface: &Surface, first: usize, density: f64) -> f64 {
    let faces = surface.faces[first..].iter().filter(|face| face[0] != NONE);
    let area: f64 = faces
        .map(|face| cross(surface.corners(*face)).length() / 2.0)
        .sum();
    // A vertex has two equilateral triangles.
    let vertices = area / (0.75_f64.sqrt() * density * density);
    (vertices / WANTED).sqrt().max(1.0)
}

struct CapMesh<'a> {
    surface: &'a mut Surface,
    /// Densities of the loop's vertices, sorted by vertex.
    outer: Vec<(u32, f64)>,
    /// Densities of the vertices inside.
    inner: Vec<f64>,
    first: usize,
    start: usize,
}

impl CapMesh<'_> {
    fn density(&self, vertex: u32) -> f64 {
        match (vertex as usize).checked_sub(self.start) {
            Some(inner) => self.inner.get(inner).copied().unwrap_or(0.0),
            None => {
                let found = self.outer.binary_search_by_key(&vertex, |(one, _)| *one);
                found.map_or(0.0, |at| self.outer[at].1)
            }
        }
    }

    fn triangles(&self) -> impl Iterator<Item = u32> + use<> {
        let range = self.first..self.surface.faces.len();
        range.filter_map(|triangle| u32::try_from(triangle).ok())
    }

    /// Triangles to divide, with their middles and the densities there.
    fn too_large(&self, work: &Work) -> Result<Vec<(u32, DVec3, f64)>, MendError> {
        let mut found = Vec::new();
        for (at, triangle) in self.triangles().enumerate() {
            if at % BLOCK == 0 {
                work.go_on()?;
            }
            let face = self.surface.faces[triangle as usize];
            if face[0] == NONE {
                continue;
            }
            let corners = self.surface.corners(face);
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            let densities = face.map(|vertex| self.density(vertex));
            let density = densities.iter().sum::<f64>() / 3.0;
            let far = corners.iter().zip(densities).all(|(corner, of_corner)| {
                let scaled = std::f64::consts::SQRT_2 * middle.distance(*corner);
                scaled > density && scaled > of_corner
            });
            if far && density > 0.0 {
                found.push((triangle, middle.as_vec3().as_dvec3(), density));
            }
        }
        Ok(found)
    }

    /// Flips edges of the cap until each is seen under angles of less than a half turn together, as Delaunay has it.
    fn relax(&mut self, work: &Work) -> Result<(), MendError> {
        let mut edges = BTreeSet::new();
        for triangle in self.triangles() {
            let [a, b, c] = self.surface.faces[triangle as usize];
            if a != NONE {
                let pairs = [[a, b], [b, c], [c, a]];
                edges.extend(pairs.map(|[a, b]| [a.min(b), a.max(b)]));
            }
        }
        for _ in 0..FLIPS {
            let mut again = BTreeSet::new();
            for (at, edge) in std::mem::take(&mut edges).into_iter().enumerate() {
                if at % BLOCK == 0 {
                    work.go_on()?;
                }
                if !self.is_inside(edge) {
                    continue;
                }
                let Some(flip) = self.surface.across(edge) else {
                    continue;
                };
                if !is_wide(self.surface, flip.edge, flip.apexes) {
                    continue;
                }
                self.surface.flip(&flip);
                let ([a, b], [c, d]) = (flip.edge, flip.apexes);
                let sides = [[a, c], [c, b], [b, d], [d, a]];
                again.extend(sides.map(|[a, b]| [a.min(b), a.max(b)]));
            }
            if again.is_empty() {
                break;
            }
            edges = again;
        }
        Ok(())
    }

    /// Both its triangles are of the cap.
    fn is_inside(&self, edge: [u32; 2]) -> bool {
        self.surface
            .at_edge(edge)
            .all(|triangle| triangle as usize >= self.first)
    }
}

/// Whether the angles across an edge are more than a half turn together, in the triangles unfolded, and less the other way.
fn is_wide(surface: &Surface, [a, b]: [u32; 2], [c, d]: [u32; 2]) -> bool {
    let [a, b, c, d] = [a, b, c, d].map(|vertex| surface.points[vertex as usize]);
    let angle = |at: DVec3, one: DVec3, other: DVec3| {
        let (one, other) = (one - at, other - at);
        one.cross(other).length().atan2(one.dot(other))
    };
    let now = angle(c, a, b) + angle(d, a, b);
    let then = angle(a, c, d) + angle(b, c, d);
    now > std::f64::consts::PI + 1e-9 && then < now
}
