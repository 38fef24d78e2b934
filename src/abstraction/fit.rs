//! Parameters and seeds whose trees have a given table.
//!
//! Two kinds of parameters are found apart. How likely tips fork and how long they live decide, with the seed, what the tree is made of: how many tips and
//! junctions it has, and of what degree. These are drawn and adapted (population Monte Carlo; Cappé, Guillin, Marin and Robert 2004): half of
//! each round's candidates near those that were good, half anywhere. Lengths, radii and angles of the same seed change evenly with their
//! parameters, since what is drawn stays the same: so for each candidate with the right number of tips they are solved for, by Gauss's and Newton's method,
//! damped.
//!
//! Rounds are worked out in parallel and looked at in order, so one seed gives one result for any number of threads.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::difference::{Difference, differences, distance, weight};
use super::error::AbstractionError;
use super::grow::{Grower, grow};
use super::params::{ITERATIONS_MOST, Params};
use super::rules;
use super::table::Table;
use crate::lsystem::Limits;
use crate::tree::Tree;
use crate::tree::measure::Measures;
use crate::tree::solve::solve;

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
    /// One number for all of these.
    pub distance: f64,
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
/// Steps of solving at most, and what they are damped by.
const STEPS: usize = 8;
const DAMPING: [f64; 3] = [0.01, 0.3, 10.0];
/// What a number is changed by to see what follows, and by how much one step may change it.
const NUDGE: f64 = 0.02;
const STRIDE: f64 = 0.5;
/// Centerlines of a model at most.
const TIPS_MOST: usize = 10_000;
/// How many more modules than branches a string may have.
const MODULES: u64 = 100;

/// What is solved for: how it is read and written, and its limits. Lengths, radii and ratios by their logarithms, angles in radians.
type Number = (fn(&Params) -> f64, fn(&mut Params, f64), [f64; 2]);

