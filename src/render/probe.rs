//! Whether the driver's multiview really draws two views.
//!
//! Some drivers offer multiview and get it wrong: Mesa 22's lavapipe draws a part of the second view into the first view's layer,
//! silently, and how much depends on the kind of draw. So at start a few grids of cells are drawn for two views by
//! draws of different shapes, read back and compared cell by cell. A wrong picture means one pass an eye.

use ash::vk;

use super::{
    error::RenderError,
    frame::{full_barrier, run_now},
    gpu::Gpu,
    memory::{Buffer, Image, ImageDesc},
    offscreen::read_color,
    pipelines::{Layout, Pipeline, PipelineDesc, SAMPLES},
    renderer::StereoMode,
    shaders,
    target::{Attachments, StereoImage, discard},
};

/// What the probe found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Multiview {
    /// Both eyes in one pass.
    Works,
    /// The driver offers multiview but draws wrong pictures.
    Broken,
}

impl Multiview {
    /// The mode to draw in, with a warning in the log where it is the slow one.
    pub fn mode(self, gpu: &Gpu) -> StereoMode {
        match self {
            Self::Works => StereoMode::Multiview,
            Self::Broken => {
                let info = gpu.info();
                tracing::warn!(
                    "{} ({}) draws wrong pictures for two eyes at once; each eye gets its own pass, which is slower: install a newer driver, on Debian: apt-get install -t bookworm-backports mesa-vulkan-drivers",
                    info.device,
                    info.driver
                );
                StereoMode::PerEye
            }
        }
    }
}

/// Cells along a side and pixels of a cell; the picture's middle is the grid's, and cells reach over its edge by `OVER_PX` on each side,
/// so that some are clipped and some lie outside.
const SIDE: u32 = 64;
const CELL_PX: u32 = 6;
const OVER_PX: u32 = 64;
const PICTURE_PX: u32 = SIDE * CELL_PX - 2 * OVER_PX;
const CELLS: u32 = SIDE * SIDE;

/// The draws that are tried: cells of one instance, and whether through an index buffer.
const SHAPES: [(u32, bool); 6] = [
    (1, true),
    (8, true),
    (64, true),
    (CELLS, true),
    (CELLS, false),
    (1, false),
];

