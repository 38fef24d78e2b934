//! Coarser drawings beside the full ones: nowhere off by more than is said, and never more than was asked for.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use proptest::prelude::*;

use super::*;
use crate::tree::mesh::mesh;
use crate::tree::organs::{Paint, Sphere};
use crate::tree::tubes::TubeSegment;

/// A tree whose nodes grow from one of some before, thinner and thinner.
fn grown(steps: &[(u8, [i8; 3])]) -> Drawing {
    let mut tree = Tree {
        letters: vec!["F".to_owned()],
        ..Tree::default()
    };
    tree.push(node(NO_PARENT, Vec3::ZERO, 0.3));
    for (back, step) in steps {
        let last = u32::try_from(tree.len()).unwrap() - 1;
        let parent = last - u32::from(*back).min(last);
        let [x, y, z] = step.map(|one| f32::from(one) / 128.0);
        let from = tree.position[parent as usize];
        let radius = tree.radius[parent as usize] * 0.9;
        tree.push(node(parent, from + Vec3::new(x, y + 0.6, z) * 0.4, radius));
    }
    Drawing {
        tree,
        organs: Organs::default(),
    }
}

fn node(parent: u32, position: Vec3, radius: f32) -> Node {
    Node {
        parent,
        position,
        radius,
        letter: 0,
        order: 0,
        birth: 0,
    }
}

fn records(drawing: &Drawing) -> Vec<TubeSegment> {
    let mut records = Vec::new();
    segments(&drawing.tree, &[], u32::MAX, &mut records);
    records
}

/// How far a point is outside a tree of round tubes, as they are drawn; negative within.
fn outside(point: Vec3, records: &[TubeSegment]) -> f32 {
    let of = |record: &TubeSegment| {
        let (off, along) = from_chord(point, record.from.into(), record.to.into());
        off - (record.radii[1] + (record.radii[3] - record.radii[1]) * along)
    };
    records.iter().map(of).fold(f32::INFINITY, f32::min)
}

/// What is checked of every drawing: each is nowhere farther outside the other than the bound.
fn is_near(fine: &Drawing, coarse: &Drawing, detail: &Detail) {
    coarse.tree.validate().unwrap();
    coarse.organs.validate(&coarse.tree).unwrap();
    let bound = detail.bound(0.3) + 1e-5;
    let [own, other] = [fine, coarse].map(records);
    for (sides, mine, theirs) in [(24, &own, &other), (detail.sides, &other, &own)] {
        let surface = mesh(mine, 1.0, sides);
        for position in surface.positions {
            let off = outside(position.into(), theirs);
            assert!(off <= bound, "{off} {bound} {detail:?}");
        }
    }
    assert!(coarse.tree.segment_count() <= fine.tree.segment_count());
    assert_eq!(coarse.tree.root_count(), fine.tree.root_count());
}

#[test]
fn straight_branches_are_one_segment_and_bent_ones_bend() {
    let line: Vec<(u8, [i8; 3])> = vec![(0, [0, 0, 0]); 30];
    let line = grown(&line);
    let coarse = coarser(&line, 0.05);
    assert!(
        coarse.tree.segment_count() < 12,
        "{}",
        coarse.tree.segment_count()
    );
    let arc: Vec<(u8, [i8; 3])> = (0..30).map(|at| (0, [4 * at, -2 * at, 0])).collect();
    let arc = grown(&arc);
    let coarse = coarser(&arc, 0.05);
    assert!(
        (3..20).contains(&coarse.tree.segment_count()),
        "{}",
        coarse.tree.segment_count()
    );
    assert_eq!(
        coarse.tree.position.last(),
        arc.tree.position.last(),
        "the thick tip stays"
    );
}

#[test]
fn what_is_carried_stays_where_it_is() {
    let mut drawing = grown(&[(0, [0, 0, 0]); 12]);
    drawing.organs.spheres.push(Sphere {
        center: Vec3::new(0.2, 1.0, 0.0),
        radius: 0.1,
        paint: Paint::default(),
        birth: 0,
        node: 5,
    });
    let coarse = coarser(&drawing, 0.2);
    assert_eq!(coarse.organs.spheres.len(), 1);
    assert_eq!(
        coarse.organs.spheres[0].center,
        drawing.organs.spheres[0].center
    );
    coarse.organs.validate(&coarse.tree).unwrap();
}

#[test]
fn odd_trees_and_odd_bounds_are_taken() {
    let empty = Drawing::default();
    assert_eq!(coarser(&empty, 1.0), empty);
    let point = grown(&[]);
    assert_eq!(coarser(&point, 1.0), point);
    let tree = grown(&[(0, [1, 2, 3]), (1, [9, 9, 9])]);
    for within in [0.0, -1.0, f32::NAN] {
        assert_eq!(coarser(&tree, within), tree);
    }
    let least = coarser(&tree, f32::INFINITY);
    assert_eq!(
        least.tree.segment_count(),
        1,
        "something stays of every tree"
    );
    assert_eq!(Detail::of_budget(&tree, 3), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn coarser_trees_are_nowhere_off_by_more_than_is_said(
        steps in prop::collection::vec((prop_oneof![4 => Just(0_u8), 1 => 0_u8..8], prop::array::uniform3(-60_i8..60)), 1..60),
        level in 0_u32..Detail::LEVELS,
        more in 0.0_f32..0.4,
    ) {
        let fine = grown(&steps);
        let sides = Detail::level(&fine.tree, level).sides;
        for within in [Detail::level(&fine.tree, level).within, more] {
            is_near(&fine, &coarser(&fine, within), &Detail { within, sides });
        }
    }

    #[test]
    fn budgets_are_held(steps in prop::collection::vec((0_u8..6, prop::array::uniform3(-60_i8..60)), 1..80), triangles in 12_u64..2000) {
        let fine = grown(&steps);
        let (detail, coarse) = Detail::of_budget(&fine, triangles).unwrap();
        let count = mesh(&records(&coarse), 1.0, detail.sides).indices.len() / 3;
        prop_assert!(count as u64 <= triangles);
        prop_assert_eq!(count as u64, triangles_of(&coarse, detail.sides));
        is_near(&fine, &coarse, &detail);
    }
}
