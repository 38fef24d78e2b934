//! The habit of a sketch's tree: how it grows beyond what was drawn, and what it wears.
//!
//! A habit is written into the sketch's grammar and nowhere else: what grows is still one L-system that a person can read.
//!
//! | law | in the grammar |
//! |---|---|
//! | wander: shoots are not straight | each new segment keeps two angles, drawn once, and is interpreted as turns before it |
//! | spread: branches do not all leave alike | random parts of a branch's roll and pitch |
//! | light and gravity: shoots turn up, branches hang | `T` towards `tropism 0 1 0`, gravity counted once for each order |
//! | ground: boughs that hang come to lie on it, where nothing was drawn below it | `ground 0` |
//! | apical dominance: branches lag behind the trunk, or it behind them | a branch's (or the trunk's) growth has the weight 1 − dominance, its rest the other |
//! | shrinking: twigs have shorter segments than boughs | `@l(1 - shrink)` where a branch starts |
//! | starving: ends in the dark die | a query `?S` at each end is told the light there; below `starve` the end goes |
//! | length: lines end, branches by where they stand on their parent | each letter has its line's segments as parameter; an end moves on below it |
//! | crowding: ends near other wood die | a query `?C` at each end is told how far that is; within `room` the end goes |
//!
//! **Length.** A trunk is determinate: it has `length` segments. The longest branch of a line has `reach` times as many as the line; the one at the part t of it
//! has (t / peak)^(peak / (1 - peak)) (1 - t) / (1 - peak) of these, which is 1 at t = peak. From the base up (peak 0, basitony) that is the straight cone of
//! a conifer, about the middle a parabola as a frond has, towards the tip (acrotony) a vase. (Crowns by the shape of their branches' lengths are Weber and Penn's 1995,
//! "Creation and rendering of realistic trees"; theirs is a choice of eight shapes, this one a number from one to the other.)

use std::fmt::Write as _;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::change::within;
use super::{Sketch, SketchError};
use crate::lsystem::bearing;
use crate::tree::bark::Bark;
use crate::tree::foliage::{Bearing, Dress, Season, USUAL_FLARE};

/// Kinds of leaves, blossoms and fruit of one tree.
pub const MOST_BEARS: usize = 16;
/// Longest line of one, bytes.
const LINE_BYTES: usize = 400;

/// See the module. The default grows and looks as a sketch without any.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Habit {
    /// Which individual.
    pub seed: u32,
    /// Standard deviation of each segment's two bends, degrees.
    pub wander_deg: f64,
    /// Standard deviation of a branch's roll and pitch where it starts, degrees.
    pub spread_deg: f64,
    /// Radians that a segment at right angles to it turns towards the light above.
    pub light: f64,
    /// Radians that a branch turns down, once for each order.
    pub gravity: f64,
    /// Chance that a branch's end rests in a step, 0 to 0.95; below 0 it is the trunk's that rests.
    pub dominance: f64,
    /// By what part a branch's segments are shorter than those that it grows from.
    pub shrink: f64,
    /// Part of the sky's light below which an end dies; 0: none does.
    pub starve: f64,
    /// Segments of a line, of the trunk above all; 0: lines have no end.
    #[serde(skip_serializing_if = "is_zero")]
    pub length: f64,
    /// Segments of a line's longest branch, as part of the line's; 0: as many as any line. Without `length` it says nothing.
    #[serde(skip_serializing_if = "is_zero")]
    pub reach: f64,
    /// Where along a line its longest branches stand, 0 at its base to 0.9 near its tip. Without `reach` it says nothing.
    #[serde(skip_serializing_if = "is_zero")]
    pub peak: f64,
    /// How near to other wood an end dies, in usual segments at full size; 0: none does.
    #[serde(skip_serializing_if = "is_zero")]
    pub crowd: f64,
    /// What covers trunk and branches; none: as Ramus draws all trees.
    pub bark: Option<Bark>,
    /// How much thicker the trunk is at the ground.
    pub flare: f32,
    /// The time of the year.
    pub season: Season,
    /// What twigs bear, each as a grammar says it behind `bears`.
    pub bears: Vec<String>,
}

