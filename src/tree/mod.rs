//! The `Tree`: what a sketch, an L-system's string, a centerline and an SWC file all become.
//!
//! Flat arrays in topological order (parent before child), no pointers, no
//! recursion over depth, so trees of millions of nodes are streamed.

use glam::Vec3;

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
    pub parent: Vec<u32>,
    /// Position in metres, Y up.
    pub position: Vec<Vec3>,
    /// Radius in metres at the node.
    pub radius: Vec<f32>,
    /// Index into `letters`: the module that drew the segment.
    pub letter: Vec<u16>,
    /// Branching order: 0 on the trunk, one more in each bracket.
    pub order: Vec<u16>,
    /// The derivation step in which the segment appeared (0: in the axiom).
    pub birth: Vec<u32>,
    /// Names of the letters.
    pub letters: Vec<String>,
}

pub mod tubes;
