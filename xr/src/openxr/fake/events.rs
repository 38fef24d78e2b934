//! What `xrPollEvent` gives.

use std::ptr;

use ::openxr as xr;
use xr::sys::{self, Handle as _};

/// An event that a test scripts.
#[derive(Clone, Copy)]
pub(in crate::openxr) enum FakeEvent {
    State(xr::SessionState),
    Recentre(xr::ReferenceSpaceType, i64),
    InstanceLoss,
    Profile,
    /// The mask of a view is another one.
    Mask(u32),
    /// The display's rate is another one.
    Rate(f32),
    /// Whether somebody wears the headset.
    Worn(bool),
}

impl FakeEvent {
    /// Writes the event as it is at `time`.
    ///
    /// # Safety
    /// `out` must be writable.
    pub(super) unsafe fn write(self, time: i64, out: *mut sys::EventDataBuffer) {
        let session = sys::Session::from_raw(2);
        let now = sys::Time::from_nanos(time);
        macro_rules! put {
            ($kind:ident { $($field:ident: $value:expr),* }) => {{
                let event = sys::$kind { ty: sys::$kind::TYPE, next: ptr::null(), $($field: $value),* };
                // SAFETY: the buffer is larger than any event, and the caller vouches for it.
                unsafe { out.cast::<sys::$kind>().write(event) }
            }};
        }
        match self {
            Self::State(state) => {
                put!(EventDataSessionStateChanged {
                    session: session,
                    state: state,
                    time: now
                });
            }
            Self::Recentre(kind, at) => put!(EventDataReferenceSpaceChangePending {
                session: session,
                reference_space_type: kind,
                change_time: sys::Time::from_nanos(at),
                pose_valid: sys::FALSE,
                pose_in_previous_space: xr::Posef::IDENTITY
            }),
            Self::InstanceLoss => put!(EventDataInstanceLossPending { loss_time: now }),
            Self::Profile => put!(EventDataInteractionProfileChanged { session: session }),
            Self::Mask(view) => put!(EventDataVisibilityMaskChangedKHR {
                session: session,
                view_configuration_type: xr::ViewConfigurationType::PRIMARY_STEREO,
                view_index: view
            }),
            Self::Rate(rate) => put!(EventDataDisplayRefreshRateChangedFB {
                from_display_refresh_rate: 0.0,
                to_display_refresh_rate: rate
            }),
            Self::Worn(worn) => put!(EventDataUserPresenceChangedEXT {
                session: session,
                is_user_present: worn.into()
            }),
        }
    }
}
