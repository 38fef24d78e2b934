//! Meshes of known facts, and any meshes beside what slow tables find.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;

use super::*;
use crate::mesh::made;

fn look(mesh: &Mesh) -> Report {
    look_by(mesh, &ReportParams::default())
}

fn look_by(mesh: &Mesh, params: &ReportParams) -> Report {
    report(mesh, params, &AtomicBool::new(false), &mut |_, _| {}).unwrap()
}

/// What a whole mesh is like, in one line: components, Euler characteristic, genus of the first component, boundary loops, watertight,
/// orientable, problems (non-manifold edges and vertices, inconsistent edges, turned triangles).
fn facts(report: &Report) -> (usize, i64, Option<u32>, usize, bool, bool, [usize; 4]) {
    (
        report.components.len(),
        report.euler_characteristic(),
        report.components.first().and_then(Component::genus),
        report.boundary_loops.len(),
        report.is_watertight(),
        report.is_orientable(),
        [
            report.non_manifold_edges.len(),
            report.non_manifold_vertices.len(),
            report.inconsistent_edges.len(),
            report.turned_triangles.len(),
        ],
    )
}

#[test]
fn meshes_of_known_shape_have_their_facts() {
    let spheres = made::both(
        &made::sphere(1),
        &made::placed(made::sphere(1), 0.5, 3.0 * Vec3::X),
    );
    let table = [
        (
            "nothing",
            Mesh::default(),
            (0, 0, None, 0, false, true, [0; 4]),
        ),
        (
            "sphere",
            made::sphere(2),
            (1, 2, Some(0), 0, true, true, [0; 4]),
        ),
        ("cube", made::cube(), (1, 2, Some(0), 0, true, true, [0; 4])),
        (
            "torus",
            made::torus(12, 9),
            (1, 0, Some(1), 0, true, true, [0; 4]),
        ),
        (
            "tube",
            made::tube(7, 4),
            (1, 0, Some(0), 2, false, true, [0; 4]),
        ),
        (
            "two spheres",
            spheres,
            (2, 4, Some(0), 0, true, true, [0; 4]),
        ),
        // Its triangles agree along the strip but for the seam.
        (
            "Möbius strip",
            made::moebius(9),
            (1, 0, None, 1, false, false, [0, 0, 1, 0]),
        ),
        // The outer lines of two pages are a loop; that of the third is left over.
        (
            "book",
            made::book(),
            (1, 1, None, 2, false, true, [1, 0, 0, 0]),
        ),
        (
            "bow tie",
            made::bow_tie(),
            (1, 1, None, 2, false, true, [0, 1, 0, 0]),
        ),
        (
            "a turned triangle",
            made::turned(made::sphere(1), |t| t == 5),
            (1, 2, Some(0), 0, true, true, [0, 0, 3, 1]),
        ),
    ];
    for (name, mesh, expected) in table {
        let found = look(&mesh);
        assert_eq!(facts(&found), expected, "{name}");
        let welded = look(&made::soup(&mesh));
        assert_eq!(facts(&welded), expected, "{name} as a soup");
        assert_eq!(welded.area(), found.area(), "{name}");
        assert_eq!(welded.volume(), found.volume(), "{name}");
    }
}

#[test]
fn vertices_that_are_not_joined_are_told_and_can_be_left_apart() {
    let soup = made::soup(&made::cube());
    let welded = look(&soup);
    assert_eq!(welded.duplicate_vertices.len(), 36 - 8);
    assert!(welded.is_watertight());
    let apart = look_by(&soup, &ReportParams { weld: false });
    assert_eq!(apart.duplicate_vertices, welded.duplicate_vertices);
    assert_eq!(facts(&apart), (12, 12, Some(0), 12, false, true, [0; 4]));
}

