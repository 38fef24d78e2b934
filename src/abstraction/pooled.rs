//! The table of a group of models, as of one that is typical of them.
//!
//! Branches, ways and angles of all models are put together and their mean and standard deviation taken, so that a model counts by how many it has;
//! radii by how long its branches are together. Counts and the stem are means of the models', counts rounded. What follows from the rest (iterations)
//! follows from the pooled numbers. So a deviation holds what differs within models and what differs between them.

use super::by_order::OfOrder;
use super::error::AbstractionError;
use super::table::{Counts, FORMAT, MeanStd, Orders, Quantities, Table};
use crate::tree::measure::Spread;

/// What is taken of a model. Lengths are in its unit, which is to be that of all; angles in degrees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Ways from the root to tips.
    pub centerlines: usize,
    /// Nodes with two children or more.
    pub junctions: usize,
    /// Runs between junctions, the root and tips.
    pub branches: usize,
    /// Of all branches together.
    pub total_length: f64,
    /// From the root to the first junction.
    pub stem_length: f64,
    /// Lengths of branches.
    pub branch_length: Spread,
    /// Radii at equally spaced points.
    pub point_radius: Spread,
    /// Lengths of ways.
    pub centerline_length: Spread,
    /// Angles between daughters.
    pub bifurcation_angle_deg: Spread,
    /// How branches bend; of as many as there are branches.
    pub upwards_angle_deg: Spread,
    /// What branches are like by order, from 0.
    pub by_order: Vec<OfOrder>,
}

/// The table of models together.
///
/// # Errors
/// [`AbstractionError::Table`] where there is no model with branches, or a number is none that a model has.
pub fn pooled(parts: &[Part]) -> Result<Table, AbstractionError> {
    let parts: Vec<&Part> = parts.iter().filter(|part| part.branches > 0).collect();
    if parts.is_empty() {
        return Err(AbstractionError::Table(
            "none of the models has a branch".to_owned(),
        ));
    }
    let models = parts.len() as f64;
    let mean = |of: fn(&Part) -> f64| parts.iter().map(|part| of(part)).sum::<f64>() / models;
    let counted = |part: &&&Part, of: fn(&Part) -> Spread| (of(part), of(part).n as f64);
    let by_count = |of: fn(&Part) -> Spread| together(parts.iter().map(|part| counted(&part, of)));
    let branch_length = by_count(|part| part.branch_length).unwrap_or_default();
    let centerline = by_count(|part| part.centerline_length).unwrap_or_default();
    let by_length = parts
        .iter()
        .map(|part| (part.point_radius, part.total_length));
    let stem_iterations = mean(|part| part.stem_length) / branch_length.mean;
    let [tips, junctions, branches] = [
        mean(|part| part.centerlines as f64),
        mean(|part| part.junctions as f64),
        mean(|part| part.branches as f64),
    ];
    let [some_tips, some_junctions] = [tips, junctions].map(whole);
    // Rounded each by itself they might contradict each other.
    let whole_branches = match (tips + junctions - branches).abs() < 1e-9 {
        true => some_tips + some_junctions,
        false => whole(branches),
    };
    let table = Table {
        format: FORMAT.to_owned(),
        counts: Counts {
            centerlines: Some(some_tips),
            junctions: Some(some_junctions),
            branches: Some(whole_branches),
        },
        table: Quantities {
            branch_length: Some(branch_length),
            point_radius: together(by_length),
            centerline_length: Some(centerline),
            stem_iterations: Some(stem_iterations),
            iterations: Some(MeanStd {
                mean: centerline.mean / branch_length.mean - stem_iterations,
                std: centerline.std.map(|std| std / branch_length.mean),
            }),
            bifurcation_angle_deg: by_count(|part| part.bifurcation_angle_deg),
            upwards_angle_deg: by_count(|part| part.upwards_angle_deg),
        },
        orders: Orders {
            centrifugal: by_order(&parts),
        },
    };
    table.check()?;
    Ok(table)
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a mean of counts"
)]
fn whole(mean: f64) -> usize {
    mean.round() as usize
}

