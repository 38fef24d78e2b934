//! What is measured between and at places of a surface: distances, angles, thickness, and the section of the tube that a place is on.
//!
//! Coordinates are those of [`super::Mesh::positions`]; lengths are in the file's unit. What looks inwards goes by the triangles' normals, the other
//! way where the mesh is inside out as a whole; parts that are turned against each other must be oriented first.

mod along;
mod axis;
mod ball;
mod section;
mod thickness;

use glam::Vec3;

pub use self::along::{Along, Cancelled, along};
pub(crate) use self::ball::inscribed_at;
pub use self::ball::{Ball, inscribed};
pub use self::section::{Section, section};
pub(crate) use self::thickness::diameter;
pub use self::thickness::{Thickness, thickness};

/// How far two points are from each other, straight.
pub fn distance(one: Vec3, other: Vec3) -> f64 {
    one.as_dvec3().distance(other.as_dvec3())
}

/// The angle at a point between the ways to two others, in radians; None where one of them is the point.
pub fn angle(at: Vec3, one: Vec3, other: Vec3) -> Option<f64> {
    let (one, other) = (
        one.as_dvec3() - at.as_dvec3(),
        other.as_dvec3() - at.as_dvec3(),
    );
    // By the tangent: exact also near 0 and 180 degrees, where the cosine hardly changes (Kahan).
    let angle = one.cross(other).length().atan2(one.dot(other));
    (one.length() > 0.0 && other.length() > 0.0 && angle.is_finite()).then_some(angle)
}

#[cfg(test)]
mod tests;
