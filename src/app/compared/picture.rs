//! The picture of a comparison: each tree alone, all of them over each other, before one camera and in colours of their own; below them how their
//! quantities are spread.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Result, anyhow, bail};
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect};
use glam::{Affine3A, DMat3, DVec3, Quat, Vec3};
use image::{RgbaImage, imageops};

use super::page::{curves, ink, told};
use crate::abstraction::blunt;
use crate::app::flat::paint;
use crate::app::picture::Picture;
use crate::app::plot::shortened;
use crate::app::portrait::{PAPER, PortraitParams, before_box, looking_at, open_gpu};
use crate::mesh::Mesh;
use crate::mesh::display::Display;
use crate::mesh::srgb::light;
use crate::tree::compare::told::About;
use crate::tree::compare::{Pair, Studied};
use crate::tree::{Tree, tubes};
use crate::ui::plot;
use crate::world::model::up;
use crate::world::scene::{ModelLook, PlacedModel, Scene, SurfaceLook, new_revision};

/// Seen from a corner, radians.
const TURN: f32 = 0.5;
/// No tube is thinner than this part of all trees' longest side.
const THINNEST: f32 = 0.0022;
/// Corners of a tube's ring, and of those of trees of many segments.
const SIDES: [u32; 2] = [8, 3];
const MANY_SEGMENTS: usize = 200_000;
/// Cells beside each other at most.
const PER_ROW: usize = 4;
/// Quantities whose curves are drawn, by name.
const SPREAD: [&str; 6] = [
    "branch_length",
    "point_radius",
    "centerline_length",
    "bifurcation_angle_deg",
    "parent_angle_deg",
    "tortuosity",
];

/// How trees are laid over each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlay {
    /// As their files have them.
    AsIs,
    /// Root to root, each upright, as large as it is.
    Rooted,
    /// Moved, scaled and turned so that they lie upon the first.
    Fitted,
}

impl Overlay {
    /// What is written below.
    fn words(self) -> &'static str {
        match self {
            Self::AsIs => "as they are",
            Self::Rooted => "root to root, as large as they are",
            Self::Fitted => "moved, scaled and turned onto the first",
        }
    }
}

/// A tree that is shown.
#[derive(Clone, Copy)]
pub struct Shown<'a> {
    /// The tree.
    pub tree: &'a Tree,
    /// Where its positions are counted from.
    pub origin: DVec3,
    /// Whether its third axis points up.
    pub z_up: bool,
}

/// What a picture shows, and how.
#[derive(Clone, Copy)]
pub struct Laid<'a> {
    /// What the trees are called.
    pub about: &'a [About],
    /// The trees.
    pub trees: &'a [Shown<'a>],
    /// What is known of them.
    pub studied: &'a [Studied],
    /// Their pairs.
    pub pairs: &'a [Pair],
    /// How they are laid over each other.
    pub overlay: Overlay,
    /// Width and height of a cell.
    pub pixels: u32,
}

/// Draws trees beside each other and over each other.
///
/// # Errors
/// Where there is nothing to see or no device can draw it.
pub fn picture(laid: &Laid<'_>) -> Result<RgbaImage> {
    let placed: Vec<Tree> = (0..laid.trees.len())
        .map(|place| placed(laid, place))
        .collect();
    let boxes = placed.iter().filter_map(Tree::bounds);
    let whole = boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let Some((low, high)) =
        whole.filter(|(low, high)| (*high - *low).max_element() > f32::MIN_POSITIVE)
    else {
        bail!("the trees have no extent, so there is nothing to draw");
    };
    let extent = high - low;
    if !extent.is_finite() {
        bail!(
            "the trees are so far apart that 32-bit coordinates do not hold them: lay them root to root"
        );
    }
    let params = PortraitParams::default();
    let scale = 2.0 * params.radius / extent.max_element();
    let middle = (low + high) * 0.5;
    // What is lowest touches the ground.
    let foot = Vec3::new(middle.x, low.y, middle.z);
    let world = Affine3A::from_scale_rotation_translation(
        Vec3::splat(scale),
        Quat::IDENTITY,
        -foot * scale,
    );
    let thinnest = THINNEST * extent.max_element();
    let models: Vec<PlacedModel> = placed
        .into_iter()
        .enumerate()
        .map(|(place, tree)| model(tree, thinnest, world, place))
        .collect::<Result<_>>()?;
    let extent = extent * scale;
    let target = Vec3::new(0.0, extent.y * 0.5, 0.0);
    let view = looking_at(before_box(target, extent, &params), target, params.field);
    let gpu = open_gpu()?;
    let mut one = Picture::before(&gpu, laid.pixels, laid.pixels, PAPER)?;
    let mut cells = Vec::new();
    let alone = models.iter().map(|model| vec![model.clone()]);
    for models in alone.chain([models.clone()]) {
        let scene = Scene {
            models,
            ..Scene::default()
        };
        one.draw_whole(&scene, &[view, view], None)?;
        if let Some(trouble) = one.take_trouble() {
            bail!("{trouble}");
        }
        let [left, _] = one.read(None)?;
        cells.push(left);
    }
    Ok(composed(laid, &cells))
}