/// Numbers of a habit: their names, and their bounds.
pub const LAWS: [(&str, [f64; 2]); 11] = [
    ("wander", [0.0, 45.0]),
    ("spread", [0.0, 90.0]),
    ("light", [0.0, 1.0]),
    ("gravity", [0.0, 1.0]),
    ("dominance", [-0.95, 0.95]),
    ("shrink", [0.0, 0.6]),
    ("starve", [0.0, 0.9]),
    ("length", [0.0, 100.0]),
    ("reach", [0.0, 2.0]),
    ("peak", [0.0, 0.9]),
    ("crowd", [0.0, 2.0]),
];

/// The first of [`LAWS`] that came with format 6 of projects.
const LATER: usize = 7;

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde calls it with a reference"
)]
fn is_zero(law: &f64) -> bool {
    *law == 0.0
}

impl Default for Habit {
    fn default() -> Self {
        Self {
            seed: 0,
            wander_deg: 0.0,
            spread_deg: 0.0,
            light: 0.0,
            gravity: 0.0,
            dominance: 0.0,
            shrink: 0.0,
            starve: 0.0,
            length: 0.0,
            reach: 0.0,
            peak: 0.0,
            crowd: 0.0,
            bark: None,
            flare: USUAL_FLARE,
            season: Season::default(),
            bears: Vec::new(),
        }
    }
}

impl Habit {
    /// A law by its place in [`LAWS`].
    #[must_use]
    pub fn law(&self, at: usize) -> f64 {
        match at {
            0 => self.wander_deg,
            1 => self.spread_deg,
            2 => self.light,
            3 => self.gravity,
            4 => self.dominance,
            5 => self.shrink,
            6 => self.starve,
            7 => self.length,
            8 => self.reach,
            9 => self.peak,
            _ => self.crowd,
        }
    }

    /// Sets one.
    pub fn set_law(&mut self, at: usize, value: f64) {
        let law = match at {
            0 => &mut self.wander_deg,
            1 => &mut self.spread_deg,
            2 => &mut self.light,
            3 => &mut self.gravity,
            4 => &mut self.dominance,
            5 => &mut self.shrink,
            6 => &mut self.starve,
            7 => &mut self.length,
            8 => &mut self.reach,
            9 => &mut self.peak,
            _ => &mut self.crowd,
        };
        *law = value;
    }

    /// Every number on the grid of 0.001: what is kept.
    #[must_use]
    pub fn quantized(&self) -> Self {
        let mut next = self.clone();
        for at in 0..LAWS.len() {
            next.set_law(at, (self.law(at) * 1000.0).round() / 1000.0);
        }
        next.flare = (self.flare * 1000.0).round() / 1000.0;
        next
    }

    /// Whether the string is that of a sketch without any habit.
    #[must_use]
    pub fn is_lawless(&self) -> bool {
        (0..LAWS.len()).all(|at| self.law(at) == 0.0)
    }

    /// Whether a law draws by the seed, so that individuals differ.
    #[must_use]
    pub fn has_chance(&self) -> bool {
        self.wander_deg > 0.0 || self.spread_deg > 0.0 || self.dominance != 0.0
    }

    /// Whether a law is set that programs before format 6 of projects do not know.
    #[must_use]
    pub fn has_later_laws(&self) -> bool {
        (LATER..LAWS.len()).any(|at| self.law(at) != 0.0)
    }

    /// Whether growth can only be known by growing.
    #[must_use]
    pub fn is_uncertain(&self) -> bool {
        self.dominance != 0.0 || self.starve > 0.0 || self.crowd > 0.0 || self.has_length()
    }

    pub(super) fn has_length(&self) -> bool {
        self.length > 0.0
    }

    pub(super) fn has_bends(&self) -> bool {
        self.wander_deg > 0.0
    }

    pub(super) fn has_tropism(&self) -> bool {
        self.light > 0.0 || self.gravity > 0.0
    }

    /// What its tree wears.
    ///
    /// # Errors
    /// A line that is no bearing: the grammar's message.
    pub fn dress(&self) -> Result<Dress, SketchError> {
        Ok(Dress {
            bark: self.bark.unwrap_or_default(),
            flare: self.bark.map_or(0.0, |_| self.flare),
            season: self.season,
            bears: self.bearings()?,
        })
    }

