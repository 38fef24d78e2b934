//! The sketch: what a person drew, as plain data, and how it becomes a growing tree.
//!
//! One polyline ([`Stroke`]) a letter: `A` is the trunk, each branch has its own letter and hangs on
//! a node of an earlier stroke. A stroke's points are relative to its own start, in the sketch's
//! axes, so moving a node carries the branches on it along and turns nothing. A stroke drawn free-hand is
//! a curve through some of its nodes, the handles ([`curve`]); [`freehand`] makes it from the path of a hand.
//!
//! The flow: [`change`] makes a new sketch from an old one (pure functions, strokes shared by `Arc`),
//! [`grammar`] writes the L-system a person may read and edit, [`grow()`] derives and draws it,
//! [`predict`] says beforehand how large that will be.
//!
//! Coordinates are multiples of 0.1 mm and angles of 0.001° ([`quantize`]), so that the same hand
//! movements give the same sketch, bit for bit, whatever headset reported them.

use std::{collections::HashMap, sync::Arc};

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::tree::error::shortest;

pub mod change;
pub mod curve;
mod dictionary;
pub mod freehand;
pub mod grammar;
pub mod grow;
pub mod habit;
pub mod letter;
pub mod own_rules;
pub mod predict;
pub mod quantize;
pub mod symmetry;

pub use freehand::{Freehand, FreehandParams};
pub use grow::{GROW, GrowParams, Grower, Grown, MAX_SEGMENTS, grow};
pub use habit::Habit;
pub use letter::{Letter, UnknownLetter};
pub use own_rules::{OwnRules, Production};
pub use predict::{Predictor, predict_segments_within};
pub use quantize::{angle_deg, coordinate, point, radius};
pub use symmetry::Symmetry;

/// The golden angle 180°·(3 − √5), in whole thousandths of a degree: the default divergence.
pub const GOLDEN_DEG: f64 = 137.508;

/// What a sketch may hold; beyond it a change is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Strokes, the trunk among them.
    pub strokes: usize,
    /// Points of all strokes together.
    pub points: usize,
    /// Largest distance from the sketch's root along one axis, metres.
    pub coordinate: f32,
    /// Shortest segment that can be drawn, metres.
    pub segment: f32,
    /// Largest angle that can be entered, degrees either way: a thousand turns.
    pub angle_deg: f64,
    /// Deepest nesting of a branch in itself.
    pub depth: u32,
    /// Largest growth step.
    pub step: u32,
    /// Smallest and largest scale from sketch to full size.
    pub scale: [f32; 2],
    /// Smallest and largest radius of a tip, metres.
    pub tip_radius: [f32; 2],
    /// Smallest and largest exponent of da Vinci's rule.
    pub radius_exponent: [f32; 2],
    /// Smallest and largest radius of a stroke that has its own, metres.
    pub radius: [f32; 2],
}

/// The bounds every sketch keeps.
pub const BOUNDS: Bounds = Bounds {
    strokes: 512,
    points: 100_000,
    coordinate: 1000.0,
    segment: 0.001,
    angle_deg: 360_000.0,
    depth: 64,
    step: 10_000,
    scale: [0.01, 1000.0],
    tip_radius: [0.0001, 1.0],
    radius_exponent: [1.0, 4.0],
    radius: [0.000_001, 100.0],
};

/// A node of a stroke: node 0 is the stroke's start, the last one its apex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NodeRef {
    /// The stroke.
    pub letter: Letter,
    /// How many segments above the stroke's start.
    pub node: u32,
}

impl NodeRef {
    /// The sketch's root: where the trunk starts.
    pub const ROOT: Self = Self::new(Letter::TRUNK, 0);

    /// Node `node` of stroke `letter`.
    #[must_use]
    pub const fn new(letter: Letter, node: u32) -> Self {
        Self { letter, node }
    }
}

/// How a letter carries copies of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SelfSimilar {
    /// A copy starts at every `rate`-th node of the letter; 1 or more.
    pub rate: u32,
    /// How often a copy may sit in a copy (0: none at all); none: without end.
    pub depth_limit: Option<u32>,
}

/// One polyline: the dictionary entry of its letter.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Its name.
    pub letter: Letter,
    /// Nodes 1, 2, … relative to node 0, metres in the sketch's axes. Node 0 itself is not stored.
    pub points: Vec<Vec3>,
    /// The nodes that the stroke's curve goes through, rising, the apex last; the nodes between them lie on the
    /// curve. Empty: a plain polyline, each of whose nodes is its own.
    pub handles: Vec<u32>,
    /// The node this stroke was drawn from (node ≥ 1 of an earlier stroke); none for the trunk.
    pub attachment: Option<NodeRef>,
    /// Whether the letter also branches from itself.
    pub self_similar: Option<SelfSimilar>,
    /// How thick it is at nodes 1, 2, …: radii in metres, as large as the sketch; 0: as thick as what grows from there makes it (da Vinci's rule). Empty: all of
    /// it is.
    pub radii: Vec<f32>,
}

impl Stroke {
    /// The number of segments, which is also the number of the apex node.
    #[must_use]
    pub fn segments(&self) -> u32 {
        u32::try_from(self.points.len()).unwrap_or(u32::MAX)
    }