/// What branches of all models are like by order: lengths and angles count by how many branches a model has of it, radii by how long they are together.
/// Models count alike for how many branches there are, but none of an order that a model has is nothing.
fn by_order(parts: &[&Part]) -> Vec<OfOrder> {
    let most = parts.iter().map(|part| part.by_order.len()).max();
    let of = |place: usize| {
        let rows = || {
            parts
                .iter()
                .filter_map(move |part| part.by_order.get(place))
        };
        let branches = rows().fold(0, |all: usize, row| all.saturating_add(row.branches));
        let spread = |of: Option<MeanStd>, n: usize| Spread {
            n: if of.is_some() { n } else { 0 },
            mean: of.map_or(0.0, |of| of.mean),
            std: of.and_then(|of| of.std).unwrap_or(0.0),
            ..Spread::default()
        };
        let counted = |of: fn(&OfOrder) -> Option<MeanStd>| {
            together(rows().map(|row| (spread(of(row), row.branches), row.branches as f64)))
        };
        let long =
            |row: &OfOrder| row.branch_length.map_or(0.0, |of| of.mean) * row.branches as f64;
        let radius =
            together(rows().map(|row| (spread(row.point_radius, row.branches), long(row))));
        OfOrder {
            order: u32::try_from(place).unwrap_or(u32::MAX),
            branches: whole(branches as f64 / parts.len() as f64).max(1),
            branch_length: counted(|row| row.branch_length),
            point_radius: radius.map(|of| MeanStd { std: None, ..of }),
            bifurcation_angle_deg: counted(|row| row.bifurcation_angle_deg),
        }
    };
    (0..most.unwrap_or(0)).map(of).collect()
}

/// Mean and deviation of what spreads are of, each with how much it counts. None of nothing.
fn together(spreads: impl Iterator<Item = (Spread, f64)> + Clone) -> Option<MeanStd> {
    let spreads = spreads.filter(|(spread, weight)| spread.n > 0 && *weight > 0.0);
    let all: f64 = spreads.clone().map(|(_, weight)| weight).sum();
    if all <= 0.0 {
        return None;
    }
    let mean = spreads
        .clone()
        .map(|(spread, weight)| spread.mean * weight)
        .sum::<f64>()
        / all;
    let square = |(spread, weight): (Spread, f64)| {
        weight * (spread.std.powi(2) + (spread.mean - mean).powi(2))
    };
    let variance = spreads.map(square).sum::<f64>() / all;
    Some(MeanStd {
        mean,
        std: Some(variance.sqrt()),
    })
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "the table says it"
    )]
    use super::*;
    use crate::tree::measure::spread;
    use proptest::prelude::*;

    fn part(lengths: &[f64], centerlines: usize) -> Part {
        Part {
            centerlines,
            junctions: lengths.len() - centerlines,
            branches: lengths.len(),
            total_length: lengths.iter().sum(),
            stem_length: lengths[0],
            branch_length: spread(lengths.iter().copied()),
            point_radius: spread([lengths[0]]),
            centerline_length: spread([10.0, 12.0]),
            ..Part::default()
        }
    }

    #[test]
    fn counts_are_means_and_nothing_is_of_nothing() {
        let parts = [
            part(&[4.0, 2.0, 2.0], 2),
            part(&[4.0, 1.0, 1.0, 1.0, 1.0], 3),
        ];
        let table = pooled(&parts).unwrap();
        assert_eq!(table.counts.centerlines, Some(3)); // 2.5, rounded.
        assert_eq!(table.counts.junctions, Some(2));
        assert_eq!(table.counts.branches, Some(5));
        assert_eq!(table.table.bifurcation_angle_deg, None);
        assert!((table.table.stem_iterations.unwrap() - 4.0 / 2.0).abs() < 1e-12);
        assert!((table.table.iterations.unwrap().mean - (11.0 / 2.0 - 2.0)).abs() < 1e-12);
        assert!(pooled(&[]).is_err() && pooled(&[Part::default()]).is_err());
        // One model's is its own.
        let one = pooled(&parts[..1]).unwrap();
        assert_eq!(one.counts.branches, Some(3));
        assert_eq!(
            one.table.branch_length,
            Some(spread([4.0, 2.0, 2.0]).into())
        );
    }

    proptest! {
        #[test]
        fn pooled_spreads_are_those_of_all_values(
            groups in prop::collection::vec(prop::collection::vec(0.1..9.0_f64, 1..9), 1..6),
        ) {
            let parts: Vec<Part> = groups.iter().map(|lengths| part(lengths, 1)).collect();
            let found = pooled(&parts).unwrap().table.branch_length.unwrap();
            let all = spread(groups.concat());
            prop_assert!((found.mean - all.mean).abs() < 1e-9);
            prop_assert!((found.std.unwrap() - all.std).abs() < 1e-9);
        }
    }
}