    /// What it bears, read.
    ///
    /// # Errors
    /// As [`Self::dress`].
    pub fn bearings(&self) -> Result<Vec<Bearing>, SketchError> {
        let read =
            |line: &String| bearing(line).map_err(|error| SketchError::Rule(error.to_string()));
        self.bears.iter().map(read).collect()
    }

    /// Checks that all numbers lie within their bounds and all lines can be read.
    ///
    /// # Errors
    /// The first that does not.
    pub fn validate(&self) -> Result<(), SketchError> {
        for (at, (name, [least, most])) in LAWS.into_iter().enumerate() {
            within(name, self.law(at), [least, most])?;
        }
        within("flare", f64::from(self.flare), [0.0, 4.0])?;
        if self.bears.len() > MOST_BEARS || self.bears.iter().any(|line| line.len() > LINE_BYTES) {
            return Err(SketchError::TooMany {
                what: "kinds of leaves, blossoms and fruit",
                most: MOST_BEARS,
            });
        }
        if let Some(line) = self
            .bears
            .iter()
            .find(|line| line.contains(char::is_control))
        {
            let line = line.escape_debug();
            return Err(SketchError::Rule(format!(
                "`bears {line}` must be one line without tabs"
            )));
        }
        self.bearings().map(|_| ())
    }

    /// The statements before the axiom. `usual` is the length of a usual segment at full size, metres; `seeded`: the seed is among them;
    /// `above`: nothing is drawn below the ground.
    pub(super) fn push_laws(&self, text: &mut String, usual: f64, seeded: bool, above: bool) {
        if self.is_lawless() {
            return;
        }
        text.push_str("# The habit: how the tree grows beyond what was drawn.\n");
        if seeded {
            let _ = writeln!(text, "seed {}", self.seed);
        }
        for (at, (name, _)) in LAWS.into_iter().enumerate() {
            let is_said = match name {
                "light" | "gravity" => self.has_tropism(),
                "reach" => self.has_length() && self.reach > 0.0,
                "peak" => self.has_length() && self.reach > 0.0 && self.peak > 0.0,
                // In metres, as `room`.
                "crowd" => false,
                _ => self.law(at) != 0.0,
            };
            if is_said {
                let _ = writeln!(text, "const {name} = {}", self.law(at).abs());
            }
        }
        if self.has_tropism() {
            text.push_str("tropism 0 1 0\n");
            if above {
                text.push_str("ground 0\n");
            }
        }
        if self.starve > 0.0 {
            let _ = writeln!(text, "const leafage = {:.4}", leafage(usual));
        }
        if self.crowd > 0.0 {
            let _ = writeln!(text, "const room = {:.4}", (self.crowd * usual).max(1e-4));
        }
    }

    /// What stands at a growing end: the end, and what it asks for.
    pub(super) fn end(&self) -> &'static str {
        match (self.starve > 0.0, self.crowd > 0.0) {
            (false, false) => "B",
            (true, false) => "B ?S(1, leafage)",
            (false, true) => "B ?C(room, room)",
            (true, true) => "B ?S(1, leafage) ?C(room, room)",
        }
    }

    /// The condition by which a line's letter knows that it stands near other wood, with the context in which it reads that; none where it does not ask.
    pub(super) fn crowded_context(&self) -> Option<&'static str> {
        let asks_light = self.starve > 0.0;
        (self.crowd > 0.0).then_some(if asks_light {
            "B ?S(l, a) ?C(c, r) : c < r"
        } else {
            "B ?C(c, r) : c < r"
        })
    }

    /// How many segments a branch has behind segment x of a line that has n.
    pub(super) fn branch_length(&self) -> &'static str {
        match (self.reach > 0.0, self.peak > 0.0) {
            (false, _) => "length",
            (true, false) => "reach * (n-x-1)",
            (true, true) => {
                "reach * (n-x-1) / (1 - peak) * ((x+1) / (n * peak))^(peak / (1 - peak))"
            }
        }
    }

    /// The rules by which ends go.
    pub(super) fn push_ends(&self, text: &mut String) {
        let (starves, is_crowded) = (self.starve > 0.0, self.crowd > 0.0);
        if starves {
            text.push_str("\n# Starving: an end that is told of too little light goes.\n");
            text.push_str("B > ?S(l, a) : l < starve -> *\n?S(l, a) : l < starve -> *\n");
        }
        if is_crowded {
            text.push_str(
                "\n# Crowding: an end that is told of other wood within its room goes.\n",
            );
        }
        text.push_str(match (starves, is_crowded) {
            (_, false) => "",
            (false, true) => "B > ?C(c, r) : c < r -> *\n?C(c, r) : c < r -> *\n",
            (true, true) => {
                "B > ?S(l, a) ?C(c, r) : c < r -> *\n?S(l, a) > ?C(c, r) : c < r -> *\n?S(l, a) < ?C(c, r) : l < starve || c < r -> *\n"
            }
        });
    }

    /// The statements about looks.
    pub(super) fn push_dress(&self, text: &mut String) {
        if let Some(bark) = self.bark {
            let _ = writeln!(text, "bark {} flare {}", bark.name(), self.flare);
        }
        if !self.bears.is_empty() {
            let _ = writeln!(text, "season {}", self.season.name());
        }
        for line in &self.bears {
            let _ = writeln!(text, "bears {line}");
        }
    }
}

