//! Recording what a headset says, and playing a recording on a real headset.
//!
//! Both are headsets around a headset, so the application needs no code for either. [`Recorder`] writes each
//! frame as the application saw it, with the views that were drawn. [`Player`] takes head, hands and time from
//! a session and everything else (views, pictures, pacing) from the headset inside: the person who wears it
//! watches somebody else's session with their own eyes.

use std::io::Write;

use ash::vk;

use crate::frame::{Frame, Hand, Pulse, View};
use crate::headset::{Acquired, Headset, HeadsetError, Swapchain, Tick};
use crate::session::{SessionError, SessionWriter};

/// Writes the session of the headset inside.
///
/// A recording that fails (a full disk, say) never ends the session: recording stops, what was written stays
/// readable, and [`Recorder::fault`] says why.
pub struct Recorder<H, W: Write> {
    inner: H,
    writer: Option<SessionWriter<W>>,
    fault: Option<SessionError>,
    /// The frame under way; written when it ends, with the views that were drawn.
    pending: Option<Frame>,
}

impl<H: Headset, W: Write> Recorder<H, W> {
    /// Records `inner` into `output` (buffer it: a frame is a few hundred bytes).
    ///
    /// # Errors
    /// [`SessionError::Io`] where the header cannot be written.
    pub fn new(inner: H, output: W) -> Result<Self, SessionError> {
        Ok(Self {
            inner,
            writer: Some(SessionWriter::new(output)?),
            fault: None,
            pending: None,
        })
    }

    /// Why recording stopped, if it did.
    #[must_use]
    pub fn fault(&self) -> Option<&SessionError> {
        self.fault.as_ref()
    }

    /// Ends the recording; gives back the headset, and the output once all is written.
    ///
    /// # Errors
    /// The [`SessionError`] that stopped the recording, or the one of writing out the rest.
    pub fn finish(mut self) -> (H, Result<W, SessionError>) {
        self.flush();
        let written = match (self.fault, self.writer) {
            (Some(fault), _) => Err(fault),
            (None, Some(writer)) => writer.finish(),
            (None, None) => Err(SessionError::TooLong),
        };
        (self.inner, written)
    }

    fn flush(&mut self) {
        let (Some(frame), Some(writer)) = (self.pending.take(), &mut self.writer) else {
            return;
        };
        if let Err(fault) = writer.write(&frame) {
            self.fault = Some(fault);
        }
        if self.fault.is_some() {
            self.writer = None;
        }
    }
}

impl<H: Headset, W: Write> Headset for Recorder<H, W> {
    fn describe(&self) -> String {
        format!("{}, recording", self.inner.describe())
    }

    fn extent(&self) -> vk::Extent2D {
        self.inner.extent()
    }

    fn swapchain(&self) -> Option<&Swapchain> {
        self.inner.swapchain()
    }

    fn wait(&mut self) -> Result<Tick, HeadsetError> {
        self.flush();
        let tick = self.inner.wait()?;
        if let Tick::Frame(frame) = tick {
            self.pending = Some(frame);
        }
        Ok(tick)
    }

    fn begin(&mut self) -> Result<Option<Acquired>, HeadsetError> {
        self.inner.begin()
    }

    fn views(&mut self) -> Result<[View; 2], HeadsetError> {
        let views = self.inner.views()?;
        if let Some(frame) = &mut self.pending {
            frame.views = views;
        }
        Ok(views)
    }

    fn end(&mut self, rendered: bool) -> Result<(), HeadsetError> {
        self.inner.end(rendered)?;
        self.flush();
        Ok(())
    }

    fn vibrate(&mut self, pulse: Pulse) {
        self.inner.vibrate(pulse);
    }

    fn request_exit(&mut self) {
        self.inner.request_exit();
    }
}

/// Plays a session's head, hands and time on the headset inside.
///
/// Every recorded frame is given exactly once, in order, whatever the device's rate, so a replay ends in the same
/// project as the session did. While the device has no focus the session stands still (no hands, time at rest);
/// after its last frame the device is asked to end.
pub struct Player<H, I> {
    inner: H,
    frames: I,
    /// The next recorded frame, read ahead.
    next: Option<Frame>,
    /// Time of the last frame given.
    time: f64,
    over: bool,
}

impl<H: Headset, I: Iterator<Item = Result<Frame, SessionError>>> Player<H, I> {
    /// Plays `frames` (a `SessionReader`, for one) on `inner`.
    ///
    /// # Errors
    /// [`SessionError`] where the first frame cannot be read.
    pub fn new(inner: H, mut frames: I) -> Result<Self, SessionError> {
        let next = frames.next().transpose()?;
        let time = next.map_or(0.0, |frame| frame.time);
        Ok(Self {
            inner,
            frames,
            next,
            time,
            over: false,
        })
    }

    /// Gives the headset back.
    #[must_use]
    pub fn into_inner(self) -> H {
        self.inner
    }
}

impl<H: Headset, I: Iterator<Item = Result<Frame, SessionError>>> Headset for Player<H, I> {
    fn describe(&self) -> String {
        format!("{}, playing a session", self.inner.describe())
    }

    fn extent(&self) -> vk::Extent2D {
        self.inner.extent()
    }

    fn swapchain(&self) -> Option<&Swapchain> {
        self.inner.swapchain()
    }

    fn wait(&mut self) -> Result<Tick, HeadsetError> {
        let device = match self.inner.wait()? {
            Tick::Frame(frame) => frame,
            tick => return Ok(tick),
        };
        if !device.focused {
            return Ok(Tick::Frame(Frame {
                time: self.time,
                hands: [Hand::ABSENT; 2],
                ..device
            }));
        }
        let Some(recorded) = self.next else {
            // The session is over. The frames until the device ends are not the session's: the application must
            // not see them, or a trigger held to the last would change the project.
            if !self.over {
                self.over = true;
                self.inner.request_exit();
            }
            self.inner.begin()?;
            self.inner.end(false)?;
            return Ok(Tick::Idle);
        };
        self.next = self.frames.next().transpose()?;
        self.time = recorded.time;
        Ok(Tick::Frame(Frame {
            should_render: device.should_render && recorded.should_render,
            views: device.views,
            ..recorded
        }))
    }

    fn begin(&mut self) -> Result<Option<Acquired>, HeadsetError> {
        self.inner.begin()
    }

    fn views(&mut self) -> Result<[View; 2], HeadsetError> {
        self.inner.views()
    }

    fn end(&mut self, rendered: bool) -> Result<(), HeadsetError> {
        self.inner.end(rendered)
    }

    fn vibrate(&mut self, pulse: Pulse) {
        self.inner.vibrate(pulse);
    }

    fn request_exit(&mut self) {
        self.inner.request_exit();
    }
}
