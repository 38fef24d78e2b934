//! A fit as `ramus-abstraction/1`.

use std::collections::BTreeMap;

use serde::Serialize;

use super::by_order::OrderDifference;
use super::difference::Difference;
use super::fit::{Candidate, Fit};
use super::params::Params;
use super::table::{Counts, Quantities, Table};

/// All that is told of a fit.
#[derive(Debug, Serialize)]
pub struct Told<'a> {
    format: &'static str,
    target: &'a Table,
    source_rules: Rules<'a>,
    best: Option<Best<'a>>,
    ranked: Vec<Ranked>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    variants: Vec<Ranked>,
    /// How many models the target was pooled of.
    #[serde(skip_serializing_if = "Option::is_none")]
    models: Option<usize>,
    candidates: usize,
    seconds: f64,
}

#[derive(Debug, Serialize)]
struct Rules<'a> {
    parameters: &'a Params,
    typical: Option<&'a Table>,
    segments: Option<usize>,
    distance: Option<f64>,
    differences: BTreeMap<&'static str, &'a Difference>,
}

#[derive(Debug, Serialize)]
struct Best<'a> {
    seed: u64,
    parameters: &'a Params,
    counts: Counts,
    segments: usize,
    table: Quantities,
    distance: f64,
    differences: BTreeMap<&'static str, &'a Difference>,
    #[serde(skip_serializing_if = "<[OrderDifference]>::is_empty")]
    by_order: &'a [OrderDifference],
}

#[derive(Debug, Serialize)]
struct Ranked {
    seed: u64,
    distance: f64,
    counts: Counts,
}

impl<'a> Told<'a> {
    /// What is told of a fit of a table that took so many seconds.
    pub fn new(target: &'a Table, fit: &'a Fit, seconds: f64) -> Self {
        let by_name = |one: &'a Candidate| -> BTreeMap<_, _> {
            let all = one.differences.iter();
            all.map(|one| (one.name, one)).collect()
        };
        let best = |one: &'a Candidate| Best {
            seed: one.params.seed,
            parameters: &one.params,
            counts: one.table.counts,
            segments: one.segments,
            table: one.table.table,
            distance: one.distance,
            differences: by_name(one),
            by_order: &one.by_order,
        };
        let ruled = fit.by_rules.as_ref();
        Self {
            format: "ramus-abstraction/1",
            target,
            source_rules: Rules {
                parameters: &fit.rules,
                typical: ruled.map(|one| &one.table),
                segments: ruled.map(|one| one.segments),
                distance: ruled.map(|one| one.distance),
                differences: ruled.map(by_name).unwrap_or_default(),
            },
            best: fit.ranked.first().map(best),
            ranked: fit.ranked.iter().map(ranked).collect(),
            variants: Vec::new(),
            models: None,
            candidates: fit.candidates,
            seconds,
        }
    }

    /// With trees of the best one's parameters and other seeds.
    #[must_use]
    pub fn with_variants(mut self, variants: &[Candidate]) -> Self {
        self.variants = variants.iter().map(ranked).collect();
        self
    }

    /// With how many models the target was pooled of.
    #[must_use]
    pub fn of_models(mut self, models: Option<usize>) -> Self {
        self.models = models;
        self
    }
}

fn ranked(one: &Candidate) -> Ranked {
    Ranked {
        seed: one.params.seed,
        distance: one.distance,
        counts: one.table.counts,
    }
}
