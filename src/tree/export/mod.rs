//! Trees as files: GLB and OBJ hold the tubes' surface, SWC the nodes and radii.
//!
//! The same tree and parameters give the same bytes on every machine and at any time: nothing here reads a clock, hashes
//! by address or depends on threads. Writing to disk is [`super::file`]'s business.

mod glb;
mod obj;
mod swc;

pub use glb::glb;
pub use obj::obj;
pub use swc::swc;

use super::mesh::{SIDES, TubeMesh, mesh, vertices_per_segment};
use super::{Tree, TreeError, tubes};

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

/// The tubes of a whole tree, or why they cannot be written; `vertex_bytes` is what one vertex takes at most.
fn surface(
    tree: &Tree,
    params: &ExportParams,
    format: &'static str,
    vertex_bytes: u64,
) -> Result<TubeMesh, TreeError> {
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
    let mut records = Vec::new();
    // Growth 1 is the whole tree whatever was newest.
    tubes::segments(tree, &[], u32::MAX, &mut records);
    let mesh = mesh(&records, 1.0, sides);
    if mesh
        .positions
        .as_flattened()
        .iter()
        .all(|coordinate| coordinate.is_finite())
    {
        Ok(mesh)
    } else {
        Err(TreeError::TooWide)
    }
}
