//! What any cut through the levels must be: one cover of the surface, without holes or cracks, as near to it as it says.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "a test that fails shows the line"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
use proptest::prelude::*;

use super::{COARSEST, Cluster, Joined, Levels, MOST_TRIANGLES, SMALL};
use crate::mesh::display::Display;
use crate::mesh::paint::{Material, Paint};
use crate::mesh::textured::{LayerLimits, Textured};
use crate::mesh::{Mesh, made};
use crate::tree::levels::cut::{self, BINS, COARSEST as COARSEST_BIN, NEVER, Standing, Views};

fn levels(mesh: Mesh) -> Arc<Levels> {
    let display = Display::new(Arc::new(mesh), None, &AtomicBool::new(false)).unwrap();
    display.levels
}

/// A ball with lumps, of 20·4ⁿ triangles.
fn lumpy(times: u32) -> Mesh {
    let mut mesh = made::sphere(times);
    for at in &mut mesh.positions {
        let lump = (7.0 * at.x).sin() * (9.0 * at.y).sin() * (8.0 * at.z).sin();
        *at *= 1.0 + 0.1 * lump + 0.004 * (60.0 * at.x).sin() * (50.0 * at.z).cos();
    }
    mesh
}

/// The clusters that are drawn where this much may be off everywhere.
fn drawn_at(levels: &Levels, error: f32) -> Vec<&Cluster> {
    let is = |cluster: &&Cluster| {
        cluster.own_error <= error && (cluster.parent_error < 0.0 || error < cluster.parent_error)
    };
    levels.clusters.iter().filter(is).collect()
}

/// The clusters that are drawn for an eye.
fn drawn_for<'a>(
    levels: &'a Levels,
    standing: &Standing,
    views: &Views,
    threshold: u32,
) -> Vec<&'a Cluster> {
    let is = |cluster: &&Cluster| {
        let bins = cluster.bins(standing, views);
        bins.is_some_and(|bins| cut::is_drawn(bins, threshold))
    };
    levels.clusters.iter().filter(is).collect()
}

/// Edges that an odd number of triangles has.
fn odd_edges(levels: &Levels, clusters: &[&Cluster]) -> BTreeSet<[u32; 2]> {
    let mut counts: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for cluster in clusters {
        for [a, b, c] in &levels.triangles[cluster.triangles()] {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *counts.entry([*from.min(to), *from.max(to)]).or_default() += 1;
            }
        }
    }
    counts
        .into_iter()
        .filter(|(_, count)| count % 2 == 1)
        .map(|(edge, _)| edge)
        .collect()
}

/// The volume within: right where the surface is whole and turned outwards.
fn volume(mesh: &Mesh, levels: &Levels, clusters: &[&Cluster]) -> f64 {
    let corner = |vertex: u32| mesh.positions[vertex as usize].as_dvec3();
    let six: f64 = clusters
        .iter()
        .flat_map(|cluster| &levels.triangles[cluster.triangles()])
        .map(|triangle| {
            let [a, b, c] = triangle.map(corner);
            a.dot(b.cross(c))
        })
        .sum();
    six / 6.0
}

/// Sees everything.
fn wide(eye: Vec3, pixels: f32) -> Views {
    Views {
        planes: [[Vec4::new(0.0, 0.0, 0.0, 1.0); 4]; 2],
        eyes: [eye.extend(pixels), (eye + 0.06 * Vec3::X).extend(pixels)],
    }
}

#[test]
fn the_finest_level_is_the_mesh_and_clusters_are_runs() {
    for mesh in [made::sphere(2), lumpy(5), made::soup(&made::sphere(4))] {
        let levels = levels(mesh.clone());
        let mut stood_for: Vec<u32> = levels.clusters[..levels.finest]
            .iter()
            .flat_map(|cluster| &levels.stands_for[cluster.triangles()])
            .copied()
            .collect();
        stood_for.sort_unstable();
        assert!(stood_for.into_iter().eq(0..mesh.triangles.len() as u32));
        let mut next = 0;
        for cluster in &levels.clusters {
            assert_eq!(cluster.first, next);
            assert!((1..=MOST_TRIANGLES as u32).contains(&cluster.count));
            next += cluster.count;
        }
        assert_eq!(next as usize, levels.triangles.len());
        assert_eq!(levels.triangles.len(), levels.stands_for.len());
        // Each triangle is the one that it stands for, by place.
        for cluster in &levels.clusters[..levels.finest] {
            for number in cluster.triangles() {
                let place =
                    |vertex: u32| mesh.positions[vertex as usize].to_array().map(f32::to_bits);
                let mut here = levels.triangles[number].map(place);
                let mut there = mesh.triangles[levels.stands_for[number] as usize].map(place);
                here.sort_unstable();
                there.sort_unstable();
                assert_eq!(here, there);
            }
        }
        if mesh.triangles.len() <= SMALL {
            assert_eq!(levels.finest, levels.clusters.len());
        } else {
            let coarsest = drawn_at(&levels, f32::MAX);
            let left: u32 = coarsest.iter().map(|cluster| cluster.count).sum();
            assert!((left as usize) < mesh.triangles.len() / 8, "{left}");
            assert!(levels.triangles.len() < mesh.triangles.len() * 5 / 2);
        }
    }
}

