//! Pictures of the workshop: the renderer, the board's layout, and uploads of large trees.

use std::sync::Arc;
use std::time::Duration;

use ash::vk;
use glam::Affine3A;
use image::{RgbaImage, imageops};
use ramus_xr::{Acquired, Headset, Swapchain, View, VisibilityMask};

use crate::app::layers::Layers;
use crate::app::rate::Rate;
use crate::app::session::SessionEnd;
use crate::app::worker::Worker;
use crate::render::{
    Backdrop, DrawReport, Eye, Fov, Gpu, ModelUpload, Offscreen, Pose, RenderError, Renderer,
    RendererParams, Resident, StereoImage, StereoMode, Surface, Target, TreeState, TreeUpload,
    probe,
};
use crate::ui::words::Language;
use crate::ui::{BoardUi, Painted};
use crate::world::room::Quality;
use crate::world::scene::weather::{Gusts, Light, Wind};
use crate::world::scene::{PlacedModel, PlacedTree, Scene};

/// Where frames go.
enum Images {
    /// Our own, for pictures without a headset.
    Own(Box<Offscreen>),
    /// The runtime's.
    Runtime {
        color: Vec<StereoImage>,
        depth: Vec<StereoImage>,
    },
    /// A window's.
    Window(Box<Surface>),
}

/// Pixels of a window that has none.
const SMALLEST: vk::Extent2D = vk::Extent2D {
    width: 16,
    height: 16,
};

/// A prepared tree with its revision, and a prepared model with its.
type Upload = (u64, Result<TreeUpload, RenderError>);
/// A tree to be prepared, and what the device has of the one that is shown.
type TreeWish = (Gpu, PlacedTree, Option<Arc<Resident>>);
type PreparedModel = (u64, Result<ModelUpload, RenderError>);

/// A model to prepare, and whether its colours alone.
type ModelWish = (Gpu, PlacedModel, bool);

/// Draws the workshop for both eyes.
pub struct Picture {
    // Images before the device that they belong to.
    images: Images,
    renderer: Renderer,
    board: BoardUi,
    language: Language,
    gusts: Gusts,
    /// The tree moves by itself.
    blows: bool,
    layers: Layers,
    uploads: Worker<TreeWish, Upload>,
    /// Revision of the tree that is being prepared on the worker.
    preparing: Option<u64>,
    /// Revision of the tree that could not be prepared: it is not tried again.
    refused: Option<u64>,
    models: Worker<ModelWish, PreparedModel>,
    /// Revision of the model that is being prepared, and those of models that could not be.
    preparing_model: Option<u64>,
    refused_models: Vec<u64>,
    /// Why a tree or a model is not in the picture, until it was told.
    trouble: Option<String>,
    /// The last draw showed an older tree than the scene's.
    behind: bool,
    /// The window did not take the last picture.
    missed: bool,
    /// Revision of the mask that was taken; 0: none.
    masked: u64,
    /// How large the headset's pictures are, and how long the device worked on one.
    rate: Rate,
    worked: Option<Duration>,
    gpu: Gpu,
}

/// Which eyes a headset's views are.
fn eyes(views: &[View; 2]) -> [Eye; 2] {
    views.map(|view| Eye {
        world_from_eye: Pose {
            orientation: view.pose.orientation,
            position: view.pose.position,
        },
        fov: Fov {
            left: view.fov.left,
            right: view.fov.right,
            up: view.fov.up,
            down: view.fov.down,
        },
    })
}

/// How this device draws both eyes, found by trying; a broken multiview is told in the log.
fn stereo_mode(gpu: &Gpu) -> Result<StereoMode, RenderError> {
    Ok(probe::multiview(gpu)?.mode(gpu))
}

impl Picture {
    /// Pictures without a headset, of so many pixels an eye.
    ///
    /// # Errors
    /// [`RenderError`] where the device cannot draw them.
    pub fn offscreen(gpu: &Gpu, width: u32, height: u32) -> Result<Self, RenderError> {
        Self::before(gpu, width, height, Backdrop::Stage)
    }

    /// Pictures without a headset, of so many pixels an eye, before a backdrop of one's own.
    ///
    /// # Errors
    /// [`RenderError`] where the device cannot draw them.
    pub fn before(
        gpu: &Gpu,
        width: u32,
        height: u32,
        backdrop: Backdrop,
    ) -> Result<Self, RenderError> {
        let images = Images::Own(Box::new(Offscreen::new(
            gpu,
            vk::Extent2D { width, height },
        )?));
        let params = RendererParams {
            backdrop,
            primitives: Quality::High.primitives(),
            error_px: Quality::High.error_px(),
            ..RendererParams::new(width, height, stereo_mode(gpu)?)
        };
        Self::new(gpu, params, images)
    }

