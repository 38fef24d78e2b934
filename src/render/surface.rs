//! A window's surface: the picture is drawn into an image of its own and copied into the swapchain's.
//!
//! ```text
//! fit(size) ─▶ swapchain, picture of the same size ─▶ Renderer::draw ─▶ present: acquire, copy, show
//! ```
//!
//! Drawing apart from the swapchain costs a copy a frame, and buys that the renderer's targets are as they are for a headset (two
//! layers), that a picture can be read back, and that an image is acquired only when there is something to show. A swapchain
//! that no longer fits its window (out of date, suboptimal, another size) is made anew by the next `fit`; so is a surface that was lost.
//! Presenting waits for the screen (FIFO, which every driver has): the frame loop is paced by it.

use std::sync::Arc;

use ash::vk;

use super::{
    error::{RenderError, Trying as _},
    frame::{Commands, SLOTS, full_barrier, transition},
    gpu::Gpu,
    memory::{Image, ImageDesc},
    target::{StereoImage, Target},
    window::{DrawnWindow, make_surface, no_window},
};

/// Longest wait for an image in nanoseconds: a compositor that shows nothing of the window may never give one.
const LONGEST_ACQUIRE: u64 = 100_000_000;

/// Formats of a swapchain that are taken, best first, each with the format that is drawn: pictures are copied byte by byte, so
/// sRGB bytes reach a UNORM image as they are.
const FORMATS: [(vk::Format, vk::Format); 4] = [
    (vk::Format::B8G8R8A8_SRGB, vk::Format::B8G8R8A8_SRGB),
    (vk::Format::R8G8B8A8_SRGB, vk::Format::R8G8B8A8_SRGB),
    (vk::Format::B8G8R8A8_UNORM, vk::Format::B8G8R8A8_SRGB),
    (vk::Format::R8G8B8A8_UNORM, vk::Format::R8G8B8A8_SRGB),
];

/// What is drawn and the swapchain that shows it.
struct Chain {
    // The view before its image.
    picture: StereoImage,
    _image: Image,
    handle: vk::SwapchainKHR,
    images: Vec<vk::Image>,
    /// For each image: its copy is done.
    copied: Vec<Semaphore>,
}

/// A semaphore between queue and screen.
struct Semaphore {
    handle: vk::Semaphore,
    gpu: Gpu,
}

impl Semaphore {
    fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let info = vk::SemaphoreCreateInfo::default();
        // SAFETY: a plain semaphore.
        let handle = unsafe { gpu.device.create_semaphore(&info, None) }
            .trying("making a semaphore for the window")?;
        Ok(Self {
            handle,
            gpu: gpu.clone(),
        })
    }
}

impl Drop for Semaphore {
    fn drop(&mut self) {
        // SAFETY: owners wait for the device before they drop semaphores.
        unsafe { self.gpu.device.destroy_semaphore(self.handle, None) };
    }
}

/// One of the copies that may be under way.
struct Slot {
    commands: Commands,
    acquired: Semaphore,
}

/// A window to draw into.
pub struct Surface {
    chain: Option<Chain>,
    slots: [Slot; SLOTS],
    /// Which slot is next.
    at: usize,
    handle: vk::SurfaceKHR,
    /// Of the swapchain, and of what is drawn.
    format: (vk::SurfaceFormatKHR, vk::Format),
    /// The size that was asked for last, pixels.
    asked: vk::Extent2D,
    /// The swapchain does not fit the window any more.
    stale: bool,
    /// The surface itself is gone.
    lost: bool,
    surfaces: ash::khr::surface::Instance,
    swapchains: ash::khr::swapchain::Device,
    gpu: Gpu,
    /// Must outlive the surface.
    window: Arc<dyn DrawnWindow>,
}

