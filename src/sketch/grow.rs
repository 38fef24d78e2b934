//! From sketch to tree: grammar text → derivation → turtle → da Vinci's radii.
//!
//! A pure function of sketch and step. It goes through the grammar's text on purpose: what a person
//! reads and may edit is exactly what grows. The engine's birth 0 (the axiom) is step 1 here,
//! because step 0 shows the root alone.
//!
//! The string does not depend on where the nodes are, only on which there are. A [`Grower`] therefore
//! keeps strings ([`History`]): moving a node draws one anew without deriving it, a step forward
//! derives one step, a step back none, and a stroke more or less leaves what grew before it. What it
//! gives is what [`grow`] gives.

use std::collections::HashMap;
use std::sync::atomic::AtomicBool;

use super::{BOUNDS, Letter, Predictor, Sketch, SketchError, dictionary::Dictionary};
use crate::{
    lsystem::{Grammar, History, Limits, TurtleParams, interpret},
    tree::{
        NO_PARENT, Organs, Tree,
        radii::{RadiusParams, da_vinci, da_vinci_given},
    },
};

/// Bounds of growing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GrowParams {
    /// Segments beyond which a step is refused, before anything is derived.
    pub segments: u64,
    /// Longest text of the string, in bytes; beyond it the text is cut.
    pub string_bytes: usize,
}

/// Segments beyond which neither the tools go on growing nor a tree is asked for or grown.
pub const MAX_SEGMENTS: u64 = 2_000_000;

/// What the workshop grows with: two million segments are some 200 MiB of tree and tubes.
pub const GROW: GrowParams = GrowParams {
    segments: MAX_SEGMENTS,
    string_bytes: 4096,
};

/// Modules that may come with one segment: its end, brackets and roll, and, while a step is being made,
/// a helper for each stroke.
const MODULES_PER_SEGMENT: u64 = 8;

/// Modules beyond which a sketch of which nothing is known beforehand (rules of a person's own, ends that rest or starve) is refused.
const OWN_MODULES: u64 = 4_000_000;

/// Bytes of strings that a [`Grower`] keeps: some twenty steps of a tree of 100,000 segments.
const KEPT_BYTES: u64 = 64 << 20;

/// A grown sketch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grown {
    /// The tree at full size, its root at the origin; `birth` counts growth steps.
    pub tree: Tree,
    /// What it wears.
    pub organs: Organs,
    /// Radius of each node one step earlier.
    pub radius_before: Vec<f32>,
    /// The string, cut to a bound.
    pub string: String,
    /// The step shown: segments with this birth are new.
    pub newest: u32,
    /// Modules of the whole string.
    pub modules: usize,
}

/// Grows a sketch to a step with the bounds of [`GROW`].
///
/// # Errors
/// Where the step is too far, the tree would be too large, or `cancel` was set meanwhile.
pub fn grow(sketch: &Sketch, step: u32, cancel: &AtomicBool) -> Result<Grown, SketchError> {
    Grower::once(GROW).grow(sketch, step, cancel)
}

/// Grows sketches one after the other, with strings kept: for a workshop where each one differs
/// little from the one before.
#[derive(Clone, Debug)]
pub struct Grower {
    /// The bounds.
    pub params: GrowParams,
    /// Bytes of strings that are kept.
    kept_bytes: u64,
    /// What grew last, and its strings.
    last: Option<Last>,
    predictor: Predictor,
}

/// A sketch whose grammar stands in a history.
#[derive(Clone, Debug)]
struct Last {
    sketch: Sketch,
    dictionary: Dictionary,
    history: History,
}

impl Last {
    fn new(sketch: &Sketch, kept_bytes: u64) -> Result<Self, SketchError> {
        Ok(Self {
            history: History::new(parsed(sketch)?, kept_bytes),
            dictionary: Dictionary::of(sketch),
            sketch: sketch.clone(),
        })
    }