    /// Pictures in a runtime's images.
    ///
    /// # Errors
    /// [`RenderError`] where the device cannot draw into them.
    pub fn in_headset(gpu: &Gpu, swapchain: &Swapchain) -> Result<Self, RenderError> {
        let vk::Extent2D { width, height } = swapchain.extent();
        let mut params = RendererParams::new(width, height, stereo_mode(gpu)?);
        params.color_format = swapchain.color_format();
        if !swapchain.depth().is_empty() {
            params.depth_format = swapchain.depth_format();
        }
        let (color, depth) = StereoImage::of_swapchain(gpu, swapchain)?;
        params.primitives = Quality::High.primitives();
        Self::new(gpu, params, Images::Runtime { color, depth })
    }

    /// Pictures in a window, for one eye: what the left one sees.
    ///
    /// # Errors
    /// [`RenderError`] where the device cannot draw into it.
    pub fn in_window(
        gpu: &Gpu,
        mut surface: Surface,
        size: vk::Extent2D,
    ) -> Result<Self, RenderError> {
        // A window without area gets a picture of its size when it has one.
        let vk::Extent2D { width, height } = surface.fit(size)?.unwrap_or(SMALLEST);
        let params = RendererParams {
            color_format: surface.color_format(),
            primitives: Quality::High.primitives(),
            ..RendererParams::new(width, height, StereoMode::OneEye)
        };
        Self::new(gpu, params, Images::Window(Box::new(surface)))
    }

    /// Makes a window's picture as large as the window, in pixels; false where there is nothing to draw into now.
    /// Other pictures have their size for good.
    ///
    /// # Errors
    /// [`RenderError`] where the device fails.
    pub fn fit(&mut self, size: vk::Extent2D) -> Result<bool, RenderError> {
        let Images::Window(surface) = &mut self.images else {
            return Ok(true);
        };
        let Some(extent) = surface.fit(size)? else {
            return Ok(false);
        };
        if self.renderer.params().extent != extent {
            self.renderer.resize(extent)?;
        }
        Ok(true)
    }

    /// Shows the last draw in the window. Other pictures are shown by whoever owns their images.
    ///
    /// # Errors
    /// [`RenderError`] where the device fails.
    pub fn present(&mut self) -> Result<(), RenderError> {
        if let Images::Window(surface) = &mut self.images {
            self.missed = !surface.present()?;
        }
        Ok(())
    }

    /// Whether the window does not show the last scene yet: a large tree is on its way, or the screen took no picture.
    #[must_use]
    pub fn is_behind(&self) -> bool {
        self.missed || self.behind
    }

    fn new(gpu: &Gpu, params: RendererParams, images: Images) -> Result<Self, RenderError> {
        let uploads = Worker::start("ramus-upload", |(gpu, placed, shown): &TreeWish, _| {
            (placed.revision, TreeUpload::new(gpu, placed, shown.clone()))
        })
        .map_err(no_thread)?;
        let models = Worker::start("ramus-models", |wish: &ModelWish, _| {
            let (gpu, placed, has_shape) = wish;
            let upload = if *has_shape {
                ModelUpload::colours(gpu, placed)
            } else {
                ModelUpload::new(gpu, placed)
            };
            (placed.revision, upload)
        })
        .map_err(no_thread)?;
        Ok(Self {
            images,
            renderer: Renderer::new(gpu, &params)?,
            board: BoardUi::default(),
            language: Language::default(),
            gusts: Gusts::default(),
            blows: false,
            layers: Layers::default(),
            uploads,
            preparing: None,
            refused: None,
            models,
            preparing_model: None,
            refused_models: Vec::new(),
            trouble: None,
            behind: false,
            missed: false,
            masked: 0,
            rate: Rate::default(),
            worked: None,
            gpu: gpu.clone(),
        })
    }

    /// Leaves out what a headset's lenses hide.
    ///
    /// # Errors
    /// [`RenderError`] where the device has no room for it.
    pub fn mask(&mut self, mask: Option<&VisibilityMask>) -> Result<(), RenderError> {
        let revision = mask.map_or(0, |mask| mask.revision);
        if self.masked != revision {
            let [left, right] = mask.map_or([&[][..]; 2], |mask| {
                mask.hidden.each_ref().map(Vec::as_slice)
            });
            self.renderer.set_hidden([left, right])?;
            self.masked = revision;
        }
        Ok(())
    }

    /// Says in which language the board speaks.
    pub fn speak(&mut self, language: Language) {
        self.language = language;
    }