#[test]
fn errors_grow_and_spheres_hold_what_is_below() {
    let mesh = lumpy(6);
    let levels = levels(mesh.clone());
    let holds =
        |outer: Vec4, inner: Vec4| outer.truncate().distance(inner.truncate()) + inner.w <= outer.w;
    for (number, cluster) in levels.clusters.iter().enumerate() {
        let finest = number < levels.finest;
        assert_eq!(cluster.own_error == 0.0, finest);
        assert_eq!(cluster.own_grain == 0.0, finest);
        assert!(cluster.own_grain >= cluster.own_error);
        if cluster.parent_error >= 0.0 {
            assert!(cluster.parent_error > cluster.own_error);
            assert!(cluster.parent_grain > cluster.own_grain);
            assert!(holds(cluster.parent, cluster.own), "{cluster:?}");
        }
        for vertex in levels.triangles[cluster.triangles()].as_flattened() {
            let at = mesh.positions[*vertex as usize];
            assert!(at.distance(cluster.sphere.truncate()) <= cluster.sphere.w);
        }
    }
}

#[test]
fn a_cut_is_as_near_to_the_ball_as_it_says_and_stays_closed() {
    let mesh = made::sphere(6);
    let levels = levels(mesh.clone());
    let mut fewest = usize::MAX;
    for error in [0.0, 1e-4, 1e-3, 1e-2, f32::MAX] {
        let drawn = drawn_at(&levels, error);
        assert_eq!(odd_edges(&levels, &drawn), BTreeSet::new(), "{error}");
        let count: usize = drawn.iter().map(|cluster| cluster.count as usize).sum();
        assert!(count <= fewest);
        fewest = count;
        // The middles of all triangles are within the error of the ball, about: it is a mean and not the largest.
        for cluster in &drawn {
            for triangle in &levels.triangles[cluster.triangles()] {
                let corners = triangle.map(|vertex| mesh.positions[vertex as usize] / 3.0);
                let off = 1.0 - corners.into_iter().sum::<Vec3>().length();
                let finest = 1.5e-4;
                assert!(off < finest + 3.0 * cluster.own_error, "{off} {cluster:?}");
            }
        }
    }
    assert!(fewest < 400, "{fewest}");
}

#[test]
fn a_sheet_keeps_its_rim_closed_to_what_was_its_rim() {
    let tube = made::tube(96, 96);
    let levels = levels(tube.clone());
    let rim = |vertex: u32| {
        let z = tube.positions[vertex as usize].z;
        z == 0.0 || z == 95.0
    };
    for error in [0.0, 1e-3, 0.1] {
        let drawn = drawn_at(&levels, error);
        let odd = odd_edges(&levels, &drawn);
        assert!(!odd.is_empty());
        assert!(odd.as_flattened_all().all(rim), "{error}");
    }
}

/// Both ends of all edges.
trait Ends {
    fn as_flattened_all(&self) -> impl Iterator<Item = u32>;
}

impl Ends for BTreeSet<[u32; 2]> {
    fn as_flattened_all(&self) -> impl Iterator<Item = u32> {
        self.iter().flatten().copied()
    }
}

#[test]
fn loose_triangles_of_a_whole_surface_become_few_and_those_of_none_too() {
    let whole = levels(made::sphere(5));
    let soup = levels(made::soup(&made::sphere(5)));
    let count = |levels: &Levels, error: f32| -> u32 {
        drawn_at(levels, error).iter().map(|c| c.count).sum()
    };
    let (a, b) = (count(&whole, 0.01), count(&soup, 0.01));
    assert!(a.abs_diff(b) < a / 5, "{a} {b}");
    // Triangles that have nothing to do with each other: the coarsest level is small all the same.
    let mut loose = Mesh::default();
    for number in 0..(2 * COARSEST as u32) {
        let along = |step: u32| (number / step % 50) as f32;
        let at = Vec3::new(along(1), along(50), along(2500));
        let first = loose.positions.len() as u32;
        loose
            .positions
            .extend([at, at + 0.3 * Vec3::X, at + 0.3 * Vec3::Y]);
        loose.triangles.push([first, first + 1, first + 2]);
    }
    let loose = levels(loose);
    let left = count(&loose, f32::MAX) as usize;
    assert!((1..=COARSEST).contains(&left), "{left}");
}

