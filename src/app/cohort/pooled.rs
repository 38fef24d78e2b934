//! A cohort as one table, to make an L-system of.

use super::Cohort;
use super::told::{Branch, Centrifugal, Facts, MeanStd, Spread};
use crate::abstraction::{self, OfOrder, Part};
use crate::tree::measure::Spread as Known;

/// What an abstraction takes of each model that was analyzed.
pub fn parts(cohort: &Cohort) -> Vec<Part> {
    let facts = cohort.models.iter().filter_map(super::Model::facts);
    facts.map(part).collect()
}

fn part(facts: &Facts) -> Part {
    let table = &facts.table;
    let lengths = facts.branches.iter().filter_map(|one: &Branch| one.length);
    Part {
        centerlines: facts.counts.tips,
        junctions: facts.counts.junctions,
        branches: facts.counts.branches,
        total_length: lengths.sum(),
        stem_length: table.stem_length.unwrap_or(0.0),
        branch_length: known(table.branch_length),
        point_radius: known(table.point_radius),
        centerline_length: known(table.centerline_length),
        bifurcation_angle_deg: known(table.bifurcation_angle_deg),
        upwards_angle_deg: of_all(table.upwards_angle_deg, facts.counts.branches),
        by_order: by_order(&facts.orders.centrifugal),
    }
}

/// What is known of orders, from 0 on, up to the first that is not in its place.
fn by_order(rows: &[Centrifugal]) -> Vec<OfOrder> {
    let known = |mean: Option<f64>, std| mean.map(|mean| abstraction::MeanStd { mean, std });
    let of = |row: &Centrifugal| OfOrder {
        order: row.order,
        branches: row.branches,
        branch_length: known(row.branch_length.mean, row.branch_length.std),
        point_radius: known(row.point_radius.mean, None),
        bifurcation_angle_deg: row
            .bifurcation_angle_deg
            .and_then(|angle| known(angle.mean, angle.std)),
    };
    let in_place = (0..)
        .zip(rows)
        .take_while(|(place, row)| row.order == *place);
    in_place.map(|(_, row)| of(row)).collect()
}

/// A spread whose numbers are there; else one of nothing.
fn known(spread: Spread) -> Known {
    match (spread.mean, spread.std) {
        (Some(mean), Some(std)) => Known {
            n: spread.n,
            mean,
            std,
            ..Known::default()
        },
        _ => Known::default(),
    }
}

fn of_all(of: MeanStd, n: usize) -> Known {
    known(Spread {
        n,
        mean: of.mean,
        std: of.std,
        ..Spread::default()
    })
}
