//! What happened since the last frame: events, and what they demand.

use ::openxr as xr;

use super::OpenXrHeadset;
use crate::headset::HeadsetError;
use crate::lifecycle::{Demand, State};
use crate::openxr::call::Called as _;
use crate::openxr::system::STEREO;
use crate::openxr::{events, mask, refresh};

impl OpenXrHeadset {
    /// Deals with everything that happened since the last frame.
    pub(super) fn poll(&mut self) -> Result<(), HeadsetError> {
        loop {
            let event = match self
                .instance
                .poll_event(&mut self.events)
                .called("xrPollEvent")?
            {
                None => return Ok(()),
                Some(event) => event,
            };
            match event {
                xr::Event::SessionStateChanged(change) => {
                    if let Some(state) = events::state_from_raw(change.state()) {
                        tracing::debug!("the session is {state:?}");
                        self.enter(state)?;
                    }
                }
                xr::Event::InstanceLossPending(_) => {
                    return Err(HeadsetError::Lost(String::from("it is shutting down")));
                }
                xr::Event::ReferenceSpaceChangePending(change)
                    if change.reference_space_type() == self.stage.kind =>
                {
                    self.recentred_at = Some(change.change_time());
                }
                xr::Event::InteractionProfileChanged(_) => {
                    self.held = events::controllers(&self.session);
                }
                xr::Event::VisibilityMaskChangedKHR(change)
                    if change.view_configuration_type() == STEREO =>
                {
                    let view = usize::try_from(change.view_index()).unwrap_or(usize::MAX);
                    mask::update(&self.session, view, &mut self.mask)?;
                }
                xr::Event::DisplayRefreshRateChangedFB(change) => {
                    self.refresh_rate = refresh::sane(change.to_display_refresh_rate());
                    tracing::debug!("the display runs at {:?} Hz", self.refresh_rate);
                }
                xr::Event::UserPresenceChangedEXT(change) => {
                    self.worn = change.is_user_present();
                    tracing::debug!("somebody wears the headset: {}", self.worn);
                }
                xr::Event::EventsLost(lost) => {
                    tracing::warn!("the runtime dropped {} events", lost.lost_event_count());
                }
                _ => {}
            }
        }
    }

    fn enter(&mut self, state: State) -> Result<(), HeadsetError> {
        match self.lifecycle.enter(state) {
            Demand::Nothing => {}
            Demand::Begin => {
                self.session
                    .begin(STEREO)
                    .and_then(events::loss)
                    .called("xrBeginSession")?;
                self.lifecycle.begun();
            }
            Demand::End => {
                self.session
                    .end()
                    .and_then(events::loss)
                    .called("xrEndSession")?;
                self.lifecycle.ended();
            }
            Demand::Exit => self.exit = true,
            Demand::Lose => {
                return Err(HeadsetError::Lost(String::from(
                    "it announced the loss of the session",
                )));
            }
        }
        Ok(())
    }
}
