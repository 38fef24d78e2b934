//! The document: all that a person made and set, and the edits that change it.
//!
//! An [`Edit`] is plain data that can be written down, so one journal line repeats it. Applying an
//! edit is a pure function: same document and edit, same result, bit for bit. What an edit carries is
//! first brought to the grid of `sketch::quantize`; an edit that would break something is refused
//! with a sentence for the person, and the document stays as it was.
//!
//! The selection is part of the document, because it decides where the trigger draws: choosing a
//! node is an edit (undoable like any other), and drawing and deleting move it along.

use std::sync::Arc;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::grove::{self, Grove, Plant};
use super::model::{self, Model, ModelError};
use super::project;
use super::taken::TakenLine;
use crate::sketch::{
    BOUNDS, Habit, Letter, NodeRef, SelfSimilar, Sketch, SketchError, Symmetry, Wrap, quantize,
};

/// Where the platform stands on the stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// Centre of the platform's top, metres in the stage's frame: the sketch's root.
    pub position: Vec3,
    /// Turn about +Y, degrees, 0…360 (in degrees because it lies on the grid of 0.001°).
    pub yaw_deg: f64,
    /// Stage metres in one sketch metre.
    pub scale: f32,
}

/// Bounds of a [`Placement`]: beyond them the platform could not be found or gripped any more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacementBounds {
    /// Largest distance from the stage's origin along one axis, metres.
    pub position: f32,
    /// Smallest and largest scale.
    pub scale: [f32; 2],
}

/// The bounds of every placement.
pub const PLACEMENT_BOUNDS: PlacementBounds = PlacementBounds {
    position: 1000.0,
    scale: [0.05, 20.0],
};

impl Default for Placement {
    /// Half an arm's length ahead, at the height of a table, one to four: an arm's length of drawing is
    /// a sapling of two metres, and the tree at full size (twice the sketch by default) some metres high.
    fn default() -> Self {
        Self {
            position: Vec3::new(0.0, 0.9, -0.55),
            yaw_deg: 0.0,
            scale: 0.25,
        }
    }
}

impl Placement {
    /// The turn about +Y in radians.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "poses are f32")]
    pub fn yaw(&self) -> f32 {
        self.yaw_deg.to_radians() as f32
    }

    /// The placement on the grid, its turn brought to 0…360° (one beyond all bounds stays, for the
    /// checks to find).
    #[must_use]
    pub fn quantized(&self) -> Self {
        let yaw_deg = quantize::angle_deg(self.yaw_deg);
        let yaw_deg = match yaw_deg.abs() <= BOUNDS.angle_deg {
            true => quantize::angle_deg(yaw_deg.rem_euclid(360.0)),
            false => yaw_deg,
        };
        Self {
            position: quantize::point(self.position),
            yaw_deg,
            scale: quantize::coordinate(self.scale),
        }
    }

    /// # Errors
    /// Where a number is not finite or out of [`PLACEMENT_BOUNDS`].
    pub fn validate(&self) -> Result<(), EditError> {
        let most = PLACEMENT_BOUNDS.position;
        let position_fits = self.position.is_finite() && self.position.abs().max_element() <= most;
        let [least, largest] = PLACEMENT_BOUNDS.scale;
        if !position_fits || !(0.0..=360.0).contains(&self.yaw_deg) {
            return Err(EditError::PlatformPlace);
        }
        if !(least..=largest).contains(&self.scale) {
            return Err(EditError::PlatformScale);
        }
        Ok(())
    }
}

/// Everything that is kept: cheap to clone, compared by content.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// What is drawn, with its angles and sizes.
    pub sketch: Arc<Sketch>,
    /// Growth step; 0 shows the root alone.
    pub step: u32,
    /// Where the platform stands.
    pub platform: Placement,
    /// The node from which the trigger draws: at an apex the line goes on, elsewhere a branch starts.
    pub selected: NodeRef,
    /// Scanned models on the stage.
    pub models: Arc<Vec<Model>>,
    /// Whether the platform and all models turn together.
    pub linked: bool,
    /// Trees that are planted on the stage.
    pub grove: Arc<Grove>,
}

