//! Scanned models: triangles in space, read from other programs' files, checked and told about.

pub mod intersect;
#[cfg(test)]
pub(crate) mod made;
pub mod problem;
pub mod report;
pub mod unit;

use glam::{DVec3, Vec3};

/// Triangles in space, as a file has them: nothing is joined, turned or left out.
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
