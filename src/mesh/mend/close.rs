//! Open ends closed: each boundary loop gets a cap, and all vertices that are there stay where they are.
//!
//! ```text
//! loop ─▶ flat enough: ears clipped in its plane ─┐
//!      └▶ else: triangles of least area ──────────┼─▶ flat: done
//!             └▶ else: a fan around the centre ───┘   smooth: refined, faired
//! ```
//!
//! A cap never makes an edge that is there already, since that would have more than two triangles then; where a polygon cannot be cut
//! without such an edge a fan around a new vertex closes it. Smooth caps are after Liepa, *Filling holes in meshes* (SGP 2003).
//!
//! Lines that non-manifold edges interrupt are no loops and stay open.

mod fair;
mod polygon;
mod refine;

use glam::DVec3;

use self::polygon::Cut;
use super::surface::Surface;
use super::{Cap, Close, MendError, Work};
use crate::mesh::Mesh;
use crate::mesh::problem::grouped;
use crate::mesh::report::BoundaryLoop;

/// Vertices that smooth caps add in one mend at most.
const ADDED_MOST: usize = 2_000_000;

/// How often a smooth cap is refined and faired: a dome has more area than what it was made of, and bends as the surface around only if
/// its triangles are as large as those there.
const DOMES: usize = 3;

pub(super) fn close(mesh: Mesh, close: &Close, work: &mut Work) -> Result<Mesh, MendError> {
    let report = work.report(&mesh)?;
    let longest = close.longest.map_or(f64::INFINITY, |most| most.of(&mesh));
    let mut closer = Closer {
        surface: Surface::new(&mesh),
        cuts: [0; 3],
        added: 0,
        unrefined: 0,
    };
    let (mut open, mut long, mut alone) = (0, 0, 0);
    let all = report.boundary_loops.len();
    for (at, end) in report.boundary_loops.iter().enumerate() {
        work.step(at, all)?;
        match end {
            BoundaryLoop { closed: false, .. } => open += 1,
            end if end.length > longest => long += 1,
            end => {
                let vertices = &report.loop_vertices[end.vertices.clone()];
                alone += usize::from(!closer.close(vertices, close.cap, work)?);
            }
        }
    }
    closer.tell(close.cap, work);
    work.remark(
        long,
        "loop longer than asked for left open",
        "loops longer than asked for left open",
    );
    work.remark(
        open,
        "line interrupted by non-manifold edges left open",
        "lines interrupted by non-manifold edges left open",
    );
    work.remark(
        alone,
        "triangle that is alone left open",
        "triangles that are alone left open",
    );
    Ok(closer.surface.into_mesh())
}

struct Closer {
    surface: Surface,
    /// Loops closed by ears, by least area and by a fan.
    cuts: [usize; 3],
    /// Vertices that were added.
    added: usize,
    /// Caps that are coarser than they should be.
    unrefined: usize,
}

impl Closer {
    /// Closes a loop; false where there is nothing to be closed, since the loop is a triangle that is there.
    fn close(&mut self, end: &[u32], cap: Cap, work: &mut Work) -> Result<bool, MendError> {
        // Against the direction of the triangles along it.
        let mut around: Vec<u32> = end.to_vec();
        if self.runs_along(end) {
            around.reverse();
        }
        if let [a, b, c] = around[..] {
            let there = self
                .surface
                .at_edge([a, b])
                .any(|triangle| self.surface.faces[triangle as usize].contains(&c));
            if there {
                return Ok(false);
            }
        }
        let densities = match cap {
            Cap::Flat => Vec::new(),
            Cap::Smooth => refine::densities(&self.surface, &around),
        };
        let first = self.surface.faces.len();
        let (cut, faces) = polygon::triangles(&self.surface, &around, work)?;
        self.cuts[cut as usize] += 1;
        match cut {
            Cut::Fan => self.fan(&around),
            Cut::Ears | Cut::LeastArea => faces.into_iter().for_each(|face| {
                self.surface.add(face);
            }),
        }
        if cap == Cap::Smooth {
            let before = self.surface.points.len();
            let start = before - usize::from(cut == Cut::Fan);
            let mut done = true;
            for _ in 0..DOMES {
                let room = ADDED_MOST
                    .saturating_sub(self.added)
                    .saturating_sub(self.surface.points.len() - before);
                done = refine::refine(
                    &mut self.surface,
                    &around,
                    &densities,
                    first,
                    start,
                    room,
                    work,
                )?;
                fair::fair(&mut self.surface, &around, start, work)?;
            }
            self.unrefined += usize::from(!done);
            self.added += self.surface.points.len() - before;
        }
        Ok(true)
    }

    /// Whether most triangles along a loop run in its direction.
    fn runs_along(&self, end: &[u32]) -> bool {
        let next = end.iter().cycle().skip(1);
        let along = end.iter().zip(next).filter(|(from, to)| {
            let triangle = self.surface.at_edge([**from, **to]).next();
            triangle.is_some_and(|triangle| {
                let face = self.surface.faces[triangle as usize];
                (0..3).any(|at| face[at] == **from && face[(at + 1) % 3] == **to)
            })
        });
        2 * along.count() >= end.len()
    }

    fn fan(&mut self, around: &[u32]) {
        let sum: DVec3 = around
            .iter()
            .map(|vertex| self.surface.points[*vertex as usize])
            .sum();
        let centre = sum / around.len().max(1) as f64;
        let centre = self.surface.add_vertex(centre.as_vec3().as_dvec3());
        let next = around.iter().cycle().skip(1);
        for (from, to) in around.iter().zip(next) {
            self.surface.add([*from, *to, centre]);
        }
    }

    fn tell(&self, cap: Cap, work: &mut Work) {
        let [ears, least, fans] = self.cuts;
        let all = ears + least + fans;
        if all == 0 {
            return;
        }
        let how = match cap {
            Cap::Flat => format!("{ears} flat, {least} by least area, {fans} by a fan"),
            Cap::Smooth => format!("smoothly, with {} new vertices", grouped(self.added + fans)),
        };
        work.remark(
            all,
            &format!("open end closed ({how})"),
            &format!("open ends closed ({how})"),
        );
        work.remark(
            self.unrefined,
            "cap left coarse, since it would need too many vertices",
            "caps left coarse, since they would need too many vertices",
        );
    }
}
