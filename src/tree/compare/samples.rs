//! How quantities are spread in two trees, over each other: tests and effect sizes.
//!
//! Values of one tree are no independent draws, branches of one fork least of all, so a p says how large a difference is beside what as many
//! independent values would have by chance, and not how likely it is that both trees are of one population: that takes groups of trees (`ramus
//! cohort`). Two quantities count as told apart where p, corrected by Holm for all tests of the pair, is small *and* the distributions are apart by
//! a part that matters. Radii at points along the tree are as many as one likes, so of them D alone is told.

use rayon::prelude::*;

use crate::tree::Tree;
use crate::tree::measure::compare::{
    cliffs_delta, hedges_g, holm, kolmogorov_smirnov, mann_whitney,
};
use crate::tree::measure::{Branch, Measures, point_radius_of};

/// Corrected p below which a quantity is told apart.
pub const P_BELOW: f64 = 0.05;
/// Kolmogorov's and Smirnov's D from which on it is.
pub const D_FROM: f64 = 0.15;
/// Values of a tree from which on tests say anything: of six and six the smallest p is 0.002.
pub const VALUES_LEAST: usize = 6;

/// Quantities that make a kind.
const OF_KIND: [&str; 5] = [
    "branch_length",
    "branch_radius",
    "centerline_length",
    "bifurcation_angle_deg",
    "parent_angle_deg",
];

/// A tortuosity, and a turn along a branch in radians, that is rounding.
pub(super) const STRAIGHT: f64 = 1e-5;

/// The values of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Its name.
    pub name: &'static str,
    /// As a person reads it.
    pub words: &'static str,
    /// To which power of a length it is.
    pub power: i8,
    /// Whether it is of what makes a kind: sizes, angles and ways, of which the source papers' table is. Others tell how branches run and taper and how junctions
    /// share.
    pub of_kind: bool,
    /// Whether each value stands for a thing that was counted, so that tests mean anything.
    pub counted: bool,
    /// The values, all of them numbers.
    pub values: Vec<f64>,
}

/// All samples of a tree, always the same in the same order.
pub fn samples(tree: &Tree, measures: &Measures) -> Vec<Sample> {
    let Measures {
        branches,
        junctions,
        ..
    } = measures;
    let sample = |name: &'static str, words, power, values: Vec<f64>| Sample {
        name,
        words,
        power,
        of_kind: OF_KIND.contains(&name),
        counted: true,
        values: values
            .into_iter()
            .filter(|value| value.is_finite())
            .collect(),
    };
    let of = |value: fn(&Branch) -> f64| branches.iter().map(value).collect::<Vec<f64>>();
    let degrees = |angles: &Vec<f64>| {
        angles
            .iter()
            .map(|angle| angle.to_degrees())
            .collect::<Vec<f64>>()
    };
    let mut radii = sample(
        "point_radius",
        "point radius",
        1,
        point_radius_of(tree, branches),
    );
    radii.counted = false;
    vec![
        sample(
            "branch_length",
            "branch length",
            1,
            of(|branch| branch.length),
        ),
        sample(
            "branch_radius",
            "branch radius",
            1,
            of(|branch| branch.radius.mean),
        ),
        radii,
        sample(
            "centerline_length",
            "centerline length",
            1,
            centerlines(branches),
        ),
        sample(
            "bifurcation_angle_deg",
            "bifurcation angle (°)",
            0,
            junctions
                .iter()
                .flat_map(|one| degrees(&one.angles))
                .collect(),
        ),
        sample(
            "parent_angle_deg",
            "angle to the parent (°)",
            0,
            junctions
                .iter()
                .flat_map(|one| degrees(&one.parent_angles))
                .collect(),
        ),
        sample(
            "tortuosity",
            "tortuosity",
            0,
            of(|branch| unless_straight(branch, branch.tortuosity())),
        ),
        sample(
            "curvature",
            "curvature",
            -1,
            of(|branch| unless_straight(branch, branch.curvature)),
        ),
        sample(
            "taper",
            "taper",
            0,
            of(|branch| branch.radius.taper(branch.length)),
        ),
        sample(
            "murray",
            "Murray exponent",
            0,
            junctions.iter().filter_map(|one| one.exponent).collect(),
        ),
        sample(
            "asymmetry",
            "asymmetry",
            0,
            junctions.iter().filter_map(|one| one.asymmetry).collect(),
        ),
    ]
}