#[test]
fn measures_are_those_of_the_shapes() {
    let cube = Mesh {
        origin: DVec3::new(1e9, 0.0, -3.0),
        ..made::placed(made::cube(), 2.0, Vec3::splat(5.0))
    };
    let found = look(&cube);
    assert_eq!(found.size(), DVec3::splat(2.0));
    assert_eq!(found.min, DVec3::new(1e9 + 5.0, 5.0, 2.0));
    assert_eq!(found.area(), 24.0);
    assert_eq!(found.volume(), Some(8.0));
    let tube = look(&made::tube(6, 4));
    assert_eq!(tube.volume(), None);
    for (end, z) in tube.boundary_loops.iter().zip([0.0, 3.0]) {
        assert!(end.closed && end.edges() == 6);
        assert!((end.length - 6.0).abs() < 1e-6, "a hexagon of radius 1");
        assert!(end.centre.distance(DVec3::new(0.0, 0.0, z)) < 1e-6);
    }
    let torus = look(&made::torus(400, 300));
    let exact = 2.0 * std::f64::consts::PI.powi(2) * 2.0 * 0.25;
    assert!((torus.volume().unwrap() / exact - 1.0).abs() < 1e-3);
}

#[test]
fn components_come_with_the_largest_first() {
    let small = made::sphere(1);
    let large = made::placed(made::cube(), 10.0, Vec3::splat(20.0));
    let found = look(&made::both(&small, &large));
    let triangles: Vec<_> = found
        .components
        .iter()
        .map(|c| (c.first_triangle, c.triangles))
        .collect();
    assert_eq!(triangles, [(80, 12), (0, 80)]);
    assert_eq!(found.component_of_triangle[0], 1);
    assert_eq!(found.component_of_triangle[91], 0);
    let cube = &found.components[0];
    assert_eq!((cube.vertices, cube.edges), (8, 18));
    assert_eq!(
        (cube.min, cube.max),
        (DVec3::splat(20.0), DVec3::splat(30.0))
    );
}

#[test]
fn what_is_inside_out_is_told_unless_it_is_a_hollow() {
    let inverted = made::turned(made::sphere(1), |_| true);
    let found = look(&inverted);
    assert!(found.components[0].is_inside_out());
    assert_eq!(facts(&found), (1, 2, Some(0), 0, true, true, [0; 4]));
    assert_eq!(found.volume(), look(&made::sphere(1)).volume());
    let cavity = made::placed(inverted.clone(), 0.1, Vec3::splat(0.5));
    let hollow = look(&made::both(&made::cube(), &cavity));
    assert!(hollow.components[1].hollow && !hollow.components[1].is_inside_out());
    assert!(hollow.volume().unwrap() < 1.0);
    // A box with a window still has its hollow, and what is in the box of a ring but not in the ring is none.
    let mut open = made::cube();
    open.triangles.pop();
    let open = look(&made::both(&open, &cavity));
    assert!(open.components[1].hollow && open.components[0].boundary_loops == 1);
    assert_eq!(open.volume(), None);
    let in_the_hole = made::placed(inverted.clone(), 0.1, Vec3::ZERO);
    let ring = look(&made::both(&made::torus(30, 20), &in_the_hole));
    assert!(ring.components[1].is_inside_out());
    let beside = look(&made::both(
        &made::cube(),
        &made::placed(inverted, 0.1, Vec3::splat(5.0)),
    ));
    assert!(beside.components[1].is_inside_out());
    assert!(beside.volume().unwrap() > 1.0);
}

#[test]
fn triangles_that_no_surface_has_are_told_and_left_out() {
    let mut mesh = made::cube();
    mesh.positions.extend([
        Vec3::NAN,
        Vec3::splat(9.0),
        Vec3::splat(0.25),
        Vec3::splat(0.75),
    ]);
    mesh.triangles.extend([
        [0, 1, 99],
        [0, 1, 8],
        [2, 2, 3],
        [3, 0, 2],
        mesh.triangles[4],
        [0, 10, 11],
        [u32::MAX; 3],
    ]);
    let found = look(&mesh);
    assert_eq!(found.unusable_triangles, [12, 13, 18]);
    assert_eq!(found.degenerate_triangles, [14]);
    assert_eq!(found.duplicate_triangles, [15, 16]);
    assert_eq!(found.zero_area_triangles, [17]);
    assert_eq!(found.unused_vertices, [8, 9]);
    assert_eq!(found.size(), DVec3::ONE);
    assert_eq!(
        found.component_of_triangle[12..],
        [NONE, NONE, NONE, NONE, NONE, 0, NONE]
    );
    // What is left is the cube, with the triangle without area on a corner.
    assert_eq!(facts(&found), (1, 2, None, 1, false, true, [0, 1, 0, 0]));
}

