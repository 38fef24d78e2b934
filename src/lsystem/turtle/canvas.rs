//! What the turtle draws on.

use glam::{DVec3, Vec3};

use super::super::error::DeriveError;
use super::super::names::Symbol;
use super::pen::Pen;

/// The module that draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drawn {
    /// Its symbol; `Grammar::name` gives the name.
    pub symbol: Symbol,
    /// The step in which it appeared.
    pub birth: u32,
    /// Its index in the string that is shown.
    pub position: u64,
}

/// The outline of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline<'a> {
    /// At least three; none equals the one before it, the last not the first. Metres.
    pub vertices: &'a [DVec3],
    /// The node at which the turtle stood when the outline began; `NO_PARENT` after a move.
    pub node: u32,
}

/// What the turtle draws on. Positions come in f64 and fit f32; so do radii and scales.
///
/// Nodes are numbered by the canvas. Node 0 is the turtle's start, which every canvas has before the first call; `Pen::node` is
/// the number that the canvas gave to where the pen stands.
pub trait Canvas {
    /// A node without a segment, where the pen stands after a move without drawing. Returns its number.
    ///
    /// # Errors
    /// What the canvas cannot hold.
    fn root(&mut self, pen: &Pen, by: Drawn, radius: f32) -> Result<u32, DeriveError>;

    /// A segment from the pen, whose node is known, to `end`; `radius` at the end in metres. Returns the number of the node at
    /// its end.
    ///
    /// # Errors
    /// What the canvas cannot hold.
    fn segment(
        &mut self,
        pen: &Pen,
        by: Drawn,
        end: DVec3,
        radius: f32,
    ) -> Result<u32, DeriveError>;

    /// A polygon, `{` to `}`; the pen and the module are those of the `}`.
    ///
    /// # Errors
    /// What the canvas cannot hold.
    fn polygon(&mut self, _pen: &Pen, _by: Drawn, _: Outline<'_>) -> Result<(), DeriveError> {
        Ok(())
    }

    /// A sphere round the pen, `@O`; its radius is in metres.
    ///
    /// # Errors
    /// What the canvas cannot hold.
    fn sphere(&mut self, _pen: &Pen, _by: Drawn, _radius: f64) -> Result<(), DeriveError> {
        Ok(())
    }

    /// A query module, `?P ?H ?U ?L ?S ?C`.
    ///
    /// # Errors
    /// What the canvas cannot answer.
    fn query(&mut self, _pen: &Pen, _by: Drawn) -> Result<(), DeriveError> {
        Ok(())
    }

    /// What the name behind the `~` of the module's name names, in the pen's frame and so many times as large.
    ///
    /// # Errors
    /// What the canvas cannot hold.
    fn surface(&mut self, _pen: &Pen, _by: Drawn, _scale: f64) -> Result<(), DeriveError> {
        Ok(())
    }
}

/// A number as trees hold it; what is beyond f32 becomes infinite.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a tree holds f32; what is beyond becomes infinite and is refused"
)]
#[inline]
pub(super) fn narrow(value: f64) -> f32 {
    value as f32
}

/// A position as trees hold it.
#[inline]
pub(super) fn narrowed(position: DVec3) -> Vec3 {
    Vec3::new(narrow(position.x), narrow(position.y), narrow(position.z))
}
