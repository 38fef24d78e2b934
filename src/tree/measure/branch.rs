//! Branches: from junction to junction, or to the root or a tip.

use glam::DVec3;
use serde::Serialize;

use super::course::Course;
use super::{Children, Detail};
use crate::tree::{NO_PARENT, Tree};

/// The radius along a branch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RadiusAlong {
    /// By length.
    pub mean: f64,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
    /// At the end nearer to the root.
    pub start: f64,
    /// At the other end.
    pub end: f64,
}

impl RadiusAlong {
    /// How much the radius shrinks along a length, per length.
    pub fn taper(&self, length: f64) -> f64 {
        if length > 0.0 {
            (self.start - self.end) / length
        } else {
            0.0
        }
    }
}

/// A branch and its measures. Lengths are in the tree's unit, angles in radians.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Branch {
    /// The place of the branch that it grows from; None for those from a root.
    pub parent: Option<usize>,
    /// Its nodes, from the one it shares with its parent on.
    pub nodes: Vec<u32>,
    /// Whether it ends in a tip.
    pub is_tip: bool,
    /// Centrifugal order: 0 for those from a root, one more at each junction.
    pub order: u32,
    /// Strahler's order: 1 at tips, one more where two of the same order meet.
    pub strahler: u32,
    /// Horsfield's order: 1 at tips, one more than the highest daughter.
    pub horsfield: u32,
    /// Tips at its end.
    pub tips: u32,
    /// Along it.
    pub length: f64,
    /// Between its ends, straight.
    pub chord: f64,
    /// Mean curvature, per length.
    pub curvature: f64,
    /// Mean torsion, per length; above zero as right-handed helices have it. None where it is too straight or short to have one.
    pub torsion: Option<f64>,
    /// The radius along it.
    pub radius: RadiusAlong,
    /// Of the balls swept along it: frustums.
    pub volume: f64,
    /// The lateral surface of the frustums.
    pub area: f64,
    /// Directions where it begins and where it ends, of length 1.
    pub tangents: [DVec3; 2],
}

impl Branch {
    /// Length over chord, less 1: 0 of a straight line, infinite of a ring.
    pub fn tortuosity(&self) -> f64 {
        self.length / self.chord - 1.0
    }

    /// Measures how it bends.
    fn bend(&mut self, tree: &Tree) {
        let points: Vec<DVec3> = self
            .nodes
            .iter()
            .map(|node| position(tree, *node))
            .collect();
        let course = Course::new(&points, self.radius.mean);
        self.curvature = course.mean_curvature();
        self.torsion = course.mean_torsion();
        self.tangents = course.end_tangents();
    }

    /// The first and the last node.
    pub fn ends(&self) -> [u32; 2] {
        [self.nodes.first(), self.nodes.last()].map(|node| node.copied().unwrap_or(NO_PARENT))
    }
}

/// Where a node is.
pub(super) fn position(tree: &Tree, node: u32) -> DVec3 {
    tree.position[node as usize].as_dvec3()
}

/// The branches of a tree, each behind its parent.
pub(super) fn branches(tree: &Tree, children: &Children, detail: Detail) -> Vec<Branch> {
    let mut branches: Vec<Branch> = Vec::new();
    let roots = (0_u32..)
        .zip(&tree.parent)
        .filter(|(_, parent)| **parent == NO_PARENT);
    let mut open: Vec<(u32, u32, Option<usize>)> = Vec::new();
    for (root, _) in roots {
        open.extend(
            children
                .of(root)
                .iter()
                .rev()
                .map(|child| (root, *child, None)),
        );
        while let Some((from, first, parent)) = open.pop() {
            let mut nodes = vec![from, first];
            let mut at = first;
            while let [next] = children.of(at) {
                at = *next;
                nodes.push(at);
            }
            let number = branches.len();
            let mut branch = measured(tree, nodes, parent, children.of(at).is_empty());
            if detail == Detail::Whole {
                branch.bend(tree);
            }
            branches.push(branch);
            open.extend(
                children
                    .of(at)
                    .iter()
                    .rev()
                    .map(|child| (at, *child, Some(number))),
            );
        }
    }
    branches
}

fn measured(tree: &Tree, nodes: Vec<u32>, parent: Option<usize>, is_tip: bool) -> Branch {
    let points: Vec<DVec3> = nodes.iter().map(|node| position(tree, *node)).collect();
    let radii: Vec<f64> = nodes
        .iter()
        .map(|node| f64::from(tree.radius[*node as usize]))
        .collect();
    let mut branch = Branch {
        parent,
        is_tip,
        chord: points[0].distance(points[points.len() - 1]),
        ..Branch::default()
    };
    let mut weighted = 0.0;
    for (points, radii) in points.windows(2).zip(radii.windows(2)) {
        let length = points[0].distance(points[1]);
        let slant = length.hypot(radii[1] - radii[0]);
        branch.length += length;
        weighted += length * f64::midpoint(radii[0], radii[1]);
        let squares = radii[0] * radii[0] + radii[0] * radii[1] + radii[1] * radii[1];
        branch.volume += std::f64::consts::PI / 3.0 * length * squares;
        branch.area += std::f64::consts::PI * (radii[0] + radii[1]) * slant;
    }
    let all = || radii.iter().copied();
    branch.radius = RadiusAlong {
        mean: if branch.length > 0.0 {
            weighted / branch.length
        } else {
            radii[0]
        },
        min: all().fold(f64::INFINITY, f64::min),
        max: all().fold(0.0, f64::max),
        start: radii[0],
        end: radii[radii.len() - 1],
    };
    branch.nodes = nodes;
    branch
}