const NUMBERS: [Number; 8] = [
    (
        |p| p.segment_length.ln(),
        |p, x| {
            let part = p.segment_length_std / p.segment_length;
            p.segment_length = x.exp();
            p.segment_length_std = part * p.segment_length;
        },
        [-40.0, 20.0],
    ),
    (
        |p| (p.segment_length_std / p.segment_length).max(0.02).ln(),
        |p, x| p.segment_length_std = x.exp() * p.segment_length,
        [-3.9, 0.7],
    ),
    (
        |p| p.length_ratio.ln(),
        |p, x| p.length_ratio = x.exp(),
        [-0.7, 0.7],
    ),
    (
        |p| p.segment_radius.ln(),
        |p, x| p.segment_radius = x.exp(),
        [-40.0, 20.0],
    ),
    (
        |p| p.radius_ratio.ln(),
        |p, x| p.radius_ratio = x.exp(),
        [-1.2, 0.4],
    ),
    (
        |p| p.bifurcation_angle.to_radians(),
        |p, x| p.bifurcation_angle = x.to_degrees(),
        [0.0, 1.57],
    ),
    (
        |p| p.bifurcation_angle_std.to_radians(),
        |p, x| p.bifurcation_angle_std = x.to_degrees(),
        [0.0, 1.2],
    ),
    (
        |p| p.upwards_angle_std.to_radians(),
        |p, x| p.upwards_angle_std = x.to_degrees(),
        [0.0, 0.6],
    ),
];

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
            .filter_map(|(_, params)| search.solved(params, cancel))
            .collect();
        if cancel.load(Ordering::Relaxed) && !ranked.is_empty() {
            break;
        }
        done = round.end;
        ranked.extend(solved);
        ranked.sort_by(|a, b| {
            a.distance
                .total_cmp(&b.distance)
                .then(a.params.seed.cmp(&b.params.seed))
        });
        ranked.truncate(params.ranked.max(ELITE));
        elite = ranked
            .iter()
            .take(ELITE)
            .map(|one| Form::of(&one.params))
            .collect();
        progress(done, params.candidates, &ranked);
    }
    ranked.truncate(params.ranked);
    for one in ranked.iter_mut().chain(&mut by_rules) {
        search.measure(one, cancel);
    }
    if ranked.is_empty() {
        return Err(if cancel.load(Ordering::Relaxed) {
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
        stopped: done < params.candidates,
    })
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
            Some(self.candidate(params, &tree))
        };
        let mut all: Vec<Candidate> = (0..RULED)
            .into_par_iter()
            .map_init(|| grower.clone(), ruled)
            .flatten()
            .collect();
        all.sort_by(|a, b| {
            let by_seed = a.params.seed.cmp(&b.params.seed);
            a.distance.total_cmp(&b.distance).then(by_seed)
        });
        let middle = all.len() / 2;
        (!all.is_empty()).then(|| all.swap_remove(middle))
    }

    fn candidate(&self, params: Params, tree: &Tree) -> Candidate {
        // How branches bend is not compared.
        let table = Table::of(&Measures::brief(tree));
        let differences = differences(self.target, &table);
        Candidate {
            params,
            segments: tree.segment_count(),
            distance: distance(&differences),
            differences,
            table,
        }
    }

    /// Measures what else its table has.
    fn measure(&self, candidate: &mut Candidate, cancel: &AtomicBool) {
        if let Ok(tree) = grow(&candidate.params, &self.limits, cancel) {
            candidate.table = Table::of(&Measures::whole(&tree));
        }
    }

    /// Draws a candidate. How far it is from what is wanted before anything was solved for; none where it has another number of tips.
    fn drawn(&self, number: u64, elite: &[Form], cancel: &AtomicBool) -> Option<(f64, Params)> {
        let mut random = Random::new(self.seed, number);
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
            + junctions.map_or(0.0, |one| (4.0 * one.relative).powi(2));
        Some((shape, candidate.params))
    }

    fn proposed(&self, random: &mut Random, elite: &[Form]) -> Params {
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
    fn solved(&self, params: Params, cancel: &AtomicBool) -> Option<Candidate> {
        let grown = |params: &Params| {
            let tree = grow(params, &self.limits, cancel).ok()?;
            Some(self.candidate(params.clone(), &tree))
        };
        let mut best = grown(&params)?;
        for _ in 0..STEPS {
            let from = residuals(&best);
            let mut slopes = Vec::with_capacity(NUMBERS.len());
            for (get, set, limits) in NUMBERS {
                let mut nudged = best.params.clone();
                let at = get(&nudged);
                let by = if at + NUDGE > limits[1] {
                    -NUDGE
                } else {
                    NUDGE
                };
                set(&mut nudged, at + by);
                let to = residuals(&grown(&nudged)?);
                slopes.push(
                    from.iter()
                        .zip(to)
                        .map(|(from, to)| (to - from) / by)
                        .collect::<Vec<f64>>(),
                );
            }
            let better = DAMPING.into_iter().find_map(|damping| {
                let moved = stepped(&best.params, &from, &slopes, damping)?;
                grown(&moved).filter(|moved| moved.distance < best.distance)
            });
            let Some(better) = better else {
                break;
            };
            let gained = best.distance - better.distance;
            best = better;
            if gained < 1e-3 * best.distance {
                break;
            }
        }
        Some(best)
    }
}

/// What is to become zero.
fn residuals(candidate: &Candidate) -> Vec<f64> {
    let all = candidate.differences.iter();
    all.map(|one| one.relative * weight(one)).collect()
}

/// Parameters one step of Gauss's and Newton's method on.
fn stepped(params: &Params, from: &[f64], slopes: &[Vec<f64>], damping: f64) -> Option<Params> {
    const N: usize = NUMBERS.len();
    let mut matrix = [[0.0; N]; N];
    let mut right = [0.0; N];
    for i in 0..N {
        for j in 0..N {
            matrix[i][j] = slopes[i].iter().zip(&slopes[j]).map(|(a, b)| a * b).sum();
        }
        right[i] = -slopes[i].iter().zip(from).map(|(a, b)| a * b).sum::<f64>();
        matrix[i][i] += damping * matrix[i][i] + 1e-6;
    }
    let step = solve(matrix, right)?;
    let mut moved = params.clone();
    for ((get, set, limits), step) in NUMBERS.into_iter().zip(step) {
        let to = get(&moved) + step.clamp(-STRIDE, STRIDE);
        set(&mut moved, to.clamp(limits[0], limits[1]));
    }
    Some(moved)
}

/// Seeds are told in files: numbers that all programs read exactly.
const SEEDS: u64 = (1 << 32) - 1;

/// Random numbers of one candidate (SplitMix64; Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn new(seed: u64, number: u64) -> Self {
        let mut random = Self(seed ^ number.wrapping_mul(0xD134_2543_DE82_EF95));
        random.next();
        random
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^ (bits >> 31)
    }

    fn uniform(&mut self, from: f64, to: f64) -> f64 {
        let part = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        from + part * (to - from)
    }
}
