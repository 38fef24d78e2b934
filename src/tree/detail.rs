//! A drawing with fewer segments, as a coarser level of detail: what is short goes, what is nearly straight becomes one.
//!
//! **The bound.** No point of the full tree's wood is farther from the coarser one's than [`Detail::bound`], nor the other way round: `within`, and what a
//! ring of so few corners lacks of its circle. A branch goes that reaches no farther than a third of `within` from the node it grows from; a chord
//! stands for the nodes of a branch that are no farther from it than another third, and whose radii are so near to its own; so two thirds are what
//! a center line is off by, and one is what a radius is. Tips narrow to a point over their last segment (see [`super::tubes`]), so what is thicker
//! than a third keeps it. What the tree carries stays where it is.

use std::f32::consts::PI;

use glam::Vec3;

use super::organs::{Organist, refined};
use super::tubes::{CAPPED, STARTS, segments};
use super::{Drawing, NO_PARENT, Node, Organs, Tree};

/// Nodes that one chord stands for at most: what bounds the time.
const CHORD: u32 = 64;

/// How exactly a drawing is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// How far the surface may be off, besides what rings of few corners lack; metres.
    pub within: f32,
    /// Corners of each ring, 3 to 64.
    pub sides: u32,
}

/// Corners of rings, and parts of the tree's size that the surface may be off by, of each level.
const LEVELS: [(u32, f32); Detail::LEVELS as usize] =
    [(8, 0.0), (5, 0.0005), (4, 0.002), (3, 0.008), (3, 0.03)];

impl Detail {
    /// How many levels there are; 0 is the tree as it is.
    pub const LEVELS: u32 = 5;

    /// A level of detail of a tree; levels beyond the last are the last.
    #[must_use]
    pub fn level(tree: &Tree, level: u32) -> Self {
        let (sides, part) = LEVELS[(level as usize).min(LEVELS.len() - 1)];
        Self {
            within: part * size(tree),
            sides,
        }
    }

    /// How far the surface may be off, for tubes no thicker than a radius; metres.
    #[must_use]
    pub fn bound(&self, radius: f32) -> f32 {
        #[allow(clippy::cast_precision_loss, reason = "at most 64")]
        let half_corner = PI / self.sides.max(3) as f32;
        self.within + (radius + self.within / 3.0) * (1.0 - half_corner.cos())
    }

    /// The finest detail whose drawing has no more triangles than a budget, with that drawing; none where not even the coarsest has.
    #[must_use]
    pub fn of_budget(drawing: &Drawing, triangles: u64) -> Option<(Self, Drawing)> {
        let size = size(&drawing.tree);
        let fits = |detail: &Self| {
            let coarse = coarser(drawing, detail.within);
            (triangles_of(&coarse, detail.sides) <= triangles).then_some((*detail, coarse))
        };
        for sides in [8, 6, 5] {
            if let Some(fine) = fits(&Self { within: 0.0, sides }) {
                return Some(fine);
            }
        }
        let mut best = None;
        // Of the tree's size, as powers of two.
        let (mut fine, mut coarse) = (-20.0_f32, 8.0_f32);
        for _ in 0..18 {
            let middle = f32::midpoint(fine, coarse);
            let within = size * middle.exp2();
            match fits(&Self { within, sides: 4 }).or_else(|| fits(&Self { within, sides: 3 })) {
                Some(found) => (best, coarse) = (Some(found), middle),
                None => fine = middle,
            }
        }
        best
    }
}

/// A tree's size: the diagonal of the box that holds its nodes.
#[must_use]
pub fn size(tree: &Tree) -> f32 {
    tree.bounds().map_or(0.0, |(low, high)| low.distance(high))
}

/// Triangles of a drawing whose tubes have so many sides.
#[must_use]
pub fn triangles_of(drawing: &Drawing, sides: u32) -> u64 {
    let fine = refined(&drawing.tree, &drawing.organs, &[]);
    let tree = fine.as_ref().map_or(&drawing.tree, |fine| &fine.tree);
    let mut records = Vec::new();
    segments(tree, &[], u32::MAX, &mut records);
    let of = |flags: u32| 2 + u64::from(flags & CAPPED != 0) + u64::from(flags & STARTS != 0);
    let tubes: u64 = records.iter().map(|record| of(record.flags)).sum();
    let organist = Organist::new(&drawing.organs);
    let organs = (0..drawing.organs.len()).map(|index| organist.size(index).1 as u64 / 3);
    u64::from(sides) * tubes + organs.sum::<u64>()
}

