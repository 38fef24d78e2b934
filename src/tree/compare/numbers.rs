//! What a tree is like in numbers: counts, sums, the source papers' table and orders, and how far two trees' numbers are apart.
//!
//! Names are those of `ramus cohort`'s tables. Lengths are in the tree's unit, angles in degrees. What is not there, such as the angle of a tree
//! without junctions, has no value.

use serde::Serialize;

use super::samples::STRAIGHT;
use crate::tree::measure::{Branch, Measures, Spread, spread};

/// Up to what part means and counts match, as the source papers have it.
pub const OF_MEANS: f64 = 0.05;
/// Up to what part standard deviations do.
pub const OF_DEVIATIONS: f64 = 0.10;
/// A standard deviation counts as no smaller than this part of its mean.
const DEVIATION_LEAST: f64 = 0.05;

/// No angle is a part of less than this, degrees: single precision knows none better.
const ANGLE_LEAST: f64 = 0.01;

/// What differences of a number are parts of at least.
fn least(name: &str) -> f64 {
    if name.contains("_deg") {
        ANGLE_LEAST
    } else {
        0.0
    }
}

/// What is counted or measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number {
    /// Its name.
    pub name: &'static str,
    /// To which power of a length it is: 1 of lengths, 3 of volumes, 0 of what has no unit.
    pub power: i8,
    /// Whether it is one of the eleven numbers of the source papers' table.
    pub of_papers: bool,
    /// What it is; none where there is nothing that it could be of.
    pub value: Option<f64>,
    /// Less than this part of it is no difference.
    pub tolerance: f64,
    /// What differences are parts of; the value itself, or a part of the mean where a deviation is next to nothing.
    unit: f64,
}

impl Number {
    fn new(name: &'static str, power: i8, value: Option<f64>) -> Self {
        let value = value.filter(|value| value.is_finite());
        Self {
            name,
            power,
            of_papers: false,
            value,
            tolerance: OF_MEANS,
            unit: value.unwrap_or_default().abs().max(least(name)),
        }
    }

    /// One of the papers'.
    fn of_papers(mut self) -> Self {
        self.of_papers = true;
        self
    }

    /// The unit that it is told in: of lengths the tree's own.
    pub fn unit(&self) -> &'static str {
        match self.power {
            1 => "length",
            2 => "length²",
            3 => "length³",
            -1 => "1/length",
            _ if self.name.contains("_deg") => "degrees",
            _ => "",
        }
    }
}

/// A mean and its deviation; nothing of nothing.
fn both(names: [&'static str; 2], power: i8, of: Spread) -> [Number; 2] {
    let known = of.n > 0;
    let mean = Number::new(names[0], power, known.then_some(of.mean)).of_papers();
    let std = Number::new(names[1], power, known.then_some(of.std)).of_papers();
    let unit = of.std.max(DEVIATION_LEAST * of.mean.abs());
    let unit = unit.max(least(names[1]));
    [
        mean,
        Number {
            tolerance: OF_DEVIATIONS,
            unit,
            ..std
        },
    ]
}

/// A spread in degrees.
fn degrees(of: Spread) -> Spread {
    Spread {
        mean: of.mean.to_degrees(),
        std: of.std.to_degrees(),
        min: of.min.to_degrees(),
        max: of.max.to_degrees(),
        ..of
    }
}

/// All numbers of a tree, always the same in the same order.
pub fn numbers(measures: &Measures) -> Vec<Number> {
    let Measures {
        branches,
        junctions,
        tips,
        orders,
        ratios,
        table,
        ..
    } = measures;
    let count = |name, count: usize| Number::new(name, 0, Some(count as f64));
    let total = |of: fn(&Branch) -> f64| Some(branches.iter().map(of).sum::<f64>());
    let mean = |of: Spread| (of.n > 0).then_some(of.mean);
    let some = |value: f64| (!branches.is_empty()).then_some(value);
    let over = |values: Vec<f64>| mean(spread(values));
    // What single precision leaves of straight branches is no curvature.
    let bend = table.curvature.max * table.branch_length.max;
    let curvature = match bend < STRAIGHT {
        true => Spread {
            mean: 0.0,
            ..table.curvature
        },
        false => table.curvature,
    };
    let parent_angles = junctions.iter().flat_map(|one| &one.parent_angles).copied();
    let mut all = vec![
        count("centerlines", *tips).of_papers(),
        count("junctions", junctions.len()).of_papers(),
        count("branches", branches.len()).of_papers(),
        count("strahler_max", orders.len()),
        Number::new("total_length", 1, total(|branch| branch.length)),
        Number::new("total_area", 2, total(|branch| branch.area)),
        Number::new("total_volume", 3, total(|branch| branch.volume)),
    ];
    all.extend(both(
        ["branch_length_mean", "branch_length_std"],
        1,
        table.branch_length,
    ));
    all.extend(both(
        ["point_radius_mean", "point_radius_std"],
        1,
        table.point_radius,
    ));
    all.extend(both(
        ["centerline_length_mean", "centerline_length_std"],
        1,
        table.centerline_length,
    ));
    all.extend(both(
        ["bifurcation_angle_deg_mean", "bifurcation_angle_deg_std"],
        0,
        degrees(table.bifurcation_angle),
    ));
    all.extend([
        Number::new(
            "bifurcation_angle_in_plane_deg_mean",
            0,
            mean(degrees(table.in_plane_angle)),
        ),
        Number::new(
            "parent_angle_deg_mean",
            0,
            over(parent_angles.map(f64::to_degrees).collect()),
        ),
        Number::new(
            "upwards_angle_deg_mean",
            0,
            mean(degrees(table.upwards_angle)),
        ),
        Number::new("stem_length", 1, some(table.stem_length)),
        Number::new("stem_iterations", 0, some(table.stem_iterations)),
        Number::new("iterations_mean", 0, some(table.iterations[0])),
        Number::new("iterations_std", 0, some(table.iterations[1])),
        Number::new("curvature_mean", -1, mean(curvature)),
        Number::new("torsion_mean", -1, mean(table.torsion)),
        Number::new("tortuosity_mean", 0, mean(table.tortuosity)),
        Number::new("branching_ratio", 0, ratios.branching),
        Number::new("length_ratio", 0, ratios.length),
        Number::new("radius_ratio", 0, ratios.radius),
        Number::new(
            "murray_mean",
            0,
            over(junctions.iter().filter_map(|one| one.exponent).collect()),
        ),
        Number::new(
            "asymmetry_mean",
            0,
            over(junctions.iter().filter_map(|one| one.asymmetry).collect()),
        ),
    ]);
    all
}

/// A number of two trees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Its name.
    #[serde(skip)]
    pub name: &'static str,
    /// Whether it is of the source papers' table.
    pub of_papers: bool,
    /// What the first tree has.
    pub a: Option<f64>,
    /// What the second has.
    pub b: Option<f64>,
    /// How much more the second has, as a part of what the first has. None where one has none, or where the first's is 0.
    pub relative: Option<f64>,
    /// The same with the second tree made as large as the first.
    pub relative_scale_free: Option<f64>,
    /// Up to what part it is no difference.
    pub tolerance: f64,
}