/// Of what bends by less than single precision tells: nothing, so that straight branches are the same.
fn unless_straight(branch: &Branch, value: f64) -> f64 {
    let is_straight =
        branch.tortuosity().abs() < STRAIGHT && branch.curvature * branch.length < STRAIGHT;
    if is_straight { 0.0 } else { value }
}

/// Lengths of the ways from root to tip.
fn centerlines(branches: &[Branch]) -> Vec<f64> {
    let mut to_end = vec![0.0; branches.len()];
    for (place, branch) in branches.iter().enumerate() {
        to_end[place] = branch.length + branch.parent.map_or(0.0, |parent| to_end[parent]);
    }
    let tips = branches
        .iter()
        .zip(to_end)
        .filter(|(branch, _)| branch.is_tip);
    tips.map(|(_, length)| length).collect()
}

/// A quantity of two trees. Effect sizes are above zero where the first has the larger values.
#[derive(Clone, Debug, PartialEq)]
pub struct Apart {
    /// Its name.
    pub name: &'static str,
    /// As a person reads it.
    pub words: &'static str,
    /// Whether it is of what makes a kind.
    pub of_kind: bool,
    /// How many values each tree has.
    pub n: [usize; 2],
    /// The largest difference between both parts at or below a value, 0 to 1. None where one has no values.
    pub d: Option<f64>,
    /// The test; none where it would say nothing.
    pub tested: Option<Tested>,
}

/// What tests tell of a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tested {
    /// The p by Kolmogorov and Smirnov, and corrected by Holm for all tests of the pair.
    pub ks_p: [f64; 2],
    /// By Mann and Whitney: U, p, and p corrected.
    pub mann_whitney: [f64; 3],
    /// Cliff's delta.
    pub delta: f64,
    /// Hedges' g.
    pub g: Option<f64>,
}

impl Apart {
    /// Whether the trees are told apart by it.
    pub fn is_told(&self) -> bool {
        let far = self.d.is_some_and(|d| d >= D_FROM);
        let sure = |tested: Tested| tested.ks_p[1].min(tested.mann_whitney[2]) < P_BELOW;
        far && self.tested.is_some_and(sure)
    }
}

/// Compares all samples of two trees, of which the second is so many times as large: as they are, and at one size.
pub fn apart(a: &[Sample], b: &[Sample], scale: f64) -> [Vec<Apart>; 2] {
    let two = |(a, b): (&Sample, &Sample)| {
        let as_is = one(a, b, 1.0);
        let scale_free = match a.power == 0 || scale == 1.0 {
            true => as_is.clone(),
            false => one(a, b, scale),
        };
        (as_is, scale_free)
    };
    let (as_is, scale_free): (Vec<Apart>, Vec<Apart>) = a.par_iter().zip(b).map(two).unzip();
    [as_is, scale_free].map(corrected)
}

/// With p corrected by Holm for all tests.
fn corrected(mut all: Vec<Apart>) -> Vec<Apart> {
    let mut tested: Vec<&mut Tested> = all
        .iter_mut()
        .filter_map(|one| one.tested.as_mut())
        .collect();
    let values: Vec<f64> = tested
        .iter()
        .flat_map(|one| [one.ks_p[0], one.mann_whitney[1]])
        .collect();
    for (one, corrected) in tested.iter_mut().zip(holm(&values).chunks(2)) {
        if let [ks, ranks] = corrected {
            one.ks_p[1] = *ks;
            one.mann_whitney[2] = *ranks;
        }
    }
    all
}

