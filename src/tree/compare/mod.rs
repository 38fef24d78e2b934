//! Two trees or more, compared: numbers, distributions, branching, and place in space, with a verdict in words.
//!
//! ```text
//! Tree ─▶ Studied: measures ─▶ numbers ────────────────▶ differences ───┐
//!            │         └─────▶ samples ────────────────▶ tests ─────────┤
//!            ├─▶ barcodes ─▶ matched and sliced distance ─▶ topology ───┼─▶ Pair ─▶ verdict ─▶ told (JSON)
//!            ├─▶ branches ─▶ edits ─────────────────────────┘           │
//!            └─▶ axis ─▶ nearest distances, fitted ─▶ space ────────────┘
//! ```
//!
//! Whatever a tree came from (a scanned model, a skeleton, a grammar, a sketch), it is compared alike. Lengths are in each tree's own unit, of
//! which a tree knows nothing: so each comparison is also made with both at one size, by the mean length of their branches.

pub mod assignment;
pub mod barcode;
pub mod bars;
pub mod edits;
mod near;
pub mod numbers;
pub mod samples;
pub mod space;
pub mod told;
mod turn;
pub mod verdict;

use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use self::barcode::{Bar, Height, barcode};
use self::numbers::{Difference, Number, numbers};
use self::samples::{Apart, Sample, samples};
use self::space::{Axis, Space};
use self::verdict::Verdict;
use super::Tree;
use super::measure::Measures;

/// A tree, ready to be compared.
pub struct Studied {
    /// Its measures, of whole branches.
    pub measures: Measures,
    /// What it is like in numbers.
    pub numbers: Vec<Number>,
    /// How its quantities are spread.
    pub samples: Vec<Sample>,
    /// Its barcodes by ways and by straight lines.
    pub bars: [Vec<Bar>; 2],
    /// Its axis; none where it has no length.
    pub axis: Option<Axis>,
}

impl Studied {
    /// Of a tree whose positions are counted from a place of its file.
    pub fn new(tree: &Tree, origin: DVec3) -> Self {
        let bars = || [Height::Path, Height::Radial].map(|by| barcode(tree, by));
        let (measures, (bars, axis)) = rayon::join(
            || Measures::whole(tree),
            || rayon::join(bars, || Axis::new(tree, origin)),
        );
        Self {
            numbers: numbers(&measures),
            samples: samples(tree, &measures),
            bars,
            axis,
            measures,
        }
    }

    /// The mean length of its branches, by which trees are made one size; 0 where there are none.
    pub fn size(&self) -> f64 {
        self.measures.table.branch_length.mean
    }
}

/// How far two barcodes are apart.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BarDistance {
    /// The matched distance, exact; none where too many bars differ for it.
    pub matched: Option<f64>,
    /// The sliced distance.
    pub sliced: f64,
    /// The matched distance, or else the sliced one, as a part of all bars' length: 0 of the same, 1 where no bar has a counterpart.
    pub share: f64,
}

impl BarDistance {
    fn new(bars: [&[Bar]; 2], sliced: f64) -> Self {
        let matched = bars::matched(bars[0], bars[1]);
        let all = bars::length(bars[0]) + bars::length(bars[1]);
        let distance = matched.unwrap_or(sliced);
        let share = if all > 0.0 { distance / all } else { 0.0 };
        Self {
            matched,
            sliced,
            share: share.min(1.0),
        }
    }
}

/// Barcodes as they are, and with the bars of each together of length 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bars {
    /// How many bars each tree has.
    pub n: [usize; 2],
    /// As they are.
    pub as_is: BarDistance,
    /// At one length.
    pub scale_free: BarDistance,
}

/// How two trees branch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Topology {
    /// By barcodes of ways from the root.
    pub path: Bars,
    /// By barcodes of straight lines from the root.
    pub radial: Bars,
    /// Branches to be taken away or added until both fork alike; none where that takes too long.
    pub edits: Option<u32>,
}

/// Two trees, compared.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Which trees, by their places.
    pub places: [usize; 2],
    /// How many branches each has.
    pub branches: [usize; 2],
    /// How many times as large the second is: its branches' mean length over the first's. 1 where one has none.
    pub scale: f64,
    /// Number by number.
    pub differences: Vec<Difference>,
    /// Quantity by quantity, as they are.
    pub distributions: Vec<Apart>,
    /// The same with both at one size.
    pub scale_free: Vec<Apart>,
    /// How they branch.
    pub topology: Topology,
    /// How they lie over each other; none where one has no length.
    pub space: Option<Space>,
    /// What that says.
    pub verdict: Verdict,
}

