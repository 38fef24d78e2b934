//! Locating the eyes.

use std::ptr;

use ::openxr as xr;

use super::call::check;
use super::space::{Stage, pose_from_raw, raw_from_pose};
use super::system::STEREO;
use crate::frame::{Fov, Pose, View};
use crate::headset::HeadsetError;

/// Both eyes at `time`; `None` while the runtime does not know where they look, or says what cannot be drawn.
///
/// A headset may know how it is turned before it knows where it is: then the position stays as in `last`.
pub(super) fn locate_views(
    session: &xr::Session<xr::Vulkan>,
    stage: &Stage,
    time: xr::Time,
    last: &[View; 2],
) -> Result<Option<[View; 2]>, HeadsetError> {
    let info = xr::sys::ViewLocateInfo {
        ty: xr::sys::ViewLocateInfo::TYPE,
        next: ptr::null(),
        view_configuration_type: STEREO,
        display_time: time,
        space: stage.space.as_raw(),
    };
    let mut state = xr::sys::ViewState {
        ty: xr::sys::ViewState::TYPE,
        next: ptr::null_mut(),
        view_state_flags: xr::ViewStateFlags::EMPTY,
    };
    let empty = xr::sys::View {
        ty: xr::sys::View::TYPE,
        next: ptr::null_mut(),
        pose: raw_from_pose(Pose::IDENTITY),
        fov: xr::Fovf::default(),
    };
    let mut views = [empty; 2];
    let mut count = 0;
    // SAFETY: the session is alive, every struct is initialised and has its type, and `views` holds the two that are said.
    let code = unsafe {
        (session.instance().fp().locate_views)(
            session.as_raw(),
            &info,
            &mut state,
            2,
            &mut count,
            views.as_mut_ptr(),
        )
    };
    check("xrLocateViews", code)?;
    let flags = state.view_state_flags;
    if count != 2 || !flags.contains(xr::ViewStateFlags::ORIENTATION_VALID) {
        return Ok(None);
    }
    let mut located = *last;
    for (view, raw) in located.iter_mut().zip(&views) {
        let pose = pose_from_raw(raw.pose);
        view.pose.orientation = pose.orientation;
        if flags.contains(xr::ViewStateFlags::POSITION_VALID) {
            view.pose.position = pose.position;
        }
        view.fov = Fov {
            left: raw.fov.angle_left,
            right: raw.fov.angle_right,
            up: raw.fov.angle_up,
            down: raw.fov.angle_down,
        };
    }
    let sane = located
        .iter()
        .all(|view| view.pose.is_sane() && view.fov.is_sane());
    for view in &mut located {
        view.pose = view.pose.settled();
    }
    Ok(sane.then_some(located))
}

/// A field of view for the runtime.
pub(super) fn raw_from_fov(fov: Fov) -> xr::Fovf {
    xr::Fovf {
        angle_left: fov.left,
        angle_right: fov.right,
        angle_up: fov.up,
        angle_down: fov.down,
    }
}
