//! What `ramus derive` prints: the object of `--json` and the table of `--print counts`.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use glam::Vec3;
use serde::Serialize;
use thiserror::Error;

use super::error::DeriveError;
use super::grammar::{Grammar, Role};
use super::number::write_general;
use super::string::{Module, ModuleString};
use super::turtle::{Extent, TurtleParams, stream_on};
use crate::tree::{NO_PARENT, Tree};

/// Smallest box round all nodes, metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bounds {
    /// Least x, y, z.
    pub min: [f32; 3],
    /// Greatest x, y, z.
    pub max: [f32; 3],
}

/// Format `ramus-derive/1`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// `ramus-derive/1`.
    pub format: &'static str,
    /// Steps derived.
    pub steps: u32,
    /// The time in steps that is drawn, where the last step is partly grown: its modules are counted whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Modules, brackets included.
    pub modules: u64,
    /// Modules of each name.
    pub counts: BTreeMap<String, u64>,
    /// Deepest bracket.
    pub max_depth: u64,
    /// FNV-1a of the symbol names alone, 16 hexadecimal digits.
    pub fnv1a64: String,
    /// Sum of each parameter over all modules of a name: `F.0` is the first of all `F`. Infinite where the sum is
    /// beyond the range of f64, which text shows (`inf`) and JSON refuses.
    pub param_sums: BTreeMap<String, f64>,
    /// Segments drawn.
    pub segments: u64,
    /// Box round what was drawn.
    pub bounds: Bounds,
    /// Milliseconds that the derivation took.
    pub derive_ms: f64,
    /// Milliseconds that the drawing took.
    pub turtle_ms: f64,
}

/// Why a report cannot be written as JSON.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A sum that no number of JSON's readers holds: `null` would say that there is none.
    #[error(
        "the sum of `{0}`, a parameter of all modules of its name, is beyond 1.8e308, the largest number of JSON's readers; make the parameter smaller, or print the string (--print string)"
    )]
    Overflow(String),
    /// Serialisation is fallible by type only.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

/// A sum that keeps what rounding loses (Neumaier 1974).
#[derive(Clone, Copy, Default)]
struct Neumaier {
    sum: f64,
    lost: f64,
}

impl Neumaier {
    fn add(&mut self, value: f64) {
        let sum = self.sum + value;
        self.lost += if self.sum.abs() >= value.abs() {
            (self.sum - sum) + value
        } else {
            (value - sum) + self.sum
        };
        self.sum = sum;
    }
}

/// Values from here on are summed scaled down, so that no order of them overflows on the way: 2^960, and 2^-64 (a string
/// has fewer than 2^32 modules). Scaling by a power of two changes no digit.
const HUGE: f64 = f64::from_bits((1023 + 960) << 52);
const SCALE: f64 = f64::from_bits((1023 - 64) << 52);

/// A sum that overflows only where its result does.
#[derive(Clone, Copy, Default)]
pub(super) struct Sum {
    plain: Neumaier,
    huge: Neumaier,
}

impl Sum {
    fn add(&mut self, value: f64) {
        if value.abs() < HUGE {
            self.plain.add(value);
        } else {
            self.huge.add(value * SCALE);
        }
    }

    /// Adds a value so many times.
    pub(super) fn add_times(&mut self, value: f64, times: u128) {
        #[allow(clippy::cast_precision_loss, reason = "rounded as every product is")]
        let times = times as f64;
        let product = value * times;
        if product.abs() < HUGE {
            self.plain.add(product);
            self.plain.add(value.mul_add(times, -product));
        } else {
            self.huge.add(value * SCALE * times);
        }
    }

    fn merge(&mut self, other: Self) {
        for value in [other.plain.sum, other.plain.lost] {
            self.plain.add(value);
        }
        for value in [other.huge.sum, other.huge.lost] {
            self.huge.add(value);
        }
    }

