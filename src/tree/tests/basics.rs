//! The tree itself: invariants, counts, children and axes.

use glam::Vec3;
use proptest::prelude::*;

use super::{any_tree, fork, node, tree_of};
use crate::tree::axes::{Children, axis_children};
use crate::tree::{NO_PARENT, Node, Tree, TreeError};

#[test]
fn counts_and_sizes_of_a_small_tree() {
    let tree = fork();
    assert_eq!(
        (tree.len(), tree.segment_count(), tree.root_count()),
        (6, 5, 1)
    );
    assert_eq!(tree.tips(), [3, 5]);
    assert_eq!(tree.bounds(), Some((Vec3::ZERO, Vec3::new(1.0, 3.0, 0.0))));
    let expected = 3.0 + (0.64_f64 + 0.01).sqrt() + (0.04_f64 + 0.64).sqrt();
    assert!((tree.total_length() - expected).abs() < 1e-6);
    let empty = Tree::default();
    assert!(
        empty.is_empty()
            && empty.validate().is_ok()
            && empty.bounds().is_none()
            && empty.tips().is_empty()
    );
    assert_eq!((empty.total_length(), empty.segment_count()), (0.0, 0));
    assert!(axis_children(&empty).is_empty());
}

#[test]
fn each_broken_invariant_is_named() {
    type Break = fn(&mut Tree);
    let table: [(Break, &str); 9] = [
        (|t| t.parent[1] = 1, "node 1 names 1 as its parent"),
        (|t| t.parent[2] = 5, "node 2 names 5"),
        (|t| t.parent[3] = u32::MAX - 1, "node 3 names 4294967294"),
        (|t| t.letter[4] = 1, "node 4 uses letter 1 of 1"),
        (|t| t.position[5].z = f32::NAN, "node 5 has a position"),
        (|t| t.position[0].x = f32::INFINITY, "node 0 has a position"),
        (|t| t.radius[2] = -0.1, "node 2 has the radius -0.1"),
        (|t| t.radius[2] = f32::NAN, "node 2 has the radius NaN"),
        (
            |t| t.order = t.order[..3].to_vec().into(),
            "`order` has 3 entries, `parent` has 6",
        ),
    ];
    for (damage, expected) in table {
        let mut tree = fork();
        damage(&mut tree);
        let message = tree.validate().unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
        assert!(message.contains(": "), "says how to mend it: {message}");
    }
    assert!(matches!(
        Tree {
            parent: vec![NO_PARENT].into(),
            ..Tree::default()
        }
        .validate(),
        Err(TreeError::Lengths { .. })
    ));
}

#[test]
fn the_axis_goes_on_by_order_then_letter_then_age_then_thickness_then_index() {
    let child = |order, letter, birth, radius| Node {
        letter,
        ..node(0, Vec3::Y, radius, order, birth)
    };
    // Each second child wins for one reason only.
    let table: [(&str, Node, Node); 4] = [
        ("order", child(1, 0, 1, 0.9), child(0, 1, 5, 0.1)),
        ("letter", child(0, 1, 1, 0.9), child(0, 0, 5, 0.1)),
        ("age", child(0, 0, 5, 0.9), child(0, 0, 1, 0.1)),
        ("thickness", child(0, 0, 5, 0.1), child(0, 0, 5, 0.9)),
    ];
    for (reason, loser, winner) in table {
        for (nodes, expected) in [([loser, winner], 2), ([winner, loser], 1)] {
            let mut tree = tree_of(&[node(NO_PARENT, Vec3::ZERO, 1.0, 0, 0)]);
            tree.letters.push("C".into());
            for node in nodes {
                tree.push(node);
            }
            tree.validate().unwrap();
            assert_eq!(axis_children(&tree)[0], expected, "by {reason}");
        }
    }
    let twins = tree_of(&[
        node(NO_PARENT, Vec3::ZERO, 1.0, 0, 0),
        node(0, Vec3::Y, 0.1, 1, 1),
        node(0, Vec3::X, 0.1, 1, 1),
    ]);
    assert_eq!(
        axis_children(&twins),
        [1, NO_PARENT, NO_PARENT],
        "a lone bracket goes on, the first of equals"
    );
}

proptest! {
    #[test]
    fn children_are_those_whose_parent_it_is(tree in any_tree()) {
        let children = Children::new(&tree);
        let axis = axis_children(&tree);
        for node in 0..tree.len() as u32 {
            let brute: Vec<u32> = (0..tree.len() as u32).filter(|&c| tree.parent[c as usize] == node).collect();
            prop_assert_eq!(children.of(node), &brute[..]);
            let continuing = axis[node as usize];
            prop_assert_eq!(brute.is_empty(), continuing == NO_PARENT);
            prop_assert!(continuing == NO_PARENT || brute.contains(&continuing));
        }
        prop_assert!(children.of(tree.len() as u32).is_empty() && children.of(u32::MAX).is_empty());
        let tips: Vec<u32> = (0..tree.len() as u32).filter(|&node| children.of(node).is_empty()).collect();
        prop_assert_eq!(tree.tips(), tips);
    }
}
