//! Dictionary shapes: polylines that the turtle follows segment by segment.
//!
//! Let B be the turtle's frame where the shape begins, d_i the displacements, dir(d) = d/|d|. Segment i goes along B·d_i, and
//! the frames F_i along it are rotation-minimizing: F_0 = B·q0 with q0 the smallest rotation from +Y to dir(d_0);
//! F_i is F_{i−1} turned by the smallest rotation from the direction before to this one. The turtle's frame
//! after segment i is F_i. At the wrap the shape begins again with B' = F_last·q0⁻¹ (`wrap carry`: the first repeated segment goes on
//! in the last one's direction) or with B' = B (`wrap restart`).
//!
//! All of this is known in the shape's own frame: with f_i the frames for B = 1, F_i = F_{i−1}·(f_{i−1}⁻¹·f_i), so the
//! turtle only needs to turn by a constant before each segment, keeps no B, and may be turned by other symbols on the way.

use glam::{DQuat, DVec3};

use super::error::GrammarError;
use super::expression::signed;
use super::names::Names;
use super::source::Cursor;

/// Below this, 1 + cos of the angle between two directions counts as 0: they are opposite.
const OPPOSITE: f64 = 1e-14;

/// How a shape goes on when it is used up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Wrap {
    /// The heading is carried over.
    #[default]
    Carry,
    /// The directions of the first time come again.
    Restart,
}

/// One segment of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ShapeSegment {
    /// The turtle's frame along this segment where the shape's own frame is 1: f_i.
    pub(crate) frame: DQuat,
    /// What the turtle turns by when it comes from the segment before (for the first: from the last one).
    pub(crate) turn: DQuat,
    /// Metres.
    pub(crate) length: f64,
    /// Radius at its end in metres; where there is none the turtle's width holds.
    pub(crate) radius: Option<f64>,
}

/// A dictionary entry.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shape {
    pub(crate) name: String,
    pub(crate) segments: Vec<ShapeSegment>,
}

impl Shape {
    pub(crate) fn new(name: &str, displacements: &[(DVec3, Option<f64>)]) -> Self {
        let mut segments = Vec::with_capacity(displacements.len());
        let mut frame = DQuat::IDENTITY;
        for (displacement, radius) in displacements {
            // Scaled first, so that the length neither overflows nor underflows.
            let scale = displacement.abs().max_element();
            let scaled = if scale > 0.0 {
                *displacement / scale
            } else {
                DVec3::ZERO
            };
            let before = frame;
            if scale > 0.0 {
                frame = (smallest_rotation(frame * DVec3::Y, scaled.normalize(), frame * DVec3::X)
                    * frame)
                    .normalize();
            }
            let turn = (before.inverse() * frame).normalize();
            segments.push(ShapeSegment {
                frame,
                turn,
                length: scaled.length() * scale,
                radius: *radius,
            });
        }
        Self {
            name: name.to_owned(),
            segments,
        }
    }

    /// A shape whose width is the turtle's.
    pub(crate) fn plain(name: &str, displacements: &[DVec3]) -> Self {
        let without_radii: Vec<(DVec3, Option<f64>)> =
            displacements.iter().map(|d| (*d, None)).collect();
        Self::new(name, &without_radii)
    }

    /// Sets what happens at the first segment when it follows the last one.
    pub(crate) fn set_wrap(&mut self, wrap: Wrap) {
        let last = self.segments.last().map_or(DQuat::IDENTITY, |s| s.frame);
        if let Some(first) = self.segments.first_mut() {
            first.turn = match wrap {
                Wrap::Carry => DQuat::IDENTITY,
                Wrap::Restart => (last.inverse() * first.frame).normalize(),
            };
        }
    }
}