    fn total(mut self) -> f64 {
        if self.huge.sum == 0.0 && self.huge.lost == 0.0 {
            return self.plain.sum + self.plain.lost;
        }
        self.huge.add(self.plain.sum * SCALE);
        self.huge.add(self.plain.lost * SCALE);
        (self.huge.sum + self.huge.lost) / SCALE
    }
}

/// FNV-1a, 64 bits.
#[derive(Clone, Copy)]
struct Fnv(u64);

impl Fnv {
    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// What is counted of modules that come one after the other.
struct Tally<'g> {
    grammar: &'g Grammar,
    by_symbol: Vec<u128>,
    sums: Vec<Vec<Sum>>,
    hash: Fnv,
    modules: u64,
    depth: u64,
    max_depth: u64,
}

impl<'g> Tally<'g> {
    fn new(grammar: &'g Grammar) -> Self {
        let sums = |arity: &u8| vec![Sum::default(); usize::from(*arity)];
        Self {
            grammar,
            by_symbol: vec![0; grammar.names.symbols().len()],
            sums: grammar.arity.iter().map(sums).collect(),
            hash: Fnv(0xcbf2_9ce4_8422_2325),
            modules: 0,
            depth: 0,
            max_depth: 0,
        }
    }

    fn add(&mut self, module: &Module<'_>) {
        self.modules += 1;
        let index = usize::from(module.symbol);
        if let Some(count) = self.by_symbol.get_mut(index) {
            *count += 1;
        }
        let sums = self.sums.get_mut(index).into_iter().flatten();
        for (sum, value) in sums.zip(module.parameters) {
            sum.add(*value);
        }
        self.hash.add(self.grammar.name(module.symbol).as_bytes());
        match self.grammar.role(module.symbol) {
            Role::Open => {
                self.depth += 1;
                self.max_depth = self.max_depth.max(self.depth);
            }
            Role::Close => self.depth = self.depth.saturating_sub(1),
            _ => {}
        }
    }

    fn report(self, steps: u32, drawn: Extent, [derive_ms, turtle_ms]: [f64; 2]) -> Report {
        let (counts, param_sums) = by_name(self.grammar, &self.by_symbol, &self.sums);
        // Each is part of `modules`.
        let narrow = |count| u64::try_from(count).unwrap_or(u64::MAX);
        let [min, max] = drawn
            .bounds
            .unwrap_or_default()
            .map(|corner| corner.to_array());
        Report {
            format: "ramus-derive/1",
            steps,
            time: None,
            modules: self.modules,
            counts: counts
                .into_iter()
                .map(|(name, count)| (name, narrow(count)))
                .collect(),
            max_depth: self.max_depth,
            fnv1a64: format!("{:016x}", self.hash.0),
            param_sums,
            segments: drawn.segments,
            bounds: Bounds { min, max },
            derive_ms,
            turtle_ms,
        }
    }
}

impl Report {
    /// Counts a string and its tree; the times are the caller's.
    #[must_use]
    pub fn new(
        grammar: &Grammar,
        string: &ModuleString,
        tree: &Tree,
        steps: u32,
        derive_ms: f64,
        turtle_ms: f64,
    ) -> Self {
        let mut tally = Tally::new(grammar);
        for module in string.iter() {
            tally.add(&module);
        }
        let drawn = Extent {
            segments: tree.parent.iter().filter(|p| **p != NO_PARENT).count() as u64,
            bounds: bounds(tree),
        };
        tally.report(steps, drawn, [derive_ms, turtle_ms])
    }

