//! Each cut shows everything once, and what it shows is as near to the tree as it says.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "tests"
)]

use std::slice::from_ref;

use glam::{Affine3A, Vec3, Vec4};
use proptest::prelude::*;

use super::cut::{self, NEVER, Standing, Views};
use super::kinds::{KINDS, Kind, LEAVES_BELOW, kind_of, of_tubes, triangles};
use super::*;
use crate::tree::tubes::{CAPPED, SegmentBuilder, TubeSegment};
use crate::tree::{NO_PARENT, Node, Tree};

/// A tree of so many nodes: each stands on one of the last few, or on any.
fn tree(choices: &[(u8, u16)]) -> Tree {
    let mut tree = Tree {
        letters: vec!["F".to_owned()],
        ..Tree::default()
    };
    for (at, (how, any)) in choices.iter().enumerate() {
        let parent = match how % 16 {
            _ if at == 0 => NO_PARENT,
            0 => NO_PARENT,
            1..9 => at as u32 - 1,
            _ => u32::from(*any) % at as u32,
        };
        let chance = f32::from(*any) / 65535.0;
        let from = tree.position.get(parent as usize).copied();
        let turn = Vec3::new((chance * 40.0).sin(), 1.0, (chance * 57.0).cos());
        tree.push(Node {
            parent,
            position: from.unwrap_or(Vec3::X * at as f32) + turn * 0.1,
            radius: 0.001 + 0.02 * chance,
            order: 0,
            letter: 0,
            birth: at as u32 % 5,
        });
    }
    tree.validate().unwrap();
    tree
}

fn ordered(tree: &Tree, newest: u32) -> Vec<TubeSegment> {
    let mut builder = SegmentBuilder::default();
    let mut segments = Vec::new();
    builder.build(tree, &[], newest, &mut segments);
    let order = along_axes(tree, builder.axis());
    order.iter().map(|at| segments[*at as usize]).collect()
}

/// The same order by recursion.
fn by_recursion(tree: &Tree, axis: &[u32]) -> Vec<u32> {
    fn visit(tree: &Tree, axis: &[u32], node: u32, out: &mut Vec<u32>) {
        out.push(node);
        if axis[node as usize] != NO_PARENT {
            visit(tree, axis, axis[node as usize], out);
        }
        for child in 0..tree.len() as u32 {
            if tree.parent[child as usize] == node && axis[node as usize] != child {
                visit(tree, axis, child, out);
            }
        }
    }
    let mut nodes = Vec::new();
    for root in 0..tree.len() as u32 {
        if tree.parent[root as usize] == NO_PARENT {
            visit(tree, axis, root, &mut nodes);
        }
    }
    // A record for each node that has a parent.
    let mut count = 0;
    let number = |parent: &u32| {
        count += u32::from(*parent != NO_PARENT);
        count.wrapping_sub(1)
    };
    let records: Vec<u32> = tree.parent.iter().map(number).collect();
    nodes.retain(|node| tree.parent[*node as usize] != NO_PARENT);
    nodes.iter().map(|node| records[*node as usize]).collect()
}

/// Some eyes that look at a place from a distance.
fn views(at: Vec3, distance: f32) -> Views {
    Views {
        planes: [[Vec4::W; 4]; 2],
        eyes: [-0.03, 0.03].map(|x| (at + Vec3::new(x, 0.0, distance)).extend(500.0)),
    }
}

fn standing() -> Standing {
    Standing::new(Affine3A::IDENTITY, Vec4::ZERO, false, 0.05)
}

/// For each cluster the numbers of its children's clusters: those that it replaces. Parents come in the order of their children.
fn children<R: Record>(levels: &Levels<R>) -> Vec<Vec<usize>> {
    let clusters = &levels.clusters;
    let mut all = vec![Vec::new(); clusters.len()];
    let mut parent = levels.finest;
    for (nth, child) in clusters.iter().enumerate() {
        if child.parent_error < 0.0 {
            continue;
        }
        let is_parent = |at: usize| {
            clusters[at].own == child.parent && clusters[at].own_error == child.parent_error
        };
        while !is_parent(parent) {
            parent += 1;
        }
        all[parent].push(nth);
    }
    all
}

/// How often each finest cluster is shown, by itself or by what replaces it.
fn shown<R: Record>(levels: &Levels<R>, is_drawn: impl Fn(&Cluster) -> bool) -> Vec<usize> {
    let children = children(levels);
    let mut times = vec![0; levels.clusters.len()];
    for at in (0..levels.clusters.len()).rev() {
        times[at] += usize::from(is_drawn(&levels.clusters[at]));
        for child in &children[at] {
            times[*child] += times[at];
        }
    }
    times.truncate(levels.finest);
    times
}

