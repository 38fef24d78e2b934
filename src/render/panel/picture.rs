//! The image that egui is painted into and the board samples, with its mip levels.

use ash::vk;

use super::{PAINTED, SAMPLED};
use crate::render::{
    error::RenderError,
    frame::{Pool, full_barrier, run_now, transition},
    gpu::Gpu,
    memory::{Image, ImageDesc, View},
};

/// The board's image.
pub(super) struct Picture {
    pub(super) image: Image,
    pub(super) paint: View,
    _sample: View,
    pub(super) set: vk::DescriptorSet,
    _pool: Pool,
}

impl Picture {
    pub(super) fn new(
        gpu: &Gpu,
        layout: vk::DescriptorSetLayout,
        sampler: vk::Sampler,
        size: [u32; 2],
    ) -> Result<Self, RenderError> {
        let extent = vk::Extent2D {
            width: size[0],
            height: size[1],
        };
        let mips = 32 - size[0].max(size[1]).leading_zeros();
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let flags = vk::ImageCreateFlags::MUTABLE_FORMAT;
        let desc = ImageDesc {
            layers: 1,
            mips,
            flags,
            ..ImageDesc::stereo("the panel's picture", SAMPLED, extent, usage)
        };
        let image = Image::new(gpu, desc)?;
        let color = vk::ImageAspectFlags::COLOR;
        let paint = View::new(gpu, image.handle, PAINTED, color, 0..1, 0..1)?;
        let sample = View::new(gpu, image.handle, SAMPLED, color, 0..1, 0..mips)?;
        let (pool, set) = sampled_set(gpu, layout, &sample, sampler)?;
        run_now(gpu, |commands| {
            let (before, after) = (
                vk::ImageLayout::UNDEFINED,
                vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
            );
            full_barrier(
                gpu,
                commands,
                &[transition(image.handle, color, before, after)],
            );
        })?;
        Ok(Self {
            image,
            paint,
            _sample: sample,
            set,
            _pool: pool,
        })
    }

    /// Halves level after level, then leaves all of them to be sampled.
    pub(super) fn record_mips(&self, gpu: &Gpu, commands: vk::CommandBuffer) {
        let color = vk::ImageAspectFlags::COLOR;
        let (source, sink) = (
            vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
            vk::ImageLayout::TRANSFER_DST_OPTIMAL,
        );
        let image = self.image.handle;
        let one = |level: u32, from, to| {
            let mut barrier = transition(image, color, from, to);
            barrier.subresource_range.base_mip_level = level;
            barrier.subresource_range.level_count = 1;
            barrier
        };
        let side = |whole: u32, level: u32| i32::try_from((whole >> level).max(1)).unwrap_or(1);
        let corner = |level| vk::Offset3D {
            x: side(self.image.desc.extent.width, level),
            y: side(self.image.desc.extent.height, level),
            z: 1,
        };
        // `transition` of all levels wants one old layout: level 0 is an attachment, the others are sampled; painting's
        // UNDEFINED discarded all of them into the attachment layout.
        full_barrier(
            gpu,
            commands,
            &[one(0, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL, source)],
        );
        let layers = |level| {
            vk::ImageSubresourceLayers::default()
                .aspect_mask(color)
                .mip_level(level)
                .layer_count(1)
        };
        for level in 1..self.image.desc.mips {
            full_barrier(
                gpu,
                commands,
                &[one(level, vk::ImageLayout::UNDEFINED, sink)],
            );
            let region = [vk::ImageBlit::default()
                .src_subresource(layers(level - 1))
                .src_offsets([vk::Offset3D::default(), corner(level - 1)])
                .dst_subresource(layers(level))
                .dst_offsets([vk::Offset3D::default(), corner(level)])];
            // SAFETY: both levels are in these layouts.
            unsafe {
                gpu.device.cmd_blit_image(
                    commands,
                    image,
                    source,
                    image,
                    sink,
                    &region,
                    vk::Filter::LINEAR,
                )
            };
            full_barrier(gpu, commands, &[one(level, sink, source)]);
        }
        full_barrier(
            gpu,
            commands,
            &[transition(
                image,
                color,
                source,
                vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
            )],
        );
    }
}

/// A set of a sampled image and a sampler, with a pool of its own.
pub(super) fn sampled_set(
    gpu: &Gpu,
    layout: vk::DescriptorSetLayout,
    view: &View,
    sampler: vk::Sampler,
) -> Result<(Pool, vk::DescriptorSet), RenderError> {
    let pool = Pool::new(
        gpu,
        1,
        &[
            (vk::DescriptorType::SAMPLED_IMAGE, 1),
            (vk::DescriptorType::SAMPLER, 1),
        ],
    )?;
    let set = pool.set(layout)?;
    let image = [vk::DescriptorImageInfo {
        image_view: view.handle,
        image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        sampler: vk::Sampler::null(),
    }];
    let sampler = [vk::DescriptorImageInfo {
        sampler,
        ..Default::default()
    }];
    let write = |binding, kind| {
        vk::WriteDescriptorSet::default()
            .dst_set(set)
            .dst_binding(binding)
            .descriptor_type(kind)
    };
    let writes = [
        write(0, vk::DescriptorType::SAMPLED_IMAGE).image_info(&image),
        write(1, vk::DescriptorType::SAMPLER).image_info(&sampler),
    ];
    // SAFETY: the set is new.
    unsafe { gpu.device.update_descriptor_sets(&writes, &[]) };
    Ok((pool, set))
}