    /// A node's place relative to the stroke's start.
    #[must_use]
    pub fn offset(&self, node: u32) -> Option<Vec3> {
        match node.checked_sub(1) {
            None => Some(Vec3::ZERO),
            Some(index) => self.points.get(index as usize).copied(),
        }
    }
}

/// What happens where the letters of a line outnumber the stroke's segments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wrap {
    /// The shape repeats on from the last heading: a curved trunk goes on curving.
    #[default]
    CarryHeading,
    /// The shape repeats in its first direction, as the published prototype did.
    Restart,
}

/// Everything drawn, and the angles and sizes that make a tree of it.
///
/// Invariants, which [`Sketch::validate`] checks and every change keeps: the first stroke is the
/// trunk, the only one that may be empty; letters differ; an attachment names an earlier stroke's
/// existing node ≥ 1; radii are none or one a node; handles rise and end at the apex; everything is finite, on the grid of [`quantize`] and within [`BOUNDS`].
#[derive(Clone, Debug, PartialEq)]
pub struct Sketch {
    /// The strokes in the order drawn; the trunk is the first.
    pub strokes: Vec<Arc<Stroke>>,
    /// Turn about the parent's axis from one branch to the next, degrees.
    pub divergence_deg: f64,
    /// Full size = sketch × scale.
    pub scale: f32,
    /// Radius of a growing tip at full size, metres.
    pub tip_radius: f32,
    /// Exponent of da Vinci's rule: 2 keeps the cross-section.
    pub radius_exponent: f32,
    /// How a line goes on after its last drawn segment.
    pub wrap: Wrap,
    /// Whether a branch drawn from now on carries copies of itself at the rate of its own
    /// attachment, as in the thesis.
    pub self_similar_branches: bool,
    /// Productions that a person wrote in the place of the generated ones.
    pub own_rules: Arc<OwnRules>,
    /// How the tree grows beyond what is drawn, and what it wears.
    pub habit: Arc<Habit>,
}

impl Default for Sketch {
    fn default() -> Self {
        let trunk = Stroke {
            letter: Letter::TRUNK,
            points: Vec::new(),
            handles: Vec::new(),
            attachment: None,
            self_similar: None,
            radii: Vec::new(),
        };
        Self {
            strokes: vec![Arc::new(trunk)],
            divergence_deg: GOLDEN_DEG,
            scale: 2.0,
            tip_radius: 0.02,
            radius_exponent: 2.0,
            wrap: Wrap::CarryHeading,
            self_similar_branches: true,
            own_rules: Arc::default(),
            habit: Arc::default(),
        }
    }
}

impl Sketch {
    /// The place of a letter's stroke in `strokes`.
    #[must_use]
    pub fn index_of(&self, letter: Letter) -> Option<usize> {
        self.strokes
            .iter()
            .position(|stroke| stroke.letter == letter)
    }

    /// A letter's stroke.
    #[must_use]
    pub fn stroke(&self, letter: Letter) -> Option<&Stroke> {
        self.index_of(letter).map(|index| &*self.strokes[index])
    }

    /// Whether nothing has been drawn.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.strokes.iter().all(|stroke| stroke.points.is_empty())
    }

    /// The last node of a letter's stroke.
    #[must_use]
    pub fn apex(&self, letter: Letter) -> Option<NodeRef> {
        let stroke = self.stroke(letter)?;
        Some(NodeRef::new(letter, stroke.segments()))
    }

    /// Whether a node is the last one of its stroke.
    #[must_use]
    pub fn is_apex(&self, at: NodeRef) -> bool {
        self.apex(at.letter) == Some(at)
    }

    /// Where a letter's stroke starts, metres in the sketch's axes from its root.
    #[must_use]
    pub fn start(&self, letter: Letter) -> Option<Vec3> {
        let mut sum = DVec3::ZERO;
        let mut stroke = self.stroke(letter)?;
        // An attachment names an earlier stroke, so this ends; the range bounds it in any case.
        for _ in 0..self.strokes.len() {
            let Some(at) = stroke.attachment else { break };
            stroke = self.stroke(at.letter)?;
            sum += stroke.offset(at.node)?.as_dvec3();
        }
        Some(sum.as_vec3())
    }

    /// Where a node stands, metres in the sketch's axes from its root.
    #[must_use]
    pub fn position(&self, at: NodeRef) -> Option<Vec3> {
        let offset = self.stroke(at.letter)?.offset(at.node)?;
        Some(self.start(at.letter)? + offset)
    }

    /// Where each stroke starts, in their order, as [`Self::start`] gives it: all of them in one pass.
    fn starts(&self) -> Vec<DVec3> {
        let mut place_of: HashMap<Letter, usize> = HashMap::with_capacity(self.strokes.len());
        let mut starts: Vec<DVec3> = Vec::with_capacity(self.strokes.len());
        for (place, stroke) in self.strokes.iter().enumerate() {
            // An attachment names an earlier stroke.
            let start = stroke.attachment.and_then(|at| {
                let parent = *place_of.get(&at.letter)?;
                let offset = self.strokes.get(parent)?.offset(at.node)?;
                Some(starts.get(parent)? + offset.as_dvec3())
            });
            starts.push(start.unwrap_or_default());
            place_of.insert(stroke.letter, place);
        }
        starts
    }

    /// Every node once with its place: the root, then each stroke's nodes 1, 2, … (a branch's node 0
    /// is a node of its parent).
    pub fn nodes(&self) -> impl Iterator<Item = (NodeRef, Vec3)> + '_ {
        let root = std::iter::once((NodeRef::ROOT, Vec3::ZERO));
        let lines = self.strokes.iter().zip(self.starts());
        root.chain(lines.flat_map(|(stroke, start)| {
            let start = start.as_vec3();
            (1..)
                .zip(&stroke.points)
                .map(move |(node, &offset)| (NodeRef::new(stroke.letter, node), start + offset))
        }))
    }

    /// Every segment once: its upper node, and the places of its lower and upper end.
    pub fn segments(&self) -> impl Iterator<Item = (NodeRef, Vec3, Vec3)> + '_ {
        let lines = self.strokes.iter().zip(self.starts());
        lines.flat_map(|(stroke, start)| {
            let start = start.as_vec3();
            let below = std::iter::once(start).chain(stroke.points.iter().map(move |&p| start + p));
            (1..)
                .zip(below.zip(&stroke.points))
                .map(move |(node, (from, &to))| {
                    (NodeRef::new(stroke.letter, node), from, start + to)
                })
        })
    }
}

