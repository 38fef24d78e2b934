//! What holds for any mesh and any list.

use proptest::prelude::*;

use super::*;
use crate::mesh::report::BoundaryLoop;

/// Few vertices, many on each other, so that triangles meet in all ways; some are not there or not finite.
fn any_mesh() -> impl Strategy<Value = Mesh> {
    let coordinate = prop_oneof![
        8 => (-2_i8..=2).prop_map(f32::from),
        4 => -2.0_f32..2.0,
        1 => prop::sample::select(vec![1e15_f32, -1e15, 1e-40, f32::NAN, f32::INFINITY]),
    ];
    let position = prop::array::uniform3(coordinate).prop_map(Vec3::from_array);
    let triangle = prop::array::uniform3(0_u32..18);
    (
        prop::collection::vec(position, 1..16),
        prop::collection::vec(triangle, 0..40),
    )
        .prop_map(|(positions, triangles)| Mesh {
            origin: DVec3::new(5.0, 0.0, -7.0),
            positions,
            triangles,
        })
}

fn any_mend() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec![
        "weld",
        "weld=0.6",
        "weld=5%",
        "debris",
        "debris=3",
        "largest",
        "orient",
        "close",
        "close=smooth",
        "close=flat:3",
        "smooth",
        "decimate",
        "decimate=4",
        "remesh=20%",
    ])
}

/// Edges with one triangle.
fn rim(report: &Report) -> usize {
    let loops = report.boundary_loops.iter();
    loops.map(BoundaryLoop::edges).sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn mended_meshes_are_clean_and_the_same_again(mesh in any_mesh(), list in prop::collection::vec(any_mend(), 1..4)) {
        let list = list.join(",");
        let found = try_mended(&mesh, &list);
        let threads = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let again = threads.install(|| try_mended(&mesh, &list));
        match (&found, &again) {
            (Ok((mended, accounts)), Ok((other, _))) => {
                prop_assert!(is_clean(mended), "{list}");
                prop_assert_eq!(mended.origin, mesh.origin);
                prop_assert_eq!(mended, other);
                let last = accounts.last().unwrap();
                prop_assert_eq!(last.triangles[1], mended.triangles.len());
                prop_assert_eq!(last.vertices[1], mended.positions.len());
            }
            _ => prop_assert_eq!(found, again),
        }
    }

    #[test]
    fn a_second_time_changes_nothing(
        mesh in any_mesh(),
        list in prop::sample::select(vec!["weld", "weld=0.6", "weld=0.01", "debris=3", "largest", "orient"]),
    ) {
        if let Ok((once, _)) = try_mended(&mesh, list) {
            let (twice, accounts) = try_mended(&once, list).unwrap();
            prop_assert_eq!(&twice, &once);
            let nothing = &accounts[0];
            prop_assert_eq!(nothing.vertices[0], nothing.vertices[1]);
        }
    }

    #[test]
    fn welded_vertices_are_apart_and_near_what_they_were(mesh in any_mesh(), distance in 0.01_f32..1.5) {
        let Ok((welded, _)) = try_mended(&mesh, &format!("weld={distance}")) else { return Ok(()) };
        let limit = f64::from(distance.to_string().parse::<f32>().unwrap());
        for (at, one) in welded.positions.iter().enumerate() {
            let was = mesh.positions.contains(one);
            prop_assert!(was, "{one} is new");
            for other in &welded.positions[at + 1..] {
                prop_assert!(one.as_dvec3().distance(other.as_dvec3()) > limit * 0.999_999);
            }
        }
    }

    #[test]
    fn closing_and_coarsening_make_topology_no_worse(
        mesh in any_mesh(),
        list in prop::sample::select(vec!["close", "close=smooth", "decimate=0.3", "decimate=2", "remesh=30%"]),
    ) {
        let Ok((before, _)) = try_mended(&mesh, "weld") else { return Ok(()) };
        let Ok((after, _)) = try_mended(&before, list) else { return Ok(()) };
        let (old, new) = (look(&before), look(&after));
        prop_assert!(new.non_manifold_edges.len() <= old.non_manifold_edges.len());
        prop_assert!(new.non_manifold_vertices.len() <= old.non_manifold_vertices.len());
        prop_assert_eq!(new.components.len(), old.components.len());
        if list.starts_with("close") {
            // A loop of three may be a triangle that is alone. Which lines are one loop where surfaces touch is a matter of the order, but edges
            // are not.
            let ends = old.boundary_loops.iter().filter(|end| end.closed && end.edges() > 3);
            let closed: usize = ends.map(BoundaryLoop::edges).sum();
            prop_assert!(rim(&new) + closed <= rim(&old));
            prop_assert_eq!(&after.positions[..before.positions.len()], &before.positions[..]);
        } else {
            prop_assert_eq!(new.euler_characteristic(), old.euler_characteristic());
            // Where surfaces touch, where one loop ends and the next begins is a matter of the order.
            prop_assert!(!old.is_manifold() || new.boundary_loops.len() == old.boundary_loops.len());
            prop_assert_eq!(new.is_orientable(), old.is_orientable());
        }
    }
}
