//! Da Vinci's rule at every node, now and one step earlier.

use proptest::prelude::*;

use super::{any_tree, between, fork};
use crate::tree::axes::Children;
use crate::tree::radii::{FitParams, RadiusParams, da_vinci, da_vinci_given, fit, for_picture};
use crate::tree::{NO_PARENT, Node, Tree};
use glam::Vec3;

/// The tree of nodes with `birth < newest`, and for each of its nodes the index in the whole tree.
pub(super) fn earlier(tree: &Tree, newest: u32) -> (Tree, Vec<usize>) {
    let mut old = Tree {
        letters: tree.letters.clone(),
        ..Tree::default()
    };
    let mut index = vec![NO_PARENT; tree.len()];
    let mut kept = Vec::new();
    for node in 0..tree.len() {
        let parent = tree.parent[node];
        if parent != NO_PARENT && tree.birth[node] >= newest {
            continue;
        }
        index[node] = old.push(Node {
            parent: if parent == NO_PARENT {
                NO_PARENT
            } else {
                index[parent as usize]
            },
            position: tree.position[node],
            radius: tree.radius[node],
            letter: tree.letter[node],
            order: tree.order[node],
            birth: tree.birth[node],
        });
        kept.push(node);
    }
    old.validate().unwrap();
    (old, kept)
}

#[test]
fn what_is_given_stays_and_is_carried() {
    let params = RadiusParams {
        tip_radius: 0.01,
        exponent: 2.0,
    };
    let mut tree = fork();
    // One of the two tips is given, and thick.
    let given = [0.0, 0.0, 0.0, 0.0, 0.03, 0.0];
    let before = da_vinci_given(&mut tree, &params, 4, &given);
    let mut plain = fork();
    let plain_before = da_vinci(&mut plain, &params, 4);
    assert_eq!(tree.radius[4], 0.03);
    for node in 0..tree.len() {
        let above = [4].iter().any(|tip| {
            let mut at = *tip;
            while at != node as u32 && tree.parent[at as usize] != NO_PARENT {
                at = tree.parent[at as usize];
            }
            at == node as u32
        });
        let expected = match (node, above) {
            (4, _) => 0.03,
            // The same, but for what the given one adds to a tip's.
            (_, true) => (plain.radius[node].powi(2) - 0.01_f32.powi(2) + 0.03_f32.powi(2)).sqrt(),
            (_, false) => plain.radius[node],
        };
        assert!((tree.radius[node] - expected).abs() < 1e-7, "{node}");
    }
    // What was not there before has no radius before, given or not.
    for (node, before) in before.iter().enumerate() {
        assert_eq!(*before > 0.0, plain_before[node] > 0.0, "{node}");
    }
}

proptest! {
    #[test]
    fn where_nothing_is_given_all_is_da_vincis(tree in any_tree(), newest in 0_u32..6, exponent in 1.0_f32..4.0) {
        let params = RadiusParams { tip_radius: 0.01, exponent };
        let [mut one, mut other] = [tree.clone(), tree];
        let before = da_vinci(&mut one, &params, newest);
        let given = vec![0.0; other.len()];
        let given_before = da_vinci_given(&mut other, &params, newest, &given);
        for (a, b) in one.radius.iter().zip(other.radius.iter()).chain(before.iter().zip(&given_before)) {
            prop_assert!((a - b).abs() <= 1e-5 * a.abs(), "{} {}", a, b);
        }
    }
}

#[test]
fn a_fork_has_the_sum_of_its_branches() {
    let mut tree = fork();
    let tip = 0.01_f32;
    let before = da_vinci(
        &mut tree,
        &RadiusParams {
            tip_radius: tip,
            exponent: 2.0,
        },
        4,
    );
    let two = tip * 2.0_f32.sqrt();
    assert_eq!(tree.radius, [two, two, tip, tip, tip, tip]);
    assert_eq!(
        before,
        [two, two, tip, tip, tip, 0.0],
        "node 4 was a tip, node 5 was not there"
    );
    let before = da_vinci(
        &mut tree,
        &RadiusParams {
            tip_radius: tip,
            exponent: 2.0,
        },
        3,
    );
    assert_eq!(before, [tip, tip, tip, 0.0, 0.0, 0.0]);
    let before = da_vinci(
        &mut tree,
        &RadiusParams {
            tip_radius: tip,
            exponent: 2.0,
        },
        1,
    );
    assert_eq!(before, [0.0; 6], "a root alone has no thickness");
}