    /// Brings it up to a sketch. Where only nodes moved, or it is another individual, the grammar is neither written nor read anew: its shapes or its seed
    /// are changed.
    fn follow(&mut self, sketch: &Sketch) -> Result<&mut History, SketchError> {
        if self.sketch.has_rules_of(sketch) {
            let changed = self.dictionary.follow(sketch).into_iter();
            let shapes = changed.filter_map(|place| self.dictionary.get(place));
            self.history
                .reshape(shapes.map(|(letter, shape)| (letter.to_string(), shape)));
        } else if self.sketch.with_seed(sketch.habit.seed) == *sketch {
            if !sketch.own_rules_state_a_seed() {
                let grammar = self.history.grammar().clone();
                self.history
                    .edit(grammar.with_seed(sketch.habit.seed.into()));
            }
        } else {
            self.history.edit(parsed(sketch)?);
            self.dictionary.follow(sketch);
        }
        self.sketch = sketch.clone();
        Ok(&mut self.history)
    }
}

/// The sketch's grammar, through its text.
fn parsed(sketch: &Sketch) -> Result<Grammar, SketchError> {
    Grammar::parse(&sketch.grammar_text(), "the sketch").map_err(refused)
}

impl Default for Grower {
    fn default() -> Self {
        Self::new(GROW)
    }
}

impl Grower {
    /// A grower with nothing kept yet.
    #[must_use]
    pub fn new(params: GrowParams) -> Self {
        Self {
            params,
            kept_bytes: KEPT_BYTES,
            last: None,
            predictor: Predictor::default(),
        }
    }

    /// A grower to whose strings nobody comes back.
    fn once(params: GrowParams) -> Self {
        Self {
            kept_bytes: 0,
            ..Self::new(params)
        }
    }

    /// A grower for one individual of a sketch after the other, each by a clone of it: the grammar is read once for all. No text of strings is made.
    ///
    /// # Errors
    /// What is wrong with the sketch's rules.
    pub fn of_individuals(sketch: &Sketch) -> Result<Self, SketchError> {
        let params = GrowParams {
            string_bytes: 0,
            ..GROW
        };
        Ok(Self {
            last: Some(Last::new(sketch, 0)?),
            ..Self::once(params)
        })
    }

    /// Grows a sketch to a step.
    ///
    /// # Errors
    /// As [`grow`]; what was kept stays.
    pub fn grow(
        &mut self,
        sketch: &Sketch,
        step: u32,
        cancel: &AtomicBool,
    ) -> Result<Grown, SketchError> {
        if step > BOUNDS.step {
            return Err(SketchError::StepTooFar {
                found: step,
                most: BOUNDS.step,
            });
        }
        let GrowParams {
            segments: most,
            string_bytes,
        } = self.params;
        let Some(segments) = self.predictor.within(sketch, step, most) else {
            return Err(SketchError::TooLarge { step, most });
        };
        if step == 0 || sketch.is_empty() {
            return Ok(root_alone(sketch, step));
        }
        let history = match &mut self.last {
            Some(last) => last.follow(sketch)?,
            none => &mut none.insert(Last::new(sketch, self.kept_bytes)?).history,
        };
        let limits = limits(sketch, segments);
        let string = history.at(step - 1, &limits, cancel).map_err(refused)?;
        let grammar = history.grammar();

        let turtle = TurtleParams::default();
        let mut tree = interpret(grammar, &string, &turtle, cancel).map_err(refused)?;
        for (birth, parent) in tree.birth.iter_mut().zip(&tree.parent) {
            *birth = if *parent == NO_PARENT {
                0
            } else {
                birth.saturating_add(1)
            };
        }
        // With rules of a person's own it is known only now.
        let grown = tree.parent.iter().filter(|parent| **parent != NO_PARENT);
        if grown.count() as u64 > most {
            return Err(SketchError::TooLarge { step, most });
        }
        let params = radius_params(sketch);
        let radius_before = match given_radii(sketch, &tree) {
            Some(given) => da_vinci_given(&mut tree, &params, step, &given),
            None => da_vinci(&mut tree, &params, step),
        };
        let mut organs = Organs::default();
        // Of the grammar, which a person may have written further lines of.
        grammar.dress_up(&tree, &mut organs);
        Ok(Grown {
            tree,
            organs,
            radius_before,
            string: string.to_text_within(grammar, string_bytes),
            newest: step,
            modules: string.len(),
        })
    }
}

