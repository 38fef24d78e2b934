//! Growth: exact at both ends, continuous and straight between.

use proptest::prelude::*;

use super::radii::earlier;
use super::{any_tree, between, fork, node, tree_of};
use crate::tree::growth::{bases, clamp_growth, grow, grown};
use crate::tree::radii::{RadiusParams, da_vinci};
use crate::tree::{NO_PARENT, Tree};

use glam::Vec3;

#[test]
fn growing_is_exact_at_both_ends_and_where_nothing_changes() {
    for (a, b) in [(0.1_f32, 0.7_f32), (1e-30, 1e30), (-3.3, 3.3), (0.3, 0.3)] {
        assert_eq!(grow(a, b, 0.0), a);
        assert_eq!(grow(a, b, 1.0), b);
        assert_eq!(grow(a, a, 0.3), a);
    }
    assert_eq!(
        [f32::NAN, -1.0, 0.0, 0.5, 7.0].map(clamp_growth),
        [1.0, 0.0, 0.0, 0.5, 1.0]
    );
}

#[test]
fn a_whole_segment_on_a_growing_one_grows_with_it() {
    // 2 is older than 1, on which it stands: a general grammar can insert a segment below.
    let tree = tree_of(&[
        node(NO_PARENT, Vec3::ZERO, 0.1, 0, 0),
        node(0, Vec3::Y, 0.1, 0, 5),
        node(1, 2.0 * Vec3::Y, 0.1, 0, 1),
    ]);
    assert_eq!(bases(&tree, 5), [0, 0, 0]);
    assert_eq!(bases(&tree, 6), [0, 1, 2]);
    let half = grown(&tree, &[], 5, 0.5);
    assert_eq!(half.position, [Vec3::ZERO, 0.5 * Vec3::Y, Vec3::Y]);
}

#[test]
fn half_grown_fork() {
    let mut tree = fork();
    let before = da_vinci(
        &mut tree,
        &RadiusParams {
            tip_radius: 0.01,
            exponent: 2.0,
        },
        4,
    );
    let half = grown(&tree, &before, 4, 0.5);
    assert_eq!(
        half.position[5],
        tree.position[4] + 0.5 * (tree.position[5] - tree.position[4])
    );
    assert_eq!(half.radius[5], 0.005);
    assert_eq!(half.position[..5], tree.position[..5]);
}

proptest! {
    #[test]
    fn growth_begins_at_the_earlier_tree_and_ends_at_the_whole(mut tree in any_tree(), newest in 0_u32..40, exponent in between(1.0, 4.0)) {
        let before = da_vinci(&mut tree, &RadiusParams { exponent, ..RadiusParams::default() }, newest);
        prop_assert_eq!(&grown(&tree, &before, newest, 1.0), &tree);

        let start = grown(&tree, &before, newest, 0.0);
        start.validate().unwrap();
        let (old, kept) = earlier(&tree, newest);
        let mut is_old = vec![false; tree.len()];
        for (old_node, &node) in kept.iter().enumerate() {
            prop_assert_eq!(start.position[node], old.position[old_node]);
            prop_assert_eq!(start.radius[node], before[node]);
            is_old[node] = true;
        }
        for node in (0..tree.len()).filter(|&node| !is_old[node]) {
            let below = tree.parent[node] as usize;
            prop_assert_eq!(start.position[node], start.position[below], "a new segment has no length");
            prop_assert_eq!(start.radius[node], 0.0);
        }
    }

    /// No jump: in steps of 1/64 nothing moves farther than that part of its whole way, lengths of growing segments grow evenly.
    #[test]
    fn growth_is_even(mut tree in any_tree(), newest in 1_u32..20) {
        let before = da_vinci(&mut tree, &RadiusParams::default(), newest);
        let [start, end]: [Tree; 2] = [0.0, 1.0].map(|g| grown(&tree, &before, newest, g));
        let mut last = start.clone();
        for step in 1..=64 {
            let now = grown(&tree, &before, newest, step as f32 / 64.0);
            for node in 0..tree.len() {
                let way = start.position[node].distance(end.position[node]);
                let moved = last.position[node].distance(now.position[node]);
                prop_assert!((moved - way / 64.0).abs() <= 1e-4 * (1.0 + end.position[node].length()));
                let thicker = (end.radius[node] - start.radius[node]) / 64.0;
                prop_assert!((now.radius[node] - last.radius[node] - thicker).abs() <= 1e-6);
            }
            last = now;
        }
    }
}
