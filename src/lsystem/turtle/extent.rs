//! The canvas that keeps nothing: how many segments there are, and where.

use glam::{DVec3, Vec3};

use super::super::error::DeriveError;
use super::canvas::{Canvas, Drawn, narrowed};
use super::pen::Pen;

/// Number and bounds of what is drawn, at constant memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    /// Segments drawn.
    pub segments: u64,
    /// Least and greatest coordinates of the ends of all segments, metres; none where there is no segment.
    pub bounds: Option<[Vec3; 2]>,
}

impl Extent {
    #[inline]
    fn add(&mut self, at: Vec3) {
        let [min, max] = self.bounds.unwrap_or([at, at]);
        self.bounds = Some([min.min(at), max.max(at)]);
    }
}

impl Canvas for Extent {
    fn root(&mut self, _: &Pen, _: Drawn, _: f32) -> Result<u32, DeriveError> {
        Ok(0)
    }

    #[inline]
    fn segment(&mut self, pen: &Pen, _: Drawn, end: DVec3, _: f32) -> Result<u32, DeriveError> {
        self.segments += 1;
        self.add(narrowed(pen.position));
        self.add(narrowed(end));
        Ok(0)
    }
}
