//! Descriptor layouts and pipelines, all made at start.

use std::ffi::CStr;

use ash::vk;

use super::{
    error::{RenderError, Trying as _},
    gpu::Gpu,
    model_upload::ModelData,
    shaders,
};

/// Samples a pixel.
pub(crate) const SAMPLES: vk::SampleCountFlags = vk::SampleCountFlags::TYPE_4;

/// A pipeline layout with its descriptor set layouts.
pub(crate) struct Layout {
    pub(crate) handle: vk::PipelineLayout,
    pub(crate) sets: Vec<vk::DescriptorSetLayout>,
    gpu: Gpu,
}

impl Layout {
    /// For drawing. `sets`: for each set its bindings' types; `immediates`: bytes of push constants.
    pub(crate) fn new(
        gpu: &Gpu,
        sets: &[&[vk::DescriptorType]],
        immediates: u32,
    ) -> Result<Self, RenderError> {
        let drawing = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        Self::staged(gpu, sets, immediates, drawing)
    }

    /// For other stages.
    pub(crate) fn staged(
        gpu: &Gpu,
        sets: &[&[vk::DescriptorType]],
        immediates: u32,
        stages: vk::ShaderStageFlags,
    ) -> Result<Self, RenderError> {
        let mut layout = Self {
            handle: vk::PipelineLayout::null(),
            sets: Vec::new(),
            gpu: gpu.clone(),
        };
        for types in sets {
            let bindings: Vec<_> = (0..)
                .zip(*types)
                .map(|(binding, kind)| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(binding)
                        .descriptor_type(*kind)
                        .descriptor_count(1)
                        .stage_flags(stages)
                })
                .collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: plain bindings.
            let set = unsafe { gpu.device.create_descriptor_set_layout(&info, None) }
                .trying("making a descriptor layout")?;
            layout.sets.push(set);
        }
        let ranges = [vk::PushConstantRange::default()
            .stage_flags(stages)
            .size(immediates)];
        let info = vk::PipelineLayoutCreateInfo::default()
            .set_layouts(&layout.sets)
            .push_constant_ranges(if immediates == 0 { &[] } else { &ranges });
        // SAFETY: the set layouts were just made.
        layout.handle = unsafe { gpu.device.create_pipeline_layout(&info, None) }
            .trying("making a pipeline layout")?;
        Ok(layout)
    }
}

impl Drop for Layout {
    fn drop(&mut self) {
        // SAFETY: owners outlive no command buffer that is still running (`Renderer` waits in its `Drop`).
        unsafe {
            self.gpu.device.destroy_pipeline_layout(self.handle, None);
            for set in &self.sets {
                self.gpu.device.destroy_descriptor_set_layout(*set, None);
            }
        }
    }
}

/// What distinguishes a pipeline from another.
#[derive(Clone, Copy)]
pub(crate) struct PipelineDesc<'a> {
    pub(crate) name: &'static str,
    pub(crate) spirv: &'a [u32],
    pub(crate) vertex: &'a CStr,
    /// None: depth only.
    pub(crate) fragment: Option<&'a CStr>,
    /// Bytes between vertices and the formats of their 16-byte attributes; empty: pulled.
    pub(crate) attributes: &'a [vk::Format],
    pub(crate) cull: vk::CullModeFlags,
    pub(crate) depth_compare: Option<vk::CompareOp>,
    pub(crate) depth_write: bool,
    /// Alpha says how many samples are covered, and is not written.
    pub(crate) covered: bool,
    pub(crate) blend: Option<vk::PipelineColorBlendAttachmentState>,
    pub(crate) samples: vk::SampleCountFlags,
    pub(crate) view_mask: u32,
    pub(crate) color: vk::Format,
    pub(crate) depth: vk::Format,
}

/// A graphics pipeline.
pub(crate) struct Pipeline {
    pub(crate) handle: vk::Pipeline,
    gpu: Gpu,
}

impl Pipeline {
    pub(crate) fn new(
        gpu: &Gpu,
        layout: &Layout,
        desc: &PipelineDesc<'_>,
    ) -> Result<Self, RenderError> {
        let code = vk::ShaderModuleCreateInfo::default().code(desc.spirv);
        // SAFETY: naga made and validated the code.
        let module = unsafe { gpu.device.create_shader_module(&code, None) }.trying(desc.name)?;
        let made = Self::with_module(gpu, layout, desc, module);
        // SAFETY: pipelines do not need their module once they are made.
        unsafe { gpu.device.destroy_shader_module(module, None) };
        made
    }

