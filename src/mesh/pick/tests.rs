//! Rays and points beside brute force, exact whole numbers, edges and corners, and meshes without sense.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use proptest::prelude::*;

use super::*;
use crate::mesh::made;

pub(super) fn picker(mesh: Mesh) -> Picker {
    Picker::new(Arc::new(mesh), &AtomicBool::new(false), &mut |_, _| {}).unwrap()
}

/// All triangles asked, one after the other.
fn ray_by_all(picker: &Picker, origin: Vec3, direction: Vec3, most: f32) -> Option<(u32, f64)> {
    let sheared = Sheared::new(origin, direction.as_dvec3().try_normalize()?);
    let mut best = None;
    for number in 0..u32::try_from(picker.mesh.triangles.len()).unwrap() {
        let met = picker.corners(number).and_then(|c| sheared.meet(c));
        if let Some(met) = met.filter(|met| met.distance <= f64::from(most))
            && best.is_none_or(|(_, distance)| met.distance < distance)
        {
            best = Some((number, met.distance));
        }
    }
    best
}

fn nearest_by_all(picker: &Picker, point: Vec3, most: f32) -> Option<(u32, f64)> {
    let mut best = None;
    for number in 0..u32::try_from(picker.mesh.triangles.len()).unwrap() {
        let Some(corners) = picker.corners(number) else {
            continue;
        };
        let (_, squared) = triangle::nearest(corners, point.as_dvec3());
        if squared <= f64::from(most).powi(2) && best.is_none_or(|(_, other)| squared < other) {
            best = Some((number, squared));
        }
    }
    best.map(|(number, squared)| (number, squared.sqrt()))
}

fn assert_same(found: Option<Hit>, expected: Option<(u32, f64)>, asked: &str) {
    let found = found.map(|hit| (hit.triangle, hit.distance));
    #[allow(
        clippy::cast_possible_truncation,
        reason = "as hits tell their distances"
    )]
    let expected = expected.map(|(number, distance)| (number, distance as f32));
    assert_eq!(found, expected, "{asked}");
}

#[test]
fn a_cube_is_hit_from_outside_and_inside() {
    let cube = picker(made::cube());
    let table = [
        ([0.3, 0.2, -2.0], [0.0, 0.0, 5.0], Some((2.0, -1.0))),
        ([0.3, 0.2, 0.5], [0.0, 0.0, 0.1], Some((0.5, 1.0))),
        ([0.3, 0.2, 1.5], [0.0, 0.0, 1.0], None),
        ([0.3, 0.2, -2.0], [0.0, 0.0, 0.0], None),
        ([0.3, 0.2, -2.0], [0.0, 0.0, f32::NAN], None),
        ([0.3, f32::INFINITY, -2.0], [0.0, 0.0, 1.0], None),
        // Along a side and along an edge: the faces across are hit.
        ([0.3, 0.0, -2.0], [0.0, 0.0, 1.0], Some((2.0, -1.0))),
        ([0.0, 0.0, -2.0], [0.0, 0.0, 1.0], Some((2.0, -1.0))),
        ([1.0, 1.0, 3.0], [0.0, 0.0, -1.0], Some((2.0, 1.0))),
        // From the surface itself.
        ([0.3, 0.2, 0.0], [0.0, 0.0, 1.0], Some((0.0, -1.0))),
    ];
    for (origin, direction, expected) in table {
        let hit = cube.ray(Vec3::from(origin), Vec3::from(direction), 10.0);
        let told = hit.map(|hit| (hit.distance, hit.normal.z));
        assert_eq!(told, expected, "{origin:?} {direction:?}");
    }
    let up = |sides| cube.ray_to(Vec3::new(0.3, 0.2, -2.0), Vec3::Z, 10.0, sides);
    assert_eq!(up(Sides::Fronts).unwrap().distance, 2.0);
    assert_eq!(up(Sides::Backs).unwrap().distance, 3.0);
    assert_eq!(cube.ray(Vec3::NEG_Z, Vec3::Z, 0.99), None);
    assert_eq!(cube.ray(Vec3::NEG_Z, Vec3::Z, 1.0).unwrap().distance, 1.0);
}

