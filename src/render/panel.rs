//! The board's picture: egui's output painted into an image that the board shows.
//!
//! egui blends in gamma space and wants a target that converts nothing, while the scene wants to sample linear colour. So
//! the image is an sRGB one that is painted through a UNORM view and sampled through an sRGB view. Small
//! text stays sharp in the distance by mip levels, made after each painting. Texture
//! updates go through staging buffers in the frame's own commands: nothing waits for the queue.
//! (`egui-ash-renderer` was looked at and left: one egui version behind, blends in linear space, waits for the
//! queue at each new glyph.)

mod clip;
pub(crate) mod layer;
mod picture;

use std::collections::HashMap;

use ash::vk;
use egui::{TextureId, epaint::Primitive};
use gpu_allocator::MemoryLocation;

pub use self::layer::LayerImage;
use self::{
    clip::clip,
    picture::{Picture, sampled_set},
};
use super::{
    error::{RenderError, Trying as _},
    frame::{Pool, SLOTS, full_barrier, transition},
    gpu::Gpu,
    memory::{Buffer, Image, ImageDesc, View},
    pipelines::{Layout, Pipeline, PipelineDesc},
    shaders,
};

/// The picture as painted, and as sampled.
const PAINTED: vk::Format = vk::Format::R8G8B8A8_UNORM;
const SAMPLED: vk::Format = vk::Format::R8G8B8A8_SRGB;

/// Widest and highest picture, and most textures at a time.
const LARGEST: u32 = 4096;
const MOST_TEXTURES: u32 = 64;

/// An image that shaders sample.
struct Texture {
    image: Image,
    _view: View,
    set: vk::DescriptorSet,
    /// Whether it was ever written.
    fresh: bool,
    // After the set that it holds.
    _pool: Pool,
}

/// Pixels on their way into a texture.
struct Patch {
    texture: TextureId,
    staging: Buffer,
    offset: [i32; 2],
    size: [u32; 2],
}

/// A run of indices with its texture and clip rectangle in pixels.
#[derive(Clone, Copy)]
struct Draw {
    texture: TextureId,
    clip: vk::Rect2D,
    indices: u32,
    first: u32,
    vertex: i32,
}

/// What is kept until the frames that use it are done.
#[allow(dead_code, reason = "kept to be dropped later")]
enum Garbage {
    Texture(Texture),
    Picture(Picture),
    Buffer(Buffer),
}

/// egui's painter.
pub(crate) struct Panel {
    sampler: vk::Sampler,
    layout: Layout,
    pipeline: Pipeline,
    picture: Picture,
    board_set: vk::DescriptorSetLayout,
    textures: HashMap<TextureId, Texture>,
    patches: Vec<Patch>,
    vertices: Vec<egui::epaint::Vertex>,
    indices: Vec<u32>,
    draws: Vec<Draw>,
    points: [f32; 2],
    buffers: [Option<[Buffer; 2]>; SLOTS],
    garbage: Vec<(u64, Garbage)>,
    /// Painted at least once.
    painted: bool,
    /// Painting waits for the next frame.
    due: bool,
    /// Shown by a headset's runtime and not in the scene.
    pub(crate) lifted: bool,
    /// Where the picture goes with the next frame.
    pub(crate) copy: Option<LayerImage>,
    gpu: Gpu,
}

impl Panel {
    pub(crate) fn new(gpu: &Gpu, board: &Layout) -> Result<Self, RenderError> {
        let layout = Layout::new(
            gpu,
            &[&[
                vk::DescriptorType::SAMPLED_IMAGE,
                vk::DescriptorType::SAMPLER,
            ]],
            8,
        )?;
        let blend = vk::PipelineColorBlendAttachmentState::default()
            .blend_enable(true)
            .src_color_blend_factor(vk::BlendFactor::ONE)
            .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .src_alpha_blend_factor(vk::BlendFactor::ONE)
            .dst_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .color_write_mask(vk::ColorComponentFlags::RGBA);
        let pipeline = Pipeline::new(
            gpu,
            &layout,
            &PipelineDesc {
                name: "the panel's pipeline",
                spirv: shaders::panel::SPIRV,
                vertex: shaders::panel::PANEL_VERTEX,
                fragment: Some(shaders::panel::PANEL_FRAGMENT),
                attributes: &[
                    vk::Format::R32G32_SFLOAT,
                    vk::Format::R32G32_SFLOAT,
                    vk::Format::R8G8B8A8_UNORM,
                ],
                cull: vk::CullModeFlags::NONE,
                depth_compare: None,
                depth_write: false,
                covered: false,
                blend: Some(blend),
                samples: vk::SampleCountFlags::TYPE_1,
                view_mask: 0,
                color: PAINTED,
                depth: vk::Format::UNDEFINED,
            },
        )?;
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(vk::Filter::LINEAR)
            .min_filter(vk::Filter::LINEAR)
            .mipmap_mode(vk::SamplerMipmapMode::LINEAR)
            .max_lod(vk::LOD_CLAMP_NONE)
            .address_mode_u(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE);
        // SAFETY: a plain sampler.
        let sampler = unsafe { gpu.device.create_sampler(&info, None) }
            .trying("making the panel's sampler")?;
        let board_set = board.sets.get(1).copied().unwrap_or_default();
        let picture = match Picture::new(gpu, board_set, sampler, [1, 1]) {
            Ok(picture) => picture,
            Err(error) => {
                // SAFETY: nothing uses the sampler yet.
                unsafe { gpu.device.destroy_sampler(sampler, None) };
                return Err(error);
            }
        };
        Ok(Self {
            sampler,
            layout,
            pipeline,
            picture,
            board_set,
            textures: HashMap::new(),
            patches: Vec::new(),
            vertices: Vec::new(),
            indices: Vec::new(),
            draws: Vec::new(),
            points: [1.0, 1.0],
            buffers: [const { None }; SLOTS],
            garbage: Vec::new(),
            painted: false,
            due: false,
            lifted: false,
            copy: None,
            gpu: gpu.clone(),
        })
    }

