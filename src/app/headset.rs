//! The headset behind the OpenXR runtime, with a picture that is drawn into its images.

use std::cell::Cell;
use std::io::Write;
use std::rc::Rc;
use std::time::Duration;

use ramus_xr::lifecycle::FrameClock;
use ramus_xr::openxr::{ConnectError, OpenXrHeadset, StartParams, System};
use ramus_xr::record::{Player, Tape};
use ramus_xr::{Frame, Headset, HeadsetError};

use crate::app::again::{Patience, run_again};
use crate::app::picture::Picture;
use crate::app::session::{self, Nobody, SessionEnd, Watcher};
use crate::app::store::StoreError;
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
    clock: Rc<Cell<FrameClock>>,
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
        Self::start_by(system, Rc::default())
    }

    /// The same by a clock that tells the frames' times from one session to the next.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn start_by(system: System, clock: Rc<Cell<FrameClock>>) -> Result<Self, OpenError> {
        let gpu = Gpu::new(&system, &GpuParams::from_env())?;
        let params = StartParams {
            clock: Rc::clone(&clock),
            ..StartParams::new(render::NEAR)
        };
        let headset = system.start_on(Box::new(gpu.clone()), params)?;
        let Some(swapchain) = headset.swapchain() else {
            return Err(ConnectError::NoFormat.into());
        };
        let picture = Picture::in_headset(&gpu, swapchain)?;
        Ok(Self {
            picture,
            headset,
            clock,
        })
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

/// What is told of a runtime that goes and comes.
#[derive(Debug)]
pub enum News {
    /// The session was lost.
    Lost {
        /// What happened, without a way out: there may be none to take.
        why: String,
        /// Whether the project is saved as it is now; the journal holds it in any case.
        saved: Result<(), StoreError>,
        /// How long the runtime is waited for.
        wait: Duration,
    },
    /// Another one goes on with the work, on this runtime and device.
    Back(String),
}

/// Runs the workshop in the headset to its end. Where the runtime is lost, the work is saved and told, and goes on as
/// soon as a runtime answers again, with everything of headset and graphics made anew; a recording goes on with it.
///
/// # Errors
/// Where the session ended before its end, or was lost and did not come back in time.
pub fn keep_going<W: Write>(
    opened: Opened,
    tape: &mut Option<Tape<W>>,
    workshop: &mut Workshop,
    patience: &Patience,
    tell: impl Fn(News),
) -> Result<(), SessionEnd> {
    let clock = Rc::clone(&opened.clock);
    // Both closures need it, one after the other.
    let workshop = Cell::new(Some(workshop));
    run_again(
        opened,
        patience,
        |opened| {
            let Some(here) = workshop.take() else {
                return Ok(());
            };
            let outcome = match tape.take() {
                None => opened.run(|headset| headset, here, &mut Nobody).1,
                Some(rolling) => {
                    let (recorder, outcome) =
                        opened.run(|headset| rolling.around(headset), here, &mut Nobody);
                    // The lost headset goes before the next is looked for: a runtime may give only one instance.
                    *tape = Some(recorder.take_off().1);
                    outcome
                }
            };
            workshop.set(Some(here));
            outcome
        },
        || {
            let opened = Opened::start_by(connect()?, Rc::clone(&clock))?;
            tell(News::Back(opened.describe()));
            Ok::<_, OpenError>(opened)
        },
        |end, wait| {
            let Some(here) = workshop.take() else { return };
            here.let_go();
            let saved = here.save();
            workshop.set(Some(here));
            let why = match end {
                SessionEnd::Headset(HeadsetError::Lost(why)) => {
                    format!("the OpenXR runtime ended the session ({why})")
                }
                end => end.to_string(),
            };
            tell(News::Lost { why, saved, wait });
        },
    )
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
