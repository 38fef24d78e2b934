//! Lengths, radii and angles of a tree, solved for by Gauss's and Newton's method, damped: with the same seed they change evenly with their parameters.

use super::by_order::ByOrder;
use super::fit::Candidate;
use super::params::Params;
use crate::tree::solve::solve;

/// Steps at most for whole trees, and for their orders, which are more numbers; and what they are damped by.
pub(super) const STEPS: [usize; 2] = [8, 16];
const DAMPING: [f64; 3] = [0.01, 0.3, 10.0];
/// What a number is changed by to see what follows, and by how much one step may change it.
const NUDGE: f64 = 0.02;
const STRIDE: f64 = 0.5;
/// Orders that have numbers of their own at most: those beyond are as the last.
pub(super) const ORDERS: usize = 12;
/// Numbers that are solved for at once at most.
const MOST: usize = 3 + 3 * ORDERS;
/// A step that gains less than this part of the distance is the last.
const GAIN_LEAST: f64 = 1e-3;

/// One number of the parameters: how it is read and written, and its limits. Lengths, radii and factors by their logarithms, angles in radians.
type Number = (fn(&Params) -> f64, fn(&mut Params, f64), [f64; 2]);

/// What is solved for.
#[derive(Clone, Copy)]
pub(super) enum Unknown {
    /// One number.
    One(Number),
    /// The logarithm of the factor of an order.
    OfOrder(ByOrder, usize),
}

/// How much it counts that radii of orders do not change evenly. A branch's first segment tapers from what it grows from, so that a radius is known as little more
/// than as the mean of two orders': without this they would be thick and thin by turns.
const EVENLY: f64 = 0.03;

/// How unevenly radii change from order to order: what is to become zero, too.
fn uneven(params: &Params) -> impl Iterator<Item = f64> {
    params.radius_by_order.windows(3).map(|radii| {
        let [a, b, c] = [radii[0], radii[1], radii[2]].map(f64::ln);
        EVENLY * (a - 2.0 * b + c)
    })
}

/// What is to become zero of a candidate.
fn residuals(of: &Candidate) -> Vec<f64> {
    of.residuals().chain(uneven(&of.params)).collect()
}

/// The sum of their squares.
fn far(of: &Candidate) -> f64 {
    residuals(of).iter().map(|one| one * one).sum()
}

/// Factors of an order, by their logarithms: what they may be.
const FACTORS: [f64; 2] = [-6.9, 6.9];

const LENGTH: Number = (
    |p| p.segment_length.ln(),
    |p, x| {
        let part = p.segment_length_std / p.segment_length;
        p.segment_length = x.exp();
        p.segment_length_std = part * p.segment_length;
    },
    [-40.0, 20.0],
);
const LENGTH_STD: Number = (
    |p| (p.segment_length_std / p.segment_length).max(0.02).ln(),
    |p, x| p.segment_length_std = x.exp() * p.segment_length,
    [-3.9, 0.7],
);
const LENGTH_RATIO: Number = (
    |p| p.length_ratio.ln(),
    |p, x| p.length_ratio = x.exp(),
    [-0.7, 0.7],
);
const RADIUS: Number = (
    |p| p.segment_radius.ln(),
    |p, x| p.segment_radius = x.exp(),
    [-40.0, 20.0],
);
const RADIUS_RATIO: Number = (
    |p| p.radius_ratio.ln(),
    |p, x| p.radius_ratio = x.exp(),
    [-1.2, 0.4],
);
const ANGLE: Number = (
    |p| p.bifurcation_angle.to_radians(),
    |p, x| p.bifurcation_angle = x.to_degrees(),
    [0.0, 1.57],
);
const ANGLE_STD: Number = (
    |p| p.bifurcation_angle_std.to_radians(),
    |p, x| p.bifurcation_angle_std = x.to_degrees(),
    [0.0, 1.2],
);
const UPWARDS_STD: Number = (
    |p| p.upwards_angle_std.to_radians(),
    |p, x| p.upwards_angle_std = x.to_degrees(),
    [0.0, 0.6],
);

/// Numbers of whole trees: orders differ by a ratio each.
pub(super) const OF_TREES: [Unknown; 8] = [
    Unknown::One(LENGTH),
    Unknown::One(LENGTH_STD),
    Unknown::One(LENGTH_RATIO),
    Unknown::One(RADIUS),
    Unknown::One(RADIUS_RATIO),
    Unknown::One(ANGLE),
    Unknown::One(ANGLE_STD),
    Unknown::One(UPWARDS_STD),
];

