//! What a person does in one frame, as the world sees it: poses, buttons, time.

use glam::{Quat, Vec2, Vec3};

/// A position in metres and an orientation, both in the stage's frame (Y up, −Z ahead).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Unit quaternion that turns the pose's own axes into the stage's.
    pub orientation: Quat,
    /// Metres.
    pub position: Vec3,
}

/// One hand's controller in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandInput {
    /// False while the controller is not tracked: it then neither points nor acts.
    pub tracked: bool,
    /// Pointing ray: starts at the position, goes along the pose's −Z.
    pub aim: Pose,
    /// Centre of the hand that holds the controller.
    pub grip: Pose,
    /// 0 (free) to 1 (pulled).
    pub trigger: f32,
    /// 0 (open) to 1 (gripped).
    pub squeeze: f32,
    /// Thumbstick, x right, y up, each −1 to 1.
    pub stick: Vec2,
    /// The lower face button: A on the right, X on the left.
    pub lower: bool,
    /// The upper face button: B on the right, Y on the left.
    pub upper: bool,
}

impl HandInput {
    /// A tracked controller at a place, with nothing pressed: where every script of a hand begins.
    #[must_use]
    pub const fn at(pose: Pose) -> Self {
        Self {
            tracked: true,
            aim: pose,
            grip: pose,
            trigger: 0.0,
            squeeze: 0.0,
            stick: Vec2::ZERO,
            lower: false,
            upper: false,
        }
    }
}

/// Everything the world is told in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input {
    /// Seconds since the session began. Animation depends on it, and the document in one thing only: where a node is
    /// that is let go while it still flies to the hand.
    pub time: f64,
    /// False when another application or the system menu has the input.
    pub focused: bool,
    /// The head.
    pub head: Pose,
    /// Left hand, right hand.
    pub hands: [HandInput; 2],
}