impl Default for Document {
    fn default() -> Self {
        Self {
            sketch: Arc::new(Sketch::default()),
            step: 0,
            platform: Placement::default(),
            selected: NodeRef::ROOT,
            models: Arc::default(),
            linked: false,
            grove: Arc::default(),
        }
    }
}

/// One action of a person. Places are metres in the sketch's axes from its root.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Edit {
    /// Chooses the node from which the trigger draws.
    Select {
        /// The node; node 0 of a branch means the parent's node it hangs on.
        at: NodeRef,
    },
    /// Draws from the selected node: the line goes on at an apex, a branch starts elsewhere. The new
    /// apex is selected.
    AddSegment {
        /// Where the segment ends.
        to: Vec3,
    },
    /// Draws several segments from the selected node, as one action.
    AddStroke {
        /// Where each segment ends.
        to: Vec<Vec3>,
    },
    /// Takes lines of a model into the sketch, as one action. The first one's apex is selected.
    TakeLines {
        /// Each starts at the selected node or at one before it.
        lines: Vec<TakenLine>,
    },
    /// Draws a curve, as one action: a free-hand stroke, or segments with their symmetric copies. The new apex is
    /// selected.
    DrawCurve {
        /// Where it starts: the line goes on at an apex, a branch starts elsewhere.
        from: NodeRef,
        /// The handles it goes through.
        through: Vec<Vec3>,
        /// How many segments lead to each of these, 1 or more.
        segments: Vec<u32>,
        /// Which copies of a branch are drawn with it.
        #[serde(default, skip_serializing_if = "Symmetry::is_off")]
        symmetry: Symmetry,
    },
    /// Moves a node; branches that start at it travel along. Its neighbours stay, but on a curve the nodes between
    /// handles follow.
    MoveNode {
        /// The node.
        at: NodeRef,
        /// Its new place.
        to: Vec3,
    },
    /// Deletes a node and all above it on its line, with the branches attached there. The node
    /// below is selected.
    DeleteNode {
        /// The node.
        at: NodeRef,
    },
    /// Deletes everything drawn and returns to step 0.
    Clear,
    /// Goes to a growth step.
    SetStep {
        /// The step, 0 the root alone.
        step: u32,
    },
    /// Sets the turn from one branch to the next.
    SetDivergence {
        /// Degrees.
        degrees: f64,
    },
    /// Moves, turns or scales the platform.
    SetPlatform {
        /// Its new place.
        to: Placement,
    },
    /// Brings models, takes them away, moves them or shows them otherwise; with what is linked, the platform turns, too.
    Arrange {
        /// All models as they are then.
        models: Vec<Model>,
        /// Where the platform stands then.
        platform: Placement,
        /// Whether all turn together from now on.
        linked: bool,
    },
    /// Switches a letter's copies of itself.
    SetSelfSimilar {
        /// The letter.
        letter: Letter,
        /// Rate and depth limit, or none: off.
        to: Option<SelfSimilar>,
    },
    /// Lets a letter be as thick as what grows from it makes it, whatever radii a scan gave it.
    ForgetRadii {
        /// The letter.
        letter: Letter,
    },
    /// Decides whether branches drawn from now on carry copies of themselves.
    SetSelfSimilarBranches {
        /// On or off.
        on: bool,
    },
    /// Sets the sizes of the full-size tree.
    SetSizes {
        /// Full size over sketch.
        scale: f32,
        /// Radius of a tip, metres.
        tip_radius: f32,
        /// Exponent of da Vinci's rule.
        radius_exponent: f32,
    },
    /// Writes a production in the place of a generated one, or further lines of the grammar.
    SetRule {
        /// The name or the left side of the generated one; empty: further lines.
        of: String,
        /// The text; none: the generated one is back.
        to: Option<String>,
    },
    /// Sets how a line goes on after its last drawn segment.
    SetWrap {
        /// Heading carried over, or restarted.
        to: Wrap,
    },
    /// Sets how the tree grows beyond what is drawn, and what it wears.
    SetHabit {
        /// All of it.
        to: Box<Habit>,
    },
    /// Begins anew with the sketch of a species, at the step that it is shown at.
    TakeSpecies {
        /// Its project file.
        project: String,
    },
    /// Plants trees of the one on the platform, as one action.
    Plant {
        /// Each with its place; what kind they say is not looked at.
        trees: Vec<Plant>,
    },
    /// Takes planted trees away, as one action.
    Uproot {
        /// Their numbers, from 0, in the order in which they were planted.
        trees: Vec<u32>,
    },
}

