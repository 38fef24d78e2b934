//! Images of our own to draw into, and reading pictures back to the processor.

use ash::vk;
use gpu_allocator::MemoryLocation;
use image::{Rgba, RgbaImage};

use super::{
    error::RenderError,
    frame::{full_barrier, run_now, transition},
    gpu::Gpu,
    memory::{Buffer, Image, ImageDesc},
    target::{StereoImage, Target, aspects},
};

/// Format of our own colour images.
pub const COLOR_FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;
/// Format of our own depth images.
pub const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;

/// Colour and depth of both eyes, without a headset.
pub struct Offscreen {
    // Views before the images that they show.
    color: StereoImage,
    depth: StereoImage,
    _images: [Image; 2],
    gpu: Gpu,
}

impl Offscreen {
    /// Makes images of so many pixels an eye.
    ///
    /// # Errors
    /// [`RenderError::OutOfMemory`], or [`RenderError::Unsupported`] for a size that the device cannot do.
    pub fn new(gpu: &Gpu, extent: vk::Extent2D) -> Result<Self, RenderError> {
        check_extent(gpu, extent)?;
        let make = |name, format, attachment| {
            let usage =
                attachment | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
            let image = Image::new(gpu, ImageDesc::stereo(name, format, extent, usage))?;
            // SAFETY: the image is kept beside the view.
            let stereo = unsafe { StereoImage::new(gpu, image.handle, format, extent) }?;
            Ok::<_, RenderError>((image, stereo))
        };
        let (color_image, color) = make(
            "the picture",
            COLOR_FORMAT,
            vk::ImageUsageFlags::COLOR_ATTACHMENT,
        )?;
        let (depth_image, depth) = make(
            "the picture's depth",
            DEPTH_FORMAT,
            vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
        )?;
        Ok(Self {
            color,
            depth,
            _images: [color_image, depth_image],
            gpu: gpu.clone(),
        })
    }

    /// What to draw into.
    pub fn target(&self) -> Target<'_> {
        Target {
            color: &self.color,
            depth: Some(&self.depth),
        }
    }

    /// Waits for the last draw and reads both eyes' colours (sRGB, as PNG wants them).
    ///
    /// # Errors
    /// [`RenderError`] when the device fails.
    pub fn read_color(&self) -> Result<[RgbaImage; 2], RenderError> {
        read_color(&self.gpu, &self.color)
    }

    /// Waits for the last draw and reads both eyes' depths, row by row: 1 at the near plane, 0 at infinity.
    ///
    /// # Errors
    /// [`RenderError`] when the device fails.
    pub fn read_depth(&self) -> Result<[Vec<f32>; 2], RenderError> {
        read_depth(&self.gpu, &self.depth)
    }
}

/// Refuses sizes that no image can have.
pub(crate) fn check_extent(gpu: &Gpu, extent: vk::Extent2D) -> Result<(), RenderError> {
    let most = gpu
        .limits
        .max_image_dimension2_d
        .min(gpu.limits.max_framebuffer_width)
        .min(gpu.limits.max_framebuffer_height);
    if extent.width == 0 || extent.height == 0 || extent.width > most || extent.height > most {
        return Err(RenderError::Unsupported(format!(
            "a picture of {} × {} pixels cannot be drawn here; choose a width and height from 1 to {most}",
            extent.width, extent.height
        )));
    }
    Ok(())
}

/// Waits for the last draw and reads both eyes' colours of an image of 8 bits a channel, RGBA or BGRA.
///
/// # Errors
/// [`RenderError`] when the device fails or the format is another.
pub fn read_color(gpu: &Gpu, image: &StereoImage) -> Result<[RgbaImage; 2], RenderError> {
    let swapped = match image.format {
        vk::Format::R8G8B8A8_SRGB | vk::Format::R8G8B8A8_UNORM => false,
        vk::Format::B8G8R8A8_SRGB | vk::Format::B8G8R8A8_UNORM => true,
        other => {
            return Err(RenderError::Unsupported(format!(
                "pictures of format {other:?} cannot be read back; use an 8-bit one"
            )));
        }
    };
    let vk::Extent2D { width, height } = image.extent;
    let layers = read(gpu, image, vk::ImageAspectFlags::COLOR)?;
    Ok(layers.map(|bytes| {
        let mut picture = RgbaImage::from_raw(width, height, bytes)
            .unwrap_or_else(|| RgbaImage::new(width, height));
        if swapped {
            for Rgba([red, _, blue, _]) in picture.pixels_mut() {
                std::mem::swap(red, blue);
            }
        }
        picture
    }))
}

/// Waits for the last draw and reads both eyes' depths of a 32-bit float image.
///
/// # Errors
/// [`RenderError`] when the device fails or the format is another.
pub fn read_depth(gpu: &Gpu, image: &StereoImage) -> Result<[Vec<f32>; 2], RenderError> {
    if image.format != vk::Format::D32_SFLOAT {
        return Err(RenderError::Unsupported(format!(
            "depths of format {:?} cannot be read back; use D32_SFLOAT",
            image.format
        )));
    }
    let layers = read(gpu, image, vk::ImageAspectFlags::DEPTH)?;
    Ok(layers.map(|bytes| {
        bytes
            .chunks_exact(4)
            .map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]]))
            .collect()
    }))
}

/// Both layers' bytes, four a pixel.
fn read(
    gpu: &Gpu,
    image: &StereoImage,
    aspect: vk::ImageAspectFlags,
) -> Result<[Vec<u8>; 2], RenderError> {
    let vk::Extent2D { width, height } = image.extent;
    let layer = u64::from(width) * u64::from(height) * 4;
    let mut buffer = Buffer::new(
        gpu,
        "reading back",
        layer * 2,
        vk::BufferUsageFlags::TRANSFER_DST,
        MemoryLocation::GpuToCpu,
    )?;
    let (drawn, read) = (image.layout(), vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
    run_now(gpu, |commands| {
        full_barrier(
            gpu,
            commands,
            &[transition(image.image, aspects(image.format), drawn, read)],
        );
        let region = [vk::BufferImageCopy::default()
            .image_subresource(
                vk::ImageSubresourceLayers::default()
                    .aspect_mask(aspect)
                    .layer_count(2),
            )
            .image_extent(vk::Extent3D {
                width,
                height,
                depth: 1,
            })];
        // SAFETY: the image is in that layout; the buffer holds both layers.
        unsafe {
            gpu.device
                .cmd_copy_image_to_buffer(commands, image.image, read, buffer.handle, &region)
        };
        full_barrier(
            gpu,
            commands,
            &[transition(image.image, aspects(image.format), read, drawn)],
        );
    })?;
    let size = usize::try_from(layer).unwrap_or(0);
    let bytes = buffer.bytes();
    let part = |from: usize| bytes.get(from..from + size).unwrap_or_default().to_vec();
    Ok([part(0), part(size)])
}