#[test]
fn the_nearest_place_may_be_a_face_an_edge_or_a_corner() {
    let cube = picker(made::cube());
    let table = [
        ([0.3, 0.4, 2.0], [0.3, 0.4, 1.0]),
        ([0.3, 2.0, 2.0], [0.3, 1.0, 1.0]),
        ([-1.0, 2.0, 3.0], [0.0, 1.0, 1.0]),
        ([0.5, 0.6, 0.9], [0.5, 0.6, 1.0]),
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
    ];
    for (point, expected) in table {
        let (point, expected) = (Vec3::from(point), Vec3::from(expected));
        let hit = cube.nearest(point, 100.0).unwrap();
        assert!(hit.point.distance(expected) < 1e-6, "{point} {hit:?}");
        assert!((hit.distance - point.distance(expected)).abs() < 1e-6);
        assert!((hit.barycentric.element_sum() - 1.0).abs() < 1e-6);
    }
    assert_eq!(cube.nearest(Vec3::splat(3.0), 3.0), None);
    assert_eq!(cube.nearest(Vec3::NAN, 3.0), None);
    assert_eq!(cube.nearest(Vec3::ZERO, -1.0), None);
    assert_eq!(cube.nearest(Vec3::ZERO, f32::NAN), None);
    assert!(
        cube.nearest(Vec3::splat(1e9), f32::INFINITY).is_some(),
        "however far"
    );
}

/// A point on an edge of triangles, over whom rounding gives it a height.
#[test]
fn a_point_on_an_edge_is_not_beyond_its_triangles() {
    let on_edge = DVec3::new(0.0, 1.0, 1.0);
    for times in 1..1000_u16 {
        let third = Vec3::new(1.1e-9, -3.3e-10, 0.37) * f32::from(times);
        let corners = [Vec3::new(-1.0, 3.0, -2.0), Vec3::new(2.0, -3.0, 7.0), third];
        assert!(!triangle::is_beyond(corners, on_edge, 0.0), "{third}");
        let above = on_edge + triangle::normal(corners) * 1e-12;
        assert!(triangle::is_beyond(corners, above, 0.0), "{third}");
    }
}

#[test]
fn no_ray_slips_out_of_a_closed_surface() {
    for (scale, by) in [
        (1.0, Vec3::ZERO),
        (1e-9, Vec3::ZERO),
        (1e12, Vec3::splat(3e12)),
    ] {
        let mesh = made::placed(made::sphere(3), scale, by);
        let picker = picker(mesh);
        let inside = by + Vec3::new(0.03, -0.2, 0.1) * scale;
        let mut aims = picker.mesh.positions.clone();
        for [a, b, c] in &picker.mesh.triangles {
            let [a, b, c] = [a, b, c].map(|v| picker.mesh.positions[*v as usize]);
            aims.extend([a.midpoint(b), b.lerp(c, 0.3), (a + b + c) / 3.0]);
        }
        for aim in aims {
            for origin in [by, inside, aim.with_x(by.x), aim.with_y(by.y).with_z(by.z)] {
                let hit = picker.ray(origin, aim - origin, f32::INFINITY);
                assert!(
                    hit.is_some() || origin.distance(by) > 0.98 * scale,
                    "{scale} {origin} {aim}"
                );
            }
        }
    }
}

#[test]
fn sides_and_normals_agree() {
    let picker = picker(made::torus(24, 12));
    for (place, corner) in picker.mesh.positions.iter().enumerate() {
        let direction = *corner - Vec3::new(0.1, 3.0, 4.0);
        for sides in [Sides::Fronts, Sides::Backs] {
            let hit = picker.ray_to(Vec3::new(0.1, 3.0, 4.0), direction, 100.0, sides);
            if let Some(hit) = hit {
                let against = hit.normal.dot(direction) < 1e-4;
                let along = hit.normal.dot(direction) > -1e-4;
                assert!(
                    if sides == Sides::Fronts {
                        against
                    } else {
                        along
                    },
                    "{place}"
                );
            }
        }
    }
}

