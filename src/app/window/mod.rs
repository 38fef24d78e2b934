//! The workshop in a window of the desktop: the second door, for whoever has no headset at hand.
//!
//! ```text
//! winit ─ events ─▶ keys (what they mean) ─▶ pointer (mouse and keyboard as a hand) ─ Frame ─▶ session::run
//!                                              ▲ camera (the eye)                                │
//!                                              └──────── wire (what is under the cursor) ◀── Stagehand
//! ```
//!
//! A window is one more [`Headset`]: it gives the same frames, so world, journal, recorder and replay know nothing of it. What a mouse
//! lacks against a hand, a place in the room, it gets from the stage: after each frame the stagehand tells over the wire what lies under
//! the cursor and where the selected node is. The window draws while something moves and rests else: an idle window wakes once a second.

pub mod camera;
mod events;
mod keys;
mod play;
pub mod pointer;
mod stagehand;

use std::cell::{Cell, RefCell};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::vk;
use glam::Vec2;
use ramus_xr::frame::{LATEST, LONGEST_STEP};
use ramus_xr::{Acquired, Frame, Headset, HeadsetError, Pulse, Swapchain, Tick, View};
use winit::event_loop::EventLoop;
use winit::platform::pump_events::{EventLoopExtPumpEvents as _, PumpStatus};

use crate::app::picture::Picture;
use crate::app::session::{self, SessionEnd, Watcher};
use crate::app::workshop::Workshop;
use crate::render::{DrawnWindow, Gpu, GpuParams, RenderError, Surface, WindowHost};
use camera::{Camera, Ray};
use events::Events;
use pointer::{Act, Facts};
use stagehand::Stagehand;

pub use play::play;

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// No X11 or Wayland answers.
    #[error(
        "no desktop answers ({0}): start Ramus in a desktop session, or leave the window out with --headset simulated"
    )]
    Display(String),
    /// The desktop gives no window.
    #[error("the desktop gives no window ({0}): leave it out with --headset simulated")]
    Window(String),
    /// Vulkan is at fault.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// How often the window wakes by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowParams {
    /// Between frames while something moves; a screen that shows fewer slows it down.
    pub moving: Duration,
    /// While a message stands on the board, which goes by itself: the session's clock goes on, without pictures.
    pub told: Duration,
    /// While nothing moves: the journal is looked after.
    pub resting: Duration,
    /// Frames that are drawn after the last news: what is under the cursor is known a frame later.
    pub settling: u8,
}

impl Default for WindowParams {
    fn default() -> Self {
        Self {
            moving: Duration::from_micros(8_000),
            told: Duration::from_millis(100),
            resting: Duration::from_secs(1),
            settling: 3,
        }
    }
}

/// What the window and whoever watches its session tell each other between frames.
#[derive(Default)]
struct Wire {
    /// Of the stage, for the pointer.
    facts: Cell<Facts>,
    /// Under the cursor in this frame.
    ray: Cell<Option<Ray>>,
    /// Something moves by itself.
    moving: Cell<bool>,
    /// A message stands on the board.
    told: Cell<bool>,
    /// What keys asked for.
    wishes: Cell<Wishes>,
    /// Files that were dropped onto it.
    dropped: RefCell<Vec<PathBuf>>,
    /// Where the eye goes next.
    eye: Cell<Option<Camera>>,
    /// In a session that is played: the person looks with the window's eye, not the recorded one.
    own_eye: Cell<bool>,
}

/// What keys asked for since the last frame that was drawn.
#[derive(Clone, Copy, Debug, Default)]
struct Wishes {
    /// The picture as a file.
    picture: bool,
    /// The tree and its grammar as files.
    export: bool,
    /// The keys on the board.
    help: bool,
    /// The whole tree in view.
    tree: bool,
}

/// A window that gives frames.
pub struct WindowHeadset {
    events: Events,
    event_loop: EventLoop<()>,
    params: WindowParams,
    wire: Rc<Wire>,
    /// Whether a recorded session says what happens: no pacing and no focus of its own.
    playing: bool,
    /// When the last frame began.
    last: Instant,
    /// Seconds of the session.
    time: f64,
    /// Frames still to draw after the last news.
    settling: u8,
    /// Whether this frame is drawn.
    draws: bool,
}

