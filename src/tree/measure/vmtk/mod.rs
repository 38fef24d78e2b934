//! Branches and bifurcations by VMTK's definition, of any tree.
//!
//! ```text
//! Tree ─▶ lines: root to tip ─▶ where they leave each other's tubes ─▶ tracts, in groups ─▶ branches: length, curvature, …
//!                                                                            └▶ bifurcations: frame, vectors, angles
//! ```
//!
//! A bifurcation begins one sphere before a line leaves another's tube and ends where it leaves it; branches are what is left
//! (Antiga and Steinman 2004, "Robust and objective decomposition and mapping of bifurcating vessels"; VMTK's branch extractor). VMTK
//! has each line by itself from source to target and compares every two of them; here they are one tree, and what they have in common is
//! looked at once. What differs on purpose:
//!
//! - Which tracts are one group follows from the tree: the tracts between the same two bifurcations are a branch, the blanked tracts at the
//!   same forks a bifurcation. VMTK asks whether tracts run in each other's tube.
//! - Lines that touch each other's tube again behind their fork have no bifurcation there.
//! - A line that never leaves another's tube (a branch within a ball of its sibling) is no branch; how many there are is told. VMTK joins what
//!   is left of it to another branch.
//! - A branch shorter than a sphere has a vector: all of it, which is told. VMTK's is zero upstream, with angles that mean nothing.
//! - The side of the normal is chosen by thickness (`frame`), not by the order of lines.

mod groups;
mod leave;
mod lines;
mod ranges;
#[cfg(test)]
mod tests;
mod tracts;
mod tube;

pub use self::groups::{Bifurcation, Branch, Vector};
pub use self::lines::{Ball, Place};
pub use self::tracts::Tract;

use super::{Children, Table};
use crate::tree::Tree;

/// Segments that are looked at in search of tubes at most, and so many more for each node.
const SEGMENTS_MOST: (u64, u64) = (1 << 24, 1 << 9);

/// A tree in branches and bifurcations as VMTK defines them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Split {
    /// Each stands behind the one that it grows from.
    pub branches: Vec<Branch>,
    /// Likewise.
    pub bifurcations: Vec<Bifurcation>,
    /// Tips of lines that never leave another's tube, and so are no branches.
    pub swallowed: Vec<u32>,
    /// The table of these branches and bifurcations.
    pub table: Table,
}

impl Split {
    /// Splits a tree. None where balls overlap so much (each with hundreds of others) that it would take too long.
    pub(super) fn new(tree: &Tree, children: &Children) -> Option<Self> {
        if tree.segment_count() == 0 {
            return Some(Self::default());
        }
        let lines = lines::Lines::new(tree, children);
        let (some, each) = SEGMENTS_MOST;
        let mut tubes = tube::Tubes::new(&lines, some + each * tree.len() as u64);
        let exits = leave::exits(&lines, &mut tubes)?;
        Some(groups::split(&lines, tracts::groups(&lines, &exits)))
    }
}