/// A tree where it stands among the others: what is up is the second axis.
fn placed(laid: &Laid<'_>, place: usize) -> Tree {
    let Shown { tree, origin, z_up } = laid.trees[place];
    let first = laid.trees[0];
    let root = tree
        .position
        .first()
        .map_or(DVec3::ZERO, |root| root.as_dvec3());
    let fit = laid.pairs.iter().find(|pair| pair.places == [0, place]);
    let fit = fit
        .and_then(|pair| pair.space.as_ref())
        .map(|space| space.fitted);
    let upright =
        |z_up: bool| DMat3::from_quat((Quat::from_rotation_y(TURN) * up(z_up)).as_dquat());
    let (from, turn, scale) = match laid.overlay {
        Overlay::AsIs => (first.origin - origin, upright(first.z_up), 1.0),
        Overlay::Rooted => (root, upright(z_up), 1.0),
        Overlay::Fitted => match fit {
            Some(fit) => (root, upright(first.z_up) * fit.turn, fit.scale),
            None => (root, upright(z_up), 1.0),
        },
    };
    // Seen from here tips that were measured are as thick as what they end.
    let mut tree = blunt(tree);
    for at in tree.position.iter_mut() {
        *at = (turn * ((at.as_dvec3() - from) * scale)).as_vec3();
    }
    #[allow(clippy::cast_possible_truncation, reason = "radii are single")]
    tree.radius
        .iter_mut()
        .for_each(|radius| *radius *= scale as f32);
    tree
}

/// Tubes along a tree.
pub(in crate::app) fn tubes_along(tree: &Tree) -> Mesh {
    let mut records = Vec::new();
    tubes::segments(tree, &[], u32::MAX, &mut records);
    let sides = SIDES[usize::from(records.len() > MANY_SEGMENTS)];
    let made = tubes::mesh(&records, 1.0, sides);
    let (triangles, _) = made.indices.as_chunks::<3>();
    Mesh {
        positions: made.positions.into_iter().map(Vec3::from).collect(),
        triangles: triangles.to_vec(),
        ..Mesh::default()
    }
}

/// Tubes along a tree in its colour.
fn model(mut tree: Tree, thinnest: f32, world: Affine3A, place: usize) -> Result<PlacedModel> {
    tree.radius
        .iter_mut()
        .for_each(|radius| *radius = radius.max(thinnest));
    let mesh = Arc::new(tubes_along(&tree));
    let display = Display::for_picture(mesh, None, &AtomicBool::new(false));
    let display = display.ok_or_else(|| anyhow!("the drawing was cancelled"))?;
    Ok(PlacedModel {
        display: Arc::new(display),
        revision: new_revision(),
        world_from_model: world,
        look: ModelLook {
            surface: Some(SurfaceLook::Matte),
            color: light(colour(place)),
            ..ModelLook::default()
        },
    })
}

/// The colour of a tree.
pub(in crate::app) fn colour(place: usize) -> [u8; 3] {
    let written = ink(place);
    [1, 3, 5].map(|at| {
        let pair = written.get(at..at + 2).unwrap_or_default();
        u8::from_str_radix(pair, 16).unwrap_or(0)
    })
}