/// A window with what draws into it.
pub struct Opened {
    // The picture goes first: its surface is the window's.
    picture: Picture,
    window: WindowHeadset,
    files: Files,
}

/// Where the window's keys put files.
#[derive(Clone, Debug, Default)]
pub struct Files {
    /// A picture's name without number and ending (P).
    pub picture: PathBuf,
    /// The tree (S), and beside it its grammar; none where a session is played.
    pub tree: Option<PathBuf>,
}

impl Opened {
    /// Opens a window with this title.
    ///
    /// # Errors
    /// [`OpenError`] in one sentence.
    pub fn open(title: &str, files: Files) -> Result<Self, OpenError> {
        let mut event_loop =
            EventLoop::new().map_err(|error| OpenError::Display(one_line(&error)))?;
        let wire = Rc::<Wire>::default();
        let mut events = Events::new(title, Rc::clone(&wire));
        let begun = Instant::now();
        while events.window().is_none() && begun.elapsed() < PATIENCE {
            let status = event_loop.pump_app_events(Some(PATIENCE / 10), &mut events);
            if let Some(fault) = events.take_fault() {
                return Err(OpenError::Window(fault));
            }
            if matches!(status, PumpStatus::Exit(_)) {
                break;
            }
        }
        let Some(window) = events.window() else {
            return Err(OpenError::Window("none came".to_owned()));
        };
        let window: Arc<dyn DrawnWindow> = window;
        let gpu = Gpu::new(
            &WindowHost::new(Arc::clone(&window)),
            &GpuParams::from_env(),
        )?;
        let surface = Surface::new(&gpu, window)?;
        let picture = Picture::in_window(&gpu, surface, extent(events.size()))?;
        let window = WindowHeadset {
            events,
            event_loop,
            params: WindowParams::default(),
            wire,
            playing: false,
            last: Instant::now(),
            time: 0.0,
            settling: 0,
            draws: false,
        };
        Ok(Self {
            picture,
            window,
            files,
        })
    }

    /// One line for people.
    #[must_use]
    pub fn describe(&self) -> String {
        self.window.describe()
    }

    /// Says on the board what mouse and keys do, and to whoever begins what comes first.
    pub fn welcome(workshop: &mut Workshop) {
        workshop.name_buttons(keys::buttons());
        if workshop.document().sketch.is_empty() {
            workshop.show_message(keys::BEGIN.to_owned());
        }
    }

    /// Runs a session to its end; `wrap` may put a headset around the window (a recorder, a player), which is given back with
    /// how the session ended.
    pub fn run<'a, Outer: Headset + 'a>(
        self,
        wrap: impl FnOnce(WindowHeadset) -> Outer,
        workshop: &mut Workshop,
        watcher: &mut dyn Watcher,
    ) -> (Outer, Result<(), SessionEnd>) {
        let mut stagehand = Stagehand::new(Rc::clone(&self.window.wire), self.files, watcher);
        // The picture is dropped here, before the window that it shows itself in.
        let mut headset = wrap(self.window);
        let mut picture = self.picture;
        let outcome = session::run(&mut headset, workshop, Some(&mut picture), &mut stagehand);
        drop(picture);
        (headset, outcome)
    }
}

/// Longest wait for a window.
const PATIENCE: Duration = Duration::from_secs(10);

fn one_line(error: &dyn std::fmt::Display) -> String {
    let text = error.to_string();
    // Some begin with the place in the library's source, which helps nobody here.
    let place = text.strip_prefix("os error at ");
    let said = place.and_then(|place| Some(place.split_once(".rs:")?.1.split_once(": ")?.1));
    let words = said.unwrap_or(&text).split_whitespace();
    words.collect::<Vec<_>>().join(" ")
}

/// A size in whole pixels.
fn extent(size_px: Vec2) -> vk::Extent2D {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "sizes come from whole numbers of pixels"
    )]
    let whole = |length: f32| length as u32;
    vk::Extent2D {
        width: whole(size_px.x),
        height: whole(size_px.y),
    }
}

