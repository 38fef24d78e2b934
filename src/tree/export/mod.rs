//! Drawings as files: GLB, OBJ, PLY and USD hold the surface of tubes and organs with their colours, SWC the skeleton's nodes and radii.
//!
//! The same tree and parameters give the same bytes on every machine and at any time: nothing here reads a clock, hashes
//! by address or depends on threads. Writing to disk is [`super::file`]'s business.
//!
//! A surface takes about a kilobyte a segment, so a large one is never whole in memory: it is made in parts, once for each kind of number that a file
//! holds in a row (positions, normals …), and each part is written and forgotten. Small ones, of which many may be written, are made once and kept.

mod glb;
mod obj;
mod ply;
mod surface;
mod swc;
mod usd;
mod vtp;

pub use glb::{Glb, glb};
pub use obj::{Obj, obj};
pub use ply::Ply;
pub use swc::{Swc, swc};
pub use usd::Usd;
pub use vtp::Vtp;

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