#[test]
fn a_line_is_one_exactly() {
    let table = [
        ([0.1, 0.2, 0.4], false),
        ([0.25, 0.5, 0.75], true),
        ([1.0, 1.0, 1.0], true),
        ([1e-45, 2e-45, 4e-45], true),
    ];
    for ([a, b, c], expected) in table {
        let point = |x: f32| Vec3::new(x, 2.0 * x, if expected { -x } else { x * x });
        assert_eq!(
            is_line([point(a), point(b), point(c)]),
            expected,
            "{a} {b} {c}"
        );
    }
    assert!(!is_line([
        Vec3::ZERO,
        Vec3::splat(1e30),
        Vec3::new(2e30, 2e30, 2.000_001e30)
    ]));
}

#[test]
fn it_can_be_cancelled_and_says_how_far_it_is() {
    let cube = made::cube();
    let cancel = AtomicBool::new(false);
    let mut told = Vec::new();
    report(&cube, &ReportParams::default(), &cancel, &mut |done, of| {
        told.push((done, of))
    })
    .unwrap();
    assert_eq!(told.first(), Some(&(0, Stages::ALL)));
    assert_eq!(told.last(), Some(&(Stages::ALL, Stages::ALL)));
    for stop in 0..Stages::ALL {
        let cancel = AtomicBool::new(false);
        let result = report(&cube, &ReportParams::default(), &cancel, &mut |done, _| {
            cancel.store(done == stop, Ordering::Relaxed);
        });
        assert_eq!(result, Err(ReportError::Cancelled), "{stop}");
    }
}

/// Small meshes with all faults: few places, so that vertices, triangles and edges coincide.
fn any_mesh() -> impl Strategy<Value = Mesh> {
    let position = prop::array::uniform3(prop_oneof![
        20 => (-1_i8..=1).prop_map(f32::from),
        1 => prop::num::f32::ANY,
    ]);
    let triangle = prop::array::uniform3(0_u32..13);
    (
        prop::collection::vec(position, 12),
        prop::collection::vec(triangle, 0..30),
    )
        .prop_map(|(positions, triangles)| Mesh {
            origin: DVec3::ZERO,
            positions: positions.into_iter().map(Vec3::from).collect(),
            triangles,
        })
}

/// Triangles as the report has them, by tables.
fn kept(mesh: &Mesh, weld: bool) -> Vec<(u32, [u32; 3])> {
    let first = |vertex: u32| {
        let position = mesh.positions[vertex as usize];
        let used = |other: u32| {
            mesh.triangles.iter().any(|triangle| {
                triangle.contains(&other)
                    && triangle.iter().all(|v| {
                        mesh.positions
                            .get(*v as usize)
                            .is_some_and(|p| p.is_finite())
                    })
            })
        };
        (0..=vertex)
            .find(|other| weld && used(*other) && mesh.positions[*other as usize] == position)
            .unwrap_or(vertex)
    };
    let mut seen = BTreeSet::new();
    (0_u32..)
        .zip(&mesh.triangles)
        .filter(|(_, t)| {
            t.iter().all(|v| {
                mesh.positions
                    .get(*v as usize)
                    .is_some_and(|p| p.is_finite())
            })
        })
        .map(|(number, triangle)| (number, triangle.map(first)))
        .filter(|(_, triangle)| {
            let set = BTreeSet::from(*triangle);
            set.len() == 3 && seen.insert(set)
        })
        .collect()
}

