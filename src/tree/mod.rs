//! The `Tree`: what a sketch, an L-system's string, a centerline and an SWC file all become.
//!
//! Flat arrays in topological order (parent before child), no pointers, no
//! recursion over depth, so trees of millions of nodes are streamed.
//!
//! ```text
//! turtle, import ─▶ Tree ─▶ radii::da_vinci ─▶ tubes::segments ─▶ GPU
//!                    │                              └─▶ mesh::mesh ─▶ export::{glb, obj}
//!                    └─▶ growth::grown ─▶ export::swc
//! ```

use glam::Vec3;

pub mod axes;
pub mod bark;
mod cells;
pub mod compare;
pub mod detail;
pub(crate) mod draws;
pub(crate) mod error;
pub mod export;
pub mod file;
pub mod foliage;
pub mod growth;
pub mod import;
pub mod levels;
pub mod measure;
pub mod mesh;
pub(crate) mod nearest;
pub mod organs;
mod pages;
pub mod radii;
pub(crate) mod solve;
pub mod tubes;
pub mod vary;

pub use cells::Cells;
pub use error::TreeError;
pub use organs::{Drawing, Organs};

/// `Tree::parent` of a node that has none.
pub const NO_PARENT: u32 = u32::MAX;

/// A branching structure as flat arrays, one entry a node; a node with a parent
/// is also the segment from its parent to itself.
///
/// Invariants (checked by `validate`): all node arrays have one length,
/// `parent[i] < i` or `parent[i] == NO_PARENT`, `letter[i] < letters.len()`,
/// positions and radii finite, radii not negative.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tree {
    /// Index of the parent node, smaller than the node's own, or [`NO_PARENT`].
    pub parent: Cells<u32>,
    /// Position in metres, Y up.
    pub position: Cells<Vec3>,
    /// Radius in metres at the node.
    pub radius: Cells<f32>,
    /// Index into `letters`: the module that drew the segment.
    pub letter: Cells<u16>,
    /// Branching order: 0 on the trunk, one more in each bracket.
    pub order: Cells<u16>,
    /// The derivation step in which the segment appeared (0: in the axiom).
    pub birth: Cells<u32>,
    /// Names of the letters.
    pub letters: Vec<String>,
}

/// One node, as [`Tree::push`] takes it; the fields are those of [`Tree`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Index of the parent node or [`NO_PARENT`].
    pub parent: u32,
    /// Metres, Y up.
    pub position: Vec3,
    /// Metres.
    pub radius: f32,
    /// Index into [`Tree::letters`].
    pub letter: u16,
    /// Branching order.
    pub order: u16,
    /// Step in which the segment appeared.
    pub birth: u32,
}

impl Tree {
    /// An empty tree with room for `nodes` nodes.
    pub fn with_capacity(nodes: usize) -> Self {
        Self {
            parent: Cells::with_capacity(nodes),
            position: Cells::with_capacity(nodes),
            radius: Cells::with_capacity(nodes),
            letter: Cells::with_capacity(nodes),
            order: Cells::with_capacity(nodes),
            birth: Cells::with_capacity(nodes),
            letters: Vec::new(),
        }
    }

    /// Makes room for so many more nodes.
    ///
    /// # Errors
    /// Where the machine does not give the memory; the tree is as it was.
    pub fn try_reserve(&mut self, nodes: usize) -> Result<(), std::collections::TryReserveError> {
        self.parent.try_reserve_exact(nodes)?;
        self.position.try_reserve_exact(nodes)?;
        self.radius.try_reserve_exact(nodes)?;
        self.letter.try_reserve_exact(nodes)?;
        self.order.try_reserve_exact(nodes)?;
        self.birth.try_reserve_exact(nodes)
    }

    /// Adds a node and returns its index. The caller keeps the invariants; [`Tree::validate`] checks them.
    pub fn push(&mut self, node: Node) -> u32 {
        let index = u32::try_from(self.parent.len()).unwrap_or(NO_PARENT);
        assert!(
            index != NO_PARENT,
            "a tree holds at most 4294967294 nodes; producers must stop before"
        );
        self.parent.push(node.parent);
        self.position.push(node.position);
        self.radius.push(node.radius);
        self.letter.push(node.letter);
        self.order.push(node.order);
        self.birth.push(node.birth);
        index
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.parent.len()
    }

    /// Whether there is no node at all.
    pub fn is_empty(&self) -> bool {
        self.parent.is_empty()
    }

    /// Number of nodes without a parent: one for each separate tree.
    pub fn root_count(&self) -> usize {
        self.parent
            .iter()
            .filter(|&&parent| parent == NO_PARENT)
            .count()
    }

    /// Number of segments: nodes that have a parent.
    pub fn segment_count(&self) -> usize {
        self.len() - self.root_count()
    }

    /// Nodes without children, in order of index.
    pub fn tips(&self) -> Vec<u32> {
        let mut is_tip = vec![true; self.len()];
        for &parent in self.parent.iter().filter(|&&parent| parent != NO_PARENT) {
            is_tip[parent as usize] = false;
        }
        (0..)
            .zip(is_tip)
            .filter_map(|(node, tip)| tip.then_some(node))
            .collect()
    }

    /// How many nodes have two children or more.
    pub fn junctions(&self) -> usize {
        let mut children = vec![0_u8; self.len()];
        for &parent in self.parent.iter().filter(|&&parent| parent != NO_PARENT) {
            let of = &mut children[parent as usize];
            *of = of.saturating_add(1);
        }
        children.into_iter().filter(|count| *count > 1).count()
    }

    /// Smallest and largest corner of the nodes' positions (without radii), or `None` for an empty tree.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = *self.position.first()?;
        Some(
            self.position
                .iter()
                .fold((first, first), |(low, high), &p| (low.min(p), high.max(p))),
        )
    }

    /// Sum of the segments' lengths in metres.
    pub fn total_length(&self) -> f64 {
        let length = |(&parent, &position): (&u32, &Vec3)| match parent {
            NO_PARENT => 0.0,
            parent => (position.as_dvec3() - self.position[parent as usize].as_dvec3()).length(),
        };
        self.parent.iter().zip(&self.position).map(length).sum()
    }

    /// Checks the invariants that every function of this room relies on; everything that comes from outside
    /// (an imported file, a deserialised project) passes through here first.
    ///
    /// # Errors
    /// The first invariant broken.
    pub fn validate(&self) -> Result<(), TreeError> {
        let expected = self.parent.len();
        let lengths = [
            ("position", self.position.len()),
            ("radius", self.radius.len()),
            ("letter", self.letter.len()),
            ("order", self.order.len()),
            ("birth", self.birth.len()),
        ];
        if let Some(&(array, found)) = lengths.iter().find(|(_, found)| *found != expected) {
            return Err(TreeError::Lengths {
                array,
                found,
                expected,
            });
        }
        if expected >= NO_PARENT as usize {
            return Err(TreeError::TooManyNodes(expected));
        }
        let letters = self.letters.len();
        for (node, &parent) in self.parent.iter().enumerate() {
            if parent != NO_PARENT && parent as usize >= node {
                return Err(TreeError::Parent { node, parent });
            }
            if usize::from(self.letter[node]) >= letters {
                return Err(TreeError::Letter {
                    node,
                    letter: self.letter[node],
                    letters,
                });
            }
            if !self.position[node].is_finite() {
                return Err(TreeError::Position(node));
            }
            let radius = self.radius[node];
            if !(radius.is_finite() && radius >= 0.0) {
                return Err(TreeError::Radius { node, radius });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
