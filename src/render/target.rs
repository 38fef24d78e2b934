//! What is drawn into: two-layer images, ours or a headset's, and the multisampled images behind them.

use ash::vk;
use ramus_xr::vulkan::Swapchain;

use super::{
    error::RenderError,
    frame::transition,
    gpu::Gpu,
    memory::{Image, ImageDesc, View, depth_aspects},
    pipelines::SAMPLES,
};

/// A picture for both eyes: an image of two layers that somebody else owns (a swapchain, an [`super::Offscreen`]).
///
/// After a draw it is in `COLOR_ATTACHMENT_OPTIMAL` (colour) or `DEPTH_STENCIL_ATTACHMENT_OPTIMAL`
/// (depth): what `XR_KHR_vulkan_enable2` wants of released images.
pub struct StereoImage {
    pub(crate) image: vk::Image,
    pub(crate) format: vk::Format,
    pub(crate) extent: vk::Extent2D,
    pub(crate) view: View,
    gpu: Gpu,
}

impl StereoImage {
    /// Takes an image to draw into.
    ///
    /// # Errors
    /// [`RenderError`] when no view can be made.
    ///
    /// # Safety
    /// `image` must be a live image of this device with two layers, one level, one sample, this format and extent, and outlive the
    /// returned value. Usage: colour or depth-stencil attachment; for [`super::StereoMode::PerEye`] transfer
    /// destination too; for read-back transfer source too.
    pub unsafe fn new(
        gpu: &Gpu,
        image: vk::Image,
        format: vk::Format,
        extent: vk::Extent2D,
    ) -> Result<Self, RenderError> {
        let view = View::new(gpu, image, format, aspects(format), 0..2, 0..1)?;
        Ok(Self {
            image,
            format,
            extent,
            view,
            gpu: gpu.clone(),
        })
    }

    /// The images of a headset, colour and depth, to draw into. Drop them before the headset.
    ///
    /// # Errors
    /// [`RenderError`] when no view can be made.
    pub fn of_swapchain(
        gpu: &Gpu,
        swapchain: &Swapchain,
    ) -> Result<(Vec<Self>, Vec<Self>), RenderError> {
        let stereo = |format: vk::Format| {
            move |image: &vk::Image| {
                // SAFETY: only a headset makes a `Swapchain`, with images of two layers, this format, extent and usage.
                unsafe { Self::new(gpu, *image, format, swapchain.extent()) }
            }
        };
        let color = swapchain
            .color()
            .iter()
            .map(stereo(swapchain.color_format()))
            .collect::<Result<_, _>>()?;
        let depth = swapchain
            .depth()
            .iter()
            .map(stereo(swapchain.depth_format()))
            .collect::<Result<_, _>>()?;
        Ok((color, depth))
    }

    /// Pixels of one eye.
    pub fn extent(&self) -> vk::Extent2D {
        self.extent
    }

    /// The layout that a draw leaves it in.
    pub(crate) fn layout(&self) -> vk::ImageLayout {
        if is_depth(self.format) {
            vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL
        } else {
            vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL
        }
    }
}

impl Drop for StereoImage {
    fn drop(&mut self) {
        // Happens when a session or a test ends: the view may still be in use by a frame under way.
        let _ = self.gpu.wait_idle();
    }
}

/// Where a frame goes.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// Colour of both eyes.
    pub color: &'a StereoImage,
    /// Depth of both eyes, where somebody wants it.
    pub depth: Option<&'a StereoImage>,
}

/// Whether a format is one of depth.
pub(crate) fn is_depth(format: vk::Format) -> bool {
    matches!(
        format,
        vk::Format::D16_UNORM
            | vk::Format::X8_D24_UNORM_PACK32
            | vk::Format::D32_SFLOAT
            | vk::Format::D24_UNORM_S8_UINT
            | vk::Format::D32_SFLOAT_S8_UINT
            | vk::Format::D16_UNORM_S8_UINT
    )
}

