//! Segments: shared rings, frames, flags, and nothing undefined in degenerate trees.

use glam::{Quat, Vec3, vec3};
use proptest::prelude::*;

use super::{any_tree, decent_tree, fork, node, tree_of};
use crate::tree::axes::axis_children;
use crate::tree::growth::bases;
use crate::tree::radii::{RadiusParams, da_vinci};
use crate::tree::tubes::{
    CAPPED, GROWING, LETTER_SHIFT, STARTS, SegmentBuilder, TIP, TubeSegment, segments, unpack_frame,
};
use crate::tree::{NO_PARENT, Tree};

pub(super) fn segments_of(tree: &Tree, before: &[f32], newest: u32) -> Vec<TubeSegment> {
    let mut out = Vec::new();
    segments(tree, before, newest, &mut out);
    out
}

/// Nodes that have a parent, in order: the k-th is segment k.
pub(super) fn segment_nodes(tree: &Tree) -> Vec<usize> {
    (0..tree.len())
        .filter(|&node| tree.parent[node] != NO_PARENT)
        .collect()
}

/// For each node the number of its segment's tube (of a root: none).
pub(super) fn tube_of_nodes(tree: &Tree, records: &[TubeSegment]) -> Vec<Option<usize>> {
    let mut tubes = vec![None; tree.len()];
    let mut count = 0;
    for (&node, segment) in segment_nodes(tree).iter().zip(records) {
        tubes[node] = if segment.flags & STARTS != 0 {
            count += 1;
            Some(count - 1)
        } else {
            tubes[tree.parent[node] as usize]
        };
    }
    tubes
}

fn ring(point: [f32; 3], radii: [f32; 2], frame: [i16; 4], v: f32) -> ([u32; 6], [i16; 4]) {
    let [x, y, z] = point;
    ([x, y, z, radii[0], radii[1], v].map(f32::to_bits), frame)
}

fn first_ring(s: &TubeSegment) -> ([u32; 6], [i16; 4]) {
    ring(s.from, [s.radii[0], s.radii[1]], s.from_frame, s.v_from)
}

fn last_ring(s: &TubeSegment) -> ([u32; 6], [i16; 4]) {
    ring(s.to, [s.radii[2], s.radii[3]], s.to_frame, s.v_to)
}

#[test]
fn a_fork_is_two_tubes() {
    let tree = fork();
    let records = segments_of(&tree, &[], 4);
    let flags: Vec<u32> = records.iter().map(|s| s.flags).collect();
    assert_eq!(flags, [STARTS, 0, CAPPED, STARTS, GROWING | CAPPED]);
    assert_eq!(last_ring(&records[0]), first_ring(&records[1]));
    assert_eq!(last_ring(&records[3]), first_ring(&records[4]));
    let branch = &records[3];
    assert_eq!(
        branch.from,
        tree.position[1].to_array(),
        "begins inside the trunk, round its node"
    );
    assert_eq!(
        branch.radii[..2],
        [tree.radius[4]; 2],
        "as thick as itself, not as the trunk"
    );
    assert_eq!(records[4].base, tree.position[4].to_array());
}

#[test]
fn a_branch_never_begins_thicker_than_its_trunk() {
    let mut tree = fork();
    tree.radius[4] = 0.5;
    assert_eq!(segments_of(&tree, &[], 9)[3].radii[1], tree.radius[1]);
}

#[test]
fn letters_stand_in_the_upper_bits() {
    let mut tree = fork();
    tree.letters = (0..70).map(|i| i.to_string()).collect();
    tree.letter = vec![0, 0, 1, 2, 3, 69].into();
    let letters: Vec<u32> = segments_of(&tree, &[], 9)
        .iter()
        .map(|s| s.flags >> LETTER_SHIFT)
        .collect();
    assert_eq!(letters, [0, 1, 2, 3, 69]);
}

