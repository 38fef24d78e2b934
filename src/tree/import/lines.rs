//! Lines with radii, as VMTK and 3D Slicer have centerlines, joined into one tree.
//!
//! VMTK gives each target a line of its own from the source on, so what lines have in common is there once for each: a line is followed
//! along what is there already, as long as it is no farther from it than a small part of the radius, and only the rest of it is new. Lines that
//! were resampled or smoothed one by one so become one, too. Pieces (branches, tracts) hang together where the one's first or last point
//! is a point of the other. What hangs together with nothing is a tree of its own.

use std::collections::{HashMap, VecDeque};

use glam::{DVec3, Vec3};

use super::number_orders;
use crate::tree::{NO_PARENT, Node, Tree, TreeError};

/// A point nearer to a line than this part of the radius there is on it.
const ON: f64 = 0.05;
/// How far ahead a line's next point is looked for, in steps to it.
const AHEAD: f64 = 1.5;
/// Segments that are looked at for a point at most.
const LOOKED_MOST: usize = 1024;
/// Nearer to a node than this part of a segment a line leaves at the node.
const AT_NODE: f64 = 1e-6;

/// Joins lines of points; every line's numbers are those of points, and radii are as many.
///
/// # Errors
/// [`TreeError`] where positions or radii are none that trees have.
pub fn lines(points: &[Vec3], radii: &[f32], lines: &[Vec<u32>]) -> Result<Tree, TreeError> {
    let lines: Vec<&[u32]> = lines
        .iter()
        .map(Vec::as_slice)
        .filter(|line| line.len() > 1)
        .collect();
    let mut joiner = Joiner {
        points,
        radii,
        draft: Draft::default(),
        waiting: HashMap::new(),
        queue: VecDeque::new(),
    };
    for (number, line) in lines.iter().enumerate() {
        for end in [line[0], line[line.len() - 1]] {
            let key = key(points[end as usize]);
            joiner.waiting.entry(key).or_default().push(number);
        }
    }
    let mut is_done = vec![false; lines.len()];
    for first in 0..lines.len() {
        if is_done[first] {
            continue;
        }
        let root = joiner.push(NO_PARENT, lines[first][0]);
        if first == 0 {
            joiner.queue_near(root, &lines);
        }
        while let Some((number, node)) = joiner.queue.pop_front() {
            if !std::mem::replace(&mut is_done[number], true) {
                joiner.add(node, lines[number]);
            }
        }
    }
    joiner.draft.tree()
}

/// The bits of a point.
fn key(point: Vec3) -> [u32; 3] {
    // −0 + 0 is 0.
    (point + Vec3::ZERO).to_array().map(f32::to_bits)
}

/// A tree that grows: segments may be cut, so parents may stand behind children.
#[derive(Default)]
struct Draft {
    position: Vec<Vec3>,
    radius: Vec<f32>,
    parent: Vec<u32>,
    children: Vec<Vec<u32>>,
}

/// A place on the segment that ends in a node.
#[derive(Clone, Copy)]
struct At {
    node: u32,
    part: f64,
}

struct Joiner<'a> {
    points: &'a [Vec3],
    radii: &'a [f32],
    draft: Draft,
    /// Lines by their ends.
    waiting: HashMap<[u32; 3], Vec<usize>>,
    /// Lines, each with a node that one of its ends is at.
    queue: VecDeque<(usize, u32)>,
}

impl Joiner<'_> {
    /// Adds a point; lines that wait for it are next.
    fn push(&mut self, parent: u32, point: u32) -> u32 {
        let at = self.points[point as usize];
        let node = self.draft.push(parent, at, self.radii[point as usize]);
        if let Some(lines) = self.waiting.remove(&key(at)) {
            self.queue
                .extend(lines.into_iter().map(|line| (line, node)));
        }
        node
    }

    /// Lines that begin all but at the first root begin at it: those that were smoothed one by one.
    fn queue_near(&mut self, root: u32, lines: &[&[u32]]) {
        let (at, radius) = self.draft.ball(root);
        let is_near = |line: &[u32]| {
            let start = self.points[line[0] as usize].as_dvec3();
            start.distance(at) <= ON * radius
        };
        let near = lines.iter().enumerate().filter(|(_, line)| is_near(line));
        let near: Vec<(usize, u32)> = near.map(|(number, _)| (number, root)).collect();
        self.queue.extend(near);
    }

    /// Adds a line that begins or ends at a node.
    fn add(&mut self, node: u32, line: &[u32]) {
        let at = self.draft.position[node as usize];
        let distance = |end: Option<&u32>| {
            end.map_or(f32::INFINITY, |end| {
                self.points[*end as usize].distance_squared(at)
            })
        };
        let is_backward = distance(line.last()) < distance(line.first());
        let count = line.len();
        let point = |place: usize| match is_backward {
            true => line[count - 1 - place],
            false => line[place],
        };
        let mut at = At { node, part: 1.0 };
        let mut next = 1;
        while next < count {
            let [from, to] =
                [next - 1, next].map(|place| self.points[point(place) as usize].as_dvec3());
            let Some(found) = self.draft.follow(at, to, from.distance(to)) else {
                break;
            };
            at = found;
            next += 1;
        }
        if next == count {
            return;
        }
        let mut parent = self.draft.cut(at);
        for place in next..count {
            parent = self.push(parent, point(place));
        }
    }
}