impl Edit {
    /// The edit with every number on the grid: what is applied, and what the journal keeps.
    #[must_use]
    pub fn quantized(&self) -> Self {
        let mut edit = self.clone();
        match &mut edit {
            Self::AddSegment { to } | Self::MoveNode { to, .. } => *to = quantize::point(*to),
            Self::AddStroke { to } | Self::DrawCurve { through: to, .. } => {
                to.iter_mut().for_each(|to| *to = quantize::point(*to));
            }
            Self::TakeLines { lines } => {
                let places = lines.iter_mut().flat_map(|line| &mut line.to);
                places.for_each(|to| *to = quantize::point(*to));
                let radii = lines.iter_mut().flat_map(|line| &mut line.radii);
                radii.for_each(|radius| *radius = quantize::radius(*radius));
            }
            Self::SetDivergence { degrees } => *degrees = quantize::angle_deg(*degrees),
            Self::SetPlatform { to } => *to = to.quantized(),
            Self::Arrange {
                models, platform, ..
            } => {
                *platform = platform.quantized();
                models
                    .iter_mut()
                    .for_each(|model| *model = model.quantized());
            }
            Self::SetSizes {
                scale,
                tip_radius,
                radius_exponent,
            } => {
                for size in [scale, tip_radius, radius_exponent] {
                    *size = quantize::coordinate(*size);
                }
            }
            Self::SetHabit { to } => **to = to.quantized(),
            Self::Plant { trees } => trees.iter_mut().for_each(|tree| *tree = tree.quantized()),
            Self::Select { .. }
            | Self::DeleteNode { .. }
            | Self::Clear
            | Self::TakeSpecies { .. }
            | Self::Uproot { .. }
            | Self::SetStep { .. }
            | Self::SetSelfSimilar { .. }
            | Self::ForgetRadii { .. }
            | Self::SetSelfSimilarBranches { .. }
            | Self::SetRule { .. }
            | Self::SetWrap { .. } => {}
        }
        edit
    }
}

impl Edit {
    /// Whether the productions that the sketch makes may be others after this.
    fn changes_rules(&self) -> bool {
        !matches!(
            self,
            Self::Select { .. }
                | Self::MoveNode { .. }
                | Self::SetStep { .. }
                | Self::SetPlatform { .. }
                | Self::Arrange { .. }
                | Self::SetDivergence { .. }
                | Self::SetSizes { .. }
                | Self::ForgetRadii { .. }
                | Self::SetWrap { .. }
                | Self::Plant { .. }
                | Self::Uproot { .. }
        )
    }
}

/// Longest project of a species, bytes: each that is taken is a line of the journal.
const SPECIES_BYTES: usize = 4 << 20;