/// Chains that tempt a builder into 0/0: no number may be undefined, frames stay unit, tubes end where a bend is sharp.
#[test]
fn degenerate_chains() {
    let table: [(&str, Vec<Vec3>, usize); 8] = [
        ("one point", vec![Vec3::ZERO; 4], 1),
        (
            "coincident first",
            vec![Vec3::ZERO, Vec3::ZERO, Vec3::Y, 2.0 * Vec3::Y],
            1,
        ),
        ("coincident last", vec![Vec3::ZERO, Vec3::Y, Vec3::Y], 1),
        (
            "back by 180°",
            vec![Vec3::ZERO, Vec3::Y, Vec3::ZERO, Vec3::Y],
            3,
        ),
        ("downward", vec![Vec3::ZERO, Vec3::NEG_Y, -2.0 * Vec3::Y], 1),
        (
            "zigzag of 90°",
            vec![
                Vec3::ZERO,
                Vec3::Y,
                vec3(1.0, 1.0, 0.0),
                vec3(1.0, 2.0, 0.0),
            ],
            1,
        ),
        ("tiny", vec![Vec3::ZERO, 1e-7 * Vec3::Y, 2e-7 * Vec3::X], 1),
        ("huge", vec![Vec3::ZERO, 1e38 * Vec3::Y, -2e38 * Vec3::Y], 2),
    ];
    for (name, points, tubes) in table {
        for radius in [0.0, 0.1] {
            let nodes: Vec<_> = (0_u32..)
                .zip(&points)
                .map(|(i, &p)| node(i.checked_sub(1).unwrap_or(NO_PARENT), p, radius, 0, i))
                .collect();
            let tree = tree_of(&nodes);
            let records = segments_of(&tree, &[], 2);
            check_sound(&tree, &records).unwrap();
            assert_eq!(
                records.iter().filter(|s| s.flags & STARTS != 0).count(),
                tubes,
                "{name}"
            );
            assert_eq!(
                records.iter().filter(|s| s.flags & CAPPED != 0).count(),
                tubes,
                "{name}"
            );
        }
    }
    assert!(segments_of(&Tree::default(), &[], 0).is_empty());
    assert!(segments_of(&tree_of(&[node(NO_PARENT, Vec3::ZERO, 1.0, 0, 0)]), &[], 0).is_empty());
}

/// All numbers defined, frames unit, and every segment either starts a tube or holds its parent's last ring bit for bit.
fn check_sound(tree: &Tree, records: &[TubeSegment]) -> Result<(), TestCaseError> {
    let nodes = segment_nodes(tree);
    prop_assert_eq!(nodes.len(), records.len());
    let axis = axis_children(tree);
    let mut record_of = vec![None; tree.len()];
    let mut continued = vec![false; records.len()];
    for (index, (&node, s)) in nodes.iter().zip(records).enumerate() {
        record_of[node] = Some(index);
        let numbers = [
            &s.from[..],
            &s.to[..],
            &s.base[..],
            &s.radii[..],
            &[s.v_from, s.v_to][..],
        ]
        .concat();
        prop_assert!(numbers.iter().all(|n| n.is_finite()), "{:?}", s);
        prop_assert!(s.v_to >= s.v_from);
        for frame in [s.from_frame, s.to_frame] {
            let length: f64 = frame
                .iter()
                .map(|&q| (f64::from(q) / 32767.0).powi(2))
                .sum::<f64>()
                .sqrt();
            prop_assert!((length - 1.0).abs() < 1e-4, "{frame:?}");
        }
        let below = tree.parent[node] as usize;
        if s.flags & STARTS == 0 {
            let parent: usize = record_of[below]
                .ok_or_else(|| TestCaseError::fail("a root has no ring to continue"))?;
            prop_assert_eq!(axis[below] as usize, node, "only the axis child goes on");
            prop_assert_eq!(last_ring(&records[parent]), first_ring(s));
            continued[parent] = true;
        } else {
            prop_assert_eq!(s.from_frame[..].len(), 4);
            prop_assert_eq!(s.v_from, 0.0);
        }
    }
    for (index, s) in records.iter().enumerate() {
        prop_assert_eq!(
            s.flags & CAPPED != 0,
            !continued[index],
            "a tube is capped where nothing goes on"
        );
    }
    Ok(())
}

fn direction(s: &TubeSegment) -> Vec3 {
    (Vec3::from(s.to) - Vec3::from(s.from)).normalize()
}

