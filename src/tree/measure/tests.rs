//! Trees whose measures are known.
#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::missing_assert_message,
    reason = "tests"
)]

use std::f64::consts::{FRAC_PI_3, PI};

use glam::{DVec3, Vec3};
use proptest::prelude::*;

use super::course::Course;
use super::*;
use crate::tree::Node;

/// A node of a test's tree.
fn push(tree: &mut Tree, parent: u32, position: Vec3, radius: f32) -> u32 {
    if tree.letters.is_empty() {
        tree.letters.push("A".to_owned());
    }
    tree.push(Node {
        parent,
        position,
        radius,
        letter: 0,
        order: 0,
        birth: 0,
    })
}

/// A stem of 60 along z with two daughters of 50, at 30° to either side.
fn y60() -> Tree {
    let mut tree = Tree::default();
    let mut at = push(&mut tree, NO_PARENT, Vec3::ZERO, 6.0);
    for step in 1..=20_u16 {
        at = push(&mut tree, at, 3.0 * f32::from(step) * Vec3::Z, 6.0);
    }
    let fork = at;
    for side in [-1.0, 1.0] {
        let way = Vec3::new(side * 0.5, 0.0, 0.75_f32.sqrt());
        let mut at = fork;
        for step in 1..=20_u16 {
            at = push(
                &mut tree,
                at,
                60.0 * Vec3::Z + 2.5 * f32::from(step) * way,
                4.762,
            );
        }
    }
    tree
}

fn near(found: f64, expected: f64, within: f64) {
    assert!(
        (found - expected).abs() <= within,
        "{found}, expected {expected}"
    );
}

#[test]
fn a_fork_is_measured() {
    let measures = Measures::new(&y60());
    let table = measures.table;
    assert_eq!(
        (
            measures.branches.len(),
            measures.junctions.len(),
            measures.tips
        ),
        (3, 1, 2)
    );
    assert_eq!(measures.bifurcations(), 1);
    near(table.branch_length.mean, 160.0 / 3.0, 1e-4);
    near(table.centerline_length.mean, 110.0, 1e-4);
    near(table.centerline_length.std, 0.0, 1e-4);
    near(table.stem_length, 60.0, 1e-5);
    near(table.stem_iterations, 60.0 / (160.0 / 3.0), 1e-6);
    near(table.iterations[0], 50.0 / (160.0 / 3.0), 1e-6);
    near(table.bifurcation_angle.mean, FRAC_PI_3, 1e-6);
    assert_eq!(table.bifurcation_angle.n, 1);
    near(table.curvature.max, 0.0, 1e-5);
    assert_eq!(table.torsion.n, 0);
    near(table.tortuosity.max, 0.0, 1e-6);
    let junction = &measures.junctions[0];
    near(junction.parent_angles[0], PI / 6.0, 1e-6);
    near(
        (junction.vectors[0] - DVec3::new(-0.5, 0.0, 0.75_f64.sqrt())).length(),
        0.0,
        1e-6,
    );
    near(junction.parent_vector.z, 1.0, 1e-9);
    // 6³ = 2 · 4.762³.
    near(junction.exponent.unwrap(), 3.0, 1e-3);
    assert_eq!(junction.asymmetry, None);
}

#[test]
fn a_branch_of_frustums_has_their_volume_and_surface() {
    let mut tree = Tree::default();
    let root = push(&mut tree, NO_PARENT, Vec3::ZERO, 10.0);
    let middle = push(&mut tree, root, 50.0 * Vec3::X, 7.5);
    push(&mut tree, middle, 100.0 * Vec3::X, 5.0);
    let measures = Measures::new(&tree);
    let branch = &measures.branches[0];
    near(
        branch.volume,
        PI / 3.0 * 100.0 * (100.0 + 50.0 + 25.0),
        1e-6,
    );
    near(branch.area, PI * 15.0 * 100.0_f64.hypot(5.0), 1e-6);
    near(branch.radius.mean, 7.5, 1e-9);
    near(branch.radius.taper(branch.length), 0.05, 1e-9);
    near(measures.table.point_radius.mean, 7.5, 0.01);
}

/// Points of a helix of curvature 0.04 and torsion 0.02.
fn helix(points: u16, noise: f64, left: bool) -> Vec<DVec3> {
    let (radius, rise) = (20.0, 10.0);
    let turns = 210.744 / 500.0_f64.sqrt();
    let point = |step: u16| {
        let along = f64::from(step) / f64::from(points - 1) * turns;
        let (sin, cos) = along.sin_cos();
        let off = noise * (f64::from(step) * 12.9898).sin();
        DVec3::new(
            (radius + off) * cos,
            (radius + off) * sin * if left { -1.0 } else { 1.0 },
            rise * along,
        )
    };
    (0..points).map(point).collect()
}

#[test]
fn helices_bend_and_twist_as_they_should_at_every_point() {
    for (points, noise) in [(400, 0.0), (211, 0.0), (211, 0.002)] {
        for left in [false, true] {
            let course = Course::new(&helix(points, noise, left), 4.0);
            let (curvatures, torsions) = course.pointwise();
            assert!(curvatures.len() > 100, "{}", curvatures.len());
            let sign = if left { -1.0 } else { 1.0 };
            for (found, expected) in curvatures
                .iter()
                .map(|one| (one, 0.04))
                .chain(torsions.iter().map(|one| (one, sign * 0.02)))
            {
                assert!(
                    (found / expected - 1.0).abs() < 0.03,
                    "{found} {expected} of {points} points"
                );
            }
        }
    }
}