fn flooded(pairs: &[(u32, u32)], nodes: &BTreeSet<u32>) -> usize {
    let mut label: BTreeMap<u32, u32> = nodes.iter().map(|node| (*node, *node)).collect();
    for (a, b) in pairs {
        let (from, to) = (label[a], label[b]);
        label
            .values_mut()
            .filter(|l| **l == from)
            .for_each(|l| *l = to);
    }
    label.values().collect::<BTreeSet<_>>().len()
}

proptest! {
    #[test]
    fn any_mesh_has_the_facts_that_tables_find(mesh in any_mesh(), weld: bool) {
        let found = look_by(&mesh, &ReportParams { weld });
        let kept = kept(&mesh, weld);
        let mut edges: BTreeMap<[u32; 2], Vec<(u32, bool)>> = BTreeMap::new();
        for (number, [a, b, c]) in &kept {
            for (from, to) in [(*a, *b), (*b, *c), (*c, *a)] {
                edges.entry([from.min(to), from.max(to)]).or_default().push((*number, from < to));
            }
        }
        let with = |is: fn(&[(u32, bool)]) -> bool| -> Vec<[u32; 2]> {
            edges.iter().filter(|(_, of)| is(of)).map(|(edge, _)| *edge).collect()
        };
        prop_assert_eq!(&found.non_manifold_edges, &with(|of| of.len() > 2));
        prop_assert_eq!(&found.inconsistent_edges, &with(|of| of.len() == 2 && of[0].1 == of[1].1));
        let boundary = with(|of| of.len() == 1);
        let in_loops: usize = found.boundary_loops.iter().map(BoundaryLoop::edges).sum();
        prop_assert_eq!(in_loops, boundary.len());
        let vertices: BTreeSet<u32> = kept.iter().flat_map(|(_, t)| *t).collect();
        let pairs: Vec<(u32, u32)> = edges.keys().map(|[a, b]| (*a, *b)).collect();
        prop_assert_eq!(found.components.len(), flooded(&pairs, &vertices));
        let euler = vertices.len() + kept.len();
        prop_assert_eq!(found.euler_characteristic(), euler as i64 - edges.len() as i64);
        // Fans: triangles of a vertex, joined over edges of two triangles.
        let on_non_manifold: BTreeSet<u32> = found.non_manifold_edges.iter().flatten().copied().collect();
        let fans = |vertex: u32| {
            let of: BTreeSet<u32> = kept.iter().filter(|(_, t)| t.contains(&vertex)).map(|(n, _)| *n).collect();
            let pairs: Vec<(u32, u32)> = edges
                .iter()
                .filter(|(edge, of)| edge.contains(&vertex) && of.len() == 2)
                .map(|(_, of)| (of[0].0, of[1].0))
                .collect();
            flooded(&pairs, &of)
        };
        let expected: Vec<u32> = vertices
            .iter()
            .copied()
            .filter(|vertex| !on_non_manifold.contains(vertex) && fans(*vertex) > 1)
            .collect();
        prop_assert_eq!(&found.non_manifold_vertices, &expected);
        // Turning the triangles mends all edges of patches with two sides.
        let mut mended = mesh.clone();
        for triangle in &found.turned_triangles {
            mended.triangles[*triangle as usize].swap(1, 2);
        }
        let mended = look_by(&mended, &ReportParams { weld });
        prop_assert_eq!(mended.is_orientable(), found.is_orientable());
        if found.is_orientable() {
            prop_assert!(mended.inconsistent_edges.is_empty());
        }
        prop_assert!(2 * found.turned_triangles.len() <= kept.len());
    }

    #[test]
    fn a_report_does_not_depend_on_the_order_of_triangles(mesh in any_mesh()) {
        let mut reversed = mesh.clone();
        reversed.triangles.reverse();
        let (one, other) = (look(&mesh), look(&reversed));
        prop_assert_eq!(one.euler_characteristic(), other.euler_characteristic());
        prop_assert_eq!(one.is_orientable(), other.is_orientable());
        prop_assert_eq!(one.is_watertight(), other.is_watertight());
        prop_assert_eq!(one.non_manifold_edges, other.non_manifold_edges);
        prop_assert_eq!(one.non_manifold_vertices, other.non_manifold_vertices);
    }
}
