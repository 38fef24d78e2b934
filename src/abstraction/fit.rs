//! Parameters and seeds whose trees have a given table.
//!
//! Two kinds of parameters are found apart. How likely tips fork and how long they live decide, with the seed, what the tree is made of: how many tips and
//! junctions it has, and of what degree. These are drawn and adapted (population Monte Carlo; Cappé, Guillin, Marin and Robert 2004): half of
//! each round's candidates near those that were good, half anywhere. Lengths, radii and angles of the same seed change evenly with their
//! parameters, since what is drawn stays the same: so for each candidate with the right number of tips they are solved for ([`super::solving`]). Where the model's
//! branches are known by order, those that are the best in the end get lengths, radii and angles of each order.
//!
//! Rounds are worked out in parallel and looked at in order, so one seed gives one result for any number of threads.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::by_order::{self, ByOrder, OrderDifference};
use super::difference::{Difference, differences, distance, residuals};
use super::error::AbstractionError;
use super::grow::{Grower, grow};
use super::params::{ITERATIONS_MOST, Params};
use super::rules;
use super::solving::{OF_TREES, ORDERS, STEPS, of_orders, solved};
use super::table::Table;
use crate::lsystem::Limits;
use crate::tree::Tree;
use crate::tree::draws::Draws;
use crate::tree::measure::Measures;

/// How a fit is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FitParams {
    /// Trees that are drawn.
    pub candidates: usize,
    /// One seed gives one fit.
    pub seed: u64,
    /// How many of the best are told.
    pub ranked: usize,
}

impl Default for FitParams {
    fn default() -> Self {
        Self {
            candidates: 20_000,
            seed: 0,
            ranked: 10,
        }
    }
}

/// A tree that is like the model.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// What it grows from.
    pub params: Params,
    /// What `ramus analyze` measures of it.
    pub table: Table,
    /// Segments, which the source counts as branches.
    pub segments: usize,
    /// How each number differs from the model's.
    pub differences: Vec<Difference>,
    /// How numbers of its orders differ, where the model's are known.
    pub by_order: Vec<OrderDifference>,
    /// Which part of its branches is of other orders than the model's.
    pub misplaced: f64,
    /// One number for all of these.
    pub distance: f64,
}

impl Candidate {
    /// Of a tree with so many segments and this table.
    pub(super) fn new(params: Params, segments: usize, table: Table, target: &Table) -> Self {
        let orders = [target, &table].map(|one| one.orders.centrifugal.as_slice());
        let by_order = by_order::differences(orders);
        Self::of(params, segments, by_order, table, target)
    }

    /// The same as a search has it that knows of orders only how many branches they have.
    fn roughly(params: Params, segments: usize, table: Table, target: &Table) -> Self {
        Self::of(params, segments, Vec::new(), table, target)
    }

    fn of(
        params: Params,
        segments: usize,
        by_order: Vec<OrderDifference>,
        table: Table,
        target: &Table,
    ) -> Self {
        let differences = differences(target, &table);
        let misplaced =
            by_order::misplaced([target, &table].map(|one| one.orders.centrifugal.as_slice()));
        Self {
            params,
            segments,
            distance: distance(&differences, &by_order, misplaced),
            differences,
            by_order,
            misplaced,
            table,
        }
    }

    /// How many of its numbers match.
    pub fn matching(&self) -> usize {
        self.differences.iter().filter(|one| one.matches()).count()
    }

    /// What is to become zero.
    pub(super) fn residuals(&self) -> impl Iterator<Item = f64> {
        residuals(&self.differences, &self.by_order)
    }
}

/// What came of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The best, the nearest first.
    pub ranked: Vec<Candidate>,
    /// Parameters by the source's own rules.
    pub rules: Params,
    /// What they make of the table: the middle one of some trees. None where all of them grow beyond bounds.
    pub by_rules: Option<Candidate>,
    /// How many trees were drawn.
    pub candidates: usize,
    /// Whether it was stopped before all were.
    pub stopped: bool,
}

