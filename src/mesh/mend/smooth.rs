//! Noise taken off without shrinking: Taubin's λ|μ filter (*A signal processing approach to fair surface design*, SIGGRAPH 1995, section 3).
//!
//! Each pass moves vertices towards the mean of their neighbours and then, by a little more, away from it: detail as fine as the edges
//! dies out, while what is coarser than about twenty edges keeps its size. All neighbours weigh the same, as in the paper: weights by
//! angles keep the parametrisation, but are without bound at the needles that scans have. Ends of edges with one triangle stay where they are,
//! and those of non-manifold edges too.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{MendError, Smooth, Work};
use crate::mesh::Mesh;
use crate::mesh::report::NONE;
use crate::mesh::report::edges::{Edges, from_to};

/// Towards the mean.
const LAMBDA: f64 = 0.5;

/// Away from it: 1/λ + 1/μ = 0.1 is the frequency that stays, as the paper advises.
const MU: f64 = -0.526_315_789;

/// Vertices of one piece of work.
const CHUNK: usize = 1 << 12;

pub(super) fn smooth(mut mesh: Mesh, smooth: &Smooth, work: &mut Work) -> Result<Mesh, MendError> {
    let rings = Rings::new(&mesh);
    let before: Vec<Vec3> = mesh.positions.clone();
    let mut points: Vec<DVec3> = mesh.positions.iter().map(|p| p.as_dvec3()).collect();
    let mut moved = points.clone();
    let passes = smooth.passes.clamp(1, Smooth::PASSES_MOST) as usize;
    for pass in 0..passes {
        work.step(pass, passes)?;
        for factor in [LAMBDA, MU] {
            rings.pass(&points, factor, &mut moved);
            std::mem::swap(&mut points, &mut moved);
            work.go_on()?;
        }
    }
    mesh.positions = points.into_iter().map(DVec3::as_vec3).collect();
    let moves = before
        .iter()
        .zip(&mesh.positions)
        .map(|(before, after)| before.as_dvec3().distance(after.as_dvec3()));
    let (sum, most) = moves.fold((0.0, 0.0_f64), |(sum, most), by| (sum + by, most.max(by)));
    let mean = sum / before.len().max(1) as f64;
    work.say(format!(
        "vertices moved by {mean:.3} on average and by {most:.3} at most"
    ));
    work.remark(
        rings.still.iter().filter(|still| **still).count(),
        "vertex of the boundary or of non-manifold edges left where it was",
        "vertices of the boundary or of non-manifold edges left where they were",
    );
    Ok(mesh)
}

/// Neighbours of each vertex.
struct Rings {
    /// Where the neighbours of each vertex begin, and the end of the last.
    starts: Vec<u32>,
    neighbours: Vec<u32>,
    /// Vertices that do not move.
    still: Vec<bool>,
}

impl Rings {
    fn new(mesh: &Mesh) -> Self {
        let faces = &mesh.triangles;
        let kinds = Edges::new(faces, mesh.positions.len()).kinds();
        let mut still = vec![false; mesh.positions.len()];
        let non_manifold = kinds.non_manifold.iter().map(|(half_edge, _)| half_edge);
        for half_edge in kinds.boundary.iter().chain(non_manifold) {
            for vertex in from_to(faces, *half_edge) {
                still[vertex as usize] = true;
            }
        }
        // Vertices that move have edges with two triangles only, and each edge is told by one of its half-edges.
        let edges = || {
            let twins = (0_u32..).zip(&kinds.twins);
            twins
                .filter(|(half_edge, twin)| **twin != NONE && half_edge < *twin)
                .map(|(half_edge, _)| from_to(faces, half_edge))
        };
        let mut starts = vec![0_u32; mesh.positions.len() + 1];
        for vertex in edges().flatten() {
            starts[vertex as usize] += 1;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut neighbours = vec![0_u32; sum as usize];
        for [a, b] in edges() {
            for (vertex, neighbour) in [(a, b), (b, a)] {
                let place = &mut starts[vertex as usize];
                *place -= 1;
                neighbours[*place as usize] = neighbour;
            }
        }
        Self {
            starts,
            neighbours,
            still,
        }
    }

    /// Moves each vertex towards the mean of its neighbours.
    fn pass(&self, points: &[DVec3], factor: f64, into: &mut [DVec3]) {
        let chunks = into.par_chunks_mut(CHUNK).enumerate();
        chunks.for_each(|(chunk, into)| {
            for (at, into) in into.iter_mut().enumerate() {
                let vertex = chunk * CHUNK + at;
                let range = self.starts[vertex] as usize..self.starts[vertex + 1] as usize;
                let point = points[vertex];
                let count = range.len();
                *into = match self.still[vertex] || count == 0 {
                    true => point,
                    false => {
                        let ring = self.neighbours[range].iter();
                        let sum: DVec3 = ring.map(|other| points[*other as usize]).sum();
                        point + factor * (sum / count as f64 - point)
                    }
                };
            }
        });
    }
}
