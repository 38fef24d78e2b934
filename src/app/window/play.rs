//! A recorded session in the window, at the speed at which it was recorded.
//!
//! Every recorded frame reaches the workshop, as in every replay; where drawing does not keep up, frames are not drawn. One looks with the
//! eyes of whoever was recorded, until one turns the view oneself.

use std::rc::Rc;
use std::time::{Duration, Instant};

use ramus_xr::record::Player;
use ramus_xr::{Frame, Headset, HeadsetError, Pose, Tick, View};

use super::{Opened, Wire};
use crate::app::session::{SessionEnd, Watcher};
use crate::app::workshop::Workshop;

/// So late, frames are left out.
const LATE: Duration = Duration::from_millis(30);

/// At least so often one is drawn.
const SEEN: Duration = Duration::from_millis(250);

/// Gives each frame at its time.
struct Paced<H> {
    inner: H,
    wire: Rc<Wire>,
    /// When the session's time was this one.
    begun: Option<(Instant, f64)>,
    /// When the last frame was drawn.
    drawn: Instant,
    /// Whether frames may be left out.
    skips: bool,
    /// The recorded head.
    head: Pose,
}

impl<H> Paced<H> {
    /// Waits for the frame's time; false where it is past, so that the frame need not be drawn.
    fn pace(&mut self, time: f64) -> bool {
        let now = Instant::now();
        let (begun, first) = *self.begun.get_or_insert((now, time));
        let due = begun + Duration::try_from_secs_f64(time - first).unwrap_or_default();
        std::thread::sleep(due.saturating_duration_since(now));
        let late = now.saturating_duration_since(due) > LATE;
        !late || !self.skips || self.drawn.elapsed() > SEEN
    }
}

impl<H: Headset> Headset for Paced<H> {
    ramus_xr::forward_headset!(inner: describe, extent, swapchain, begin, vibrate, device, request_exit);

    fn wait(&mut self) -> Result<Tick, HeadsetError> {
        let tick = self.inner.wait()?;
        let Tick::Frame(frame) = tick else {
            return Ok(tick);
        };
        self.head = frame.head;
        Ok(Tick::Frame(Frame {
            should_render: self.pace(frame.time) && frame.should_render,
            ..frame
        }))
    }

    fn end(&mut self, rendered: bool) -> Result<(), HeadsetError> {
        self.inner.end(rendered)?;
        if rendered {
            // From its end, or drawing that takes long would leave no time for anything else.
            self.drawn = Instant::now();
        }
        Ok(())
    }

    fn views(&mut self) -> Result<[View; 2], HeadsetError> {
        let views = self.inner.views()?;
        Ok(if self.wire.own_eye.get() {
            views
        } else {
            views.map(|view| View {
                pose: self.head,
                ..view
            })
        })
    }
}

/// Plays a session in the window; `whole`: every frame is drawn, however long that takes.
///
/// # Errors
/// Where the session ended before its end.
pub fn play(
    mut opened: Opened,
    frames: Vec<Frame>,
    whole: bool,
    workshop: &mut Workshop,
    watcher: &mut dyn Watcher,
) -> Result<(), SessionEnd> {
    opened.window.playing = true;
    let wire = Rc::clone(&opened.window.wire);
    let frames = frames.into_iter().map(Ok);
    let (paced, outcome) = opened.run(
        |window| Paced {
            inner: Player::new(window, frames),
            wire,
            begun: None,
            drawn: Instant::now(),
            skips: !whole,
            head: Pose::IDENTITY,
        },
        workshop,
        watcher,
    );
    outcome?;
    if paced.inner.is_over() {
        Ok(())
    } else {
        Err(SessionEnd::Early)
    }
}