#[test]
fn parameters_outside_their_ranges_are_named_and_clamped() {
    let good = RadiusParams::default();
    assert!(good.validate().is_ok());
    for (tip_radius, exponent, name) in [
        (
            30.3,
            2.0,
            "the tip radius (metres) is 30.3, but must lie between 1e-6 and 10",
        ),
        (1e30, 2.0, "is 1e30, but"),
        (0.01, 0.3, "the radius exponent is 0.3, but"),
        (0.0, 2.0, "tip radius"),
        (-1.0, 2.0, "tip radius"),
        (f32::NAN, 2.0, "tip radius"),
        (f32::INFINITY, 2.0, "tip radius"),
        (0.01, 0.0, "exponent"),
        (0.01, 9.0, "exponent"),
        (0.01, f32::NAN, "exponent"),
    ] {
        let params = RadiusParams {
            tip_radius,
            exponent,
        };
        let message = params.validate().unwrap_err().to_string();
        assert!(
            message.contains(name) && message.contains("between"),
            "{message}"
        );
        assert!(params.clamped().validate().is_ok(), "{params:?}");
        let mut tree = fork();
        da_vinci(&mut tree, &params, 4);
        assert!(
            tree.radius.iter().all(|r| r.is_finite() && *r > 0.0),
            "{params:?}"
        );
    }
}

proptest! {
    #[test]
    fn cross_sections_add_up_at_every_node(mut tree in any_tree(), exponent in between(1.0, 4.0), tip_radius in between(1e-4, 0.1), newest in 0_u32..40) {
        let params = RadiusParams { tip_radius, exponent };
        let before = da_vinci(&mut tree, &params, newest);
        let children = Children::new(&tree);
        let power = |radius: f32| f64::from(radius).powf(f64::from(exponent));
        for node in 0..tree.len() {
            let own = power(tree.radius[node]);
            let sum: f64 = children.of(node as u32).iter().map(|&c| power(tree.radius[c as usize])).sum();
            let expected = if sum == 0.0 { power(tip_radius) } else { sum };
            prop_assert!((own - expected).abs() <= 2e-5 * expected, "node {node}: {own} and {expected}");
        }

        // One step earlier: the same rule on the tree that stood then.
        let (mut old, kept) = earlier(&tree, newest);
        da_vinci(&mut old, &params, 0);
        let mut expected = vec![0.0; tree.len()];
        let has_child: Vec<bool> = (0..old.len()).map(|n| old.parent.contains(&(n as u32))).collect();
        for (old_node, &node) in kept.iter().enumerate() {
            let bare_root = old.parent[old_node] == NO_PARENT && !has_child[old_node];
            expected[node] = if bare_root { 0.0 } else { old.radius[old_node] };
        }
        prop_assert_eq!(before, expected);
    }
}

#[test]
fn widths_without_a_unit_are_fitted_and_real_ones_stay() {
    for (radius, expected) in [
        (5.0, Some(0.01)), // 2 m × 0.025 / 5 m
        (0.41, Some(0.05 / 0.41)),
        (0.4, None),
        (0.02, None),
        (0.0, None),
    ] {
        let mut tree = Tree {
            letters: vec!["F".into()],
            ..Tree::default()
        };
        let node = |parent, y, radius| Node {
            parent,
            position: Vec3::new(0.0, y, 0.0),
            radius,
            letter: 0,
            order: 0,
            birth: 0,
        };
        let root = tree.push(node(NO_PARENT, 0.0, radius));
        tree.push(node(root, 2.0, radius * 0.5));
        let factor = fit(&mut tree, &FitParams::default());
        match (factor, expected) {
            (Some(factor), Some(expected)) => {
                assert!((factor - expected).abs() < 1e-6, "{radius}: {factor}");
                assert_eq!(tree.radius[1], tree.radius[0] * 0.5, "ratios stay");
            }
            (factor, expected) => assert_eq!(factor, expected, "{radius}"),
        }
    }
    assert_eq!(fit(&mut Tree::default(), &FitParams::default()), None);
}

#[test]
fn uniform_lines_are_drawn_for_the_eye_and_widths_that_differ_keep_their_ratios() {
    // Segments of 1, 1 and 4 m.
    let row = |radii: [f32; 4]| {
        let mut tree = Tree {
            letters: vec!["F".into()],
            ..Tree::default()
        };
        for (parent, (y, radius)) in [NO_PARENT, 0, 1, 2]
            .into_iter()
            .zip([0.0, 1.0, 2.0, 6.0].into_iter().zip(radii))
        {
            tree.push(Node {
                parent,
                position: Vec3::new(0.0, y, 0.0),
                radius,
                letter: 0,
                order: 0,
                birth: 0,
            });
        }
        tree
    };
    for (name, radii, finest, expected) in [
        ("a hairline", [0.01; 4], 0.05, [0.05; 4]),
        ("a good line", [0.06; 4], 0.05, [0.06; 4]),
        ("thicker than long", [3.0; 4], 0.01, [0.08; 4]),
        ("a pixel is wider than that", [3.0; 4], 0.1, [0.1; 4]),
        (
            "a trunk",
            [3.0, 2.0, 1.0, 0.01],
            0.05,
            [3.0, 2.0, 1.0, 0.05],
        ),
        ("nothing is drawn", [0.0; 4], 0.05, [0.0; 4]),
    ] {
        let mut tree = row(radii);
        for_picture(&mut tree, finest);
        assert_eq!(tree.radius, expected, "{name}");
    }
    for_picture(&mut Tree::default(), 1.0);
}