    /// Takes what a panel shows from the next frame on.
    ///
    /// # Errors
    /// [`RenderError`] where the device has no room for it.
    pub fn paint(&mut self, slot: usize, mut painted: Painted) -> Result<(), RenderError> {
        self.layers.painted(slot);
        self.renderer.paint_panel(
            slot,
            &painted.primitives,
            &mut painted.textures,
            painted.size_px,
            painted.pixels_per_point,
        )
    }

    /// Lays the board out, where it says something else.
    fn lay_out(&mut self, scene: &Scene) -> Result<(), RenderError> {
        if let Some(board) = &scene.board
            && let Some(painted) = self.board.lay_out(board, self.language)
        {
            self.paint(0, painted)?;
        }
        Ok(())
    }

    /// Has the headset show the panels by itself in the frame that has begun, as far as it can, instead of drawing them into
    /// the scene; `room` says where it stands on the stage. Without it they are in the scene again.
    ///
    /// # Errors
    /// Where the headset or the device cannot go on.
    pub fn lift(
        &mut self,
        headset: &mut dyn Headset,
        scene: &Scene,
        room: Option<&Affine3A>,
        views: &[View; 2],
    ) -> Result<(), SessionEnd> {
        self.lay_out(scene)?;
        let renderer = &mut self.renderer;
        Ok(self.layers.lift(headset, renderer, scene, room, views)?)
    }

    /// Shows the stage as a person has lit it and lets it blow there, at a time of the session in seconds.
    pub fn set_weather(&mut self, light: Light, wind: Wind, time: f64) {
        self.renderer.set_light(light);
        let sway = self.gusts.blow(wind, time);
        self.renderer.set_sway(sway);
        self.blows = sway.moves() || wind != Wind::Still;
    }

    /// Whether the picture moves by itself, since it blows.
    #[must_use]
    pub fn blows(&self) -> bool {
        self.blows
    }

    /// Lights everything like this from now on.
    #[must_use]
    pub fn lit(mut self, light: Light) -> Self {
        self.renderer.set_light(light);
        self
    }

    /// Draws as finely as a person wants it from now on.
    pub fn set_quality(&mut self, quality: Quality) {
        let renderer = &mut self.renderer;
        renderer.set_quality(quality.primitives(), quality.error_px());
    }

    /// Has a headset's pictures drawn with fewer pixels while the device needs too long for all of them, where `wanted`; and says so to the headset.
    pub fn hold_rate(&mut self, headset: &mut dyn Headset, wanted: bool) {
        let all = self.renderer.params().extent;
        let part = match (headset.period(), &self.images) {
            (Some(period), Images::Runtime { .. }) if wanted => {
                if let Some(worked) = self.worked.take() {
                    self.rate.take(worked, period);
                }
                self.rate.part_of(all)
            }
            _ => {
                self.rate = Rate::default();
                all
            }
        };
        self.renderer.set_part(part);
        headset.show_part(part);
    }

    /// Draws a frame; `acquired` names the runtime's images.
    ///
    /// # Errors
    /// [`RenderError`]; after `DeviceLost` everything must be made anew.
    pub fn draw(
        &mut self,
        scene: &Scene,
        views: &[View; 2],
        acquired: Option<Acquired>,
    ) -> Result<DrawReport, RenderError> {
        if let Some(upload) = self.uploads.poll() {
            self.take_upload(upload);
        }
        self.lay_out(scene)?;
        if let Some(model) = self.models.poll() {
            self.take_model(model);
        }
        let target = self.images.target(acquired)?;
        let report = self.renderer.draw(scene, &eyes(views), &target)?;
        self.worked = report.device.or(self.worked);
        self.ask_for_model(scene, report.model);
        let wanted = match report.tree {
            TreeState::Wanted(revision) => Some(revision),
            _ => report.plain,
        };
        if let (Some(revision), Some(placed)) = (wanted, &scene.tree)
            && self.preparing != Some(revision)
            && self.refused != Some(revision)
        {
            self.preparing = Some(revision);
            let shown = self.renderer.resident();
            self.uploads.ask((self.gpu.clone(), placed.clone(), shown));
        }
        self.behind = match report.tree {
            TreeState::None | TreeState::Shown => false,
            TreeState::Copying => true,
            TreeState::Wanted(revision) => self.refused != Some(revision),
        } || self.waits_for_models(scene);
        Ok(report)
    }

    /// Has a model prepared that the renderer asks for; one at a time, since the worker keeps only the newest wish.
    fn ask_for_model(&mut self, scene: &Scene, wanted: Option<u64>) {
        let Some(revision) = wanted.filter(|wanted| !self.refused_models.contains(wanted)) else {
            return;
        };
        if self.preparing_model.is_none()
            && let Some(placed) = scene.models.iter().find(|model| model.revision == revision)
        {
            self.preparing_model = Some(revision);
            let has_shape = self.renderer.has_shape(placed);
            self.models
                .ask((self.gpu.clone(), placed.clone(), has_shape));
        }
    }

