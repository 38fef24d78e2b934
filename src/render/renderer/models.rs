//! The scene's scanned models: which of them are on the device, and how they are recorded.

use ash::vk;

use super::record::Pass;
use super::{DrawReport, Garbage, Renderer};
use crate::render::{
    error::RenderError,
    memory::Buffer,
    model_upload::{ModelData, ModelUpload},
    tree_upload::COPY_BYTES,
};
use crate::world::scene::{PlacedModel, Scene, SurfaceLook};

impl Renderer {
    /// Takes a model that was prepared elsewhere; it is shown when it has been copied, some frames later.
    pub fn set_model(&mut self, upload: ModelUpload) {
        let same = |known: &ModelUpload| known.revision == upload.revision;
        if !self.models.iter().any(same) {
            self.models.push(upload);
        }
    }

    /// Lets go of models that the scene has no more, takes small new ones, and copies what is due. Says whether anything was copied, and the first model
    /// that is too large to be prepared within a frame.
    pub(super) fn update_models(
        &mut self,
        scene: &Scene,
        commands: vk::CommandBuffer,
    ) -> Result<(bool, Option<u64>), RenderError> {
        let wanted = |upload: &mut ModelUpload| {
            let revision = upload.revision;
            !scene
                .models
                .iter()
                .any(|placed| placed.revision == revision)
        };
        let gone = self.models.extract_if(.., wanted);
        let frame = self.frame;
        self.garbage
            .extend(gone.map(|upload| (frame, Garbage::Model(upload))));
        let mut missing = None;
        for placed in &scene.models {
            if self
                .models
                .iter()
                .any(|known| known.revision == placed.revision)
            {
                continue;
            }
            if placed.display.mesh.triangles.len() > self.params.direct_segments {
                missing = missing.or(Some(placed.revision));
                continue;
            }
            let upload = ModelUpload::new(&self.gpu, placed)?;
            self.set_model(upload);
        }
        let mut copied = false;
        let mut budget = COPY_BYTES;
        let layout = self.pipelines.model_layout.sets.get(1);
        let layout = layout.copied().unwrap_or_default();
        for model in &mut self.models {
            if model.is_there() {
                continue;
            }
            copied = true;
            if let Some(staging) = model.copy(&self.gpu, commands, layout, &mut budget)? {
                let staging = staging
                    .into_iter()
                    .map(|buffer: Buffer| (frame, Garbage::Buffer(buffer)));
                self.garbage.extend(staging);
            }
        }
        Ok((copied, missing))
    }

    /// Whether all models of the scene are on the device.
    #[must_use]
    pub fn has_models(&self, scene: &Scene) -> bool {
        scene
            .models
            .iter()
            .all(|placed| self.there(placed).is_some())
    }

    fn there(&self, placed: &PlacedModel) -> Option<&ModelUpload> {
        let known = |model: &&ModelUpload| model.revision == placed.revision && model.is_there();
        self.models.iter().find(known)
    }

    /// Faces, edges and vertices: everything that hides what is behind it.
    pub(super) fn record_models(&self, pass: &Pass<'_>, block: u64, report: &mut DrawReport) {
        let pipelines = &self.pipelines;
        self.record_each_model(pass, block, report, |placed| {
            let look = &placed.look;
            let faces = match look.surface {
                Some(SurfaceLook::Matte | SurfaceLook::Shaded) => Some(&pipelines.faces),
                Some(SurfaceLook::XRay) => None,
                None => look.wireframe.then_some(&pipelines.wire),
            };
            [
                faces.map(|pipeline| (pipeline.handle, Of::Triangles)),
                look.vertices
                    .then_some((pipelines.points.handle, Of::Vertices)),
            ]
        });
    }

    /// What is seen through; after all else, the sky included.
    pub(super) fn record_x_rays(&self, pass: &Pass<'_>, block: u64, report: &mut DrawReport) {
        let x_rays = self.pipelines.x_rays.handle;
        self.record_each_model(pass, block, report, |placed| {
            let is_one = placed.look.surface == Some(SurfaceLook::XRay);
            [is_one.then_some((x_rays, Of::Triangles)), None]
        });
    }

    fn record_each_model(
        &self,
        pass: &Pass<'_>,
        block: u64,
        report: &mut DrawReport,
        draws: impl Fn(&PlacedModel) -> [Option<(vk::Pipeline, Of)>; 2],
    ) {
        let layout = self.pipelines.model_layout.handle;
        let mut bound = false;
        for placed in pass.models {
            let Some(model) = self.there(placed) else {
                continue;
            };
            if !placed.world_from_model.is_finite() {
                continue;
            }
            let data = ModelData::new(
                &placed.world_from_model,
                &placed.look,
                model.coloured,
                model.vertices,
            );
            for (pipeline, of) in draws(placed).into_iter().flatten() {
                if !bound {
                    self.bind_frame(pass, layout, block);
                    bound = true;
                }
                self.bind(pass, pipeline);
                self.tell(pass, &data);
                for chunk in &model.chunks {
                    let corners = match of {
                        Of::Triangles => chunk.triangles.saturating_mul(3),
                        Of::Vertices => data.points(chunk.vertices).saturating_mul(6),
                    };
                    self.draw_chunk(pass, layout, chunk.set, corners);
                    report.draws += 1;
                    report.triangles += u64::from(corners / 3);
                }
            }
        }
        if bound {
            self.bind_frame(pass, self.pipelines.tree_layout.handle, block);
        }
    }

    fn tell(&self, pass: &Pass<'_>, data: &ModelData) {
        // SAFETY: the layout takes immediates of this size in these stages.
        unsafe {
            self.gpu.device.cmd_push_constants(
                pass.commands,
                self.pipelines.model_layout.handle,
                vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT,
                0,
                bytemuck::bytes_of(data),
            );
        }
    }

    fn draw_chunk(
        &self,
        pass: &Pass<'_>,
        layout: vk::PipelineLayout,
        set: vk::DescriptorSet,
        corners: u32,
    ) {
        if corners == 0 {
            return;
        }
        // SAFETY: the set's layout is the second of the pipeline layout; its buffers hold what these corners name.
        unsafe {
            let device = &self.gpu.device;
            device.cmd_bind_descriptor_sets(
                pass.commands,
                vk::PipelineBindPoint::GRAPHICS,
                layout,
                1,
                &[set],
                &[],
            );
            device.cmd_draw(pass.commands, corners, 1, 0, 0);
        }
    }
}

/// What a draw makes of a model.
#[derive(Clone, Copy)]
enum Of {
    Triangles,
    Vertices,
}