/// Candidates of a round.
const ROUND: usize = 500;
/// Of these so many are solved for.
const SOLVED: usize = 24;
/// Good ones that later rounds draw near to.
const ELITE: usize = 24;
/// Draws of the source's rules, of which the one in the middle is told.
const RULED: u64 = 101;
/// Factors of orders that are begun with, at least and at most: ratios of many orders come to nothing.
const FACTORS: [f64; 2] = [0.01, 100.0];
/// Centerlines of a model at most.
const TIPS_MOST: usize = 10_000;
/// How many more modules than branches a string may have.
const MODULES: u64 = 100;

/// Finds trees with a model's table. `progress` gets how many candidates are done, of how many, and the best so far, the nearest first.
///
/// # Errors
/// A table that no tree of this kind can have. Where `cancel` is set what was found until then is given, if anything was.
pub fn fit(
    target: &Table,
    params: &FitParams,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(usize, usize, &[Candidate]),
) -> Result<Fit, AbstractionError> {
    let search = Search::new(target, params)?;
    let mut by_rules = search.by_rules(cancel);
    let mut ranked: Vec<Candidate> = Vec::new();
    let mut elite: Vec<Form> = Vec::new();
    let mut done = 0;
    progress(0, params.candidates, &[]);
    while done < params.candidates && !cancel.load(Ordering::Relaxed) {
        let round = done..(done + ROUND).min(params.candidates);
        let mut drawn: Vec<(f64, Params)> = round
            .clone()
            .into_par_iter()
            .filter_map(|number| search.drawn(number as u64, &elite, cancel))
            .collect();
        drawn.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.seed.cmp(&b.1.seed)));
        drawn.truncate(SOLVED);
        let solved: Vec<Candidate> = drawn
            .into_par_iter()
            .filter_map(|(_, params)| search.solved(&params, cancel))
            .collect();
        if cancel.load(Ordering::Relaxed) && !ranked.is_empty() {
            break;
        }
        done = round.end;
        ranked.extend(solved);
        sort(&mut ranked);
        ranked.truncate(params.ranked.max(ELITE));
        elite = ranked
            .iter()
            .take(ELITE)
            .map(|one| Form::of(&one.params))
            .collect();
        progress(done, params.candidates, &ranked);
    }
    let orders: Vec<Candidate> = ranked
        .par_iter()
        .map(|one| search.by_order(one.clone(), cancel))
        .collect();
    // Where it was stopped some lack what orders are like: none has it then.
    let stopped = cancel.load(Ordering::Relaxed);
    if !stopped {
        ranked = orders;
        sort(&mut ranked);
        progress(done, params.candidates, &ranked);
    }
    ranked.truncate(params.ranked);
    for one in ranked.iter_mut().chain(&mut by_rules) {
        search.measure(one, cancel);
    }
    if ranked.is_empty() {
        return Err(if stopped {
            AbstractionError::Cancelled
        } else {
            AbstractionError::Table(format!(
                "none of {done} trees has {} centerlines: draw more of them (--candidates)",
                search.tips
            ))
        });
    }
    Ok(Fit {
        ranked,
        rules: search.rules,
        by_rules,
        candidates: done,
        stopped: stopped || done < params.candidates,
    })
}

/// The nearest first.
pub(super) fn sort(candidates: &mut [Candidate]) {
    candidates.sort_by(|a, b| {
        let by_seed = a.params.seed.cmp(&b.params.seed);
        a.distance.total_cmp(&b.distance).then(by_seed)
    });
}

/// What decides of what a tree is made.
#[derive(Clone, Copy, Debug)]
struct Form {
    bifurcation: f64,
    trifurcation: f64,
    iterations: f64,
    iterations_std: f64,
    side_life: f64,
    stem: f64,
}

impl Form {
    fn of(params: &Params) -> Self {
        Self {
            bifurcation: params.bifurcation_probability,
            trifurcation: params.trifurcation_probability,
            iterations: params.iterations,
            iterations_std: params.iterations_std,
            side_life: params.side_life,
            stem: f64::from(params.stem_length),
        }
    }
}

/// A search under way.
struct Search<'a> {
    target: &'a Table,
    /// By the source's rules.
    rules: Params,
    tips: usize,
    /// How likely a fork has three branches, from the counts.
    three: f64,
    seed: u64,
    limits: Limits,
}