/// Square metres of leaves that an end is counted for: a quarter of its usual segment's square.
pub(super) fn leafage(usual: f64) -> f64 {
    (0.25 * usual * usual).max(1e-4)
}

impl Sketch {
    /// The same sketch at another time of the year.
    #[must_use]
    pub fn in_season(&self, season: Season) -> Self {
        let habit = Habit {
            season,
            ..Habit::clone(&self.habit)
        };
        Self {
            habit: Arc::new(habit),
            ..self.clone()
        }
    }

    /// The same sketch as another individual.
    #[must_use]
    pub fn with_seed(&self, seed: u32) -> Self {
        let habit = Habit {
            seed,
            ..Habit::clone(&self.habit)
        };
        Self {
            habit: Arc::new(habit),
            ..self.clone()
        }
    }
}

#[cfg(test)]
#[path = "habit_tests.rs"]
mod length_and_crowding;

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use std::sync::atomic::AtomicBool;

    use glam::Vec3;

    use super::*;
    use crate::sketch::{Grown, NodeRef, SelfSimilar, grow};
    use crate::tree::{NO_PARENT, Tree};

    /// A trunk of four segments with a branch at its second node that carries copies.
    fn sketch() -> Sketch {
        let up: Vec<Vec3> = (1..=4).map(|k| Vec3::Y * 0.3 * k as f32).collect();
        let (sketch, _) = Sketch::default().add_segments(NodeRef::ROOT, &up).unwrap();
        let at = NodeRef::new(super::super::Letter::TRUNK, 2);
        let out = [Vec3::new(0.3, 0.75, 0.0), Vec3::new(0.6, 0.85, 0.05)];
        let (sketch, apex) = sketch.add_segments(at, &out).unwrap();
        let copies = SelfSimilar {
            rate: 1,
            depth_limit: Some(2),
        };
        sketch.with_self_similar(apex.letter, Some(copies)).unwrap()
    }

    fn grown(change: impl Fn(&mut Habit)) -> (Sketch, Grown) {
        let mut habit = Habit::default();
        change(&mut habit);
        let sketch = sketch().with_habit(habit).unwrap();
        let tree = grow(&sketch, 12, &AtomicBool::new(false)).unwrap();
        (sketch, tree)
    }

    /// Mean height gained along each metre of branches.
    fn rise(tree: &Tree) -> f32 {
        let (mut up, mut length) = (0.0, 0.0);
        for (node, &parent) in tree.parent.iter().enumerate() {
            if parent != NO_PARENT && tree.order[node] > 0 {
                let way = tree.position[node] - tree.position[parent as usize];
                (up, length) = (up + way.y, length + way.length());
            }
        }
        up / length
    }

    #[test]
    fn without_laws_nothing_is_said_and_nothing_changes() {
        let plain = sketch();
        let (same, _) = grown(|_| ());
        assert_eq!(plain.grammar_text(), same.grammar_text());
        for word in ["seed", "T(", "normal", "?S", "bark", "bears", "widths"] {
            assert!(!plain.grammar_text().contains(word), "{word}");
        }
    }

    #[test]
    fn each_law_stands_in_the_grammar_and_does_what_it_says() {
        let (_, plain) = grown(|_| ());
        let segments = plain.tree.segment_count();
        let of_order = |tree: &Tree, trunk: bool| {
            tree.order
                .iter()
                .filter(|order| (**order == 0) == trunk)
                .count()
        };

        let (sketch, bent) = grown(|habit| habit.wander_deg = 8.0);
        assert!(sketch.grammar_text().contains("interpret {"));
        assert_eq!(bent.tree.parent, plain.tree.parent, "the same tree, bent");
        assert_ne!(bent.tree.position, plain.tree.position);

        let (sketch, spread) = grown(|habit| habit.spread_deg = 20.0);
        assert!(sketch.grammar_text().contains("normal(0, spread)"));
        assert_eq!(spread.tree.segment_count(), segments);

        let (sketch, lit) = grown(|habit| habit.light = 0.3);
        assert!(sketch.grammar_text().contains("T(light"));
        let (_, hung) = grown(|habit| habit.gravity = 0.3);
        let rises = [&hung.tree, &plain.tree, &lit.tree].map(rise);
        assert!(
            rises[0] < rises[1] - 0.2 && rises[1] + 0.2 < rises[2],
            "{rises:?}"
        );

        let (sketch, slow) = grown(|habit| habit.dominance = 0.5);
        assert!(sketch.grammar_text().contains("weight dominance"));
        assert_eq!(of_order(&slow.tree, true), of_order(&plain.tree, true));
        assert!(of_order(&slow.tree, false) * 2 < of_order(&plain.tree, false));
        let (_, low) = grown(|habit| habit.dominance = -0.5);
        assert!(of_order(&low.tree, true) < of_order(&plain.tree, true));

        let (sketch, fine) = grown(|habit| habit.shrink = 0.4);
        assert!(sketch.grammar_text().contains("@l(1 - shrink)"));
        let longest = |tree: &Tree, order: u16| {
            let of = tree
                .parent
                .iter()
                .enumerate()
                .filter(|(node, parent)| **parent != NO_PARENT && tree.order[*node] == order);
            of.map(|(node, parent)| tree.position[node].distance(tree.position[*parent as usize]))
                .fold(0.0, f32::max)
        };
        for order in 0..3 {
            let ratio = longest(&fine.tree, order) / longest(&plain.tree, order);
            assert!(
                (ratio - 0.6_f32.powi(order.into())).abs() < 1e-3,
                "order {order}: {ratio}"
            );
        }

        let (sketch, starved) = grown(|habit| habit.starve = 0.9);
        assert!(sketch.grammar_text().contains("l < starve -> *"));
        assert!(
            starved.tree.segment_count() < segments * 9 / 10,
            "{} of {segments}",
            starved.tree.segment_count()
        );
    }

    /// A workshop's grower, which keeps strings, gives what growing anew gives: after a node moved, and after another dress.
    #[test]
    fn what_is_kept_is_not_older_than_the_sketch() {
        let never = AtomicBool::new(false);
        let habit = Habit {
            wander_deg: 4.0,
            starve: 0.8,
            bears: vec!["oak".to_owned()],
            ..Habit::default()
        };
        let mut sketch = sketch().with_habit(habit).unwrap();
        let mut grower = crate::sketch::Grower::default();
        let at = NodeRef::new(super::super::Letter::TRUNK, 4);
        for k in 0..3_u8 {
            let to = Vec3::new(0.1, 1.2 + 0.6 * f32::from(k), 0.0);
            sketch = sketch.move_node(at, to).unwrap();
            let kept = grower.grow(&sketch, 10, &never).unwrap();
            assert_eq!(kept, grow(&sketch, 10, &never).unwrap(), "moved {k}");
            sketch = sketch.in_season(Season::ALL[usize::from(k)]);
            let kept = grower.grow(&sketch, 10, &never).unwrap();
            assert_eq!(kept, grow(&sketch, 10, &never).unwrap(), "season {k}");
        }
        // Further lines of a person's own are worn, too.
        let own = sketch.with_rule("", Some("bears spines size 0.3")).unwrap();
        let with = grower.grow(&own, 10, &never).unwrap();
        let without = grower.grow(&sketch, 10, &never).unwrap();
        assert!(with.organs.placed.len() > without.organs.placed.len());
    }

    /// Letters of more than one sign are declared with their parameters; laws fit them, too.
    #[test]
    fn sketches_of_many_strokes_have_laws_too() {
        let mut sketch = sketch();
        for number in 0..30_u8 {
            let at = NodeRef::new(super::super::Letter::TRUNK, 1 + u32::from(number % 3));
            let out = Vec3::new(0.2, 0.4 + 0.02 * f32::from(number), 0.01);
            sketch = sketch.add_segments(at, &[out]).unwrap().0;
        }
        assert!(sketch.grammar_text().contains("module C1(x"));
        let plain = grow(&sketch, 6, &AtomicBool::new(false)).unwrap();
        let laws = Habit {
            wander_deg: 5.0,
            spread_deg: 5.0,
            light: 0.1,
            shrink: 0.1,
            ..Habit::default()
        };
        let bent = grow(
            &sketch.with_habit(laws).unwrap(),
            6,
            &AtomicBool::new(false),
        )
        .unwrap();
        assert_eq!(bent.tree.parent, plain.tree.parent);
        assert_ne!(bent.tree.position, plain.tree.position);
    }

    #[test]
    fn a_seed_is_one_tree_and_growth_goes_on_from_what_was_there() {
        let wild = |habit: &mut Habit| {
            (
                habit.wander_deg,
                habit.spread_deg,
                habit.dominance,
                habit.starve,
            ) = (8.0, 10.0, 0.3, 0.05);
        };
        let (sketch, tree) = grown(wild);
        assert_eq!(tree, grown(wild).1);
        let other = grow(&sketch.with_seed(5), 12, &AtomicBool::new(false)).unwrap();
        assert_ne!(other.tree, tree.tree);
        // What stands at one step stands at the next one in the same place.
        let next = grow(&sketch, 13, &AtomicBool::new(false)).unwrap();
        let places: std::collections::HashSet<[u32; 3]> = next
            .tree
            .position
            .iter()
            .map(|p| p.to_array().map(f32::to_bits))
            .collect();
        let kept = tree
            .tree
            .position
            .iter()
            .filter(|p| places.contains(&p.to_array().map(f32::to_bits)));
        assert_eq!(kept.count(), tree.tree.len());
    }

    #[test]
    fn what_it_wears_is_on_the_tree_and_in_the_grammar() {
        let (sketch, tree) = grown(|habit| {
            habit.bark = Some(Bark::Birch);
            habit.bears = vec![
                "birch size 0.07 order 1".to_owned(),
                "blossom in summer".to_owned(),
            ];
        });
        let text = sketch.grammar_text();
        for line in [
            "widths da-vinci tip 0.02 exponent 2",
            "bark birch flare 0.5",
            "season summer",
            "bears birch size 0.07 order 1",
            "bears blossom in summer",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}: {text}");
        }
        assert_eq!(tree.organs.bark, Bark::Birch);
        assert!(tree.organs.placed.len() > 100 && tree.organs.surfaces.len() == 2);
        let derived = crate::lsystem::Grammar::parse(&text, "sketch").unwrap();
        assert_eq!(*derived.dress(), sketch.habit.dress().unwrap());
    }

    #[test]
    fn what_cannot_be_is_refused_in_a_sentence() {
        let refused = |change: &dyn Fn(&mut Habit)| {
            let mut habit = Habit::default();
            change(&mut habit);
            sketch().with_habit(habit).unwrap_err().to_string()
        };
        assert!(refused(&|habit| habit.light = 2.0).contains("light"));
        assert!(refused(&|habit| habit.starve = f64::NAN).contains("starve"));
        assert!(refused(&|habit| habit.bears = vec!["mapple".to_owned()]).contains("maple"));
        assert!(refused(&|habit| habit.bears = vec!["maple size 0".to_owned()]).contains("size"));
        assert!(refused(&|habit| habit.bears = vec!["oak\naxiom F".to_owned()]).contains("bears"));
        assert!(refused(&|habit| habit.bears = vec!["oak".to_owned(); 17]).contains("at most"));
        // A rule of a person's own that knows no bends stays readable or is told of.
        let own = sketch()
            .with_rule("A > B", Some("A(x) > B : x < 9 -> A(x) A(x+1)"))
            .unwrap();
        let bends = Habit {
            wander_deg: 5.0,
            ..Habit::default()
        };
        assert!(
            own.with_habit(bends)
                .unwrap_err()
                .to_string()
                .contains("`A`")
        );
    }
}