#[test]
fn meshes_without_sense_are_picked_all_the_same() {
    let far = f32::MAX;
    let cases: Vec<Mesh> = vec![
        Mesh::default(),
        Mesh {
            positions: vec![Vec3::ZERO; 3],
            triangles: vec![[0, 1, 2], [0, 0, 0], [7, 8, 9]],
            ..Mesh::default()
        },
        Mesh {
            positions: vec![Vec3::NAN, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        },
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::X * 3.0],
            triangles: vec![[0, 1, 2]; 5],
            ..Mesh::default()
        },
        Mesh {
            positions: vec![
                Vec3::splat(-far),
                Vec3::new(far, -far, 0.0),
                Vec3::splat(far),
                Vec3::splat(1e-40),
            ],
            triangles: vec![[0, 1, 2], [0, 1, 3], [3, 3, 3]],
            ..Mesh::default()
        },
    ];
    for (case, mesh) in cases.into_iter().enumerate() {
        let picker = picker(mesh);
        for point in [
            Vec3::ZERO,
            Vec3::new(0.5, 0.1, -1.0),
            Vec3::splat(1e30),
            Vec3::splat(far),
        ] {
            let found = picker.nearest(point, f32::INFINITY);
            assert_same(
                found,
                nearest_by_all(&picker, point, f32::INFINITY),
                &case.to_string(),
            );
            for direction in [Vec3::Z, Vec3::NEG_X, Vec3::new(1.0, 1e-38, -0.0)] {
                let found = picker.ray(point, direction, f32::INFINITY);
                let expected = ray_by_all(&picker, point, direction, f32::INFINITY);
                assert_same(found, expected, &format!("{case} {point} {direction}"));
            }
        }
    }
}

/// All triangles in one place, which makes hierarchies deep.
#[test]
fn a_heap_of_equal_triangles_is_picked_in_bounded_depth() {
    let mut mesh = made::cube();
    mesh.triangles = vec![mesh.triangles[1]; 50_000];
    let picker = picker(mesh);
    let topology: Vec<_> = picker.hierarchy.nodes.iter().map(|n| n.children).collect();
    assert!(build::depth(&topology).is_some_and(|depth| depth <= DEPTH_MOST));
    let hit = picker
        .ray(Vec3::new(0.2, 0.1, -1.0), Vec3::Z, 10.0)
        .unwrap();
    assert_eq!((hit.triangle, hit.distance), (0, 1.0));
}

#[test]
fn building_can_be_cancelled_and_says_how_far_it_is() {
    let mesh = Arc::new(made::sphere(2));
    let mut told = Vec::new();
    let never = AtomicBool::new(false);
    Picker::new(Arc::clone(&mesh), &never, &mut |done, of| {
        told.push((done, of))
    })
    .unwrap();
    assert_eq!(told, (0..=5).map(|done| (done, 5)).collect::<Vec<_>>());
    for stop in 0..=5 {
        let cancel = AtomicBool::new(false);
        let built = Picker::new(Arc::clone(&mesh), &cancel, &mut |done, _| {
            cancel.store(done == stop, std::sync::atomic::Ordering::Relaxed);
        });
        assert!(built.is_none(), "{stop}");
    }
}

