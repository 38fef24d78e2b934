//! The running session: events, frames, layers.

mod poll;

use std::cell::Cell;
use std::rc::Rc;
use std::thread::sleep;
use std::time::Duration;

use ::openxr as xr;
use ash::vk::{self, Handle as _};

use super::call::Called as _;
use super::connect::{ConnectError, refused};
use super::events::Held;
use super::hands::Hands;
use super::input::Input;
use super::quads::Quads;
use super::space::{Stage, locate, raw_from_pose};
use super::swapchain::{BOTH_EYES, Chain, choose_formats};
use super::system::{StartParams, System};
use super::view::locate_views;
use super::{frames, mask, refresh};
use crate::frame::{Frame, Hand, Pose, Pulse, View};
use crate::headset::{Acquired, Headset, HeadsetError, Tick};
use crate::lifecycle::{FrameCall, FrameClock, Lifecycle, Stage as FrameStage};
use crate::mask::VisibilityMask;
use crate::profiles::Profile;
use crate::quad::{QuadId, QuadImages, QuadPlace};
use crate::vulkan::{Swapchain, VulkanDevice, VulkanHandles};

/// How long `wait` rests while no session runs, so that a loop around it does not spin.
const IDLE_PAUSE: Duration = Duration::from_millis(10);

/// A headset behind an OpenXR runtime.
///
/// Drop it before the Vulkan device that it was started with, and with that device idle.
pub struct OpenXrHeadset {
    // The order of the fields is the order of dropping: what hangs on the session goes first.
    color: Chain,
    depth: Option<Chain>,
    images: Swapchain,
    quads: Quads,
    input: Input,
    bare: Option<Hands>,
    stage: Stage,
    head: xr::Space,
    session: xr::Session<xr::Vulkan>,
    instance: xr::Instance,
    events: Box<xr::EventDataBuffer>,
    title: String,
    blend: xr::EnvironmentBlendMode,
    near: f32,
    lifecycle: Lifecycle,
    clock: Rc<Cell<FrameClock>>,
    /// Predicted display time of the present frame, as the runtime told it.
    display_time: xr::Time,
    should_render: bool,
    /// How long it is shown.
    period: Duration,
    /// Pixels that are drawn of each eye's picture.
    part: vk::Extent2D,
    /// The views that were given last: the present frame's layers carry them.
    views: [View; 2],
    /// Whether `views` are the present frame's.
    located: bool,
    head_pose: Pose,
    held: [Held; 2],
    mask: VisibilityMask,
    /// Hertz, as far as the runtime tells.
    refresh_rate: Option<f32>,
    worn: bool,
    /// When the stage's origin will move.
    recentred_at: Option<xr::Time>,
    exit: bool,
    /// The device, where it is the headset's to keep alive; dropped last.
    device: Option<Box<dyn VulkanDevice>>,
}

impl Drop for OpenXrHeadset {
    fn drop(&mut self) {
        if let Some(device) = &self.device {
            device.wait_idle();
        }
    }
}

impl OpenXrHeadset {
    /// Keeps the device alive for as long as the session.
    pub(super) fn keep(&mut self, device: Box<dyn VulkanDevice>) {
        self.device = Some(device);
    }

