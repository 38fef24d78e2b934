//! The built-in headset: plays a recorded session without any device.
//!
//! It gives one recorded frame for each `wait` and never sleeps, so a run is as fast as the machine and
//! the same every time. There are no runtime images: the application draws into its own. It is strict
//! about the order of calls (as a runtime is), so that a wrong frame loop fails here first.

use std::fmt;

use ash::vk;

use crate::frame::{Frame, Pulse, View};
use crate::headset::{Acquired, Headset, HeadsetError, Tick};
use crate::session::SessionError;
use crate::vulkan::Swapchain;

/// A vibration that was asked for, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Felt {
    /// Number of the frame, from 0.
    pub frame: usize,
    /// What was asked for.
    pub pulse: Pulse,
}

/// Most vibrations that are kept for tests.
const MAX_FELT: usize = 65_536;

/// Plays recorded frames.
pub struct Simulated {
    frames: Box<dyn Iterator<Item = Result<Frame, SessionError>>>,
    extent: vk::Extent2D,
    now: Option<Frame>,
    stage: Stage,
    waited: usize,
    rendered: usize,
    felt: Vec<Felt>,
    exit: bool,
}

/// Where in the round of calls the application is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Ended,
    Waited,
    Begun,
}

impl Simulated {
    /// Plays these frames; `extent` is the size of one eye's picture in pixels.
    #[must_use]
    pub fn new<I>(frames: I, extent: vk::Extent2D) -> Self
    where
        I: IntoIterator<Item = Frame>,
        I::IntoIter: 'static,
    {
        Self::from_session(frames.into_iter().map(Ok), extent)
    }

    /// Plays a session as it is read (a `SessionReader`, for one); its errors come out of `wait`.
    #[must_use]
    pub fn from_session<I>(frames: I, extent: vk::Extent2D) -> Self
    where
        I: Iterator<Item = Result<Frame, SessionError>> + 'static,
    {
        Self {
            frames: Box::new(frames),
            extent,
            now: None,
            stage: Stage::Ended,
            waited: 0,
            rendered: 0,
            felt: Vec::new(),
            exit: false,
        }
    }

    /// The vibrations so far.
    #[must_use]
    pub fn felt(&self) -> &[Felt] {
        &self.felt
    }

    /// How many frames were waited for.
    #[must_use]
    pub fn waited(&self) -> usize {
        self.waited
    }

    /// How many frames were ended with a picture.
    #[must_use]
    pub fn rendered(&self) -> usize {
        self.rendered
    }

    /// Goes on from one call of a round to the next.
    fn step(&mut self, from: Stage, to: Stage, call: &str) -> Result<(), HeadsetError> {
        if self.stage != from {
            let stage = self.stage;
            return Err(HeadsetError::Failed(format!(
                "{call} was called out of order (the frame is {stage}); this is a fault of the program, please report it"
            )));
        }
        self.stage = to;
        Ok(())
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ended => "not begun",
            Self::Waited => "waited for",
            Self::Begun => "begun",
        })
    }
}

impl Headset for Simulated {
    fn describe(&self) -> String {
        format!(
            "simulated headset, {} × {} pixels an eye",
            self.extent.width, self.extent.height
        )
    }

    fn extent(&self) -> vk::Extent2D {
        self.extent
    }

    fn swapchain(&self) -> Option<&Swapchain> {
        None
    }

    fn wait(&mut self) -> Result<Tick, HeadsetError> {
        self.step(Stage::Ended, Stage::Ended, "wait")?;
        if self.exit {
            return Ok(Tick::Exit);
        }
        match self.frames.next() {
            Some(Ok(frame)) => {
                self.stage = Stage::Waited;
                self.waited += 1;
                self.now = Some(frame);
                Ok(Tick::Frame(frame))
            }
            Some(Err(error)) => {
                self.exit = true;
                Err(error.into())
            }
            None => {
                self.exit = true;
                Ok(Tick::Exit)
            }
        }
    }

    fn begin(&mut self) -> Result<Option<Acquired>, HeadsetError> {
        self.step(Stage::Waited, Stage::Begun, "begin")?;
        Ok(None)
    }

