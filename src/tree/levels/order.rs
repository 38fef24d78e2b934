//! Nodes in the order in which a tree's levels of detail take them.

use super::super::{NO_PARENT, Tree};

/// A tree's segments in order, by the numbers of their records ([`segments`](super::super::tubes::segments) makes one for each node that has a parent): axes
/// whole, each followed by the branches that it bears, those at its tip first. `axis`: of each node the child that continues its axis
/// ([`axis_children`](super::super::axes::axis_children)).
///
/// So neighbours in this order are neighbours along an axis, or branches of one part of the tree.
#[must_use]
pub fn along_axes(tree: &Tree, axis: &[u32]) -> Vec<u32> {
    let count = tree.len();
    // How many nodes stand on each, itself included.
    let mut size = vec![1_u32; count];
    for node in (0..count).rev() {
        let parent = tree.parent[node] as usize;
        if parent < node {
            size[parent] += size[node];
        }
    }
    // Where each node comes, and where the next of its children that is no axis child does.
    let (mut place, mut next) = (vec![0_u32; count], vec![0_u32; count]);
    let mut order = vec![NO_PARENT; count];
    let (mut roots, mut record) = (0, 0_u32);
    for node in 0..count {
        let below = tree.parent[node] as usize;
        let free = match axis.get(below) {
            None => &mut roots,
            Some(child) if *child as usize == node => &mut place[below],
            Some(_) => &mut next[below],
        };
        let at = *free;
        let is_root = tree.parent[node] == NO_PARENT;
        *free += size[node];
        place[node] = at + 1;
        next[node] = at + 1 + tail(&size, axis, node);
        if !is_root {
            if let Some(of) = order.get_mut(at as usize) {
                *of = record;
            }
            record += 1;
        }
    }
    order.retain(|record| *record != NO_PARENT);
    order
}

/// How many nodes stand on a node's axis child, that one included.
fn tail(size: &[u32], axis: &[u32], node: usize) -> u32 {
    let child = axis.get(node).copied().unwrap_or(NO_PARENT);
    size.get(child as usize).copied().unwrap_or(0)
}
