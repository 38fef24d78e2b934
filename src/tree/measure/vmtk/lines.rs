//! A tree's lines from its root to each tip, in an order in which all that is below a node stands right behind it.
//!
//! So what is below a node is a stretch of nodes and a stretch of tips, and a set of lines is a few stretches of tips.

use glam::DVec3;

use super::super::Children;
use super::super::branch::position;
use crate::tree::{NO_PARENT, Tree};

/// Halvings with which a place on a segment is found.
pub(super) const HALVINGS: u32 = 40;

/// A ball on a line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ball {
    /// Its middle.
    pub centre: DVec3,
    /// Its radius.
    pub radius: f64,
}

impl Ball {
    /// Whether a point is in it.
    pub(super) fn reaches(self, point: DVec3) -> bool {
        self.centre.distance_squared(point) <= self.radius * self.radius
    }

    pub(super) fn lerp(self, other: Self, part: f64) -> Self {
        Self {
            centre: self.centre.lerp(other.centre, part),
            radius: self.radius + part * (other.radius - self.radius),
        }
    }
}

/// A place on the segment that ends in a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// The node.
    pub node: u32,
    /// How much of the segment is before the place, 0 to 1.
    pub part: f64,
    /// How far it is from the root, along the tree.
    pub along: f64,
}

/// The lines.
pub(super) struct Lines<'a> {
    pub(super) tree: &'a Tree,
    pub(super) children: &'a Children,
    /// All nodes, what is below one right behind it.
    pub(super) order: Vec<u32>,
    /// Where in that order each node stands.
    pub(super) place: Vec<u32>,
    /// Where in that order what is below each node ends.
    pub(super) end: Vec<u32>,
    /// Which tips are below each node: from one, up to before another.
    pub(super) tips: Vec<[u32; 2]>,
    /// The nodes of tips.
    pub(super) nodes: Vec<u32>,
    /// How far each node is from its root.
    pub(super) along: Vec<f64>,
}

impl<'a> Lines<'a> {
    pub(super) fn new(tree: &'a Tree, children: &'a Children) -> Self {
        let count = tree.len();
        let mut lines = Self {
            tree,
            children,
            order: Vec::with_capacity(count),
            place: vec![0; count],
            end: vec![0; count],
            tips: vec![[0; 2]; count],
            nodes: Vec::new(),
            along: vec![0.0; count],
        };
        let roots = (0_u32..)
            .zip(&tree.parent)
            .filter(|(_, parent)| **parent == NO_PARENT);
        let mut open: Vec<u32> = Vec::new();
        for (root, _) in roots {
            open.push(root);
            while let Some(node) = open.pop() {
                lines.visit(node);
                open.extend(children.of(node).iter().rev());
            }
        }
        for place in (0..lines.order.len()).rev() {
            let node = lines.order[place] as usize;
            let last = children.of(lines.order[place]).last();
            let last = last.map(|child| *child as usize);
            lines.end[node] = last.map_or(lines.place[node] + 1, |last| lines.end[last]);
            lines.tips[node][1] = last.map_or(lines.tips[node][0] + 1, |last| lines.tips[last][1]);
        }
        lines
    }

    fn visit(&mut self, node: u32) {
        let at = node as usize;
        self.place[at] = u32::try_from(self.order.len()).unwrap_or(NO_PARENT);
        self.order.push(node);
        self.tips[at][0] = u32::try_from(self.nodes.len()).unwrap_or(NO_PARENT);
        if self.children.of(node).is_empty() {
            self.nodes.push(node);
        }
        if let Some(parent) = self.parent(node) {
            let length = position(self.tree, parent).distance(position(self.tree, node));
            self.along[at] = self.along[parent as usize] + length;
        }
    }

    pub(super) fn parent(&self, node: u32) -> Option<u32> {
        let parent = self.tree.parent[node as usize];
        (parent != NO_PARENT).then_some(parent)
    }

    /// Whether one node is another, or on its way to the root.
    pub(super) fn is_above(&self, above: u32, node: u32) -> bool {
        (self.place[above as usize]..self.end[above as usize]).contains(&self.place[node as usize])
    }

    /// The ball of a node.
    pub(super) fn ball(&self, node: u32) -> Ball {
        Ball {
            centre: position(self.tree, node),
            radius: f64::from(self.tree.radius[node as usize]),
        }
    }

    /// A part of the way along the segment that ends in a node.
    pub(super) fn on(&self, node: u32, part: f64) -> Place {
        let to = self.along[node as usize];
        let from = self
            .parent(node)
            .map_or(to, |parent| self.along[parent as usize]);
        Place {
            node,
            part,
            along: from + part * (to - from),
        }
    }

    /// The ball of a place.
    pub(super) fn ball_at(&self, place: Place) -> Ball {
        let ball = self.ball(place.node);
        match self.parent(place.node) {
            Some(parent) if place.part < 1.0 => self.ball(parent).lerp(ball, place.part),
            _ => ball,
        }
    }

    /// The first place on the way to the root from which on balls no longer reach a place: one sphere upstream of it, as VMTK has it. The root where all do.
    pub(super) fn touching_above(&self, place: Place) -> Place {
        let point = self.ball_at(place).centre;
        let mut reaching = place;
        while let Some(parent) = self.parent(reaching.node) {
            if !self.ball(parent).reaches(point) {
                let (mut out, mut within) = (0.0, reaching.part);
                for _ in 0..HALVINGS {
                    let middle = f64::midpoint(out, within);
                    let ball = self.ball_at(self.on(reaching.node, middle));
                    *(if ball.reaches(point) {
                        &mut within
                    } else {
                        &mut out
                    }) = middle;
                }
                return self.on(reaching.node, within);
            }
            reaching = self.on(parent, 1.0);
        }
        reaching
    }

    /// The balls from one place down to another that is on it or below it, both included.
    pub(super) fn balls(&self, from: Place, to: Place) -> Vec<Ball> {
        let mut balls = vec![self.ball_at(to)];
        let mut node = to.node;
        while node != from.node {
            let Some(parent) = self.parent(node) else {
                break;
            };
            node = parent;
            if node != from.node || from.part < 1.0 {
                balls.push(self.ball(node));
            }
        }
        balls.push(self.ball_at(from));
        balls.reverse();
        balls
    }
}
