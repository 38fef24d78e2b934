//! Known pairs, and any triangles beside their shadows and beside brute force.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use proptest::prelude::*;

use super::*;
use crate::mesh::made;

type Whole = [i64; 3];

fn minus(a: Whole, b: Whole) -> Whole {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: Whole, b: Whole) -> Whole {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The oracle, another way than the room's: closed convex shapes are apart if and only if their shadows on some axis are, and for triangles
/// the axes are the normals, the products of two edges, and in one plane what stands on an edge. Whole numbers make it exact.
fn meet_by_shadows(one: [Whole; 3], other: [Whole; 3]) -> bool {
    let edges = |[a, b, c]: [Whole; 3]| [minus(b, a), minus(c, b), minus(a, c)];
    let normal = |t: [Whole; 3]| cross(edges(t)[0], edges(t)[1]);
    let mut axes = vec![normal(one), normal(other)];
    for edge in edges(one) {
        axes.extend(edges(other).map(|across| cross(edge, across)));
        axes.push(cross(edge, normal(one)));
    }
    axes.extend(edges(other).map(|edge| cross(edge, normal(other))));
    !axes.iter().any(|axis| {
        let shadow = |t: [Whole; 3]| t.map(|p| (0..3).map(|i| p[i] * axis[i]).sum::<i64>());
        let (one, other) = (shadow(one), shadow(other));
        one.iter().max() < other.iter().min() || other.iter().max() < one.iter().min()
    })
}

fn whole(point: Vec3) -> Whole {
    point.as_i64vec3().to_array()
}

fn has_area(triangle: [Vec3; 3]) -> bool {
    let [a, b, c] = triangle.map(whole);
    cross(minus(b, a), minus(c, a)) != [0; 3]
}

fn brute_force(mesh: &Mesh) -> Vec<[u32; 2]> {
    let count = u32::try_from(mesh.triangles.len()).unwrap();
    let of = |t: u32| corners(mesh, t).filter(|corners| has_area(*corners));
    let mut found = Vec::new();
    for a in 0..count {
        for b in a + 1..count {
            if let (Some(one), Some(other)) = (of(a), of(b))
                && !one.iter().any(|corner| other.contains(corner))
                && meet_by_shadows(one.map(whole), other.map(whole))
            {
                found.push([a, b]);
            }
        }
    }
    found
}

fn look(mesh: &Mesh) -> Intersections {
    look_by(mesh, usize::MAX)
}

fn look_by(mesh: &Mesh, pairs_most: usize) -> Intersections {
    let never = AtomicBool::new(false);
    intersections(
        mesh,
        &IntersectParams { pairs_most },
        &never,
        &mut |_, _| {},
    )
    .unwrap()
}

fn triangle(points: [[f32; 3]; 3]) -> [Vec3; 3] {
    points.map(Vec3::from)
}

#[test]
fn what_touches_meets() {
    let base = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
    let table = [
        (
            "through",
            [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]],
            true,
        ),
        (
            "beside",
            [[5.0, 5.0, -1.0], [5.0, 5.0, 1.0], [6.0, 5.0, 1.0]],
            false,
        ),
        (
            "above",
            [[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 1.0]],
            false,
        ),
        (
            "a corner on the face",
            [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]],
            true,
        ),
        (
            "a corner on an edge",
            [[2.0, 2.0, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]],
            true,
        ),
        (
            "a corner on the plane",
            [[3.0, 2.0, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]],
            false,
        ),
        (
            "an edge on the face",
            [[1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [2.0, 1.0, 1.0]],
            true,
        ),
        (
            "an edge on the plane",
            [[5.0, 5.0, 0.0], [9.0, 1.0, 0.0], [5.0, 5.0, 1.0]],
            false,
        ),
        (
            "edges that cross",
            [[2.0, 0.0, -1.0], [2.0, 0.0, 1.0], [2.0, -3.0, 0.0]],
            true,
        ),
        (
            "in the plane, across",
            [[-1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [9.0, 2.0, 0.0]],
            true,
        ),
        (
            "in the plane, within",
            [[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 2.0, 0.0]],
            true,
        ),
        (
            "in the plane, around",
            [[-9.0, -9.0, 0.0], [30.0, -9.0, 0.0], [-9.0, 30.0, 0.0]],
            true,
        ),
        (
            "in the plane, at a corner",
            [[4.0, 0.0, 0.0], [8.0, 0.0, 0.0], [8.0, 4.0, 0.0]],
            true,
        ),
        (
            "in the plane, apart",
            [[4.1, 0.0, 0.0], [8.0, 0.0, 0.0], [8.0, 4.0, 0.0]],
            false,
        ),
        (
            "on the same line, apart",
            [[5.0, 0.0, 0.0], [8.0, 0.0, 0.0], [6.0, 0.0, 3.0]],
            false,
        ),
    ];
    for (name, other, expected) in table {
        let other = triangle(other);
        for shift in 0..3 {
            let turn = |p: Vec3| Vec3::new(p[shift], p[(shift + 1) % 3], p[(shift + 2) % 3]);
            let (a, b) = (base.map(turn), other.map(turn));
            assert_eq!(meet(a, b), expected, "{name}");
            assert_eq!(meet(b, a), expected, "{name}, the other way");
            assert_eq!(meet([a[2], a[1], a[0]], b), expected, "{name}, from behind");
        }
    }
}

#[test]
fn the_smallest_step_decides() {
    let base = triangle([[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 1.0]]);
    let above = |z: f32| triangle([[1.0, 1.0, z], [1.0, 1.0, 2.0], [2.0, 1.0, 2.0]]);
    assert!(meet(base, above(1.0)));
    assert!(!meet(base, above(1.0_f32.next_up())));
    assert!(meet(base, above(1.0_f32.next_down())));
}

#[test]
fn clean_surfaces_have_no_pairs_and_pushed_ones_have_those_of_brute_force() {
    for mesh in [
        made::sphere(2),
        made::torus(20, 12),
        made::cube(),
        made::moebius(9),
        made::book(),
    ] {
        let found = look(&mesh);
        assert!(found.complete && found.pairs.is_empty());
        assert!(look(&made::soup(&mesh)).pairs.is_empty());
    }
    let pushed = made::both(
        &made::sphere(2),
        &made::placed(made::sphere(2), 1.0, Vec3::X),
    );
    // On a grid, so that brute force is exact.
    let mut pushed = made::placed(pushed, 500.0, Vec3::ZERO);
    pushed.positions.iter_mut().for_each(|p| *p = p.round());
    let found = look(&pushed);
    assert_eq!(found.pairs, brute_force(&pushed));
    assert!(found.pairs.len() > 40);
    assert!(
        found.pairs.iter().all(|[a, b]| *a < 320 && *b >= 320),
        "one of each"
    );
    assert_eq!(look(&made::soup(&pushed)), found);
}

#[test]
fn the_bound_cuts_the_sorted_list() {
    let pushed = made::both(
        &made::sphere(2),
        &made::placed(made::sphere(2), 1.0, Vec3::X),
    );
    let all = look(&pushed);
    for most in [0, 1, 7, all.pairs.len() - 1, all.pairs.len()] {
        let some = look_by(&pushed, most);
        assert_eq!(some.pairs, all.pairs[..most]);
        assert_eq!(some.complete, most == all.pairs.len());
    }
    let triangles = all.triangles();
    assert!(triangles.is_sorted_by(|a, b| a < b));
}

#[test]
fn more_pairs_than_the_bound_are_those_that_come_first_in_many_blocks_too() {
    let fine = made::torus(200, 100);
    let pushed = made::both(&fine, &made::placed(fine.clone(), 1.0, Vec3::splat(0.21)));
    let all = look(&pushed);
    assert!(all.complete && all.pairs.len() > 1000);
    for most in [1, all.pairs.len() / 2, all.pairs.len() - 1] {
        let some = look_by(&pushed, most);
        assert!(!some.complete);
        assert_eq!(some.pairs, all.pairs[..most]);
    }
}

#[test]
fn anything_may_be_asked() {
    let apart = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| f32::MAX * p);
    let far = Mesh {
        positions: [apart, apart.map(|p| p + Vec3::ONE)].concat(),
        triangles: vec![[0, 1, 2], [3, 4, 5], [9, 0, 1]],
        ..Mesh::default()
    };
    let flat = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::NAN, Vec3::INFINITY],
        triangles: vec![[0, 1, 1], [0, 1, 2], [0, 3, 1], [7, 8, 9]],
        ..Mesh::default()
    };
    for (mesh, expected) in [(Mesh::default(), 0), (flat, 0), (far, 0)] {
        assert_eq!(look(&mesh).pairs.len(), expected);
    }
    // Many of the same: three corners each, a hair apart, so that none is a neighbour.
    let shifted = |step: u16| made::placed(made::bow_tie(), 1.0, Vec3::Z * f32::from(step) * 1e-7);
    let pile = (1..200).fold(shifted(0), |pile, step| made::both(&pile, &shifted(step)));
    assert!(look(&pile).complete);
    let cancel = AtomicBool::new(true);
    assert_eq!(
        intersections(&pile, &IntersectParams::default(), &cancel, &mut |_, _| {}),
        None
    );
}

proptest! {
    #[test]
    fn triangles_meet_as_their_shadows_say(points in prop::array::uniform6(prop::array::uniform3(-3_i8..=3))) {
        let point = |i: usize| Vec3::from(points[i].map(f32::from));
        let (one, other) = ([point(0), point(1), point(2)], [point(3), point(4), point(5)]);
        prop_assume!(has_area(one) && has_area(other));
        let expected = meet_by_shadows(one.map(whole), other.map(whole));
        prop_assert_eq!(meet(one, other), expected);
        prop_assert_eq!(meet(other, one), expected);
    }

    #[test]
    fn pairs_are_those_of_brute_force(
        points in prop::collection::vec(prop::array::uniform3(-4_i8..=4), 3..40),
        triangles in prop::collection::vec(prop::array::uniform3(0_u32..40), 0..40),
    ) {
        let mesh = Mesh {
            positions: points.into_iter().map(|p| Vec3::from(p.map(f32::from))).collect(),
            triangles,
            ..Mesh::default()
        };
        let found = look(&mesh);
        prop_assert_eq!(&found.pairs, &brute_force(&mesh));
        let half = found.pairs.len() / 2;
        prop_assert_eq!(&look_by(&mesh, half).pairs, &found.pairs[..half]);
    }
}
