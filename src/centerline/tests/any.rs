//! Whatever way a model is turned, scaled, placed and written down, its centerlines are the same.

use glam::{Quat, Vec3};
use proptest::prelude::*;

use super::*;
use crate::tree::measure::Measures;

/// A trunk with branches pushed into it: for each, where along the trunk it begins, how it leans and in which direction.
fn forked(branches: &[(f32, f32, f32)]) -> Mesh {
    branches
        .iter()
        .fold(tube(24, 41), |mesh, (along, lean, about)| {
            let turn = Quat::from_rotation_z(*about) * Quat::from_rotation_y(*lean);
            // Half as thick and half as long.
            with(mesh, tube(20, 41), |one| {
                turn * (0.5 * one) + *along * Vec3::Z
            })
        })
}

/// Where they begin and end.
fn ends_of(branches: &[(f32, f32, f32)]) -> Vec<(Kind, DVec3)> {
    let tips = branches.iter().map(|(along, lean, about)| {
        let turn = Quat::from_rotation_z(*about) * Quat::from_rotation_y(*lean);
        let tip = turn * (20.0 * Vec3::Z) + *along * Vec3::Z;
        (Kind::Target, tip.as_dvec3())
    });
    of_tube(40.0).into_iter().chain(tips).collect()
}

/// Tips, junctions, the length of all and the mean radius.
fn told(mesh: Mesh, ends: &[(Kind, DVec3)]) -> (usize, usize, f64, f64) {
    let found = found(mesh, ends, &Params::default()).unwrap();
    assert!(found.unreached.is_empty(), "{:?}", found.unreached);
    let measures = Measures::new(&found.tree);
    (
        measures.tips,
        measures.junctions.len(),
        found.tree.total_length(),
        measures.table.point_radius.mean,
    )
}

fn branches() -> impl Strategy<Value = Vec<(f32, f32, f32)>> {
    // Begins are apart, so that each has a fork of its own.
    let branch = |number: usize| {
        let along = 6.0 + 10.0 * number as f32;
        (along..along + 4.0, 0.7_f32..1.5, 0.0_f32..6.2)
    };
    (1_usize..=3).prop_flat_map(move |count| (0..count).map(branch).collect::<Vec<_>>())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn lines_do_not_depend_on_how_a_model_stands_and_is_written(
        branches in branches(),
        turn in (-3.0_f32..3.0, -3.0_f32..3.0, -3.0_f32..3.0),
        size in -4.0_f32..4.0,
        stride in 1_usize..50,
    ) {
        let (mesh, ends) = (forked(&branches), ends_of(&branches));
        let (tips, junctions, length, radius) = told(mesh.clone(), &ends);
        prop_assert_eq!((tips, junctions), (branches.len() + 1, branches.len()));

        let turn = Quat::from_euler(glam::EulerRot::XYZ, turn.0, turn.1, turn.2);
        let size = 10.0_f32.powf(size);
        let moved = |one: Vec3| size * (turn * one);
        let ends: Vec<(Kind, DVec3)> =
            ends.iter().map(|(kind, one)| (*kind, moved(one.as_vec3()).as_dvec3())).collect();
        let other = told(in_another_order(mesh, stride, moved), &ends);
        prop_assert_eq!((tips, junctions), (other.0, other.1));
        let size = f64::from(size);
        prop_assert!((other.2 / size / length - 1.0).abs() < 0.01, "{} {}", other.2 / size, length);
        prop_assert!((other.3 / size / radius - 1.0).abs() < 0.01, "{} {}", other.3 / size, radius);
    }
}

/// A mesh with its vertices moved and in another order, and its triangles from the last to the first.
fn in_another_order(mesh: Mesh, stride: usize, moved: impl Fn(Vec3) -> Vec3) -> Mesh {
    let count = mesh.positions.len();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|place| (place % stride, std::cmp::Reverse(*place)));
    let mut place_of = vec![0; count];
    for (place, old) in order.iter().enumerate() {
        place_of[*old] = u32::try_from(place).unwrap();
    }
    let triangles = mesh.triangles.iter().rev();
    Mesh {
        positions: order
            .iter()
            .map(|old| moved(mesh.positions[*old]))
            .collect(),
        triangles: triangles
            .map(|face| face.map(|vertex| place_of[vertex as usize]))
            .collect(),
        ..mesh
    }
}
