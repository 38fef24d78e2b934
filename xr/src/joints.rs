//! A hand without a controller, from the places of its joints: a pinch of thumb and index finger draws, a fist grabs.
//!
//! For runtimes that track fingers (`XR_EXT_hand_tracking`) and leave it to the application to see gestures in them. Where the runtime sees
//! them itself (`XR_EXT_hand_interaction`), its word counts and nothing here is used.

use glam::{Mat3, Quat, Vec3};

use crate::frame::{Hand, Pose};

/// Joints of a hand, as OpenXR counts them.
pub const JOINTS: usize = 26;

/// Places of the joints that matter, as OpenXR numbers them.
pub const PALM: usize = 0;
/// The wrist.
pub const WRIST: usize = 1;
/// The thumb's tip.
pub const THUMB_TIP: usize = 5;
/// The knuckle of the index finger.
pub const INDEX_PROXIMAL: usize = 7;
/// The index finger's tip.
pub const INDEX_TIP: usize = 10;
/// Tips of the three fingers that make a fist.
pub const FIST_TIPS: [usize; 3] = [15, 20, 25];

/// What counts as a gesture. Distances in metres, as adults' hands have them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GestureParams {
    /// A pinch begins where thumb and index finger are this near,
    pub pinched: f32,
    /// and ends where they are this far apart, more than `pinched`.
    pub unpinched: f32,
    /// A fist begins where the fingertips are this near the palm,
    pub closed: f32,
    /// and ends where they are this far away, more than `closed`.
    pub opened: f32,
}

impl Default for GestureParams {
    fn default() -> Self {
        Self {
            pinched: 0.015,
            unpinched: 0.035,
            closed: 0.050,
            opened: 0.070,
        }
    }
}

/// What one hand does: a gesture goes on until it ends, and the other one waits for that. A fist brings thumb and index
/// finger together too, and a pinch bends the other fingers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gesture {
    /// Neither.
    #[default]
    Open,
    /// A pinch: the trigger is pulled.
    Pinch,
    /// A fist: the grip is squeezed.
    Fist,
}

impl Gesture {
    /// The hand that these joints are, absent where too few of them are known: palm, wrist, thumb, and the index finger's
    /// knuckle and tip. Trigger and squeeze are 0 to 1, and never between the middle and the end that the gesture is on,
    /// so that whoever looks for a press at 0.6 and a release at 0.4 sees this one's hysteresis.
    pub fn hand(&mut self, joints: &[Option<Pose>; JOINTS], params: &GestureParams) -> Hand {
        let Some(known) = Known::new(joints) else {
            *self = Self::Open;
            return Hand::ABSENT;
        };
        let near = |distance: f32, from: f32, to: f32| {
            // 1 at `from` and nearer, 0 at `to` and farther.
            ((to - distance) / (to - from)).clamp(0.0, 1.0)
        };
        let pinch = near(known.pinch, params.pinched, params.unpinched);
        let fist = known
            .fist
            .map_or(0.0, |distance| near(distance, params.closed, params.opened));
        let ended = match self {
            Self::Open => true,
            Self::Pinch => pinch <= 0.0,
            Self::Fist => fist <= 0.0,
        };
        if ended {
            *self = if fist >= 1.0 {
                Self::Fist
            } else if pinch >= 1.0 {
                Self::Pinch
            } else {
                Self::Open
            };
        }
        // A pull that goes on stays above the middle, one that has not begun below it.
        let (going, coming) = (|value: f32| 0.6 + 0.4 * value, |value: f32| 0.4 * value);
        let (trigger, squeeze) = match self {
            Self::Open => (coming(pinch), coming(fist)),
            Self::Pinch => (going(pinch), 0.0),
            Self::Fist => (0.0, going(fist)),
        };
        Hand {
            tracked: true,
            aim: known.aim,
            grip: known.grip,
            trigger,
            squeeze,
            ..Hand::ABSENT
        }
    }
}

/// What the gestures are seen in.
struct Known {
    aim: Pose,
    grip: Pose,
    /// From thumb to index finger.
    pinch: f32,
    /// From the palm to the tips, in the mean of those that are known; none where fewer than two are.
    fist: Option<f32>,
}

impl Known {
    fn new(joints: &[Option<Pose>; JOINTS]) -> Option<Self> {
        let joint = |at: usize| {
            let pose = (*joints.get(at)?)?;
            pose.is_sane().then(|| pose.settled())
        };
        let palm = joint(PALM)?;
        let (thumb, index) = (joint(THUMB_TIP)?.position, joint(INDEX_TIP)?.position);
        // From the wrist through the knuckle: it hardly moves while the fingers pinch.
        let ahead = (joint(INDEX_PROXIMAL)?.position - joint(WRIST)?.position).try_normalize()?;
        let aim = Pose {
            orientation: looking(ahead, palm.orientation * Vec3::Y)?,
            position: thumb.midpoint(index),
        };
        let (mut sum, mut count) = (0.0, 0.0);
        for tip in FIST_TIPS.into_iter().filter_map(joint) {
            sum += tip.position.distance(palm.position);
            count += 1.0;
        }
        Some(Self {
            aim,
            grip: palm,
            pinch: thumb.distance(index),
            fist: (count > 1.5).then(|| sum / count),
        })
    }
}