#[test]
fn orders_are_strahlers_and_horsfields() {
    // Two forks of tips on one side, one tip on the other.
    let mut tree = Tree::default();
    let root = push(&mut tree, NO_PARENT, Vec3::ZERO, 1.0);
    let first = push(&mut tree, root, Vec3::Z, 1.0);
    push(&mut tree, first, Vec3::new(5.0, 0.0, 2.0), 1.0);
    let second = push(&mut tree, first, Vec3::new(-1.0, 0.0, 2.0), 1.0);
    for side in [-1.0_f32, 1.0] {
        let fork = push(&mut tree, second, Vec3::new(side, 0.0, 3.0), 1.0);
        push(&mut tree, fork, Vec3::new(side, -1.0, 4.0), 1.0);
        push(&mut tree, fork, Vec3::new(side, 1.0, 4.0), 1.0);
    }
    let measures = Measures::new(&tree);
    let of = |of: fn(&Branch) -> u32| measures.branches.iter().map(of).collect::<Vec<_>>();
    assert_eq!(of(|branch| branch.strahler), [3, 1, 3, 2, 1, 1, 2, 1, 1]);
    assert_eq!(of(|branch| branch.horsfield), [4, 1, 3, 2, 1, 1, 2, 1, 1]);
    assert_eq!(of(|branch| branch.order), [0, 1, 1, 2, 3, 3, 2, 3, 3]);
    assert_eq!(of(|branch| branch.tips), [5, 1, 4, 2, 1, 1, 2, 1, 1]);
    assert_eq!(measures.junctions[0].asymmetry, Some(1.0));
    assert_eq!(measures.junctions[1].asymmetry, Some(0.0));
    let counts: Vec<usize> = measures.orders.iter().map(|order| order.branches).collect();
    assert_eq!(counts, [5, 2, 2]);
    let counts = measures
        .by_order
        .iter()
        .map(|one| (one.order, one.length.n));
    assert_eq!(counts.collect::<Vec<_>>(), [(0, 1), (1, 2), (2, 2), (3, 4)]);
    // Of the last order: all as long, right angles between them.
    let [stem, _, _, last] = measures.by_order[..] else {
        panic!("four orders");
    };
    assert!((last.length.mean - 2.0_f64.sqrt()).abs() < 1e-6 && last.length.std < 1e-6);
    assert!((last.angle.mean.to_degrees() - 90.0).abs() < 1e-3);
    assert_eq!((last.angle.n, stem.angle.n), (2, 0));
    assert!((last.radius - 1.0).abs() < 1e-6);
}

#[test]
fn trees_of_nothing_have_no_measures_and_no_faults() {
    let mut point = Tree::default();
    push(&mut point, NO_PARENT, Vec3::ZERO, 1.0);
    let mut flat = point.clone();
    push(&mut flat, 0, Vec3::ZERO, 0.0);
    push(&mut flat, 0, Vec3::ZERO, 0.0);
    for tree in [Tree::default(), point, flat] {
        let measures = Measures::new(&tree);
        let table = measures.table;
        for number in [
            table.branch_length.mean,
            table.stem_length,
            table.iterations[0],
            table.tortuosity.mean,
            table.point_radius.mean,
        ] {
            assert!(number.is_finite(), "{number}");
        }
    }
}

proptest! {
    /// Branches are tips and junctions together; lengths and angles do not depend on where a tree stands or how it is turned.
    #[test]
    fn counts_agree_and_nothing_depends_on_the_place(
        steps in prop::collection::vec((0_u32..40, -1.0..1.0_f32, -1.0..1.0_f32, 0.1..1.0_f32), 1..40),
        turn in 0.0..6.0_f32,
    ) {
        let mut tree = Tree::default();
        let mut last = push(&mut tree, NO_PARENT, Vec3::ZERO, 1.0);
        // One way out of the root: a stem.
        last = push(&mut tree, last, Vec3::Z, 1.0);
        let _ = last;
        for (parent, x, y, z) in steps {
            let parent = 1 + parent % u32::try_from(tree.len() - 1).unwrap();
            let from = tree.position[parent as usize];
            push(&mut tree, parent, from + Vec3::new(x, y, z), 0.5);
        }
        let measures = Measures::new(&tree);
        prop_assert_eq!(measures.branches.len(), measures.tips + measures.junctions.len());
        let total: f64 = measures.branches.iter().map(|branch| branch.length).sum();
        prop_assert!((total - tree.total_length()).abs() < 1e-6 * total);
        let turned = glam::Quat::from_rotation_x(turn);
        let mut moved = tree.clone();
        moved.position.iter_mut().for_each(|position| *position = turned * *position + Vec3::new(3.0, -2.0, 1.0));
        let other = Measures::new(&moved);
        // An angle whose sides are short is known the less in single precision.
        prop_assert!((other.table.bifurcation_angle.mean - measures.table.bifurcation_angle.mean).abs() < 5e-3);
        prop_assert!((other.table.centerline_length.mean / measures.table.centerline_length.mean - 1.0).abs() < 1e-5);
    }
}
