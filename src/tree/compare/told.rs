//! A comparison as `ramus-comparison/1`.

use std::collections::BTreeMap;

use serde::Serialize;

use super::numbers::Difference;
use super::samples::{Apart as Quantity, Tested};
use super::space::{Apart, Fit};
use super::{BarDistance, Bars, Pair, Studied};

/// The format's name.
pub const FORMAT: &str = "ramus-comparison/1";

/// What is known of a tree besides itself.
#[derive(Clone, Debug, Serialize)]
pub struct About {
    /// What it is called.
    pub name: String,
    /// Its file.
    pub file: String,
    /// What the file holds: a model, a skeleton, a grammar, a project.
    pub kind: &'static str,
    /// What its numbers most likely are in.
    pub unit: Option<&'static str>,
    /// Nodes of its tree.
    pub nodes: usize,
}

/// All that is told.
#[derive(Debug, Serialize)]
pub struct Told<'a> {
    format: &'static str,
    trees: Vec<OfTree<'a>>,
    pairs: Vec<OfPair<'a>>,
}

#[derive(Debug, Serialize)]
struct OfTree<'a> {
    #[serde(flatten)]
    about: &'a About,
    numbers: BTreeMap<&'static str, Option<f64>>,
}

#[derive(Debug, Serialize)]
struct OfPair<'a> {
    a: &'a str,
    b: &'a str,
    verdict: OfVerdict<'a>,
    scale: f64,
    differences: BTreeMap<&'static str, &'a Difference>,
    distributions: BTreeMap<&'static str, OfQuantity>,
    distributions_scale_free: BTreeMap<&'static str, OfQuantity>,
    topology: OfTopology,
    space: Option<OfSpace>,
}

#[derive(Debug, Serialize)]
struct OfVerdict<'a> {
    kind: &'static str,
    words: &'a str,
}

#[derive(Debug, Serialize)]
struct OfQuantity {
    n: [usize; 2],
    ks_d: Option<f64>,
    ks_p: Option<f64>,
    ks_p_holm: Option<f64>,
    mann_whitney_u: Option<f64>,
    mann_whitney_p: Option<f64>,
    mann_whitney_p_holm: Option<f64>,
    cliffs_delta: Option<f64>,
    hedges_g: Option<f64>,
    told_apart: bool,
}

#[derive(Debug, Serialize)]
struct OfTopology {
    tmd: Tmd,
    edits: Edits,
}

#[derive(Debug, Serialize)]
struct Tmd {
    path: OfBars,
    radial: OfBars,
}

#[derive(Debug, Serialize)]
struct OfBars {
    bars: [usize; 2],
    wasserstein: Option<f64>,
    sliced_wasserstein: f64,
    share: f64,
    scale_free: OfDistance,
}

#[derive(Debug, Serialize)]
struct OfDistance {
    wasserstein: Option<f64>,
    sliced_wasserstein: f64,
    share: f64,
}

#[derive(Debug, Serialize)]
struct Edits {
    branches: Option<u32>,
    share: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    remark: Option<&'static str>,
}

#[derive(Debug, Serialize)]
struct OfSpace {
    reach: f64,
    as_is: OfApart,
    rooted: OfApart,
    fitted: OfFit,
    mirrored: OfFit,
}

#[derive(Debug, Serialize)]
struct OfApart {
    mean: f64,
    max: f64,
    mean_of_reach: f64,
    max_of_reach: f64,
}

#[derive(Debug, Serialize)]
struct OfFit {
    scale: f64,
    /// Row by row.
    turn: [[f64; 3]; 3],
    #[serde(flatten)]
    apart: OfApart,
}

impl<'a> Told<'a> {
    /// Of trees and of their pairs.
    pub fn new(about: &'a [About], trees: &'a [Studied], pairs: &'a [Pair]) -> Self {
        let of_tree = |(about, tree): (&'a About, &'a Studied)| OfTree {
            about,
            numbers: tree
                .numbers
                .iter()
                .map(|one| (one.name, one.value))
                .collect(),
        };
        Self {
            format: FORMAT,
            trees: about.iter().zip(trees).map(of_tree).collect(),
            pairs: pairs.iter().map(|pair| of_pair(about, pair)).collect(),
        }
    }
}

fn of_pair<'a>(about: &'a [About], pair: &'a Pair) -> OfPair<'a> {
    let [a, b] = pair.places.map(|place| about[place].name.as_str());
    let quantities =
        |all: &[Quantity]| all.iter().map(|one| (one.name, of_quantity(one))).collect();
    let branches: usize = pair.branches.iter().sum();
    let edits = pair.topology.edits;
    OfPair {
        a,
        b,
        verdict: OfVerdict {
            kind: pair.verdict.kind.name(),
            words: &pair.verdict.words,
        },
        scale: pair.scale,
        differences: pair.differences.iter().map(|one| (one.name, one)).collect(),
        distributions: quantities(&pair.distributions),
        distributions_scale_free: quantities(&pair.scale_free),
        topology: OfTopology {
            tmd: Tmd {
                path: of_bars(&pair.topology.path),
                radial: of_bars(&pair.topology.radial),
            },
            edits: Edits {
                branches: edits,
                share: edits.map(|edits| f64::from(edits) / branches.max(1) as f64),
                remark: edits.is_none().then_some(
                    "not counted: the trees have too many branches, or junctions of too many",
                ),
            },
        },
        space: pair.space.as_ref().map(|space| OfSpace {
            reach: space.reach,
            as_is: of_apart(space.as_is, space.reach),
            rooted: of_apart(space.rooted, space.reach),
            fitted: of_fit(space.fitted, space.reach),
            mirrored: of_fit(space.mirrored, space.reach),
        }),
    }
}

fn of_quantity(one: &Quantity) -> OfQuantity {
    let of = |value: fn(&Tested) -> f64| one.tested.as_ref().map(value);
    OfQuantity {
        n: one.n,
        ks_d: one.d,
        ks_p: of(|tested| tested.ks_p[0]),
        ks_p_holm: of(|tested| tested.ks_p[1]),
        mann_whitney_u: of(|tested| tested.mann_whitney[0]),
        mann_whitney_p: of(|tested| tested.mann_whitney[1]),
        mann_whitney_p_holm: of(|tested| tested.mann_whitney[2]),
        cliffs_delta: of(|tested| tested.delta),
        hedges_g: one.tested.and_then(|tested| tested.g),
        told_apart: one.is_told(),
    }
}

fn of_bars(bars: &Bars) -> OfBars {
    let BarDistance {
        matched,
        sliced,
        share,
    } = bars.as_is;
    OfBars {
        bars: bars.n,
        wasserstein: matched,
        sliced_wasserstein: sliced,
        share,
        scale_free: OfDistance {
            wasserstein: bars.scale_free.matched,
            sliced_wasserstein: bars.scale_free.sliced,
            share: bars.scale_free.share,
        },
    }
}

fn of_apart(apart: Apart, reach: f64) -> OfApart {
    OfApart {
        mean: apart.mean,
        max: apart.max,
        mean_of_reach: apart.mean / reach,
        max_of_reach: apart.max / reach,
    }
}

fn of_fit(fit: Fit, reach: f64) -> OfFit {
    OfFit {
        scale: fit.scale,
        turn: fit.turn.transpose().to_cols_array_2d(),
        apart: of_apart(fit.apart, reach),
    }
}