/// Reads `A = [(x y z r) …]`.
pub(crate) fn read(names: &Names, cursor: &mut Cursor<'_>) -> Result<Shape, GrammarError> {
    cursor.skip_blank();
    let at = cursor.pos();
    let name = names.read(cursor)?;
    if !name.chars().next().is_some_and(char::is_alphanumeric) {
        return Err(cursor.error_at(
            at,
            format!("`{name}` is a sign of the turtle; expected a letter"),
        ));
    }
    cursor.expect("=")?;
    cursor.expect("[")?;
    let mut displacements = Vec::new();
    while !cursor.take("]") {
        cursor.expect("(")?;
        let mut values = Vec::new();
        while !cursor.take(")") {
            if values.len() == 4 {
                return Err(cursor.expected("`)` after x, y, z and a radius"));
            }
            cursor.skip_blank();
            let at = cursor.pos();
            let value = signed(cursor)?;
            if values.len() == 3 && value < 0.0 {
                return Err(cursor.error_at(at, "a radius cannot be negative".into()));
            }
            values.push(value);
            cursor.take(",");
        }
        match *values.as_slice() {
            [x, y, z] => displacements.push((DVec3::new(x, y, z), None)),
            [x, y, z, r] => displacements.push((DVec3::new(x, y, z), Some(r))),
            _ => {
                return Err(
                    cursor.expected("three numbers x y z, or four with a radius, before `)`")
                );
            }
        }
        cursor.take(",");
    }
    if displacements.is_empty() {
        return Err(cursor.error_at(
            at,
            format!("the shape `{name}` is empty; expected at least one `(x y z)`"),
        ));
    }
    Ok(Shape::new(name, &displacements))
}

/// The turtle's frame along each segment of a shape, where the shape begins in the frame 1: what a writer of grammars
/// needs to say a branch's displacements in the frame of the segment it sits on.
#[must_use]
pub fn shape_frames(displacements: &[DVec3]) -> Vec<DQuat> {
    let shape = Shape::plain("", displacements);
    shape.segments.iter().map(|segment| segment.frame).collect()
}

/// The smallest rotation that takes the unit vector `from` to `to`; for opposite ones half a turn about `side`, which is
/// at right angles to `from`.
pub(crate) fn smallest_rotation(from: DVec3, to: DVec3, side: DVec3) -> DQuat {
    let w = 1.0 + from.dot(to);
    if w < OPPOSITE {
        return DQuat::from_xyzw(side.x, side.y, side.z, 0.0).normalize();
    }
    let axis = from.cross(to);
    DQuat::from_xyzw(axis.x, axis.y, axis.z, w).normalize()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests may fail by panic")]
    use super::*;

    #[test]
    fn smallest_rotations() {
        let directions = [
            DVec3::X,
            DVec3::Y,
            DVec3::NEG_Y,
            DVec3::Z,
            DVec3::new(1.0, -2.0, 0.5).normalize(),
            DVec3::new(1e-9, -1.0, 0.0).normalize(),
        ];
        for from in directions {
            for to in directions {
                let side = from.any_orthonormal_vector();
                let rotation = smallest_rotation(from, to, side);
                assert!(
                    (rotation * from - to).length() < 1e-7,
                    "{from} to {to}: {}",
                    rotation * from
                );
                assert!((rotation.length() - 1.0).abs() < 1e-12, "unit");
                let angle = 2.0 * rotation.xyz().length().atan2(rotation.w.abs());
                assert!(
                    (angle - from.angle_between(to)).abs() < 1e-6,
                    "{from} to {to}: no more than needed"
                );
            }
        }
    }

    #[test]
    fn frames_follow_the_displacements() {
        let d = [
            (DVec3::new(0.0, -1.0, 0.0), None),
            (DVec3::new(1.0, 1.0, 0.0), Some(0.2)),
            (DVec3::ZERO, None),
            (DVec3::new(0.0, 1e-200, 1e-200), None),
        ];
        let shape = Shape::new("A", &d);
        for (segment, (displacement, _)) in shape.segments.iter().zip(d) {
            let reached = segment.frame * DVec3::Y * segment.length;
            assert!(
                (reached - displacement).length() <= 1e-12 * displacement.length(),
                "{reached} {displacement}"
            );
        }
        assert_eq!(
            shape.segments.get(2).unwrap().frame,
            shape.segments.get(1).unwrap().frame,
            "no length, no turn"
        );
        // The turns lead from frame to frame.
        let mut frame = DQuat::IDENTITY;
        for segment in &shape.segments {
            frame *= segment.turn;
            assert!(frame.angle_between(segment.frame) < 1e-7, "turns add up");
        }
    }
}