impl Draft {
    fn push(&mut self, parent: u32, position: Vec3, radius: f32) -> u32 {
        let node = u32::try_from(self.parent.len()).unwrap_or(NO_PARENT);
        self.position.push(position);
        self.radius.push(radius);
        self.parent.push(parent);
        self.children.push(Vec::new());
        if let Some(siblings) = self.children.get_mut(parent as usize) {
            siblings.push(node);
        }
        node
    }

    fn ball(&self, node: u32) -> (DVec3, f64) {
        let place = node as usize;
        (
            self.position[place].as_dvec3(),
            f64::from(self.radius[place]),
        )
    }

    /// The nearest place to a point from another one on, not much farther than a step; None where none is near enough.
    fn follow(&self, at: At, point: DVec3, step: f64) -> Option<At> {
        let mut best: Option<(f64, At)> = None;
        let mut open = vec![(at.node, at.part, 0.0)];
        let mut looked = 0;
        while let Some((node, from, done)) = open.pop() {
            looked += 1;
            if looked > LOOKED_MOST {
                break;
            }
            let (end, radius) = self.ball(node);
            let parent = self.parent[node as usize];
            let (start, start_radius) = match parent {
                NO_PARENT => (end, radius),
                parent => self.ball(parent),
            };
            let way = end - start;
            let part = way.dot(point - start) / way.length_squared();
            let part = if part.is_finite() {
                part.clamp(from, 1.0)
            } else {
                1.0
            };
            let distance = (start + part * way).distance(point);
            let thick = start_radius + part * (radius - start_radius);
            if distance <= ON * thick && best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, At { node, part }));
            }
            let done = done + (1.0 - from) * way.length();
            if done <= AHEAD * step {
                let children = self.children[node as usize].iter().rev();
                open.extend(children.map(|child| (*child, 0.0, done)));
            }
        }
        best.map(|(_, at)| at)
    }

    /// The node at a place, a new one where there is none.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "trees are in single precision"
    )]
    fn cut(&mut self, at: At) -> u32 {
        let parent = self.parent[at.node as usize];
        if at.part >= 1.0 - AT_NODE || parent == NO_PARENT {
            return at.node;
        }
        if at.part <= AT_NODE {
            return parent;
        }
        let [(start, from), (end, to)] = [parent, at.node].map(|node| self.ball(node));
        let position = start.lerp(end, at.part).as_vec3();
        let radius = (from + at.part * (to - from)) as f32;
        let node = self.push(NO_PARENT, position, radius);
        self.parent[node as usize] = parent;
        self.parent[at.node as usize] = node;
        self.children[node as usize].push(at.node);
        for child in &mut self.children[parent as usize] {
            if *child == at.node {
                *child = node;
            }
        }
        node
    }

    /// The tree, parents before children.
    fn tree(self) -> Result<Tree, TreeError> {
        let mut tree = Tree::with_capacity(self.parent.len());
        tree.letters.push("centerline".to_owned());
        let roots = (0_u32..).zip(&self.parent);
        let roots = roots.filter(|(_, parent)| **parent == NO_PARENT);
        for (root, _) in roots {
            let mut open = vec![(root, NO_PARENT)];
            while let Some((node, parent)) = open.pop() {
                let pushed = tree.push(Node {
                    parent,
                    position: self.position[node as usize],
                    radius: self.radius[node as usize],
                    letter: 0,
                    order: 0,
                    birth: 0,
                });
                let children = self.children[node as usize].iter().rev();
                open.extend(children.map(|child| (*child, pushed)));
            }
        }
        number_orders(&mut tree);
        tree.validate()?;
        Ok(tree)
    }
}
