//! The scene's scanned models: which of them are on the device, and how they are recorded.

use ash::vk;

use super::record::Pass;
use super::{DrawReport, Garbage, Renderer};
use crate::mesh::display::Display;
use crate::render::{
    error::RenderError,
    memory::Buffer,
    model_upload::{Colours, Geometry, ModelData, ModelUpload},
    selection::{DRAW_BYTES, Run, has_faces},
    tree_upload::COPY_BYTES,
};
use crate::world::scene::{PlacedModel, Scene, SurfaceLook};

impl Renderer {
    /// Takes a model that was prepared elsewhere; it is shown when it has been copied, some frames later.
    pub fn set_model(&mut self, upload: ModelUpload) {
        let ModelUpload { geometry, colours } = upload;
        if let Some(shape) = geometry
            && !self.shapes.iter().any(|known| known.is_same(&shape))
        {
            self.shapes.push(shape);
        }
        let known = |known: &Colours| known.revision == colours.revision;
        if !self.colours.iter().any(known) {
            self.colours.push(colours);
        }
    }

    /// Whether the device has a model's shape, or it is on its way, so that only colours need to be prepared.
    #[must_use]
    pub fn has_shape(&self, placed: &PlacedModel) -> bool {
        self.shape(&placed.display).is_some()
    }

    fn shape(&self, display: &Display) -> Option<&Geometry> {
        self.shapes.iter().find(|shape| shape.is_of(display))
    }

    /// Bytes of models' colours that are on the device or on their way.
    #[must_use]
    pub fn colour_bytes(&self) -> u64 {
        self.colours.iter().map(Colours::bytes).sum()
    }

    /// Lets go of models that the scene has no more, takes small new ones, and copies what is due. Says whether anything was copied, and the first model
    /// that is too large to be prepared within a frame.
    pub(super) fn update_models(
        &mut self,
        scene: &Scene,
        commands: vk::CommandBuffer,
    ) -> Result<(bool, Option<u64>), RenderError> {
        self.let_go(scene);
        let mut missing = None;
        for placed in &scene.models {
            let has_shape = self.has_shape(placed);
            let has_colours = self.colours_of(placed).is_some();
            if has_shape && has_colours {
                continue;
            }
            let display = &placed.display;
            let texels = display
                .textured
                .as_ref()
                .map_or(0, |textured| textured.layers.texels.len() / TEXELS_EACH);
            if display.mesh.triangles.len().max(texels) > self.params.direct_triangles {
                missing = missing.or(Some(placed.revision));
                continue;
            }
            let upload = if has_shape {
                ModelUpload::colours(&self.gpu, placed)?
            } else {
                ModelUpload::new(&self.gpu, placed)?
            };
            self.set_model(upload);
        }
        Ok((self.copy_models(commands)?, missing))
    }

    fn let_go(&mut self, scene: &Scene) {
        let frame = self.frame;
        let unused = |shape: &mut Geometry| {
            let mut models = scene.models.iter();
            !models.any(|placed| shape.is_of(&placed.display))
        };
        let gone = self.shapes.extract_if(.., unused);
        self.garbage
            .extend(gone.map(|shape| (frame, Garbage::Shape(shape))));
        let mut at = 0;
        while let Some(colours) = self.colours.get(at) {
            let stays = scene.models.iter().any(|placed| {
                // Others of the same shape stand in until its own are there.
                let stands_in = || {
                    colours.is_there()
                        && colours.is_of(&placed.display)
                        && !self.colours_of(placed).is_some_and(Colours::is_there)
                };
                colours.revision == placed.revision || stands_in()
            });
            if stays {
                at += 1;
            } else {
                let gone = self.colours.remove(at);
                self.garbage.push((frame, Garbage::Colours(gone)));
            }
        }
    }

