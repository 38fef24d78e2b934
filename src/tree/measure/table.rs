//! The table that models are compared by, with the distributions behind it.

use glam::DVec3;

use super::branch::{Branch, position};
use super::junction::Junction;
use super::statistics::{Spread, spread};
use crate::tree::Tree;

/// Points to the smallest radius.
const PER_RADIUS: f64 = 4.0;
/// Points at most.
const POINTS_MOST: f64 = 1e6;

/// The source papers' quantities. Lengths are in the tree's unit, angles in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Table {
    /// Lengths of branches.
    pub branch_length: Spread,
    /// Radii at points spread equally along branches, a quarter of the smallest radius apart.
    pub point_radius: Spread,
    /// Lengths of the ways from root to tip.
    pub centerline_length: Spread,
    /// From the root to the first junction.
    pub stem_length: f64,
    /// The same in mean branch lengths.
    pub stem_iterations: f64,
    /// Mean of (centerline length less stem length) over mean branch length, and the standard deviation of centerline length over it.
    pub iterations: [f64; 2],
    /// Angles between daughters, in space.
    pub bifurcation_angle: Spread,
    /// Angles between daughters within the plane in which they branch.
    pub in_plane_angle: Spread,
    /// Angle between the tangents at a branch's ends, above zero where the end is nearer to the stem's direction, over its length in mean
    /// branch lengths.
    pub upwards_angle: Spread,
    /// Mean curvatures of branches.
    pub curvature: Spread,
    /// Mean torsions of branches that have one.
    pub torsion: Spread,
    /// Tortuosities of branches: length over chord, less 1.
    pub tortuosity: Spread,
}

/// What a table is made of.
pub(super) struct Parts {
    /// Of each branch.
    pub(super) lengths: Vec<f64>,
    /// Of each branch, where it begins and ends.
    pub(super) tangents: Vec<[DVec3; 2]>,
    pub(super) point_radius: Spread,
    pub(super) centerline_length: Spread,
    /// Which branch is the stem.
    pub(super) stem: Option<usize>,
    pub(super) angles: Spread,
    pub(super) in_plane: Spread,
    pub(super) curvature: Spread,
    pub(super) torsion: Spread,
    pub(super) tortuosity: Spread,
}

impl Parts {
    pub(super) fn table(self) -> Table {
        let branch_length = spread(self.lengths.iter().copied());
        let per_branch = |length: f64| {
            if branch_length.mean > 0.0 {
                length / branch_length.mean
            } else {
                0.0
            }
        };
        let stem_length = self.stem.map_or(0.0, |stem| self.lengths[stem]);
        let stem = self.stem.map_or(DVec3::ZERO, |stem| self.tangents[stem][0]);
        let upwards = |([start, end], length): (&[DVec3; 2], &f64)| {
            let turned = start.cross(*end).length().atan2(start.dot(*end));
            turned * (end.dot(stem) - start.dot(stem)).signum() / per_branch(*length)
        };
        Table {
            branch_length,
            point_radius: self.point_radius,
            centerline_length: self.centerline_length,
            stem_length,
            stem_iterations: per_branch(stem_length),
            iterations: [
                per_branch(self.centerline_length.mean) - per_branch(stem_length),
                per_branch(self.centerline_length.std),
            ],
            bifurcation_angle: self.angles,
            in_plane_angle: self.in_plane,
            upwards_angle: spread(self.tangents.iter().zip(&self.lengths).map(upwards)),
            curvature: self.curvature,
            torsion: self.torsion,
            tortuosity: self.tortuosity,
        }
    }
}

/// The table of whole branches.
pub(super) fn table(tree: &Tree, branches: &[Branch], junctions: &[Junction]) -> Table {
    let to_end = lengths_to_end(branches);
    let tips = branches
        .iter()
        .zip(&to_end)
        .filter(|(branch, _)| branch.is_tip);
    Parts {
        lengths: branches.iter().map(|branch| branch.length).collect(),
        tangents: branches.iter().map(|branch| branch.tangents).collect(),
        point_radius: spread_of_runs(&runs_of(tree, branches)),
        centerline_length: spread(tips.map(|(_, length)| *length)),
        stem: stem(branches),
        angles: spread(junctions.iter().flat_map(|one| one.angles.iter().copied())),
        in_plane: spread(
            junctions
                .iter()
                .flat_map(|one| one.in_plane.iter().copied()),
        ),
        curvature: spread(branches.iter().map(|branch| branch.curvature)),
        torsion: spread(branches.iter().filter_map(|branch| branch.torsion)),
        tortuosity: spread(branches.iter().map(Branch::tortuosity)),
    }
    .table()
}

/// How far each branch's end is from its root.
pub(super) fn lengths_to_end(branches: &[Branch]) -> Vec<f64> {
    let mut to_end = vec![0.0; branches.len()];
    for (place, branch) in branches.iter().enumerate() {
        to_end[place] = branch.length + branch.parent.map_or(0.0, |parent| to_end[parent]);
    }
    to_end
}

/// The branch that is the stem: the first, if its root does not fork at once.
fn stem(branches: &[Branch]) -> Option<usize> {
    let first = branches.first()?;
    let of_root = branches
        .iter()
        .filter(|branch| branch.parent.is_none() && branch.ends()[0] == first.ends()[0]);
    (of_root.count() == 1).then_some(0)
}