/// Compares all pairs of trees: first and second, first and third, … second and third, and so on. `progress` gets how many are done of how many. None
/// where `cancel` is set.
pub fn compare(
    all: &[Studied],
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(usize, usize),
) -> Option<Vec<Pair>> {
    pairs(all, all.len(), cancel, progress)
}

/// Compares all others with the first tree. None where `cancel` is set.
pub fn compare_with_first(all: &[Studied], cancel: &AtomicBool) -> Option<Vec<Pair>> {
    pairs(all, 1, cancel, &mut |_, _| {})
}

/// Compares so many trees, from the first on, with all behind them.
fn pairs(
    all: &[Studied],
    firsts: usize,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(usize, usize),
) -> Option<Vec<Pair>> {
    // In the order in which distances of all are worked out, so that these of the first come first.
    let places: Vec<[usize; 2]> = (0..firsts.min(all.len()))
        .flat_map(|a| (a + 1..all.len()).map(move |b| [a, b]))
        .collect();
    progress(0, places.len());
    let [path, radial] = [0, 1].map(|which| {
        let barcodes: Vec<&[Bar]> = all.iter().map(|one| one.bars[which].as_slice()).collect();
        let scales: Vec<f64> = barcodes.iter().map(|bars| per_length(bars)).collect();
        bars::sliced(&barcodes, &scales)
    });
    let mut pairs = Vec::with_capacity(places.len());
    for (number, both) in places.iter().enumerate() {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        let two = both.map(|place| &all[place]);
        pairs.push(pair(*both, two, [path[number], radial[number]]));
        progress(number + 1, places.len());
    }
    Some(pairs)
}

/// By what bars are made of length 1 together.
fn per_length(bars: &[Bar]) -> f64 {
    match bars::length(bars) {
        length if length > 0.0 => 1.0 / length,
        _ => 1.0,
    }
}

fn pair(places: [usize; 2], [a, b]: [&Studied; 2], sliced: [[f64; 2]; 2]) -> Pair {
    let scale = match b.size() / a.size() {
        scale if scale.is_finite() && scale > 0.0 => scale,
        _ => 1.0,
    };
    let differences = a.numbers.iter().zip(&b.numbers);
    // Parts that take long beside each other.
    let ((topology, space), [distributions, scale_free]) = rayon::join(
        || {
            let space = || Some(a.axis.as_ref()?.with(b.axis.as_ref()?));
            rayon::join(|| topology([a, b], sliced), space)
        },
        || samples::apart(&a.samples, &b.samples, scale),
    );
    let mut pair = Pair {
        places,
        branches: [a, b].map(|one| one.measures.branches.len()),
        scale,
        differences: differences
            .map(|(a, b)| Difference::new(a, b, scale))
            .collect(),
        distributions,
        scale_free,
        topology,
        space,
        verdict: Verdict {
            kind: verdict::Kind::Different,
            words: String::new(),
            at_one_size: false,
            within: [0; 2],
            told_apart: [0; 2],
        },
    };
    pair.verdict = verdict::verdict(&pair);
    pair
}

fn topology([a, b]: [&Studied; 2], sliced: [[f64; 2]; 2]) -> Topology {
    let bars = |which: usize| {
        let both = [&a.bars[which], &b.bars[which]];
        let at_one: Vec<Vec<Bar>> = both
            .par_iter()
            .map(|bars| bars::scaled(bars, per_length(bars)))
            .collect();
        Bars {
            n: both.map(Vec::len),
            as_is: BarDistance::new(both.map(Vec::as_slice), sliced[which][0]),
            scale_free: BarDistance::new([&at_one[0], &at_one[1]], sliced[which][1]),
        }
    };
    let ((path, radial), edits) = rayon::join(
        || rayon::join(|| bars(0), || bars(1)),
        || edits::edits(&a.measures.branches, &b.measures.branches),
    );
    Topology {
        path,
        radial,
        edits,
    }
}

#[cfg(test)]
mod tests;
