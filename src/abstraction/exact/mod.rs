//! A tree as a compact L-system that draws it again, within a tolerance.
//!
//! ```text
//! Tree ─▶ shape (fewest nodes) ─▶ frames ─▶ classes (equal parts) ─▶ forms (families, runs) ─▶ plan ─▶ write ─▶ grammar
//!                  └─▶ level (how segments stand) ─▶ edges, nodes (one production) ─────────────────────────────▶ │
//!                       the smallest whose deviation is within the tolerance ◀─ check ◀─ Tree ◀─ derived, drawn ◀─┘
//! ```
//!
//! What is small is told by one number, modules and parameters of all productions and the axiom together, as Guo et al. 2020 ("Inverse
//! Procedural Modeling of Branching Structures by Inferring L-Systems") weigh rules by their length. How much of the tolerance goes into fewer nodes and how
//! much into parts that are alike, how alike parts must be, and how frames are rolled: all of a short list of settings are tried, and the
//! smallest grammar is kept whose tree, drawn by the engine itself, is near enough.

mod axiom;
mod chains;
mod check;
mod classes;
mod curve;
mod edges;
mod error;
mod forms;
mod frames;
mod level;
mod nodes;
mod number;
mod out;
mod pairs;
mod plan;
mod shape;
mod template;
mod write;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

pub use self::check::Deviation;
pub use self::curve::{Point, curve};
pub use self::error::ExactError;
pub use self::out::Size;

use self::chains::Chains;
use self::classes::{Alike, Classes};
use self::forms::{Form, Forms};
use self::frames::Rolled;
use self::level::Level;
use self::plan::{Plan, Planner, Room};
use self::shape::Shape;
use self::write::{Rule, Writer, part_of, plain};
use crate::lsystem::{Grammar, Limits, TurtleParams, interpret};
use crate::tree::Tree;

/// A grammar that draws a tree.
#[derive(Clone, Debug)]
pub struct Exact {
    /// In Ramus's language.
    pub grammar: String,
    /// What it draws, its first root at the origin.
    pub tree: Tree,
    /// Where the first root is in the tree that was given.
    pub origin: DVec3,
    /// As asked for.
    pub tolerance: f64,
    /// How far off it is.
    pub error: Deviation,
    /// How large it is.
    pub size: Size,
    /// How large the tree is with each of its segments written out.
    pub plain: Size,
    /// Segments of the tree that was given, and of the drawn one.
    pub segments: [usize; 2],
}

/// Parts of the tolerance: of nodes that are left out, of parts that productions draw, of numbers that are rounded.
const SHARES: [[f64; 3]; 5] = [
    [0.65, 0.3, 0.2],
    [0.2, 0.75, 0.2],
    [0.01, 0.94, 0.2],
    ALL,
    EVEN,
];
/// No node is left out, not even on straight lines: what a rule makes there is of equal parts only with all of them.
const ALL: [f64; 3] = [-1.0, 0.95, 0.2];
/// Its place among the shares.
const ALL_NODES: usize = 3;
/// What is written with so many digits that what is equal stays equal, for repeats in the axiom alone.
const EVEN: [f64; 3] = [0.01, 0.94, 0.003];
/// How alike parts are, radians.
const APART: [f64; 7] = [1e-5, 1e-4, 1e-3, 1e-2, 0.04, 0.12, 0.35];
/// The same where there are more nodes than the first number, and than the second.
const APART_OF_MANY: [f64; 2] = [1e-3, 0.12];
const APART_OF_MOST: [f64; 1] = [1e-3];
const MANY: [usize; 2] = [20_000, 300_000];
/// Rules that rewrite everything are looked for where no more than this is alike: what is hardly alike is not equal everywhere.
const RULES_APART: f64 = 0.04;
/// How many of the smallest grammars have their axioms shortened.
const SHORTENED: usize = 4;
/// Rounds in which productions that do not pay are given up.
const ROUNDS: usize = 3;
/// Modules and parameters of a segment that is written out, about.
const SEGMENT: u64 = 6;
/// Of the way from the root to the farthest node: single precision holds a quarter of this.
const FINEST: f64 = 1.0 / (1 << 22) as f64;

/// One of the ways to write a tree.
#[derive(Clone, Copy, Debug)]
struct Setting {
    share: usize,
    /// Whether what is repeated in the axiom becomes productions.
    shorten: bool,
    by: By,
}