proptest! {
    #[test]
    fn the_order_is_that_of_a_walk_along_axes(choices in prop::collection::vec(any::<(u8, u16)>(), 1..120)) {
        let tree = tree(&choices);
        let axis = crate::tree::axes::axis_children(&tree);
        prop_assert_eq!(along_axes(&tree, &axis), by_recursion(&tree, &axis));
    }

    /// Whatever may be off: each part of a tree is shown once, errors and spheres grow.
    #[test]
    fn every_cut_shows_everything_once(
        choices in prop::collection::vec(any::<(u8, u16)>(), 600..2500),
        distance in 0.1_f32..200.0,
        threshold in 0_u32..cut::COARSEST,
        newest in 0_u32..6,
    ) {
        let segments = ordered(&tree(&choices), newest);
        let levels = Levels::new(&segments);
        prop_assume!(segments.len() > 600);
        let fewest = segments.len().div_ceil(MOST);
        prop_assert!((fewest..=fewest + segments.len() / 512).contains(&levels.finest));
        let views = views(Vec3::ZERO, distance);
        let is_drawn = |cluster: &Cluster| {
            cluster.bins(&standing(), &views).is_some_and(|bins| cut::is_drawn(bins, threshold))
        };
        prop_assert!(shown(&levels, is_drawn).iter().all(|times| *times == 1));
        for (at, cluster) in levels.clusters.iter().enumerate() {
            let records = levels.records_of(from_ref(cluster));
            prop_assert!(records.len() <= MOST);
            let ends = records.iter().filter(|record| record.flags & CAPPED != 0).count();
            prop_assert!(records[..ends].iter().all(|record| record.flags & CAPPED != 0));
            prop_assert_eq!(cluster.ends as usize, ends.div_ceil(BATCH));
            if at < levels.finest {
                prop_assert_eq!(cluster.own_error, 0.0);
            }
            if cluster.parent_error >= 0.0 {
                prop_assert!(cluster.parent_error >= cluster.own_error);
                let apart = cluster.parent.truncate().distance(cluster.own.truncate());
                prop_assert!(apart + cluster.own.w <= cluster.parent.w * 1.0001 + 1e-6);
            }
        }
        let last = levels.clusters.last().unwrap();
        prop_assert!(last.parent_error < 0.0);
        prop_assert_eq!(levels.clusters.iter().filter(|c| c.parent_error < 0.0).count(), 1);
    }

    /// No more than it takes, to the last record.
    #[test]
    fn few_segments_have_one_level(count in 1_usize..500) {
        let choices: Vec<(u8, u16)> = (0..count).map(|at| (1 + (at % 15) as u8, (at * 997 % 65536) as u16)).collect();
        let segments = ordered(&tree(&choices), 9);
        let levels = Levels::new(&segments);
        prop_assert_eq!(levels.clusters.len(), levels.finest);
        let records = levels.batches.as_flattened().iter().filter(|record| **record != TubeSegment::default());
        prop_assert_eq!(records.count(), segments.len());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, max_shrink_iters: 0, ..ProptestConfig::default() })]

    /// A branch more and a node that is thicker change the clusters about it, and those that stand for them.
    #[test]
    fn what_is_not_edited_stays(seed in any::<u64>(), edited in any::<prop::sample::Index>(), more in 0_usize..40) {
        let choices: Vec<(u8, u16)> = (0..30_000)
            .map(|at| stirred(seed, at).to_le_bytes())
            .map(|bytes| (bytes[0], u16::from_le_bytes([bytes[1], bytes[2]])))
            .collect();
        let before = ordered(&tree(&choices), 9);
        let mut after = before.clone();
        let at = edited.index(before.len());
        after[at].radii[3] *= 1.5;
        let branch = (0..more).map(|nth| TubeSegment { to: [nth as f32, 7.0, 7.0], ..before[at] });
        after.splice(at..at, branch);
        let of = |segments: &[TubeSegment]| -> Vec<Vec<u8>> {
            let levels = Levels::new(segments);
            levels.clusters.iter().map(|cluster| levels.bytes_of(from_ref(cluster)).to_vec()).collect()
        };
        let known: std::collections::HashSet<Vec<u8>> = of(&before).into_iter().collect();
        let after = of(&after);
        let new = after.iter().filter(|bytes| !known.contains(*bytes)).count();
        prop_assert!(new * 3 <= after.len(), "{new} of {}", after.len());
    }
}

