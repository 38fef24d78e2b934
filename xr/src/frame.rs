//! What a headset says of one frame: poses, views, hands, time.
//!
//! Plain data without OpenXR in it, so that the same value comes from a runtime, from a recorded
//! session or from a test. [`Frame::check`] is the one place that says which values are sane: the
//! session reader and writer and the OpenXR room all go by it, so nothing behind them sees a NaN.

use std::f32::consts::FRAC_PI_4;
use std::ops::Mul;

use glam::{Quat, Vec2, Vec3};

/// A position in metres and an orientation, in the stage's frame (Y up, −Z ahead, floor at 0).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Unit quaternion.
    pub orientation: Quat,
    /// Metres.
    pub position: Vec3,
}

impl Pose {
    /// At the origin, unturned.
    pub const IDENTITY: Self = Self {
        orientation: Quat::IDENTITY,
        position: Vec3::ZERO,
    };

    /// The pose that undoes this one: `pose * pose.inverse()` is the identity.
    #[must_use]
    pub fn inverse(self) -> Self {
        let orientation = self.orientation.conjugate();
        Self {
            orientation,
            position: orientation * -self.position,
        }
    }

    /// Finite, not absurdly far away, and turned by what is nearly a unit quaternion (within [`NEARLY_UNIT`]).
    #[must_use]
    pub fn is_sane(&self) -> bool {
        // Written so that a NaN fails: every comparison with it is false.
        self.position
            .to_array()
            .iter()
            .all(|value| value.abs() <= FARTHEST)
            && (self.orientation.length_squared() - 1.0).abs() <= NEARLY_UNIT
    }

    /// The same pose with a unit quaternion, as everything behind a headset wants it; one that is unit to the last
    /// bits is left as it is, so that settling twice changes nothing. Runtimes do this to what is sent to them, so a
    /// session that came through one stays the session that was sent. The pose must be sane.
    #[must_use]
    pub fn settled(self) -> Self {
        if (self.orientation.length_squared() - 1.0).abs() <= UNIT {
            self
        } else {
            Self {
                orientation: self.orientation.normalize(),
                ..self
            }
        }
    }
}

/// `stage_from_head * head_from_eye` is `stage_from_eye`.
impl Mul for Pose {
    type Output = Self;

    fn mul(self, inner: Self) -> Self {
        Self {
            orientation: self.orientation * inner.orientation,
            position: self.position + self.orientation * inner.position,
        }
    }
}

/// Farthest believable coordinate in metres; beyond it a tracking value is nonsense.
pub const FARTHEST: f32 = 10_000.0;

/// How far a quaternion's squared length may be from 1 when it comes in: four written decimals keep well within it.
pub const NEARLY_UNIT: f32 = 0.002;

/// How far a settled quaternion's squared length is from 1 at most: a few last bits.
pub const UNIT: f32 = 1e-6;

/// Longest step of [`Frame::time`] in seconds; whoever makes frames clamps to it, so that a stalled
/// runtime never makes an animation jump.
pub const LONGEST_STEP: f64 = 0.1;

/// Latest believable [`Frame::time`] in seconds: a session of 24 hours.
pub const LATEST: f64 = 86_400.0;

/// Half angles of a view in radians; left and down are usually negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fov {
    /// Left edge.
    pub left: f32,
    /// Right edge.
    pub right: f32,
    /// Upper edge.
    pub up: f32,
    /// Lower edge.
    pub down: f32,
}

impl Fov {
    /// 45° to every side.
    pub const SQUARE: Self = Self {
        left: -FRAC_PI_4,
        right: FRAC_PI_4,
        up: FRAC_PI_4,
        down: -FRAC_PI_4,
    };

    /// Angles short of 90°, right of left and above below, so that a projection can be made from them.
    #[must_use]
    pub fn is_sane(&self) -> bool {
        let angles = [self.left, self.right, self.up, self.down];
        angles.iter().all(|angle| angle.abs() < WIDEST)
            && self.right - self.left > NARROWEST
            && self.up - self.down > NARROWEST
    }
}

/// Half angles at or beyond this many radians (89.4°) make no usable projection.
pub const WIDEST: f32 = 1.56;

/// A view narrower than this many radians shows nothing and would divide by almost zero.
pub const NARROWEST: f32 = 1e-3;

/// One eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye's pose in the stage's frame.
    pub pose: Pose,
    /// What it sees.
    pub fov: Fov,
}

impl View {
    /// With its pose settled ([`Pose::settled`]).
    #[must_use]
    pub fn settled(self) -> Self {
        Self {
            pose: self.pose.settled(),
            ..self
        }
    }
}

