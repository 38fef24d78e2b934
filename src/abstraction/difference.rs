//! How far one table is from another.

use serde::Serialize;

use super::by_order::{ByOrder, OrderDifference};
use super::table::{MeanStd, Table};

/// A number of two tables.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Its name, as in the table's JSON.
    pub name: &'static str,
    /// What it should be.
    pub target: f64,
    /// What it is.
    pub got: f64,
    /// The difference as a part of what it should be.
    pub relative: f64,
    /// Up to what part it matches.
    pub tolerance: f64,
}

impl Difference {
    pub(super) fn new(
        name: &'static str,
        target: f64,
        got: f64,
        [tolerance, unit]: [f64; 2],
    ) -> Self {
        Self {
            name,
            target,
            got,
            relative: (got - target) / unit,
            tolerance,
        }
    }

    /// Whether it is near enough.
    pub fn matches(&self) -> bool {
        self.relative.abs() <= self.tolerance
    }
}

/// Within what part of the model's means and counts match.
pub const OF_MEANS: f64 = 0.05;
/// Within what part standard deviations do.
pub const OF_DEVIATIONS: f64 = 0.10;
/// A standard deviation counts as no smaller than this part of the mean: that of next to nothing need not be met to the hundredth.
const DEVIATION_LEAST: f64 = 0.05;

/// What of a target a table has otherwise: all that the target says but what follows from the rest.
pub fn differences(target: &Table, got: &Table) -> Vec<Difference> {
    let (wanted, counts) = (target.table, target.counts);
    let mut all = Vec::new();
    for (name, wanted, got, tolerance) in [
        (
            "centerlines",
            counts.centerlines,
            got.counts.centerlines,
            0.0,
        ),
        (
            "junctions",
            counts.junctions,
            got.counts.junctions,
            OF_MEANS,
        ),
        ("branches", counts.branches, got.counts.branches, OF_MEANS),
    ] {
        if let (Some(wanted), Some(got)) = (wanted, got) {
            let [wanted, got] = [wanted as f64, got as f64];
            all.push(Difference::new(
                name,
                wanted,
                got,
                [tolerance, wanted.max(1.0)],
            ));
        }
    }
    for ([name, of_std], wanted, got) in [
        (
            ["branch_length.mean", "branch_length.std"],
            wanted.branch_length,
            got.table.branch_length,
        ),
        (
            ["point_radius.mean", "point_radius.std"],
            wanted.point_radius,
            got.table.point_radius,
        ),
        (
            ["centerline_length.mean", "centerline_length.std"],
            wanted.centerline_length,
            got.table.centerline_length,
        ),
        (
            ["bifurcation_angle_deg.mean", "bifurcation_angle_deg.std"],
            wanted.bifurcation_angle_deg,
            got.table.bifurcation_angle_deg,
        ),
    ] {
        let Some(wanted) = wanted else {
            continue;
        };
        let got = got.unwrap_or_default();
        let unit = wanted.mean.abs().max(f64::MIN_POSITIVE);
        all.push(Difference::new(
            name,
            wanted.mean,
            got.mean,
            [OF_MEANS, unit],
        ));
        if let MeanStd { std: Some(std), .. } = wanted {
            let unit = std.max(DEVIATION_LEAST * unit);
            all.push(Difference::new(
                of_std,
                std,
                got.std.unwrap_or(0.0),
                [OF_DEVIATIONS, unit],
            ));
        }
    }
    all
}

/// One number for all: the root of the mean square of relative differences, those of standard deviations and of orders by half. All orders together
/// count as three numbers, a length, a radius and an angle, and what they are off by more than by a part of themselves counts the less. `misplaced` is the part of
/// branches that are of other orders than the model's.
pub fn distance(differences: &[Difference], by_order: &[OrderDifference], misplaced: f64) -> f64 {
    let orders = if by_order.is_empty() {
        0
    } else {
        ByOrder::ALL.len()
    };
    let sum: f64 = residuals(differences, by_order)
        .map(|residual| residual.powi(2))
        .sum();
    let mean = sum / (differences.len() + orders).max(1) as f64;
    mean.sqrt().hypot(OF_MISPLACED * misplaced)
}

/// How much branches of other orders count.
const OF_MISPLACED: f64 = 0.1;

/// Relative differences, each by how much it counts.
pub(super) fn residuals(
    differences: &[Difference],
    by_order: &[OrderDifference],
) -> impl Iterator<Item = f64> {
    let of_order = |one: &OrderDifference| {
        let relative = one.difference.relative;
        relative / (1.0 + relative.abs()) * weight(&one.difference) * one.share.sqrt()
    };
    let whole = differences.iter().map(|one| one.relative * weight(one));
    whole.chain(by_order.iter().map(of_order))
}

/// How much a difference counts.
fn weight(one: &Difference) -> f64 {
    if one.tolerance == OF_DEVIATIONS {
        OF_MEANS / OF_DEVIATIONS
    } else {
        1.0
    }
}
