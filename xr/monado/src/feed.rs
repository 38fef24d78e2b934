//! Plays a session through the real runtime: every recorded frame is sent to the remote driver, and the frame that the
//! application gets is what the runtime then says.
//!
//! [`Fed`] is a headset around a headset. Before each frame it sends the next packet and goes on to wait for frames of
//! the device until hands and head are as sent, so the application sees each recorded frame exactly once and in order,
//! whatever the runtime's rate and however long a packet takes. Frames that come too early (the driver copies packets
//! without a lock, so they can even be half old) are ended empty and never shown to the application.

use ramus_xr::frame::LONGEST_STEP;
use ramus_xr::{Frame, Hand, Headset, HeadsetError, Pose, Tick};

use crate::remote::{Packet, Remote};

/// Most frames of the device until a packet must have arrived: some 20 s on the null compositor.
const PATIENCE: usize = 400;

/// How much the runtime changes an orientation: it normalises the quaternion once more, which moves the last bits
/// where its length was not exactly 1. Everything else arrives to the bit.
const LAST_BITS: f32 = 1e-6;

/// Feeds a session to the remote driver and gives what the headset inside says of it.
pub struct Fed<H, I> {
    inner: H,
    remote: Remote,
    frames: I,
    over: bool,
    /// The runtime's time and the application's of the last frame: frames that are passed over on a busy machine are no leap.
    times: Option<(f64, f64)>,
}

impl<H: Headset, I: Iterator<Item = Frame>> Fed<H, I> {
    /// Plays `frames` through `remote`, the driver of the runtime behind `inner`.
    pub fn new(inner: H, remote: Remote, frames: I) -> Self {
        Self {
            inner,
            remote,
            frames,
            over: false,
            times: None,
        }
    }

    /// Ends a frame of the device that the application does not see.
    fn pass_over(&mut self) -> Result<(), HeadsetError> {
        self.inner.begin()?;
        self.inner.end(false)
    }
}

/// Whether the runtime says what was sent: hands and head, in all that matters of a hand that is tracked or not.
pub fn arrived(seen: &Frame, sent: &Frame) -> bool {
    let near = |seen: Pose, sent: Pose| {
        let apart = seen
            .orientation
            .to_array()
            .into_iter()
            .zip(sent.orientation.to_array());
        seen.position == sent.position
            && apart
                .into_iter()
                .all(|(seen, sent)| (seen - sent).abs() <= LAST_BITS)
    };
    let hands = seen.hands.iter().zip(&sent.hands).all(|(seen, sent)| {
        let values = |hand: &Hand| {
            (
                hand.trigger,
                hand.squeeze,
                hand.stick,
                hand.lower,
                hand.upper,
            )
        };
        seen.tracked == sent.tracked
            && (!sent.tracked
                || (values(seen) == values(sent)
                    && near(seen.aim, sent.aim)
                    && near(seen.grip, sent.grip)))
    });
    hands && near(seen.head, sent.head)
}

impl<H: Headset, I: Iterator<Item = Frame>> Headset for Fed<H, I> {
    ramus_xr::forward_headset!(inner: extent, swapchain, begin, views, end, vibrate, device, request_exit);

    fn describe(&self) -> String {
        format!("{}, fed by the remote driver", self.inner.describe())
    }

    fn wait(&mut self) -> Result<Tick, HeadsetError> {
        let sent = if self.over { None } else { self.frames.next() };
        let Some(sent) = sent else {
            if !self.over {
                self.over = true;
                self.inner.request_exit();
            }
            return match self.inner.wait()? {
                Tick::Frame(_) => self.pass_over().map(|()| Tick::Idle),
                tick => Ok(tick),
            };
        };
        let failed = |error: &dyn std::error::Error| HeadsetError::Failed(error.to_string());
        let packet = Packet::from_frame(&sent).map_err(|error| failed(&error))?;
        self.remote.send(&packet).map_err(|error| failed(&error))?;
        for _ in 0..PATIENCE {
            match self.inner.wait()? {
                Tick::Frame(seen) if seen.focused && arrived(&seen, &sent) => {
                    // What the session says without a device's help.
                    let hands = if sent.focused {
                        seen.hands
                    } else {
                        [Hand::ABSENT; 2]
                    };
                    let (before, given) = self.times.unwrap_or((seen.time, seen.time));
                    let time = given + (seen.time - before).clamp(0.0, LONGEST_STEP);
                    self.times = Some((seen.time, time));
                    return Ok(Tick::Frame(Frame {
                        time,
                        focused: sent.focused,
                        hands,
                        ..seen
                    }));
                }
                Tick::Frame(_) => self.pass_over()?,
                Tick::Idle => {}
                Tick::Exit => return Ok(Tick::Exit),
            }
        }
        Err(HeadsetError::Failed(format!(
            "what was sent for the frame at {} s never arrived",
            sent.time
        )))
    }
}