    /// Copies shapes, then the colours whose shapes are there; whether anything was.
    fn copy_models(&mut self, commands: vk::CommandBuffer) -> Result<bool, RenderError> {
        let layouts = self.model_layouts();
        let (gpu, frame) = (&self.gpu, self.frame);
        let mut copied = false;
        let mut budget = COPY_BYTES;
        let garbage = &mut self.garbage;
        let mut done = |staging: Option<Vec<Buffer>>| {
            let staging = staging.into_iter().flatten();
            garbage.extend(staging.map(|buffer| (frame, Garbage::Buffer(buffer))));
        };
        for shape in self.shapes.iter_mut().filter(|shape| !shape.is_there()) {
            copied = true;
            done(shape.copy(gpu, commands, layouts, &mut budget)?);
        }
        for colours in self.colours.iter_mut().filter(|of| !of.is_there()) {
            let mut shapes = self.shapes.iter();
            let Some(shape) = shapes.find(|shape| shape.is_there() && shape.is_of_same(colours))
            else {
                continue;
            };
            copied = true;
            done(colours.copy(gpu, commands, shape, layouts, &mut budget)?);
        }
        Ok(copied)
    }

    /// Whether all models of the scene are on the device, each in its own colours.
    #[must_use]
    pub fn has_models(&self, scene: &Scene) -> bool {
        scene.models.iter().all(|placed| {
            let shown = self.shown(placed);
            shown.is_some_and(|(_, colours)| colours.revision == placed.revision)
        })
    }

    fn colours_of(&self, placed: &PlacedModel) -> Option<&Colours> {
        let own = |colours: &&Colours| colours.revision == placed.revision;
        self.colours.iter().find(own)
    }

    /// A model's shape with its colours, or with others that it had before as long as its own are on their way.
    pub(super) fn shown(&self, placed: &PlacedModel) -> Option<(&Geometry, &Colours)> {
        let shape = self
            .shape(&placed.display)
            .filter(|shape| shape.is_there())?;
        let there = |colours: &&Colours| colours.is_there() && colours.is_of(&placed.display);
        let mut others = self.colours.iter();
        let colours = self.colours_of(placed).filter(there);
        Some((shape, colours.or_else(|| others.find(there))?))
    }

