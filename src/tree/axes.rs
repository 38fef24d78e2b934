//! Children of nodes, and which child continues its parent's axis (its tube).
//!
//! A tree stores parents only; both indices here are built in one pass over the nodes.

use super::{NO_PARENT, Tree};

/// The children of every node as one array cut into runs (compressed sparse rows).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Children {
    /// `first[i]..first[i + 1]` is node i's run in `nodes`.
    first: Vec<u32>,
    /// Children, in order of index within each run.
    nodes: Vec<u32>,
}

impl Children {
    /// Builds the index of a valid tree.
    pub fn new(tree: &Tree) -> Self {
        let mut first = vec![0_u32; tree.len() + 1];
        for &parent in tree.parent.iter().filter(|&&parent| parent != NO_PARENT) {
            first[parent as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut nodes = vec![0_u32; tree.segment_count()];
        let mut next = first.clone();
        for (child, &parent) in (0..).zip(&tree.parent) {
            if parent != NO_PARENT {
                let slot = &mut next[parent as usize];
                nodes[*slot as usize] = child;
                *slot += 1;
            }
        }
        Self { first, nodes }
    }

    /// The children of a node, in order of index; none for a node that does not exist.
    pub fn of(&self, node: u32) -> &[u32] {
        let node = node as usize;
        match (self.first.get(node), self.first.get(node + 1)) {
            (Some(&from), Some(&to)) => &self.nodes[from as usize..to as usize],
            _ => &[],
        }
    }
}

/// For each node the child that continues its axis, or [`NO_PARENT`] where there is no child.
///
/// Of several children it is the one with, in this order of weight: the same branching order, the same
/// letter, the earlier birth (so that a growing side branch never takes over an axis that stood before it),
/// the larger radius, the smaller index. The other children are laterals. Every node that has a child has an axis child:
/// where an axis ends in nothing but a bracket, the bracket's branch goes on from it without a joint.
pub fn axis_children(tree: &Tree) -> Vec<u32> {
    let mut axis = Vec::new();
    axis_children_into(tree, &mut axis);
    axis
}

/// [`axis_children`] into a vector that is reused.
pub fn axis_children_into(tree: &Tree, axis: &mut Vec<u32>) {
    axis.clear();
    axis.resize(tree.len(), NO_PARENT);
    for (child, &parent) in (0..).zip(&tree.parent) {
        if parent == NO_PARENT {
            continue;
        }
        let best = &mut axis[parent as usize];
        if *best == NO_PARENT
            || continues_better(tree, parent as usize, child as usize, *best as usize)
        {
            *best = child;
        }
    }
}

/// Whether `child` continues the axis of `parent` better than `other`, which has a smaller index.
fn continues_better(tree: &Tree, parent: usize, child: usize, other: usize) -> bool {
    let kinship = |node: usize| {
        let same_order = tree.order[node] == tree.order[parent];
        (same_order, tree.letter[node] == tree.letter[parent])
    };
    kinship(child)
        .cmp(&kinship(other))
        .then_with(|| tree.birth[other].cmp(&tree.birth[child]))
        .then_with(|| tree.radius[child].total_cmp(&tree.radius[other]))
        .is_gt()
}
