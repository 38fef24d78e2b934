//! Pictures without a headset: of one tree, and of the whole stage from where all of it is seen.

use std::sync::Arc;

use anyhow::{Result, anyhow, bail};
use glam::{Affine3A, Quat, Vec2, Vec3};
use image::RgbaImage;
use ramus_xr::{Fov, Frame, Pose, View};

use crate::app::picture::Picture;
use crate::render::{Backdrop, Gpu, GpuParams, Headless};
use crate::tree::{Drawing, radii};
use crate::world::scene::weather::Light;
use crate::world::scene::{PlacedTree, Scene};

/// How a tree is placed for its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PortraitParams {
    /// Half the largest extent that the tree is brought to, metres: grammars have no common unit.
    pub radius: f32,
    /// The eye's height above the tree's middle, as a part of the distance; what is flat is seen straight on.
    pub rise: f32,
    /// Vertical field of view, radians.
    pub field: f32,
    /// How much room is left round the tree: 1 fills the picture.
    pub room: f32,
    /// What is shallower than this part of its larger extent is flat.
    pub flat: f32,
}

impl Default for PortraitParams {
    fn default() -> Self {
        Self {
            radius: 1.5,
            rise: 0.12,
            field: 0.7,
            room: 1.12,
            flat: 0.05,
        }
    }
}

/// Opens the device for pictures without a headset.
///
/// # Errors
/// Where there is no Vulkan device that can draw.
pub fn open_gpu() -> Result<Gpu> {
    Ok(Gpu::new(&Headless::default(), &GpuParams::from_env())?)
}

/// Half the width of the finest line that is drawn whole, pixels.
const FINEST_PX: f32 = 0.9;

/// Paper: what figures stand on in print, linear.
pub const PAPER: Backdrop = Backdrop::Plain([0.956, 0.939, 0.888, 1.0]);

/// What a tree's picture is taken before, and by what light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scenery {
    /// What is behind it.
    pub backdrop: Backdrop,
    /// What lights it.
    pub light: Light,
}

impl From<Backdrop> for Scenery {
    /// In daylight.
    fn from(backdrop: Backdrop) -> Self {
        Self {
            backdrop,
            light: Light::Day,
        }
    }
}

impl Scenery {
    /// So many pixels wide and high.
    fn picture(self, gpu: &Gpu, pixels: u32) -> Result<Picture> {
        Ok(Picture::before(gpu, pixels, pixels, self.backdrop)?.lit(self.light))
    }
}

/// Where an eye before a box (its middle, its extent) sees all of it, and no farther away than that takes.
pub(super) fn before_box(middle: Vec3, extent: Vec3, params: &PortraitParams) -> Vec3 {
    let is_flat = extent.z < params.flat * extent.x.max(extent.y);
    let rise = if is_flat { 0.0 } else { params.rise };
    let back = Vec3::new(0.0, rise, 1.0).normalize();
    let up = back.cross(Vec3::X);
    let slope = (params.field * 0.5).tan() / params.room;
    let distance = (0..8_u8).map(|corner| {
        let side = |bit: u8| if corner >> bit & 1 == 0 { -0.5 } else { 0.5 };
        let at = Vec3::new(side(0), side(1), side(2)) * extent;
        at.x.abs().max(at.dot(up).abs()) / slope + at.dot(back)
    });
    middle + back * distance.fold(0.0, f32::max)
}

/// Draws a drawing of any size in a scenery, as seen from before it; `pixels` wide and high, its widths as they are or
/// set for the picture's sake ([`radii::for_picture`]).
///
/// # Errors
/// Where there is nothing to see or no device can draw it.
pub fn of_drawing(
    drawing: Drawing,
    pixels: u32,
    set_widths: bool,
    scenery: impl Into<Scenery>,
) -> Result<RgbaImage> {
    let (scene, view) = sitting(drawing, pixels, set_widths, 1)?;
    let gpu = open_gpu()?;
    let mut picture = scenery.into().picture(&gpu, pixels)?;
    picture.draw_whole(&scene, &[view, view], None)?;
    let [left, _] = picture.read(None)?;
    Ok(left)
}

/// A device and what it draws on, for one picture after the other.
pub(super) struct Easel {
    // Before the device that it belongs to.
    picture: Picture,
    _gpu: Gpu,
    pixels: u32,
    drawn: u64,
}

