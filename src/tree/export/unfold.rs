//! The last steps of a tree as morph targets: where each vertex was one step earlier.
//!
//! In the tree of a step all nodes that are younger lie on the nearest older one below them ([`crate::tree::growth`]), tubes that lead to them are points, and wood
//! is as thick as the tips say that it bears by then (areas add up, as Leonardo has it). The target of a step holds, for each vertex, its place before
//! the step less its place after it. Targets add up: with weight 1 for all steps from one on, the mesh is exactly the tree before that step, and a weight that falls
//! from 1 to 0 unfolds one step as the workshop shows it, straight out of where it stands.

use std::ops::RangeInclusive;

use glam::Vec3;

use super::PART;
use super::surface::{Matter, Surface};
use crate::tree::axes::axis_children;
use crate::tree::growth::bases;
use crate::tree::mesh::mesh;
use crate::tree::organs::{Numbers, OrganMesh, Organist, Refined};
use crate::tree::tubes::{GROWING, TIP, TubeSegment};
use crate::tree::{NO_PARENT, Tree};

/// The steps that unfold.
#[derive(Debug)]
pub(super) struct Unfolding {
    /// As it is drawn.
    tree: Tree,
    /// By node: the child that goes on.
    axis: Vec<u32>,
    /// The number in it of each node of the tree that is exported, where they differ.
    number: Option<Vec<u32>>,
    /// The step before the first that unfolds, and the newest.
    first: u32,
    newest: u32,
}

/// The tree of a step: where nodes are, how thick, and which are there.
struct Stage {
    place: Vec<Vec3>,
    radius: Vec<f32>,
    is_whole: Vec<bool>,
}

impl Unfolding {
    /// The last so many steps of a tree that is drawn as a finer one, where there is one.
    pub(super) fn of(tree: &Tree, fine: Option<Refined>, steps: u32) -> Self {
        let newest = tree.birth.iter().copied().max().unwrap_or(0);
        let (tree, number) = match fine {
            Some(fine) => (fine.tree, Some(fine.number)),
            None => (tree.clone(), None),
        };
        Self {
            axis: axis_children(&tree),
            tree,
            number,
            first: newest.saturating_sub(steps),
            newest,
        }
    }

    /// The steps, from the oldest on; none where the tree did not grow.
    pub(super) fn steps(&self) -> RangeInclusive<u32> {
        self.first.saturating_add(1)..=self.newest
    }

    fn stage(&self, step: u32) -> Stage {
        let tree = &self.tree;
        let bases = bases(tree, step.saturating_add(1));
        let own = (0_u32..).zip(&bases);
        let is_whole: Vec<bool> = own.map(|(node, base)| node == *base).collect();
        let now = tips(tree, &is_whole);
        let whole = tips(tree, &vec![true; tree.len()]);
        let radius = (0..tree.len()).map(|node| {
            #[allow(clippy::cast_precision_loss, reason = "a ratio")]
            let share = now[node] as f32 / whole[node].max(1) as f32;
            let thin = match self.is_last(&is_whole, node) && step < self.newest {
                true => TIP,
                false => 1.0,
            };
            tree.radius[node] * share.sqrt() * thin
        });
        Stage {
            radius: radius.collect(),
            place: bases
                .iter()
                .map(|base| tree.position[*base as usize])
                .collect(),
            is_whole,
        }
    }

    /// Whether a tube ends at a node then: nothing goes on from it that is there, and it is no root.
    fn is_last(&self, there: &[bool], node: usize) -> bool {
        let next = self.axis[node] as usize;
        let goes_on = there.get(next).copied().unwrap_or(false);
        self.tree.parent[node] != NO_PARENT && !goes_on
    }

    /// The tubes at a step; those of the newest are as they are.
    fn records(&self, records: &[TubeSegment], step: u32, stage: &Stage) -> Vec<TubeSegment> {
        let nodes = (0..self.tree.len()).filter(|node| self.tree.parent[*node] != NO_PARENT);
        let moved = |(node, record): (usize, &TubeSegment)| {
            let mut record = *record;
            record.flags &= !GROWING;
            if step >= self.newest {
                return record;
            }
            let parent = self.tree.parent[node] as usize;
            let to = stage.radius[node];
            let from = match self.axis[parent] as usize == node {
                true => stage.radius[parent],
                false => stage.radius[parent].min(to),
            };
            record.from = stage.place[parent].to_array();
            record.to = stage.place[node].to_array();
            record.radii = [from, from, to, to];
            record
        };
        nodes.zip(records).map(moved).collect()
    }