/// The drawing with fewer segments, whose surface is nowhere off by more than `within`, metres; 0 leaves all.
#[must_use]
pub fn coarser(drawing: &Drawing, within: f32) -> Drawing {
    if within.is_nan() || within <= 0.0 || drawing.tree.segment_count() == 0 {
        return drawing.clone();
    }
    let fine = refined(&drawing.tree, &drawing.organs, &[]);
    let tree = fine.as_ref().map_or(&drawing.tree, |fine| &fine.tree);
    let paints = fine
        .as_ref()
        .map_or(&drawing.organs.paints, |fine| &fine.paints);
    let number = fine.as_ref().map(|fine| fine.number.as_slice());
    let within = within / 3.0;
    let stays = staying(tree, within);
    let mut only = vec![NO_PARENT; tree.len()];
    let mut several = vec![false; tree.len()];
    for node in (0..tree.len()).filter(|node| stays[*node]) {
        if let Some(parent) = parent_of(tree, node) {
            several[parent] |= only[parent] != NO_PARENT;
            only[parent] = u32::try_from(node).unwrap_or(NO_PARENT);
        }
    }
    let paint = |node: usize| paints.get(node).copied().unwrap_or_default();
    // Where a chord may not pass: at roots, forks, tips, and where the look changes.
    let ends = |node: usize| {
        let next = only[node] as usize;
        let is_between =
            !several[node] && only[node] != NO_PARENT && parent_of(tree, node).is_some();
        !is_between || paint(next) != paint(node) || tree.letter[next] != tree.letter[node]
    };
    let mut made = Tree {
        letters: tree.letters.clone(),
        ..Tree::default()
    };
    let mut made_paints = Vec::new();
    let mut now = vec![NO_PARENT; tree.len()];
    // The node that each node's chord begins at, and how many nodes that chord has passed.
    let mut begins: Vec<(u32, u32)> = vec![(NO_PARENT, 0); tree.len()];
    let mut run = Vec::new();
    for node in (0..tree.len()).filter(|node| stays[*node]) {
        let Some(parent) = parent_of(tree, node) else {
            now[node] = made.push(of(tree, node, NO_PARENT));
            made_paints.push(paint(node));
            continue;
        };
        let passed = match now[parent] {
            NO_PARENT => begins[parent],
            _ => (u32::try_from(parent).unwrap_or(NO_PARENT), 0),
        };
        begins[node] = (passed.0, passed.1 + 1);
        let narrows = |next: u32| only[next as usize] == NO_PARENT && tree.radius[node] > within;
        let may_pass = !ends(node) && passed.1 < CHORD && !narrows(only[node]);
        if may_pass && is_near(tree, passed.0, node, only[node], within, &mut run) {
            continue;
        }
        now[node] = made.push(of(tree, node, now[passed.0 as usize]));
        made_paints.push(paint(node));
    }
    let kept = |node: u32| {
        let fine = number.map_or(Some(node), |number| number.get(node as usize).copied());
        let known = fine.and_then(|node| now.get(node as usize).copied());
        known.unwrap_or(NO_PARENT)
    };
    let mut organs = Organs {
        paints: if paints.is_empty() {
            Vec::new()
        } else {
            made_paints
        },
        smooth: Vec::new(),
        ..drawing.organs.clone()
    };
    organs
        .polygons
        .iter_mut()
        .for_each(|one| one.node = kept(one.node));
    organs
        .spheres
        .iter_mut()
        .for_each(|one| one.node = kept(one.node));
    organs
        .placed
        .iter_mut()
        .for_each(|one| one.node = kept(one.node));
    Drawing { tree: made, organs }
}

fn parent_of(tree: &Tree, node: usize) -> Option<usize> {
    let parent = tree.parent[node];
    (parent != NO_PARENT).then_some(parent as usize)
}

fn of(tree: &Tree, node: usize, parent: u32) -> Node {
    Node {
        parent,
        position: tree.position[node],
        radius: tree.radius[node],
        letter: tree.letter[node],
        order: tree.order[node],
        birth: tree.birth[node],
    }
}

/// Whether all nodes after one, up to another, are near the chord from the one to what comes behind the other.
fn is_near(
    tree: &Tree,
    from: u32,
    last: usize,
    next: u32,
    within: f32,
    run: &mut Vec<usize>,
) -> bool {
    run.clear();
    let mut at = Some(last);
    while let Some(between) = at.filter(|at| *at != from as usize) {
        run.push(between);
        at = parent_of(tree, between);
    }
    let [start, stop] = [from as usize, next as usize].map(|at| tree.position[at]);
    let [thick, thin] = [from as usize, next as usize].map(|at| tree.radius[at]);
    run.iter().all(|between| {
        let (off, along) = from_chord(tree.position[*between], start, stop);
        let radius = thick + (thin - thick) * along;
        off <= within && (tree.radius[*between] - radius).abs() <= within
    })
}

/// How far a point is from a chord, and where along it is nearest, 0 to 1.
fn from_chord(point: Vec3, start: Vec3, stop: Vec3) -> (f32, f32) {
    let along = stop - start;
    let square = along.length_squared();
    let place = match square > 0.0 {
        true => ((point - start).dot(along) / square).clamp(0.0, 1.0),
        false => 0.0,
    };
    (point.distance(start + along * place), place)
}

/// Nodes that stay: those whose branches reach farther, their thickness included; of each root at least the branch that reaches farthest.
fn staying(tree: &Tree, within: f32) -> Vec<bool> {
    let mut reach = vec![0.0_f32; tree.len()];
    let mut farthest = vec![(f32::NEG_INFINITY, 0); tree.len()];
    for node in (0..tree.len()).rev() {
        let own = reach[node].max(tree.radius[node]);
        if let Some(parent) = parent_of(tree, node) {
            let from_parent = own + tree.position[node].distance(tree.position[parent]);
            reach[node] = from_parent;
            reach[parent] = reach[parent].max(from_parent);
            if from_parent > farthest[parent].0 {
                farthest[parent] = (from_parent, node);
            }
        }
    }
    let mut stays = vec![false; tree.len()];
    for node in 0..tree.len() {
        stays[node] = parent_of(tree, node).is_none_or(|parent| {
            // The next tip would narrow where the tree is thick; and of no tree all goes.
            let is_thick = tree.radius[parent] > within || tree.parent[parent] == NO_PARENT;
            stays[parent] && (reach[node] > within || is_thick && farthest[parent].1 == node)
        });
    }
    stays
}

#[cfg(test)]
mod tests;
