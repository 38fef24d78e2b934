//! Growth between two steps: where everything stands while the newest segments unfold.
//!
//! A segment is *growing* when it was born in the newest step (or later), or stands on a growing one. Its *base* is the
//! nearest node below it that is whole. At growth g, 0 to 1:
//!
//! ```text
//! point of a growing segment   grow(base, point, g)
//! radius at any node           grow(radius_before, radius, g)
//! grow(a, b, g) = a + g·(b − a), and b itself where g ≥ 1
//! ```
//!
//! So each chain of new segments unfolds from where it stands, straight out, at one speed. At g = 1 the result is the
//! whole tree bit for bit; at g = 0 all new segments are points on the tree of one step earlier, which is
//! bit for bit where it was: `a + 0·(b − a)` and `a + g·(a − a)` are exactly a. (`mix(a, b, g)` = `a·(1 − g) + b·g` would
//! be exact at g = 1 by itself, but at g = 0.3 it would tear a ring that a growing segment shares with a whole one.)
//!
//! In a sketch births never fall from a node to its child, so the tree one step earlier is exactly the nodes
//! with `birth < newest`. A general grammar may insert a new segment below an old one; the old one then
//! grows out again with it, which is continuous too.

use glam::Vec3;

use super::{NO_PARENT, Tree};

/// `from` at `g` = 0, `to` at 1, both exactly; `from` throughout where both are equal.
pub fn grow(from: f32, to: f32, g: f32) -> f32 {
    if g >= 1.0 { to } else { from + g * (to - from) }
}

/// [`grow`] of each coordinate.
pub fn grow_point(from: Vec3, to: Vec3, g: f32) -> Vec3 {
    if g >= 1.0 { to } else { from + g * (to - from) }
}

/// A growth that came from outside, brought into 0…1; what is no number counts as whole.
pub fn clamp_growth(g: f32) -> f32 {
    if g.is_nan() { 1.0 } else { g.clamp(0.0, 1.0) }
}

/// For each node its base: the node itself where it is whole, else its nearest whole ancestor. Roots are whole.
pub fn bases(tree: &Tree, newest: u32) -> Vec<u32> {
    let mut bases = Vec::with_capacity(tree.len());
    for ((node, &parent), &birth) in (0..).zip(&tree.parent).zip(&tree.birth) {
        bases.push(base(&bases, node, parent, birth, newest));
    }
    bases
}

/// The base of `node`, where `bases` holds those of all nodes before it.
fn base(bases: &[u32], node: u32, parent: u32, birth: u32, newest: u32) -> u32 {
    if parent == NO_PARENT {
        return node;
    }
    let below = bases[parent as usize];
    let parent_is_whole = below == parent;
    if birth < newest && parent_is_whole {
        node
    } else {
        below
    }
}

/// The tree at growth `g`: same nodes, positions and radii between the step before `newest` and the whole.
///
/// `radius_before` is what [`super::radii::da_vinci`] returned; where it is shorter than the tree, radii do not change.
/// At g = 1 the result equals `tree`; at g = 0 the nodes with `birth < newest` are the tree one step earlier
/// and all others lie on it with radius 0.
#[must_use]
pub fn grown(tree: &Tree, radius_before: &[f32], newest: u32, g: f32) -> Tree {
    let g = clamp_growth(g);
    let mut grown = tree.clone();
    for (node, &base) in bases(tree, newest).iter().enumerate() {
        if base as usize != node {
            grown.position[node] = grow_point(tree.position[base as usize], tree.position[node], g);
        }
        let after = tree.radius[node];
        grown.radius[node] = grow(radius_before.get(node).copied().unwrap_or(after), after, g);
    }
    grown
}
