//! A panel's picture in an image that a headset's runtime shows by itself.
//!
//! Bytes go over as they are, or with red and blue swapped: both images are sRGB ones, and a blit between sRGB formats pixel by
//! pixel gives the same colours. egui's edges are blended in gamma space and those of a runtime's layers in linear space; that
//! is seen in the half transparent pixels of the board's round corners alone, since panels are opaque.

use ash::vk;
use ramus_xr::vulkan::QuadImages;

use super::picture::Picture;
use crate::render::{
    frame::{full_barrier, transition},
    gpu::Gpu,
};

/// An image of a quad, to be copied into by one draw.
#[derive(Clone, Copy, Debug)]
pub struct LayerImage {
    image: vk::Image,
    format: vk::Format,
    extent: vk::Extent2D,
}

impl LayerImage {
    /// One of a quad's images, or none where it has no such image. It must have been acquired, and be released after the draw.
    #[must_use]
    pub fn of_quad(images: &QuadImages, index: usize) -> Option<Self> {
        Some(Self {
            image: *images.color().get(index)?,
            format: images.format(),
            extent: images.extent(),
        })
    }
}

impl Picture {
    /// Copies what was painted; leaves the layer's image as an attachment, as runtimes want it.
    pub(super) fn record_copy(&self, gpu: &Gpu, commands: vk::CommandBuffer, layer: &LayerImage) {
        let from = &self.image;
        if from.desc.extent != layer.extent {
            return;
        }
        let color = vk::ImageAspectFlags::COLOR;
        let (source, sink) = (
            vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
            vk::ImageLayout::TRANSFER_DST_OPTIMAL,
        );
        let (read, drawn) = (
            vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
            vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
        );
        let before = [
            transition(from.handle, color, read, source),
            transition(layer.image, color, vk::ImageLayout::UNDEFINED, sink),
        ];
        full_barrier(gpu, commands, &before);
        let place = vk::ImageSubresourceLayers::default()
            .aspect_mask(color)
            .layer_count(1);
        if from.desc.format == layer.format {
            let region = [vk::ImageCopy::default()
                .src_subresource(place)
                .dst_subresource(place)
                .extent(layer.extent.into())];
            // SAFETY: both images are in these layouts, of one format and size; the layer's was acquired for this frame.
            unsafe {
                gpu.device.cmd_copy_image(
                    commands,
                    from.handle,
                    source,
                    layer.image,
                    sink,
                    &region,
                );
            }
        } else {
            let side = |pixels: u32| i32::try_from(pixels).unwrap_or(i32::MAX);
            let corner = vk::Offset3D {
                x: side(layer.extent.width),
                y: side(layer.extent.height),
                z: 1,
            };
            let region = [vk::ImageBlit::default()
                .src_subresource(place)
                .src_offsets([vk::Offset3D::default(), corner])
                .dst_subresource(place)
                .dst_offsets([vk::Offset3D::default(), corner])];
            // SAFETY: both images are in these layouts and of one size; the layer's was acquired for this frame.
            unsafe {
                gpu.device.cmd_blit_image(
                    commands,
                    from.handle,
                    source,
                    layer.image,
                    sink,
                    &region,
                    vk::Filter::NEAREST,
                );
            }
        }
        let after = [
            transition(from.handle, color, source, read),
            transition(layer.image, color, sink, drawn),
        ];
        full_barrier(gpu, commands, &after);
    }
}

#[cfg(test)]
#[path = "layer_tests.rs"]
pub(crate) mod tests;
