//! A device that is never in time.

use std::{cell::RefCell, rc::Rc, time::Duration};

use ash::vk;
use ramus_xr::{Headset, HeadsetError, Tick};

/// A headset around a headset that wants pictures in no time, for so many frames, and notes how large they are.
pub(crate) struct Hurried<H> {
    pub(crate) inner: H,
    pub(crate) frames: usize,
    pub(crate) parts: Rc<RefCell<Vec<vk::Extent2D>>>,
}

impl<H: Headset> Headset for Hurried<H> {
    ramus_xr::forward_headset!(inner: describe, extent, swapchain, begin, views, end, vibrate, device, request_exit);

    fn wait(&mut self) -> Result<Tick, HeadsetError> {
        if self.frames == 0 {
            return Ok(Tick::Exit);
        }
        let tick = self.inner.wait()?;
        self.frames -= usize::from(matches!(tick, Tick::Frame(_)));
        Ok(tick)
    }

    fn period(&self) -> Option<Duration> {
        self.inner.period().map(|_| Duration::from_nanos(1))
    }

    fn show_part(&mut self, extent: vk::Extent2D) {
        self.parts.borrow_mut().push(extent);
        self.inner.show_part(extent);
    }
}