/// Puts cells, captions and curves together.
fn composed(laid: &Laid<'_>, cells: &[RgbaImage]) -> RgbaImage {
    let side = laid.pixels;
    let columns = cells.len().min(PER_ROW);
    let rows = cells.len().div_ceil(PER_ROW);
    let narrow = |count: usize| u32::try_from(count).unwrap_or(1);
    let caption = (side / 12).max(18);
    let width = narrow(columns) * side;
    let band = side * 2 / 5;
    let trees = narrow(rows) * (side + caption);
    let names: Vec<usize> = SPREAD
        .iter()
        .filter_map(|name| {
            laid.studied[0]
                .samples
                .iter()
                .position(|sample| sample.name == *name)
        })
        .collect();
    let per_row = (2 * columns).clamp(2, names.len().max(2));
    let bands = narrow(names.len().div_ceil(per_row));
    let ground = cells[0].get_pixel(0, 0);
    let mut image = RgbaImage::from_pixel(width, trees + bands * band, *ground);
    let corner = |place: usize| {
        [
            narrow(place % PER_ROW) * side,
            narrow(place / PER_ROW) * (side + caption),
        ]
    };
    for (place, cell) in cells.iter().enumerate() {
        let [x, y] = corner(place);
        imageops::replace(&mut image, cell, x.into(), (y + caption).into());
    }
    let size = (side as f32 / 30.0).clamp(9.0, 40.0);
    paint(&mut image, |painter| {
        for place in 0..cells.len() {
            let [x, y] = corner(place).map(|at| at as f32);
            let rect =
                Rect::from_min_size(Pos2::new(x, y), egui::vec2(side as f32, caption as f32));
            match laid.about.get(place) {
                Some(about) => name(painter, rect, size, &about.name, place),
                None => {
                    let words = laid.overlay.words();
                    painter.text(
                        rect.center(),
                        Align2::CENTER_CENTER,
                        words,
                        FontId::proportional(size),
                        INK,
                    );
                }
            }
        }
        let wide = width as f32 / per_row as f32;
        for (place, sample) in names.iter().enumerate() {
            let x = (place % per_row) as f32 * wide;
            let y = trees as f32 + (place / per_row) as f32 * band as f32;
            let rect = Rect::from_min_size(Pos2::new(x, y), egui::vec2(wide, band as f32));
            spread(painter, rect.shrink(size * 0.6), size * 0.8, laid, *sample);
        }
    });
    image
}

fn opaque(place: usize) -> Color32 {
    let [red, green, blue] = colour(place);
    Color32::from_rgb(red, green, blue)
}

const INK: Color32 = Color32::from_rgb(26, 26, 26);
const PALE: Color32 = Color32::from_rgb(107, 107, 107);

/// A tree's name in the middle, with its colour before it.
fn name(painter: &Painter, rect: Rect, size: f32, name: &str, place: usize) {
    let letters = (0..200_u16)
        .take_while(|count| f32::from(*count) * size * 0.55 < rect.width() - 3.0 * size);
    let said = shortened(name, letters.count().max(4));
    let text = painter.text(
        rect.center() + egui::vec2(size * 0.6, 0.0),
        Align2::CENTER_CENTER,
        said,
        FontId::proportional(size),
        INK,
    );
    let square = egui::vec2(size * 0.8, size * 0.8);
    let middle = Pos2::new(text.left() - size * 0.8, rect.center().y);
    painter.rect_filled(Rect::from_center_size(middle, square), 0.0, opaque(place));
}

/// How a quantity is spread, one tree over the other.
fn spread(painter: &Painter, rect: Rect, size: f32, laid: &Laid<'_>, sample: usize) {
    let title = laid.studied[0].samples[sample].words;
    let font = FontId::proportional(size);
    painter.text(rect.left_top(), Align2::LEFT_TOP, title, font.clone(), INK);
    if let [pair] = laid.pairs {
        let below = rect.left_top() + egui::vec2(0.0, size * 1.3);
        let said = told(&pair.distributions[sample]);
        painter.text(
            below,
            Align2::LEFT_TOP,
            said,
            FontId::proportional(size * 0.9),
            PALE,
        );
    }
    let plot = Rect::from_min_max(
        rect.min + egui::vec2(0.0, size * 2.9),
        rect.max - egui::vec2(0.0, size * 1.5),
    );
    let Some(shown) = curves(laid.studied, sample) else {
        painter.text(
            plot.center(),
            Align2::CENTER_CENTER,
            "nothing to show",
            font,
            PALE,
        );
        return;
    };
    let inks: Vec<Color32> = (0..shown.curves.len()).map(opaque).collect();
    plot::spread(painter, plot, size, &shown, (&inks, INK));
}
