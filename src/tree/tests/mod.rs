//! Tests of the tree's invariants, axes, radii, growth and tubes, over tables and random trees.
#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::missing_assert_message,
    clippy::float_cmp,
    reason = "tests"
)]

mod basics;
mod exports;
mod growth;
mod painted;
mod radii;
mod surface;
mod swc;
mod tubes;

use glam::{Vec3, vec3};
use proptest::prelude::*;

use super::{NO_PARENT, Node, Tree};

/// A node: parent, position, radius, order, birth.
pub(super) fn node(parent: u32, position: Vec3, radius: f32, order: u16, birth: u32) -> Node {
    Node {
        parent,
        position,
        radius,
        letter: 0,
        order,
        birth,
    }
}

/// A tree of nodes, whose only letter is A.
pub(super) fn tree_of(nodes: &[Node]) -> Tree {
    let mut tree = Tree {
        letters: vec!["A".into()],
        ..Tree::default()
    };
    for &node in nodes {
        tree.push(node);
    }
    tree.validate().unwrap();
    tree
}

/// A trunk of three segments with a branch of two at its first node:
///
/// ```text
///   3
///   2   5
///   1 ─ 4
///   0
/// ```
pub(super) fn fork() -> Tree {
    tree_of(&[
        node(NO_PARENT, Vec3::ZERO, 0.02, 0, 0),
        node(0, vec3(0.0, 1.0, 0.0), 0.02, 0, 1),
        node(1, vec3(0.0, 2.0, 0.0), 0.01, 0, 2),
        node(2, vec3(0.0, 3.0, 0.0), 0.01, 0, 3),
        node(1, vec3(0.8, 1.1, 0.0), 0.01, 1, 3),
        node(4, vec3(1.0, 1.9, 0.0), 0.01, 1, 4),
    ])
}

/// What a random node is made from: parent choice, step, radius, whether lateral, later birth, letter.
type Seed = (u32, Step, f32, bool, bool, u16);

/// How a random node lies to its parent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    /// By this vector.
    Free(Vec3),
    /// At the parent's own place.
    Nowhere,
    /// Straight back over the parent's segment.
    Back,
    /// Straight on.
    On,
}

/// Any of a million floats between two. (proptest 1.12's own ranges of f32 fail an assertion of their sampler now and then.)
pub(super) fn between(low: f32, high: f32) -> impl Strategy<Value = f32> {
    (0_u32..=1_000_000).prop_map(move |part| low + (high - low) * (part as f32 / 1e6))
}

fn step() -> impl Strategy<Value = Step> {
    let free = prop::array::uniform3(between(-1.0, 1.0)).prop_map(|v| Step::Free(v.into()));
    prop_oneof![8 => free, 1 => Just(Step::Nowhere), 1 => Just(Step::Back), 1 => Just(Step::On)]
}

/// Steps that make a decent plant: upward, at most some 60° from the vertical, each longer than 0.2 m.
fn decent_step() -> impl Strategy<Value = Step> {
    (between(-0.3, 0.3), between(0.2, 0.6), between(-0.3, 0.3))
        .prop_map(|(x, y, z)| Step::Free(vec3(x, y, z)))
}

/// Any valid tree: forks, chains, coincident nodes, turns of 180°, several roots, births that never fall upward.
pub(super) fn any_tree() -> impl Strategy<Value = Tree> {
    grow_from(step(), 1..120)
}

/// Trees without degenerate segments.
pub(super) fn decent_tree() -> impl Strategy<Value = Tree> {
    grow_from(decent_step(), 2..80)
}

fn grow_from(
    step: impl Strategy<Value = Step>,
    sizes: std::ops::Range<usize>,
) -> impl Strategy<Value = Tree> {
    let seed = (
        any::<u32>(),
        step,
        between(0.001, 0.05),
        prop::bool::weighted(0.3),
        any::<bool>(),
        0_u16..3,
    );
    prop::collection::vec(seed, sizes).prop_map(|seeds| plant(&seeds))
}

fn plant(seeds: &[Seed]) -> Tree {
    let mut tree = Tree {
        letters: ["A", "C", "D"].map(String::from).to_vec(),
        ..Tree::default()
    };
    for (index, &(choice, step, radius, lateral, later, letter)) in (0_u32..).zip(seeds) {
        // A new root now and then; else mostly the last node, so that there are chains.
        let parent = match choice % 16 {
            _ if index == 0 => NO_PARENT,
            0 if choice % 5 == 0 => NO_PARENT,
            1..=5 => (choice >> 4) % index,
            _ => index - 1,
        };
        let Some(below) = (parent != NO_PARENT).then_some(parent as usize) else {
            tree.push(Node {
                letter,
                ..node(NO_PARENT, Vec3::new(index as f32, 0.0, 0.0), radius, 0, 0)
            });
            continue;
        };
        let from = tree.position[below];
        let under = match tree.parent[below] {
            NO_PARENT => Vec3::Y,
            lower => from - tree.position[lower as usize],
        };
        let position = match step {
            Step::Free(by) => from + by,
            Step::Nowhere => from,
            Step::Back => from - under,
            Step::On => from + under,
        };
        let order = tree.order[below] + u16::from(lateral);
        let birth = tree.birth[below] + u32::from(later);
        tree.push(Node {
            parent,
            position,
            radius,
            letter,
            order,
            birth,
        });
    }
    tree.validate().unwrap();
    tree
}