#[test]
fn what_cannot_be_seen_is_left_out_and_harms_nothing() {
    let mut mesh = made::sphere(4);
    let whole = mesh.triangles.len() as u32;
    let behind = mesh.positions.len() as u32;
    mesh.positions
        .extend([Vec3::NAN, Vec3::INFINITY, Vec3::splat(1e30)]);
    mesh.triangles.extend([
        [0, 1, behind],
        [0, 1, behind + 1],
        [0, 0, 1],
        [0, 1, behind + 77],
        [0, 1, behind + 2],
    ]);
    let found = levels(mesh);
    let finest: u32 = found.clusters[..found.finest].iter().map(|c| c.count).sum();
    assert_eq!(finest, whole + 1, "one reaches far and is there");
    assert_eq!(*levels(Mesh::default()), Levels::default());
    let point = Mesh {
        positions: vec![Vec3::ONE; 30_000],
        triangles: (0..10_000).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect(),
        ..Mesh::default()
    };
    assert_eq!(*levels(point), Levels::default());
    // The same triangle very often, and a line.
    let mut often = made::cube();
    often.triangles = vec![[0, 1, 2]; 5_000];
    assert!(!levels(often).clusters.is_empty());
    let line = Mesh {
        positions: (0..6_000_u16).map(|n| Vec3::X * f32::from(n)).collect(),
        triangles: (0..5_998).map(|n| [n, n + 1, n + 2]).collect(),
        ..Mesh::default()
    };
    assert!(!levels(line).clusters.is_empty());
    for size in [1e-30, 1e18, 3e37] {
        let placed = made::placed(made::sphere(5), size, Vec3::ZERO);
        let levels = levels(placed);
        let finest: u32 = levels.clusters[..levels.finest]
            .iter()
            .map(|c| c.count)
            .sum();
        assert_eq!(finest, 20 * 4_u32.pow(5));
    }
}

#[test]
fn levels_are_the_same_for_any_number_of_threads_and_can_be_cancelled() {
    let mesh = lumpy(6);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| levels(mesh.clone()))
    };
    assert_eq!(with(1), with(3));
    let cancelled = AtomicBool::new(true);
    let normals = vec![0; mesh.positions.len()];
    let joined: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let joined = Joined::by_place(&joined);
    assert!(Levels::new(&mesh, &joined, &normals, &cancelled).is_none());
}

#[test]
fn bins_never_fall_and_begin_at_a_pixel() {
    assert_eq!([0.0, 0.5, 1.0].map(cut::bin), [0; 3]);
    assert_eq!([1.01, 1.125, 1.13, 2.0].map(cut::bin), [1, 1, 2, 8]);
    assert_eq!(
        [f32::INFINITY, f32::NAN, -1.0].map(cut::bin),
        [COARSEST_BIN; 3]
    );
    for bin in 0..BINS as u32 {
        assert_eq!(cut::bin(cut::pixels(bin)), bin);
        assert_eq!(
            cut::bin(cut::pixels(bin).next_up()),
            (bin + 1).min(COARSEST_BIN)
        );
    }
}

