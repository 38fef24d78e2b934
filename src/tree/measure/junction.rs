//! Junctions: the angles between what meets there, and how radii and tips are shared out.

use glam::DVec3;

use super::branch::{Branch, position};
use super::frame::{Daughter, Direction, Frame, apart};
use super::vmtk::Ball;
use crate::tree::{NO_PARENT, Tree};

/// A vector of a branch is its chord over so many of its mean radii.
const RADII: f64 = 2.0;
/// Exponents that are looked for.
const EXPONENTS: [f64; 2] = [0.05, 20.0];

/// A node with two or more daughters. Angles are in radians.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Junction {
    /// Its node.
    pub node: u32,
    /// The branch that leads to it; None at a root.
    pub parent: Option<usize>,
    /// Branches that begin here.
    pub daughters: Vec<usize>,
    /// Direction of the parent where it arrives, of length 1, with the flow: its chord over two radii. Zero at a root.
    pub parent_vector: DVec3,
    /// Directions of the daughters where they leave, in their order.
    pub vectors: Vec<DVec3>,
    /// Angles between daughters: of the first and second, the first and third, … the second and third, and so on.
    pub angles: Vec<f64>,
    /// Angles between the parent's direction and each daughter's: 0 where it goes straight on.
    pub parent_angles: Vec<f64>,
    /// The reference system. None where nothing there goes anywhere.
    pub frame: Option<Frame>,
    /// The parent's angles in it; None at a root.
    pub parent_direction: Option<Direction>,
    /// The daughters', in their order.
    pub directions: Vec<Option<Direction>>,
    /// Angles between daughters within the plane, in the order of `angles`, 0 to π.
    pub in_plane: Vec<f64>,
    /// The exponent with which the daughters' radii add up to the parent's (Murray: 3; da Vinci: 2). None where a daughter is as thick as the
    /// parent, or where there is no parent.
    pub exponent: Option<f64>,
    /// How unequally tips are shared between two daughters: 0 equally, 1 all but one of many to one (Van Pelt's partition asymmetry). None
    /// with more daughters, or with one tip each.
    pub asymmetry: Option<f64>,
}

/// All junctions, in the order of their nodes.
pub(super) fn junctions(tree: &Tree, branches: &[Branch]) -> Vec<Junction> {
    let mut daughters: Vec<(u32, usize)> = branches
        .iter()
        .enumerate()
        .map(|(place, branch)| (branch.ends()[0], place))
        .collect();
    daughters.sort_unstable();
    let groups = daughters
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|group| group.len() > 1);
    groups
        .map(|group| {
            let daughters: Vec<usize> = group.iter().map(|(_, place)| *place).collect();
            junction(tree, branches, group[0].0, daughters)
        })
        .collect()
}

fn junction(tree: &Tree, branches: &[Branch], node: u32, daughters: Vec<usize>) -> Junction {
    let parent = branches[daughters[0]].parent;
    let vectors: Vec<DVec3> = daughters
        .iter()
        .map(|place| vector(tree, &branches[*place], false))
        .collect();
    let parent_vector = parent.map_or(DVec3::ZERO, |parent| vector(tree, &branches[parent], true));
    let frame = frame(tree, branches, (node, parent), &daughters, &vectors);
    let direction = |vector: &DVec3| frame.and_then(|frame| frame.direction(*vector));
    let directions: Vec<Option<Direction>> = vectors.iter().map(direction).collect();
    let (mut angles, mut in_plane) = (Vec::new(), Vec::new());
    for (place, one) in vectors.iter().enumerate() {
        angles.extend(vectors[place + 1..].iter().map(|other| angle(*one, *other)));
        let others = directions[place + 1..].iter();
        in_plane.extend(others.map(|other| directions[place].zip(*other).map_or(0.0, apart)));
    }
    Junction {
        frame,
        parent_direction: direction(&parent_vector),
        directions,
        in_plane,
        node,
        parent,
        parent_angles: vectors
            .iter()
            .map(|one| angle(parent_vector, *one))
            .collect(),
        exponent: parent.and_then(|parent| {
            let radius = |place: usize| radius(tree, &branches[place]);
            let radii: Vec<f64> = daughters.iter().map(|place| radius(*place)).collect();
            exponent(radius(parent), &radii)
        }),
        asymmetry: asymmetry(branches, &daughters),
        parent_vector,
        vectors,
        angles,
        daughters,
    }
}