    /// The set that the board's shader reads.
    pub(crate) fn set(&self) -> vk::DescriptorSet {
        self.picture.set
    }

    /// Whether there is anything to show.
    pub(crate) fn painted(&self) -> bool {
        self.painted
    }

    /// Pixels of what is shown from the next frame on, where there is anything.
    pub(crate) fn extent(&self) -> Option<vk::Extent2D> {
        (self.painted || self.due).then_some(self.picture.image.desc.extent)
    }

    /// Takes egui's output for the next frame and clears `textures`.
    pub(crate) fn paint(
        &mut self,
        primitives: &[egui::ClippedPrimitive],
        textures: &mut egui::TexturesDelta,
        size_px: [u32; 2],
        pixels_per_point: f32,
        frame: u64,
    ) -> Result<(), RenderError> {
        let size = size_px.map(|side| side.clamp(1, LARGEST));
        if size
            != [
                self.picture.image.desc.extent.width,
                self.picture.image.desc.extent.height,
            ]
        {
            let new = Picture::new(&self.gpu, self.board_set, self.sampler, size)?;
            self.garbage.push((
                frame,
                Garbage::Picture(std::mem::replace(&mut self.picture, new)),
            ));
        }
        let taken = self.take_textures(textures, frame);
        textures.clear();
        taken?;

        let scale = if pixels_per_point.is_finite() && pixels_per_point > 0.01 {
            pixels_per_point
        } else {
            1.0
        };
        #[allow(clippy::cast_precision_loss, reason = "at most 4096")]
        let points = size.map(|side| side as f32 / scale);
        self.points = points;
        self.vertices.clear();
        self.indices.clear();
        self.draws.clear();
        for egui::ClippedPrimitive {
            clip_rect,
            primitive,
        } in primitives
        {
            let Primitive::Mesh(mesh) = primitive else {
                continue;
            };
            let clip = clip(clip_rect, scale, size);
            let most = u32::try_from(mesh.vertices.len()).unwrap_or(0);
            if clip.extent.width == 0
                || clip.extent.height == 0
                || mesh.indices.iter().any(|index| *index >= most)
            {
                continue;
            }
            self.draws.push(Draw {
                texture: mesh.texture_id,
                clip,
                indices: u32::try_from(mesh.indices.len()).unwrap_or(0),
                first: u32::try_from(self.indices.len()).unwrap_or(0),
                vertex: i32::try_from(self.vertices.len()).unwrap_or(0),
            });
            self.vertices.extend_from_slice(&mesh.vertices);
            self.indices.extend_from_slice(&mesh.indices);
        }
        self.due = true;
        Ok(())
    }

