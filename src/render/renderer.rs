//! Draws a [`Scene`] for two eyes.
//!
//! A frame: wait for the slot's last frame, write the frame's numbers and instances into the slot's buffers, copy what is due
//! of a new tree, draw the shadow map if the tree changed, one pass over the stage for both eyes
//! (multiview; or one pass an eye), submit. Nothing is allocated and no pipeline made once
//! the buffers have grown to the scene.

mod air;
mod choice;
mod models;
mod record;
mod report;
mod trees;

use std::sync::Arc;

use ash::vk;
use glam::{Mat4, Vec3, Vec4};

use self::air::sphere_of;
use self::record::Pass;
pub use self::report::{DrawReport, TreeState};
use super::{
    data::{self, FrameData, RodData, SolidData, ViewData},
    error::RenderError,
    eye::Eye,
    frame::{Pool, SLOTS, Slot, block_stride, depth_was_resolved, full_barrier},
    gpu::Gpu,
    hidden::{Hidden, HiddenEyes},
    light::LightData,
    memory::Buffer,
    meshes::Meshes,
    model_upload::{Colours, Geometry, ModelLayouts},
    offscreen::{COLOR_FORMAT, DEPTH_FORMAT, check_extent},
    panel::{LayerImage, Panel},
    pipelines::{Formats, Pipelines},
    resident::Resident,
    selection::{Chosen, OldCrowns, OldRoom, Selection, sun_views},
    shadow::{self, Shadow, ShadowKey, Wood},
    target::{Attachments, Target},
    texture::Texture,
    tree_upload::{Detail, Scratch, TreeUpload, upload_size},
};
use crate::tree::bark::Bark;
use crate::world::scene::weather::{Light, Sway};
use crate::world::scene::{Color, MOST_PANELS, PlacedTree, Scene};

/// How both eyes are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StereoMode {
    /// Both in one pass.
    Multiview,
    /// One pass an eye: for drivers whose multiview is broken (see [`super::probe`]).
    PerEye,
    /// The left eye alone, into the first layer: for windows.
    OneEye,
}

impl StereoMode {
    /// How many eyes get a pass of their own.
    fn own_eyes(self) -> u32 {
        match self {
            Self::Multiview => 0,
            Self::PerEye => 2,
            Self::OneEye => 1,
        }
    }
}

/// What surrounds the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Backdrop {
    /// Sky and ground.
    Stage,
    /// One colour (linear), nothing else: pictures of a tree alone.
    Plain(Color),
}

/// How to draw.
#[derive(Clone, Copy, Debug)]
pub struct RendererParams {
    /// Pixels of one eye.
    pub extent: vk::Extent2D,
    /// Format of the targets' colour; an 8-bit sRGB one.
    pub color_format: vk::Format,
    /// Format of the targets' depth.
    pub depth_format: vk::Format,
    /// One pass or two.
    pub mode: StereoMode,
    /// What surrounds the scene.
    pub backdrop: Backdrop,
    /// What everything is lit by. [`Self::lit`] sets it with its sun.
    pub light: Light,
    /// Towards the sun; any length.
    pub sun: Vec3,
    /// Whether the tree throws a shadow.
    pub shadows: bool,
    /// A new tree of up to so many segments is built and shown within the frame that brings it; larger ones must come through [`Renderer::set_tree`].
    pub direct_segments: usize,
    /// Of these, trees of up to so many segments have their levels of detail at once; others when they come once more, see [`DrawReport::plain`].
    pub direct_levels: usize,
    /// The same of models and their triangles, and [`Renderer::set_model`].
    pub direct_triangles: usize,
    /// Triangles and points of all trees and models together that a frame hands over at most.
    pub primitives: u32,
    /// What levels of detail may be off by where `primitives` allow it, pixels.
    pub error_px: f32,
}

impl RendererParams {
    /// For an [`super::Offscreen`] or the like of `width` × `height` pixels an eye.
    pub fn new(width: u32, height: u32, mode: StereoMode) -> Self {
        Self {
            extent: vk::Extent2D { width, height },
            color_format: COLOR_FORMAT,
            depth_format: DEPTH_FORMAT,
            mode,
            backdrop: Backdrop::Stage,
            light: Light::Day,
            sun: super::light::sun(Light::Day),
            shadows: true,
            direct_segments: 100_000,
            direct_levels: 4_000,
            direct_triangles: 100_000,
            // With what else stands on the stage 1.5 million.
            primitives: 1_400_000,
            error_px: 1.0,
        }
    }
}