    /// # Safety
    /// As [`System::start`].
    pub(super) unsafe fn new(
        system: System,
        vulkan: VulkanHandles,
        params: StartParams,
    ) -> Result<Self, ConnectError> {
        let System {
            instance,
            id,
            title,
            offer,
            blend,
            extent,
            room,
        } = system;
        let handles = xr::vulkan::SessionCreateInfo {
            instance: vulkan.instance.as_raw() as _,
            physical_device: vulkan.physical_device.as_raw() as _,
            device: vulkan.device.as_raw() as _,
            queue_family_index: vulkan.queue_family,
            queue_index: vulkan.queue_index,
        };
        // SAFETY: the caller vouches for the handles. Waiter and stream only hold the session: frames go by raw calls.
        let (session, _, _) = unsafe { instance.create_session::<xr::Vulkan>(id, &handles) }
            .map_err(|code| refused("xrCreateSession", code))?;
        let stage = Stage::new(&session, offer.local_floor)?;
        let head = session
            .create_reference_space(xr::ReferenceSpaceType::VIEW, raw_from_pose(Pose::IDENTITY))
            .called("xrCreateReferenceSpace")?;
        let input = Input::new(&session, &offer.profiles, offer.palm)?;
        let (color_format, depth_format) = choose_formats(&session, offer.depth)?;
        let color = Chain::new(
            &session,
            color_format,
            xr::SwapchainUsageFlags::COLOR_ATTACHMENT
                | xr::SwapchainUsageFlags::TRANSFER_SRC
                | xr::SwapchainUsageFlags::TRANSFER_DST
                | xr::SwapchainUsageFlags::SAMPLED,
            extent,
            BOTH_EYES,
        )?;
        let depth = depth_format.and_then(|format| {
            let usage = xr::SwapchainUsageFlags::DEPTH_STENCIL_ATTACHMENT
                | xr::SwapchainUsageFlags::TRANSFER_SRC
                | xr::SwapchainUsageFlags::TRANSFER_DST;
            // A picture without depth is better than none.
            Chain::new(&session, format, usage, extent, BOTH_EYES)
                .inspect_err(|error| tracing::warn!("no depth layer: {error}"))
                .ok()
        });
        let images = Swapchain {
            color: color.images.clone(),
            color_format,
            depth: depth
                .as_ref()
                .map(|chain| chain.images.clone())
                .unwrap_or_default(),
            depth_format: depth
                .as_ref()
                .and(depth_format)
                .unwrap_or(vk::Format::UNDEFINED),
            extent,
        };
        let bare = if offer.joints {
            Hands::new(&session)?
        } else {
            None
        };
        let mut mask = VisibilityMask::default();
        for view in 0..if offer.mask { 2 } else { 0 } {
            mask::update(&session, view, &mut mask)?;
        }
        let refresh_rate = if offer.refresh {
            refresh::request(&session, params.refresh)?
        } else {
            None
        };
        params.clock.set(params.clock.get().resumed());
        let start = Frame::start();
        Ok(Self {
            color,
            depth,
            images,
            quads: Quads::new(room),
            input,
            bare,
            stage,
            head,
            session,
            instance,
            events: Box::new(xr::EventDataBuffer::new()),
            title,
            blend,
            near: params.near,
            lifecycle: Lifecycle::default(),
            clock: params.clock,
            display_time: xr::Time::from_nanos(0),
            should_render: false,
            period: Duration::ZERO,
            part: extent,
            views: start.views,
            located: false,
            head_pose: start.head,
            held: [Held::default(); 2],
            mask,
            refresh_rate,
            worn: true,
            recentred_at: None,
            exit: false,
            device: None,
        })
    }

    /// Ends a frame that the application left open, without a picture: each wait needs its begin and end.
    fn close(&mut self) -> Result<(), HeadsetError> {
        if self.lifecycle.stage() == FrameStage::Waited {
            self.begin_frame()?;
        }
        if self.lifecycle.stage() == FrameStage::Begun {
            self.end(false)?;
        }
        Ok(())
    }

    fn wait_frame(&mut self) -> Result<(), HeadsetError> {
        self.allow(FrameCall::Wait)?;
        let next = frames::wait(&self.session)?;
        self.lifecycle.done(FrameCall::Wait);
        self.display_time = next.display_time;
        self.period = next.period;
        self.should_render = next.should_render;
        self.located = false;
        Ok(())
    }

    fn begin_frame(&mut self) -> Result<(), HeadsetError> {
        self.allow(FrameCall::Begin)?;
        frames::begin(&self.session)?;
        self.lifecycle.done(FrameCall::Begin);
        Ok(())
    }

    /// Ends the frame, with the picture or without.
    fn end_frame(&mut self, picture: bool) -> Result<(), HeadsetError> {
        let picture = picture.then_some(frames::Picture {
            space: &self.stage.space,
            views: &self.views,
            color: &self.color,
            depth: self.depth.as_ref(),
            extent: self.part,
            near: self.near,
            quads: self.quads.layers(&self.stage.space),
        });
        let ended = frames::end(
            &self.session,
            self.display_time,
            self.blend,
            picture.as_ref(),
        );
        // Whatever came of it, the frame is over.
        self.lifecycle.done(FrameCall::End);
        ended
    }

    fn allow(&self, call: FrameCall) -> Result<(), HeadsetError> {
        self.lifecycle
            .allow(call)
            .map_err(|error| HeadsetError::Failed(error.to_string()))
    }

    /// Looks for the eyes; the views stay as they were where they cannot be found.
    fn locate_eyes(&mut self) -> Result<(), HeadsetError> {
        if let Some(views) =
            locate_views(&self.session, &self.stage, self.display_time, &self.views)?
        {
            self.views = views;
            self.located = true;
        }
        Ok(())
    }

    /// Both hands: with what they hold, or bare where nothing is bound to them.
    fn hands(&mut self) -> Result<[Hand; 2], HeadsetError> {
        let mut hands = self
            .input
            .hands(&self.session, &self.stage, self.display_time)?;
        if let Some(bare) = &mut self.bare {
            for (side, (hand, held)) in hands.iter_mut().zip(self.held).enumerate() {
                if !hand.tracked && !held.bound {
                    *hand = bare.hand(&self.stage, self.display_time, side)?;
                }
            }
        }
        Ok(hands)
    }