/// What productions are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum By {
    /// There are none but those of the axiom's own repeats.
    Segments,
    /// Parts that are equal, with frames rolled so and numbers alike that are no farther apart.
    Parts(Rolled, f64),
    /// One production, which rewrites all segments or one module; numbers are alike that are no farther apart.
    Rewriting(f64),
}

/// Checks what is asked for; returns the tree's size, the diagonal of its box.
fn checked(tree: &Tree, tolerance: f64) -> Result<f64, ExactError> {
    tree.validate()?;
    let (Some((low, high)), Some(root)) = (tree.bounds(), tree.position.first()) else {
        return Err(ExactError::Empty);
    };
    if tree.segment_count() == 0 {
        return Err(ExactError::Empty);
    }
    let size = size(tree);
    if size == 0.0 {
        return Err(ExactError::Point);
    }
    if !(tolerance.is_finite() && tolerance > 0.0) {
        return Err(ExactError::Tolerance(tolerance));
    }
    if tolerance >= size {
        return Err(ExactError::Coarse { tolerance, size });
    }
    let root = root.as_dvec3();
    let far = (low.as_dvec3() - root)
        .abs()
        .max((high.as_dvec3() - root).abs());
    // A little more, in few digits.
    let least = far.length() * FINEST;
    let least = number::shortest(1.05 * least, 0.05 * least);
    if tolerance < least {
        return Err(ExactError::Fine { tolerance, least });
    }
    Ok(size)
}

/// A tree's size: the diagonal of the box that holds its nodes.
pub fn size(tree: &Tree) -> f64 {
    tree.bounds()
        .map_or(0.0, |(low, high)| low.as_dvec3().distance(high.as_dvec3()))
}

/// The smallest grammar that is found for a tree. `progress` gets what is tried of how much.
///
/// # Errors
/// What cannot be asked for, a tree without segments, or `cancel` being set.
pub fn exact(
    tree: &Tree,
    tolerance: f64,
    cancel: &AtomicBool,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Exact, ExactError> {
    checked(tree, tolerance)?;
    let shapes: Vec<Shape> = SHARES
        .par_iter()
        .map(|[nodes, ..]| Shape::new(tree, nodes * tolerance, nodes * tolerance))
        .collect();
    stop_if(cancel)?;
    let search = Search {
        shapes: &shapes,
        tolerance,
        cancel,
    };
    for setting in search.best(progress)? {
        let shape = &shapes[setting.share];
        let Some((grammar, order, size)) = search.written(setting)? else {
            continue;
        };
        let Some((drawn, error)) = drawn(tree, shape, &order, &grammar, cancel)? else {
            continue;
        };
        if error.max <= tolerance && error.radius <= tolerance {
            return Ok(Exact {
                plain: written_out(tree, tolerance, cancel)?,
                origin: tree.position[0].as_dvec3(),
                segments: [tree, &drawn].map(Tree::segment_count),
                tree: drawn,
                grammar,
                tolerance,
                error,
                size,
            });
        }
    }
    Err(ExactError::Unmet(tolerance))
}

/// All settings for a tree.
struct Search<'a> {
    shapes: &'a [Shape],
    tolerance: f64,
    cancel: &'a AtomicBool,
}

impl Search<'_> {
    fn written(&self, setting: Setting) -> Result<Option<Written>, ExactError> {
        Way::new(&self.shapes[setting.share], setting, self.tolerance).written(self.cancel)
    }

    /// The settings by how small their grammars are: of all, and of the smallest and those without classes once more with the axiom shortened.
    fn best(&self, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<Vec<Setting>, ExactError> {
        let all = settings(self.shapes);
        let done = AtomicUsize::new(0);
        let tried = |settings: Vec<Setting>| -> Result<Vec<(usize, Setting)>, ExactError> {
            let sizes = settings.into_par_iter().map(|setting| {
                let written = self.written(setting)?;
                progress(
                    done.fetch_add(1, Ordering::Relaxed) + 1,
                    all.len() + SHORTENED + SHARES.len(),
                );
                Ok(written.map(|(_, _, size)| (size.symbols(), setting)))
            });
            sizes.filter_map(Result::transpose).collect()
        };
        let mut found = tried(all.clone())?;
        // Among equals the earlier one is first: the order of trying is kept.
        found.sort_by_key(|(size, _)| *size);
        let again = found
            .iter()
            .enumerate()
            .filter_map(|(place, (_, setting))| {
                let is_tried = place < SHORTENED || setting.by == By::Segments;
                let may_be = !matches!(setting.by, By::Rewriting(_));
                (is_tried && may_be).then_some(Setting {
                    shorten: true,
                    ..*setting
                })
            });
        let again = tried(again.collect())?;
        found.extend(again);
        found.sort_by_key(|(size, _)| *size);
        Ok(found.into_iter().map(|(_, setting)| setting).collect())
    }
}