/// Frames after which a tree is taken to be at rest.
const REST: u64 = 12;

/// What waits until the frames that use it are done.
enum Garbage {
    Tree(#[allow(dead_code, reason = "kept to be dropped later")] TreeUpload),
    Shape(#[allow(dead_code, reason = "kept to be dropped later")] Geometry),
    Colours(#[allow(dead_code, reason = "kept to be dropped later")] Colours),
    Room(#[allow(dead_code, reason = "kept to be dropped later")] OldRoom),
    Crowns(#[allow(dead_code, reason = "kept to be dropped later")] OldCrowns),
    Buffer(#[allow(dead_code, reason = "kept to be dropped later")] Buffer),
    Resident(#[allow(dead_code, reason = "kept to be dropped later")] Arc<Resident>),
}

/// Draws scenes into targets of one size and format.
pub struct Renderer {
    params: RendererParams,
    /// Pixels that are drawn of each eye's.
    part: vk::Extent2D,
    /// Triangles and points that a frame has room for.
    most: u32,
    pipelines: Pipelines,
    meshes: Meshes,
    attachments: Attachments,
    slots: [Slot; SLOTS],
    shadow: Shadow,
    /// What it was drawn for.
    drawn: Option<ShadowKey>,
    wood: Wood,
    /// How things move in the next frame.
    sway: Sway,
    /// By slot; the board's is always there.
    panels: Vec<Panel>,
    hidden: Hidden,
    tree: Option<TreeUpload>,
    coming: Option<TreeUpload>,
    /// The frame in which the shown tree came, and how many bytes were sent for it.
    came: u64,
    sent: u64,
    /// The bark that trees were last covered by.
    bark: Option<(Bark, Arc<Texture>)>,
    shapes: Vec<Geometry>,
    colours: Vec<Colours>,
    selection: Selection,
    scratch: Scratch,
    garbage: Vec<(u64, Garbage)>,
    frame: u64,
    /// Holds the slots' sets.
    _pool: Pool,
    gpu: Gpu,
}

impl Renderer {
    /// Makes everything that frames need.
    ///
    /// # Errors
    /// [`RenderError`] when the device cannot.
    pub fn new(gpu: &Gpu, params: &RendererParams) -> Result<Self, RenderError> {
        check_extent(gpu, params.extent)?;
        let mut params = *params;
        params.sun = params.sun.normalize_or(Vec3::Y);
        let own_eyes = params.mode.own_eyes();
        let formats = Formats {
            color: params.color_format,
            depth: params.depth_format,
            view_mask: if own_eyes > 0 { 0 } else { 0b11 },
        };
        let pipelines = Pipelines::new(gpu, &formats)?;
        let count = u32::try_from(SLOTS).unwrap_or(2);
        let pool = Pool::new(
            gpu,
            count,
            &[
                (vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC, count),
                (vk::DescriptorType::SAMPLED_IMAGE, 4 * count),
                (vk::DescriptorType::SAMPLER, 2 * count),
                (vk::DescriptorType::STORAGE_BUFFER, 2 * count),
            ],
        )?;
        let shadow = Shadow::new(gpu)?;
        let wood = Wood::new(gpu)?;
        let layout = pipelines
            .tree_layout
            .sets
            .first()
            .copied()
            .unwrap_or_default();
        let slot = || {
            let slot = Slot::new(gpu, pool.set(layout)?)?;
            write_set(gpu, &slot, &shadow, &wood);
            Ok::<_, RenderError>(slot)
        };
        let slots = [slot()?, slot()?];
        let lists = [&pipelines.model_layout, &pipelines.tree_layout]
            .map(|layout| layout.sets.get(2).copied().unwrap_or_default());
        let most = params.primitives;
        let selection = Selection::new(gpu, lists, most)?;
        Ok(Self {
            meshes: Meshes::new(gpu)?,
            attachments: Attachments::new(
                gpu,
                params.color_format,
                params.depth_format,
                params.extent,
                own_eyes,
            )?,
            panels: vec![Panel::new(gpu, &pipelines.board_layout)?],
            hidden: Hidden::new(gpu, &formats)?,
            most,
            part: params.extent,
            params,
            pipelines,
            slots,
            shadow,
            drawn: None,
            wood,
            sway: Sway::default(),
            tree: None,
            coming: None,
            came: 0,
            sent: 0,
            bark: None,
            shapes: Vec::new(),
            colours: Vec::new(),
            selection,
            scratch: Scratch::default(),
            garbage: Vec::new(),
            frame: 0,
            _pool: pool,
            gpu: gpu.clone(),
        })
    }

    /// How this renderer draws.
    pub fn params(&self) -> &RendererParams {
        &self.params
    }

    /// Draws in another size from now on.
    ///
    /// # Errors
    /// [`RenderError`] where the device cannot; the size stays as it was then.
    pub fn resize(&mut self, extent: vk::Extent2D) -> Result<(), RenderError> {
        check_extent(&self.gpu, extent)?;
        self.gpu.wait_idle()?;
        let params = &mut self.params;
        self.attachments = Attachments::new(
            &self.gpu,
            params.color_format,
            params.depth_format,
            extent,
            params.mode.own_eyes(),
        )?;
        params.extent = extent;
        self.part = extent;
        Ok(())
    }

    /// Draws only so many pixels of each eye's picture from now on, from the first on: what it shows stays the same, more coarsely.
    pub fn set_part(&mut self, part: vk::Extent2D) {
        let all = self.params.extent;
        self.part = vk::Extent2D {
            width: part.width.clamp(1, all.width),
            height: part.height.clamp(1, all.height),
        };
    }

    /// Draws as finely as this from now on: [`RendererParams::error_px`], and so many [`RendererParams::primitives`], but no more than it was made for.
    pub fn set_quality(&mut self, primitives: u32, error_px: f32) {
        self.params.primitives = primitives.min(self.most);
        self.params.error_px = error_px;
    }

    /// What the device has of the shown tree, for the [`TreeUpload`] of the next one.
    #[must_use]
    pub fn resident(&self) -> Option<Arc<Resident>> {
        self.tree.as_ref().map(|tree| Arc::clone(&tree.resident))
    }

    /// Bytes that the shown tree takes on the device.
    #[must_use]
    pub fn tree_bytes(&self) -> u64 {
        self.tree.as_ref().map_or(0, TreeUpload::bytes)
    }

    /// Takes a tree that was prepared elsewhere; it is shown when it has been copied, some frames later.
    pub fn set_tree(&mut self, upload: TreeUpload) {
        if let Some(old) = self.coming.replace(upload) {
            self.garbage.push((self.frame, Garbage::Tree(old)));
        }
    }

    /// Takes what nobody can see of the left and the right eye's picture, as triangles of three corners each, at the
    /// tangents (x right, y up) of the angles at which the eye sees them: those pixels stay black and are not shaded.
    ///
    /// # Errors
    /// [`RenderError`] when there is no room for them; what was hidden before stays hidden then.
    pub fn set_hidden(&mut self, hidden: [&[[f32; 2]]; 2]) -> Result<(), RenderError> {
        if let Some(old) = self.hidden.set(&self.gpu, hidden)? {
            self.garbage.push((self.frame, Garbage::Buffer(old)));
        }
        Ok(())
    }

    /// Paints egui's output into a panel's picture, of `size_px` pixels, with the next draw; `textures` is cleared. Slot 0 is the
    /// board's; the others are those of [`PlacedPanel`](crate::world::scene::PlacedPanel).
    ///
    /// # Errors
    /// [`RenderError`] when a texture does not fit or there is no such slot.
    pub fn paint_panel(
        &mut self,
        slot: usize,
        primitives: &[egui::ClippedPrimitive],
        textures: &mut egui::TexturesDelta,
        size_px: [u32; 2],
        pixels_per_point: f32,
    ) -> Result<(), RenderError> {
        while self.panels.len() <= slot.min(MOST_PANELS - 1) {
            let panel = Panel::new(&self.gpu, &self.pipelines.board_layout)?;
            self.panels.push(panel);
        }
        let Some(panel) = self.panels.get_mut(slot) else {
            textures.clear();
            return Err(RenderError::Unsupported(format!(
                "there is no panel {slot}"
            )));
        };
        panel.paint(primitives, textures, size_px, pixels_per_point, self.frame)
    }

    /// Pixels of a panel's picture as the next draw shows it; none where there is none yet.
    #[must_use]
    pub fn panel_extent(&self, slot: usize) -> Option<vk::Extent2D> {
        self.panels.get(slot).and_then(Panel::extent)
    }

    /// Leaves a panel out of the scene from the next draw on, since a headset's runtime shows it by itself; or takes it back.
    pub fn lift_panel(&mut self, slot: usize, lifted: bool) {
        if let Some(panel) = self.panels.get_mut(slot) {
            panel.lifted = lifted;
        }
    }

    /// Copies a panel's picture with the next draw into an image of the same size.
    pub fn copy_panel(&mut self, slot: usize, image: LayerImage) {
        if let Some(panel) = self.panels.get_mut(slot) {
            panel.copy = Some(image);
        }
    }

    /// Draws a scene into a target. Returns when the work is handed over, before it is done.
    ///
    /// # Errors
    /// [`RenderError`]; after [`RenderError::DeviceLost`] everything must be made anew.
    pub fn draw(
        &mut self,
        scene: &Scene,
        eyes: &[Eye; 2],
        target: &Target<'_>,
    ) -> Result<DrawReport, RenderError> {
        self.check_target(target)?;
        let at = usize::try_from(self.frame % SLOTS as u64).unwrap_or(0);
        let (commands, device) = self.slots[at].begin()?;
        self.frame += 1;
        let done = self.frame.saturating_sub(SLOTS as u64);
        self.garbage.retain(|(frame, _)| *frame > done);

        let mut state = self.update_tree(scene.tree.as_ref())?;
        let placed = scene
            .tree
            .as_ref()
            .filter(|_| self.tree.is_some() || self.coming.is_some());
        let copied = self.copy_tree(commands)?;
        if copied && state == TreeState::Copying {
            state = TreeState::Shown;
        }
        let (models, model) = self.update_models(scene, commands)?;
        let views = self.views_of(eyes);
        self.follow_wood(scene);
        let chosen = self.gather(scene, placed, &views, at)?;
        let points = self.points_each(scene);
        let budget = self.budget(scene, points);
        let mut painted = false;
        for panel in &mut self.panels {
            painted |= panel.record(&self.gpu, commands, at, self.frame, done)?;
        }

        let numbers = self.numbers(scene, eyes, placed);
        let slot = &mut self.slots[at];
        let (rods, solids) = data::room(scene);
        if slot.make_room(&self.gpu, rods, solids)? {
            write_set(&self.gpu, slot, &self.shadow, &self.wood);
        }
        let mut swapped = numbers;
        swapped.views.swap(0, 1);
        slot.frame.write(0, &[numbers]);
        slot.frame.write(block_stride(&self.gpu), &[swapped]);
        let counts = data::fill(
            scene,
            |slot| match self.panels.get(slot) {
                Some(panel) if panel.lifted => None,
                panel => Some(panel.is_some_and(Panel::painted)),
            },
            records::<RodData>(&mut slot.rods),
            records::<SolidData>(&mut slot.solids),
        );

        let pass = Pass {
            commands,
            counts,
            set: self.slots[at].set,
            list_set: self.selection.list_set(at),
            hidden: HiddenEyes::new(eyes),
            tree: self.tree.as_ref().filter(|_| placed.is_some()),
            models: &scene.models,
            points,
        };
        let key = self.shadow_key(placed, &numbers);
        if copied || painted || models {
            full_barrier(&self.gpu, commands, &[]);
        }
        let mut report = DrawReport {
            draws: 0,
            triangles: 0,
            chosen,
            segments: pass.tree.map_or(0, |tree| tree.segments),
            sent: if copied { self.sent } else { 0 },
            device,
            tree: state,
            plain: self.plain_tree(state),
            model,
        };
        if let Some(key) = key
            && self.drawn != Some(key)
        {
            let texel = numbers.tree.w;
            let sun = sun_views(
                self.params.sun,
                sphere_of(&pass, key.world_from_tree),
                texel,
            );
            let primitives = self.params.primitives;
            self.selection.record_sun(commands, at, sun, primitives);
            self.record_shadow(&pass, &mut report);
            self.drawn = Some(key);
        }
        if let Some(sun) = self.wood.due() {
            let primitives = self.params.primitives;
            self.selection.record_wood(commands, at, sun, primitives);
            self.record_wood(&pass, &mut report);
        }
        self.selection.record(commands, at, &views, budget);
        match self.params.mode {
            StereoMode::Multiview => self.record_both(&pass, target, &mut report),
            StereoMode::PerEye | StereoMode::OneEye => self.record_each(&pass, target, &mut report),
        }
        if target.depth.is_some() {
            depth_was_resolved(&self.gpu, commands);
        }
        self.slots[at].submit()?;
        Ok(report)
    }

    fn model_layouts(&self) -> ModelLayouts {
        let set = |layout: &super::pipelines::Layout, number: usize| {
            layout.sets.get(number).copied().unwrap_or_default()
        };
        ModelLayouts {
            drawn: set(&self.pipelines.model_layout, 1),
            chosen: set(&self.selection.layout, 1),
            skin: set(&self.pipelines.model_layout, 3),
            samplers: self.pipelines.image_samplers.handles,
        }
    }

    fn check_target(&self, target: &Target<'_>) -> Result<(), RenderError> {
        let fits = |image: &super::StereoImage, format| {
            image.extent == self.params.extent && image.format == format
        };
        let depth = target
            .depth
            .is_none_or(|depth| fits(depth, self.params.depth_format));
        if fits(target.color, self.params.color_format) && depth {
            Ok(())
        } else {
            Err(RenderError::Unsupported(
                "the target's size or format is not the renderer's; make a new renderer for it"
                    .to_owned(),
            ))
        }
    }

    /// Decides which tree is shown and starts uploads.
    fn update_tree(&mut self, placed: Option<&PlacedTree>) -> Result<TreeState, RenderError> {
        let Some(placed) = placed else {
            for gone in [self.tree.take(), self.coming.take()].into_iter().flatten() {
                self.garbage.push((self.frame, Garbage::Tree(gone)));
            }
            return Ok(TreeState::None);
        };
        let has = |upload: &Option<TreeUpload>| {
            upload
                .as_ref()
                .is_some_and(|upload| upload.revision == placed.revision)
        };
        if has(&self.tree) {
            // Back at the tree that is shown: what was on its way is not wanted any more, but for the same in levels of detail.
            if let Some(old) = self
                .coming
                .take_if(|coming| coming.revision != placed.revision)
            {
                self.garbage.push((self.frame, Garbage::Tree(old)));
            }
            return Ok(TreeState::Shown);
        }
        if has(&self.coming) {
            return Ok(TreeState::Copying);
        }
        if upload_size(placed) > self.params.direct_segments {
            return Ok(TreeState::Wanted(placed.revision));
        }
        let detail = if upload_size(placed) > self.params.direct_levels {
            Detail::Finest
        } else {
            Detail::Levels
        };
        let before = self.resident();
        let upload =
            TreeUpload::with_scratch(&self.gpu, placed, before, &mut self.scratch, detail)?;
        self.set_tree(upload);
        Ok(TreeState::Copying)
    }

    /// The revision of the shown tree, where it lacks levels of detail and nothing changes.
    fn plain_tree(&self, state: TreeState) -> Option<u64> {
        let tree = self.tree.as_ref()?;
        let rests = state == TreeState::Shown && self.coming.is_none();
        let waited = self.frame.saturating_sub(self.came) >= REST;
        (rests && waited && tree.detail == Detail::Finest).then_some(tree.revision)
    }

    /// The numbers that all shaders read.
    fn numbers(&self, scene: &Scene, eyes: &[Eye; 2], placed: Option<&PlacedTree>) -> FrameData {
        let bounds = self
            .tree
            .as_ref()
            .map(|tree| tree.bounds)
            .unwrap_or_default();
        let world_from_tree = placed
            .map(|placed| placed.world_from_tree)
            .filter(|map| map.is_finite())
            .unwrap_or_default();
        let shadow = placed.filter(|_| self.params.shadows).and_then(|placed| {
            let stir = self.stir_of(placed);
            shadow::projection(self.params.sun, &bounds, &world_from_tree, stir)
        });
        let texel = shadow.map_or(0.0, |(_, texel)| texel);
        let (wood_from_world, wood_texel) = self.wood.now.projection().unwrap_or_default();
        // A tree that waits for its successor stands whole.
        let growth = placed
            .filter(|placed| {
                self.tree
                    .as_ref()
                    .is_some_and(|tree| tree.revision == placed.revision)
            })
            .map_or(1.0, |placed| {
                crate::tree::growth::clamp_growth(placed.growth)
            });
        FrameData {
            views: [0, 1].map(|eye| ViewData::new(&eyes[eye], self.part.width)),
            sun: self.params.sun.extend(0.0),
            backdrop: match self.params.backdrop {
                Backdrop::Stage => Vec4::ZERO,
                Backdrop::Plain([red, green, blue, _]) => Vec4::new(red, green, blue, 1.0),
            },
            world_from_tree: Mat4::from(world_from_tree),
            tree: Vec4::new(
                growth,
                world_from_tree.x_axis.length(),
                if shadow.is_some() { 1.0 } else { 0.0 },
                texel,
            ),
            shadow_from_world: shadow.map_or(Mat4::IDENTITY, |(map, _)| map),
            spots: data::spots(scene, placed.map(|placed| (placed, bounds.foot))),
            light: LightData::of(self.params.light),
            wind: Vec4::new(self.sway.strength, self.sway.clock, 0.0, 0.0),
            root: placed.map_or(Vec4::ZERO, |placed| self.root_of(placed).extend(0.0)),
            wood_from_world,
            wood: Vec4::X * wood_texel,
        }
    }

    /// Waits until everything handed over is drawn.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`].
    pub fn wait(&self) -> Result<(), RenderError> {
        self.slots.iter().try_for_each(|slot| slot.commands.wait())
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        let _ = self.gpu.wait_idle();
    }
}

fn whole_buffer(buffer: vk::Buffer) -> vk::DescriptorBufferInfo {
    vk::DescriptorBufferInfo {
        buffer,
        offset: 0,
        range: vk::WHOLE_SIZE,
    }
}

/// The whole records that a buffer holds.
fn records<T: bytemuck::Pod>(buffer: &mut Buffer) -> &mut [T] {
    let bytes = buffer.bytes();
    let whole = bytes.len() / size_of::<T>() * size_of::<T>();
    // Mapped memory is aligned far beyond 16 bytes; if it ever is not, nothing is drawn rather than crashed.
    bytes
        .get_mut(..whole)
        .and_then(|bytes| bytemuck::try_cast_slice_mut(bytes).ok())
        .unwrap_or_default()
}

/// Writes a slot's set.
fn write_set(gpu: &Gpu, slot: &Slot, shadow: &Shadow, wood: &Wood) {
    let frame = [vk::DescriptorBufferInfo {
        buffer: slot.frame.handle,
        offset: 0,
        range: size_of::<FrameData>() as u64,
    }];
    let [map, wood_map] = [shadow, &wood.shadow].map(|shadow| {
        [vk::DescriptorImageInfo {
            image_view: shadow.view.handle,
            image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
            sampler: vk::Sampler::null(),
        }]
    });
    let sampler = [vk::DescriptorImageInfo {
        sampler: shadow.sampler,
        ..Default::default()
    }];
    let [shade_map, shade_sampler] = shadow.shade.described().map(|info| [info]);
    let [wood_shade, _] = wood.shadow.shade.described().map(|info| [info]);
    let rods = [whole_buffer(slot.rods.handle)];
    let solids = [whole_buffer(slot.solids.handle)];
    let write = |binding, kind| {
        vk::WriteDescriptorSet::default()
            .dst_set(slot.set)
            .dst_binding(binding)
            .descriptor_type(kind)
    };
    let writes = [
        write(0, vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC).buffer_info(&frame),
        write(1, vk::DescriptorType::SAMPLED_IMAGE).image_info(&map),
        write(2, vk::DescriptorType::SAMPLER).image_info(&sampler),
        write(3, vk::DescriptorType::STORAGE_BUFFER).buffer_info(&rods),
        write(4, vk::DescriptorType::STORAGE_BUFFER).buffer_info(&solids),
        write(5, vk::DescriptorType::SAMPLED_IMAGE).image_info(&shade_map),
        write(6, vk::DescriptorType::SAMPLER).image_info(&shade_sampler),
        write(7, vk::DescriptorType::SAMPLED_IMAGE).image_info(&wood_map),
        write(8, vk::DescriptorType::SAMPLED_IMAGE).image_info(&wood_shade),
    ];
    // SAFETY: the slot's last frame is done, so the set is free.
    unsafe { gpu.device.update_descriptor_sets(&writes, &[]) };
}
