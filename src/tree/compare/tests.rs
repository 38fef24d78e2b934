//! Trees for the tests of this room, and what comparisons of whole trees say.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "the table says it"
)]

use glam::{Quat, Vec3};
use proptest::prelude::*;

use super::verdict::Kind;
use super::*;
use crate::tree::{NO_PARENT, Node};

/// A tree of a root and of nodes with their parents and where they are from these.
pub(super) fn grown(nodes: &[(u32, [f32; 3])]) -> Tree {
    let mut tree = Tree {
        letters: vec!["A".to_owned()],
        ..Tree::default()
    };
    let node = |parent, position| Node {
        parent,
        position,
        radius: 0.5,
        letter: 0,
        order: 0,
        birth: 0,
    };
    tree.push(node(NO_PARENT, Vec3::ZERO));
    for (parent, step) in nodes {
        let from = tree.position[*parent as usize];
        tree.push(node(*parent, from + Vec3::from(*step)));
    }
    tree
}

/// Any tree of so many nodes at most.
pub(super) fn spec(most: usize) -> impl Strategy<Value = Tree> {
    let step = prop::array::uniform3(-2_i8..3).prop_map(|step| step.map(f32::from));
    prop::collection::vec((any::<u32>(), step), 0..most).prop_map(|nodes| {
        let nodes: Vec<(u32, [f32; 3])> = (1..)
            .zip(nodes)
            .map(|(before, (parent, step))| (parent % before, step))
            .collect();
        grown(&nodes)
    })
}

/// The same nodes at other places.
pub(super) fn moved(tree: &Tree, to: impl Fn(Vec3) -> Vec3) -> Tree {
    let mut tree = tree.clone();
    tree.position.iter_mut().for_each(|at| *at = to(*at));
    tree
}

/// Siblings in the opposite order, and left and right exchanged.
pub(super) fn mirrored(tree: &Tree) -> Tree {
    let mut order: Vec<usize> = Vec::new();
    let mut open: Vec<usize> = (0..tree.len())
        .filter(|node| tree.parent[*node] == NO_PARENT)
        .collect();
    while let Some(at) = open.pop() {
        order.push(at);
        // The last is taken first.
        open.extend((0..tree.len()).filter(|node| tree.parent[*node] as usize == at));
    }
    let mut places = vec![NO_PARENT; tree.len()];
    let mut other = Tree {
        letters: tree.letters.clone(),
        ..Tree::default()
    };
    for at in order {
        let parent = tree.parent[at];
        places[at] = other.push(Node {
            parent: if parent == NO_PARENT {
                NO_PARENT
            } else {
                places[parent as usize]
            },
            position: tree.position[at] * Vec3::new(-1.0, 1.0, 1.0),
            radius: tree.radius[at],
            letter: 0,
            order: 0,
            birth: 0,
        });
    }
    other
}

fn judged(a: &Tree, b: &Tree) -> Pair {
    let all = [a, b].map(|tree| Studied::new(tree, DVec3::ZERO));
    let pairs = compare(&all, &AtomicBool::new(false), &mut |_, _| {}).unwrap();
    pairs.into_iter().next().unwrap()
}

/// A tree of so many generations, whose branches are that much shorter from one to the next and turned by pseudo-random angles.
fn plant(generations: u32, shorter: f32, spread: f32, seed: u32) -> Tree {
    let mut random = seed.wrapping_mul(2_654_435_761).wrapping_add(12_345);
    let mut draw = move || {
        random ^= random << 13;
        random ^= random >> 17;
        random ^= random << 5;
        f32::from(u16::try_from(random >> 16).unwrap_or(0)) / 65_535.0
    };
    let mut nodes = vec![(0, [0.0, 10.0, 0.0])];
    let mut tips = vec![(1_u32, Vec3::Y, 10.0_f32)];
    for _ in 0..generations {
        let mut next = Vec::new();
        for (at, way, length) in tips {
            for side in [-1.0, 1.0] {
                let roll = Quat::from_axis_angle(way, std::f32::consts::TAU * draw());
                let pitch = Quat::from_axis_angle(
                    way.any_orthonormal_vector(),
                    side * spread * (0.7 + 0.6 * draw()),
                );
                let way = (roll * pitch * way).normalize();
                let length = length * shorter * (0.8 + 0.4 * draw());
                nodes.push((at, (way * length).to_array()));
                next.push((u32::try_from(nodes.len()).unwrap(), way, length));
            }
        }
        tips = next;
    }
    let mut tree = grown(&nodes);
    for (radius, (_, step)) in tree.radius.iter_mut().skip(1).zip(&nodes) {
        *radius = 0.05 * Vec3::from(*step).length() * (0.8 + 0.4 * draw());
    }
    tree
}

