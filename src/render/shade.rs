//! Levels of what the shadow map hides: how soft shadows are read from it without a loop over taps.
//!
//! ```text
//! shadow map 2048² ─▶ 512²: of each 4 × 4 texels, how many hide the sun, and how deep these lie ─▶ 256² ─▶ … ─▶ 8² ─▶ all in one image, side by side
//! ```
//!
//! Percentage-closer soft shadows (Fernando 2005) ask the map a few dozen times a pixel: for what hides the sun, and how far that is, then for as wide a blur
//! as follows. Both are means over a part of the map, so both are read here from a level whose texels are as large as that part. What is behind all of the
//! tree, as the ground is, needs no comparison of depths: a mean of what is hidden is its shadow, exactly. That has no grain and no bands, whatever is wide.
//! What is beside or on the tree needs the comparison, and is given the map itself (shaders/shared/shadow.wgsl).
//!
//! The levels are copied into one image, each with an edge of nothing around it. *Tried*: reading them as mip levels. Lavapipe takes one level for four
//! pixels at once, which shows as dashes where the level changes.
//!
//! *Tried on paper and left*: variance shadow maps, which shine through where leaves lie over leaves; taps turned by noise, which crawls or shows as grain.

use ash::vk;

use super::{
    error::{RenderError, Trying as _},
    frame::{Pool, full_barrier, run_now, transition, whole},
    gpu::Gpu,
    memory::{Image, ImageDesc, View},
    pipelines::{Layout, Pipeline, PipelineDesc},
    shaders,
};

/// Texels along a side of the finest level: a fourth of the map's; shaders/shared/shadow.wgsl knows both.
const SIDE: u32 = super::shadow::SIZE / 4;
const LEVELS: u32 = 7;

/// Two halves: every device draws into it and filters it.
const FORMAT: vk::Format = vk::Format::R16G16_SFLOAT;

/// How levels are while they are made: each is written once and read once.
const MADE: vk::ImageLayout = vk::ImageLayout::GENERAL;
/// How all of them are while the stage is drawn.
const READ: vk::ImageLayout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
const FROM: vk::ImageLayout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
const TO: vk::ImageLayout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
const NEW: vk::ImageLayout = vk::ImageLayout::UNDEFINED;

/// Where all levels lie side by side, in texels.
const ROOM: [u32; 2] = [SIDE + SIDE / 2 + 4, SIDE + 4];

pub(crate) struct Shade {
    image: Image,
    all: Image,
    view: View,
    levels: Vec<View>,
    sampler: vk::Sampler,
    sets: Vec<vk::DescriptorSet>,
    first: Pipeline,
    next: Pipeline,
    layout: Layout,
    _pool: Pool,
    gpu: Gpu,
}

impl Shade {
    pub(crate) fn new(gpu: &Gpu, map: &View) -> Result<Self, RenderError> {
        let color = vk::ImageAspectFlags::COLOR;
        let drawn = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let image = image_of(gpu, [SIDE; 2], LEVELS, drawn)?;
        let all = image_of(gpu, ROOM, 1, vk::ImageUsageFlags::TRANSFER_DST)?;
        let of = |levels| View::new(gpu, image.handle, FORMAT, color, 0..1, levels);
        let levels: Vec<View> = (0..LEVELS)
            .map(|level| of(level..level + 1))
            .collect::<Result<_, _>>()?;
        let view = View::new(gpu, all.handle, FORMAT, color, 0..1, 0..1)?;
        let layout = Layout::new(gpu, &[&[vk::DescriptorType::SAMPLED_IMAGE; 2]], 0)?;
        let pool = Pool::new(
            gpu,
            LEVELS,
            &[(vk::DescriptorType::SAMPLED_IMAGE, 2 * LEVELS)],
        )?;
        let set = layout.sets.first().copied().unwrap_or_default();
        let mut sets = Vec::new();
        for level in 0..levels.len() {
            // The first level reads none, but something must stand there.
            let finer = levels.get(level.saturating_sub(1));
            sets.push(pool.set(set)?);
            write_set(gpu, sets.last().copied(), map, finer);
        }
        let [first, next] = pipelines(gpu, &layout)?;
        let shade = Self {
            sampler: sampler(gpu)?,
            image,
            all,
            view,
            levels,
            sets,
            first,
            next,
            layout,
            _pool: pool,
            gpu: gpu.clone(),
        };
        run_now(gpu, |commands| {
            shade.become_all(commands, NEW, TO);
            shade.clear(commands);
            shade.become_all(commands, TO, READ);
        })?;
        Ok(shade)
    }

