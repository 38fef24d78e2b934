//! The headset behind the OpenXR runtime, with a picture that is drawn into its images.

use ramus_xr::openxr::{ConnectError, OpenXrHeadset, StartParams, System};
use ramus_xr::record::Player;
use ramus_xr::{Frame, Headset};

use crate::app::picture::Picture;
use crate::app::session::{self, SessionEnd, Watcher};
use crate::app::workshop::Workshop;
use crate::render::{self, Gpu, GpuParams, RenderError};

/// Why the headset could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The runtime or the headset is at fault.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// Vulkan is.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// The program's version as one number, for the runtime's books.
const VERSION: u32 = 1;

/// A headset with a session, and what draws for it.
pub struct Opened {
    // The picture goes first: its views show the headset's images.
    picture: Picture,
    headset: OpenXrHeadset,
}

/// Reaches the active runtime and its headset, without starting anything.
///
/// # Errors
/// [`ConnectError`] in one sentence.
pub fn connect() -> Result<System, ConnectError> {
    ramus_xr::openxr::connect(VERSION)
}

impl Opened {
    /// Reaches the headset and starts a session on it.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn connect() -> Result<Self, OpenError> {
        Self::start(connect()?)
    }

    /// Makes Vulkan's device through the runtime and starts a session on it.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn start(system: System) -> Result<Self, OpenError> {
        let gpu = Gpu::new(&system, &GpuParams::from_env())?;
        let headset = system.start_on(Box::new(gpu.clone()), StartParams::new(render::NEAR))?;
        let Some(swapchain) = headset.swapchain() else {
            return Err(ConnectError::NoFormat.into());
        };
        let picture = Picture::in_headset(&gpu, swapchain)?;
        Ok(Self { picture, headset })
    }

    /// One line for people: runtime and device.
    #[must_use]
    pub fn describe(&self) -> String {
        self.headset.describe()
    }

    /// Runs a session to its end; `wrap` may put a headset around the headset (a recorder, a player), which is given
    /// back with how the session ended.
    pub fn run<'a, Outer: Headset + 'a>(
        self,
        wrap: impl FnOnce(OpenXrHeadset) -> Outer,
        workshop: &mut Workshop,
        watcher: &mut dyn Watcher,
    ) -> (Outer, Result<(), SessionEnd>) {
        // The picture is dropped here, before the headset whose images it shows.
        let mut headset = wrap(self.headset);
        let mut picture = self.picture;
        let outcome = session::run(&mut headset, workshop, Some(&mut picture), watcher);
        drop(picture);
        (headset, outcome)
    }
}

/// Plays a session's head and hands on the headset.
///
/// # Errors
/// Where the session ended before its end.
pub fn play(
    opened: Opened,
    frames: Vec<Frame>,
    workshop: &mut Workshop,
    watcher: &mut dyn Watcher,
) -> Result<(), SessionEnd> {
    let frames = frames.into_iter().map(Ok);
    let (player, outcome) = opened.run(|headset| Player::new(headset, frames), workshop, watcher);
    outcome?;
    if player.is_over() {
        Ok(())
    } else {
        Err(SessionEnd::Early)
    }
}