    fn take_textures(
        &mut self,
        delta: &egui::TexturesDelta,
        frame: u64,
    ) -> Result<(), RenderError> {
        let mut ids: Vec<TextureId> = delta.set.keys().copied().collect();
        ids.sort_unstable();
        for id in ids {
            for change in delta.set.get(&id).into_iter().flatten() {
                let egui::ImageData::Color(image) = &change.image;
                let size = image
                    .size
                    .map(|side| u32::try_from(side).unwrap_or(u32::MAX));
                let offset = match change.pos {
                    None => {
                        self.make_texture(id, size, frame)?;
                        [0, 0]
                    }
                    Some(at) => at.map(|side| u32::try_from(side).unwrap_or(u32::MAX)),
                };
                let room = self
                    .textures
                    .get(&id)
                    .map(|texture| texture.image.desc.extent)
                    .unwrap_or_default();
                let fits = |at: u32, size: u32, room: u32| {
                    size > 0 && at.checked_add(size).is_some_and(|end| end <= room)
                };
                if !fits(offset[0], size[0], room.width) || !fits(offset[1], size[1], room.height) {
                    return Err(RenderError::Unsupported(
                        "the panel's text uses a texture that does not fit".to_owned(),
                    ));
                }
                let mut staging = Buffer::new(
                    &self.gpu,
                    "the panel's pixels",
                    (image.pixels.len() * 4) as u64,
                    vk::BufferUsageFlags::TRANSFER_SRC,
                    MemoryLocation::CpuToGpu,
                )?;
                staging.write(0, &image.pixels);
                let offset = offset.map(|side| i32::try_from(side).unwrap_or(0));
                self.patches.push(Patch {
                    texture: id,
                    staging,
                    offset,
                    size,
                });
            }
        }
        for id in &delta.free {
            if let Some(texture) = self.textures.remove(id) {
                self.garbage.push((frame + 1, Garbage::Texture(texture)));
            }
        }
        Ok(())
    }

    fn make_texture(
        &mut self,
        id: TextureId,
        size: [u32; 2],
        frame: u64,
    ) -> Result<(), RenderError> {
        let same = |texture: &Texture| {
            [
                texture.image.desc.extent.width,
                texture.image.desc.extent.height,
            ] == size
        };
        if self.textures.get(&id).is_some_and(same) {
            return Ok(());
        }
        if self.textures.len() >= MOST_TEXTURES as usize
            || size.iter().any(|side| *side == 0 || *side > 2 * LARGEST)
        {
            return Err(RenderError::Unsupported(
                "the panel's text uses too many or too large textures".to_owned(),
            ));
        }
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let extent = vk::Extent2D {
            width: size[0],
            height: size[1],
        };
        let image = Image::new(
            &self.gpu,
            ImageDesc {
                layers: 1,
                ..ImageDesc::stereo("a panel's texture", PAINTED, extent, usage)
            },
        )?;
        let view = View::new(
            &self.gpu,
            image.handle,
            PAINTED,
            vk::ImageAspectFlags::COLOR,
            0..1,
            0..1,
        )?;
        let layout = self.layout.sets.first().copied().unwrap_or_default();
        let (pool, set) = sampled_set(&self.gpu, layout, &view, self.sampler)?;
        let new = Texture {
            image,
            _view: view,
            set,
            fresh: true,
            _pool: pool,
        };
        if let Some(old) = self.textures.insert(id, new) {
            self.garbage.push((frame, Garbage::Texture(old)));
            // Patches of the old one would not fit the new.
            self.patches.retain(|patch| patch.texture != id);
        }
        Ok(())
    }

    /// Records what is due; true when there was anything. `done`: the last frame that the device has finished.
    pub(crate) fn record(
        &mut self,
        gpu: &Gpu,
        commands: vk::CommandBuffer,
        slot: usize,
        frame: u64,
        done: u64,
    ) -> Result<bool, RenderError> {
        self.garbage.retain(|(used, _)| *used > done);
        let recorded = self.record_due(gpu, commands, slot, frame)?;
        if let Some(layer) = self.copy.take().filter(|_| self.painted) {
            self.picture.record_copy(gpu, commands, &layer);
        }
        Ok(recorded)
    }

    /// Records the painting, where it is due.
    fn record_due(
        &mut self,
        gpu: &Gpu,
        commands: vk::CommandBuffer,
        slot: usize,
        frame: u64,
    ) -> Result<bool, RenderError> {
        if !std::mem::take(&mut self.due) {
            return Ok(false);
        }
        self.record_patches(gpu, commands, frame);

        let bytes = [
            (
                size_of_val(self.vertices.as_slice()) as u64,
                vk::BufferUsageFlags::VERTEX_BUFFER,
            ),
            (
                size_of_val(self.indices.as_slice()) as u64,
                vk::BufferUsageFlags::INDEX_BUFFER,
            ),
        ];
        let small =
            |buffers: &[Buffer; 2]| buffers[0].size < bytes[0].0 || buffers[1].size < bytes[1].0;
        let Some(place) = self.buffers.get_mut(slot) else {
            return Ok(false);
        };
        if place.as_ref().is_none_or(small) {
            let make = |(size, usage): (u64, _)| {
                Buffer::new(
                    gpu,
                    "the panel's triangles",
                    size.next_power_of_two(),
                    usage,
                    MemoryLocation::CpuToGpu,
                )
            };
            *place = Some([make(bytes[0])?, make(bytes[1])?]);
        }
        if let Some([vertices, indices]) = place {
            vertices.write(0, &self.vertices);
            indices.write(0, &self.indices);
        }
        self.record_painting(gpu, commands, slot);
        self.picture.record_mips(gpu, commands);
        self.painted = true;
        Ok(true)
    }

