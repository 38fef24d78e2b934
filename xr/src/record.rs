//! Recording what a headset says, and playing a recording on a real headset.
//!
//! Both are headsets around a headset, so the application needs no code for either. [`Recorder`] writes each
//! frame as the application saw it, with the views that were drawn. [`Player`] takes head, hands and time from
//! a session and everything else (views, pictures, pacing) from the headset inside: the person who wears it
//! watches somebody else's session with their own eyes.

use std::io::Write;

use crate::frame::{Frame, Hand, View};
use crate::headset::{Headset, HeadsetError, Tick};
use crate::session::{SessionError, SessionWriter};

/// Writes the session of the headset inside.
///
/// A recording that fails (a full disk, say) never ends the session: recording stops, what was written stays
/// readable, and [`Recorder::fault`] says why.
pub struct Recorder<H, W: Write> {
    inner: H,
    tape: Tape<W>,
}

/// A recording by itself, between one headset and the next: where a headset is lost, the recording goes on with the one
/// that comes back.
pub struct Tape<W: Write> {
    writer: Option<SessionWriter<W>>,
    fault: Option<SessionError>,
    /// The frame under way; written when it ends, with the views that were drawn.
    pending: Option<Frame>,
}

impl<W: Write> Tape<W> {
    /// A recording into `output` (buffer it: a frame is a few hundred bytes).
    pub fn new(output: W) -> Self {
        let (writer, fault) = match SessionWriter::new(output) {
            Ok(writer) => (Some(writer), None),
            Err(fault) => (None, Some(fault)),
        };
        Self {
            writer,
            fault,
            pending: None,
        }
    }

    /// Writes a comment into the recording.
    #[must_use]
    pub fn with_comment(mut self, text: &str) -> Self {
        if let Some(writer) = &mut self.writer
            && let Err(fault) = writer.comment(text)
        {
            self.fault = Some(fault);
            self.writer = None;
        }
        self
    }

    /// Goes on with a headset, whose time goes on where the last one's stopped.
    pub fn around<H: Headset>(self, inner: H) -> Recorder<H, W> {
        Recorder { inner, tape: self }
    }

