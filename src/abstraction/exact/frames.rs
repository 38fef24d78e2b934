//! How each segment stands to the one that it grows from, told so that like parts are told alike wherever they stand.
//!
//! A segment's frame is a quaternion whose axes are the turtle's: X to the right, Y ahead, Z up. The heading is the segment's; how the frame
//! is rolled about it is up to us. Where it is rolled so that its first side branch hangs down (`&` alone turns there), a part tells the same wherever it
//! stands and however it is turned. Where it is level, as `$` makes it, parts tell the same that grow by the same rule with `$`, as ABOP's trees do.

use std::f64::consts::PI;

use glam::{DMat3, DQuat, DVec3};

use super::shape::Shape;
use crate::tree::NO_PARENT;

/// A side branch leaves by more than this at least, radians.
const ASIDE: f64 = 0.01;

/// A heading whose horizontal part is shorter than this counts as vertical, and is not rolled by `$`.
const VERTICAL: f64 = 1e-3;

/// As the turtle has it.
const LEVEL_AS_IT_IS: f64 = 1e-12;

/// How frames are rolled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rolled {
    /// By what grows from the segment.
    ByBranches,
    /// So that left is horizontal.
    Level,
}

/// Of each segment of a shape.
pub(super) struct Frames {
    /// Of length 1, or 0 for roots and segments without length.
    pub(super) heading: Vec<DVec3>,
    /// The frame's Z; none where nothing that grows from it says how it is rolled.
    pub(super) up: Vec<Option<DVec3>>,
    /// Whether `$` gives this roll.
    pub(super) is_level: Vec<bool>,
}

/// Turns of the turtle in radians: `/` by `roll`, then `&` by `pitch`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Turn {
    pub(super) roll: f64,
    pub(super) pitch: f64,
}

impl Turn {
    /// The turn from the heading of a frame to a direction in its own axes.
    pub(super) fn to(direction: DVec3) -> Self {
        let aside = direction.x.hypot(direction.z);
        Self {
            roll: if aside > 0.0 {
                (-direction.x).atan2(-direction.z)
            } else {
                0.0
            },
            pitch: aside.atan2(direction.y),
        }
    }

    pub(super) fn rotation(self) -> DQuat {
        DQuat::from_rotation_y(self.roll) * DQuat::from_rotation_x(-self.pitch)
    }
}

/// The frame of a heading and an up that is square to it.
pub(super) fn frame(heading: DVec3, up: DVec3) -> DQuat {
    let up = square_to(up, heading).unwrap_or_else(|| heading.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(heading.cross(up), heading, up))
}

/// The part of a vector that is square to a direction, of length 1.
fn square_to(vector: DVec3, direction: DVec3) -> Option<DVec3> {
    (vector - direction * vector.dot(direction)).try_normalize()
}

fn is_vertical(heading: DVec3) -> bool {
    heading.x.hypot(heading.z) < VERTICAL
}

/// A frame after `$`; a vertical one stays as it is.
pub(super) fn levelled(rotation: DQuat) -> DQuat {
    let heading = rotation * DVec3::Y;
    match heading.x.hypot(heading.z) < LEVEL_AS_IT_IS {
        true => rotation,
        false => frame(heading, DVec3::Y),
    }
}

/// The roll about the heading from one frame to another up, radians.
pub(super) fn roll_to(from: DQuat, up: DVec3) -> f64 {
    let own = from.inverse() * up;
    own.x.atan2(own.z)
}

/// An angle from −π to π, the latter included.
pub(super) fn wrapped(angle: f64) -> f64 {
    let angle = angle.rem_euclid(2.0 * PI);
    if angle > PI { angle - 2.0 * PI } else { angle }
}

impl Frames {
    /// The frames of a shape whose angles are told apart by so much, radians.
    pub(super) fn new(shape: &Shape, rolled: Rolled, apart: f64) -> Self {
        let steps = (0..).take(shape.len()).map(|node| shape.step(node));
        let heading: Vec<DVec3> = steps.map(DVec3::normalize_or_zero).collect();
        let mut frames = Self {
            up: vec![None; heading.len()],
            is_level: vec![false; heading.len()],
            heading,
        };
        for node in (0..shape.len()).rev() {
            let heading = frames.heading[node];
            if shape.parent[node] == NO_PARENT || heading == DVec3::ZERO {
                continue;
            }
            let children = shape.children(u32::try_from(node).unwrap_or(NO_PARENT));
            let by_branches = frames.by_branches(heading, children, apart);
            // What has no branches looks the same however it is rolled.
            let levels = rolled == Rolled::Level && !is_vertical(heading);
            frames.is_level[node] = levels && by_branches.is_some();
            frames.up[node] = match by_branches {
                Some(_) if levels => square_to(DVec3::Y, heading),
                other => other,
            };
        }
        frames
    }

    /// The up that has the first side branch below; where there is none, that of what goes on straight.
    fn by_branches(&self, heading: DVec3, children: &[u32], apart: f64) -> Option<DVec3> {
        let leaves = |child: &u32, by: f64| {
            let aside = self.heading[*child as usize];
            (aside != DVec3::ZERO && heading.angle_between(aside) > by).then_some(aside)
        };
        let aside = |by: f64| children.iter().find_map(|child| leaves(child, by));
        let on = || children.iter().find_map(|child| self.up[*child as usize]);
        let below = |aside: DVec3| square_to(-aside, heading);
        let first = aside(ASIDE.max(2.0 * apart)).and_then(below);
        first
            .or_else(|| on().and_then(|up| square_to(up, heading)))
            .or_else(|| aside(apart).and_then(below))
    }

    /// The frame of a segment.
    pub(super) fn frame(&self, node: u32) -> DQuat {
        let heading = self.heading[node as usize];
        let up = self.up[node as usize];
        frame(
            heading,
            up.unwrap_or_else(|| heading.any_orthonormal_vector()),
        )
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    #[test]
    fn a_turn_to_a_direction_leads_there() {
        for direction in [
            DVec3::X,
            DVec3::Y,
            DVec3::NEG_Y,
            DVec3::Z,
            DVec3::new(0.3, -0.2, 0.9),
            DVec3::new(-0.7, 0.1, -0.4),
        ] {
            let direction = direction.normalize();
            let led = Turn::to(direction).rotation() * DVec3::Y;
            assert!(led.distance(direction) < 1e-12, "{direction}: {led}");
        }
    }

    #[test]
    fn a_roll_leads_from_one_up_to_another() {
        let from = frame(DVec3::new(1.0, 2.0, -0.5).normalize(), DVec3::Y);
        for by in [-3.0, -1.0, 0.0, 0.4, 2.5] {
            let to = from * DQuat::from_rotation_y(by);
            assert!((roll_to(from, to * DVec3::Z) - by).abs() < 1e-12, "{by}");
        }
    }
}