impl Surface {
    /// The surface of a window, on a device that a [`super::WindowHost`] for the same window made.
    ///
    /// # Errors
    /// [`RenderError`] where the device cannot present to it.
    pub fn new(gpu: &Gpu, window: Arc<dyn DrawnWindow>) -> Result<Self, RenderError> {
        let slot = || {
            Ok::<_, RenderError>(Slot {
                commands: Commands::new(gpu)?,
                acquired: Semaphore::new(gpu)?,
            })
        };
        let slots = [slot()?, slot()?];
        let surfaces = ash::khr::surface::Instance::new(&gpu.entry, &gpu.instance);
        // SAFETY: the surface is destroyed before the instance and the window, which are kept beside it.
        let handle = unsafe { make_surface(&gpu.entry, &gpu.instance, &*window) }?;
        let mut surface = Self {
            chain: None,
            slots,
            at: 0,
            handle,
            format: (vk::SurfaceFormatKHR::default(), vk::Format::UNDEFINED),
            asked: vk::Extent2D::default(),
            stale: false,
            lost: false,
            surfaces,
            swapchains: ash::khr::swapchain::Device::new(&gpu.instance, &gpu.device),
            gpu: gpu.clone(),
            window,
        };
        surface.format = surface.find_format()?;
        Ok(surface)
    }

    /// The format to draw in.
    #[must_use]
    pub fn color_format(&self) -> vk::Format {
        self.format.1
    }

    /// Makes swapchain and picture fit a window of this size, in pixels; gives the size to draw, or `None` while there is
    /// nothing to draw into (a window without area).
    ///
    /// # Errors
    /// [`RenderError`] where the device fails.
    pub fn fit(&mut self, asked: vk::Extent2D) -> Result<Option<vk::Extent2D>, RenderError> {
        if self.lost {
            self.make_anew()?;
        }
        if self.chain.is_none() || self.stale || self.asked != asked {
            self.asked = asked;
            self.make_chain()?;
        }
        Ok(self.chain.as_ref().map(|chain| chain.picture.extent))
    }

