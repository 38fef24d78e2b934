//! Any trees, beside the definition taken literally: every line's tube at every point of every other.

use super::super::leave::exits;
use super::super::lines::{Ball, Lines};
use super::super::tube::{Tubes, depth};
use super::*;

/// The way from the root to a tip.
fn way(tree: &Tree, tip: u32) -> Vec<u32> {
    let mut way = vec![tip];
    while tree.parent[way[way.len() - 1] as usize] != NO_PARENT {
        way.push(tree.parent[way[way.len() - 1] as usize]);
    }
    way.reverse();
    way
}

fn ball(tree: &Tree, node: u32) -> Ball {
    Ball {
        centre: tree.position[node as usize].as_dvec3(),
        radius: f64::from(tree.radius[node as usize]),
    }
}

/// The tube function of a whole line.
fn tube(tree: &Tree, way: &[u32], point: glam::DVec3) -> f64 {
    let pairs = way.windows(2);
    let depths = pairs.map(|pair| depth(ball(tree, pair[0]), ball(tree, pair[1]), point));
    depths.fold(f64::INFINITY, f64::min)
}

/// The node behind which each line leaves each other's tube first, once they have parted.
fn first_exits(tree: &Tree) -> Vec<(u32, u32, u32)> {
    let tips = tree.tips();
    let mut found = Vec::new();
    for one in &tips {
        for other in tips.iter().filter(|other| *other != one) {
            let [mine, theirs] = [way(tree, *one), way(tree, *other)];
            let mut own = mine.iter().filter(|node| !theirs.contains(node));
            let out = own.find(|node| tube(tree, &theirs, ball(tree, **node).centre) > 0.0);
            if let Some(out) = out {
                found.push((*one, *other, *out));
            }
        }
    }
    found.sort_unstable();
    found
}

proptest! {
    #[test]
    fn exits_are_those_of_the_definition(
        steps in prop::collection::vec((0_u32..60, -1.0..1.0_f32, -1.0..1.0_f32, 0.1..1.0_f32, 0.1..1.2_f32), 1..60),
    ) {
        let mut tree = Tree::default();
        push(&mut tree, NO_PARENT, Vec3::ZERO, 0.6);
        for (parent, x, y, z, radius) in steps {
            let parent = parent % u32::try_from(tree.len()).unwrap();
            let from = tree.position[parent as usize];
            push(&mut tree, parent, from + Vec3::new(x, y, z), radius);
        }
        let children = Children::new(&tree);
        let lines = Lines::new(&tree, &children);
        let mut tubes = Tubes::new(&lines, u64::MAX);
        let found = exits(&lines, &mut tubes).unwrap();
        let mut told = Vec::new();
        for exit in &found.all {
            let through = lines.tips[exit.at.node as usize];
            for mine in through[0]..through[1] {
                for theirs in exit.left.iter().flat_map(|range| range[0]..range[1]) {
                    told.push((lines.nodes[mine as usize], lines.nodes[theirs as usize], exit.at.node));
                }
            }
            // And there the tube ends.
            let theirs = exit.left.iter().next().unwrap()[0];
            let at = lines.ball_at(exit.at).centre;
            prop_assert!(tube(&tree, &way(&tree, lines.nodes[theirs as usize]), at).abs() < 1e-5);
        }
        told.sort_unstable();
        prop_assert_eq!(told, first_exits(&tree));
    }

    #[test]
    fn what_is_cut_adds_up_whatever_the_tree(
        steps in prop::collection::vec((0_u32..40, -1.0..1.0_f32, -1.0..1.0_f32, 0.1..1.0_f32, 0.0..0.5_f32), 1..40),
    ) {
        let mut tree = Tree::default();
        push(&mut tree, NO_PARENT, Vec3::ZERO, 0.3);
        for (parent, x, y, z, radius) in steps {
            let parent = parent % u32::try_from(tree.len()).unwrap();
            let from = tree.position[parent as usize];
            push(&mut tree, parent, from + 2.0 * Vec3::new(x, y, z), radius);
        }
        let found = split(&tree);
        let kept: f64 = tree.tips().iter().filter(|tip| !found.swallowed.contains(tip)).map(|tip| {
            let pairs = way(&tree, *tip);
            let pairs = pairs.windows(2);
            pairs.map(|pair| ball(&tree, pair[0]).centre.distance(ball(&tree, pair[1]).centre)).sum::<f64>()
        }).sum();
        let tracts = found.branches.iter().map(|branch| &branch.tracts);
        let tracts = tracts.chain(found.bifurcations.iter().map(|one| &one.tracts)).flatten();
        let sum: f64 = tracts.map(|tract| f64::from(tract.lines) * tract.length()).sum();
        prop_assert!((sum - kept).abs() < 1e-6 * kept.max(1.0), "{} of {}", sum, kept);
        // Each has one way in.
        for one in &found.bifurcations {
            prop_assert!(one.frame.normal.is_finite() && one.frame.up.is_finite());
            prop_assert!(one.daughters.len() + usize::from(one.parent.is_some()) > 1);
        }
        let tips = found.branches.iter().filter(|branch| branch.tip.is_some()).count();
        prop_assert!(tips <= tree.tips().len() - found.swallowed.len());
        for number in [found.table.branch_length.mean, found.table.bifurcation_angle.mean, found.table.in_plane_angle.mean, found.table.curvature.mean] {
            prop_assert!(number.is_finite());
        }
    }
}