/// Why a sketch cannot be changed, read or grown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SketchError {
    /// A rule of a person's own that the grammar cannot be read with: the grammar's message.
    #[error("{0}")]
    Rule(String),
    /// A letter without a stroke.
    #[error("the sketch has no stroke `{0}`")]
    NoStroke(Letter),
    /// A node beyond the stroke's end.
    #[error("stroke `{0}` has no node {1}: its last one is {2}")]
    NoNode(Letter, u32, u32),
    /// A branch from the root.
    #[error("no branch can start at the root: draw the trunk's first segment and branch above it")]
    BranchAtRoot,
    /// Node 0 of a branch named as if it were its own.
    #[error("the start of `{0}` is node {2} of `{1}`: point at that node instead")]
    StartOfBranch(Letter, Letter, u32),
    /// The root can neither be moved nor deleted.
    #[error("the root stays where it is: move the platform, or clear the sketch")]
    Root,
    /// NaN or infinite.
    #[error("{0} is not a finite number")]
    NotFinite(&'static str),
    /// Beyond the bounds.
    #[error("{what} must lie between {} and {}, not {}", shortest(*least), shortest(*most), shortest(*found))]
    OutOfBounds {
        /// What is out of bounds.
        what: &'static str,
        /// The value found.
        found: f64,
        /// Smallest allowed.
        least: f64,
        /// Largest allowed.
        most: f64,
    },
    /// A segment without length.
    #[error("segment {1} of `{0}` would be shorter than 1 mm: put its end farther from its start")]
    TooShort(Letter, u32),
    /// Too many of something.
    #[error("a sketch holds at most {most} {what}: delete some before drawing more")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// The bound.
        most: usize,
    },
    /// The first stroke is not the trunk, or another one has no attachment.
    #[error(
        "stroke `{0}` hangs nowhere: the first stroke must be the trunk `A` and every other one must name the node it grows from"
    )]
    Loose(Letter),
    /// Two strokes with one name.
    #[error("two strokes are called `{0}`: each letter may stand once")]
    Twice(Letter),
    /// An attachment that no earlier stroke has.
    #[error("stroke `{0}` hangs on node {2} of `{1}`, which no earlier stroke has")]
    BadAttachment(Letter, Letter, u32),
    /// Too far a step.
    #[error("growth ends at step {most}: step {found} is too far")]
    StepTooFar {
        /// The step asked for.
        found: u32,
        /// The largest one.
        most: u32,
    },
    /// Too large a tree.
    #[error(
        "step {step} would have more than {most} segments, and no more are grown: step back, or thin the branches out"
    )]
    TooLarge {
        /// The step asked for.
        step: u32,
        /// The bound.
        most: u64,
    },
    /// The engine refused the generated grammar, ran out of its limits or was cancelled.
    #[error("the sketch cannot be grown: {0}")]
    Grow(String),
    /// Handles that are no nodes, out of order, or all of them.
    #[error(
        "the handles of stroke `{0}` must be numbers of its nodes, rising, the last one its apex, and fewer than its nodes"
    )]
    Handles(Letter),
    /// A curve that says nothing or not everything.
    #[error(
        "a curve needs places to go through, and for each the number of segments, 1 or more, that lead to it"
    )]
    Spans,
    /// Radii that are not one for each node.
    #[error(
        "stroke `{0}` has {1} radii and {2} nodes: it needs one for each node behind its start, or none"
    )]
    Radii(Letter, usize, usize),
    /// A branch without segments.
    #[error("branch `{0}` has no segments: only the trunk may be empty")]
    EmptyBranch(Letter),
}