/// Why an edit was refused; the document is unchanged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EditError {
    /// The sketch refused it.
    #[error(transparent)]
    Sketch(#[from] SketchError),
    /// The platform's place is NaN, infinite or far out.
    #[error(
        "the platform cannot stand there: its place must be finite and within {} m of the room's middle",
        PLACEMENT_BOUNDS.position
    )]
    PlatformPlace,
    /// The platform's scale is out of bounds.
    #[error(
        "the platform's scale must lie between {} and {}",
        PLACEMENT_BOUNDS.scale[0],
        PLACEMENT_BOUNDS.scale[1]
    )]
    PlatformScale,
    /// A model that no project has.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A species that is no project.
    #[error("this species cannot be taken: {0}")]
    Species(String),
    /// A line that is taken starts at one that is not before it.
    #[error("a line that is taken must start at the selected node or at a line before it")]
    NoLine,
    /// A planted tree's place is NaN, infinite or far out.
    #[error(
        "a tree cannot be planted there: its place must be finite and within {} m of the stage's middle",
        grove::FARTHEST
    )]
    PlantPlace,
    /// A planted tree's turn is none.
    #[error("a planted tree is turned by {0} degrees: give 0 to 360")]
    PlantTurn(f64),
    /// A planted tree that no grove has.
    #[error(
        "a planted tree must be one of {} individuals of a kind that is there, {} to {} times as large as it grew",
        grove::INDIVIDUALS,
        grove::SIZES[0],
        grove::SIZES[1]
    )]
    Plant,
    /// Too many planted trees.
    #[error(
        "{} trees are planted, and there is room for no more: uproot some first",
        grove::PLANTS_MOST
    )]
    GroveFull,
    /// Too many kinds of planted trees.
    #[error(
        "the grove is of {} different trees, and there is room for no other: uproot all of one first",
        grove::KINDS_MOST
    )]
    GroveKinds,
    /// A planted tree that is not there.
    #[error("there is no planted tree to take away")]
    NoPlant,
    /// Nothing on the platform to plant.
    #[error("there is nothing to plant yet: draw a tree or choose a species, and let it grow")]
    NothingToPlant,
    /// Nothing to draw.
    #[error("a stroke needs at least one segment")]
    EmptyStroke,
    /// A journal's undo or redo without anything to undo or redo.
    #[error("there is nothing to undo or redo")]
    NothingToRepeat,
}

impl Document {
    /// The document after an edit.
    ///
    /// # Errors
    /// Where the edit would break the document; it is then as it was.
    pub fn after(&self, edit: &Edit) -> Result<Self, EditError> {
        let mut next = self.clone();
        let sketch = &*self.sketch;
        let changed = match edit.quantized() {
            Edit::Select { at } => {
                sketch.check_node(at)?;
                next.selected = sketch.own_name(at);
                None
            }
            Edit::AddSegment { to } => {
                let (sketch, apex) = sketch.add_segment(self.selected, to)?;
                next.selected = apex;
                Some(sketch)
            }
            Edit::AddStroke { to } if to.is_empty() => return Err(EditError::EmptyStroke),
            Edit::AddStroke { to } => {
                let (sketch, apex) = sketch.add_segments(self.selected, &to)?;
                next.selected = apex;
                Some(sketch)
            }
            Edit::TakeLines { lines } => {
                let (sketch, apex) = self.taken(&lines)?;
                next.selected = apex;
                Some(sketch)
            }
            Edit::DrawCurve {
                from,
                through,
                segments,
                symmetry,
            } => {
                let (sketch, apex) = sketch.draw_curve(from, &through, &segments, symmetry)?;
                next.selected = apex;
                Some(sketch)
            }
            Edit::MoveNode { at, to } => Some(sketch.move_node(at, to)?),
            Edit::DeleteNode { at } => {
                let (sketch, below) = sketch.delete_node(at)?;
                next.selected = below;
                Some(sketch)
            }
            Edit::Clear => {
                next.selected = NodeRef::ROOT;
                next.step = 0;
                next.grove = Arc::new(self.grove.kept(&self.sketch, self.step));
                Some(sketch.clear())
            }
            Edit::SetStep { step } => {
                next.step = step;
                None
            }
            Edit::SetDivergence { degrees } => Some(sketch.with_divergence(degrees)?),
            Edit::SetPlatform { to } => {
                next.platform = to;
                None
            }
            Edit::Arrange {
                models,
                platform,
                linked,
            } => {
                next.models = Arc::new(models);
                (next.platform, next.linked) = (platform, linked);
                None
            }
            Edit::SetSelfSimilar { letter, to } => Some(sketch.with_self_similar(letter, to)?),
            Edit::ForgetRadii { letter } => Some(sketch.without_radii(letter)?),
            Edit::SetSelfSimilarBranches { on } => Some(Sketch {
                self_similar_branches: on,
                ..sketch.clone()
            }),
            Edit::SetSizes {
                scale,
                tip_radius,
                radius_exponent,
            } => Some(sketch.with_sizes(scale, tip_radius, radius_exponent)?),
            Edit::SetRule { of, to } => Some(sketch.with_rule(&of, to.as_deref())?),
            Edit::SetWrap { to } => Some(sketch.with_wrap(to)),
            Edit::SetHabit { to } => Some(sketch.with_habit(*to)?),
            Edit::TakeSpecies { project } if project.len() > SPECIES_BYTES => {
                let message = format!("it is longer than {SPECIES_BYTES} bytes");
                return Err(EditError::Species(message));
            }
            Edit::TakeSpecies { project } => {
                let species = project::from_bytes(project.as_bytes())
                    .map_err(|error| EditError::Species(error.to_string()))?;
                next.selected = species.selected;
                next.step = species.step;
                next.grove = Arc::new(self.grove.kept(&self.sketch, self.step));
                Some(Sketch::clone(&species.sketch))
            }
            Edit::Plant { trees } => {
                if self.step == 0 || sketch.is_empty() {
                    return Err(EditError::NothingToPlant);
                }
                next.grove = Arc::new(self.grove.with(&trees)?);
                None
            }
            Edit::Uproot { trees } => {
                next.grove = Arc::new(self.grove.without(&trees)?);
                None
            }
        };
        if let Some(mut sketch) = changed {
            if edit.changes_rules() {
                sketch.prune_rules();
                sketch.check_own_rules()?;
            }
            next.sketch = Arc::new(sketch);
        }
        next.validate_settings()?;
        Ok(next)
    }