    /// The hands are hidden for a frame: a gesture that was under way is over.
    fn rest(&mut self) {
        if let Some(bare) = &mut self.bare {
            bare.rest();
        }
    }

    /// Pictures a second in hertz, where the runtime tells.
    #[must_use]
    pub fn refresh_rate(&self) -> Option<f32> {
        self.refresh_rate
    }

    /// Whether the stage's origin moves with this frame. The hands are then hidden for one frame, so that a stroke or
    /// a drag ends cleanly where it was and does not leap with the origin.
    fn recentred(&mut self) -> bool {
        let now = self
            .recentred_at
            .is_some_and(|time| self.display_time.as_nanos() >= time.as_nanos());
        if now {
            self.recentred_at = None;
        }
        now
    }
}

impl Headset for OpenXrHeadset {
    fn describe(&self) -> String {
        self.title.clone()
    }

    fn extent(&self) -> vk::Extent2D {
        self.images.extent
    }

    fn swapchain(&self) -> Option<&Swapchain> {
        Some(&self.images)
    }

    fn wait(&mut self) -> Result<Tick, HeadsetError> {
        self.close()?;
        self.poll()?;
        if self.exit {
            return Ok(Tick::Exit);
        }
        if !self.lifecycle.running() {
            sleep(IDLE_PAUSE);
            return Ok(Tick::Idle);
        }
        self.wait_frame()?;
        self.input.sync(&self.session)?;
        self.locate_eyes()?;
        if let Some(head) = locate(&self.head, &self.stage, self.display_time)? {
            self.head_pose = head;
        }
        let recentred = self.recentred();
        // A headset that lies on the table takes no input, whatever its controllers do.
        let focused = self.lifecycle.focused() && self.worn;
        let hands = if focused && !recentred {
            self.hands()?
        } else {
            self.rest();
            [Hand::ABSENT; 2]
        };
        let mut clock = self.clock.get();
        let time = clock.advance(self.display_time.as_nanos());
        self.clock.set(clock);
        Ok(Tick::Frame(Frame {
            time,
            focused,
            should_render: self.should_render && self.located,
            head: self.head_pose,
            views: self.views,
            hands,
        }))
    }

    fn begin(&mut self) -> Result<Option<Acquired>, HeadsetError> {
        self.begin_frame()?;
        if !(self.should_render && self.located) {
            return Ok(None);
        }
        let color = self.color.acquire()?;
        let depth = self.depth.as_mut().map(Chain::acquire).transpose()?;
        Ok(Some(Acquired { color, depth }))
    }

    fn views(&mut self) -> Result<[View; 2], HeadsetError> {
        self.allow(FrameCall::End)?;
        self.locate_eyes()?;
        Ok(self.views)
    }

    fn end(&mut self, rendered: bool) -> Result<(), HeadsetError> {
        self.allow(FrameCall::End)?;
        let color = self.color.release()?;
        let depth = self.depth.as_mut().map_or(Ok(true), Chain::release)?;
        self.quads.release()?;
        self.end_frame(rendered && self.located && color && depth)?;
        self.input
            .vibrate(&self.session, self.lifecycle.focused() && self.worn)
    }

    fn vibrate(&mut self, pulse: Pulse) {
        self.input.queue(pulse);
    }

    fn controllers(&self) -> [Option<&'static Profile>; 2] {
        self.held.map(|held| held.profile)
    }

    fn worn(&self) -> bool {
        self.worn
    }

    fn period(&self) -> Option<Duration> {
        (self.period > Duration::ZERO).then_some(self.period)
    }

    fn show_part(&mut self, extent: vk::Extent2D) {
        let all = self.images.extent;
        self.part = vk::Extent2D {
            width: extent.width.clamp(1, all.width),
            height: extent.height.clamp(1, all.height),
        };
    }

    fn visibility_mask(&self) -> Option<&VisibilityMask> {
        (self.mask.revision > 0).then_some(&self.mask)
    }

    fn make_quad(&mut self, extent: vk::Extent2D) -> Result<Option<QuadId>, HeadsetError> {
        self.quads
            .make(&self.session, self.images.color_format, extent)
    }

    fn quad_images(&self, quad: QuadId) -> Option<&QuadImages> {
        self.quads.images(quad)
    }

    fn acquire_quad(&mut self, quad: QuadId) -> Result<Option<usize>, HeadsetError> {
        self.allow(FrameCall::End)?;
        self.quads.acquire(quad)
    }

    fn place_quad(&mut self, quad: QuadId, place: Option<QuadPlace>) {
        self.quads.place(quad, place);
    }

    fn request_exit(&mut self) {
        if let Err(code) = self.session.request_exit() {
            // A session that does not run cannot be asked to stop; there is nothing to wait for then.
            tracing::debug!("leaving without the runtime's consent: {code:?}");
            self.exit = true;
        }
    }
}