/// The aspects that a view of the format shows.
pub(crate) fn aspects(format: vk::Format) -> vk::ImageAspectFlags {
    if is_depth(format) {
        depth_aspects(format)
    } else {
        vk::ImageAspectFlags::COLOR
    }
}

/// The four-sample images that passes draw into, and in per-eye mode each eye's own resolved images.
///
/// Per-eye mode resolves into images of one layer and copies those into the target's layers: some drivers (Mesa's
/// lavapipe before 23) drop a resolve into a view that does not begin at layer 0.
pub(crate) struct Attachments {
    color: Image,
    depth: Image,
    pub(crate) color_view: View,
    pub(crate) depth_view: View,
    /// Each eye's colour and depth where eyes get passes of their own.
    pub(crate) eyes: Vec<(Resolved, Resolved)>,
}

/// One layer of one sample.
pub(crate) struct Resolved {
    pub(crate) image: Image,
    pub(crate) view: View,
}

impl Resolved {
    fn new(
        gpu: &Gpu,
        name: &'static str,
        format: vk::Format,
        extent: vk::Extent2D,
    ) -> Result<Self, RenderError> {
        let attachment = if is_depth(format) {
            vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT
        } else {
            vk::ImageUsageFlags::COLOR_ATTACHMENT
        };
        let usage = attachment | vk::ImageUsageFlags::TRANSFER_SRC;
        let image = Image::new(
            gpu,
            ImageDesc {
                layers: 1,
                ..ImageDesc::stereo(name, format, extent, usage)
            },
        )?;
        let view = View::new(gpu, image.handle, format, aspects(format), 0..1, 0..1)?;
        Ok(Self { image, view })
    }
}

impl Attachments {
    pub(crate) fn new(
        gpu: &Gpu,
        color: vk::Format,
        depth: vk::Format,
        extent: vk::Extent2D,
        own_eyes: u32,
    ) -> Result<Self, RenderError> {
        let layers = if own_eyes > 0 { 1 } else { 2 };
        let multisampled = |name, format, usage| {
            let usage = usage | vk::ImageUsageFlags::TRANSIENT_ATTACHMENT;
            Image::new(
                gpu,
                ImageDesc {
                    samples: SAMPLES,
                    layers,
                    ..ImageDesc::stereo(name, format, extent, usage)
                },
            )
        };
        let color_image = multisampled(
            "the multisampled colour",
            color,
            vk::ImageUsageFlags::COLOR_ATTACHMENT,
        )?;
        let depth_image = multisampled(
            "the multisampled depth",
            depth,
            vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
        )?;
        let eyes = (0..own_eyes)
            .map(|_| {
                Ok((
                    Resolved::new(gpu, "an eye's colour", color, extent)?,
                    Resolved::new(gpu, "an eye's depth", depth, extent)?,
                ))
            })
            .collect::<Result<_, RenderError>>()?;
        Ok(Self {
            color_view: View::new(
                gpu,
                color_image.handle,
                color,
                vk::ImageAspectFlags::COLOR,
                0..layers,
                0..1,
            )?,
            depth_view: View::new(
                gpu,
                depth_image.handle,
                depth,
                aspects(depth),
                0..layers,
                0..1,
            )?,
            color: color_image,
            depth: depth_image,
            eyes,
        })
    }

    /// The barriers that make both ready to be cleared.
    pub(crate) fn ready(&self) -> [vk::ImageMemoryBarrier2<'static>; 2] {
        [
            discard(self.color.handle, self.color.desc.format),
            discard(self.depth.handle, self.depth.desc.format),
        ]
    }
}

/// Makes an image an attachment whose contents are not wanted.
pub(crate) fn discard(image: vk::Image, format: vk::Format) -> vk::ImageMemoryBarrier2<'static> {
    let layout = if is_depth(format) {
        vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL
    } else {
        vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL
    };
    transition(image, aspects(format), vk::ImageLayout::UNDEFINED, layout)
}
