//! One hand's raw input made safe: checked poses and button edges.
//!
//! Tools act on edges alone (a button goes down, a button comes up), each with
//! the pose of the very frame that brought it. A frame that a runtime shows
//! twice therefore changes nothing, and the document does not depend on the
//! frame rate.
//!
//! Every button starts *blocked* and is blocked again while its controller is
//! untracked, its values are no numbers, or the input is not ours: it must be
//! seen released before it can be pressed. So nothing is drawn by a trigger
//! that was already pulled when the controller came back.

use glam::{Quat, Vec3};

use super::input::{HandInput, Pose};

/// How buttons and poses are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandParams {
    /// Trigger and squeeze count as pressed above this, 0 to 1.
    pub press: f32,
    /// Trigger and squeeze count as released below this, less than `press`.
    pub release: f32,
    /// The stick counts as flicked beyond this, 0 to 1.
    pub flick: f32,
    /// The stick counts as centred again within this, less than `flick`.
    pub centre: f32,
    /// How far the drawing tip stands ahead of the aim pose, metres.
    pub tip: f32,
    /// A pose farther than this from the stage's origin is nonsense, metres.
    pub farthest: f32,
    /// How much a quaternion's length may differ from 1 before it is nonsense.
    pub unit_error: f32,
}

impl Default for HandParams {
    fn default() -> Self {
        Self {
            press: 0.6,
            release: 0.4,
            flick: 0.7,
            centre: 0.3,
            tip: 0.06,
            farthest: 100.0,
            unit_error: 0.01,
        }
    }
}

/// A controller's checked state in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    /// Pointing pose, a unit quaternion.
    pub(super) aim: Pose,
    /// The hand's pose, a unit quaternion.
    pub(super) grip: Pose,
    /// The drawing tip in the stage, metres.
    pub(super) tip: Vec3,
    /// Unit vector along which the hand points.
    pub(super) direction: Vec3,
    /// How far the trigger is pulled, 0 to 1.
    pub(super) trigger: f32,
}

/// What a button did in this frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Edge {
    /// Nothing new.
    #[default]
    None,
    /// It went down.
    Down,
    /// It came up.
    Up,
}

/// What all buttons of one hand did in this frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Edges {
    pub(super) trigger: Edge,
    pub(super) squeeze: Edge,
    pub(super) lower: Edge,
    pub(super) upper: Edge,
    /// The stick was flicked: −1 left, 1 right, 0 not.
    pub(super) flick: i8,
}

/// A button's memory between frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Latch {
    /// Must be seen released first.
    #[default]
    Blocked,
    Free,
    Down,
}

impl Latch {
    /// Moves on by one frame: `pressed` and `released` are both false between the two thresholds.
    fn step(&mut self, pressed: bool, released: bool) -> Edge {
        match *self {
            Self::Blocked if released => {
                *self = Self::Free;
                Edge::None
            }
            Self::Free if pressed => {
                *self = Self::Down;
                Edge::Down
            }
            Self::Down if released => {
                *self = Self::Free;
                Edge::Up
            }
            _ => Edge::None,
        }
    }

    fn button(&mut self, pressed: bool) -> Edge {
        self.step(pressed, !pressed)
    }
}

/// All buttons of one hand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Buttons {
    trigger: Latch,
    squeeze: Latch,
    lower: Latch,
    upper: Latch,
    stick: Latch,
}

impl Buttons {
    /// What changed with this frame's values, which `sample` found to be sound.
    pub(super) fn step(&mut self, hand: &HandInput, params: &HandParams) -> Edges {
        let HandParams {
            press,
            release,
            flick,
            centre,
            ..
        } = *params;
        let flicked = self
            .stick
            .step(hand.stick.x.abs() > flick, hand.stick.x.abs() < centre)
            == Edge::Down;
        Edges {
            trigger: self
                .trigger
                .step(hand.trigger > press, hand.trigger < release),
            squeeze: self
                .squeeze
                .step(hand.squeeze > press, hand.squeeze < release),
            lower: self.lower.button(hand.lower),
            upper: self.upper.button(hand.upper),
            flick: match (flicked, hand.stick.x > 0.0) {
                (false, _) => 0,
                (true, false) => -1,
                (true, true) => 1,
            },
        }
    }
}