/// Whether a ray from a whole point in a whole direction meets a triangle of whole corners, exactly and another way: by the signs of the
/// volumes that it spans with the edges, and the distance as a fraction of the direction.
fn exactly(origin: [i64; 3], direction: [i64; 3], corners: [[i64; 3]; 3]) -> Option<(i64, i64)> {
    let minus = |a: [i64; 3], b: [i64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let cross = |a: [i64; 3], b: [i64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let dot = |a: [i64; 3], b: [i64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let [a, b, c] = corners.map(|corner| minus(corner, origin));
    let volumes = [(b, c), (c, a), (a, b)].map(|(p, q)| dot(direction, cross(p, q)));
    let normal = cross(minus(b, a), minus(c, a));
    let (over, under) = (dot(normal, a), dot(normal, direction));
    let one_sided = volumes.iter().all(|v| *v >= 0) || volumes.iter().all(|v| *v <= 0);
    (one_sided && under != 0 && over * under.signum() >= 0).then_some((over, under))
}

fn any_mesh() -> impl Strategy<Value = Mesh> {
    let position = prop::array::uniform3(prop_oneof![
        20 => (-3_i8..=3).prop_map(f32::from),
        5 => -3.0_f32..3.0,
        // Not millions of times the others, where double precision has no distances between them any more.
        1 => prop::num::f32::ANY.prop_filter("far", |number| !number.is_finite() || number.abs() < 1e6),
    ]);
    (
        prop::collection::vec(position, 1..40),
        prop::collection::vec(prop::array::uniform3(0_u32..41), 0..80),
    )
        .prop_map(|(positions, triangles)| Mesh {
            origin: DVec3::ZERO,
            positions: positions.into_iter().map(Vec3::from).collect(),
            triangles,
        })
}

fn any_point() -> impl Strategy<Value = Vec3> {
    let number = prop_oneof![(-4_i8..=4).prop_map(f32::from), -4.0_f32..4.0];
    prop::array::uniform3(number).prop_map(Vec3::from)
}

proptest! {
    #[test]
    fn rays_hit_what_all_triangles_asked_say(mesh in any_mesh(), asked in prop::collection::vec((any_point(), any_point()), 20), most in 0.0_f32..20.0) {
        let picker = picker(mesh);
        for (origin, direction) in asked {
            for most in [most, f32::INFINITY] {
                let found = picker.ray(origin, direction, most);
                let expected = ray_by_all(&picker, origin, direction, most);
                assert_same(found, expected, &format!("{origin} {direction} {most}"));
            }
        }
    }

    #[test]
    fn the_nearest_is_what_all_triangles_asked_say(mesh in any_mesh(), points in prop::collection::vec(any_point(), 20), most in 0.0_f32..5.0) {
        let picker = picker(mesh);
        for point in points {
            for most in [most, f32::INFINITY] {
                assert_same(picker.nearest(point, most), nearest_by_all(&picker, point, most), &point.to_string());
            }
        }
    }

    #[test]
    fn one_triangle_is_hit_exactly_where_whole_numbers_say(
        origin in prop::array::uniform3(-5_i8..=5),
        direction in prop::array::uniform3(-5_i8..=5),
        corners in prop::array::uniform3(prop::array::uniform3(-5_i8..=5)),
    ) {
        let whole = |point: [i8; 3]| point.map(i64::from);
        let float = |point: [i8; 3]| Vec3::from(point.map(f32::from));
        let exact = exactly(whole(origin), whole(direction), corners.map(whole));
        let Some(unit) = float(direction).as_dvec3().try_normalize() else { return Ok(()) };
        // Directions along a diagonal are rounded where they are made unit, so what only touches an edge may be missed, by itself.
        // A ray that begins on the triangle may begin a rounding behind it.
        let inside = exact.is_some_and(|(over, _)| over != 0) && {
            let [a, b, c] = corners.map(|corner| float(corner).as_dvec3() - float(origin).as_dvec3());
            [(b, c), (c, a), (a, b)].iter().all(|(p, q)| unit.dot(p.cross(*q)).abs() > 1e-9)
        };
        let axis = direction.iter().filter(|along| **along != 0).count() == 1;
        let met = Sheared::new(float(origin), unit).meet(corners.map(float));
        if axis || inside {
            prop_assert_eq!(met.is_some(), exact.is_some());
        }
        if let (Some(met), Some((over, under))) = (met, exact) {
            let length = float(direction).as_dvec3().length();
            prop_assert!((met.distance - over as f64 / under as f64 * length).abs() < 1e-9);
        }
    }

    #[test]
    fn the_nearest_of_one_triangle_is_nearer_than_a_fine_grid_of_it(point in any_point(), corners in prop::array::uniform3(any_point())) {
        let (weights, squared) = triangle::nearest(corners, point.as_dvec3());
        prop_assert!(weights.min_element() >= 0.0 && (weights.element_sum() - 1.0).abs() < 1e-9);
        let exact = corners.map(Vec3::as_dvec3);
        let found = triangle::at(exact, weights).distance(point.as_dvec3());
        prop_assert!((found - squared.sqrt()).abs() < 1e-6);
        let mut best = f64::INFINITY;
        for i in 0..=40_u8 {
            for j in 0..=40 - i {
                let (u, v) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
                let at = triangle::at(exact, DVec3::new(u, v, 1.0 - u - v));
                best = best.min(at.distance(point.as_dvec3()));
            }
        }
        let longest = exact[0].distance(exact[1]).max(exact[1].distance(exact[2])).max(exact[2].distance(exact[0]));
        prop_assert!(found <= best + 1e-9 && best <= found + longest / 40.0);
    }
}