fn one(a: &Sample, b: &Sample, scale: f64) -> Apart {
    let factor = scale.powi(-i32::from(b.power));
    let second: Vec<f64> = b.values.iter().map(|value| value * factor).collect();
    let n = [a.values.len(), second.len()];
    let ks = match a.counted {
        true => kolmogorov_smirnov(&a.values, &second).map(|found| (found.d, found.p)),
        false => farthest(&a.values, &second).map(|d| (d, 1.0)),
    };
    let enough = a.counted && n.iter().all(|n| *n >= VALUES_LEAST);
    let tested = ks.zip(mann_whitney(&a.values, &second)).filter(|_| enough);
    Apart {
        name: a.name,
        words: a.words,
        of_kind: a.of_kind,
        n,
        d: ks.map(|(d, _)| d),
        tested: tested.map(|((_, p), ranks)| Tested {
            ks_p: [p; 2],
            mann_whitney: [ranks.u, ranks.p, ranks.p],
            delta: cliffs_delta(ranks.u, n[0], n[1]),
            g: hedges_g(&a.values, &second),
        }),
    }
}

/// The largest difference between the parts of two samples at or below a value. None where one is empty.
fn farthest(a: &[f64], b: &[f64]) -> Option<f64> {
    let mut sorted = [a.to_vec(), b.to_vec()];
    sorted
        .iter_mut()
        .for_each(|values| values.sort_by(f64::total_cmp));
    let [a, b] = &sorted;
    let (mut x, mut y, mut apart) = (0, 0, 0.0_f64);
    while let (Some(one), Some(other)) = (a.get(x), b.get(y)) {
        let value = one.min(*other);
        x += a[x..].iter().take_while(|other| **other <= value).count();
        y += b[y..].iter().take_while(|other| **other <= value).count();
        apart = apart.max((x as f64 / a.len() as f64 - y as f64 / b.len() as f64).abs());
    }
    (!a.is_empty() && !b.is_empty()).then_some(apart)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "the table says it"
    )]
    use super::*;
    use proptest::prelude::*;

    fn sample(values: impl IntoIterator<Item = f64>) -> Sample {
        Sample {
            name: "branch_length",
            words: "branch length",
            power: 1,
            of_kind: true,
            counted: true,
            values: values.into_iter().collect(),
        }
    }

    fn row(from: f64, count: u32) -> Sample {
        sample((0..count).map(|place| from + f64::from(place)))
    }

    #[test]
    fn quantities_are_told_apart_where_they_are_far_and_many() {
        for (a, b, scale, told) in [
            (row(0.0, 40), row(0.0, 40), 1.0, false),
            (row(0.0, 40), row(30.0, 40), 1.0, true),
            (row(0.0, 4), row(30.0, 4), 1.0, false),
            // Sure and near: no difference that matters.
            (row(0.0, 9000), row(700.0, 9000), 1.0, false),
            (
                row(10.0, 40),
                sample((0..40).map(|place| 20.0 + 2.0 * f64::from(place))),
                2.0,
                false,
            ),
            (
                row(10.0, 40),
                sample((0..40).map(|place| 20.0 + 2.0 * f64::from(place))),
                1.0,
                true,
            ),
            (row(0.0, 40), row(0.0, 0), 1.0, false),
        ] {
            let [_, found] = apart(&[a], &[b], scale);
            assert_eq!(found[0].is_told(), told, "{found:?}");
        }
    }

    #[test]
    fn points_have_no_p() {
        let points = |from| Sample {
            counted: false,
            ..row(from, 100)
        };
        let found = &apart(&[points(0.0)], &[points(50.0)], 1.0)[0][0];
        assert_eq!((found.d, found.tested), (Some(0.5), None));
    }

    proptest! {
        #[test]
        fn both_ways_to_d_are_one(
            a in prop::collection::vec(0_u8..9, 1..30), b in prop::collection::vec(0_u8..9, 1..30),
        ) {
            let [a, b] = [a, b].map(|values| values.into_iter().map(f64::from).collect::<Vec<f64>>());
            let other = kolmogorov_smirnov(&a, &b).unwrap().d;
            prop_assert!((farthest(&a, &b).unwrap() - other).abs() < 1e-12);
        }
    }
}
