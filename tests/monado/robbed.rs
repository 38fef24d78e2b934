//! A headset that plays a script on the real runtime: frames to show, things to do, states to wait for.

use ramus_monado::{
    feed::arrived,
    remote::{Packet, Remote},
};
use ramus_xr::{Frame, Headset, HeadsetError, Tick};

/// Most frames of the device until a beat must be over: half a minute on the null compositor.
const PATIENCE: usize = 600;

/// Whether a frame is the one that is waited for.
pub(crate) type Wish<'a> = Box<dyn Fn(&Frame) -> bool + 'a>;

/// A part of the script.
pub(crate) enum Beat<'a> {
    /// Send this frame and go on to wait until the runtime says the same; the application sees it once.
    Show(Box<Frame>),
    /// Do something between two frames.
    Do(Box<dyn FnOnce() + 'a>),
    /// Let the application see every frame until one is as wanted.
    Until(&'static str, Wish<'a>),
}

impl Beat<'_> {
    pub(crate) fn show(frame: &Frame) -> Self {
        Self::Show(Box::new(*frame))
    }
}

/// Plays the beats in order, then asks the session to end.
pub(crate) struct Robbed<'a, H> {
    inner: H,
    remote: Remote,
    beats: std::vec::IntoIter<Beat<'a>>,
    waiting: Option<(&'static str, Wish<'a>, usize)>,
    over: bool,
}

impl<'a, H: Headset> Robbed<'a, H> {
    pub(crate) fn new(inner: H, remote: Remote, beats: Vec<Beat<'a>>) -> Self {
        Self {
            inner,
            remote,
            beats: beats.into_iter(),
            waiting: None,
            over: false,
        }
    }

    /// Ends a frame of the device that the application does not see.
    fn pass_over(&mut self) -> Result<(), HeadsetError> {
        self.inner.begin()?;
        self.inner.end(false)
    }

    fn show(&mut self, sent: &Frame) -> Result<Tick, HeadsetError> {
        self.remote
            .send(&Packet::from_frame(sent).unwrap())
            .unwrap();
        for _ in 0..PATIENCE {
            match self.inner.wait()? {
                Tick::Frame(seen) if seen.focused && arrived(&seen, sent) => {
                    return Ok(Tick::Frame(seen));
                }
                Tick::Frame(_) => self.pass_over()?,
                Tick::Idle => {}
                Tick::Exit => return Ok(Tick::Exit),
            }
        }
        panic!(
            "what was sent for the frame at {} s never arrived",
            sent.time
        );
    }
}

impl<H: Headset> Headset for Robbed<'_, H> {
    ramus_xr::forward_headset!(inner: describe, extent, swapchain, begin, views, end, vibrate, device, request_exit);

    fn wait(&mut self) -> Result<Tick, HeadsetError> {
        loop {
            if let Some((what, wanted, rounds)) = &mut self.waiting {
                *rounds += 1;
                assert!(*rounds < PATIENCE, "it never came that {what}");
                let tick = self.inner.wait()?;
                if let Tick::Frame(frame) = &tick
                    && wanted(frame)
                {
                    self.waiting = None;
                }
                return Ok(tick);
            }
            match self.beats.next() {
                Some(Beat::Show(frame)) => return self.show(&frame),
                Some(Beat::Do(action)) => action(),
                Some(Beat::Until(what, wanted)) => self.waiting = Some((what, wanted, 0)),
                None => {
                    if !self.over {
                        self.over = true;
                        self.inner.request_exit();
                    }
                    return match self.inner.wait()? {
                        Tick::Frame(_) => self.pass_over().map(|()| Tick::Idle),
                        tick => Ok(tick),
                    };
                }
            }
        }
    }
}
