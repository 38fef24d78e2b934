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
    /// Angles between daughters.
    pub bifurcation_angle: Spread,
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

pub(super) fn table(tree: &Tree, branches: &[Branch], junctions: &[Junction]) -> Table {
    let branch_length = spread(branches.iter().map(|branch| branch.length));
    let per_branch = |length: f64| {
        if branch_length.mean > 0.0 {
            length / branch_length.mean
        } else {
            0.0
        }
    };
    let mut to_end = vec![0.0; branches.len()];
    for (place, branch) in branches.iter().enumerate() {
        to_end[place] = branch.length + branch.parent.map_or(0.0, |parent| to_end[parent]);
    }
    let tips = branches
        .iter()
        .zip(&to_end)
        .filter(|(branch, _)| branch.is_tip);
    let centerline_length = spread(tips.map(|(_, length)| *length));
    // A root that forks at once has no stem.
    let stem = branches.first().filter(|first| {
        let of_root = branches
            .iter()
            .filter(|branch| branch.parent.is_none() && branch.ends()[0] == first.ends()[0]);
        of_root.count() == 1
    });
    let stem_length = stem.map_or(0.0, |stem| stem.length);
    let upwards = |branch: &Branch| {
        let [start, end] = branch.tangents;
        let stem = stem.map_or(DVec3::ZERO, |stem| stem.tangents[0]);
        let turned = start.cross(end).length().atan2(start.dot(end));
        turned * (end.dot(stem) - start.dot(stem)).signum() / per_branch(branch.length)
    };
    Table {
        branch_length,
        point_radius: point_radii(tree, branches),
        centerline_length,
        stem_length,
        stem_iterations: per_branch(stem_length),
        iterations: [
            per_branch(centerline_length.mean) - per_branch(stem_length),
            per_branch(centerline_length.std),
        ],
        bifurcation_angle: spread(
            junctions
                .iter()
                .flat_map(|junction| junction.angles.iter().copied()),
        ),
        upwards_angle: spread(branches.iter().map(upwards)),
        curvature: spread(branches.iter().map(|branch| branch.curvature)),
        torsion: spread(branches.iter().filter_map(|branch| branch.torsion)),
        tortuosity: spread(branches.iter().map(Branch::tortuosity)),
    }
}

/// Radii at equally spaced points.
fn point_radii(tree: &Tree, branches: &[Branch]) -> Spread {
    let total: f64 = branches.iter().map(|branch| branch.length).sum();
    let smallest = branches
        .iter()
        .map(|branch| branch.radius.min)
        .filter(|radius| *radius > 0.0);
    let step = (smallest.fold(f64::INFINITY, f64::min) / PER_RADIUS).max(total / POINTS_MOST);
    if !(step.is_finite() && step > 0.0) {
        return Spread::default();
    }
    let mut radii = Vec::new();
    for branch in branches {
        let (mut done, mut next) = (0.0, 0.0);
        for pair in branch.nodes.windows(2) {
            let length = position(tree, pair[0]).distance(position(tree, pair[1]));
            let [from, to] = [pair[0], pair[1]].map(|node| f64::from(tree.radius[node as usize]));
            while next <= done + length {
                let part = if length > 0.0 {
                    (next - done) / length
                } else {
                    0.0
                };
                radii.push(from + part * (to - from));
                next += step;
            }
            done += length;
        }
    }
    spread(radii)
}