    /// Ends the recording; gives back the output once all is written.
    ///
    /// # Errors
    /// The [`SessionError`] that stopped the recording, or the one of writing out the rest.
    pub fn finish(mut self) -> Result<W, SessionError> {
        self.flush();
        match (self.fault, self.writer) {
            (Some(fault), _) => Err(fault),
            (None, Some(writer)) => writer.finish(),
            (None, None) => Err(SessionError::TooLong),
        }
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

impl<H: Headset, W: Write> Recorder<H, W> {
    /// Records `inner` into `output` (buffer it: a frame is a few hundred bytes).
    pub fn new(inner: H, output: W) -> Self {
        Tape::new(output).around(inner)
    }

    /// Why recording stopped, if it did.
    #[must_use]
    pub fn fault(&self) -> Option<&SessionError> {
        self.tape.fault.as_ref()
    }

    /// Takes the recording off its headset, which has come to its end.
    pub fn take_off(mut self) -> (H, Tape<W>) {
        self.tape.flush();
        (self.inner, self.tape)
    }

    /// Ends the recording; gives back the headset, and the output once all is written.
    ///
    /// # Errors
    /// As [`Tape::finish`].
    pub fn finish(self) -> (H, Result<W, SessionError>) {
        let (headset, tape) = self.take_off();
        (headset, tape.finish())
    }
}

impl<H: Headset, W: Write> Headset for Recorder<H, W> {
    crate::forward_headset!(inner: extent, swapchain, begin, vibrate, device, rate, request_exit);

    fn describe(&self) -> String {
        format!("{}, recording", self.inner.describe())
    }

    fn wait(&mut self) -> Result<Tick, HeadsetError> {
        self.tape.flush();
        let tick = self.inner.wait()?;
        if let Tick::Frame(frame) = tick {
            self.tape.pending = Some(frame);
        }
        Ok(tick)
    }

    fn views(&mut self) -> Result<[View; 2], HeadsetError> {
        let views = self.inner.views()?;
        if let Some(frame) = &mut self.tape.pending {
            frame.views = views;
        }
        Ok(views)
    }

    fn end(&mut self, rendered: bool) -> Result<(), HeadsetError> {
        self.inner.end(rendered)?;
        self.tape.flush();
        Ok(())
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
    /// The next recorded frame, read ahead: time stands at it until the device has the focus.
    next: Option<Result<Frame, SessionError>>,
    /// Time of the last frame given.
    time: f64,
    over: bool,
}

impl<H: Headset, I: Iterator<Item = Result<Frame, SessionError>>> Player<H, I> {
    /// Plays `frames` (a `SessionReader`, for one) on `inner`; an error in them comes out of `wait` in its turn.
    #[must_use]
    pub fn new(inner: H, mut frames: I) -> Self {
        let next = frames.next();
        let time = match &next {
            Some(Ok(frame)) => frame.time,
            _ => 0.0,
        };
        Self {
            inner,
            frames,
            next,
            time,
            over: false,
        }
    }

    /// Whether every recorded frame was given.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.next.is_none()
    }

    /// Gives the headset back.
    #[must_use]
    pub fn into_inner(self) -> H {
        self.inner
    }
}

impl<H: Headset, I: Iterator<Item = Result<Frame, SessionError>>> Headset for Player<H, I> {
    crate::forward_headset!(inner: extent, swapchain, begin, views, end, vibrate, device, request_exit);

    fn describe(&self) -> String {
        format!("{}, playing a session", self.inner.describe())
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
        let Some(recorded) = self.next.take() else {
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
        let recorded = recorded?;
        self.next = self.frames.next();
        self.time = recorded.time;
        Ok(Tick::Frame(Frame {
            should_render: device.should_render && recorded.should_render,
            views: device.views,
            ..recorded
        }))
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "tests say what they expect by their names"
    )]

    use std::io;

    use ash::vk;
    use glam::Vec3;

    use super::*;
    use crate::frame::{Fov, Pose};
    use crate::session::{SessionReader, from_bytes, to_bytes};
    use crate::simulated::Simulated;

    const EXTENT: vk::Extent2D = vk::Extent2D {
        width: 64,
        height: 48,
    };

    /// A session whose right hand moves and pulls the trigger to the last.
    fn session() -> Vec<Frame> {
        (0..6u8)
            .map(|at| {
                let pose = Pose {
                    position: Vec3::new(0.1 * f32::from(at), 1.0, -0.3),
                    ..Pose::IDENTITY
                };
                let hand = Hand {
                    tracked: true,
                    aim: pose,
                    grip: pose,
                    trigger: 1.0,
                    ..Hand::ABSENT
                };
                Frame {
                    time: f64::from(at) * 0.01,
                    hands: [Hand::ABSENT, hand],
                    ..Frame::start()
                }
            })
            .collect()
    }

    /// A device of its own rate and eyes, without focus at first and in the middle.
    fn device(count: usize) -> Vec<Frame> {
        let views = [-0.03, 0.03].map(|x| View {
            pose: Pose {
                position: Vec3::new(x, 1.7, 0.0),
                ..Pose::IDENTITY
            },
            fov: Fov {
                left: -0.9,
                ..Fov::SQUARE
            },
        });
        (0..count)
            .map(|at| Frame {
                time: at as f64 * 0.05,
                focused: !matches!(at, 0 | 1 | 4),
                views,
                ..Frame::start()
            })
            .collect()
    }

    /// What an application would see, with the rounds run as it would run them.
    fn run(headset: &mut impl Headset) -> Vec<Frame> {
        let mut seen = Vec::new();
        for _ in 0..1000 {
            match headset.wait().unwrap() {
                Tick::Frame(frame) => {
                    headset.begin().unwrap();
                    let views = headset.views().unwrap();
                    seen.push(Frame { views, ..frame });
                    headset.end(frame.should_render).unwrap();
                }
                Tick::Idle => {}
                Tick::Exit => return seen,
            }
        }
        panic!("the headset never ends");
    }

    #[test]
    fn a_recording_is_what_the_application_saw() {
        let mut recorder = Recorder::new(Simulated::new(session(), EXTENT), Vec::new());
        let seen = run(&mut recorder);
        assert!(recorder.fault().is_none());
        let (_, bytes) = recorder.finish();
        assert_eq!(bytes.unwrap(), to_bytes(&seen).unwrap());
        assert_eq!(seen, session());
    }

    #[test]
    fn a_frame_under_way_is_recorded_too() {
        let mut recorder = Recorder::new(Simulated::new(session(), EXTENT), Vec::new());
        recorder.wait().unwrap();
        let (_, bytes) = recorder.finish();
        assert_eq!(from_bytes(&bytes.unwrap()).unwrap(), session()[..1]);
    }

    #[test]
    fn a_full_disk_ends_the_recording_and_not_the_session() {
        struct Full(usize);
        impl Write for Full {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                self.0 = self
                    .0
                    .checked_sub(bytes.len())
                    .ok_or_else(|| io::Error::other("no space left"))?;
                Ok(bytes.len())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let mut recorder = Recorder::new(Simulated::new(session(), EXTENT), Full(100));
        assert_eq!(run(&mut recorder).len(), session().len());
        assert!(
            recorder
                .fault()
                .unwrap()
                .to_string()
                .contains("no space left")
        );
        assert!(recorder.finish().1.is_err());
    }

    #[test]
    fn a_player_gives_every_recorded_frame_once_whatever_the_device_does() {
        let inner = Simulated::new(device(40), EXTENT);
        let mut player = Player::new(inner, session().into_iter().map(Ok));
        let seen = run(&mut player);
        let own = device(1)[0].views;
        assert!(
            seen.iter().all(|frame| frame.views == own),
            "the eyes are the device's"
        );
        assert!(seen.windows(2).all(|pair| pair[0].time <= pair[1].time));
        let played: Vec<Frame> = seen.iter().copied().filter(|frame| frame.focused).collect();
        let expected: Vec<Frame> = session()
            .into_iter()
            .map(|frame| Frame {
                views: own,
                ..frame
            })
            .collect();
        assert_eq!(played, expected);
        assert!(player.is_over());
        // A device that ends first leaves some of the session unplayed.
        let mut cut = Player::new(
            Simulated::new(device(5), EXTENT),
            session().into_iter().map(Ok),
        );
        run(&mut cut);
        assert!(!cut.is_over());
        let held = seen.iter().filter(|frame| !frame.focused);
        assert_eq!(held.clone().count(), 3);
        assert!(
            held.into_iter()
                .all(|frame| frame.hands == [Hand::ABSENT; 2])
        );
        // The device was left in good order: every frame that it gave was begun and ended.
        let inner = player.into_inner();
        assert_eq!(inner.waited(), session().len() + 3 + 1);
    }

    #[test]
    fn a_player_stops_at_the_sessions_error_and_plays_an_empty_session() {
        let text = b"ramus-session 1\nframe 0\nframe 0.01\nleft trigger 2\n";
        let mut player = Player::new(
            Simulated::new(device(40), EXTENT),
            SessionReader::new(&text[..]).unwrap(),
        );
        let mut rounds = 0;
        let error = loop {
            match player.wait() {
                Ok(_) => {
                    player.begin().unwrap();
                    player.end(true).unwrap();
                    rounds += 1;
                }
                Err(error) => break error,
            }
        };
        assert!(
            error.to_string().contains("line 4") && rounds == 3,
            "{error} after {rounds}"
        );
        let mut empty = Player::new(Simulated::new(device(40), EXTENT), std::iter::empty());
        assert!(run(&mut empty).iter().all(|frame| !frame.focused));
    }
}
