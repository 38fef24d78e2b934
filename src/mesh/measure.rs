//! What is measured between and at places of a surface: distances, angles, thickness, and the section of the tube that a place is on.
//!
//! Coordinates are those of [`super::Mesh::positions`]; lengths are in the file's unit. What looks inwards takes it that triangles show their
//! fronts to the outside, as a mesh is once it is oriented.

mod axis;
mod ball;
mod section;
mod thickness;

use glam::Vec3;

pub use self::ball::{Ball, inscribed};
pub use self::section::{Section, section};
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
