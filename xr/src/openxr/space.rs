//! The stage's frame, and poses in it.

use ::openxr as xr;
use glam::{Quat, Vec3};

use super::call::Called as _;
use crate::frame::{EYE_HEIGHT, Pose};
use crate::headset::HeadsetError;

/// The space that stands for the stage: floor at 0, −Z ahead of the person.
///
/// A recentring moves its origin under the person: the runtime gives every pose from then on in the new frame, and
/// the scene, which is fixed to it, stands before the person again.
pub(super) struct Stage {
    pub(super) space: xr::Space,
    /// The kind of reference space, to tell whose recentring is announced.
    pub(super) kind: xr::ReferenceSpaceType,
}

impl Stage {
    /// LOCAL_FLOOR where it exists; else STAGE, whose floor is right but which is not recentred on the person; else
    /// LOCAL, whose origin is at the eyes, lowered by a person's eye height.
    pub(super) fn new(
        session: &xr::Session<xr::Vulkan>,
        local_floor: bool,
    ) -> Result<Self, HeadsetError> {
        let offered = session
            .enumerate_reference_spaces()
            .called("xrEnumerateReferenceSpaces")?;
        let has = |kind| offered.contains(&kind);
        let (kind, floor) = if local_floor && has(xr::ReferenceSpaceType::LOCAL_FLOOR) {
            (xr::ReferenceSpaceType::LOCAL_FLOOR, 0.0)
        } else if has(xr::ReferenceSpaceType::STAGE) {
            (xr::ReferenceSpaceType::STAGE, 0.0)
        } else {
            (xr::ReferenceSpaceType::LOCAL, -EYE_HEIGHT)
        };
        let origin = Pose {
            position: Vec3::new(0.0, floor, 0.0),
            ..Pose::IDENTITY
        };
        let space = session
            .create_reference_space(kind, raw_from_pose(origin))
            .called("xrCreateReferenceSpace")?;
        Ok(Self { space, kind })
    }
}

/// Where `space` is in the stage at `time`; `None` while it is not known or not sane.
pub(super) fn locate(
    space: &xr::Space,
    stage: &Stage,
    time: xr::Time,
) -> Result<Option<Pose>, HeadsetError> {
    let location = space.locate(&stage.space, time).called("xrLocateSpace")?;
    let known = xr::SpaceLocationFlags::ORIENTATION_VALID | xr::SpaceLocationFlags::POSITION_VALID;
    let pose = pose_from_raw(location.pose);
    Ok((location.location_flags.contains(known) && pose.is_sane()).then(|| pose.settled()))
}

pub(super) fn pose_from_raw(raw: xr::Posef) -> Pose {
    let (turn, place) = (raw.orientation, raw.position);
    Pose {
        orientation: Quat::from_xyzw(turn.x, turn.y, turn.z, turn.w),
        position: Vec3::new(place.x, place.y, place.z),
    }
}

pub(super) fn raw_from_pose(pose: Pose) -> xr::Posef {
    let (turn, place) = (pose.orientation, pose.position);
    xr::Posef {
        orientation: xr::Quaternionf {
            x: turn.x,
            y: turn.y,
            z: turn.z,
            w: turn.w,
        },
        position: xr::Vector3f {
            x: place.x,
            y: place.y,
            z: place.z,
        },
    }
}
