//! Bare hands where the runtime tracks joints and sees no gestures (XR_EXT_hand_tracking).

use ::openxr as xr;

use super::call::Called as _;
use super::space::{Stage, pose_from_raw};
use crate::frame::Hand;
use crate::headset::HeadsetError;
use crate::joints::{Gesture, GestureParams};

/// Both hands' trackers and what the hands are doing.
pub(super) struct Hands {
    trackers: [xr::HandTracker; 2],
    gestures: [Gesture; 2],
    params: GestureParams,
}

impl Hands {
    /// None where the runtime gives no trackers: a session goes without bare hands then.
    pub(super) fn new(session: &xr::Session<xr::Vulkan>) -> Result<Option<Self>, HeadsetError> {
        let tracker = |hand| {
            session
                .create_hand_tracker(hand)
                .called("xrCreateHandTrackerEXT")
        };
        let both = tracker(xr::Hand::LEFT).and_then(|left| Ok([left, tracker(xr::Hand::RIGHT)?]));
        match both {
            Ok(trackers) => Ok(Some(Self {
                trackers,
                gestures: [Gesture::default(); 2],
                params: GestureParams::default(),
            })),
            Err(HeadsetError::Failed(why)) => {
                tracing::warn!("no bare hands: {why}");
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }

    /// The hand on one side at `time`.
    pub(super) fn hand(
        &mut self,
        stage: &Stage,
        time: xr::Time,
        side: usize,
    ) -> Result<Hand, HeadsetError> {
        let (Some(tracker), Some(gesture)) = (self.trackers.get(side), self.gestures.get_mut(side))
        else {
            return Ok(Hand::ABSENT);
        };
        let Some(joints) = stage
            .space
            .locate_hand_joints(tracker, time)
            .called("xrLocateHandJointsEXT")?
        else {
            *gesture = Gesture::default();
            return Ok(Hand::ABSENT);
        };
        let known =
            xr::SpaceLocationFlags::ORIENTATION_VALID | xr::SpaceLocationFlags::POSITION_VALID;
        let joints = joints.map(|joint| {
            joint
                .location_flags
                .contains(known)
                .then(|| pose_from_raw(joint.pose))
        });
        Ok(gesture.hand(&joints, &self.params))
    }

    /// The hands are hidden: what they were doing is over.
    pub(super) fn rest(&mut self) {
        self.gestures = [Gesture::default(); 2];
    }
}
