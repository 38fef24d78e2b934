//! The platform in the hands: moved and turned by one, scaled too by two.
//!
//! The platform follows as if it were fixed to the hand, but stays level: only
//! the hand's turn about the vertical counts. With two hands the midpoint
//! carries it, their distance scales it and their direction turns it. When a
//! hand joins or leaves, the grip begins anew from where the platform is, so it never jumps.

use glam::{Quat, Vec3};

use super::{
    document::Placement,
    hands::{wrapped, yaw_between},
    input::Pose,
};

/// How far the platform may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripParams {
    /// Largest level distance from the stage's origin along one axis, metres: it must stay in the room.
    pub farthest: f32,
    /// Lowest and highest top, metres.
    pub height: [f32; 2],
    /// Smallest and largest scale.
    pub scale: [f32; 2],
    /// Hands nearer to each other than this neither scale nor turn, metres.
    pub least_span: f32,
}

impl Default for GripParams {
    fn default() -> Self {
        Self {
            farthest: 3.0,
            height: [0.1, 2.0],
            scale: [0.05, 4.0],
            least_span: 0.02,
        }
    }
}

/// A grip since the last hand joined or left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlatformGrip {
    start: Placement,
    hands: [Option<Pose>; 2],
}

impl PlatformGrip {
    pub(super) fn new(start: Placement, hands: [Option<Pose>; 2]) -> Self {
        Self { start, hands }
    }

    /// Where the platform is when the hands are at `now`.
    pub(super) fn placement(&self, now: [Option<Pose>; 2], params: &GripParams) -> Placement {
        let both = |[left, right]: [Option<Pose>; 2]| left.zip(right);
        let (yaw, scale, from, to) = match (both(self.hands), both(now)) {
            (Some(before), Some(after)) => self.by_two(before, after, params),
            _ => match self
                .hands
                .iter()
                .zip(now)
                .find_map(|(&before, after)| before.zip(after))
            {
                Some((before, after)) => {
                    let yaw = yaw_between(before.orientation, after.orientation);
                    (yaw, self.start.scale, before.position, after.position)
                }
                None => return self.start,
            },
        };
        let ratio = scale / self.start.scale;
        let arm = Quat::from_rotation_y(yaw) * (self.start.position - from);
        let position = to + arm * ratio;
        let level = Vec3::new(params.farthest, 0.0, params.farthest);
        let [lowest, highest] = params.height;
        Placement {
            position: position.clamp(-level + Vec3::Y * lowest, level + Vec3::Y * highest),
            yaw_deg: self.start.yaw_deg + f64::from(yaw).to_degrees(),
            scale,
        }
        .quantized()
    }

    /// Turn, scale, and the points of the grip before and after.
    fn by_two(
        &self,
        before: (Pose, Pose),
        after: (Pose, Pose),
        params: &GripParams,
    ) -> (f32, f32, Vec3, Vec3) {
        let span = |(left, right): (Pose, Pose)| right.position - left.position;
        let middle = |(left, right): (Pose, Pose)| (left.position + right.position) * 0.5;
        let (old, new) = (span(before), span(after));
        let heading = |span: Vec3| (-span.z).atan2(span.x);
        let wide = |span: Vec3| span.x.hypot(span.z) >= params.least_span;
        let yaw = if wide(old) && wide(new) {
            wrapped(heading(new) - heading(old))
        } else {
            0.0
        };
        let long = |span: Vec3| span.length() >= params.least_span;
        let ratio = if long(old) && long(new) {
            new.length() / old.length()
        } else {
            1.0
        };
        let [least, most] = params.scale;
        (
            yaw,
            (self.start.scale * ratio).clamp(least, most),
            middle(before),
            middle(after),
        )
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use proptest::prelude::*;

    use super::*;

    const START: Placement = Placement {
        position: Vec3::new(0.0, 0.9, -0.5),
        yaw_deg: 30.0,
        scale: 0.5,
    };

    fn pose(x: f32, y: f32, z: f32, yaw: f32) -> Pose {
        Pose {
            orientation: Quat::from_rotation_y(yaw),
            position: Vec3::new(x, y, z),
        }
    }

    fn at(grip: [Option<Pose>; 2], now: [Option<Pose>; 2]) -> Placement {
        PlatformGrip::new(START, grip).placement(now, &GripParams::default())
    }

    #[test]
    fn one_hand_carries_and_turns_it_about_itself() {
        let before = pose(0.3, 0.9, -0.5, 0.0);
        for hand in [0, 1] {
            let by = |after: Pose| {
                let (mut grip, mut now) = ([None; 2], [None; 2]);
                grip[hand] = Some(before);
                now[hand] = Some(after);
                at(grip, now)
            };
            assert_eq!(by(before), START, "held still");
            let moved = by(pose(0.4, 1.0, -0.6, 0.0));
            assert!(moved.position.distance(Vec3::new(0.1, 1.0, -0.6)) < 1e-4);
            let turned = by(pose(0.3, 0.9, -0.5, std::f32::consts::FRAC_PI_2));
            // The platform was 0.3 m to the left of the hand; a quarter turn to the left puts it in front of its thumb, at +Z.
            assert!(
                turned.position.distance(Vec3::new(0.3, 0.9, -0.2)) < 1e-3,
                "{turned:?}"
            );
            assert!((turned.yaw_deg - 120.0).abs() < 0.01 && turned.scale == START.scale);
            let tilted = by(Pose {
                orientation: Quat::from_rotation_x(0.8),
                position: before.position,
            });
            assert_eq!(tilted, START, "the horizon stays level");
        }
    }

    #[test]
    fn two_hands_scale_and_turn_it_about_their_middle() {
        let grip = [
            Some(pose(-0.2, 0.9, -0.5, 0.0)),
            Some(pose(0.2, 0.9, -0.5, 0.0)),
        ];
        let wider = at(
            grip,
            [
                Some(pose(-0.4, 0.9, -0.5, 0.0)),
                Some(pose(0.4, 0.9, -0.5, 0.0)),
            ],
        );
        assert!(
            (wider.scale - 1.0).abs() < 1e-3
                && wider.position == START.position
                && wider.yaw_deg == START.yaw_deg
        );
        // The right hand goes ahead, the left one back: a quarter turn to the left.
        let turned = at(
            grip,
            [
                Some(pose(0.0, 0.9, -0.3, 0.0)),
                Some(pose(0.0, 0.9, -0.7, 0.0)),
            ],
        );
        assert!((turned.yaw_deg - 120.0).abs() < 0.01, "{}", turned.yaw_deg);
        assert!(
            (turned.scale - 0.5).abs() < 1e-3 && turned.position.distance(START.position) < 1e-3
        );
    }

    proptest! {
        #[test]
        fn any_hands_leave_it_in_the_room(
            places in prop::array::uniform12(-100.0_f32..100.0),
            turns in prop::array::uniform4(-4.0_f32..4.0),
            held in prop::array::uniform4(any::<bool>()),
        ) {
            let hand = |i: usize| held[i].then(|| pose(places[3 * i], places[3 * i + 1], places[3 * i + 2], turns[i]));
            let params = GripParams::default();
            let placement = at([hand(0), hand(1)], [hand(2), hand(3)]);
            prop_assert!(placement.validate().is_ok(), "{placement:?}");
            let position = placement.position;
            prop_assert!(position.x.abs() <= params.farthest && position.z.abs() <= params.farthest);
            prop_assert!((params.height[0]..=params.height[1]).contains(&position.y));
            prop_assert!((params.scale[0]..=params.scale[1]).contains(&placement.scale));
        }
    }
}
