//! Trees as files: GLB and OBJ hold the tubes' surface, SWC the nodes and radii.
//!
//! The same tree and parameters give the same bytes on every machine and at any time: nothing here reads a clock, hashes
//! by address or depends on threads. Writing to disk is [`super::file`]'s business.
//!
//! A surface takes about a kilobyte a segment, so it is never whole in memory: it is made in parts, once for each kind of number that a file
//! holds in a row (positions, normals …), and each part is written and forgotten. Making it four times costs less than the disk does.

mod glb;
mod obj;
mod swc;

pub use glb::{Glb, glb};
pub use obj::{Obj, obj};
pub use swc::{Swc, swc};

use std::io;

use glam::Vec3;

use super::mesh::{SIDES, TubeMesh, mesh, vertices_per_segment};
use super::tubes::{self, TubeSegment};
use super::{Tree, TreeError};

/// How tubes are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExportParams {
    /// Corners of each ring, 3 to 64.
    pub sides: u32,
}

impl Default for ExportParams {
    fn default() -> Self {
        Self { sides: 8 }
    }
}

/// Largest file that an exporter makes: lengths inside a GLB are u32.
const MOST_BYTES: u64 = u32::MAX as u64;

/// Segments whose surface is in memory at a time.
const PART: usize = 4096;

/// The tubes of a whole tree, to be made part by part.
#[derive(Debug)]
struct Surface {
    records: Vec<TubeSegment>,
    sides: u32,
    vertices: usize,
    indices: usize,
    /// Smallest and largest coordinates.
    bounds: [[f32; 3]; 2],
}

impl Surface {
    /// The tubes of a whole tree, or why they cannot be written; `vertex_bytes` is what one vertex takes at most.
    fn new(
        tree: &Tree,
        params: &ExportParams,
        format: &'static str,
        vertex_bytes: u64,
    ) -> Result<Self, TreeError> {
        tree.validate()?;
        let ExportParams { sides } = *params;
        if !SIDES.contains(&sides) {
            let [value, least, most] = [sides, *SIDES.start(), *SIDES.end()].map(f64::from);
            return Err(TreeError::Parameter {
                name: "the number of sides",
                value,
                least,
                most,
            });
        }
        let segments = tree.segment_count();
        if segments == 0 {
            return Err(TreeError::Empty(format));
        }
        let vertices = segments as u64 * vertices_per_segment(sides);
        if vertices.saturating_mul(vertex_bytes) > MOST_BYTES {
            return Err(TreeError::TooLarge {
                format,
                segments,
                sides,
            });
        }
        // Asked for once before it is needed in several pieces: those end the program where they are not given.
        let bytes = tree.len().saturating_mul(tubes::NODE_BYTES);
        if Vec::<u8>::new().try_reserve_exact(bytes).is_err() {
            return Err(TreeError::Memory(segments));
        }
        let mut records = Vec::new();
        // Growth 1 is the whole tree whatever was newest.
        tubes::segments(tree, &[], u32::MAX, &mut records);
        let mut surface = Self {
            records,
            sides,
            vertices: 0,
            indices: 0,
            bounds: [[0.0; 3]; 2],
        };
        let mut finite = true;
        let (mut vertices, mut indices) = (0, 0);
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        // What is counted is not written, so nothing can fail.
        let _ = surface.each(|mesh, _| {
            finite &= mesh.positions.as_flattened().iter().all(|x| x.is_finite());
            vertices += mesh.positions.len();
            indices += mesh.indices.len();
            let (from, to) = mesh.bounds();
            (low, high) = (low.min(from.into()), high.max(to.into()));
            Ok(())
        });
        if !finite {
            return Err(TreeError::TooWide);
        }
        surface.vertices = vertices;
        surface.indices = indices;
        surface.bounds = [low.to_array(), high.to_array()];
        Ok(surface)
    }

    /// Makes the parts one after the other; each is given with the number of vertices before it.
    fn each(&self, mut take: impl FnMut(&TubeMesh, u32) -> io::Result<()>) -> io::Result<()> {
        let mut before = 0;
        for part in self.records.chunks(PART) {
            let mesh = mesh(part, 1.0, self.sides);
            take(&mesh, before)?;
            #[allow(
                clippy::cast_possible_truncation,
                reason = "`new` refuses more vertices than fit u32"
            )]
            let vertices = mesh.positions.len() as u32;
            before += vertices;
        }
        Ok(())
    }
}