/// A long axis that winds: nothing goes but nodes, so each of these is as near to what stands for it as its cluster says.
#[test]
fn an_axis_is_nowhere_off_by_more_than_is_said() {
    let mut tree = Tree {
        letters: vec!["F".to_owned()],
        ..Tree::default()
    };
    let mut seed = 7_u32;
    let mut position = Vec3::ZERO;
    for at in 0..4000_u32 {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let chance = (seed >> 8) as f32 / (1 << 24) as f32;
        let turn = at as f32 * 0.01;
        position += Vec3::new(turn.sin(), 1.0, turn.cos() + chance - 0.5) * 0.02;
        tree.push(Node {
            parent: at.wrapping_sub(1),
            position,
            radius: 0.03 + 0.01 * chance,
            order: 0,
            letter: 0,
            birth: 0,
        });
    }
    let levels = Levels::new(&ordered(&tree, 9));
    let children = children(&levels);
    let mut leaves: Vec<Vec<usize>> = (0..levels.clusters.len())
        .map(|at| {
            if at < levels.finest {
                vec![at]
            } else {
                Vec::new()
            }
        })
        .collect();
    let mut coarsest = 0.0_f32;
    for at in levels.finest..levels.clusters.len() {
        leaves[at] = children[at]
            .iter()
            .flat_map(|child| leaves[*child].clone())
            .collect();
        let cluster = &levels.clusters[at];
        let records = |cluster: &Cluster| {
            levels
                .records_of(from_ref(cluster))
                .iter()
                .filter(|record| record.size() > 0.0)
        };
        let mut most = 0.0_f32;
        for leaf in &leaves[at] {
            for fine in records(&levels.clusters[*leaf]) {
                let node = Vec3::from(fine.to);
                let off = records(cluster).map(|coarse| {
                    let (from, to) = (Vec3::from(coarse.from), Vec3::from(coarse.to));
                    let along = ((node - from).dot(to - from) / (to - from).length_squared())
                        .clamp(0.0, 1.0);
                    let radius = coarse.radii[1] + along * (coarse.radii[3] - coarse.radii[1]);
                    node.distance(from + (to - from) * along)
                        .max((radius - fine.radii[3]).abs())
                });
                most = most.max(off.fold(f32::INFINITY, f32::min));
            }
        }
        assert!(
            most <= cluster.own_error * 1.0001 + 1e-6,
            "{most} of {}",
            cluster.own_error
        );
        coarsest = coarsest.max(cluster.own_error);
        // It ends in rings that are the tree's own.
        for coarse in records(cluster) {
            let is = |fine: &TubeSegment| fine.to == coarse.to && fine.to_frame == coarse.to_frame;
            let coarser = levels.clusters[levels.finest].first as usize;
            assert!(levels.batches[..coarser].as_flattened().iter().any(is));
        }
    }
    // Worth having: the whole axis in 64 segments is off by a few times its radius at most.
    assert!(coarsest > 0.0 && coarsest < 0.5, "{coarsest}");
}

/// Twigs that stand apart can only go, and others grow wider: what is shown of them together stays.
#[test]
fn twigs_that_go_leave_their_width_to_others() {
    let mut tree = Tree {
        letters: vec!["F".to_owned()],
        ..Tree::default()
    };
    for at in 0..2000_u32 {
        let foot = Vec3::new((at % 50) as f32, 0.0, (at / 50) as f32) * 0.01;
        for (parent, position) in [(NO_PARENT, foot), (2 * at, foot + Vec3::Y * 0.05)] {
            tree.push(Node {
                parent,
                position,
                radius: 0.0005,
                order: 0,
                letter: 0,
                birth: 0,
            });
        }
    }
    let levels = Levels::new(&ordered(&tree, 9));
    let shown = |clusters: &[Cluster]| -> f32 {
        let of = |cluster: &Cluster| {
            let records = levels.records_of(from_ref(cluster)).iter();
            records
                .map(|one| {
                    (one.radii[1] + one.radii[3]) * Vec3::from(one.from).distance(one.to.into())
                })
                .sum::<f32>()
        };
        clusters.iter().map(of).sum()
    };
    let all = shown(&levels.clusters[..levels.finest]);
    let coarsest = levels.clusters.last().unwrap();
    assert!((shown(&[*coarsest]) / all - 1.0).abs() < 1e-3);
    // One in 31 is left, so they are some 31 times as wide as a millimetre (0.6 at their tips).
    assert!(
        (0.02..0.12).contains(&coarsest.own_error),
        "{}",
        coarsest.own_error
    );
}