    /// The node of the drawn tree that is a node of the exported one.
    fn drawn(&self, node: u32) -> Option<usize> {
        let node = match &self.number {
            Some(number) => *number.get(node as usize)? as usize,
            None => node as usize,
        };
        (node < self.tree.len()).then_some(node)
    }
}

/// How many tips each node bears among those that are there; 0 where it is not.
fn tips(tree: &Tree, there: &[bool]) -> Vec<u32> {
    let mut tips = vec![0_u32; tree.len()];
    for node in (0..tree.len()).rev().filter(|node| there[*node]) {
        tips[node] = tips[node].max(1);
        let own = tips[node];
        if let Some(below) = tips.get_mut(tree.parent[node] as usize) {
            *below = below.saturating_add(own);
        }
    }
    tips
}

/// What one step moves each vertex of a group by, backwards, in their order.
pub(super) fn moved(
    surface: &Surface<'_>,
    matter: Matter,
    step: u32,
    mut take: impl FnMut([f32; 3]),
) {
    let Some(unfolding) = &surface.unfolding else {
        return;
    };
    let earlier = step.saturating_sub(1);
    let [before, after] = [earlier, step].map(|step| unfolding.stage(step));
    let own = |step, stage: &Stage| -> Vec<TubeSegment> {
        let all = unfolding.records(&surface.records, step, stage);
        let own = |record: &TubeSegment| surface.matter(record) == matter;
        all.into_iter().filter(own).collect()
    };
    let [old, new] = [own(earlier, &before), own(step, &after)];
    for (old, new) in old.chunks(PART).zip(new.chunks(PART)) {
        let [old, new] = [old, new].map(|records| mesh(records, 1.0, surface.sides).positions);
        for (old, new) in old.into_iter().zip(new) {
            take((Vec3::from(old) - Vec3::from(new)).to_array());
        }
    }
    let mut organist = Organist::new(surface.organs);
    let mut mesh = OrganMesh::default();
    for index in 0..surface.loose {
        let organ = organist.organ(index);
        let organ = organ.filter(|organ| matter == Matter::Painted(organ.paint.material));
        let Some(organ) = organ else { continue };
        mesh.clear();
        organist.add_only(index, Numbers::POSITIONS, &mut mesh);
        let node = unfolding.drawn(organ.node);
        for place in &mesh.positions {
            // Organs unfold with what they hang on, as tubes do.
            let at = |stage: &Stage, step| match node {
                Some(node) if !stage.is_whole[node] || organ.birth > step => stage.place[node],
                _ => Vec3::from(*place),
            };
            take((at(&before, earlier) - at(&after, step)).to_array());
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;
    use crate::tree::Node;

    #[test]
    fn what_is_younger_lies_where_it_will_grow_from() {
        let mut tree = Tree {
            letters: vec!["F".to_owned()],
            ..Tree::default()
        };
        // A trunk of two steps with a branch of two.
        for (parent, place, radius, birth) in [
            (NO_PARENT, [0.0, 0.0, 0.0], 0.2, 0),
            (0, [0.0, 1.0, 0.0], 0.2, 1),
            (1, [0.0, 2.0, 0.0], 0.1, 2),
            (1, [1.0, 1.0, 0.0], 0.1, 2),
            (3, [2.0, 1.0, 0.0], 0.1, 3),
        ] {
            tree.push(Node {
                parent,
                position: Vec3::from(place),
                radius,
                letter: 0,
                order: 0,
                birth,
            });
        }
        let unfolding = Unfolding::of(&tree, None, 9);
        assert_eq!(unfolding.steps(), 1..=3);
        let one = unfolding.stage(1);
        for node in [1, 2, 3, 4] {
            assert_eq!(one.place[node], Vec3::Y);
        }
        assert_eq!(one.radius[2..], [0.0; 3]);
        // One tip of two: half of the area, and as a tip it is thin.
        assert!((one.radius[1] - 0.2 * 0.5_f32.sqrt() * TIP).abs() < 1e-6);
        let two = unfolding.stage(2);
        assert_eq!(two.place[4], Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(two.place[3], tree.position[3]);
        assert!((two.radius[1] - 0.2).abs() < 1e-6);
        assert_eq!(unfolding.stage(3).place, tree.position.to_vec());
        assert_eq!(Unfolding::of(&tree, None, 1).steps(), 3..=3);
    }
}
