//! How far a grammar's own tree is from the tree that it is to be.
//!
//! The drawn tree's nodes come in the order of the plan, so it is known which node is which, and no grammar passes whose tips, junctions or parents are
//! others. Of a drawn segment and the nodes that it stands for, neither is farther from the other than the farthest of these nodes is from the segment and the
//! ends are from theirs: this bounds the two-sided Hausdorff distance of each branch, not only of the whole.

use glam::DVec3;
use serde::Serialize;

use super::shape::{Shape, from_segment};
use crate::tree::{NO_PARENT, Tree};

/// Distances in the tree's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Deviation {
    /// No point of a center line is farther from the other tree's than this.
    pub max: f64,
    /// Of the tree's nodes from the drawn center lines, in the mean.
    pub mean: f64,
    /// The largest difference of radii.
    pub radius: f64,
}

/// What the drawn tree is off by; none where it is another tree.
pub(super) fn deviation(
    tree: &Tree,
    shape: &Shape,
    order: &[u32],
    drawn: &Tree,
) -> Option<Deviation> {
    if drawn.len() != order.len() {
        return None;
    }
    let origin = tree.position.first()?.as_dvec3();
    let mut is_there = vec![false; shape.len()];
    let mut off = Deviation::default();
    let (mut sum, mut count) = (0.0, 0_usize);
    for (at, node) in order.iter().enumerate() {
        let place = *node as usize;
        let parent = drawn.parent[at];
        let meant = shape.parent[place];
        let is_own_start = parent != NO_PARENT && order[parent as usize] == *node;
        let is_right = match parent {
            NO_PARENT => meant == NO_PARENT && !is_there[place],
            _ if is_own_start => meant == NO_PARENT,
            parent => order[parent as usize] == meant && !is_there[place],
        };
        if !is_right {
            return None;
        }
        is_there[place] = true;
        let here = drawn.position[at].as_dvec3();
        let radius = f64::from(drawn.radius[at]);
        let mut add = |distance: f64, thickness: f64| {
            off.max = off.max.max(distance);
            off.radius = off.radius.max(thickness.abs());
            sum += distance;
            count += 1;
        };
        add(
            here.distance(shape.point[place]),
            radius - shape.radius[place],
        );
        if parent == NO_PARENT || is_own_start {
            continue;
        }
        let before = drawn.position[parent as usize].as_dvec3();
        let thick = f64::from(drawn.radius[parent as usize]);
        let mut between = tree.parent[shape.node[place] as usize];
        while between != shape.node[meant as usize] {
            if between == NO_PARENT {
                return None;
            }
            let point: DVec3 = tree.position[between as usize].as_dvec3() - origin;
            let (distance, along) = from_segment(point, [before, here]);
            let lerped = thick + (radius - thick) * along;
            add(distance, lerped - f64::from(tree.radius[between as usize]));
            between = tree.parent[between as usize];
        }
    }
    off.mean = sum / count.max(1) as f64;
    is_there.iter().all(|is_there| *is_there).then_some(off)
}