/// Draws for two views and compares.
///
/// # Errors
/// [`RenderError`] when the device fails; a wrong picture is no error.
pub fn multiview(gpu: &Gpu) -> Result<Multiview, RenderError> {
    let extent = vk::Extent2D {
        width: PICTURE_PX,
        height: PICTURE_PX,
    };
    let format = vk::Format::R8G8B8A8_UNORM;
    let depth_format = vk::Format::D32_SFLOAT;
    let attachments = Attachments::new(gpu, format, depth_format, extent, 0)?;
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
    let image = Image::new(gpu, ImageDesc::stereo("the probe", format, extent, usage))?;
    // SAFETY: the image outlives the view (declared before it).
    let target = unsafe { StereoImage::new(gpu, image.handle, format, extent) }?;
    let layout = Layout::new(gpu, &[], 8)?;
    let desc = PipelineDesc {
        name: "the probe's pipeline",
        spirv: shaders::probe::SPIRV,
        vertex: shaders::probe::INDEXED_VERTEX,
        fragment: Some(shaders::probe::PROBE_FRAGMENT),
        attributes: &[],
        cull: vk::CullModeFlags::NONE,
        depth_compare: Some(vk::CompareOp::GREATER),
        depth_write: true,
        covered: false,
        blend: None,
        samples: SAMPLES,
        view_mask: 0b11,
        color: format,
        depth: depth_format,
    };
    let indexed = Pipeline::new(gpu, &layout, &desc)?;
    let flat = Pipeline::new(
        gpu,
        &layout,
        &PipelineDesc {
            vertex: shaders::probe::FLAT_VERTEX,
            ..desc
        },
    )?;
    let cell = [0_u16, 1, 2, 2, 1, 3];
    let corners: Vec<u16> = (0..u16::try_from(CELLS).unwrap_or(0))
        .flat_map(|n| cell.map(|corner| n * 4 + corner))
        .collect();
    let mut indices = Buffer::new(
        gpu,
        "the probe's indices",
        size_of_val(corners.as_slice()) as u64,
        vk::BufferUsageFlags::INDEX_BUFFER,
        gpu_allocator::MemoryLocation::CpuToGpu,
    )?;
    indices.write(0, &corners);

    for (batch, through_indices) in SHAPES {
        run_now(gpu, |commands| {
            let [color, depth] = attachments.ready();
            full_barrier(
                gpu,
                commands,
                &[color, depth, discard(target.image, format)],
            );
            let many_color = [vk::RenderingAttachmentInfo::default()
                .image_view(attachments.color_view.handle)
                .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
                .resolve_mode(vk::ResolveModeFlags::AVERAGE)
                .resolve_image_view(target.view.handle)
                .resolve_image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(vk::AttachmentStoreOp::DONT_CARE)];
            let many_depth = vk::RenderingAttachmentInfo::default()
                .image_view(attachments.depth_view.handle)
                .image_layout(vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(vk::AttachmentStoreOp::DONT_CARE);
            let area = vk::Rect2D {
                offset: vk::Offset2D::default(),
                extent,
            };
            let info = vk::RenderingInfo::default()
                .render_area(area)
                .layer_count(1)
                .view_mask(0b11)
                .color_attachments(&many_color)
                .depth_attachment(&many_depth);
            #[allow(clippy::cast_precision_loss, reason = "256 pixels")]
            let viewport = [vk::Viewport {
                width: extent.width as f32,
                height: extent.height as f32,
                max_depth: 1.0,
                ..Default::default()
            }];
            let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
            let numbers = [SIDE, batch];
            let pipeline = if through_indices { &indexed } else { &flat };
            let device = &gpu.device;
            // SAFETY: recording; everything lives until `run_now` has waited; indices reach `batch` cells.
            unsafe {
                (gpu.newer.begin_rendering)(commands, &raw const info);
                device.cmd_set_viewport(commands, 0, &viewport);
                device.cmd_set_scissor(commands, 0, &[area]);
                device.cmd_bind_pipeline(
                    commands,
                    vk::PipelineBindPoint::GRAPHICS,
                    pipeline.handle,
                );
                device.cmd_push_constants(
                    commands,
                    layout.handle,
                    stages,
                    0,
                    bytemuck::cast_slice(&numbers),
                );
                if through_indices {
                    device.cmd_bind_index_buffer(
                        commands,
                        indices.handle,
                        0,
                        vk::IndexType::UINT16,
                    );
                    device.cmd_draw_indexed(commands, 6 * batch, CELLS / batch, 0, 0, 0);
                } else {
                    device.cmd_draw(commands, 6 * batch, CELLS / batch, 0, 0);
                }
                (gpu.newer.end_rendering)(commands);
            }
        })?;
        if !right(&read_color(gpu, &target)?) {
            return Ok(Multiview::Broken);
        }
    }
    Ok(Multiview::Works)
}

/// Whether both layers hold what shaders/probe.wgsl draws.
fn right(layers: &[image::RgbaImage; 2]) -> bool {
    let marks = [[255, 0], [0, 255]];
    layers.iter().zip(marks).all(|(picture, mark)| {
        picture
            .enumerate_pixels()
            .all(|(x, y, pixel)| pixel.0[..2] == mark && pixel.0[2].abs_diff(blue(x, y)) <= 1)
    })
}

/// The mark of the cell at a pixel.
fn blue(x: u32, y: u32) -> u8 {
    let cell = (y + OVER_PX) / CELL_PX * SIDE + (x + OVER_PX) / CELL_PX;
    u8::try_from(cell % 16 * 17).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "tests")]
    use super::*;

    #[test]
    fn a_missing_or_misplaced_view_is_wrong() {
        let drawn = |mark: [u8; 2]| {
            image::RgbaImage::from_fn(PICTURE_PX, PICTURE_PX, |x, y| {
                image::Rgba([mark[0], mark[1], blue(x, y), 255])
            })
        };
        let (left, second) = (drawn([255, 0]), drawn([0, 255]));
        assert!(right(&[left.clone(), second.clone()]));
        assert!(!right(&[second.clone(), left.clone()]), "swapped");
        assert!(
            !right(&[second.clone(), second.clone()]),
            "both in the first layer"
        );
        let mut hole = second;
        hole.put_pixel(5, 7, image::Rgba([0; 4]));
        assert!(!right(&[left, hole]), "one pixel missing");
    }
}
