//! What a headset's lenses hide of both eyes' pictures: covered before anything is drawn, so that it costs nothing.
//!
//! The triangles are given by the tangents of the angles at which they are seen, so they fit whatever field of view a
//! frame has. One buffer holds those of both eyes, each corner with its eye's number: a pass over both eyes draws
//! all of them in each view, and the vertex shader throws the other eye's away.

use ash::vk;
use bytemuck::{Pod, Zeroable};
use gpu_allocator::MemoryLocation;

use super::{
    error::RenderError,
    eye::Eye,
    gpu::Gpu,
    memory::Buffer,
    pipelines::{Formats, Layout, Pipeline, PipelineDesc, SAMPLES},
    shaders,
};

/// From tangents to each eye's picture; twin of `Eyes` in shaders/hidden.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct HiddenEyes {
    maps: [[f32; 4]; 2],
    first: [u32; 4],
}

const _: () = assert!(
    size_of::<HiddenEyes>() == 48,
    "the shader's struct is rounded up to 16 bytes"
);

impl HiddenEyes {
    pub(crate) fn new(eyes: &[Eye; 2]) -> Self {
        let maps = [0, 1].map(|eye| {
            let [left, right, up, down] = eyes[eye].fov.tangents();
            let (width, height) = (right - left, up - down);
            // As `Eye::clip_from_eye` maps a point at distance 1.
            [
                2.0 / width,
                -2.0 / height,
                -(right + left) / width,
                (up + down) / height,
            ]
        });
        Self {
            maps,
            first: [0; 4],
        }
    }

    /// For the pass of one eye alone.
    pub(crate) fn of_eye(mut self, eye: u32) -> Self {
        self.first[0] = eye;
        self
    }
}

/// The hidden parts, on the device.
pub(crate) struct Hidden {
    layout: Layout,
    pipeline: Pipeline,
    /// Corners of both eyes' triangles, and how many; none where all is seen.
    corners: Option<(Buffer, u32)>,
}

impl Hidden {
    pub(crate) fn new(gpu: &Gpu, formats: &Formats) -> Result<Self, RenderError> {
        let bytes = u32::try_from(size_of::<HiddenEyes>()).unwrap_or(0);
        let layout = Layout::new(gpu, &[], bytes)?;
        let pipeline = Pipeline::new(
            gpu,
            &layout,
            &PipelineDesc {
                name: "the pipeline of what is hidden",
                spirv: shaders::hidden::SPIRV,
                vertex: shaders::hidden::HIDDEN_VERTEX,
                fragment: Some(shaders::hidden::HIDDEN_FRAGMENT),
                attributes: &[vk::Format::R32G32B32A32_SFLOAT],
                cull: vk::CullModeFlags::NONE,
                depth_compare: Some(vk::CompareOp::GREATER),
                depth_write: true,
                covered: false,
                blend: None,
                samples: SAMPLES,
                view_mask: formats.view_mask,
                color: formats.color,
                depth: formats.depth,
            },
        )?;
        Ok(Self {
            layout,
            pipeline,
            corners: None,
        })
    }

    /// Takes other triangles, three corners each, left eye and right; gives the old buffer, which frames under way may
    /// still read.
    pub(crate) fn set(
        &mut self,
        gpu: &Gpu,
        hidden: [&[[f32; 2]]; 2],
    ) -> Result<Option<Buffer>, RenderError> {
        let mut corners: Vec<[f32; 4]> = Vec::new();
        for (eye, triangles) in [0.0, 1.0].into_iter().zip(hidden) {
            let whole = triangles.chunks_exact(3).flatten();
            corners.extend(whole.map(|[x, y]| [*x, *y, eye, 0.0]));
        }
        let next = if corners.is_empty() {
            None
        } else {
            let mut buffer = Buffer::new(
                gpu,
                "what is hidden",
                size_of_val(corners.as_slice()) as u64,
                vk::BufferUsageFlags::VERTEX_BUFFER,
                MemoryLocation::CpuToGpu,
            )?;
            if !buffer.write(0, &corners) {
                return Err(RenderError::OutOfMemory("what is hidden"));
            }
            Some((buffer, u32::try_from(corners.len()).unwrap_or(0)))
        };
        Ok(std::mem::replace(&mut self.corners, next).map(|(buffer, _)| buffer))
    }

    /// Covers the hidden parts, first thing in a pass over the stage; gives the number of triangles.
    pub(crate) fn record(&self, gpu: &Gpu, commands: vk::CommandBuffer, eyes: &HiddenEyes) -> u32 {
        let Some((buffer, count)) = &self.corners else {
            return 0;
        };
        // SAFETY: a pass of the pipeline's formats is being recorded; everything lives until the frame is done.
        unsafe {
            let device = &gpu.device;
            device.cmd_bind_pipeline(
                commands,
                vk::PipelineBindPoint::GRAPHICS,
                self.pipeline.handle,
            );
            device.cmd_push_constants(
                commands,
                self.layout.handle,
                vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT,
                0,
                bytemuck::bytes_of(eyes),
            );
            device.cmd_bind_vertex_buffers(commands, 0, &[buffer.handle], &[0]);
            device.cmd_draw(commands, *count, 1, 0, 0);
        }
        count / 3
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "tests")]

    use glam::Vec3;

    use super::*;
    use crate::render::{Fov, Pose};

    #[test]
    fn tangents_land_where_the_projection_puts_points() {
        let fov = Fov {
            left: -0.9,
            right: 0.7,
            up: 0.8,
            down: -0.95,
        };
        let eye = Eye {
            world_from_eye: Pose {
                orientation: glam::Quat::IDENTITY,
                position: Vec3::ZERO,
            },
            fov,
        };
        let eyes = HiddenEyes::new(&[eye; 2]);
        for (x, y) in [(0.0, 0.0), (-1.2, 0.9), (0.3, -1.3)] {
            let clip = eye.clip_from_world() * Vec3::new(x, y, -1.0).extend(1.0);
            let [scale_x, scale_y, move_x, move_y] = eyes.maps[1];
            assert!((clip.x / clip.w - (x * scale_x + move_x)).abs() < 1e-5);
            assert!((clip.y / clip.w - (y * scale_y + move_y)).abs() < 1e-5);
        }
    }
}
