//! The habit of a sketch's tree: how it grows beyond what was drawn, and what it wears.
//!
//! A habit is written into the sketch's grammar and nowhere else: what grows is still one L-system that a person can read.
//!
//! | law | in the grammar |
//! |---|---|
//! | wander: shoots are not straight | each new segment keeps two angles, drawn once, and is interpreted as turns before it |
//! | spread: branches do not all leave alike | random parts of a branch's roll and pitch |
//! | light and gravity: shoots turn up, branches hang | `T` towards `tropism 0 1 0`, gravity counted once for each order |
//! | apical dominance: branches lag behind the trunk, or it behind them | a branch's (or the trunk's) growth has the weight 1 − dominance, its rest the other |
//! | shrinking: twigs have shorter segments than boughs | `@l(1 - shrink)` where a branch starts |
//! | starving: ends in the dark die | a query `?S` at each end is told the light there; below `starve` the end goes |

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
pub const LAWS: [(&str, [f64; 2]); 7] = [
    ("wander", [0.0, 45.0]),
    ("spread", [0.0, 90.0]),
    ("light", [0.0, 1.0]),
    ("gravity", [0.0, 1.0]),
    ("dominance", [-0.95, 0.95]),
    ("shrink", [0.0, 0.6]),
    ("starve", [0.0, 0.9]),
];

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
            _ => self.starve,
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
            _ => &mut self.starve,
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

    /// Whether growth can only be known by growing.
    #[must_use]
    pub fn is_uncertain(&self) -> bool {
        self.dominance != 0.0 || self.starve > 0.0
    }

    /// Whether another one has the same laws, so that the string is the same.
    #[must_use]
    pub fn grows_as(&self, other: &Self) -> bool {
        self.seed == other.seed && (0..LAWS.len()).all(|at| self.law(at) == other.law(at))
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
        self.bearings().map(|_| ())
    }

    /// The statements before the axiom.
    pub(super) fn push_laws(&self, text: &mut String, leafage: f64) {
        if self.is_lawless() {
            return;
        }
        text.push_str("# The habit: how the tree grows beyond what was drawn.\n");
        let _ = writeln!(text, "seed {}", self.seed);
        for (at, (name, _)) in LAWS.into_iter().enumerate() {
            if self.law(at) != 0.0 || (self.has_tropism() && matches!(name, "light" | "gravity")) {
                let _ = writeln!(text, "const {name} = {}", self.law(at).abs());
            }
        }
        if self.has_tropism() {
            text.push_str("tropism 0 1 0\n");
        }
        if self.starve > 0.0 {
            let _ = writeln!(text, "const leafage = {leafage:.4}");
        }
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

impl Sketch {
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
