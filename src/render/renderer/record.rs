//! Records a frame's passes: the shadow, then the stage for both eyes at once or for one after the other.

use ash::vk;

use super::{Backdrop, DrawReport, Renderer};
use crate::render::{
    data::Counts,
    frame::{block_stride, full_barrier, transition},
    hidden::HiddenEyes,
    memory::Buffer,
    meshes::Run,
    pipelines::Pipeline,
    selection::For,
    shadow::Shadow,
    target::{Resolved, StereoImage, Target, aspects, discard},
    tree_upload::TreeUpload,
};
use crate::world::scene::PlacedModel;

/// What the recording of a pass needs to know.
pub(super) struct Pass<'a> {
    pub(super) commands: vk::CommandBuffer,
    pub(super) counts: Counts,
    pub(super) set: vk::DescriptorSet,
    /// The list of models' triangles, and where models stand.
    pub(super) list_set: vk::DescriptorSet,
    pub(super) hidden: HiddenEyes,
    pub(super) tree: Option<&'a TreeUpload>,
    pub(super) models: &'a [PlacedModel],
    /// Of so many vertices of a model one is shown as a point.
    pub(super) points: u32,
}

impl Renderer {
    /// Draws the tree's depth as the sun sees it.
    pub(super) fn record_shadow(&self, pass: &Pass<'_>, report: &mut DrawReport) {
        let pipelines = &self.pipelines;
        self.record_map(pass, &self.shadow, || {
            let crowns = [&pipelines.shadow, &pipelines.leaf_shadow];
            self.record_crowns(pass, For::Sun, crowns, report);
            self.record_organs(pass, pipelines.organ_shadow.handle, report);
        });
    }

