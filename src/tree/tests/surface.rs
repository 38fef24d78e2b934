//! The mesh: closed, outward, unstretched, joined, at every growth.

use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

use glam::{Vec3, vec3};
use proptest::prelude::*;

use super::tubes::{segment_nodes, segments_of, tube_of_nodes};
use super::{any_tree, between, decent_tree, fork, node, tree_of};
use crate::tree::mesh::{AROUND, CAP_HEIGHT, TubeMesh, mesh};
use crate::tree::radii::{RadiusParams, da_vinci};
use crate::tree::tubes::{TIP, TubeSegment};
use crate::tree::{NO_PARENT, Tree};

/// One index for each different position (bit for bit, but for the sign of zero).
fn merged(mesh: &TubeMesh) -> Vec<u32> {
    let mut index_of = HashMap::new();
    let index = |p: &[f32; 3]| {
        let next = index_of.len() as u32;
        *index_of
            .entry(p.map(|c| (c + 0.0).to_bits()))
            .or_insert(next)
    };
    mesh.positions.iter().map(index).collect()
}

/// Closed and oriented: each directed edge once, its opposite once. Triangles that have no area because two corners coincide
/// are left out: their two other edges cancel each other.
fn check_closed(mesh: &TubeMesh) -> Result<(), TestCaseError> {
    let merged = merged(mesh);
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for triangle in mesh.indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| merged[triangle[i] as usize]);
        if a == b || b == c || c == a {
            continue;
        }
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    for (&(a, b), &count) in &edges {
        prop_assert_eq!(count, 1, "edge {}-{} used {} times", a, b, count);
        prop_assert_eq!(
            edges.get(&(b, a)),
            Some(&1),
            "edge {}-{} has no other side",
            a,
            b
        );
    }
    Ok(())
}

fn volume(mesh: &TubeMesh) -> f64 {
    let origin = Vec3::from(mesh.positions[0]).as_dvec3();
    let point = |index: u32| Vec3::from(mesh.positions[index as usize]).as_dvec3() - origin;
    let sum = |t: &[u32]| point(t[0]).dot(point(t[1]).cross(point(t[2])));
    mesh.indices.chunks_exact(3).map(sum).sum::<f64>() / 6.0
}

fn tube_meshes(tree: &Tree, records: &[TubeSegment], growth: f32, sides: u32) -> Vec<TubeMesh> {
    let tubes = tube_of_nodes(tree, records);
    let count = tubes.iter().flatten().max().map_or(0, |last| last + 1);
    let mut parts = vec![Vec::new(); count];
    for (&node, &segment) in segment_nodes(tree).iter().zip(records) {
        parts[tubes[node].unwrap()].push(segment);
    }
    parts.iter().map(|part| mesh(part, growth, sides)).collect()
}

fn check_numbers(mesh: &TubeMesh) -> Result<(), TestCaseError> {
    let vertices = mesh.positions.len();
    prop_assert!(mesh.normals.len() == vertices && mesh.uvs.len() == vertices);
    prop_assert!(mesh.indices.iter().all(|&i| (i as usize) < vertices));
    prop_assert!(
        mesh.positions
            .iter()
            .flatten()
            .chain(mesh.uvs.iter().flatten())
            .all(|n| n.is_finite())
    );
    prop_assert!(
        mesh.normals
            .iter()
            .all(|&n| (Vec3::from(n).length() - 1.0).abs() < 1e-4)
    );
    Ok(())
}