proptest! {
    #[test]
    fn any_tree_makes_sound_segments(mut tree in any_tree(), newest in 0_u32..40) {
        let before = da_vinci(&mut tree, &RadiusParams::default(), newest);
        let records = segments_of(&tree, &before, newest);
        check_sound(&tree, &records)?;
        let bases = bases(&tree, newest);
        for (&node, s) in segment_nodes(&tree).iter().zip(&records) {
            let base = bases[node] as usize;
            prop_assert_eq!(s.flags & GROWING != 0, base != node);
            prop_assert_eq!(s.base, tree.position[base].to_array());
            let child = |whole: bool| {
                (0..tree.len()).any(|at| tree.parent[at] as usize == node && (!whole || bases[at] as usize == at))
            };
            let end = |bears: bool, radius: f32| if bears { radius } else { radius * TIP };
            prop_assert_eq!(
                [s.radii[2], s.radii[3]],
                [end(child(true), before[node]), end(child(false), tree.radius[node])],
                "tips taper, now and one step earlier"
            );
            prop_assert!(s.radii[0] >= s.radii[2] && s.radii[1] >= s.radii[3], "da Vinci's tubes never widen");
        }
    }

    /// Rings stand half-way in each bend, and frames turn no more than the bend does.
    #[test]
    fn frames_are_mitred_and_minimal(tree in decent_tree()) {
        let records = segments_of(&tree, &[], u32::MAX);
        let nodes = segment_nodes(&tree);
        let mut frame_of = vec![Quat::IDENTITY; tree.len()];
        let mut record_of = vec![usize::MAX; tree.len()];
        for (index, (&node, s)) in nodes.iter().zip(&records).enumerate() {
            record_of[node] = index;
            let along = direction(s);
            let below = tree.parent[node] as usize;
            // The oracle: the whole bend at once, by glam, from the segment below (or from the vertical).
            let under = match record_of[below] {
                usize::MAX => Vec3::Y,
                index => direction(&records[index]),
            };
            frame_of[node] = Quat::from_rotation_arc(under, along) * frame_of[below];
            prop_assert!((frame_of[node] * Vec3::Y).distance(along) < 1e-3);
            let first = unpack_frame(s.from_frame);
            if s.flags & STARTS != 0 {
                prop_assert!((first * Vec3::Y).distance(along) < 1e-3);
                prop_assert!((first * Vec3::X).distance(frame_of[node] * Vec3::X) < 1e-3);
            } else {
                let half = (under + along).normalize();
                prop_assert!((first * Vec3::Y).distance(half) < 1e-3, "the ring halves the bend");
                let halfway = Quat::from_rotation_arc(under, half) * frame_of[below];
                prop_assert!((first * Vec3::X).distance(halfway * Vec3::X) < 2e-3, "no twist");
            }
        }
    }

    /// The builder's scratch memory leaves no trace, and a second call of the same size allocates nothing.
    #[test]
    fn a_used_builder_gives_the_same(first in any_tree(), second in any_tree()) {
        let mut builder = SegmentBuilder::default();
        let mut out = Vec::new();
        builder.build(&first, &[], 3, &mut out);
        builder.build(&second, &[], 3, &mut out);
        prop_assert_eq!(&out, &segments_of(&second, &[], 3));
        let place = (out.as_ptr(), out.capacity());
        builder.build(&second, &[], 3, &mut out);
        prop_assert_eq!(place, (out.as_ptr(), out.capacity()));
    }
}

#[test]
fn texture_length_counts_circumferences() {
    let tree = tree_of(&[
        node(NO_PARENT, Vec3::ZERO, 0.1, 0, 0),
        node(0, Vec3::Y, 0.1, 0, 1),
        node(1, 3.0 * Vec3::Y, 0.05, 0, 1),
    ]);
    let records = segments_of(&tree, &[], 9);
    let turn = std::f32::consts::TAU;
    assert!((records[0].v_to - 1.0 / (turn * 0.1)).abs() < 1e-5);
    assert_eq!(records[0].v_to, records[1].v_from);
    assert!((records[1].v_to - records[1].v_from - 2.0 / (turn * 0.075)).abs() < 1e-4);
}

/// A tip that grows on begins the step as thin as it ended the last one.
#[test]
fn a_tip_that_grows_on_does_not_jump() {
    let pole = |nodes: u16| {
        let nodes: Vec<_> = (0..u32::from(nodes))
            .map(|i| {
                let at = i as f32 * Vec3::Y;
                node(i.checked_sub(1).unwrap_or(NO_PARENT), at, 0.1, 0, i)
            })
            .collect();
        tree_of(&nodes)
    };
    let (earlier, mut later) = (pole(3), pole(4));
    let before = da_vinci(
        &mut later,
        &RadiusParams {
            tip_radius: 0.1,
            exponent: 2.0,
        },
        3,
    );
    let [was, is] = [
        segments_of(&earlier, &[], 2),
        segments_of(&later, &before, 3),
    ];
    assert_eq!(was[1].radii[3], 0.1 * TIP, "a tip");
    for (was, is) in was.iter().zip(&is) {
        assert_eq!([was.radii[1], was.radii[3]], [is.radii[0], is.radii[2]]);
        assert_eq!(
            [was.v_from, was.v_to],
            [is.v_from, is.v_to],
            "nor does its texture"
        );
    }
    assert_eq!([is[1].radii[3], is[2].radii[3]], [0.1, 0.1 * TIP]);
}