    /// What a descriptor set is told of it: the image, and by what it is sampled.
    pub(crate) fn described(&self) -> [vk::DescriptorImageInfo; 2] {
        let image = vk::DescriptorImageInfo::default()
            .image_view(self.view.handle)
            .image_layout(READ);
        [
            image,
            vk::DescriptorImageInfo::default().sampler(self.sampler),
        ]
    }

    /// Makes all levels from the map, which was drawn and may be read.
    pub(crate) fn record(&self, commands: vk::CommandBuffer) {
        let mut side = SIDE;
        let color = vk::ImageAspectFlags::COLOR;
        let levels = self.image.handle;
        let begun = transition(levels, color, NEW, MADE);
        full_barrier(&self.gpu, commands, &[begun]);
        for (level, (view, set)) in self.levels.iter().zip(&self.sets).enumerate() {
            let pipeline = if level == 0 { &self.first } else { &self.next };
            self.record_level(commands, pipeline, view, *set, side);
            full_barrier(&self.gpu, commands, &[]);
            side /= 2;
        }
        let done = transition(levels, color, MADE, FROM);
        full_barrier(&self.gpu, commands, &[done]);
        self.become_all(commands, READ, TO);
        self.copy(commands);
        self.become_all(commands, TO, READ);
    }

    /// Changes how the image of all levels may be used; what is in it stays, but for a new one.
    fn become_all(&self, commands: vk::CommandBuffer, from: vk::ImageLayout, to: vk::ImageLayout) {
        let image = self.all.handle;
        let change = transition(image, vk::ImageAspectFlags::COLOR, from, to);
        full_barrier(&self.gpu, commands, &[change]);
    }

    /// Nothing is hidden where no level is copied to.
    fn clear(&self, commands: vk::CommandBuffer) {
        let nothing = vk::ClearColorValue::default();
        let whole = [whole(vk::ImageAspectFlags::COLOR)];
        // SAFETY: the image is in this layout and nothing else uses it.
        unsafe {
            let device = &self.gpu.device;
            device.cmd_clear_color_image(commands, self.all.handle, TO, &nothing, &whole);
        }
    }

    fn copy(&self, commands: vk::CommandBuffer) {
        let layers = |mip_level| vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level,
            base_array_layer: 0,
            layer_count: 1,
        };
        let regions: [vk::ImageCopy; LEVELS as usize] = std::array::from_fn(|level| {
            let level = u32::try_from(level).unwrap_or(0);
            let [x, y] = corner(level).map(|at| i32::try_from(at).unwrap_or(0));
            vk::ImageCopy::default()
                .src_subresource(layers(level))
                .dst_subresource(layers(0))
                .dst_offset(vk::Offset3D { x, y, z: 0 })
                .extent(vk::Extent3D {
                    width: SIDE >> level,
                    height: SIDE >> level,
                    depth: 1,
                })
        });
        let (from, to) = (self.image.handle, self.all.handle);
        // SAFETY: both images are in this layout; the levels fit where they go.
        unsafe {
            let device = &self.gpu.device;
            device.cmd_copy_image(commands, from, FROM, to, TO, &regions);
        }
    }

    fn record_level(
        &self,
        commands: vk::CommandBuffer,
        pipeline: &Pipeline,
        view: &View,
        set: vk::DescriptorSet,
        side: u32,
    ) {
        let area = vk::Rect2D {
            offset: vk::Offset2D::default(),
            extent: vk::Extent2D {
                width: side,
                height: side,
            },
        };
        let color = [vk::RenderingAttachmentInfo::default()
            .image_view(view.handle)
            .image_layout(MADE)
            .load_op(vk::AttachmentLoadOp::DONT_CARE)
            .store_op(vk::AttachmentStoreOp::STORE)];
        let info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&color);
        #[allow(clippy::cast_precision_loss, reason = "a small power of two")]
        let viewport = [vk::Viewport {
            width: side as f32,
            height: side as f32,
            max_depth: 1.0,
            ..vk::Viewport::default()
        }];
        let device = &self.gpu.device;
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: the command buffer is recording outside of a pass; the level that is written is not the one that the set's used image shows.
        unsafe {
            (self.gpu.newer.begin_rendering)(commands, &raw const info);
            device.cmd_set_viewport(commands, 0, &viewport);
            device.cmd_set_scissor(commands, 0, &[area]);
            device.cmd_bind_pipeline(commands, graphics, pipeline.handle);
            device.cmd_bind_descriptor_sets(commands, graphics, self.layout.handle, 0, &[set], &[]);
            device.cmd_draw(commands, 3, 1, 0, 0);
            (self.gpu.newer.end_rendering)(commands);
        }
    }
}