impl Easel {
    /// For pictures that are `pixels` wide and high, in a scenery.
    ///
    /// # Errors
    /// Where no device can draw them.
    pub(super) fn new(pixels: u32, scenery: impl Into<Scenery>) -> Result<Self> {
        let gpu = open_gpu()?;
        Ok(Self {
            picture: scenery.into().picture(&gpu, pixels)?,
            _gpu: gpu,
            pixels,
            drawn: 0,
        })
    }

    /// Draws the next one, as [`of_drawing`] does with its widths set for the picture's sake.
    ///
    /// # Errors
    /// As [`of_drawing`].
    pub(super) fn draw(&mut self, drawing: Drawing) -> Result<RgbaImage> {
        self.drawn += 1;
        let (scene, view) = sitting(drawing, self.pixels, true, self.drawn)?;
        self.picture.draw_whole(&scene, &[view, view], None)?;
        let [left, _] = self.picture.read(None)?;
        Ok(left)
    }
}

/// Draws several, each as [`of_drawing`] does, in rows of as many as there are rows or one more; each is `pixels` wide and high.
///
/// # Errors
/// As [`of_drawing`].
pub fn sheet(
    drawings: &[Arc<Drawing>],
    pixels: u32,
    scenery: impl Into<Scenery>,
) -> Result<RgbaImage> {
    let count = u32::try_from(drawings.len()).unwrap_or(u32::MAX);
    let columns = (1..=count).find(|side| side.saturating_mul(*side) >= count);
    let columns = columns.unwrap_or(1);
    let rows = count.div_ceil(columns).max(1);
    let [width, height] = [columns, rows].map(|many| many.saturating_mul(pixels));
    let mut sheet: Option<RgbaImage> = None;
    let mut easel = Easel::new(pixels, scenery)?;
    for (place, drawing) in (0..count).zip(drawings) {
        let drawn = easel.draw(Drawing::clone(drawing))?;
        let at = [place % columns, place / columns].map(|at| i64::from(at * pixels));
        // Places that are left over look as what is behind the others.
        let behind = *drawn.get_pixel(0, 0);
        let sheet = sheet.get_or_insert_with(|| RgbaImage::from_pixel(width, height, behind));
        image::imageops::replace(sheet, &drawn, at[0], at[1]);
    }
    sheet.ok_or_else(|| anyhow!("there is no individual to draw"))
}

/// A drawing where it is to be drawn, and from where it is seen.
fn sitting(
    drawing: Drawing,
    pixels: u32,
    set_widths: bool,
    revision: u64,
) -> Result<(Scene, View)> {
    let params = PortraitParams::default();
    if drawing.is_empty() {
        bail!(
            "the tree has no segment, so there is nothing to draw: segments are drawn by `F` and by the letters of shapes"
        );
    }
    let Some((low, high)) = drawing.bounds() else {
        bail!("the tree has no node, so there is nothing to draw");
    };
    let extent = high - low;
    if !extent.is_finite() {
        bail!(
            "the drawing is so large that 32-bit coordinates do not hold it: make lengths and scales smaller"
        );
    }
    let half = (extent * 0.5).max_element();
    if half < f32::MIN_POSITIVE {
        bail!(
            "the tree's nodes all stand in one place, so there is nothing to draw: give its segments a length"
        );
    }
    let Drawing { mut tree, organs } = drawing;
    let scale = params.radius / half;
    let middle = (low + high) * 0.5;
    // What is lowest touches the ground.
    let foot = Vec3::new(middle.x, low.y, middle.z);
    let world_from_tree = Affine3A::from_scale_rotation_translation(
        Vec3::splat(scale),
        Quat::IDENTITY,
        -foot * scale,
    );
    let extent = (high - low) * scale;
    let target = Vec3::new(0.0, extent.y * 0.5, 0.0);
    let eye = before_box(target, extent, &params);
    // What wears bark was made to be looked at: its widths are meant.
    if set_widths && !organs.is_dressed() {
        #[allow(
            clippy::cast_precision_loss,
            reason = "no device draws as many pixels as f32 has whole numbers"
        )]
        let pixel = 2.0 * eye.distance(target) * (params.field * 0.5).tan() / pixels.max(1) as f32;
        radii::for_picture(&mut tree, FINEST_PX * pixel / scale);
    }
    let scene = Scene {
        tree: Some(PlacedTree {
            tree: Arc::new(tree),
            organs: Arc::new(organs),
            radius_before: Arc::default(),
            revision,
            world_from_tree,
            growth: 1.0,
            newest: u32::MAX,
        }),
        ..Scene::default()
    };
    let view = looking_at(eye, target, params.field);
    Ok((scene, view))
}