    fn views(&mut self) -> Result<[View; 2], HeadsetError> {
        self.step(Stage::Begun, Stage::Begun, "views")?;
        self.now
            .map(|frame| frame.views)
            .ok_or_else(|| HeadsetError::Failed("there is no frame".into()))
    }

    fn end(&mut self, rendered: bool) -> Result<(), HeadsetError> {
        self.step(Stage::Begun, Stage::Ended, "end")?;
        self.rendered += usize::from(rendered);
        Ok(())
    }

    fn vibrate(&mut self, pulse: Pulse) {
        let focused = self.now.is_some_and(|frame| frame.focused);
        if focused && self.felt.len() < MAX_FELT {
            self.felt.push(Felt {
                frame: self.waited.saturating_sub(1),
                pulse,
            });
        }
    }

    fn request_exit(&mut self) {
        self.exit = true;
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "tests say what they expect by their names"
    )]

    use super::*;
    use crate::session::SessionReader;

    const EXTENT: vk::Extent2D = vk::Extent2D {
        width: 64,
        height: 48,
    };

    fn frames(count: usize) -> Vec<Frame> {
        (0..count)
            .map(|at| Frame {
                time: at as f64 / 90.0,
                focused: at != 1,
                ..Frame::start()
            })
            .collect()
    }

    #[test]
    fn gives_each_frame_once_and_then_exits() {
        let recorded = frames(3);
        let mut headset = Simulated::new(recorded.clone(), EXTENT);
        assert_eq!(headset.extent(), EXTENT);
        assert!(headset.swapchain().is_none());
        for frame in &recorded {
            assert_eq!(headset.wait().unwrap(), Tick::Frame(*frame));
            assert_eq!(headset.begin().unwrap(), None);
            assert_eq!(headset.views().unwrap(), frame.views);
            headset.end(frame.should_render).unwrap();
        }
        assert_eq!(headset.wait().unwrap(), Tick::Exit);
        assert_eq!(headset.wait().unwrap(), Tick::Exit);
        assert_eq!((headset.waited(), headset.rendered()), (3, 3));
    }

    #[test]
    fn calls_out_of_order_fail_and_change_nothing() {
        let mut headset = Simulated::new(frames(2), EXTENT);
        assert!(headset.begin().is_err() && headset.end(true).is_err() && headset.views().is_err());
        headset.wait().unwrap();
        assert!(headset.wait().is_err() && headset.end(true).is_err());
        headset.begin().unwrap();
        assert!(headset.begin().is_err() && headset.wait().is_err());
        headset.end(true).unwrap();
        assert!(matches!(headset.wait().unwrap(), Tick::Frame(_)));
        assert_eq!(headset.waited(), 2);
    }

    #[test]
    fn vibrations_are_felt_only_while_focused() {
        let mut headset = Simulated::new(frames(3), EXTENT);
        let pulse = Pulse {
            hand: 1,
            duration: 0.02,
            amplitude: 0.5,
        };
        headset.vibrate(pulse);
        while let Tick::Frame(_) = headset.wait().unwrap() {
            headset.begin().unwrap();
            headset.vibrate(pulse);
            headset.end(false).unwrap();
        }
        assert_eq!(
            headset.felt(),
            [Felt { frame: 0, pulse }, Felt { frame: 2, pulse }]
        );
        assert_eq!(headset.rendered(), 0);
    }

    #[test]
    fn exits_when_asked_and_ends_a_broken_session_with_its_error() {
        let mut headset = Simulated::new(frames(5), EXTENT);
        headset.request_exit();
        assert_eq!(headset.wait().unwrap(), Tick::Exit);
        let reader =
            SessionReader::new(&b"ramus-session 1\nframe 0\nframe 0.01\nframe x\n"[..]).unwrap();
        let mut headset = Simulated::from_session(reader, EXTENT);
        assert!(matches!(headset.wait().unwrap(), Tick::Frame(_)));
        headset.begin().unwrap();
        headset.end(true).unwrap();
        let error = headset.wait().unwrap_err();
        assert!(error.to_string().contains("line 4"), "{error}");
        assert_eq!(headset.wait().unwrap(), Tick::Exit);
    }
}