    /// The sketch with lines that are taken into it, none of which carries copies of itself, and the apex of the first.
    fn taken(&self, lines: &[TakenLine]) -> Result<(Sketch, NodeRef), EditError> {
        let mut sketch = Sketch {
            self_similar_branches: false,
            ..Sketch::clone(&self.sketch)
        };
        // Each line's letter, and where on that it begins: at an apex a line goes on.
        let mut begun: Vec<(Letter, u32)> = Vec::with_capacity(lines.len());
        let mut first = None;
        for line in lines {
            let from = match line.from {
                None => self.selected,
                Some([number, node]) => {
                    let (letter, begins) = begun.get(number as usize).ok_or(EditError::NoLine)?;
                    NodeRef::new(*letter, begins.saturating_add(node))
                }
            };
            if line.to.is_empty() {
                return Err(EditError::EmptyStroke);
            }
            let begins = if sketch.is_apex(from) { from.node } else { 0 };
            let (next, apex) = match line.radii.as_slice() {
                [] => sketch.add_segments(from, &line.to)?,
                radii => sketch.add_thick_segments(from, &line.to, radii)?,
            };
            begun.push((apex.letter, begins));
            first.get_or_insert(apex);
            sketch = next;
        }
        sketch.self_similar_branches = self.sketch.self_similar_branches;
        Ok((sketch, first.ok_or(EditError::EmptyStroke)?))
    }

    /// Checks everything, as a file from elsewhere needs it.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn validate(&self) -> Result<(), EditError> {
        self.sketch.validate()?;
        self.sketch.check_own_rules()?;
        self.sketch.check_node(self.selected)?;
        self.validate_settings()
    }

    fn validate_settings(&self) -> Result<(), EditError> {
        if self.step > BOUNDS.step {
            return Err(SketchError::StepTooFar {
                found: self.step,
                most: BOUNDS.step,
            }
            .into());
        }
        model::validate(&self.models)?;
        self.grove.validate()?;
        self.platform.validate()
    }
}
