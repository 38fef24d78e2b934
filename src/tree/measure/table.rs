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
        point_radius: spread(point_radius_of(tree, branches)),
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

/// The spread of radii at equally spaced points of lines; `smallest` are their smallest radii, `total` is the length of all.
pub(super) fn point_radii<L: IntoIterator<Item = (DVec3, f64)>>(
    lines: impl IntoIterator<Item = L>,
    smallest: impl Iterator<Item = f64>,
    total: f64,
) -> Spread {
    spread(point_radius_values(lines, smallest, total))
}

/// The radii behind [`Table::point_radius`], of a tree's whole branches.
pub fn point_radius_of(tree: &Tree, branches: &[Branch]) -> Vec<f64> {
    let smallest = branches.iter().map(|branch| branch.radius.min);
    let total = branches.iter().map(|branch| branch.length).sum();
    point_radius_values(lines(tree, branches), smallest, total)
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

fn point_radius_values<L: IntoIterator<Item = (DVec3, f64)>>(
    lines: impl IntoIterator<Item = L>,
    smallest: impl Iterator<Item = f64>,
    total: f64,
) -> Vec<f64> {
    let smallest = smallest.filter(|radius| *radius > 0.0);
    let step = (smallest.fold(f64::INFINITY, f64::min) / PER_RADIUS).max(total / POINTS_MOST);
    if !(step.is_finite() && step > 0.0) {
        return Vec::new();
    }
    let mut radii = Vec::new();
    for line in lines {
        let (mut done, mut next) = (0.0, 0.0);
        let mut before: Option<(DVec3, f64)> = None;
        for (point, to) in line {
            let Some((start, from)) = before.replace((point, to)) else {
                continue;
            };
            let length = start.distance(point);
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
    radii
}
