//! Centerlines of meshes that are made by formula, and of models with a known truth.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

mod any;
mod truth;

use std::sync::Arc;

use glam::Vec3;

use super::*;
use crate::mesh::Mesh;
use crate::mesh::made::{sphere, torus, tube, turned};
use crate::mesh::pick::Picker;

pub(super) fn surface(mesh: Mesh) -> Surface {
    let never = AtomicBool::new(false);
    let picker = Picker::new(Arc::new(mesh), &never, &mut |_, _| {}).unwrap();
    Surface::new(picker, &never).unwrap()
}

pub(super) fn end(kind: Kind, point: DVec3) -> Endpoint {
    Endpoint {
        point,
        name: kind.as_str().to_owned(),
        kind,
        snapped: None,
    }
}

fn found(
    mesh: Mesh,
    ends: &[(Kind, DVec3)],
    params: &Params,
) -> Result<Centerline, CenterlineError> {
    let ends: Vec<Endpoint> = ends
        .iter()
        .map(|(kind, point)| end(*kind, *point))
        .collect();
    centerline(
        &surface(mesh),
        &ends,
        params,
        &AtomicBool::new(false),
        &mut |_, _| {},
    )
}

/// Two ends of a tube of radius 1 along z.
fn of_tube(length: f64) -> [(Kind, DVec3); 2] {
    [
        (Kind::Source, DVec3::ZERO),
        (Kind::Target, length * DVec3::Z),
    ]
}

/// A mesh beside or within another.
fn with(mut mesh: Mesh, other: Mesh, moved: impl Fn(Vec3) -> Vec3) -> Mesh {
    let first = u32::try_from(mesh.positions.len()).unwrap();
    mesh.positions
        .extend(other.positions.into_iter().map(moved));
    mesh.triangles.extend(
        other
            .triangles
            .into_iter()
            .map(|face| face.map(|vertex| vertex + first)),
    );
    mesh
}

#[test]
fn an_open_tube_has_its_axis() {
    let found = found(tube(40, 41), &of_tube(40.0), &Params::default()).unwrap();
    let tree = &found.tree;
    assert_eq!((tree.root_count(), tree.tips().len()), (1, 1));
    for (position, radius) in tree.position.iter().zip(&tree.radius) {
        let off = position.truncate().length();
        assert!(
            off < 1e-3 && (radius - 1.0).abs() < 0.01,
            "{position} {radius}"
        );
    }
    // The balls that touch the caps.
    let [first, last] = [tree.position[0], tree.position[tree.len() - 1]];
    assert!(
        (first.z - 1.0).abs() < 0.1 && (last.z - 39.0).abs() < 0.1,
        "{first} {last}"
    );
}

#[test]
fn tubes_pushed_into_each_other_are_one_and_tubes_apart_are_not() {
    let shifted = |by: f32| move |one: Vec3| one + by * Vec3::Z;
    // They overlap by 3 in the same axis, each with an end of its own inside the other.
    let joined = with(tube(40, 21), tube(30, 21), shifted(17.0));
    let line = found(joined, &of_tube(37.0), &Params::default()).unwrap();
    assert!(line.unreached.is_empty());
    let length = line.tree.total_length();
    assert!((length - 35.0).abs() < 0.3, "{length}");
    let apart = with(tube(40, 21), tube(40, 21), shifted(22.0));
    let error = found(apart.clone(), &of_tube(42.0), &Params::default()).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("not connected to the source: gap of 2.0"),
        "{error}"
    );
    let bridged = found(
        apart,
        &of_tube(42.0),
        &Params {
            bridge: Some(2.1),
            ..Params::default()
        },
    )
    .unwrap();
    assert!(
        (bridged.tree.total_length() - 40.0).abs() < 0.5,
        "{}",
        bridged.tree.total_length()
    );
}

#[test]
fn a_hollow_is_no_inside_and_ways_go_through_the_wall_beside_it() {
    let mesh = with(sphere(4), turned(sphere(4), |_| true), |one| 0.5 * one);
    let ends = [(Kind::Source, DVec3::Z), (Kind::Target, -DVec3::Z)];
    let line = found(mesh, &ends, &Params::default()).unwrap();
    let length = line.tree.total_length();
    assert!(
        (length / (0.75 * std::f64::consts::PI) - 1.0).abs() < 0.05,
        "{length}"
    );
    for (place, radius) in line.tree.position.iter().zip(&line.tree.radius) {
        let off = place.length();
        assert!(
            (off - 0.75).abs() < 0.05 && (radius - 0.25).abs() < 0.03,
            "{place} {radius}"
        );
    }
}

#[test]
fn a_ring_is_gone_round_on_one_side() {
    let ends = [
        (Kind::Source, DVec3::new(2.5, 0.0, 0.0)),
        (Kind::Target, DVec3::new(0.0, 2.5, 0.0)),
    ];
    let line = found(torus(160, 40), &ends, &Params::default()).unwrap();
    let length = line.tree.total_length();
    assert!(
        (length / std::f64::consts::PI - 1.0).abs() < 0.02,
        "a quarter of the ring is π long: {length}"
    );
}

#[test]
fn what_cannot_be_done_is_said_in_one_sentence() {
    let far = DVec3::new(9.0, 0.0, 20.0);
    let flat = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE - Vec3::Z],
        triangles: vec![[0, 1, 2], [1, 3, 2]],
        ..Mesh::default()
    };
    let lines = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, 2.0 * Vec3::X],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let tube = || tube(20, 41);
    let [source, target] = of_tube(40.0);
    for (mesh, ends, expected) in [
        (tube(), vec![target], "there is no source"),
        (tube(), vec![source], "there is no target"),
        (tube(), vec![source, source, target], "there are 2 sources"),
        (
            tube(),
            vec![source, (Kind::Target, DVec3::ZERO)],
            "is where the source is",
        ),
        (tube(), vec![source, (Kind::Target, far)], "off the surface"),
        (
            tube(),
            vec![source, (Kind::Target, DVec3::new(f64::NAN, 0.0, 0.0))],
            "not at a finite place",
        ),
        (flat, vec![source, target], "no inside"),
        (lines, vec![source, target], "no surface"),
        (Mesh::default(), vec![source, target], "no surface"),
    ] {
        let error = found(mesh, &ends, &Params::default())
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(expected) && error.lines().count() == 1,
            "{error}, expected {expected}"
        );
    }
    let stopped = AtomicBool::new(true);
    let ends = of_tube(40.0).map(|(kind, point)| end(kind, point));
    let error = centerline(
        &surface(tube()),
        &ends,
        &Params::default(),
        &stopped,
        &mut |_, _| {},
    );
    assert_eq!(error.unwrap_err(), CenterlineError::Cancelled);
}

#[test]
fn more_triangles_than_there_may_be_are_refused() {
    let mut mesh = tube(4, 5);
    // They are of vertices that are not there, and so cost nothing but their room.
    mesh.triangles.resize(TRIANGLES_MOST + 1, [NONE; 3]);
    let error = found(mesh, &of_tube(4.0), &Params::default()).unwrap_err();
    let most = TRIANGLES_MOST;
    assert_eq!(
        error,
        CenterlineError::TooLarge {
            triangles: most + 1,
            most
        }
    );
    assert!(error.to_string().contains("20000000"), "{error}");
}

#[test]
fn a_ball_is_no_tube_but_has_a_middle() {
    let ends = [(Kind::Source, DVec3::Z), (Kind::Target, -DVec3::Z)];
    let error = found(sphere(4), &ends, &Params::default()).unwrap_err();
    assert!(
        error.to_string().contains("is where the source is"),
        "{error}"
    );
}