/// The hand's state, or `None` where it is not tracked or says nonsense.
pub(super) fn sample(hand: &HandInput, params: &HandParams) -> Option<Sample> {
    if !hand.tracked
        || !hand.trigger.is_finite()
        || !hand.squeeze.is_finite()
        || !hand.stick.is_finite()
    {
        return None;
    }
    let aim = checked(&hand.aim, params)?;
    let grip = checked(&hand.grip, params)?;
    let direction = (aim.orientation * Vec3::NEG_Z).normalize_or(Vec3::NEG_Z);
    Some(Sample {
        aim,
        grip,
        tip: aim.position + direction * params.tip,
        direction,
        trigger: hand.trigger.clamp(0.0, 1.0),
    })
}

/// The pose with its quaternion made exactly unit, or `None` where it is nonsense.
pub(super) fn checked(pose: &Pose, params: &HandParams) -> Option<Pose> {
    let length = pose.orientation.length();
    // Written so that NaN fails each test.
    let sound = (length - 1.0).abs() <= params.unit_error
        && pose.position.abs().max_element() <= params.farthest;
    (sound && pose.position.is_finite()).then(|| Pose {
        orientation: pose.orientation.normalize(),
        position: pose.position,
    })
}

/// The turn about the vertical in `to · from⁻¹`, radians in −π…π: what is left of a hand's turn when the horizon stays level.
pub(super) fn yaw_between(from: Quat, to: Quat) -> f32 {
    let turn = to * from.inverse();
    // The twist part of a swing–twist split; both 0 only for a half turn about a level axis, where atan2 gives 0.
    let yaw = 2.0 * turn.y.atan2(turn.w);
    wrapped(yaw)
}