/// Field of view of a picture of the stage in radians: narrower than a headset's, which stretches what is at its edges.
const STAGE_FIELD: f32 = 1.05;

/// What is to be seen keeps this far from the picture's edges, as a part of half its width.
const STAGE_MARGIN: f32 = 0.06;

/// Nothing that is to be seen comes nearer to the eyes than this, metres.
const NEAREST: f32 = 0.6;

/// Both eyes of a person who stands before the platform, as far back as it takes to see all of it, the whole tree
/// and the board.
#[must_use]
pub fn of_stage(scene: &Scene) -> [View; 2] {
    let points = extremes(scene);
    let mut back = NEAREST;
    loop {
        let views = before(&points, back);
        // At ten thousand kilometres there are no more digits to look with.
        if back > 1e7
            || views
                .iter()
                .all(|view| points.iter().all(|&point| is_in(view, point)))
        {
            return views;
        }
        back *= 1.05;
    }
}

/// Corners of the boxes round what stands on the stage, in the stage's frame.
fn extremes(scene: &Scene) -> Vec<Vec3> {
    let mut points = Vec::new();
    let mut corners = |world_from_box: Affine3A, low: Vec3, high: Vec3| {
        for corner in 0..8_u8 {
            let pick =
                |bit: u8, low: f32, high: f32| if corner >> bit & 1 == 0 { low } else { high };
            points.push(world_from_box.transform_point3(Vec3::new(
                pick(0, low.x, high.x),
                pick(1, low.y, high.y),
                pick(2, low.z, high.z),
            )));
        }
    };
    if let Some(placed) = &scene.tree
        && let Some((low, high)) = placed.tree.bounds()
    {
        corners(placed.world_from_tree, low, high);
    }
    for model in &scene.models {
        let display = &model.display;
        corners(model.world_from_model, display.low, display.high);
    }
    for plate in &scene.plates {
        // A plate is a disc of radius 1 from 0 down to −1.
        corners(
            plate.world_from_plate,
            Vec3::NEG_ONE,
            Vec3::new(1.0, 0.0, 1.0),
        );
    }
    if let Some(board) = &scene.board {
        let half = Vec3::new(board.size[0] * 0.5, board.size[1] * 0.5, 0.0);
        corners(board.world_from_board, -half, half);
    }
    points.extend(scene.balls.iter().map(|ball| ball.center));
    points.retain(|point| point.is_finite());
    points
}

/// Both eyes at standing height, so far back on the stage, turned to the middle of what is to be seen.
fn before(points: &[Vec3], back: f32) -> [View; 2] {
    let eye = Frame::start().head.position + Vec3::Z * back;
    let angles = points.iter().map(|&point| {
        let way = point - eye;
        let ahead = (-way.z).max(f32::MIN_POSITIVE);
        Vec2::new(way.x.atan2(ahead), way.y.atan2(ahead))
    });
    let (low, high) = angles.fold((Vec2::MAX, Vec2::MIN), |(low, high), angle| {
        (low.min(angle), high.max(angle))
    });
    let middle = if points.is_empty() {
        Vec2::ZERO
    } else {
        (low + high) * 0.5
    };
    let ahead = Vec3::new(middle.x.tan(), middle.y.tan(), -1.0);
    let view = looking_at(eye, eye + ahead, STAGE_FIELD);
    Frame::eyes().map(|eye| View {
        pose: view.pose * eye.pose,
        ..view
    })
}

/// Whether a view shows a point, with room around it.
fn is_in(view: &View, point: Vec3) -> bool {
    let at = view.pose.orientation.conjugate() * (point - view.pose.position);
    let edge = view.fov.right.tan() * (1.0 - STAGE_MARGIN) * -at.z;
    -at.z >= NEAREST && at.x.abs() <= edge && at.y.abs() <= edge
}