/// How radii are spread at equally spaced points of lines; `smallest` are their smallest radii, `total` is the length of all.
pub(super) fn point_radii<L: IntoIterator<Item = (DVec3, f64)>>(
    lines: impl IntoIterator<Item = L>,
    smallest: impl Iterator<Item = f64>,
    total: f64,
) -> Spread {
    spread_of_runs(&radius_runs(lines, smallest, total))
}

/// The radii behind [`Table::point_radius`], of a tree's whole branches.
pub fn point_radius_of(tree: &Tree, branches: &[Branch]) -> Vec<f64> {
    runs_of(tree, branches)
        .iter()
        .flat_map(Run::values)
        .collect()
}

fn runs_of(tree: &Tree, branches: &[Branch]) -> Vec<Run> {
    let smallest = branches.iter().map(|branch| branch.radius.min);
    let total = branches.iter().map(|branch| branch.length).sum();
    radius_runs(lines(tree, branches), smallest, total)
}

/// Places and radii along each branch.
fn lines(
    tree: &Tree,
    branches: &[Branch],
) -> impl Iterator<Item = impl Iterator<Item = (DVec3, f64)>> {
    branches.iter().map(|branch| {
        let nodes = branch.nodes.iter();
        nodes.map(|node| {
            (
                position(tree, *node),
                f64::from(tree.radius[*node as usize]),
            )
        })
    })
}

fn radius_runs<L: IntoIterator<Item = (DVec3, f64)>>(
    lines: impl IntoIterator<Item = L>,
    smallest: impl Iterator<Item = f64>,
    total: f64,
) -> Vec<Run> {
    let smallest = smallest.filter(|radius| *radius > 0.0);
    let step = (smallest.fold(f64::INFINITY, f64::min) / PER_RADIUS).max(total / POINTS_MOST);
    if !(step.is_finite() && step > 0.0) {
        return Vec::new();
    }
    let mut runs = Vec::new();
    for line in lines {
        let (mut done, mut next) = (0.0, 0.0);
        let mut before: Option<(DVec3, f64)> = None;
        for (point, to) in line {
            let Some((start, from)) = before.replace((point, to)) else {
                continue;
            };
            let length = start.distance(point);
            if next <= done + length {
                let per_length = if length > 0.0 {
                    (to - from) / length
                } else {
                    0.0
                };
                let count = ((done + length - next) / step).floor() + 1.0;
                runs.push(Run {
                    first: from + (next - done) * per_length,
                    rise: step * per_length,
                    count,
                });
                next += count * step;
            }
            done += length;
        }
    }
    runs
}

/// Values in equal steps, as radii are between two nodes.
#[derive(Clone, Copy, Debug)]
struct Run {
    first: f64,
    rise: f64,
    count: f64,
}

impl Run {
    fn last(&self) -> f64 {
        self.first + self.rise * (self.count - 1.0)
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        let &Self { first, rise, count } = self;
        let places = (0_u32..).map(f64::from);
        places
            .take_while(move |place| *place < count)
            .map(move |place| first + place * rise)
    }
}

/// The spread of all values, by the sums of arithmetic series.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "some million at most"
)]
fn spread_of_runs(runs: &[Run]) -> Spread {
    let is_finite = |run: &&Run| run.first.is_finite() && run.last().is_finite();
    let runs: Vec<&Run> = runs.iter().filter(is_finite).collect();
    let n: f64 = runs.iter().map(|run| run.count).sum();
    if n == 0.0 {
        return Spread::default();
    }
    let sum = |run: &&Run| run.count * f64::midpoint(run.first, run.last());
    let mean = runs.iter().map(sum).sum::<f64>() / n;
    let squares = |run: &&Run| {
        let (count, from) = (run.count, run.first - mean);
        let (once, twice) = (count - 1.0, 2.0 * count - 1.0);
        count * (from * (from + run.rise * once) + run.rise * run.rise * once * twice / 6.0)
    };
    let variance = runs.iter().map(squares).sum::<f64>() / n;
    let ends = || runs.iter().flat_map(|run| [run.first, run.last()]);
    Spread {
        n: n as usize,
        mean,
        std: variance.max(0.0).sqrt(),
        min: ends().fold(f64::INFINITY, f64::min),
        max: ends().fold(f64::NEG_INFINITY, f64::max),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the case says it")]
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against all values, one by one.
        #[test]
        fn runs_are_spread_as_their_values(runs in prop::collection::vec((-5.0..5.0_f64, -0.1..0.1_f64, 1..40_u32), 1..20)) {
            let runs: Vec<Run> = runs
                .into_iter()
                .map(|(first, rise, count)| Run { first, rise, count: f64::from(count) })
                .collect();
            let values = runs.iter().flat_map(Run::values);
            let (found, expected) = (spread_of_runs(&runs), spread(values));
            prop_assert_eq!(found.n, expected.n);
            for (found, expected) in [
                (found.mean, expected.mean),
                (found.std, expected.std),
                (found.min, expected.min),
                (found.max, expected.max),
            ] {
                prop_assert!((found - expected).abs() < 1e-9, "{found} {expected}");
            }
        }
    }
}