/// The angle brought into −π…π.
pub(super) fn wrapped(angle: f32) -> f32 {
    let turned = angle.rem_euclid(std::f32::consts::TAU);
    if turned > std::f32::consts::PI {
        turned - std::f32::consts::TAU
    } else {
        turned
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use glam::Vec2;
    use proptest::prelude::*;

    use super::*;

    fn resting() -> HandInput {
        HandInput::at(Pose {
            orientation: Quat::IDENTITY,
            position: Vec3::new(0.2, 1.0, -0.3),
        })
    }

    #[test]
    fn the_tip_stands_ahead_of_the_aim() {
        let params = HandParams::default();
        let mut hand = resting();
        hand.aim.orientation = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
        let sample = sample(&hand, &params).unwrap();
        // A quarter turn to the left looks along −X.
        assert!((sample.tip - (hand.aim.position - Vec3::X * params.tip)).length() < 1e-6);
    }

    #[test]
    fn hysteresis_gives_one_edge_for_a_pull_that_trembles() {
        let params = HandParams::default();
        let mut buttons = Buttons::default();
        let mut hand = resting();
        let mut seen = Vec::new();
        for value in [
            0.0, 0.5, 0.61, 0.55, 0.45, 0.62, 0.62, 0.41, 0.39, 0.45, 0.59, 0.39,
        ] {
            hand.trigger = value;
            seen.push(buttons.step(&hand, &params).trigger);
        }
        let mut expected = vec![Edge::None; 12];
        expected[2] = Edge::Down;
        expected[8] = Edge::Up;
        assert_eq!(seen, expected);
    }

    #[test]
    fn a_button_held_from_the_start_waits_for_its_release() {
        let params = HandParams::default();
        let mut buttons = Buttons::default();
        let mut hand = resting();
        (
            hand.trigger,
            hand.squeeze,
            hand.lower,
            hand.upper,
            hand.stick.x,
        ) = (1.0, 1.0, true, true, 1.0);
        assert_eq!(buttons.step(&hand, &params), Edges::default());
        assert_eq!(
            buttons.step(&resting(), &params),
            Edges::default(),
            "no up without a down"
        );
        let all = buttons.step(&hand, &params);
        assert_eq!(
            (all.trigger, all.squeeze, all.lower, all.upper, all.flick),
            (Edge::Down, Edge::Down, Edge::Down, Edge::Down, 1)
        );
        buttons = Buttons::default();
        assert_eq!(
            buttons.step(&hand, &params),
            Edges::default(),
            "blocked again"
        );
    }

    #[test]
    fn a_flick_needs_the_centre_before_the_next() {
        let params = HandParams::default();
        let mut buttons = Buttons::default();
        let mut hand = resting();
        let mut seen = Vec::new();
        for x in [
            0.0, 0.6, 0.75, 1.0, 0.5, 0.9, 0.2, -0.9, -0.4, -0.8, 0.0, -0.71,
        ] {
            hand.stick.x = x;
            seen.push(buttons.step(&hand, &params).flick);
        }
        assert_eq!(seen, [0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, -1]);
    }

    #[test]
    fn nonsense_counts_as_untracked() {
        type Spoil = fn(&mut HandInput);
        let cases: [(&str, Spoil); 9] = [
            ("untracked", |hand| hand.tracked = false),
            ("NaN position", |hand| hand.aim.position.y = f32::NAN),
            ("infinite position", |hand| {
                hand.grip.position.x = f32::INFINITY
            }),
            ("far away", |hand| hand.grip.position.z = -101.0),
            ("NaN quaternion", |hand| hand.aim.orientation.w = f32::NAN),
            ("no quaternion", |hand| {
                hand.aim.orientation = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)
            }),
            ("long quaternion", |hand| {
                hand.grip.orientation = Quat::from_xyzw(0.0, 0.0, 0.0, 1.2)
            }),
            ("NaN trigger", |hand| hand.trigger = f32::NAN),
            ("NaN stick", |hand| hand.stick.y = f32::NAN),
        ];
        let params = HandParams::default();
        assert!(sample(&resting(), &params).is_some());
        for (what, spoil) in cases {
            let mut hand = resting();
            spoil(&mut hand);
            assert_eq!(sample(&hand, &params), None, "{what}");
        }
    }

    #[test]
    fn yaw_is_what_a_level_turn_is() {
        let tilt = Quat::from_rotation_x(-0.9) * Quat::from_rotation_z(0.3);
        for yaw in [-3.0_f32, -1.0, 0.0, 0.5, 2.5] {
            let turned = Quat::from_rotation_y(yaw) * tilt;
            assert!((yaw_between(tilt, turned) - yaw).abs() < 1e-4, "{yaw}");
            // The other sign of the quaternion is the same turn.
            assert!((yaw_between(tilt, -turned) - yaw).abs() < 1e-4, "{yaw}");
        }
        assert!(
            yaw_between(Quat::IDENTITY, Quat::from_rotation_x(0.7)).abs() < 1e-6,
            "nodding is no turn"
        );
    }

    proptest! {
        #[test]
        fn any_bits_are_sound_or_refused(bits in prop::array::uniform14(any::<u32>())) {
            let f = |i: usize| f32::from_bits(bits[i]);
            let mut hand = resting();
            hand.aim.position = Vec3::new(f(0), f(1), f(2));
            hand.aim.orientation = Quat::from_xyzw(f(3), f(4), f(5), f(6));
            hand.trigger = f(7);
            hand.squeeze = f(8);
            hand.stick = Vec2::new(f(9), f(10));
            if let Some(sample) = sample(&hand, &HandParams::default()) {
                prop_assert!(sample.tip.is_finite() && sample.direction.is_normalized());
                prop_assert!((0.0..=1.0).contains(&sample.trigger));
            }
        }
    }
}
