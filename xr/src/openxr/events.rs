//! What the runtime's events mean.

use ::openxr as xr;

use crate::bindings::HANDS;
use crate::lifecycle::State;

/// States as the runtime tells them; `None` for ones that a later version may add.
pub(super) fn state_from_raw(state: xr::SessionState) -> Option<State> {
    Some(match state {
        xr::SessionState::IDLE => State::Idle,
        xr::SessionState::READY => State::Ready,
        xr::SessionState::SYNCHRONIZED => State::Synchronized,
        xr::SessionState::VISIBLE => State::Visible,
        xr::SessionState::FOCUSED => State::Focused,
        xr::SessionState::STOPPING => State::Stopping,
        xr::SessionState::LOSS_PENDING => State::LossPending,
        xr::SessionState::EXITING => State::Exiting,
        _ => return None,
    })
}

/// A success that announces a loss is one.
pub(super) fn loss(code: xr::sys::Result) -> xr::Result<()> {
    if code == xr::sys::Result::SESSION_LOSS_PENDING {
        Err(code)
    } else {
        Ok(())
    }
}

/// Says in the log which controllers are used now.
pub(super) fn report_controllers(session: &xr::Session<xr::Vulkan>) {
    let instance = session.instance();
    for hand in HANDS {
        let profile = instance
            .string_to_path(hand)
            .and_then(|hand| session.current_interaction_profile(hand))
            .and_then(|path| {
                if path == xr::Path::NULL {
                    Ok(String::from("none"))
                } else {
                    instance.path_to_string(path)
                }
            });
        match profile {
            Ok(profile) => tracing::info!("{hand}: {profile}"),
            Err(code) => tracing::warn!("{hand}: the controller is not known ({code:?})"),
        }
    }
}
