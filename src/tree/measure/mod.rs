//! What is measured on a tree: its branches, junctions and orders, and the table that models are compared by.
//!
//! ```text
//! Tree ─▶ branches (junction to junction, or to the root or a tip) ─▶ course: length, curvature, torsion, radius
//!            │                └▶ orders: generation, Strahler, Horsfield      └▶ table: n, mean, std, min, max; by order
//!            └▶ junctions: angles, exponents, asymmetry
//! Tree ─▶ vmtk: branches and bifurcations as VMTK defines them ─▶ a table of those
//! ```
//!
//! Whatever made the tree (a scanned model's centerlines, an SWC file, an L-system), the same code measures it. Lengths are in the tree's
//! unit, angles in radians. The table's terms are those of van Nielen, Verbeek and Cao, "Visualizing, Analyzing and Constructing L-system
//! from Arborized 3D Model Using a Web Application".

mod branch;
mod by_order;
pub mod compare;
mod course;
mod frame;
mod junction;
mod orders;
mod statistics;
mod table;
pub mod vmtk;

pub use self::branch::{Branch, RadiusAlong};
pub use self::by_order::OfOrder;
pub use self::frame::{Direction, Frame};
pub use self::junction::Junction;
pub use self::orders::{Order, Ratios};
pub use self::statistics::{Spread, quantile, spread};
pub use self::table::{Table, point_radius_of};
pub use self::vmtk::Split;
use super::{NO_PARENT, Tree};

/// A tree, measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures {
    /// Each stands behind its parent.
    pub branches: Vec<Branch>,
    /// In the order of their nodes.
    pub junctions: Vec<Junction>,
    /// How many tips there are.
    pub tips: usize,
    /// By Strahler's orders, from 1.
    pub orders: Vec<Order>,
    /// Ratios between orders.
    pub ratios: Ratios,
    /// By centrifugal orders, from 0.
    pub by_order: Vec<OfOrder>,
    /// The table, of whole branches.
    pub table: Table,
    /// Branches and bifurcations as VMTK defines them, with a table of their own. None where balls overlap so much that it would take too long.
    pub vmtk: Option<Split>,
}

impl Measures {
    /// Measures a tree. Nodes at one place are no branches: what has no length is left out.
    pub fn new(tree: &Tree) -> Self {
        let children = Children::new(tree);
        Self {
            vmtk: Split::new(tree, &children),
            ..Self::of(tree, &children, Detail::Whole)
        }
    }

    /// The same of whole branches alone, without VMTK's, which takes a small part of the time.
    pub fn whole(tree: &Tree) -> Self {
        Self::of(tree, &Children::new(tree), Detail::Whole)
    }

    /// The same without how branches bend, for trees that are measured by the thousand: curvatures and torsions are none, directions at branches' ends and
    /// what follows from them zero.
    pub fn brief(tree: &Tree) -> Self {
        Self::of(tree, &Children::new(tree), Detail::Brief)
    }

    fn of(tree: &Tree, children: &Children, detail: Detail) -> Self {
        let mut branches = branch::branches(tree, children, detail);
        orders::number(&mut branches);
        let orders = orders::orders(&branches);
        let junctions = junction::junctions(tree, &branches);
        Self {
            tips: branches.iter().filter(|branch| branch.is_tip).count(),
            table: table::table(tree, &branches, &junctions),
            ratios: orders::ratios(&orders),
            by_order: by_order::by_order(&branches, &junctions),
            vmtk: None,
            orders,
            junctions,
            branches,
        }
    }

    /// Junctions with two daughters.
    pub fn bifurcations(&self) -> usize {
        self.junctions
            .iter()
            .filter(|junction| junction.daughters.len() == 2)
            .count()
    }
}

/// How much of a branch is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Detail {
    /// All of it.
    Whole,
    /// Not how it bends, which takes most of the time.
    Brief,
}

/// The children of each node, in flat arrays.
pub(super) struct Children {
    starts: Vec<u32>,
    all: Vec<u32>,
}

impl Children {
    pub(super) fn new(tree: &Tree) -> Self {
        let mut starts = vec![0_u32; tree.len() + 1];
        let with_parent = || {
            (0_u32..)
                .zip(tree.parent.iter().copied())
                .filter(|(_, parent)| *parent != NO_PARENT)
        };
        for (_, parent) in with_parent() {
            starts[parent as usize + 1] += 1;
        }
        for place in 1..starts.len() {
            starts[place] += starts[place - 1];
        }
        let mut next = starts.clone();
        let mut all = vec![0; starts.last().map_or(0, |last| *last as usize)];
        for (node, parent) in with_parent() {
            let place = &mut next[parent as usize];
            all[*place as usize] = node;
            *place += 1;
        }
        Self { starts, all }
    }

    pub(super) fn of(&self, node: u32) -> &[u32] {
        &self.all[self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize]
    }
}

#[cfg(test)]
mod tests;