/// One hand's controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Whether the controller is tracked now.
    pub tracked: bool,
    /// Pointing pose: the ray goes along −Z.
    pub aim: Pose,
    /// Centre of the hand.
    pub grip: Pose,
    /// 0 to 1.
    pub trigger: f32,
    /// 0 to 1.
    pub squeeze: f32,
    /// x right, y up, −1 to 1.
    pub stick: Vec2,
    /// A on the right, X on the left.
    pub lower: bool,
    /// B on the right, Y on the left.
    pub upper: bool,
}

impl Hand {
    /// Not tracked, nothing pressed.
    pub const ABSENT: Self = Self {
        tracked: false,
        aim: Pose::IDENTITY,
        grip: Pose::IDENTITY,
        trigger: 0.0,
        squeeze: 0.0,
        stick: Vec2::ZERO,
        lower: false,
        upper: false,
    };

    /// Sane poses and values within their ranges.
    #[must_use]
    pub fn is_sane(&self) -> bool {
        self.aim.is_sane()
            && self.grip.is_sane()
            && (0.0..=1.0).contains(&self.trigger)
            && (0.0..=1.0).contains(&self.squeeze)
            && self.stick.to_array().iter().all(|value| value.abs() <= 1.0)
    }
}

/// Everything that a headset says of one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Predicted display time in seconds since the session began; never decreases, never jumps by more than 0.1 s.
    pub time: f64,
    /// Input is ours.
    pub focused: bool,
    /// False: begin and end the frame but draw nothing.
    pub should_render: bool,
    /// The head.
    pub head: Pose,
    /// Left eye, right eye.
    pub views: [View; 2],
    /// Left hand, right hand.
    pub hands: [Hand; 2],
}

/// Height of the eyes of a standing person in metres, where no device says better.
pub const EYE_HEIGHT: f32 = 1.6;

/// Half the distance between the eyes in metres, where no device says better.
pub const HALF_EYE_DISTANCE: f32 = 0.032;

impl Frame {
    /// Where a session begins before anything is said: time 0, focused, drawn, the head at standing
    /// height looking ahead, eyes 64 mm apart with 45° to every side, no hands.
    #[must_use]
    pub fn start() -> Self {
        let head = Pose {
            position: Vec3::new(0.0, EYE_HEIGHT, 0.0),
            ..Pose::IDENTITY
        };
        Self {
            time: 0.0,
            focused: true,
            should_render: true,
            head,
            views: Self::eyes().map(|eye| View {
                pose: head * eye.pose,
                ..eye
            }),
            hands: [Hand::ABSENT; 2],
        }
    }

    /// The eyes of [`Frame::start`], relative to the head.
    #[must_use]
    pub fn eyes() -> [View; 2] {
        [-HALF_EYE_DISTANCE, HALF_EYE_DISTANCE].map(|x| View {
            pose: Pose {
                position: Vec3::new(x, 0.0, 0.0),
                ..Pose::IDENTITY
            },
            fov: Fov::SQUARE,
        })
    }

    /// Says which part of the frame is not sane, if any.
    ///
    /// # Errors
    /// [`FrameFault`] naming the first part that is not finite or out of its range.
    pub fn check(&self) -> Result<(), FrameFault> {
        let parts = [
            ((0.0..=LATEST).contains(&self.time), "time"),
            (self.head.is_sane(), "head"),
            (
                self.views[0].pose.is_sane() && self.views[0].fov.is_sane(),
                "left view",
            ),
            (
                self.views[1].pose.is_sane() && self.views[1].fov.is_sane(),
                "right view",
            ),
            (self.hands[0].is_sane(), "left hand"),
            (self.hands[1].is_sane(), "right hand"),
        ];
        match parts.into_iter().find(|(sane, _)| !sane) {
            Some((_, part)) => Err(FrameFault { part }),
            None => Ok(()),
        }
    }
}

impl Frame {
    /// The frame with all its poses settled ([`Pose::settled`]).
    ///
    /// # Errors
    /// [`FrameFault`] where the frame is not sane.
    pub fn settled(&self) -> Result<Self, FrameFault> {
        self.check()?;
        let hand = |hand: Hand| Hand {
            aim: hand.aim.settled(),
            grip: hand.grip.settled(),
            ..hand
        };
        Ok(Self {
            head: self.head.settled(),
            views: self.views.map(View::settled),
            hands: self.hands.map(hand),
            ..*self
        })
    }
}

/// A frame holds a value that no headset can mean: not finite, out of range, or a quaternion that is no rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the {part} of the frame is not finite or out of range")]
pub struct FrameFault {
    /// Which part.
    pub part: &'static str,
}

/// A vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// 0 left, 1 right.
    pub hand: usize,
    /// Seconds.
    pub duration: f32,
    /// 0 to 1.
    pub amplitude: f32,
}
