//! The display's refresh rate, where an application may choose it (XR_FB_display_refresh_rate).

use ::openxr as xr;

use super::call::Called as _;
use crate::headset::HeadsetError;
use crate::refresh::{RefreshWish, choose};

/// Asks for the rate that is wished for; gives the one at which the display runs for now. The change comes as an event.
pub(super) fn request(
    session: &xr::Session<xr::Vulkan>,
    wish: RefreshWish,
) -> Result<Option<f32>, HeadsetError> {
    match try_to(session, wish) {
        Err(HeadsetError::Failed(why)) => {
            // Any rate shows the workshop.
            tracing::warn!("the refresh rate stays as it is: {why}");
            Ok(None)
        }
        asked => asked,
    }
}

fn try_to(
    session: &xr::Session<xr::Vulkan>,
    wish: RefreshWish,
) -> Result<Option<f32>, HeadsetError> {
    let offered = session
        .enumerate_display_refresh_rates()
        .called("xrEnumerateDisplayRefreshRatesFB")?;
    let now = session
        .get_display_refresh_rate()
        .called("xrGetDisplayRefreshRateFB")?;
    if let Some(rate) = choose(&offered, wish).filter(|rate| *rate != now) {
        session
            .request_display_refresh_rate(rate)
            .called("xrRequestDisplayRefreshRateFB")?;
        tracing::debug!("{rate} Hz of {offered:?} were asked for, instead of {now}");
    }
    Ok(sane(now))
}

/// A rate that can be told to people.
pub(super) fn sane(rate: f32) -> Option<f32> {
    (rate.is_finite() && rate > 0.0).then_some(rate)
}