fn refused(problem: impl std::fmt::Display) -> SketchError {
    SketchError::Grow(problem.to_string())
}

/// No more modules than the predicted segments can need.
fn limits(sketch: &Sketch, segments: u64) -> Limits {
    let modules_each = MODULES_PER_SEGMENT.saturating_add(sketch.strokes.len() as u64);
    let defaults = Limits::default();
    if !sketch.own_rules.is_empty() || sketch.habit.is_uncertain() {
        return Limits {
            modules: OWN_MODULES,
            ..defaults
        };
    }
    let modules = segments
        .saturating_add(1)
        .saturating_mul(modules_each)
        .min(defaults.modules);
    Limits {
        modules,
        ..defaults
    }
}

/// How thick nodes are whose letters have radii of their own, metres at full size, 0 for the others; none where no letter has any. A node has the radius of its
/// place in the line, counted in segments. A line that is longer than its stroke goes on as thick as that ends, and becomes thinner as it did.
fn given_radii(sketch: &Sketch, tree: &Tree) -> Option<Vec<f32>> {
    let thick = sketch.strokes.iter().filter(|one| !one.radii.is_empty());
    let known: HashMap<String, Profile<'_>> = thick
        .map(|one| (one.letter.to_string(), Profile::of(&one.radii)))
        .collect();
    if known.is_empty() {
        return None;
    }
    let of_letter: Vec<Option<&Profile<'_>>> =
        tree.letters.iter().map(|name| known.get(name)).collect();
    // Which segment of its line each node ends, from 0.
    let mut along = vec![0_usize; tree.len()];
    let mut given = vec![0.0; tree.len()];
    for node in 0..tree.len() {
        let parent = tree.parent[node];
        if parent == NO_PARENT {
            continue;
        }
        let below = parent as usize;
        let of = |node: usize| (tree.letter[node], tree.order[node]);
        if tree.parent[below] != NO_PARENT && of(below) == of(node) {
            along[node] = along[below] + 1;
        }
        let profile = of_letter.get(usize::from(tree.letter[node])).copied();
        if let Some(profile) = profile.flatten() {
            given[node] = sketch.scale * profile.at(along[node]);
        }
    }
    Some(given)
}

/// The radii of a stroke, and how they go on behind its end.
#[derive(Debug)]
struct Profile<'a> {
    radii: &'a [f32],
    /// By how much it becomes thinner from its first radius to its last, 1 at most.
    thinner: f32,
    /// No thinner than this: a tenth of its end.
    least: f32,
}

impl<'a> Profile<'a> {
    /// Of radii, at least one.
    fn of(radii: &'a [f32]) -> Self {
        let known = || radii.iter().copied().filter(|radius| *radius > 0.0);
        let first = known().next().unwrap_or(1.0);
        let last = known().next_back().unwrap_or(first);
        Self {
            radii,
            thinner: (last / first).min(1.0),
            least: (last * 0.1).max(BOUNDS.radius[0]),
        }
    }

    /// The radius behind so many segments of a line; 0 where it has none of its own.
    fn at(&self, segment: usize) -> f32 {
        let times = segment / self.radii.len();
        let radius = self.radii[segment % self.radii.len()];
        if radius == 0.0 || times == 0 {
            return radius;
        }
        let thinner = self.thinner.powi(i32::try_from(times).unwrap_or(i32::MAX));
        (radius * thinner).max(self.least.min(radius))
    }
}

fn radius_params(sketch: &Sketch) -> RadiusParams {
    RadiusParams {
        tip_radius: sketch.tip_radius,
        exponent: sketch.radius_exponent,
    }
}

fn root_alone(sketch: &Sketch, step: u32) -> Grown {
    let tree = Tree {
        parent: vec![NO_PARENT].into(),
        position: vec![glam::Vec3::ZERO].into(),
        radius: vec![sketch.tip_radius].into(),
        letter: vec![0].into(),
        order: vec![0].into(),
        birth: vec![0].into(),
        letters: vec![Letter::TRUNK.to_string()],
    };
    Grown {
        tree,
        organs: Organs::default(),
        radius_before: vec![sketch.tip_radius],
        string: String::new(),
        newest: step,
        modules: 0,
    }
}