#[test]
fn leaves_that_go_leave_their_area_to_others() {
    let leaves: Vec<Leaf> = (0..5000)
        .map(|at| Leaf {
            place: (Vec3::new((at % 70) as f32, (at / 70) as f32, 0.0) * 0.05).to_array(),
            scale: if at % 3 == 0 { -0.1 } else { 0.1 },
            light: 0.5,
            ..Leaf::default()
        })
        .collect();
    let levels = LeafLevels::new(&leaves);
    let area = |clusters: &[Cluster]| -> f32 {
        let of = |cluster: &Cluster| {
            levels
                .records_of(from_ref(cluster))
                .iter()
                .map(|leaf| leaf.scale * leaf.scale)
                .sum::<f32>()
        };
        clusters.iter().map(of).sum()
    };
    let all = area(&levels.clusters[..levels.finest]);
    assert!((all / 50.0 - 1.0).abs() < 1e-3);
    // Half of the leaves may be off by half a leaf, a fourth by a whole one; more where three clusters became one.
    let (children, mut level, mut many, mut threes) =
        (children(&levels), 0..levels.finest, 1.0, 1.0);
    while level.len() > 1 {
        let is_next = |at: &usize| children[*at].iter().all(|child| level.contains(child));
        level = level.end
            ..level.end
                + (level.end..levels.clusters.len())
                    .take_while(is_next)
                    .count();
        let clusters = &levels.clusters[level.clone()];
        assert!((area(clusters) / all - 1.0).abs() < 1e-3, "{level:?}");
        (many, threes) = (many * 2.0, threes * 2.0);
        assert!(
            clusters
                .iter()
                .all(|cluster| cluster.own_error <= 0.1 * many * threes / 4.0 * 1.001)
        );
        assert!(
            clusters
                .iter()
                .any(|cluster| cluster.own_error >= 0.1 * many / 4.0 * 0.999)
        );
    }
    assert_eq!(level.end, levels.clusters.len());
    let none: [f32; 4] = LeafLevels::new(&[])
        .clusters
        .first()
        .map_or([0.0; 4], |c| c.own.to_array());
    assert_eq!(none, [0.0; 4]);
}

#[test]
fn kinds_are_chosen_by_size() {
    let tubes = of_tubes();
    for (pixels, kind) in [
        (1e9, 0),
        (64.0, 0),
        (63.9, 1),
        (24.0, 1),
        (10.0, 2),
        (8.0, 2),
        (5.0, 3),
        (2.0, 4),
        (0.0, 4),
    ] {
        assert_eq!(kind_of(&tubes, pixels), kind, "{pixels}");
    }
    let mut leaves = [Kind::default(); KINDS];
    for (kind, below) in leaves.iter_mut().zip(LEAVES_BELOW) {
        kind.below = below;
    }
    assert_eq!(
        [100.0, 12.0, 3.0].map(|pixels| kind_of(&leaves, pixels)),
        [0, 0, 1]
    );
    // A family of one kind.
    leaves[1] = Kind::default();
    assert_eq!(kind_of(&leaves, 0.0), 0);
    let cluster = Cluster {
        batches: 8,
        ends: 3,
        ..Cluster::default()
    };
    let each = [0, 2, 3, 4].map(|kind| triangles(&tubes, &cluster, kind));
    assert_eq!(each, [64 * 32 + 24 * 16, 64 * 10 + 24 * 5, 64 * 6, 64 * 2]);
    assert_eq!(
        cluster.bins(&standing(), &views(Vec3::ZERO, 1.0)),
        Some([0, 0])
    );
    let coarsest = Cluster {
        parent_error: -1.0,
        ..cluster
    };
    assert_eq!(
        coarsest.bins(&standing(), &views(Vec3::ZERO, 1.0)),
        Some([0, NEVER])
    );
}

/// Twigs without width take nobody's place: what is visible stays or its loss is said.
#[test]
fn a_twig_of_no_width_takes_nothing() {
    let mut segments = ordered(&tree(&[(1, 900); 1200]), 9);
    for (at, segment) in segments.iter_mut().enumerate() {
        // Each by itself, so that none goes on from another.
        segment.flags |= CAPPED;
        segment.radii = [if at % 2 == 0 { 0.0 } else { 0.01 }; 4];
    }
    let levels = Levels::new(&segments);
    assert!(
        levels
            .batches
            .iter()
            .flatten()
            .all(|one| one.radii.iter().all(|radius| radius.is_finite()))
    );
    let widest = levels.clusters.iter().map(|cluster| cluster.size);
    assert!(widest.clone().all(f32::is_finite) && widest.fold(0.0, f32::max) >= 0.02);
}

/// What a driver or a grammar may do to numbers: nothing is nowhere for ever.
#[test]
fn records_without_a_place_do_no_harm() {
    let mut segments = ordered(&tree(&[(1, 500); 900]), 9);
    for segment in segments.iter_mut().step_by(7) {
        segment.to = [f32::NAN; 3];
    }
    let levels = Levels::new(&segments);
    assert!(levels.clusters.len() > levels.finest);
    let is_number = |sphere: Vec4| sphere.is_finite();
    assert!(
        levels
            .clusters
            .iter()
            .all(|cluster| is_number(cluster.sphere) && is_number(cluster.own))
    );
    assert!(Levels::<TubeSegment>::new(&[]).clusters.is_empty());
}