impl WindowHeadset {
    /// Whether something moves, so that frames follow each other.
    fn is_lively(&self) -> bool {
        let pointer = self.events.pointer();
        let eye = self.wire.eye.take();
        self.wire.eye.set(eye);
        self.playing
            || eye.is_some()
            || self.settling > 0
            || self.wire.moving.get()
            || pointer.is_busy()
            || pointer.is_holding()
    }

    /// Hears events until the next frame is due.
    fn hear(&mut self) {
        let least = if self.playing {
            Duration::ZERO
        } else {
            self.params.moving
        };
        // What nobody sees needs no haste.
        let seen = self.playing || self.events.is_seen();
        let most = match (self.is_lively(), self.wire.told.get()) {
            (true, _) if seen => least,
            (false, false) => self.params.resting,
            _ => self.params.told,
        };
        let mut timeout = Duration::ZERO;
        loop {
            let status = self
                .event_loop
                .pump_app_events(Some(timeout), &mut self.events);
            if matches!(status, PumpStatus::Exit(_)) {
                self.events.close();
            }
            let news = self.events.has_news() || self.events.pointer().is_busy();
            let rest = if news { least } else { most };
            timeout = rest.saturating_sub(self.last.elapsed());
            if timeout.is_zero() || self.events.is_closed() {
                return;
            }
        }
    }

    fn frame(&mut self) -> Frame {
        let passed = self.last.elapsed().as_secs_f64().min(LONGEST_STEP);
        self.last = Instant::now();
        self.time = (self.time + passed).min(LATEST);
        let size = self.events.size();
        if let Some(eye) = self.wire.eye.take() {
            self.events.pointer_mut().take(Act::Look(eye));
        }
        let news = self.events.take_news() || self.events.pointer().is_busy();
        self.settling = if news {
            self.params.settling
        } else {
            self.settling.saturating_sub(1)
        };
        self.draws = self.is_lively();
        let facts = self.wire.facts.get();
        let pointer = self.events.pointer_mut();
        let right = pointer.step(passed, size, &facts);
        let left = pointer.left(&facts);
        self.wire.ray.set(Some(pointer.ray(size)));
        let view = pointer.camera.view(size);
        Frame {
            time: self.time,
            focused: self.playing || pointer.is_focused(),
            should_render: self.draws && self.events.is_seen(),
            head: view.pose,
            views: [view; 2],
            hands: [left, right],
        }
    }
}

impl Headset for WindowHeadset {
    fn describe(&self) -> String {
        let vk::Extent2D { width, height } = extent(self.events.size());
        format!("a window of {width} × {height} pixels")
    }

    fn extent(&self) -> vk::Extent2D {
        extent(self.events.size())
    }

    fn swapchain(&self) -> Option<&Swapchain> {
        None
    }

    fn wait(&mut self) -> Result<Tick, HeadsetError> {
        self.hear();
        if self.events.is_closed() {
            return Ok(Tick::Exit);
        }
        Ok(Tick::Frame(self.frame()))
    }

    fn begin(&mut self) -> Result<Option<Acquired>, HeadsetError> {
        // The picture's own image: the window's is asked for when there is something to show.
        Ok((self.draws && self.events.is_seen()).then_some(Acquired {
            color: 0,
            depth: None,
        }))
    }

    fn views(&mut self) -> Result<[View; 2], HeadsetError> {
        Ok([self.events.pointer().camera.view(self.events.size()); 2])
    }

    fn end(&mut self, _rendered: bool) -> Result<(), HeadsetError> {
        Ok(())
    }

    fn vibrate(&mut self, _pulse: Pulse) {}

    fn request_exit(&mut self) {
        self.events.close();
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "a table")]
    use super::one_line;

    #[test]
    fn what_a_library_says_is_one_line_without_its_source() {
        for (said, expected) in [
            (
                "os error at /a/b/mod.rs:765: neither DISPLAY is set.",
                "neither DISPLAY is set.",
            ),
            ("os error at a\n  b", "os error at a b"),
            ("two\nlines: here", "two lines: here"),
            ("os error at x.rs:1", "os error at x.rs:1"),
            ("", ""),
        ] {
            assert_eq!(one_line(&said), expected, "{said}");
        }
    }
}