fn stop_if(cancel: &AtomicBool) -> Result<(), ExactError> {
    match cancel.load(Ordering::Relaxed) {
        true => Err(ExactError::Cancelled),
        false => Ok(()),
    }
}

/// What is tried, the simplest first.
fn settings(shapes: &[Shape]) -> Vec<Setting> {
    let mut settings = Vec::new();
    let fewer = shapes[ALL_NODES - 1].len();
    for (share, shape) in shapes.iter().enumerate() {
        // The first share leaves the fewest nodes, and with so many nothing else is worth its time.
        if share > 0 && shape.len() > MANY[1] {
            continue;
        }
        let mut add = |by: By| {
            settings.push(Setting {
                share,
                shorten: false,
                by,
            });
        };
        let apart: &[f64] = match MANY.map(|many| shape.len() > many) {
            [false, _] => &APART,
            [true, false] => &APART_OF_MANY,
            [_, true] => &APART_OF_MOST,
        };
        if share == ALL_NODES {
            let exact = apart.iter().filter(|apart| **apart <= RULES_APART);
            exact.for_each(|apart| add(By::Rewriting(*apart)));
            // Where few nodes lie on straight lines, this is as good as the share before.
            if shape.len() <= fewer + fewer / 8 || shape.len() > MANY[0] {
                continue;
            }
        } else {
            add(By::Segments);
        }
        if SHARES[share] == EVEN {
            continue;
        }
        for rolled in [Rolled::ByBranches, Rolled::Level] {
            apart
                .iter()
                .for_each(|apart| add(By::Parts(rolled, *apart)));
        }
    }
    settings
}

/// What the grammar draws, and how far that is off.
fn drawn(
    tree: &Tree,
    shape: &Shape,
    order: &[u32],
    text: &str,
    cancel: &AtomicBool,
) -> Result<Option<(Tree, Deviation)>, ExactError> {
    let grammar = Grammar::parse(text, "exact.lsys")?;
    let limits = Limits::default();
    let string = grammar.derive(grammar.steps().unwrap_or(0), &limits, cancel)?;
    let drawn = interpret(&grammar, &string, &TurtleParams::default(), cancel)?;
    let error = check::deviation(tree, shape, order, &drawn);
    Ok(error.map(|error| (drawn, error)))
}

/// The size of a tree with each of its segments written out, with numbers as exact.
fn written_out(tree: &Tree, tolerance: f64, cancel: &AtomicBool) -> Result<Size, ExactError> {
    let shape = Shape::new(tree, -1.0, -1.0);
    let setting = Setting {
        share: 0,
        shorten: false,
        by: By::Segments,
    };
    let way = Way::new(&shape, setting, tolerance);
    let plan = way.planner(None).plan(&|_| false, cancel)?;
    Ok(plain(&plan, false, false).1)
}

/// A grammar, the order in which it draws the shape's nodes, and its size.
type Written = (String, Vec<u32>, Size);

/// A way to write a shape.
struct Way<'a> {
    shape: &'a Shape,
    setting: Setting,
    room: Room,
    one_width: Option<f64>,
}

impl<'a> Way<'a> {
    fn new(shape: &'a Shape, setting: Setting, tolerance: f64) -> Self {
        let [_, part, rounding] = SHARES[setting.share];
        let room = Room {
            rounding: rounding * tolerance,
            part: part * tolerance,
            radius: part * tolerance,
            // The first segment's own radius may be off by the rest.
            root: 0.9 * (1.0 - part) * tolerance,
        };
        let all = || shape.radius.iter().copied();
        let (least, most) = (
            all().fold(f64::INFINITY, f64::min),
            all().fold(0.0, f64::max),
        );
        let is_one = most - least <= 2.0 * part * tolerance * 0.9;
        Self {
            shape,
            setting,
            room,
            one_width: is_one.then(|| number::thickness(most + least, part * tolerance * 0.1)),
        }
    }