/// A view from `eye` towards `target`, upright, `field` radians wide and high.
#[must_use]
pub fn looking_at(eye: Vec3, target: Vec3, field: f32) -> View {
    let ahead = (target - eye).normalize_or(Vec3::NEG_Z);
    let yaw = (-ahead.x).atan2(-ahead.z);
    let pitch = ahead.y.clamp(-1.0, 1.0).asin();
    let half = field * 0.5;
    View {
        pose: Pose {
            orientation: Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch),
            position: eye,
        },
        fov: Fov {
            left: -half,
            right: half,
            up: half,
            down: -half,
        },
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::tree::{NO_PARENT, Tree};
    use crate::world::World;
    use crate::world::history::History;

    /// Nodes in a row, so far from each other.
    fn row(nodes: u16, apart: f32) -> Tree {
        let count = usize::from(nodes);
        Tree {
            parent: (0..u32::from(nodes))
                .map(|node| node.checked_sub(1).unwrap_or(NO_PARENT))
                .collect(),
            position: (0..nodes)
                .map(|node| Vec3::new(10.0, apart * f32::from(node), 0.0))
                .collect(),
            radius: vec![0.01; count].into(),
            letter: vec![0; count].into(),
            order: vec![0; count].into(),
            birth: vec![0; count].into(),
            letters: vec!["F".to_owned()],
        }
    }

    #[test]
    fn a_tree_without_extent_is_refused_before_any_device_is_asked() {
        for (what, tree, expected) in [
            ("nothing", row(0, 0.0), "no segment"),
            ("the root alone", row(1, 0.0), "no segment"),
            ("all in one place", row(3, 0.0), "in one place"),
            ("a span beyond f32", row(2, f32::INFINITY), "so large"),
        ] {
            let error = of_drawing(tree.into(), 16, true, Backdrop::Stage)
                .unwrap_err()
                .to_string();
            assert!(error.contains(expected), "{what}: {error}");
        }
    }

    #[test]
    fn a_portrait_shows_the_whole_tree_and_fills_the_picture() {
        let params = PortraitParams::default();
        for (extent, is_flat) in [
            (Vec3::new(2.0, 2.0, 0.0), true),
            (Vec3::new(1.0, 3.0, 0.1), true),
            (Vec3::new(0.1, 3.0, 0.2), false),
            (Vec3::new(3.0, 0.0, 3.0), false),
            (Vec3::new(1.0, 2.0, 3.0), false),
        ] {
            let middle = Vec3::new(5.0, 1.5, -2.0);
            let eye = before_box(middle, extent, &params);
            assert_eq!(eye.y > middle.y, !is_flat, "{extent}");
            let view = looking_at(eye, middle, params.field);
            let farthest = (0..8_u8)
                .map(|corner| {
                    let side = |bit: u8| if corner >> bit & 1 == 0 { -0.5 } else { 0.5 };
                    let at = middle + Vec3::new(side(0), side(1), side(2)) * extent - eye;
                    let at = view.pose.orientation.conjugate() * at;
                    at.x.abs().max(at.y.abs()) / (-at.z * (params.field * 0.5).tan())
                })
                .fold(0.0, f32::max);
            let expected = 1.0 / params.room;
            assert!((farthest - expected).abs() < 1e-4, "{extent}: {farthest}");
        }
    }

    #[test]
    fn the_whole_stage_is_in_both_eyes_from_a_persons_height() {
        let mut stage = Scene::default();
        World::new(History::default()).scene(&mut stage);
        let mut nearest = 0.0;
        for (nodes, apart) in [(2, 0.5), (3, 2.0), (100, 1.0), (1000, 50.0)] {
            let tree = row(nodes, apart);
            let top = Vec3::new(0.0, apart * f32::from(nodes - 1), -6.0);
            stage.tree = Some(PlacedTree {
                tree: Arc::new(tree),
                organs: Arc::default(),
                radius_before: Arc::default(),
                revision: 1,
                world_from_tree: Affine3A::from_translation(Vec3::new(-10.0, 0.0, -6.0)),
                growth: 1.0,
                newest: u32::MAX,
            });
            let views = of_stage(&stage);
            let points = [top, Vec3::new(0.0, 0.0, -6.0)]
                .into_iter()
                .chain(extremes(&stage));
            for point in points {
                assert!(
                    views.iter().all(|view| is_in(view, point)),
                    "{nodes}: {point}"
                );
            }
            let [left, right] = views.map(|view| view.pose.position);
            assert!(left.x < right.x && left.y == right.y && (1.5..1.7).contains(&left.y));
            assert!(left.z >= nearest, "taller trees are seen from farther away");
            nearest = left.z;
        }
        assert!(nearest > 10_000.0);
    }
}