    /// Draws depth as the sun sees it, and how soft that makes shadows.
    pub(super) fn record_map(&self, pass: &Pass<'_>, shadow: &Shadow, draw: impl FnOnce()) {
        let attachment = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        full_barrier(
            &self.gpu,
            pass.commands,
            &[shadow.barrier(vk::ImageLayout::UNDEFINED, attachment)],
        );
        let depth = vk::RenderingAttachmentInfo::default()
            .image_view(shadow.view.handle)
            .image_layout(attachment)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)
            .clear_value(clear_depth(1.0));
        let info = vk::RenderingInfo::default()
            .render_area(vk::Rect2D {
                offset: vk::Offset2D::default(),
                extent: shadow.extent(),
            })
            .layer_count(1)
            .depth_attachment(&depth);
        self.begin(pass, &info, shadow.extent(), 0);
        draw();
        self.end(pass);
        let read = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        full_barrier(
            &self.gpu,
            pass.commands,
            &[shadow.barrier(attachment, read)],
        );
        shadow.shade.record(pass.commands);
    }

    /// Both eyes in one pass.
    pub(super) fn record_both(
        &self,
        pass: &Pass<'_>,
        target: &Target<'_>,
        report: &mut DrawReport,
    ) {
        let [color, depth] = self.attachments.ready();
        let barriers = [
            color,
            depth,
            discard(target.color.image, target.color.format),
            target
                .depth
                .map_or_else(|| color, |depth| discard(depth.image, depth.format)),
        ];
        let count = if target.depth.is_some() { 4 } else { 3 };
        full_barrier(
            &self.gpu,
            pass.commands,
            barriers.get(..count).unwrap_or_default(),
        );
        self.record_stage(
            pass,
            target.color.view.handle,
            target.depth.map(|depth| depth.view.handle),
            0b11,
            0,
            report,
        );
    }

    /// One pass an eye, each copied into its layer of the target.
    pub(super) fn record_each(
        &self,
        pass: &Pass<'_>,
        target: &Target<'_>,
        report: &mut DrawReport,
    ) {
        let mut offset = 0;
        for (layer, (color, depth)) in (0_u32..).zip(&self.attachments.eyes) {
            let [many_color, many_depth] = self.attachments.ready();
            let barriers = [
                many_color,
                many_depth,
                discard(color.image.handle, self.params.color_format),
                discard(depth.image.handle, self.params.depth_format),
            ];
            full_barrier(&self.gpu, pass.commands, &barriers);
            self.record_stage(
                pass,
                color.view.handle,
                Some(depth.view.handle),
                0,
                offset,
                report,
            );
            offset = block_stride(&self.gpu);
            self.copy_layer(pass.commands, color, target.color, layer);
            if let Some(target) = target.depth {
                self.copy_layer(pass.commands, depth, target, layer);
            }
        }
    }

    fn copy_layer(
        &self,
        commands: vk::CommandBuffer,
        from: &Resolved,
        to: &StereoImage,
        layer: u32,
    ) {
        let aspect = aspects(to.format);
        let (source, sink) = (
            vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
            vk::ImageLayout::TRANSFER_DST_OPTIMAL,
        );
        // The other layer is kept: only the first copy may discard.
        let before = if layer == 0 {
            vk::ImageLayout::UNDEFINED
        } else {
            to.layout()
        };
        full_barrier(
            &self.gpu,
            commands,
            &[
                transition(from.image.handle, aspect, to.layout(), source),
                transition(to.image, aspect, before, sink),
            ],
        );
        let place = |layer| {
            vk::ImageSubresourceLayers::default()
                .aspect_mask(aspect)
                .base_array_layer(layer)
                .layer_count(1)
        };
        let region = [vk::ImageCopy::default()
            .src_subresource(place(0))
            .dst_subresource(place(layer))
            .extent(vk::Extent3D {
                width: self.part.width,
                height: self.part.height,
                depth: 1,
            })];
        // SAFETY: both images are in these layouts, of one format and size.
        unsafe {
            self.gpu.device.cmd_copy_image(
                commands,
                from.image.handle,
                source,
                to.image,
                sink,
                &region,
            )
        };
        full_barrier(
            &self.gpu,
            commands,
            &[transition(to.image, aspect, sink, to.layout())],
        );
    }

    /// The whole stage into the multisampled images, resolved into `color` and `depth`.
    fn record_stage(
        &self,
        pass: &Pass<'_>,
        color: vk::ImageView,
        depth: Option<vk::ImageView>,
        view_mask: u32,
        block: u64,
        report: &mut DrawReport,
    ) {
        let extent = self.part;
        let many_color = [vk::RenderingAttachmentInfo::default()
            .image_view(self.attachments.color_view.handle)
            .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            .resolve_mode(vk::ResolveModeFlags::AVERAGE)
            .resolve_image_view(color)
            .resolve_image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::DONT_CARE)
            .clear_value(vk::ClearValue {
                color: vk::ClearColorValue {
                    float32: [0.0, 0.0, 0.0, 1.0],
                },
            })];
        let mut many_depth = vk::RenderingAttachmentInfo::default()
            .image_view(self.attachments.depth_view.handle)
            .image_layout(vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::DONT_CARE)
            .clear_value(clear_depth(0.0));
        if let Some(depth) = depth {
            many_depth = many_depth
                .resolve_mode(vk::ResolveModeFlags::SAMPLE_ZERO)
                .resolve_image_view(depth)
                .resolve_image_layout(vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
        }
        let info = vk::RenderingInfo::default()
            .render_area(vk::Rect2D {
                offset: vk::Offset2D::default(),
                extent,
            })
            .layer_count(1)
            .view_mask(view_mask)
            .color_attachments(&many_color)
            .depth_attachment(&many_depth);
        self.begin(pass, &info, extent, block);
        self.record_hidden(pass, block, report);
        let pipelines = &self.pipelines;
        self.record_crowns(
            pass,
            For::Eyes,
            [&pipelines.tubes, &pipelines.leaves],
            report,
        );
        self.record_organs(pass, pipelines.organs.handle, report);
        self.record_models(pass, block, report);
        self.record_instances(pass, report);
        self.record_panels(pass, block, report);
        if self.params.backdrop == Backdrop::Stage {
            // Sectors × bands × corners of shaders/ground.wgsl.
            self.record_plain(pass, self.pipelines.ground.handle, 48 * 4 * 6, report);
        }
        self.record_plain(pass, self.pipelines.sky.handle, 3, report);
        self.record_x_rays(pass, block, report);
        self.end(pass);
    }

    fn begin(
        &self,
        pass: &Pass<'_>,
        info: &vk::RenderingInfo<'_>,
        extent: vk::Extent2D,
        block: u64,
    ) {
        #[allow(
            clippy::cast_precision_loss,
            reason = "pictures are at most some thousands of pixels"
        )]
        let viewport = [vk::Viewport {
            x: 0.0,
            y: 0.0,
            width: extent.width as f32,
            height: extent.height as f32,
            min_depth: 0.0,
            max_depth: 1.0,
        }];
        let scissor = [vk::Rect2D {
            offset: vk::Offset2D::default(),
            extent,
        }];
        let device = &self.gpu.device;
        // SAFETY: the command buffer is recording outside of a pass; all handles live until the frame is done.
        unsafe {
            (self.gpu.newer.begin_rendering)(pass.commands, std::ptr::from_ref(info));
            device.cmd_set_viewport(pass.commands, 0, &viewport);
            device.cmd_set_scissor(pass.commands, 0, &scissor);
        }
        self.bind_indices(pass, &self.meshes.indices, vk::IndexType::UINT16);
        self.bind_frame(pass, self.pipelines.tree_layout.handle, block);
    }

    /// Covers what nobody sees. The block of an eye's own pass says which eye it is: the first block is the left one's.
    fn record_hidden(&self, pass: &Pass<'_>, block: u64, report: &mut DrawReport) {
        let eyes = pass.hidden.of_eye(u32::from(block > 0));
        let triangles = self.hidden.record(&self.gpu, pass.commands, &eyes);
        report.draws += u32::from(triangles > 0);
        report.triangles += u64::from(triangles);
    }

    pub(super) fn bind_frame(&self, pass: &Pass<'_>, layout: vk::PipelineLayout, block: u64) {
        let offset = u32::try_from(block).unwrap_or(0);
        // SAFETY: the set's layout is the first of the pipeline layout.
        unsafe {
            self.gpu.device.cmd_bind_descriptor_sets(
                pass.commands,
                vk::PipelineBindPoint::GRAPHICS,
                layout,
                0,
                &[pass.set],
                &[offset],
            );
        }
    }

    fn end(&self, pass: &Pass<'_>) {
        // SAFETY: a pass is being recorded.
        unsafe { (self.gpu.newer.end_rendering)(pass.commands) };
    }

    pub(super) fn bind(&self, pass: &Pass<'_>, pipeline: vk::Pipeline) {
        // SAFETY: the pipeline fits the pass's formats.
        unsafe {
            self.gpu.device.cmd_bind_pipeline(
                pass.commands,
                vk::PipelineBindPoint::GRAPHICS,
                pipeline,
            )
        };
    }

    /// What was chosen of branches, then of leaves.
    fn record_crowns(
        &self,
        pass: &Pass<'_>,
        whom: For,
        [tubes, leaves]: [&Pipeline; 2],
        report: &mut DrawReport,
    ) {
        let Some(tree) = pass.tree else { return };
        self.bind(pass, tubes.handle);
        self.bind_set(pass, 2, self.selection.crowns.list_set);
        for (item, chunk) in tree.chunks.iter().enumerate() {
            self.bind_chunk(pass, chunk.set);
            self.draw_chosen(pass, item, whom, report);
        }
        if tree.leaves.is_empty() {
            return;
        }
        self.bind(pass, leaves.handle);
        for (item, chunk) in (tree.chunks.len()..).zip(&tree.leaves) {
            self.bind_chunk(pass, chunk.crown.set);
            self.bind_indices(pass, &chunk.indices, vk::IndexType::UINT32);
            self.draw_chosen(pass, item, whom, report);
        }
        self.bind_indices(pass, &self.meshes.indices, vk::IndexType::UINT16);
    }

    /// The draws that the device made of a chunk.
    fn draw_chosen(&self, pass: &Pass<'_>, item: usize, whom: For, report: &mut DrawReport) {
        const STRIDE: u32 = 20;
        const _: () = assert!(
            size_of::<vk::DrawIndexedIndirectCommand>() == STRIDE as usize,
            "draws stand one after the other"
        );
        let (buffer, runs) = self.selection.crowns.draws(item, whom);
        for (offset, count) in runs.into_iter().filter(|(_, count)| *count > 0) {
            // SAFETY: the buffer has these draws; what they draw lies within the bound buffers.
            unsafe {
                let device = &self.gpu.device;
                device.cmd_draw_indexed_indirect(pass.commands, buffer, offset, count, STRIDE);
            }
            report.draws += count;
        }
    }

    fn record_organs(&self, pass: &Pass<'_>, pipeline: vk::Pipeline, report: &mut DrawReport) {
        let Some(tree) = pass.tree.filter(|tree| !tree.organs.is_empty()) else {
            return;
        };
        self.bind(pass, pipeline);
        for chunk in &tree.organs {
            self.bind_chunk(pass, chunk.set);
            self.bind_indices(pass, &chunk.indices, vk::IndexType::UINT32);
            let run = Run {
                count: chunk.count,
                ..Run::default()
            };
            self.draw_run(pass, run, 0..1, report);
        }
        self.bind_indices(pass, &self.meshes.indices, vk::IndexType::UINT16);
    }

    fn bind_indices(&self, pass: &Pass<'_>, buffer: &Buffer, kind: vk::IndexType) {
        // SAFETY: the buffer lives until the frame is done.
        unsafe {
            self.gpu
                .device
                .cmd_bind_index_buffer(pass.commands, buffer.handle, 0, kind);
        }
    }

    fn bind_chunk(&self, pass: &Pass<'_>, set: vk::DescriptorSet) {
        self.bind_set(pass, 1, set);
    }

    /// Binds a set of what trees are drawn by.
    fn bind_set(&self, pass: &Pass<'_>, number: u32, set: vk::DescriptorSet) {
        let layout = self.pipelines.tree_layout.handle;
        // SAFETY: the set's layout is that of this number of the pipeline layout.
        unsafe {
            self.gpu.device.cmd_bind_descriptor_sets(
                pass.commands,
                vk::PipelineBindPoint::GRAPHICS,
                layout,
                number,
                &[set],
                &[],
            );
        }
    }

    fn record_instances(&self, pass: &Pass<'_>, report: &mut DrawReport) {
        let counts = pass.counts;
        self.bind(pass, self.pipelines.solids.handle);
        // SAFETY: the buffer lives as long as the renderer.
        unsafe {
            self.gpu.device.cmd_bind_vertex_buffers(
                pass.commands,
                0,
                &[self.meshes.solids.handle],
                &[0],
            )
        };
        self.draw_run(pass, self.meshes.plate, 0..counts.plates, report);
        self.draw_run(pass, self.meshes.left, counts.plates..counts.left, report);
        self.draw_run(pass, self.meshes.right, counts.left..counts.right, report);
        // SAFETY: as above.
        unsafe {
            self.gpu.device.cmd_bind_vertex_buffers(
                pass.commands,
                0,
                &[self.meshes.spheres.handle],
                &[0],
            )
        };
        self.bind(pass, self.pipelines.rods.handle);
        self.draw_run(pass, self.meshes.rod, 0..counts.rods, report);
        self.draw_run(pass, self.meshes.ball, counts.rods..counts.balls, report);
        self.bind(pass, self.pipelines.ghosts.handle);
        self.draw_run(
            pass,
            self.meshes.rod,
            counts.balls..counts.ghost_rods,
            report,
        );
        self.draw_run(
            pass,
            self.meshes.ball,
            counts.ghost_rods..counts.ghost_balls,
            report,
        );
    }

    fn record_panels(&self, pass: &Pass<'_>, block: u64, report: &mut DrawReport) {
        let counts = pass.counts;
        if counts.panels <= counts.right {
            return;
        }
        let layout = self.pipelines.board_layout.handle;
        self.bind(pass, self.pipelines.board.handle);
        self.bind_frame(pass, layout, block);
        for (instance, slot) in (counts.right..counts.panels).zip(counts.pictures) {
            // One that was never painted is an empty slab, which any picture will do for.
            let Some(panel) = self.panels.get(slot).or(self.panels.first()) else {
                continue;
            };
            // SAFETY: the set's layout is the second of the pipeline layout; `instance` was written.
            unsafe {
                let device = &self.gpu.device;
                device.cmd_bind_descriptor_sets(
                    pass.commands,
                    vk::PipelineBindPoint::GRAPHICS,
                    layout,
                    1,
                    &[panel.set()],
                    &[],
                );
                device.cmd_draw(pass.commands, 6, 1, 0, instance);
            }
            report.draws += 1;
            report.triangles += 2;
        }
        self.bind_frame(pass, self.pipelines.tree_layout.handle, block);
    }

    fn record_plain(
        &self,
        pass: &Pass<'_>,
        pipeline: vk::Pipeline,
        vertices: u32,
        report: &mut DrawReport,
    ) {
        self.bind(pass, pipeline);
        // SAFETY: the shader makes its vertices itself.
        unsafe { self.gpu.device.cmd_draw(pass.commands, vertices, 1, 0, 0) };
        report.draws += 1;
        report.triangles += u64::from(vertices / 3);
    }

    fn draw_run(
        &self,
        pass: &Pass<'_>,
        run: Run,
        instances: std::ops::Range<u32>,
        report: &mut DrawReport,
    ) {
        if instances.is_empty() {
            return;
        }
        let count = instances.end - instances.start;
        // SAFETY: indices and instances lie within the bound buffers.
        unsafe {
            self.gpu.device.cmd_draw_indexed(
                pass.commands,
                run.count,
                count,
                run.first,
                run.vertex,
                instances.start,
            );
        }
        report.draws += 1;
        report.triangles += u64::from(run.count / 3) * u64::from(count);
    }
}

fn clear_depth(depth: f32) -> vk::ClearValue {
    vk::ClearValue {
        depth_stencil: vk::ClearDepthStencilValue { depth, stencil: 0 },
    }
}
