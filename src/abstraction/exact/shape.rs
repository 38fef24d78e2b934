//! The tree with no more nodes than a tolerance asks for: roots, junctions and tips, and of the nodes between them the fewest.
//!
//! A chord stands for the nodes between its ends if they are all within the tolerance of it, in place and radius. Then the chord is as near to
//! them as they are to it: their closest points cover all of it. Where a branch has few nodes the fewest chords are found (Imai and Iri 1988), else
//! each chord is made as long as doubling and halving find it.

use glam::DVec3;

use crate::tree::axes::{Children, axis_children};
use crate::tree::{NO_PARENT, Tree};

/// Nodes of a branch up to which the fewest chords are looked for.
const FEWEST_UP_TO: usize = 48;

/// What is drawn, in the order in which it is: each node before its children, the child that goes on with the axis last.
#[derive(Clone, Debug, Default)]
pub(super) struct Shape {
    /// Of the tree.
    pub(super) node: Vec<u32>,
    /// Of the shape, or [`NO_PARENT`].
    pub(super) parent: Vec<u32>,
    /// From the first root.
    pub(super) point: Vec<DVec3>,
    pub(super) radius: Vec<f64>,
    /// Behind the last node of what grows from it.
    pub(super) end: Vec<u32>,
    /// The longest way from it to a tip.
    pub(super) reach: Vec<f64>,
    children: Children,
}

impl Shape {
    pub(super) fn len(&self) -> usize {
        self.node.len()
    }

    pub(super) fn children(&self, node: u32) -> &[u32] {
        self.children.of(node)
    }

    /// From its parent to a node.
    pub(super) fn step(&self, node: u32) -> DVec3 {
        match self.parent[node as usize] {
            NO_PARENT => DVec3::ZERO,
            parent => self.point[node as usize] - self.point[parent as usize],
        }
    }

    pub(super) fn roots(&self) -> impl Iterator<Item = u32> + '_ {
        let parents = (0..).zip(&self.parent);
        parents.filter_map(|(node, parent)| (*parent == NO_PARENT).then_some(node))
    }

    /// The shape of a tree, near to it within a tolerance of place and of radius.
    pub(super) fn new(tree: &Tree, within: f64, radius_within: f64) -> Self {
        let children = Children::new(tree);
        let axis = axis_children(tree);
        let origin = tree.position.first().map_or(DVec3::ZERO, |p| p.as_dvec3());
        let mut shape = Self::default();
        // Nodes of the tree that begin a branch, and the node of the shape that they hang on.
        let mut open: Vec<(u32, u32)> = Vec::new();
        let mut run = Vec::new();
        let roots = (0..).zip(&tree.parent);
        for (root, _) in roots.filter(|(_, parent)| **parent == NO_PARENT) {
            shape.add(tree, origin, root, NO_PARENT);
            let here = shape.last();
            shape.open(&children, &axis, root, here, &mut open);
            while let Some((first, from)) = open.pop() {
                run.clear();
                run.push(shape.node[from as usize]);
                let mut at = first;
                run.push(at);
                while let [next] = children.of(at) {
                    at = *next;
                    run.push(at);
                }
                let mut on = from;
                for kept in kept(tree, &run, within, radius_within) {
                    shape.add(tree, origin, run[kept], on);
                    on = shape.last();
                }
                shape.open(&children, &axis, at, on, &mut open);
            }
        }
        shape.finish();
        shape
    }

    fn last(&self) -> u32 {
        u32::try_from(self.node.len().saturating_sub(1)).unwrap_or(NO_PARENT)
    }

    fn add(&mut self, tree: &Tree, origin: DVec3, node: u32, parent: u32) {
        let place = node as usize;
        self.node.push(node);
        self.parent.push(parent);
        self.point.push(tree.position[place].as_dvec3() - origin);
        self.radius.push(f64::from(tree.radius[place]));
    }

    /// Puts a node's branches where the next one to draw is last.
    fn open(
        &self,
        children: &Children,
        axis: &[u32],
        node: u32,
        here: u32,
        open: &mut Vec<(u32, u32)>,
    ) {
        let on = axis[node as usize];
        open.extend((on != NO_PARENT).then_some((on, here)));
        let others = children.of(node).iter().rev();
        open.extend(
            others
                .filter(|child| **child != on)
                .map(|child| (*child, here)),
        );
    }

    /// Children, ends and ways.
    fn finish(&mut self) {
        let only_parents = Tree {
            parent: self.parent.iter().copied().collect(),
            ..Tree::default()
        };
        self.children = Children::new(&only_parents);
        self.end = (1..).take(self.len()).collect();
        self.reach = vec![0.0; self.len()];
        for node in (0..self.len()).rev() {
            let parent = self.parent[node];
            if parent == NO_PARENT {
                continue;
            }
            let way = self.reach[node] + self.point[node].distance(self.point[parent as usize]);
            let parent = parent as usize;
            self.end[parent] = self.end[parent].max(self.end[node]);
            self.reach[parent] = self.reach[parent].max(way);
        }
    }
}

/// How far a point is from a segment, and where along it (0 to 1) is nearest.
pub(super) fn from_segment(point: DVec3, [from, to]: [DVec3; 2]) -> (f64, f64) {
    let along = to - from;
    let square = along.length_squared();
    let place = if square > 0.0 {
        ((point - from).dot(along) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (point.distance(from + along * place), place)
}

/// Which nodes of a run are kept, from the second on; the last always is.
fn kept(tree: &Tree, run: &[u32], within: f64, radius_within: f64) -> Vec<usize> {
    let at = |place: usize| {
        let node = run[place] as usize;
        (tree.position[node].as_dvec3(), f64::from(tree.radius[node]))
    };
    let fits = |from: usize, to: usize| {
        let ((start, thick), (stop, thin)) = (at(from), at(to));
        (from + 1..to).all(|between| {
            let (point, radius) = at(between);
            let (off, along) = from_segment(point, [start, stop]);
            off <= within && (thick + (thin - thick) * along - radius).abs() <= radius_within
        })
    };
    match run.len() {
        0..=2 => (1..run.len()).collect(),
        few if few <= FEWEST_UP_TO => fewest(few, fits),
        many => longest(many, fits),
    }
}

/// The fewest chords of so many nodes; of several ways the one with the longest first chord.
fn fewest(nodes: usize, fits: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let last = nodes - 1;
    let mut chords = vec![0; nodes];
    let mut next = vec![last; nodes];
    for from in (0..last).rev() {
        (chords[from], next[from]) = (chords[from + 1] + 1, from + 1);
        for to in (from + 2..=last).rev() {
            if chords[to] + 1 < chords[from] + usize::from(to > next[from]) && fits(from, to) {
                (chords[from], next[from]) = (chords[to] + 1, to);
            }
        }
    }
    let mut kept = Vec::new();
    let mut at = 0;
    while at < last {
        at = next[at];
        kept.push(at);
    }
    kept
}

/// Chords that are as long as doubling and halving find them.
fn longest(nodes: usize, fits: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let last = nodes - 1;
    let mut kept = Vec::new();
    let mut at = 0;
    while at < last {
        let mut good = 1;
        while at + 2 * good <= last && fits(at, at + 2 * good) {
            good *= 2;
        }
        let mut bad = (2 * good).min(last - at + 1);
        while bad - good > 1 {
            let middle = good.midpoint(bad);
            if fits(at, at + middle) {
                good = middle;
            } else {
                bad = middle;
            }
        }
        at += good;
        kept.push(at);
    }
    kept
}