    /// One that computes.
    pub(crate) fn compute(
        gpu: &Gpu,
        layout: &Layout,
        name: &'static str,
        spirv: &[u32],
        entry: &CStr,
    ) -> Result<Self, RenderError> {
        let code = vk::ShaderModuleCreateInfo::default().code(spirv);
        // SAFETY: naga made and validated the code.
        let module = unsafe { gpu.device.create_shader_module(&code, None) }.trying(name)?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(entry);
        let info = vk::ComputePipelineCreateInfo::default()
            .stage(stage)
            .layout(layout.handle);
        let cache = vk::PipelineCache::null();
        // SAFETY: everything `info` points to lives until the call returns; pipelines do not need their module once they are made.
        let made = unsafe {
            let made = gpu.device.create_compute_pipelines(cache, &[info], None);
            gpu.device.destroy_shader_module(module, None);
            made
        };
        let made = made.map_err(|(_, result)| RenderError::from_vulkan(name, result))?;
        gpu.pipeline_was_made();
        Ok(Self {
            handle: made.first().copied().unwrap_or_default(),
            gpu: gpu.clone(),
        })
    }

    fn with_module(
        gpu: &Gpu,
        layout: &Layout,
        desc: &PipelineDesc<'_>,
        module: vk::ShaderModule,
    ) -> Result<Self, RenderError> {
        let stage = |flag, name| {
            vk::PipelineShaderStageCreateInfo::default()
                .stage(flag)
                .module(module)
                .name(name)
        };
        let mut stages = vec![stage(vk::ShaderStageFlags::VERTEX, desc.vertex)];
        stages.extend(
            desc.fragment
                .map(|name| stage(vk::ShaderStageFlags::FRAGMENT, name)),
        );

        // An attribute has four floats, except in the panel's vertices.
        let mut stride = 0;
        let attributes: Vec<_> = (0..)
            .zip(desc.attributes)
            .map(|(location, format)| {
                let attribute = vk::VertexInputAttributeDescription::default()
                    .location(location)
                    .format(*format)
                    .offset(stride);
                stride += match *format {
                    vk::Format::R32G32B32A32_SFLOAT => 16,
                    vk::Format::R32G32_SFLOAT => 8,
                    _ => 4,
                };
                attribute
            })
            .collect();
        let bindings = [vk::VertexInputBindingDescription::default()
            .stride(stride)
            .input_rate(vk::VertexInputRate::VERTEX)];
        let mut input = vk::PipelineVertexInputStateCreateInfo::default();
        if !attributes.is_empty() {
            input = input
                .vertex_binding_descriptions(&bindings)
                .vertex_attribute_descriptions(&attributes);
        }
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport = vk::PipelineViewportStateCreateInfo::default()
            .viewport_count(1)
            .scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(desc.cull)
            .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
            .line_width(1.0);
        let multisample = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(desc.samples)
            .alpha_to_coverage_enable(desc.covered);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(desc.depth_compare.is_some())
            .depth_write_enable(desc.depth_write)
            .depth_compare_op(desc.depth_compare.unwrap_or(vk::CompareOp::ALWAYS));
        let rgb =
            vk::ColorComponentFlags::R | vk::ColorComponentFlags::G | vk::ColorComponentFlags::B;
        let written = if desc.covered {
            rgb
        } else {
            vk::ColorComponentFlags::RGBA
        };
        let attachments = [desc.blend.unwrap_or_else(|| {
            vk::PipelineColorBlendAttachmentState::default().color_write_mask(written)
        })];
        let mut blend = vk::PipelineColorBlendStateCreateInfo::default();
        let dynamic = vk::PipelineDynamicStateCreateInfo::default()
            .dynamic_states(&[vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR]);
        let formats = [desc.color];
        let mut rendering = vk::PipelineRenderingCreateInfo::default()
            .view_mask(desc.view_mask)
            .depth_attachment_format(desc.depth);
        if desc.fragment.is_some() {
            rendering = rendering.color_attachment_formats(&formats);
            blend = blend.attachments(&attachments);
        }
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&multisample)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(layout.handle)
            .push_next(&mut rendering);
        // SAFETY: everything `info` points to lives until the call returns.
        match unsafe {
            gpu.device
                .create_graphics_pipelines(vk::PipelineCache::null(), &[info], None)
        } {
            Ok(made) => {
                gpu.pipeline_was_made();
                Ok(Self {
                    handle: made.first().copied().unwrap_or_default(),
                    gpu: gpu.clone(),
                })
            }
            Err((_, result)) => Err(RenderError::from_vulkan(desc.name, result)),
        }
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        // SAFETY: as for layouts.
        unsafe { self.gpu.device.destroy_pipeline(self.handle, None) };
    }
}