impl Difference {
    /// Of a number of two trees, of which the second is so many times as large.
    pub fn new(a: &Number, b: &Number, scale: f64) -> Self {
        let both = a.value.zip(b.value);
        let relative = |factor: f64| {
            let (from, to) = both?;
            let to = to * factor;
            let part = (to - from) / a.unit;
            // What both have none of is the same.
            if from == to { Some(0.0) } else { Some(part) }.filter(|part| part.is_finite())
        };
        Self {
            name: a.name,
            of_papers: a.of_papers,
            a: a.value,
            b: b.value,
            relative: relative(1.0),
            relative_scale_free: relative(scale.powi(-i32::from(a.power))),
            tolerance: a.tolerance,
        }
    }

    /// Whether both have it alike; as they are, or made one size.
    pub fn matches(&self, scale_free: bool) -> bool {
        let relative = match scale_free {
            true => self.relative_scale_free,
            false => self.relative,
        };
        match relative {
            Some(relative) => relative.abs() <= self.tolerance,
            None => self.a == self.b,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "the table says it"
    )]
    use super::super::tests::{grown, moved, spec};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_papers_have_eleven_numbers_and_names_are_told_once() {
        let tree = grown(&[
            (0, [0.0, 10.0, 0.0]),
            (1, [5.0, 5.0, 0.0]),
            (1, [-5.0, 5.0, 0.0]),
        ]);
        let all = numbers(&Measures::whole(&tree));
        assert_eq!(all.iter().filter(|one| one.of_papers).count(), 11);
        let mut names: Vec<&str> = all.iter().map(|one| one.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all.len());
        let of = |name: &str| all.iter().find(|one| one.name == name).unwrap().value;
        assert_eq!(of("centerlines"), Some(2.0));
        assert!((of("bifurcation_angle_deg_mean").unwrap() - 90.0).abs() < 1e-4);
        assert!((of("total_length").unwrap() - 10.0 - 2.0 * 50.0_f64.sqrt()).abs() < 1e-5);
        // Of nothing nothing but counts and sums is known.
        let none = numbers(&Measures::whole(&grown(&[])));
        let known: Vec<&str> = none
            .iter()
            .filter(|one| one.value.is_some())
            .map(|one| one.name)
            .collect();
        assert_eq!(
            known,
            [
                "centerlines",
                "junctions",
                "branches",
                "strahler_max",
                "total_length",
                "total_area",
                "total_volume"
            ]
        );
    }

    proptest! {
        #[test]
        fn a_tree_that_is_larger_is_the_same_but_for_its_size(tree in spec(12), scale in 0.2..5.0_f32) {
            let mut larger = moved(&tree, |at| at * scale);
            larger.radius.iter_mut().for_each(|radius| *radius *= scale);
            let [one, other] = [&tree, &larger].map(|tree| numbers(&Measures::whole(tree)));
            for (a, b) in one.iter().zip(&other) {
                let difference = Difference::new(a, b, f64::from(scale));
                // Torsion and angles of short pieces are known the less in single precision.
                if a.of_papers || a.name.starts_with("total") {
                    prop_assert!(difference.relative_scale_free.unwrap_or(0.0).abs() < 1e-2, "{difference:?}");
                    prop_assert!(difference.matches(true), "{difference:?}");
                    let expected = f64::from(scale).powi(a.power.into()) - 1.0;
                    if a.value.is_some_and(|value| value > 1e-3) && !a.name.ends_with("std") {
                        prop_assert!((difference.relative.unwrap() - expected).abs() < 1e-2 * (1.0 + expected.abs()));
                    }
                }
            }
        }
    }
}