#[test]
fn the_threshold_is_the_smallest_that_fits() {
    let clusters = [
        ([0, 5], 800),
        ([0, 7], 400),
        ([5, NEVER], 320),
        ([7, 9], 160),
        ([9, NEVER], 40),
    ];
    let drawn = |threshold: u32| -> u32 {
        let is = |(bins, _): &&([u32; 2], u32)| cut::is_drawn(*bins, threshold);
        clusters.iter().filter(is).map(|(_, count)| count).sum()
    };
    for budget in [8000, 1200, 1199, 720, 719, 480, 479, 360, 359, 0] {
        let found = cut::threshold(clusters.into_iter(), budget);
        let expected = (0..COARSEST_BIN).find(|bin| drawn(*bin) <= budget);
        assert_eq!(found, expected.unwrap_or(COARSEST_BIN), "{budget}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn every_eye_sees_a_closed_surface_within_the_budget(
        eye in prop::array::uniform3(-3.0_f32..3.0),
        pixels in 10.0_f32..4000.0,
        scale in 0.01_f32..30.0,
        turn in 0.0_f32..6.0,
        threshold in 0_u32..60,
        budget in 2_000_u32..60_000,
        by_grain: bool,
    ) {
        static LEVELS: std::sync::OnceLock<(Mesh, Arc<Levels>)> = std::sync::OnceLock::new();
        let (mesh, levels) = LEVELS.get_or_init(|| (lumpy(6), levels(lumpy(6))));
        let place = Affine3A::from_scale_rotation_translation(
            Vec3::splat(scale),
            Quat::from_rotation_y(turn),
            Vec3::new(0.1, 0.2, -0.4),
        );
        let standing = Standing::new(place, Vec4::ZERO, by_grain, 0.05);
        let views = wide(Vec3::from(eye) * scale, pixels);
        // Everything is seen, so errors never fall on the way up.
        for cluster in &levels.clusters {
            let [own, parent] = cluster.bins(&standing, &views).unwrap();
            prop_assert!(own <= parent);
        }
        let drawn = drawn_for(levels, &standing, &views, threshold);
        prop_assert_eq!(odd_edges(levels, &drawn), BTreeSet::new());
        // One cover and not two: the volume is that of the ball.
        let finest: Vec<&Cluster> = levels.clusters[..levels.finest].iter().collect();
        let share = volume(mesh, levels, &drawn) / volume(mesh, levels, &finest);
        // What may be off by a part of the ball's radius may be off by its cube in volume: in a picture of a few pixels by much.
        let far = (Vec3::from(eye) * scale).distance(place.translation.into()) - scale;
        let radius = scale * pixels / far.max(0.05);
        let off = 2.0_f32.powf(threshold as f32 / 8.0) / radius;
        let most = ((1.0 + off).powi(3) - 1.0).max(0.2);
        prop_assert!((share - 1.0).abs() < most.into(), "{share} {most}");
        let all = levels.clusters.iter().filter_map(|cluster| {
            Some((cluster.bins(&standing, &views)?, cluster.count))
        });
        let found = cut::threshold(all, budget);
        let count = |at: u32| -> u32 {
            drawn_for(levels, &standing, &views, at).iter().map(|c| c.count).sum()
        };
        prop_assert!(count(found) <= budget);
        // The smallest that fits, each cluster counted as the device counts it.
        let counted = |at: u32| -> u32 {
            let drawn = drawn_for(levels, &standing, &views, at);
            drawn.iter().map(|c| c.count.div_ceil(cut::COUNTED_IN)).sum()
        };
        prop_assert!(found == 0 || counted(found - 1) > budget / cut::COUNTED_IN);
    }

    #[test]
    fn what_is_not_seen_lies_outside_both_pictures_or_before_the_cut(
        eye in prop::array::uniform3(-2.0_f32..2.0),
        target in prop::array::uniform3(-1.0_f32..1.0),
        plane in prop::array::uniform4(-1.0_f32..1.0),
    ) {
        static LEVELS: std::sync::OnceLock<(Mesh, Arc<Levels>)> = std::sync::OnceLock::new();
        let (mesh, levels) = LEVELS.get_or_init(|| (lumpy(4), levels(lumpy(4))));
        let ahead = (Vec3::from(target) - Vec3::from(eye)).normalize_or(Vec3::NEG_Z);
        let (right, up) = ahead.any_orthonormal_pair();
        let corner = |x: f32, y: f32| ahead + x * right + y * up;
        let planes = |eye: Vec3| {
            [[-0.5, 0.0], [0.5, 0.0], [0.0, -0.5], [0.0, 0.5]].map(|[x, y]| {
                let along = if x == 0.0 { right } else { up };
                cut::side(eye, corner(x, y), along, ahead)
            })
        };
        let eyes = [Vec3::from(eye), Vec3::from(eye) + 0.06 * right];
        let views = Views {
            planes: eyes.map(planes),
            eyes: eyes.map(|eye| eye.extend(1000.0)),
        };
        let plane = Vec4::from(plane);
        let standing = Standing::new(Affine3A::IDENTITY, plane, false, 0.05);
        for cluster in levels.clusters.iter().filter(|c| c.bins(&standing, &views).is_none()) {
            for vertex in levels.triangles[cluster.triangles()].as_flattened() {
                let at = mesh.positions[*vertex as usize];
                let before_the_cut = plane.truncate().dot(at) > plane.w - 1e-4;
                let inside = eyes.map(|eye| {
                    let offset = at - eye;
                    let far = offset.dot(ahead);
                    let within = |axis: Vec3| offset.dot(axis).abs() < 0.499 * far;
                    far > 0.0 && within(right) && within(up)
                });
                prop_assert!(before_the_cut || inside == [false; 2]);
            }
        }
    }
}

/// A tube along z of quads round and along, with lumps: where it is in an image goes round once, so that its vertices lie twice on a seam; its two
/// halves are of two materials.
fn seamed(round: u32, along: u32) -> (Mesh, Textured) {
    let mut mesh = Mesh::default();
    let mut paint = Paint {
        materials: vec![Material::default(); 2],
        ..Paint::default()
    };
    let part = |of: u32, whole: u32| of as f32 / whole as f32;
    for z in 0..=along {
        for at in 0..=round {
            let place = Vec2::new(part(at, round), part(z, along));
            let turn = if at == round { 0.0 } else { place.x };
            let (sin, cos) = (turn * std::f32::consts::TAU).sin_cos();
            let radius = 1.0 + 0.05 * (5.0 * sin).sin() * (20.0 * place.y).cos();
            mesh.positions
                .push(Vec3::new(cos * radius, sin * radius, 4.0 * place.y));
            paint.texture_coordinates.push(place);
        }
    }
    for z in 0..along {
        for at in 0..round {
            let a = z * (round + 1) + at;
            let [b, c, d] = [a + 1, a + round + 1, a + round + 2];
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
            paint
                .triangle_materials
                .extend([u16::from(z >= along / 2); 2]);
        }
    }
    let never = AtomicBool::new(false);
    let (textured, _) = Textured::new(paint, &LayerLimits::default(), &never).unwrap();
    (mesh, textured.unwrap())
}

#[test]
fn seams_and_borders_of_materials_stay_where_they_are() {
    let (mesh, textured) = seamed(160, 120);
    let mesh = Arc::new(mesh);
    let never = AtomicBool::new(false);
    let display = Display::new(Arc::clone(&mesh), Some(&textured), &never).unwrap();
    let levels = &*display.levels;
    let coarsest = levels.clusters.iter().filter(|of| of.parent_error < 0.0);
    let left: u32 = coarsest.map(|cluster| cluster.count).sum();
    assert!(left < 4_000, "{left} of {} are left", mesh.triangles.len());
    let middle = 2.0;
    // What is off by as much as the tube is wide may reach across it.
    let fine = levels.clusters.iter().filter(|of| of.own_error < 0.1);
    let fine = fine
        .flat_map(Cluster::triangles)
        .map(|at| levels.triangles[at]);
    for triangle in fine {
        let places = triangle.map(|vertex| textured.coordinate(vertex).x);
        let [low, high] = [f32::min, f32::max].map(|of| places.into_iter().reduce(of).unwrap());
        assert!(
            high - low < 0.35,
            "{places:?}: across the seam it would run back through all of the image"
        );
    }
    for (triangle, original) in levels.triangles.iter().zip(&levels.stands_for) {
        // What is of one material does not reach over to the other.
        let heights = triangle.map(|vertex| mesh.positions[vertex as usize].z);
        let first = textured.material_of(*original) == 0;
        let beyond = |z: &f32| if first { *z > middle } else { *z < middle };
        assert!(!heights.iter().any(beyond), "{heights:?}");
    }
    // Whatever is drawn closes round the tube: the seam is open in the image alone.
    let joined: Vec<u32> = {
        let mut first = BTreeMap::new();
        (0_u32..)
            .zip(&mesh.positions)
            .map(|(vertex, at)| {
                *first
                    .entry(at.to_array().map(f32::to_bits))
                    .or_insert(vertex)
            })
            .collect()
    };
    let welded = Levels {
        triangles: levels
            .triangles
            .iter()
            .map(|triangle| triangle.map(|vertex| joined[vertex as usize]))
            .collect(),
        ..levels.clone()
    };
    for error in [0.0, 0.001, 0.01, 0.05, 1.0] {
        let clusters = drawn_at(&welded, error);
        for [a, b] in odd_edges(&welded, &clusters) {
            let [a, b] = [a, b].map(|vertex| mesh.positions[vertex as usize].z);
            let is_end = |z: f32| z.abs() < 1e-6 || (z - 4.0).abs() < 1e-5;
            assert!(is_end(a) && is_end(b), "a crack at {a}, {b} with {error}");
        }
    }
}