    /// What to draw into; after a successful [`Self::fit`].
    ///
    /// # Errors
    /// Where there is nothing.
    pub fn target(&self) -> Result<Target<'_>, RenderError> {
        match &self.chain {
            Some(chain) => Ok(Target {
                color: &chain.picture,
                depth: None,
            }),
            None => Err(no_window("it has no area")),
        }
    }

    /// Shows what was drawn; false where the screen took nothing, so that it must be drawn again.
    ///
    /// # Errors
    /// [`RenderError`] where the device fails.
    pub fn present(&mut self) -> Result<bool, RenderError> {
        let (Some(chain), Some(slot)) = (&self.chain, self.slots.get(self.at)) else {
            return Ok(false);
        };
        slot.commands.wait()?;
        // SAFETY: the slot's last copy is done, so its semaphore is not in use.
        let acquired = unsafe {
            self.swapchains.acquire_next_image(
                chain.handle,
                LONGEST_ACQUIRE,
                slot.acquired.handle,
                vk::Fence::null(),
            )
        };
        let index = match acquired {
            Ok((index, suboptimal)) => {
                self.stale |= suboptimal;
                index
            }
            Err(result) => return self.unfit(result, "asking for the window's next image"),
        };
        let place = index as usize;
        let (Some(&image), Some(copied)) = (chain.images.get(place), chain.copied.get(place))
        else {
            return Err(no_window("it named an image that it does not have"));
        };
        let commands = slot.commands.begin()?;
        copy(&self.gpu, commands, &chain.picture, image);
        slot.commands
            .submit_between(Some(slot.acquired.handle), Some(copied.handle))?;
        self.at = (self.at + 1) % SLOTS;
        let (waits, handles, indices) = ([copied.handle], [chain.handle], [index]);
        let info = vk::PresentInfoKHR::default()
            .wait_semaphores(&waits)
            .swapchains(&handles)
            .image_indices(&indices);
        match self.gpu.present(&self.swapchains, &info) {
            Ok(suboptimal) => {
                self.stale |= suboptimal;
                Ok(true)
            }
            Err(result) => self.unfit(result, "showing a picture in the window"),
        }
    }

    /// Notes what the next `fit` must mend; anything else is an error.
    fn unfit(&mut self, result: vk::Result, what: &'static str) -> Result<bool, RenderError> {
        match result {
            vk::Result::TIMEOUT | vk::Result::NOT_READY => {}
            vk::Result::ERROR_OUT_OF_DATE_KHR => self.stale = true,
            vk::Result::ERROR_SURFACE_LOST_KHR => self.lost = true,
            other => return Err(RenderError::from_vulkan(what, other)),
        }
        Ok(false)
    }

    /// The first of [`FORMATS`] that the surface has.
    fn find_format(&self) -> Result<(vk::SurfaceFormatKHR, vk::Format), RenderError> {
        // SAFETY: device and surface are alive.
        let found = unsafe {
            self.surfaces
                .get_physical_device_surface_formats(self.gpu.physical_device, self.handle)
        }
        .trying("asking for the window's formats")?;
        let nonlinear = vk::ColorSpaceKHR::SRGB_NONLINEAR;
        FORMATS
            .iter()
            .find_map(|&(format, drawn)| {
                let same = |has: &&vk::SurfaceFormatKHR| {
                    has.format == format && has.color_space == nonlinear
                };
                found.iter().find(same).map(|has| (*has, drawn))
            })
            .ok_or_else(|| no_window("it takes no pictures of 8 bits a channel"))
    }

    /// A surface in place of the lost one.
    fn make_anew(&mut self) -> Result<(), RenderError> {
        self.drop_chain();
        // SAFETY: the device is idle and nothing uses the surface; the new one is kept as the old one was.
        unsafe {
            self.surfaces.destroy_surface(self.handle, None);
            self.handle = vk::SurfaceKHR::null();
            self.handle = make_surface(&self.gpu.entry, &self.gpu.instance, &*self.window)?;
        }
        self.lost = false;
        Ok(())
    }

    fn drop_chain(&mut self) {
        let _ = self.gpu.wait_idle();
        if let Some(chain) = self.chain.take() {
            // SAFETY: the device is idle.
            unsafe { self.swapchains.destroy_swapchain(chain.handle, None) };
        }
    }

    /// The size of the swapchain: the surface's own, or where it leaves that to us the window's.
    fn extent(&self, found: &vk::SurfaceCapabilitiesKHR) -> vk::Extent2D {
        if found.current_extent.width != u32::MAX {
            return found.current_extent;
        }
        let (least, most) = (found.min_image_extent, found.max_image_extent);
        vk::Extent2D {
            width: self.asked.width.max(least.width).min(most.width),
            height: self.asked.height.max(least.height).min(most.height),
        }
    }

    fn make_chain(&mut self) -> Result<(), RenderError> {
        // SAFETY: device and surface are alive.
        let found = unsafe {
            self.surfaces
                .get_physical_device_surface_capabilities(self.gpu.physical_device, self.handle)
        };
        let found = match found {
            Ok(found) => found,
            Err(vk::Result::ERROR_SURFACE_LOST_KHR) => {
                self.lost = true;
                self.drop_chain();
                return Ok(());
            }
            Err(result) => {
                return Err(RenderError::from_vulkan(
                    "asking what the window can",
                    result,
                ));
            }
        };
        let extent = self.extent(&found);
        let usage = vk::ImageUsageFlags::TRANSFER_DST;
        if !found.supported_usage_flags.contains(usage) {
            return Err(no_window("its images cannot be copied into"));
        }
        if extent.width == 0 || extent.height == 0 {
            self.drop_chain();
            return Ok(());
        }
        super::offscreen::check_extent(&self.gpu, extent)?;
        let most = match found.max_image_count {
            0 => u32::MAX,
            most => most,
        };
        let _ = self.gpu.wait_idle();
        let old = self.chain.take();
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(self.handle)
            .min_image_count(found.min_image_count.saturating_add(1).min(most))
            .image_format(self.format.0.format)
            .image_color_space(self.format.0.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(usage)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(found.current_transform)
            .composite_alpha(opaque(found.supported_composite_alpha))
            .present_mode(vk::PresentModeKHR::FIFO)
            .clipped(true)
            .old_swapchain(old.as_ref().map_or_else(Default::default, |old| old.handle));
        // SAFETY: the surface is alive and can present from this device; the old swapchain is not in use.
        let made = unsafe { self.swapchains.create_swapchain(&info, None) };
        if let Some(old) = old {
            // SAFETY: the device is idle.
            unsafe { self.swapchains.destroy_swapchain(old.handle, None) };
        }
        match made {
            Ok(handle) => self.take_chain(handle, extent),
            Err(result) => {
                // The window changed in between: the next frame tries again.
                self.unfit(result, "making the window's images").map(|_| ())
            }
        }
    }

    fn take_chain(
        &mut self,
        handle: vk::SwapchainKHR,
        extent: vk::Extent2D,
    ) -> Result<(), RenderError> {
        let made = self.dress(handle, extent);
        if made.is_err() {
            // SAFETY: nothing was drawn into it yet.
            unsafe { self.swapchains.destroy_swapchain(handle, None) };
        }
        self.chain = Some(made?);
        self.stale = false;
        Ok(())
    }

    fn dress(&self, handle: vk::SwapchainKHR, extent: vk::Extent2D) -> Result<Chain, RenderError> {
        // SAFETY: the swapchain was just made.
        let images = unsafe { self.swapchains.get_swapchain_images(handle) }
            .trying("asking for the window's images")?;
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let format = self.format.1;
        let desc = ImageDesc::stereo("the window's picture", format, extent, usage);
        let image = Image::new(&self.gpu, desc)?;
        let copied = images.iter().map(|_| Semaphore::new(&self.gpu));
        Ok(Chain {
            // SAFETY: the image is kept beside its view.
            picture: unsafe { StereoImage::new(&self.gpu, image.handle, format, extent) }?,
            _image: image,
            handle,
            copied: copied.collect::<Result<_, _>>()?,
            images,
        })
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        self.drop_chain();
        // SAFETY: the device is idle, the swapchain is gone, the instance and the window are still there.
        unsafe { self.surfaces.destroy_surface(self.handle, None) };
    }
}