    /// Whether a model that can be shown is not there yet.
    fn waits_for_models(&self, scene: &Scene) -> bool {
        let refused = |revision| self.refused_models.contains(&revision);
        !self.renderer.has_models(scene)
            && !scene.models.iter().any(|model| refused(model.revision))
    }

    /// Draws until the scene's own tree and models are in the picture, however large they are.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub fn draw_whole(
        &mut self,
        scene: &Scene,
        views: &[View; 2],
        acquired: Option<Acquired>,
    ) -> Result<DrawReport, RenderError> {
        loop {
            let report = self.draw(scene, views, acquired)?;
            match report.tree {
                TreeState::None | TreeState::Shown if !self.waits_for_models(scene) => {
                    return Ok(report);
                }
                TreeState::None | TreeState::Shown => {
                    if self.preparing_model.is_some()
                        && let Some(model) = self.models.wait()
                    {
                        self.take_model(model);
                    }
                }
                TreeState::Copying => {}
                TreeState::Wanted(revision) if self.refused == Some(revision) => return Ok(report),
                TreeState::Wanted(_) => {
                    let Some(upload) = self.uploads.wait() else {
                        return Err(RenderError::Unsupported(
                            "the thread that prepares trees is gone".to_owned(),
                        ));
                    };
                    self.take_upload(upload);
                }
            }
        }
    }

    /// Waits for the last draw and reads what both eyes see (of the runtime's images: those that `acquired` names; where only a part was drawn, see
    /// [`Self::hold_rate`], the rest is nothing).
    ///
    /// # Errors
    /// [`RenderError`] where the device fails.
    pub fn read(&self, acquired: Option<Acquired>) -> Result<[RgbaImage; 2], RenderError> {
        let target = self.images.target(acquired)?;
        let [left, right] = crate::render::read_color(&self.gpu, target.color)?;
        // A window has one eye, which stands for both.
        Ok(match self.images {
            Images::Window(_) => [left.clone(), left],
            Images::Own(_) | Images::Runtime { .. } => [left, right],
        })
    }

    /// Why a tree is not in the picture, in a sentence; told once.
    pub fn take_trouble(&mut self) -> Option<String> {
        self.trouble.take()
    }

    /// A model that finds no room on the device ends no session: it is not shown, which is told.
    fn take_model(&mut self, (revision, upload): PreparedModel) {
        self.preparing_model = None;
        match upload {
            Ok(upload) => self.renderer.set_model(upload),
            Err(error) => {
                self.refused_models.push(revision);
                self.trouble = Some(format!("the model cannot be shown: {error}"));
            }
        }
    }

    /// A tree that finds no room on the device ends no session: the one before stays in view.
    fn take_upload(&mut self, (revision, upload): Upload) {
        // A newer one may have been asked for while this one was on its way.
        self.preparing = self.preparing.filter(|&newest| newest != revision);
        match upload {
            Ok(upload) => self.renderer.set_tree(upload),
            Err(error) => {
                self.refused = Some(revision);
                self.trouble = Some(format!("the tree cannot be shown: {error}"));
            }
        }
    }
}

fn no_thread(error: std::io::Error) -> RenderError {
    RenderError::Unsupported(format!("no thread for uploads: {error}"))
}

impl Images {
    fn target(&self, acquired: Option<Acquired>) -> Result<Target<'_>, RenderError> {
        match (self, acquired) {
            (Self::Own(offscreen), _) => Ok(offscreen.target()),
            (Self::Window(surface), _) => surface.target(),
            (Self::Runtime { color, depth }, Some(acquired)) => {
                let missing = || {
                    RenderError::Unsupported(
                        "the runtime named an image that it does not have".to_owned(),
                    )
                };
                Ok(Target {
                    color: color.get(acquired.color).ok_or_else(missing)?,
                    depth: acquired.depth.and_then(|index| depth.get(index)),
                })
            }
            (Self::Runtime { .. }, None) => Err(RenderError::Unsupported(
                "the runtime gave no image to draw into".to_owned(),
            )),
        }
    }
}

/// Both eyes beside each other, left eye on the left: a stereo picture as one image.
#[must_use]
pub fn side_by_side([left, right]: &[RgbaImage; 2]) -> RgbaImage {
    let mut both = RgbaImage::new(
        left.width() + right.width(),
        left.height().max(right.height()),
    );
    imageops::replace(&mut both, left, 0, 0);
    imageops::replace(&mut both, right, i64::from(left.width()), 0);
    both
}