    fn record_patches(&mut self, gpu: &Gpu, commands: vk::CommandBuffer, frame: u64) {
        let (written, read) = (
            vk::ImageLayout::TRANSFER_DST_OPTIMAL,
            vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        );
        let color = vk::ImageAspectFlags::COLOR;
        for patch in self.patches.drain(..) {
            if let Some(texture) = self.textures.get_mut(&patch.texture) {
                let before = if std::mem::take(&mut texture.fresh) {
                    vk::ImageLayout::UNDEFINED
                } else {
                    read
                };
                full_barrier(
                    gpu,
                    commands,
                    &[transition(texture.image.handle, color, before, written)],
                );
                let region = [vk::BufferImageCopy::default()
                    .image_subresource(
                        vk::ImageSubresourceLayers::default()
                            .aspect_mask(color)
                            .layer_count(1),
                    )
                    .image_offset(vk::Offset3D {
                        x: patch.offset[0],
                        y: patch.offset[1],
                        z: 0,
                    })
                    .image_extent(vk::Extent3D {
                        width: patch.size[0],
                        height: patch.size[1],
                        depth: 1,
                    })];
                // SAFETY: the patch lies within the texture; both live until the frame is done.
                unsafe {
                    gpu.device.cmd_copy_buffer_to_image(
                        commands,
                        patch.staging.handle,
                        texture.image.handle,
                        written,
                        &region,
                    );
                }
                full_barrier(
                    gpu,
                    commands,
                    &[transition(texture.image.handle, color, written, read)],
                );
            }
            self.garbage.push((frame, Garbage::Buffer(patch.staging)));
        }
    }

    fn record_painting(&self, gpu: &Gpu, commands: vk::CommandBuffer, slot: usize) {
        let attachment = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
        let color = vk::ImageAspectFlags::COLOR;
        full_barrier(
            gpu,
            commands,
            &[transition(
                self.picture.image.handle,
                color,
                vk::ImageLayout::UNDEFINED,
                attachment,
            )],
        );
        let target = [vk::RenderingAttachmentInfo::default()
            .image_view(self.picture.paint.handle)
            .image_layout(attachment)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)];
        let extent = self.picture.image.desc.extent;
        let info = vk::RenderingInfo::default()
            .render_area(vk::Rect2D {
                offset: vk::Offset2D::default(),
                extent,
            })
            .layer_count(1)
            .color_attachments(&target);
        #[allow(clippy::cast_precision_loss, reason = "at most 4096")]
        let viewport = [vk::Viewport {
            width: extent.width as f32,
            height: extent.height as f32,
            max_depth: 1.0,
            ..Default::default()
        }];
        let Some(Some([vertices, indices])) = self.buffers.get(slot) else {
            return;
        };
        let device = &gpu.device;
        let layout = self.layout.handle;
        let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        // SAFETY: recording; all handles live until the frame is done; indices were checked in `paint`.
        unsafe {
            (gpu.newer.begin_rendering)(commands, &raw const info);
            device.cmd_bind_pipeline(
                commands,
                vk::PipelineBindPoint::GRAPHICS,
                self.pipeline.handle,
            );
            device.cmd_set_viewport(commands, 0, &viewport);
            device.cmd_bind_vertex_buffers(commands, 0, &[vertices.handle], &[0]);
            device.cmd_bind_index_buffer(commands, indices.handle, 0, vk::IndexType::UINT32);
            device.cmd_push_constants(
                commands,
                layout,
                stages,
                0,
                bytemuck::bytes_of(&self.points),
            );
            for draw in &self.draws {
                let Some(texture) = self
                    .textures
                    .get(&draw.texture)
                    .filter(|texture| !texture.fresh)
                else {
                    continue;
                };
                device.cmd_set_scissor(commands, 0, &[draw.clip]);
                device.cmd_bind_descriptor_sets(
                    commands,
                    vk::PipelineBindPoint::GRAPHICS,
                    layout,
                    0,
                    &[texture.set],
                    &[],
                );
                device.cmd_draw_indexed(commands, draw.indices, 1, draw.first, draw.vertex, 0);
            }
            (gpu.newer.end_rendering)(commands);
        }
    }
}

impl Drop for Panel {
    fn drop(&mut self) {
        // SAFETY: the renderer waits for the device before it drops its parts.
        unsafe { self.gpu.device.destroy_sampler(self.sampler, None) };
    }
}
