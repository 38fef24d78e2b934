//! What is to be seen, as plain data in the stage's frame: `render` draws it and knows nothing else.
//!
//! The vectors keep their capacity from frame to frame, so that a warm loop allocates nothing.

use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};

use glam::{Affine3A, Vec3, Vec4};
use serde::{Deserialize, Serialize};

use crate::mesh::display::Display;
use crate::tree::{Organs, Tree};

pub mod weather;

pub use super::input::Pose;

/// Linear (not sRGB) colour with straight alpha, each 0 to 1.
pub type Color = [f32; 4];

/// A round rod between two points: sketch lines, rays, the preview.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rod {
    /// Start in metres.
    pub from: Vec3,
    /// End in metres.
    pub to: Vec3,
    /// Radius in metres.
    pub radius: f32,
    /// Colour; alpha below 1 marks a ghost (drawn see-through).
    pub color: Color,
}

/// A ball: a node, a mark, a handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre in metres.
    pub center: Vec3,
    /// Radius in metres.
    pub radius: f32,
    /// Colour; alpha below 1 marks a ghost.
    pub color: Color,
}

/// An upright round plate (the platform, its rim, the pedestal) with its own pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// Unit cylinder (radius 1, y from −1 to 0, top at 0) to stage.
    pub world_from_plate: Affine3A,
    /// Colour.
    pub color: Color,
}

/// A controller in the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller {
    /// Grip pose: controller to stage.
    pub world_from_grip: Affine3A,
    /// 0 left, 1 right.
    pub hand: usize,
    /// 0 to 1: how far the trigger is pulled (shown on the model).
    pub trigger: f32,
}

/// A number that no tree and no board in this process has had: one renderer may be shown several worlds, one after the
/// other, and would take the second world's first tree for the first world's if each counted for itself.
#[must_use]
pub fn new_revision() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed) + 1
}

/// A full-size tree on the stage.
#[derive(Clone, Debug)]
pub struct PlacedTree {
    /// The tree in its own frame, in its whole last state.
    pub tree: Arc<Tree>,
    /// What the tree carries besides its skeleton.
    pub organs: Arc<Organs>,
    /// Radius of each node one step earlier (0 for the newest nodes); empty: as in `tree`.
    pub radius_before: Arc<Vec<f32>>,
    /// Changes whenever `tree` does ([`new_revision`]); an unchanged number means nothing to upload.
    pub revision: u64,
    /// Tree to stage: a similarity (turn, move, one scale).
    pub world_from_tree: Affine3A,
    /// How far the newest step has grown, 0 (not begun) to 1 (whole).
    pub growth: f32,
    /// The newest step: segments with this birth are the ones that grow.
    pub newest: u32,
}

/// How a model's surface looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SurfaceLook {
    /// Lit by the sky alone, without gloss: shape without show.
    Matte,
    /// Lit by sky and sun, with gloss.
    #[default]
    Shaded,
    /// As its file colours it, where it does; else [`Self::Shaded`].
    Textured,
    /// Seen through, edges more than faces.
    XRay,
}

/// What of a model is to be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelLook {
    /// Its faces, or none.
    pub surface: Option<SurfaceLook>,
    /// Its edges, as lines of one width in the picture.
    pub wireframe: bool,
    /// Its vertices, as points of one size in the picture.
    pub vertices: bool,
    /// Each triangle with one normal of its own.
    pub flat: bool,
    /// Colour where [`Display::colours`] and [`Display::vertex_colours`] say none.
    pub color: Color,
    /// What lies in front of this plane of the stage (normal and distance along it) is cut away.
    pub cut: Option<Vec4>,
    /// A light in a hand: where on the stage.
    pub lamp: Option<Vec3>,
    /// Whether it stands on the ground for good and throws a shadow, on itself, too.
    pub shadow: bool,
}

impl Default for ModelLook {
    fn default() -> Self {
        Self {
            surface: Some(SurfaceLook::default()),
            wireframe: false,
            vertices: false,
            flat: false,
            // Between bone and plaster: takes any light, and every mark stands out from it.
            color: [0.62, 0.56, 0.47, 1.0],
            cut: None,
            lamp: None,
            shadow: false,
        }
    }
}

/// A scanned model on the stage.
#[derive(Clone, Debug)]
pub struct PlacedModel {
    /// What is drawn.
    pub display: Arc<Display>,
    /// Changes whenever `display` does ([`new_revision`]). Displays that share their [levels](Display::levels) differ in colours alone, and only those are
    /// uploaded anew.
    pub revision: u64,
    /// Model, from its mesh's origin, to stage: a similarity.
    pub world_from_model: Affine3A,
    /// What of it is to be seen.
    pub look: ModelLook,
}

impl PlacedModel {
    /// Whether it differs from another one in its place alone.
    #[must_use]
    pub fn is_drawn_as(&self, other: &Self) -> bool {
        self.revision == other.revision
            && Arc::ptr_eq(&self.display, &other.display)
            && self.look == other.look
    }
}

/// What a board says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoardContent {
    /// Heading.
    pub title: String,
    /// Lines of text, monospaced: the L-string, the rules, counts, button hints.
    pub lines: Vec<String>,
    /// A message to the person, in a colour that is seen.
    pub message: Option<String>,
}

/// A flat panel with text in the stage; `ui` lays the text out, `render` paints it.
#[derive(Clone, Debug, PartialEq)]
pub struct Board {
    /// Panel (x right, y up, unit: metres, origin at the centre) to stage.
    pub world_from_board: Affine3A,
    /// Width and height in metres.
    pub size: [f32; 2],
    /// Changes whenever `content` does ([`new_revision`]).
    pub revision: u64,
    /// The text.
    pub content: Arc<BoardContent>,
}

/// How many panels a scene can show, the board among them.
pub const MOST_PANELS: usize = 7;

/// A panel that hands point at; `ui` lays it out and `render` keeps its picture by `slot`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedPanel {
    /// Which picture it shows, 1 to [`MOST_PANELS`] − 1 (0 is the board's).
    pub slot: usize,
    /// Panel (x right, y up, unit: metres, origin at the centre) to stage.
    pub world_from_panel: Affine3A,
    /// Width and height in metres.
    pub size: [f32; 2],
}

/// One frame's picture.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Rods.
    pub rods: Vec<Rod>,
    /// Balls.
    pub balls: Vec<Ball>,
    /// Plates.
    pub plates: Vec<Plate>,
    /// Controllers that are tracked.
    pub controllers: Vec<Controller>,
    /// The tree, where there is one.
    pub tree: Option<PlacedTree>,
    /// Scanned models.
    pub models: Vec<PlacedModel>,
    /// The board with the step, the string and messages.
    pub board: Option<Board>,
    /// Panels to point at.
    pub panels: Vec<PlacedPanel>,
}