/// Numbers of so many orders, each with a length, a radius and an angle of its own.
pub(super) fn of_orders(orders: usize) -> Vec<Unknown> {
    let mut all = vec![
        Unknown::One(LENGTH_STD),
        Unknown::One(ANGLE_STD),
        Unknown::One(UPWARDS_STD),
    ];
    for order in 0..orders.min(ORDERS) {
        all.extend([ByOrder::Length, ByOrder::Radius].map(|of| Unknown::OfOrder(of, order)));
        // The stem leaves no junction.
        if order > 0 {
            all.push(Unknown::OfOrder(ByOrder::Angle, order));
        }
    }
    all
}

impl Unknown {
    fn get(self, params: &Params) -> f64 {
        match self {
            Self::One((get, ..)) => get(params),
            Self::OfOrder(of, order) => of.factors(params).get(order).map_or(0.0, |one| one.ln()),
        }
    }

    fn set(self, params: &mut Params, to: f64) {
        let to = to.clamp(self.limits()[0], self.limits()[1]);
        match self {
            Self::One((_, set, _)) => set(params, to),
            Self::OfOrder(of, order) => {
                if let Some(factor) = of.factors_mut(params).get_mut(order) {
                    *factor = to.exp();
                }
            }
        }
    }

    fn limits(self) -> [f64; 2] {
        match self {
            Self::One((.., limits)) => limits,
            Self::OfOrder(..) => FACTORS,
        }
    }
}

/// A candidate whose numbers are solved for, from where they are, in so many steps at most. `grown` makes candidates of parameters; none where the first or a nudged one does not
/// grow.
pub(super) fn solved(
    start: &Params,
    unknowns: &[Unknown],
    steps: usize,
    grown: impl Fn(&Params) -> Option<Candidate>,
) -> Option<Candidate> {
    let mut best = grown(start)?;
    for _ in 0..steps {
        let from = residuals(&best);
        let mut slopes = Vec::with_capacity(unknowns.len());
        for unknown in unknowns {
            let mut nudged = best.params.clone();
            let at = unknown.get(&nudged);
            let by = match at + NUDGE > unknown.limits()[1] {
                true => -NUDGE,
                false => NUDGE,
            };
            unknown.set(&mut nudged, at + by);
            let to = residuals(&grown(&nudged)?);
            let slope = |(from, to): (&f64, f64)| (to - from) / by;
            slopes.push(from.iter().zip(to).map(slope).collect::<Vec<f64>>());
        }
        let better = DAMPING.into_iter().find_map(|damping| {
            let moved = stepped(&best.params, unknowns, &from, &slopes, damping)?;
            // No number that matched is given up for others.
            grown(&moved)
                .filter(|moved| far(moved) < far(&best) && moved.matching() >= best.matching())
        });
        let Some(better) = better else {
            break;
        };
        let gained = 1.0 - (far(&better) / far(&best)).sqrt();
        best = better;
        if gained < GAIN_LEAST {
            break;
        }
    }
    Some(best)
}

/// Parameters one step of Gauss's and Newton's method on.
fn stepped(
    params: &Params,
    unknowns: &[Unknown],
    from: &[f64],
    slopes: &[Vec<f64>],
    damping: f64,
) -> Option<Params> {
    // Rows that nothing is solved for in are those of the identity.
    let mut matrix = [[0.0; MOST]; MOST];
    let mut right = [0.0; MOST];
    for (i, row) in matrix.iter_mut().enumerate() {
        let Some(slope) = slopes.get(i) else {
            row[i] = 1.0;
            continue;
        };
        for (cell, other) in row.iter_mut().zip(slopes) {
            *cell = slope.iter().zip(other).map(|(a, b)| a * b).sum();
        }
        right[i] = -slope.iter().zip(from).map(|(a, b)| a * b).sum::<f64>();
        row[i] += damping * row[i] + 1e-6;
    }
    let step = solve(matrix, right)?;
    let mut moved = params.clone();
    for (unknown, step) in unknowns.iter().zip(step) {
        let to = unknown.get(&moved) + step.clamp(-STRIDE, STRIDE);
        unknown.set(&mut moved, to);
    }
    Some(moved)
}