impl<'a> Search<'a> {
    fn new(target: &'a Table, params: &FitParams) -> Result<Self, AbstractionError> {
        let tips = target.counts.centerlines.unwrap_or(0);
        if tips > TIPS_MOST {
            return Err(AbstractionError::Table(format!(
                "it has {tips} centerlines: an L-system is made of {TIPS_MOST} at most"
            )));
        }
        if tips < 2 {
            return Err(AbstractionError::Table(format!(
                "it has {tips} centerlines: there are no forks to make an L-system of, which takes 2 centerlines or more"
            )));
        }
        let rules = rules::params(target, params.seed);
        rules.check()?;
        // Each fork of two makes one tip more, each of three two.
        let three = target.counts.junctions.map_or(0.0, |junctions| {
            let more = (tips - 1).saturating_sub(junctions);
            more as f64 / junctions.max(1) as f64
        });
        let modules = MODULES * tips as u64 + 10 * u64::from(super::params::STEM_MOST);
        Ok(Self {
            target,
            rules,
            tips,
            three: three.min(1.0),
            seed: params.seed,
            limits: Limits {
                modules,
                bytes: 1 << 30,
            },
        })
    }

    /// The middle one of trees by the source's rules.
    fn by_rules(&self, cancel: &AtomicBool) -> Option<Candidate> {
        let grower = Grower::new(&self.rules).ok()?;
        let ruled = |grower: &mut Grower, number| {
            let seed = self.seed.wrapping_add(number) & SEEDS;
            let tree = grower.tree(seed, &self.limits, cancel).ok()?;
            let params = Params {
                seed,
                ..self.rules.clone()
            };
            let segments = tree.segment_count();
            Some(Candidate::new(params, segments, brief(&tree), self.target))
        };
        let mut all: Vec<Candidate> = (0..RULED)
            .into_par_iter()
            .map_init(|| grower.clone(), ruled)
            .flatten()
            .collect();
        sort(&mut all);
        let middle = all.len() / 2;
        (!all.is_empty()).then(|| all.swap_remove(middle))
    }

    fn candidate(&self, params: Params, tree: &Tree) -> Candidate {
        Candidate::roughly(params, tree.segment_count(), brief(tree), self.target)
    }

    /// The candidate with what its orders are like.
    fn with_orders(&self, params: &Params, cancel: &AtomicBool) -> Option<Candidate> {
        let tree = grow(params, &self.limits, cancel).ok()?;
        let segments = tree.segment_count();
        Some(Candidate::new(
            params.clone(),
            segments,
            brief(&tree),
            self.target,
        ))
    }

    /// Measures what else its table has.
    fn measure(&self, candidate: &mut Candidate, cancel: &AtomicBool) {
        if let Ok(tree) = grow(&candidate.params, &self.limits, cancel) {
            candidate.table = Table::of(&Measures::whole(&tree));
        }
    }

    /// Draws a candidate. How far it is from what is wanted before anything was solved for; none where it has another number of tips.
    fn drawn(&self, number: u64, elite: &[Form], cancel: &AtomicBool) -> Option<(f64, Params)> {
        let mut random = Draws::new(self.seed, number);
        let params = self.proposed(&mut random, elite);
        // Some tips die before they have grown: they are tips of the string alone.
        let most = self.tips + self.tips / 2 + 2;
        let mut grower = Grower::new(&params).ok()?;
        let tree = grower
            .up_to([usize::MAX, most], params.seed, &self.limits, cancel)
            .ok()??;
        if tree.tips().len() != self.tips {
            return None;
        }
        let candidate = self.candidate(params, &tree);
        // Lengths by each other: that all are longer is solved for.
        let (got, wanted) = (candidate.table.table, self.target.table);
        let far = |of: fn(&super::table::Quantities) -> Option<f64>| match (of(&wanted), of(&got)) {
            (Some(wanted), Some(got)) => ((got - wanted) / wanted.abs().max(1e-9)).powi(2),
            _ => 0.0,
        };
        let junctions = candidate
            .differences
            .iter()
            .find(|one| one.name == "junctions");
        let shape = far(|one| Some(one.centerline_length?.mean / one.branch_length?.mean))
            + far(|one| Some(one.centerline_length?.std? / one.branch_length?.mean))
            + junctions.map_or(0.0, |one| (4.0 * one.relative).powi(2))
            + candidate.misplaced.powi(2);
        Some((shape, candidate.params))
    }