/// The turn whose −Z is `ahead`, with Y as near `up` as may be.
fn looking(ahead: Vec3, up: Vec3) -> Option<Quat> {
    let right = ahead.cross(up).try_normalize()?;
    let up = right.cross(ahead);
    let turn = Quat::from_mat3(&Mat3::from_cols(right, up, -ahead));
    turn.is_finite().then(|| turn.normalize())
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "tests say what they expect by their names"
    )]

    use super::*;

    /// A hand that looks ahead, back of the hand up, with thumb and index finger `pinch` apart and the other
    /// tips `fist` from the palm.
    fn hand(pinch: f32, fist: f32) -> [Option<Pose>; JOINTS] {
        let at = |x: f32, y: f32, z: f32| {
            Some(Pose {
                position: Vec3::new(0.2, 1.1, -0.3) + Vec3::new(x, y, z),
                ..Pose::IDENTITY
            })
        };
        let mut joints = [at(0.0, 0.0, -0.05); JOINTS];
        joints[PALM] = at(0.0, 0.0, 0.0);
        joints[WRIST] = at(0.0, 0.0, 0.07);
        joints[INDEX_PROXIMAL] = at(0.0, 0.0, -0.03);
        joints[THUMB_TIP] = at(-pinch / 2.0, 0.0, -0.08);
        joints[INDEX_TIP] = at(pinch / 2.0, 0.0, -0.08);
        for tip in FIST_TIPS {
            joints[tip] = at(0.0, 0.0, -fist);
        }
        joints
    }

    fn seen(gesture: &mut Gesture, pinch: f32, fist: f32) -> (bool, bool) {
        let hand = gesture.hand(&hand(pinch, fist), &GestureParams::default());
        assert!(hand.is_sane() && hand.tracked);
        for value in [hand.trigger, hand.squeeze] {
            assert!(value <= 0.4 || value >= 0.6, "{value} is neither");
        }
        (hand.trigger >= 0.6, hand.squeeze >= 0.6)
    }

    #[test]
    fn a_pinch_begins_near_and_ends_far() {
        let mut gesture = Gesture::default();
        let distances = [
            0.06, 0.03, 0.02, 0.014, 0.02, 0.03, 0.034, 0.036, 0.03, 0.016,
        ];
        let pulled: Vec<bool> = distances
            .iter()
            .map(|pinch| seen(&mut gesture, *pinch, 0.1).0)
            .collect();
        let expected = [
            false, false, false, true, true, true, true, false, false, false,
        ];
        assert_eq!(pulled, expected);
    }

    #[test]
    fn a_fist_begins_near_and_ends_far() {
        let mut gesture = Gesture::default();
        let squeezed: Vec<bool> = [0.1, 0.06, 0.049, 0.06, 0.069, 0.071, 0.06]
            .iter()
            .map(|fist| seen(&mut gesture, 0.06, *fist).1)
            .collect();
        assert_eq!(squeezed, [false, false, true, true, true, false, false]);
    }

    #[test]
    fn of_pinch_and_fist_the_first_goes_on() {
        let mut gesture = Gesture::default();
        assert_eq!(seen(&mut gesture, 0.01, 0.1), (true, false));
        assert_eq!(
            seen(&mut gesture, 0.01, 0.03),
            (true, false),
            "still a pinch"
        );
        assert_eq!(seen(&mut gesture, 0.05, 0.03), (false, true), "now a fist");
        assert_eq!(
            seen(&mut gesture, 0.01, 0.03),
            (false, true),
            "still a fist"
        );
        assert_eq!(seen(&mut gesture, 0.01, 0.1), (true, false), "now a pinch");
        assert_eq!(seen(&mut gesture, 0.05, 0.1), (false, false));
    }

    #[test]
    fn the_ray_goes_from_the_wrist_through_the_knuckle() {
        let turn = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-0.4);
        let joints = hand(0.02, 0.1).map(|joint| {
            joint.map(|pose| Pose {
                orientation: turn,
                position: turn * pose.position,
            })
        });
        let hand = Gesture::default().hand(&joints, &GestureParams::default());
        let expected = joints[INDEX_PROXIMAL].unwrap().position - joints[WRIST].unwrap().position;
        let ahead = hand.aim.orientation * Vec3::NEG_Z;
        assert!((ahead - expected.normalize()).length() < 1e-5);
        assert!((hand.aim.orientation * Vec3::Y).dot(turn * Vec3::Y) > 0.999);
        let between = joints[THUMB_TIP]
            .unwrap()
            .position
            .midpoint(joints[INDEX_TIP].unwrap().position);
        assert!((hand.aim.position - between).length() < 1e-6);
        assert_eq!(hand.grip, joints[PALM].unwrap());
    }

    #[test]
    fn a_hand_of_which_too_little_is_known_is_absent() {
        let whole = hand(0.01, 0.1);
        for missing in [PALM, WRIST, THUMB_TIP, INDEX_PROXIMAL, INDEX_TIP] {
            let mut gesture = Gesture::Pinch;
            let mut joints = whole;
            joints[missing] = None;
            let params = GestureParams::default();
            assert_eq!(gesture.hand(&joints, &params), Hand::ABSENT, "{missing}");
            assert_eq!(gesture, Gesture::Open, "the gesture is over");
            // Nor with nonsense in its place, nor with all joints in one point.
            joints[missing] = Some(Pose {
                position: Vec3::splat(f32::NAN),
                ..Pose::IDENTITY
            });
            assert_eq!(gesture.hand(&joints, &params), Hand::ABSENT, "{missing}");
        }
        let point = [whole[PALM]; JOINTS];
        assert_eq!(
            Gesture::default().hand(&point, &GestureParams::default()),
            Hand::ABSENT
        );
        // The other fingers may be hidden: then there is no fist, and the pinch counts.
        let mut joints = hand(0.01, 0.03);
        joints[FIST_TIPS[0]] = None;
        joints[FIST_TIPS[2]] = None;
        let hand = Gesture::default().hand(&joints, &GestureParams::default());
        assert!(hand.trigger == 1.0 && hand.squeeze == 0.0);
    }
}