#[test]
fn a_rod_has_the_volume_of_its_prisms_and_cone() {
    let rod = tree_of(&[
        node(NO_PARENT, Vec3::ZERO, 0.5, 0, 0),
        node(0, Vec3::Y, 0.5, 0, 0),
        node(1, 2.0 * Vec3::Y, 0.5, 0, 0),
    ]);
    for sides in [3_u32, 4, 8, 17, 64] {
        let mesh = mesh(&segments_of(&rod, &[], 9), 1.0, sides);
        let n = f64::from(sides);
        let base = 0.5 * n * 0.25 * (std::f64::consts::TAU / n).sin();
        // A whole prism, one that narrows towards the tip, and the cap.
        let tip = f64::from(TIP);
        let narrowing = (1.0 + tip + tip * tip) / 3.0;
        let expected = base * (1.0 + narrowing + f64::from(CAP_HEIGHT) * 0.5 * tip.powi(3) / 3.0);
        assert!(
            (volume(&mesh) - expected).abs() < 1e-4,
            "{sides} sides: {} and {expected}",
            volume(&mesh)
        );
        check_closed(&mesh).unwrap();
        check_numbers(&mesh).unwrap();
    }
    for (asked, used) in [(0, 3), (2, 3), (1000, 64)] {
        assert_eq!(
            mesh(&segments_of(&rod, &[], 9), 1.0, asked),
            mesh(&segments_of(&rod, &[], 9), 1.0, used)
        );
    }
}

#[test]
fn ring_corners_start_at_x_and_go_to_z() {
    let rod = tree_of(&[
        node(NO_PARENT, Vec3::ZERO, 0.5, 0, 0),
        node(0, Vec3::Y, 0.5, 0, 0),
        node(1, 2.0 * Vec3::Y, 0.5, 0, 0),
    ]);
    let mesh = mesh(&segments_of(&rod, &[], 9), 1.0, 4);
    for (corner, expected) in [Vec3::X, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Z, Vec3::X]
        .into_iter()
        .enumerate()
    {
        assert!(Vec3::from(mesh.positions[corner]).distance(0.5 * expected) < 1e-4);
        assert!(Vec3::from(mesh.normals[corner]).distance(expected) < 1e-4);
        assert_eq!(mesh.uvs[corner], [AROUND * corner as f32 / 4.0, 0.0]);
    }
    assert!(
        (mesh.uvs[5][1] - AROUND / (TAU * 0.5)).abs() < 1e-5,
        "as many repeats along a circumference as round it"
    );
    assert_eq!(
        mesh.positions[0], mesh.positions[4],
        "the seam is closed bit for bit"
    );
}

/// On a cone the normals are those of the cone.
#[test]
fn normals_account_for_the_taper() {
    let cone = tree_of(&[
        node(NO_PARENT, Vec3::ZERO, 0.5, 0, 0),
        node(0, Vec3::Y, 0.1, 0, 0),
    ]);
    let mesh = mesh(&segments_of(&cone, &[], 9), 1.0, 8);
    let (sin, cos) = (0.5 - 0.1 * TIP).atan().sin_cos();
    for corner in 0..18 {
        let angle = TAU * (corner % 9) as f32 / 8.0;
        let expected = vec3(cos * angle.cos(), sin, cos * angle.sin());
        assert!(Vec3::from(mesh.normals[corner]).distance(expected) < 1e-3);
    }
}

#[test]
fn nothing_makes_an_empty_mesh() {
    assert_eq!(mesh(&[], 1.0, 8), TubeMesh::default());
    assert_eq!(TubeMesh::default().bounds(), ([0.0; 3], [0.0; 3]));
}

/// At g = 0 a new tip is a disc that closes its parent's last ring: nothing sticks out.
#[test]
fn a_new_tip_begins_flat() {
    let mut tree = fork();
    let before = da_vinci(&mut tree, &RadiusParams::default(), 4);
    let records = segments_of(&tree, &before, 4);
    let mesh = mesh(&records[4..], 0.0, 8);
    let base = tree.position[4];
    assert!(
        mesh.positions
            .iter()
            .all(|&p| Vec3::from(p).distance(base) <= RadiusParams::default().tip_radius * 1.001)
    );
    check_numbers(&mesh).unwrap();
}