/// The reference system of a junction: of the ways from two radii up its parent to two radii down each daughter.
fn frame(
    tree: &Tree,
    branches: &[Branch],
    (node, parent): (u32, Option<usize>),
    daughters: &[usize],
    vectors: &[DVec3],
) -> Option<Frame> {
    let end = |place: usize, is_parent: bool| {
        let branch = &branches[place];
        let mut nodes = branch.nodes.clone();
        if is_parent {
            nodes.reverse();
        }
        Ball {
            centre: at(tree, &nodes, RADII * branch.radius.mean),
            radius: branch.radius.mean,
        }
    };
    let from = parent.map_or_else(
        || Ball {
            centre: position(tree, node),
            radius: f64::from(tree.radius[node as usize]),
        },
        |parent| end(parent, true),
    );
    let ways: Vec<[Ball; 2]> = daughters
        .iter()
        .map(|daughter| [from, end(*daughter, false)])
        .collect();
    let kinds: Vec<Daughter> = daughters
        .iter()
        .zip(vectors)
        .map(|(daughter, vector)| Daughter {
            vector: *vector,
            radius: branches[*daughter].radius.mean,
            tips: branches[*daughter].tips,
            length: branches[*daughter].length,
        })
        .collect();
    Frame::new(&ways).map(|frame| frame.turned(&kinds))
}

/// The chord of a branch over two of its radii from where it comes out of the junction's ball, with the flow, of length 1. What is nearer than that
/// is the junction's and not the branch's: where lines meet in it is a matter of definition, and a tenth of a radius there turns a chord from the
/// junction by 3 degrees.
fn vector(tree: &Tree, branch: &Branch, from_end: bool) -> DVec3 {
    let mut nodes = branch.nodes.clone();
    if from_end {
        nodes.reverse();
    }
    let ball = nodes
        .first()
        .map_or(0.0, |node| f64::from(tree.radius[*node as usize]));
    let near = ball.min(branch.length / 2.0);
    let far = near + RADII * branch.radius.mean;
    let [start, end] = [near, far].map(|length| at(tree, &nodes, length));
    let away = (end - start).normalize_or_zero();
    if from_end { -away } else { away }
}

/// The place so far along nodes, or their last.
fn at(tree: &Tree, nodes: &[u32], length: f64) -> DVec3 {
    let mut left = length;
    let mut place = nodes
        .first()
        .map_or(DVec3::ZERO, |node| position(tree, *node));
    for node in nodes.iter().skip(1) {
        let next = position(tree, *node);
        let step = place.distance(next);
        if step >= left && step > 0.0 {
            return place.lerp(next, left / step);
        }
        left -= step;
        place = next;
    }
    place
}

/// By the tangent: exact also near 0 and 180 degrees (Kahan).
pub(super) fn angle(one: DVec3, other: DVec3) -> f64 {
    one.cross(other).length().atan2(one.dot(other))
}

/// The median radius of a branch, without the node where it begins: that belongs to a junction.
fn radius(tree: &Tree, branch: &Branch) -> f64 {
    let nodes = branch.nodes.iter().skip(1);
    let mut radii: Vec<f32> = nodes.map(|node| tree.radius[*node as usize]).collect();
    radii.sort_by(f32::total_cmp);
    radii.get(radii.len() / 2).copied().map_or(0.0, f64::from)
}

/// With which exponent radii add up to the parent's: parentˣ = Σ daughterˣ.
fn exponent(parent: f64, daughters: &[f64]) -> Option<f64> {
    let parts: Vec<f64> = daughters.iter().map(|radius| radius / parent).collect();
    let sum = |x: f64| parts.iter().map(|part| part.powf(x)).sum::<f64>() - 1.0;
    let [mut low, mut high] = EXPONENTS;
    if !(parts.iter().all(|part| *part > 0.0 && *part < 1.0) && sum(low) > 0.0 && sum(high) < 0.0) {
        return None;
    }
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if sum(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(low)
}

fn asymmetry(branches: &[Branch], daughters: &[usize]) -> Option<f64> {
    let [one, other] = *daughters else {
        return None;
    };
    let [one, other] = [one, other].map(|place| f64::from(branches[place].tips));
    let most = one + other - 2.0;
    (most > 0.0).then(|| (one - other).abs() / most)
}

impl Junction {
    /// How many branches begin here.
    pub fn degree(&self) -> usize {
        self.daughters.len()
    }

    /// Whether it is where a tree begins.
    pub fn is_root(&self, tree: &Tree) -> bool {
        tree.parent[self.node as usize] == NO_PARENT
    }
}