#[test]
fn verdicts_are_what_a_person_would_say() {
    let one = plant(5, 0.8, 0.5, 1);
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.4, 1.3, -0.6);
    let scaled = |by: f32| {
        let mut tree = moved(&one, |at| at * by);
        tree.radius.iter_mut().for_each(|radius| *radius *= by);
        tree
    };
    let line = grown(&[(0, [0.0, 10.0, 0.0])]);
    let y = grown(&[
        (0, [0.0, 10.0, 0.0]),
        (1, [3.0, 5.0, 0.0]),
        (1, [-3.0, 5.0, 0.0]),
    ]);
    let other_y = grown(&[
        (0, [0.0, 10.0, 0.0]),
        (1, [3.0, 6.0, 0.0]),
        (1, [-4.0, 5.0, 0.0]),
    ]);
    for (other, kind, words) in [
        (one.clone(), Kind::Same, "the same tree at the same place"),
        (
            moved(&one, |at| at + 7.0),
            Kind::Same,
            "the same tree at another place",
        ),
        (
            moved(&one, |at| turn * at),
            Kind::Same,
            "the same tree turned",
        ),
        (scaled(2.0), Kind::Same, "the same tree 2.00 times as large"),
        (mirrored(&one), Kind::Same, "the same tree mirrored"),
        (plant(5, 0.8, 0.5, 2), Kind::SameKind, "of the same kind"),
        (
            plant(5, 0.8, 1.2, 2),
            Kind::Different,
            "bifurcation angle is larger in the second",
        ),
        (
            plant(7, 0.8, 0.5, 1),
            Kind::Different,
            "63 and 255 branches",
        ),
        (plant(5, 0.5, 0.5, 3), Kind::Different, "branch length"),
    ] {
        let pair = judged(&one, &other);
        assert_eq!(pair.verdict.kind, kind, "{words}: {:?}", pair.verdict);
        assert!(
            pair.verdict.words.contains(words),
            "{words}: {:?}",
            pair.verdict
        );
    }
    assert_eq!(judged(&y, &other_y).verdict.kind, Kind::TooFew);
    assert_eq!(judged(&line, &line).verdict.kind, Kind::Same);
    // Nothing at all is compared without a fault.
    let nothing = Tree::default();
    for (a, b) in [
        (&nothing, &nothing),
        (&nothing, &one),
        (&grown(&[]), &line),
        (&one, &grown(&[])),
    ] {
        let pair = judged(a, b);
        assert!(pair.space.is_none() && pair.scale == 1.0);
        assert_ne!(pair.verdict.kind, Kind::Same);
    }
}

#[test]
fn progress_goes_to_the_last_pair() {
    let all = [1, 2, 3].map(|seed| Studied::new(&plant(2, 0.8, 0.5, seed), DVec3::ZERO));
    let mut told = Vec::new();
    compare(&all, &AtomicBool::new(false), &mut |done, of| {
        told.push((done, of))
    });
    assert_eq!(told, [(0, 3), (1, 3), (2, 3), (3, 3)]);
}

#[test]
fn a_cancelled_comparison_gives_nothing() {
    let all = [1, 2].map(|seed| Studied::new(&plant(3, 0.8, 0.5, seed), DVec3::ZERO));
    assert!(compare(&all, &AtomicBool::new(true), &mut |_, _| {}).is_none());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// A tree is the same as itself, wherever it stands, in whatever order its siblings are; all numbers that are told are numbers.
    #[test]
    fn the_same_tree_is_the_same(tree in spec(25), angle in 0.0..6.0_f32) {
        prop_assume!(tree.total_length() > 0.0);
        let there = moved(&mirrored(&tree), |at| Quat::from_rotation_z(angle) * at + Vec3::ONE);
        for other in [&tree, &there] {
            let pair = judged(&tree, other);
            prop_assert!(pair.topology.path.as_is.share < 1e-5);
            prop_assert!(pair.topology.radial.scale_free.share < 1e-5);
            prop_assert_eq!(pair.topology.edits, Some(0));
            let space = pair.space.unwrap();
            prop_assert!(space.as_is.max.is_finite() && space.fitted.apart.max.is_finite());
        }
        let pair = judged(&tree, &tree);
        prop_assert_eq!(pair.verdict.kind, Kind::Same);
        prop_assert_eq!(pair.topology.path.as_is.matched, Some(0.0));
        prop_assert!(pair.space.unwrap().as_is.max < 1e-12);
    }
}