impl Drop for Shade {
    fn drop(&mut self) {
        // SAFETY: the renderer waits for the device before it drops its parts.
        unsafe { self.gpu.device.destroy_sampler(self.sampler, None) };
    }
}

/// Where a level lies among all, in texels.
fn corner(level: u32) -> [u32; 2] {
    let before = 1..level;
    match level {
        0 => [1, 1],
        _ => [
            SIDE + 3,
            before.map(|level| (SIDE >> level) + 2).sum::<u32>() + 1,
        ],
    }
}

fn image_of(
    gpu: &Gpu,
    [width, height]: [u32; 2],
    mips: u32,
    usage: vk::ImageUsageFlags,
) -> Result<Image, RenderError> {
    let extent = vk::Extent2D { width, height };
    let usage = usage | vk::ImageUsageFlags::SAMPLED;
    Image::new(
        gpu,
        ImageDesc {
            layers: 1,
            mips,
            ..ImageDesc::stereo("the soft shadow", FORMAT, extent, usage)
        },
    )
}

fn sampler(gpu: &Gpu) -> Result<vk::Sampler, RenderError> {
    let edge = vk::SamplerAddressMode::CLAMP_TO_EDGE;
    let info = vk::SamplerCreateInfo::default()
        .mag_filter(vk::Filter::LINEAR)
        .min_filter(vk::Filter::LINEAR)
        .address_mode_u(edge)
        .address_mode_v(edge);
    // SAFETY: a plain sampler.
    unsafe { gpu.device.create_sampler(&info, None) }.trying("making the soft shadow's sampler")
}

fn pipelines(gpu: &Gpu, layout: &Layout) -> Result<[Pipeline; 2], RenderError> {
    let desc = PipelineDesc {
        name: "the soft shadow's pipeline",
        spirv: shaders::shade::SPIRV,
        vertex: shaders::shade::SHADE_VERTEX,
        fragment: Some(shaders::shade::FIRST_FRAGMENT),
        attributes: &[],
        cull: vk::CullModeFlags::NONE,
        depth_compare: None,
        depth_write: false,
        covered: false,
        blend: None,
        samples: vk::SampleCountFlags::TYPE_1,
        view_mask: 0,
        color: FORMAT,
        depth: vk::Format::UNDEFINED,
    };
    let next = PipelineDesc {
        fragment: Some(shaders::shade::NEXT_FRAGMENT),
        ..desc
    };
    Ok([
        Pipeline::new(gpu, layout, &desc)?,
        Pipeline::new(gpu, layout, &next)?,
    ])
}

fn write_set(gpu: &Gpu, set: Option<vk::DescriptorSet>, map: &View, finer: Option<&View>) {
    let (Some(set), Some(finer)) = (set, finer) else {
        return;
    };
    let depths = [vk::DescriptorImageInfo::default()
        .image_view(map.handle)
        .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)];
    let finer = [vk::DescriptorImageInfo::default()
        .image_view(finer.handle)
        .image_layout(MADE)];
    let writes = [(0, &depths), (1, &finer)].map(|(binding, info)| {
        vk::WriteDescriptorSet::default()
            .dst_set(set)
            .dst_binding(binding)
            .descriptor_type(vk::DescriptorType::SAMPLED_IMAGE)
            .image_info(info)
    });
    // SAFETY: the set is new; the views live as long as it.
    unsafe { gpu.device.update_descriptor_sets(&writes, &[]) };
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    #[test]
    fn levels_lie_apart_with_an_edge_of_nothing() {
        let places: Vec<_> = (0..LEVELS)
            .map(|level| (corner(level), SIDE >> level))
            .collect();
        for (at, ([x, y], side)) in places.iter().enumerate() {
            assert!(*x > 0 && *y > 0);
            assert!(x + side < ROOM[0] && y + side < ROOM[1], "{at}");
            for ([left, top], other) in &places[..at] {
                let apart = |one: u32, wide: u32, two: u32, other: u32| {
                    one + wide + 1 < two || two + other + 1 < one
                };
                assert!(apart(*x, *side, *left, *other) || apart(*y, *side, *top, *other));
            }
            // As the shader counts.
            let level = u32::try_from(at).unwrap_or(0);
            if level > 0 {
                assert_eq!(*y, SIDE + 2 * level - 1 - 2 * side);
            }
        }
        assert_eq!(ROOM, [772, 516], "shaders/shared/shadow.wgsl");
        assert_eq!((SIDE, LEVELS), (512, 7), "shaders/shared/shadow.wgsl");
    }
}