/// How many ways images are sampled.
pub(crate) const IMAGE_SAMPLERS: usize = 4;

/// What models' images are sampled by: repeated across and down, across alone, down alone, not at all.
pub(crate) struct ImageSamplers {
    pub(crate) handles: [vk::Sampler; IMAGE_SAMPLERS],
    gpu: Gpu,
}

impl ImageSamplers {
    fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let (repeat, clamp) = (
            vk::SamplerAddressMode::REPEAT,
            vk::SamplerAddressMode::CLAMP_TO_EDGE,
        );
        let mut samplers = Self {
            handles: [vk::Sampler::null(); IMAGE_SAMPLERS],
            gpu: gpu.clone(),
        };
        let ways = [
            [repeat, repeat],
            [repeat, clamp],
            [clamp, repeat],
            [clamp, clamp],
        ];
        for (handle, [across, down]) in samplers.handles.iter_mut().zip(ways) {
            let info = vk::SamplerCreateInfo::default()
                .mag_filter(vk::Filter::LINEAR)
                .min_filter(vk::Filter::LINEAR)
                .mipmap_mode(vk::SamplerMipmapMode::LINEAR)
                .address_mode_u(across)
                .address_mode_v(down)
                .max_lod(vk::LOD_CLAMP_NONE);
            // SAFETY: a plain sampler.
            *handle = unsafe { gpu.device.create_sampler(&info, None) }
                .trying("making a sampler of models' images")?;
        }
        Ok(samplers)
    }
}

impl Drop for ImageSamplers {
    fn drop(&mut self) {
        for sampler in self.handles {
            // SAFETY: as for layouts; those that were not made are null, which is nothing.
            unsafe { self.gpu.device.destroy_sampler(sampler, None) };
        }
    }
}

/// What the stage's pipelines draw into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Formats {
    pub(crate) color: vk::Format,
    pub(crate) depth: vk::Format,
    pub(crate) view_mask: u32,
}

/// The stage's pipelines.
pub(crate) struct Pipelines {
    /// Set 0: the frame. Set 1: a chunk of the tree. Set 2: the batches to draw.
    pub(crate) tree_layout: Layout,
    /// Set 0: the frame. Set 1: the panel's picture.
    pub(crate) board_layout: Layout,
    /// Set 0: the frame. Set 1: a chunk of a model. Set 2: the triangles to draw, and where models stand. Set 3: its materials and images, where it is drawn with them.
    pub(crate) model_layout: Layout,
    pub(crate) image_samplers: ImageSamplers,
    pub(crate) faces: Pipeline,
    pub(crate) textured: Pipeline,
    pub(crate) wire: Pipeline,
    pub(crate) points: Pipeline,
    pub(crate) x_rays: Pipeline,
    pub(crate) model_shadow: Pipeline,
    pub(crate) sky: Pipeline,
    pub(crate) ground: Pipeline,
    pub(crate) tubes: Pipeline,
    pub(crate) shadow: Pipeline,
    pub(crate) organs: Pipeline,
    pub(crate) organ_shadow: Pipeline,
    pub(crate) leaves: Pipeline,
    pub(crate) leaf_shadow: Pipeline,
    pub(crate) rods: Pipeline,
    pub(crate) ghosts: Pipeline,
    pub(crate) solids: Pipeline,
    pub(crate) board: Pipeline,
}

/// Format of the shadow map.
pub(crate) const SHADOW_FORMAT: vk::Format = vk::Format::D32_SFLOAT;