    /// Faces, edges and vertices: everything that hides what is behind it.
    pub(super) fn record_models(&self, pass: &Pass<'_>, block: u64, report: &mut DrawReport) {
        let pipelines = &self.pipelines;
        self.record_each_model(pass, block, report, |placed, colours| {
            let look = &placed.look;
            let faces = match look.surface {
                Some(SurfaceLook::Textured) if colours.skin_set().is_some() => {
                    Some(&pipelines.textured)
                }
                // Without materials, or with other colours as long as these are on their way.
                Some(SurfaceLook::Matte | SurfaceLook::Shaded | SurfaceLook::Textured) => {
                    Some(&pipelines.faces)
                }
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
        self.record_each_model(pass, block, report, |placed, _| {
            let is_one = placed.look.surface == Some(SurfaceLook::XRay);
            [is_one.then_some((x_rays, Of::Triangles)), None]
        });
    }

    /// Follows what of the scene throws a shadow and is on the device.
    pub(super) fn follow_wood(&mut self, scene: &Scene) {
        let mut wood = std::mem::take(&mut self.wood.now);
        let throws = |placed: &&PlacedModel| {
            self.params.shadows && placed.look.shadow && self.is_chosen(placed).is_some()
        };
        wood.follow(self.params.sun, scene.models.iter().filter(throws));
        self.wood.now = wood;
    }

    /// Draws the map of what throws a shadow.
    pub(super) fn record_wood(&self, pass: &Pass<'_>, report: &mut DrawReport) {
        let pipeline = self.pipelines.model_shadow.handle;
        self.record_map(pass, &self.wood.shadow, || {
            self.record_each_model(pass, 0, report, |placed, _| {
                let draw = (pipeline, Of::Triangles);
                [placed.look.shadow.then_some(draw), None]
            });
        });
    }

    fn record_each_model(
        &self,
        pass: &Pass<'_>,
        block: u64,
        report: &mut DrawReport,
        draws: impl Fn(&PlacedModel, &Colours) -> [Option<(vk::Pipeline, Of)>; 2],
    ) {
        let layout = self.pipelines.model_layout.handle;
        let mut bound = false;
        for run in &self.selection.runs {
            let first = self.selection.models.get(run.standings.start);
            let placed = first.and_then(|number| pass.models.get(*number));
            let Some((placed, (shape, colours))) =
                placed.and_then(|placed| Some((placed, self.shown(placed)?)))
            else {
                continue;
            };
            let data = ModelData::new(&placed.look, colours.coloured, pass.points);
            for (pipeline, of) in draws(placed, colours).into_iter().flatten() {
                if !bound {
                    self.bind_frame(pass, layout, block);
                    self.bind_model(pass, 2, pass.list_set);
                    bound = true;
                }
                if let Some(skin) = colours.skin_set() {
                    self.bind_model(pass, 3, skin);
                }
                self.bind(pass, pipeline);
                self.tell(pass, &data);
                match of {
                    Of::Triangles => self.draw_faces(pass, run, colours, report),
                    Of::Vertices => self.draw_points(pass, run, shape, colours, report),
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

    fn bind_model(&self, pass: &Pass<'_>, number: u32, set: vk::DescriptorSet) {
        // SAFETY: the set is of the layout that has this number in the models' pipeline layout.
        unsafe {
            self.gpu.device.cmd_bind_descriptor_sets(
                pass.commands,
                vk::PipelineBindPoint::GRAPHICS,
                self.pipelines.model_layout.handle,
                number,
                &[set],
                &[],
            );
        }
    }

    /// The triangles that were chosen of a run's models.
    fn draw_faces(&self, pass: &Pass<'_>, run: &Run, colours: &Colours, report: &mut DrawReport) {
        let draws = self.selection.draws();
        for number in run.items.clone() {
            let item = self.selection.items.get(number);
            let set = item.and_then(|item| colours.sets.get(item.chunk));
            let Some(set) = set.copied() else {
                continue;
            };
            self.bind_model(pass, 1, set);
            let offset = number as u64 * DRAW_BYTES;
            // SAFETY: the choice wrote this draw, whose triangles are in the list.
            unsafe {
                self.gpu
                    .device
                    .cmd_draw_indirect(pass.commands, draws, offset, 1, 0);
            }
            report.draws += 1;
        }
    }

    /// Of the vertices of a run's models as many as a frame has room for.
    fn draw_points(
        &self,
        pass: &Pass<'_>,
        run: &Run,
        shape: &Geometry,
        colours: &Colours,
        report: &mut DrawReport,
    ) {
        let number = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let (first, models) = (number(run.standings.start), number(run.standings.len()));
        for (chunk, set) in shape.chunks.iter().zip(&colours.sets) {
            let points = chunk.points / pass.points.max(1);
            if points == 0 {
                continue;
            }
            self.bind_model(pass, 1, *set);
            let corners = points.saturating_mul(6);
            // SAFETY: the chunk has these vertices, and the models stand where the list says.
            unsafe {
                self.gpu
                    .device
                    .cmd_draw(pass.commands, corners, models, 0, first);
            }
            report.draws += 1;
            report.triangles += 2 * u64::from(points) * u64::from(models);
        }
    }

    /// Whether a model's faces are chosen in this frame.
    pub(super) fn is_chosen(&self, placed: &PlacedModel) -> Option<&Geometry> {
        let drawn = has_faces(&placed.look) && placed.world_from_model.is_finite();
        self.shown(placed).filter(|_| drawn).map(|(shape, _)| shape)
    }
}

/// Bytes of images that are as much work as a triangle.
const TEXELS_EACH: usize = 64;

/// What a draw makes of a model.
#[derive(Clone, Copy)]
enum Of {
    Triangles,
    Vertices,
}
