//! What the runtime's events mean.

use ::openxr as xr;

use crate::bindings::HANDS;
use crate::lifecycle::State;
use crate::profiles::{PROFILES, Profile};

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

/// What a hand holds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Held {
    /// Whether the runtime has bound a profile to it, be it one that is not known here.
    pub(super) bound: bool,
    /// The profile, where it is known.
    pub(super) profile: Option<&'static Profile>,
}

/// The controllers that are used now; the log says what they are.
pub(super) fn controllers(session: &xr::Session<xr::Vulkan>) -> [Held; 2] {
    let instance = session.instance();
    HANDS.map(|hand| {
        let current = instance
            .string_to_path(hand)
            .and_then(|hand| session.current_interaction_profile(hand));
        let path = match current {
            Ok(xr::Path::NULL) => {
                tracing::info!("{hand}: none");
                return Held::default();
            }
            Ok(path) => instance.path_to_string(path),
            Err(code) => Err(code),
        };
        match path {
            Ok(path) => {
                tracing::info!("{hand}: {path}");
                let profile = PROFILES.iter().find(|profile| profile.path == path);
                Held {
                    bound: true,
                    profile,
                }
            }
            Err(code) => {
                tracing::warn!("{hand}: the controller is not known ({code:?})");
                Held::default()
            }
        }
    })
}