    /// Counts and measures modules as they come, holding neither string nor tree: of a grammar that
    /// [`streams`](super::turtle::streams). The time that making them took is in that of the drawing.
    ///
    /// # Errors
    /// What keeps the turtle from drawing.
    pub fn streamed<'m>(
        grammar: &Grammar,
        modules: impl Iterator<Item = Module<'m>>,
        steps: u32,
        params: &TurtleParams,
        cancel: &AtomicBool,
    ) -> Result<Self, DeriveError> {
        let began = Instant::now();
        let mut tally = Tally::new(grammar);
        let modules = modules.inspect(|module| tally.add(module));
        let drawn = stream_on(grammar, modules, params, cancel, Extent::default())?;
        let turtle_ms = began.elapsed().as_secs_f64() * 1e3;
        Ok(tally.report(steps, drawn, [0.0, turtle_ms]))
    }

    /// One object on one line, without a line end.
    ///
    /// # Errors
    /// A sum beyond the range of f64.
    pub fn to_json(&self) -> Result<String, ReportError> {
        let infinite = |(_, sum): &(&String, &f64)| !sum.is_finite();
        match self.param_sums.iter().find(infinite) {
            Some((name, _)) => Err(ReportError::Overflow(name.clone())),
            None => Ok(serde_json::to_string(self)?),
        }
    }

    /// `--print counts`, as [`Counts::text`].
    #[must_use]
    pub fn counts_text(&self) -> String {
        let counts = self.counts.iter();
        Counts {
            steps: self.steps,
            modules: u128::from(self.modules),
            counts: counts.map(|(n, c)| (n.clone(), u128::from(*c))).collect(),
            param_sums: self.param_sums.clone(),
            max_depth: self.max_depth,
            segments: Some(u128::from(self.segments)),
        }
        .text()
    }
}

/// What a string holds, of which there need be no more than its graph ([`super::Unwritten`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Counts {
    /// Steps derived.
    pub steps: u32,
    /// Modules, brackets included.
    pub modules: u128,
    /// Modules of each name.
    pub counts: BTreeMap<String, u128>,
    /// Sum of each parameter over all modules of a name, as in [`Report`].
    pub param_sums: BTreeMap<String, f64>,
    /// Deepest bracket.
    pub max_depth: u64,
    /// Segments that the turtle draws; `None` where an `interpret` block says what is drawn.
    pub segments: Option<u128>,
}

impl Counts {
    /// A line for each name, its count and its parameters' sums.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        for (name, count) in &self.counts {
            let _ = write!(text, "{name} {count}");
            let sums = (0..).map_while(|i| self.param_sums.get(&format!("{name}.{i}")));
            for (i, sum) in sums.enumerate() {
                let _ = write!(text, "{}", if i == 0 { " sums " } else { " " });
                write_general(&mut text, *sum);
            }
            text.push('\n');
        }
        let _ = write!(text, "modules {}", self.modules);
        if let Some(segments) = self.segments {
            let _ = write!(text, ", segments {segments}");
        }
        let _ = writeln!(text, ", depth {}", self.max_depth);
        text
    }
}

/// Counts and sums by name: symbols of one name with different numbers of parameters are one entry.
pub(super) fn by_name(
    grammar: &Grammar,
    modules: &[u128],
    sums: &[Vec<Sum>],
) -> (BTreeMap<String, u128>, BTreeMap<String, f64>) {
    let mut counts: BTreeMap<String, u128> = BTreeMap::new();
    let mut by_name: BTreeMap<String, Sum> = BTreeMap::new();
    for ((symbol, count), parameters) in (0..).zip(modules).zip(sums) {
        if *count == 0 {
            continue;
        }
        let name = grammar.name(symbol);
        *counts.entry(name.to_owned()).or_default() += count;
        for (i, part) in parameters.iter().enumerate() {
            let sum = by_name.entry(format!("{name}.{i}")).or_default();
            sum.merge(*part);
        }
    }
    let total = |(name, sum): (String, Sum)| (name, sum.total());
    (counts, by_name.into_iter().map(total).collect())
}

fn bounds(tree: &Tree) -> Option<[Vec3; 2]> {
    // Both ends of each segment: where the turtle moved without drawing (or began) nothing stands.
    let mut ends = tree
        .parent
        .iter()
        .zip(&tree.position)
        .filter_map(|(parent, end)| Some([*tree.position.get(*parent as usize)?, *end]))
        .flatten();
    let first = ends.next()?;
    Some(ends.fold([first; 2], |[min, max], p| [min.min(p), max.max(p)]))
}