    fn proposed(&self, random: &mut Draws, elite: &[Form]) -> Params {
        let near = random.uniform(0.0, 1.0) < 0.5 && !elite.is_empty();
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "one of a few"
        )]
        let form = if near {
            let one = elite
                [((random.uniform(0.0, 1.0) * elite.len() as f64) as usize).min(elite.len() - 1)];
            Form {
                bifurcation: one.bifurcation + random.uniform(-0.08, 0.08),
                trifurcation: one.trifurcation * random.uniform(0.7, 1.4),
                iterations: one.iterations * random.uniform(0.85, 1.18),
                iterations_std: one.iterations_std * random.uniform(0.8, 1.25),
                side_life: one.side_life * random.uniform(0.8, 1.25),
                stem: one.stem + random.uniform(-0.8, 0.8),
            }
        } else {
            let iterations = self.rules.iterations * random.uniform(-0.7, 1.1).exp();
            Form {
                bifurcation: random.uniform(0.4, 1.0),
                trifurcation: self.three * random.uniform(0.5, 1.5),
                iterations,
                iterations_std: iterations * random.uniform(0.0, 1.0),
                side_life: random.uniform(0.05, 1.2),
                stem: f64::from(self.rules.stem_length) * random.uniform(0.5, 1.1),
            }
        };
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of segments"
        )]
        let stem = form
            .stem
            .round()
            .clamp(0.0, f64::from(super::params::STEM_MOST)) as u32;
        Params {
            bifurcation_probability: form.bifurcation.clamp(0.05, 1.0),
            trifurcation_probability: form.trifurcation.clamp(0.0, 1.0),
            iterations: form.iterations.clamp(1.0, ITERATIONS_MOST),
            iterations_std: form.iterations_std.clamp(0.0, ITERATIONS_MOST),
            side_life: form.side_life.clamp(0.0, 1.0),
            stem_length: stem,
            radial_increment: 0.0,
            around: true,
            roll_range: 20,
            upwards_angle: 0.0,
            bifurcation_angle_std: 10.0,
            radius_ratio: 0.9,
            seed: random.next() & SEEDS,
            ..self.rules.clone()
        }
    }

    /// A candidate whose lengths, radii and angles are solved for.
    fn solved(&self, params: &Params, cancel: &AtomicBool) -> Option<Candidate> {
        solved(params, &OF_TREES, STEPS[0], |params| {
            let tree = grow(params, &self.limits, cancel).ok()?;
            Some(self.candidate(params.clone(), &tree))
        })
    }

    /// The same candidate, and with numbers of its own for each order that the model has where that brings it nearer.
    fn by_order(&self, one: Candidate, cancel: &AtomicBool) -> Candidate {
        let orders = self.target.orders.centrifugal.len().min(ORDERS);
        if orders == 0 {
            return one;
        }
        let mut params = one.params.clone();
        let ratios = [
            (ByOrder::Length, params.length_ratio),
            (ByOrder::Radius, params.radius_ratio),
            (ByOrder::Angle, 1.0),
        ];
        for (of, ratio) in ratios {
            // The stem is as the first order behind it.
            let factors = (0..orders).map(|order| {
                let factor = ratio.powf(order.saturating_sub(1) as f64);
                factor.clamp(FACTORS[0], FACTORS[1])
            });
            *of.factors_mut(&mut params) = factors.collect();
        }
        (params.length_ratio, params.radius_ratio) = (1.0, 1.0);
        let Some(one) = self.with_orders(&one.params, cancel) else {
            return one;
        };
        let unknowns = of_orders(orders);
        match solved(&params, &unknowns, STEPS[1], |params| {
            self.with_orders(params, cancel)
        }) {
            Some(better)
                if better.distance < one.distance && better.matching() >= one.matching() =>
            {
                better
            }
            _ => one,
        }
    }
}

/// What is compared of a tree: not how branches bend.
fn brief(tree: &Tree) -> Table {
    Table::of(&Measures::brief(tree))
}

/// Seeds are told in files: numbers that all programs read exactly.
const SEEDS: u64 = (1 << 32) - 1;