/// How the window's alpha is taken: not at all, where that can be had.
fn opaque(supported: vk::CompositeAlphaFlagsKHR) -> vk::CompositeAlphaFlagsKHR {
    let wanted = [
        vk::CompositeAlphaFlagsKHR::OPAQUE,
        vk::CompositeAlphaFlagsKHR::INHERIT,
        vk::CompositeAlphaFlagsKHR::PRE_MULTIPLIED,
        vk::CompositeAlphaFlagsKHR::POST_MULTIPLIED,
    ];
    let there = wanted.into_iter().find(|&alpha| supported.contains(alpha));
    there.unwrap_or(vk::CompositeAlphaFlagsKHR::OPAQUE)
}

/// Copies the left eye's picture into the window's image.
fn copy(gpu: &Gpu, commands: vk::CommandBuffer, picture: &StereoImage, image: vk::Image) {
    let color = vk::ImageAspectFlags::COLOR;
    let (source, sink) = (
        vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
        vk::ImageLayout::TRANSFER_DST_OPTIMAL,
    );
    let drawn = picture.layout();
    full_barrier(
        gpu,
        commands,
        &[
            transition(picture.image, color, drawn, source),
            transition(image, color, vk::ImageLayout::UNDEFINED, sink),
        ],
    );
    let layer = vk::ImageSubresourceLayers::default()
        .aspect_mask(color)
        .layer_count(1);
    let region = [vk::ImageCopy::default()
        .src_subresource(layer)
        .dst_subresource(layer)
        .extent(vk::Extent3D {
            width: picture.extent.width,
            height: picture.extent.height,
            depth: 1,
        })];
    // SAFETY: both images are in these layouts, of one size and of formats with the same bytes.
    unsafe {
        gpu.device
            .cmd_copy_image(commands, picture.image, source, image, sink, &region);
    }
    full_barrier(
        gpu,
        commands,
        &[
            transition(picture.image, color, source, drawn),
            transition(image, color, sink, vk::ImageLayout::PRESENT_SRC_KHR),
        ],
    );
}