    fn planner<'b>(&'b self, classes: Option<&'b Classes>) -> Planner<'b> {
        Planner {
            shape: self.shape,
            classes,
            room: self.room,
            one_width: self.one_width,
        }
    }

    /// None where it cannot be written so.
    fn written(&self, cancel: &AtomicBool) -> Result<Option<Written>, ExactError> {
        stop_if(cancel)?;
        match self.setting.by {
            By::Segments => {
                let plan = self.planner(None).plan(&|_| false, cancel)?;
                let (text, size) = plain(&plan, true, self.setting.shorten);
                Ok(Some((text, plan.drawn, size)))
            }
            By::Parts(rolled, apart) => self.in_parts(rolled, apart, cancel).map(Some),
            By::Rewriting(apart) => Ok(self.rewritten(apart, cancel)),
        }
    }

    /// By one production, of trees that are everywhere as thick: the smaller of both kinds.
    fn rewritten(&self, apart: f64, cancel: &AtomicBool) -> Option<Written> {
        let first = *self.shape.children(0).first()?;
        let off = self.shape.radius[first as usize] - self.shape.radius[0];
        // Else the root needs a thickness of its own.
        let width = self.one_width.filter(|_| off.abs() <= self.room.root)?;
        let level = Level::of(self.shape)?;
        let kinds = level.kinds(apart)?;
        let both =
            [edges::rewritten, nodes::rewritten].map(|by| by(&level, &kinds, width, apart, cancel));
        both.into_iter()
            .flatten()
            .min_by_key(|(_, _, size)| size.symbols())
    }

    /// With productions for parts that are equal.
    fn in_parts(
        &self,
        rolled: Rolled,
        apart: f64,
        cancel: &AtomicBool,
    ) -> Result<Written, ExactError> {
        let one_radius = self.one_width.is_some();
        let classes = Classes::new(
            self.shape,
            Alike {
                rolled,
                apart,
                one_radius,
            },
        );
        stop_if(cancel)?;
        let of = |fixed| Parts {
            classes: &classes,
            forms: Forms::new(&classes, fixed),
            chains: Chains::default(),
        };
        let level = self.written_with(&of(false), cancel)?;
        let fixed = of(true);
        if !fixed.forms.has_fixed() {
            return Ok(level);
        }
        let fixed = self.written_with(&fixed, cancel)?;
        let smaller = fixed.2.symbols() < level.2.symbols();
        Ok(if smaller { fixed } else { level })
    }

    /// The same with the forms that classes are written in.
    fn written_with(&self, parts: &Parts<'_>, cancel: &AtomicBool) -> Result<Written, ExactError> {
        let several = |class: &classes::Class| class.uses > 1 && class.height > 0;
        let mut pays = Pays {
            named: parts.classes.all.iter().map(several).collect(),
            families: vec![true; parts.forms.families.len()],
        };
        for round in 0.. {
            let plan = self.plan(parts, &pays, cancel)?;
            let given_up = self.given_up(&self.writer(parts, &pays.named), &plan);
            if round == ROUNDS || given_up.is_empty() {
                return self.with_wholes(parts, pays, plan, cancel);
            }
            for rule in given_up {
                match rule {
                    Rule::Plain(class) => pays.named[class as usize] = false,
                    Rule::Family(family) => pays.families[family as usize] = false,
                    Rule::Run(_) | Rule::Chain(_) => {}
                }
            }
        }
        Err(ExactError::Cancelled)
    }