impl Pipelines {
    pub(crate) fn new(gpu: &Gpu, formats: &Formats) -> Result<Self, RenderError> {
        use vk::DescriptorType as Kind;
        let frame = [
            Kind::UNIFORM_BUFFER_DYNAMIC,
            Kind::SAMPLED_IMAGE,
            Kind::SAMPLER,
            Kind::STORAGE_BUFFER,
            Kind::STORAGE_BUFFER,
            Kind::SAMPLED_IMAGE,
            Kind::SAMPLER,
            Kind::SAMPLED_IMAGE,
            Kind::SAMPLED_IMAGE,
        ];
        let chunk = [
            Kind::STORAGE_BUFFER,
            Kind::STORAGE_BUFFER,
            Kind::STORAGE_BUFFER,
            Kind::SAMPLED_IMAGE,
            Kind::SAMPLER,
        ];
        let tree_layout = Layout::new(gpu, &[&frame, &chunk, &[Kind::STORAGE_BUFFER]], 0)?;
        let board_layout = Layout::new(gpu, &[&frame, &[Kind::SAMPLED_IMAGE, Kind::SAMPLER]], 0)?;

        let immediates = u32::try_from(size_of::<ModelData>()).unwrap_or(0);
        let model_layout = Layout::new(
            gpu,
            &[
                &frame,
                &[Kind::STORAGE_BUFFER; 3],
                &[Kind::STORAGE_BUFFER; 2],
                &[
                    Kind::SAMPLED_IMAGE,
                    Kind::SAMPLER,
                    Kind::SAMPLER,
                    Kind::SAMPLER,
                    Kind::SAMPLER,
                    Kind::STORAGE_BUFFER,
                ],
            ],
            immediates,
        )?;

        let plain = PipelineDesc {
            name: "the sky's pipeline",
            spirv: shaders::sky::SPIRV,
            vertex: shaders::sky::SKY_VERTEX,
            fragment: Some(shaders::sky::SKY_FRAGMENT),
            attributes: &[],
            cull: vk::CullModeFlags::NONE,
            // Depth is reversed: greater is nearer. The sky, at 0, fills what is still clear.
            depth_compare: Some(vk::CompareOp::GREATER_OR_EQUAL),
            depth_write: false,
            covered: false,
            blend: None,
            samples: SAMPLES,
            view_mask: formats.view_mask,
            color: formats.color,
            depth: formats.depth,
        };
        let solid = PipelineDesc {
            cull: vk::CullModeFlags::BACK,
            depth_compare: Some(vk::CompareOp::GREATER),
            depth_write: true,
            ..plain
        };
        let sphere = [vk::Format::R32G32B32A32_SFLOAT];
        let solid_model = [vk::Format::R32G32B32A32_SFLOAT; 2];
        let tubes = PipelineDesc {
            name: "the tree's pipeline",
            spirv: shaders::tree::SPIRV,
            vertex: shaders::tree::TUBE_VERTEX,
            fragment: Some(shaders::tree::TREE_FRAGMENT),
            covered: true,
            ..solid
        };
        let rods = PipelineDesc {
            name: "the rods' pipeline",
            spirv: shaders::rod::SPIRV,
            vertex: shaders::rod::ROD_VERTEX,
            fragment: Some(shaders::rod::ROD_FRAGMENT),
            attributes: &sphere,
            ..solid
        };
        let organs = PipelineDesc {
            name: "the organs' pipeline",
            spirv: shaders::organ::SPIRV,
            vertex: shaders::organ::ORGAN_VERTEX,
            fragment: Some(shaders::organ::ORGAN_FRAGMENT),
            cull: vk::CullModeFlags::NONE,
            ..solid
        };
        let leaves = PipelineDesc {
            name: "the leaves' pipeline",
            spirv: shaders::leaf::SPIRV,
            vertex: shaders::leaf::LEAF_VERTEX,
            fragment: Some(shaders::leaf::LEAF_FRAGMENT),
            ..organs
        };
        let faces = PipelineDesc {
            name: "the models' pipeline",
            spirv: shaders::model::SPIRV,
            vertex: shaders::model::MODEL_VERTEX,
            fragment: Some(shaders::model::FACE_FRAGMENT),
            cull: vk::CullModeFlags::NONE,
            ..solid
        };
        let over = vk::PipelineColorBlendAttachmentState {
            blend_enable: vk::TRUE,
            src_color_blend_factor: vk::BlendFactor::SRC_ALPHA,
            dst_color_blend_factor: vk::BlendFactor::ONE_MINUS_SRC_ALPHA,
            color_blend_op: vk::BlendOp::ADD,
            src_alpha_blend_factor: vk::BlendFactor::ZERO,
            dst_alpha_blend_factor: vk::BlendFactor::ONE,
            alpha_blend_op: vk::BlendOp::ADD,
            color_write_mask: vk::ColorComponentFlags::RGBA,
        };
        let cast = |desc: PipelineDesc<'static>| PipelineDesc {
            name: "the shadow's pipeline",
            fragment: None,
            covered: false,
            cull: vk::CullModeFlags::NONE,
            depth_compare: Some(vk::CompareOp::LESS),
            samples: vk::SampleCountFlags::TYPE_1,
            view_mask: 0,
            depth: SHADOW_FORMAT,
            ..desc
        };
        let pipeline = |desc: PipelineDesc<'_>| Pipeline::new(gpu, &tree_layout, &desc);
        let model = |desc: PipelineDesc<'_>| Pipeline::new(gpu, &model_layout, &desc);
        Ok(Self {
            faces: model(faces)?,
            textured: model(PipelineDesc {
                name: "the textured models' pipeline",
                spirv: shaders::textured::SPIRV,
                vertex: shaders::textured::TEXTURED_VERTEX,
                fragment: Some(shaders::textured::TEXTURED_FRAGMENT),
                covered: true,
                ..faces
            })?,
            image_samplers: ImageSamplers::new(gpu)?,
            wire: model(PipelineDesc {
                fragment: Some(shaders::model::WIRE_FRAGMENT),
                covered: true,
                ..faces
            })?,
            points: model(PipelineDesc {
                vertex: shaders::model::POINT_VERTEX,
                fragment: Some(shaders::model::POINT_FRAGMENT),
                ..faces
            })?,
            x_rays: model(PipelineDesc {
                fragment: Some(shaders::model::X_RAY_FRAGMENT),
                depth_write: false,
                blend: Some(over),
                ..faces
            })?,
            model_shadow: model(cast(PipelineDesc {
                vertex: shaders::model::MODEL_SHADOW_VERTEX,
                ..faces
            }))?,
            model_layout,
            sky: pipeline(plain)?,
            ground: pipeline(PipelineDesc {
                name: "the ground's pipeline",
                spirv: shaders::ground::SPIRV,
                vertex: shaders::ground::GROUND_VERTEX,
                fragment: Some(shaders::ground::GROUND_FRAGMENT),
                ..solid
            })?,
            tubes: pipeline(tubes)?,
            shadow: pipeline(cast(PipelineDesc {
                vertex: shaders::tree::SHADOW_VERTEX,
                ..tubes
            }))?,
            organs: pipeline(organs)?,
            organ_shadow: pipeline(cast(PipelineDesc {
                vertex: shaders::organ::ORGAN_SHADOW_VERTEX,
                ..organs
            }))?,
            leaves: pipeline(leaves)?,
            leaf_shadow: pipeline(cast(PipelineDesc {
                vertex: shaders::leaf::LEAF_SHADOW_VERTEX,
                ..leaves
            }))?,
            rods: pipeline(rods)?,
            ghosts: pipeline(PipelineDesc {
                name: "the ghosts' pipeline",
                fragment: Some(shaders::rod::GHOST_FRAGMENT),
                covered: true,
                ..rods
            })?,
            solids: pipeline(PipelineDesc {
                name: "the solids' pipeline",
                spirv: shaders::solid::SPIRV,
                vertex: shaders::solid::SOLID_VERTEX,
                fragment: Some(shaders::solid::SOLID_FRAGMENT),
                attributes: &solid_model,
                ..solid
            })?,
            board: Pipeline::new(
                gpu,
                &board_layout,
                &PipelineDesc {
                    name: "the board's pipeline",
                    spirv: shaders::board::SPIRV,
                    vertex: shaders::board::BOARD_VERTEX,
                    fragment: Some(shaders::board::BOARD_FRAGMENT),
                    covered: true,
                    cull: vk::CullModeFlags::NONE,
                    ..solid
                },
            )?,
            tree_layout,
            board_layout,
        })
    }
}