proptest! {
    /// Each tube of any tree is watertight, whatever is degenerate in it, whole or growing.
    #[test]
    fn every_tube_is_closed(mut tree in decent_tree(), newest in 0_u32..30, growth in between(0.01, 1.0), sides in 3_u32..12) {
        let before = da_vinci(&mut tree, &RadiusParams::default(), newest);
        let records = segments_of(&tree, &before, newest);
        for growth in [growth, 1.0] {
            for mesh in tube_meshes(&tree, &records, growth, sides) {
                check_numbers(&mesh)?;
                check_closed(&mesh)?;
                prop_assert!(volume(&mesh) > 0.0, "inside out");
            }
        }
    }

    #[test]
    fn degenerate_trees_stay_closed_and_finite(tree in any_tree(), growth in between(-0.5, 1.5)) {
        let records = segments_of(&tree, &[], u32::MAX);
        for mesh in tube_meshes(&tree, &records, 1.0, 5) {
            check_numbers(&mesh)?;
            check_closed(&mesh)?;
        }
        check_numbers(&mesh(&segments_of(&tree, &[], 3), growth, 5))?;
    }

    /// The sides' normals look away from the axis and agree with their triangles.
    #[test]
    fn normals_look_outward(mut tree in decent_tree()) {
        da_vinci(&mut tree, &RadiusParams { tip_radius: 0.001, exponent: 2.0 }, 0);
        for s in segments_of(&tree, &[], u32::MAX) {
            let sides = 8;
            let mesh = mesh(&[s], 1.0, sides);
            let [from, to] = [s.from, s.to].map(Vec3::from);
            let along = (to - from).normalize();
            for corner in 0..2 * (sides as usize + 1) {
                let away = (Vec3::from(mesh.positions[corner]) - from).reject_from_normalized(along);
                prop_assert!(away.normalize().dot(mesh.normals[corner].into()) > 0.4);
            }
            for triangle in mesh.indices.chunks_exact(3) {
                let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(mesh.positions[triangle[i] as usize]));
                let face = (b - a).cross(c - a).normalize();
                for &corner in triangle {
                    prop_assert!(face.dot(mesh.normals[corner as usize].into()) > 0.2);
                }
            }
        }
    }

    /// Where a segment goes on from its parent, their rings coincide bit for bit at every growth: no crack can open.
    #[test]
    fn rings_join_at_every_growth(mut tree in any_tree(), newest in 0_u32..30, growth in between(0.0, 1.0)) {
        let before = da_vinci(&mut tree, &RadiusParams::default(), newest);
        let records = segments_of(&tree, &before, newest);
        let mut last_ring = vec![None; tree.len()];
        let sides = 6;
        for (&node, s) in segment_nodes(&tree).iter().zip(&records) {
            let mesh = mesh(&[*s], growth, sides);
            let corners = sides as usize + 1;
            if s.flags & crate::tree::tubes::STARTS == 0 {
                let ring: &Vec<[u32; 3]> = last_ring[tree.parent[node] as usize].as_ref().unwrap();
                let own: Vec<_> = mesh.positions[..corners].iter().map(|p| p.map(f32::to_bits)).collect();
                prop_assert_eq!(ring, &own);
            }
            last_ring[node] = Some(mesh.positions[corners..2 * corners].iter().map(|p| p.map(f32::to_bits)).collect());
        }
    }
}

/// The bend narrows by cos(θ/2) and never spikes.
#[test]
fn bends_are_bounded() {
    for degrees in [10.0_f32, 60.0, 90.0, 119.0] {
        let angle = degrees * PI / 180.0;
        let tree = tree_of(&[
            node(NO_PARENT, Vec3::ZERO, 0.1, 0, 0),
            node(0, Vec3::Y, 0.1, 0, 0),
            node(1, Vec3::Y + vec3(angle.sin(), angle.cos(), 0.0), 0.1, 0, 0),
        ]);
        let mesh = mesh(&segments_of(&tree, &[], 9), 1.0, 32);
        for p in &mesh.positions {
            let p = Vec3::from(*p);
            let near = [
                (tree.position[0], tree.position[1]),
                (tree.position[1], tree.position[2]),
            ]
            .map(|(a, b)| {
                let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                p.distance(a + t * (b - a))
            });
            assert!(near[0].min(near[1]) <= 0.1001, "{degrees}°: {p}");
        }
    }
}
