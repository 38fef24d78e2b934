//! Scanned models: triangles in space, read from other programs' files, checked and told about.

pub mod colour;
pub mod display;
pub mod endpoints;
mod error;
pub mod field;
pub mod intersect;
pub mod levels;
pub mod line;
#[cfg(test)]
pub(crate) mod made;
pub mod measure;
pub mod mend;
pub mod paint;
pub mod pick;
pub mod problem;
mod read;
pub mod report;
pub mod srgb;
pub mod surface;
pub mod textured;
#[cfg(test)]
pub(crate) mod truth;
pub mod unit;
pub mod write;

pub use error::{MeshError, Place};
pub use read::{Format, Model, ReadLimits, read, read_bytes};

use glam::{DVec3, Vec3};

/// Triangles in space, as a file has them: nothing is turned or left out, and nothing joined but the corners of STL files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Where coordinates are counted from, in the file's unit: scans stand far from zero, where single precision would round them
    /// to a grid that is seen.
    pub origin: DVec3,
    /// Vertices, from `origin`.
    pub positions: Vec<Vec3>,
    /// Three vertices each, by number, counter-clockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
}