    /// What a plan is written as, or where there are chains, whose last levels whole trees may be, what is smaller: that, or the same with productions for
    /// these, too, though they are there once.
    fn with_wholes(
        &self,
        parts: &Parts<'_>,
        mut pays: Pays,
        plan: Plan,
        cancel: &AtomicBool,
    ) -> Result<Written, ExactError> {
        let written = |pays: &Pays, plan: Plan| {
            let writer = self.writer(parts, &pays.named);
            let chains = writer.chained(&plan);
            let (text, size) = writer.write(&plan, &chains, self.setting.shorten);
            ((text, plan.drawn, size), !chains.all.is_empty())
        };
        let (one, has_chains) = written(&pays, plan);
        let roots = self.shape.roots();
        let wholes = roots.flat_map(|root| self.shape.children(root));
        let wholes = wholes.map(|whole| parts.classes.of[*whole as usize] as usize);
        let is_plain = |class: &usize| parts.forms.of.get(*class) == Some(&Form::Plain);
        let wholes: Vec<usize> = wholes.filter(is_plain).collect();
        if !has_chains || wholes.is_empty() {
            return Ok(one);
        }
        for whole in wholes {
            pays.named[whole] = true;
        }
        let plan = self.plan(parts, &pays, cancel)?;
        let (other, _) = written(&pays, plan);
        let is_smaller = other.2.symbols() < one.2.symbols();
        Ok(if is_smaller { other } else { one })
    }

    /// Which parts are left to productions.
    fn plan(
        &self,
        parts: &Parts<'_>,
        pays: &Pays,
        cancel: &AtomicBool,
    ) -> Result<Plan, ExactError> {
        let has = |class: u32| match parts.forms.of[class as usize] {
            Form::Leaf => false,
            Form::Plain => pays.named[class as usize],
            Form::Level { family, .. } => pays.families[family as usize],
            Form::Run { .. } => true,
        };
        self.planner(Some(parts.classes)).plan(&has, cancel)
    }

    fn writer<'b>(&self, parts: &'b Parts<'_>, named: &'b [bool]) -> Writer<'b> {
        Writer {
            classes: parts.classes,
            forms: &parts.forms,
            named,
            chains: &parts.chains,
            next: None,
            one_radius: self.one_width.is_some(),
        }
    }

    /// Which rules take more than they save.
    fn given_up(&self, writer: &Writer<'_>, plan: &Plan) -> Vec<Rule> {
        let parts: Vec<u32> = plan.words.iter().filter_map(part_of).collect();
        let needed = writer.needed(&parts);
        let costs = writer.costs();
        let call = writer.call_cost();
        let mut written: hashbrown::HashMap<Rule, (u64, u64)> = hashbrown::HashMap::new();
        for (word, segments) in plan.words.iter().zip(sizes(self.shape, plan)) {
            if let Some((rule, _)) = part_of(word).and_then(|class| writer.rule(class)) {
                let entry = written.entry(rule).or_default();
                entry.0 += 1;
                entry.1 = entry.1.saturating_add(segments.saturating_mul(SEGMENT));
            }
        }
        let mut given_up = Vec::new();
        for rule in needed.rules {
            let calls = needed.calls.get(&rule).copied().unwrap_or(0);
            let pays = match rule {
                Rule::Plain(class) => {
                    let body = costs[class as usize];
                    calls.saturating_mul(body) > calls * call + body + call
                }
                Rule::Family(family) => {
                    let (own, instead) = written.get(&rule).copied().unwrap_or_default();
                    let body = costs[writer.forms.families[family as usize].top as usize];
                    // What other rules call stays.
                    own < calls || instead > own * (call + 1) + body + call + 2
                }
                Rule::Run(_) | Rule::Chain(_) => true,
            };
            given_up.extend((!pays).then_some(rule));
        }
        given_up
    }
}

/// Equal parts, and the forms that they are written in.
struct Parts<'a> {
    classes: &'a Classes,
    forms: Forms,
    /// None: a writer finds its own.
    chains: Chains,
}

/// What has productions.
struct Pays {
    /// Classes that are written plainly.
    named: Vec<bool>,
    families: Vec<bool>,
}

/// Segments that each word of a plan draws.
fn sizes<'a>(shape: &'a Shape, plan: &'a Plan) -> impl Iterator<Item = u64> + 'a {
    let mut at = 1;
    plan.words.iter().map(move |word| match word {
        plan::Word::Segment { .. } | plan::Word::Move { .. } => {
            at += 1;
            1
        }
        plan::Word::Part { .. } => {
            let first = plan.drawn.get(at).copied().unwrap_or(0);
            let end = shape.end.get(first as usize).copied().unwrap_or(first);
            let segments = end.saturating_sub(first);
            at += segments as usize;
            u64::from(segments)
        }
        _ => 0,
    })
}

#[cfg(test)]
mod tests;
