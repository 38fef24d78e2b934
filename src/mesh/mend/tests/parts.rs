//! Joining, dropping and turning.

use super::*;

#[test]
fn corners_of_equal_place_become_one_and_all_that_is_no_surface_goes() {
    let mut soup = made::soup(&made::cube());
    soup.positions.extend([Vec3::NAN, Vec3::ZERO]);
    soup.triangles.extend([
        [0, 0, 1],   // twice a vertex
        [0, 1, 36],  // not finite
        [0, 1, 999], // not there
        [2, 1, 0],   // there already
        [0, 37, 1],  // twice a place
    ]);
    let (welded, told) = mended(&soup, "weld");
    assert_eq!(welded.positions.len(), 8);
    assert_eq!(facts(&welded), (true, true, Some(0), 1, 0));
    assert_eq!(
        told,
        [
            "weld=0: 2 triangles with a vertex that is not there or not finite dropped, 29 vertices joined, \
             2 degenerate triangles dropped, 1 triangle that was there already dropped, 1 unused vertex dropped; \
             38 → 8 vertices; 17 → 12 triangles"
        ]
    );
    let (again, told) = mended(&welded, "weld");
    assert_eq!(again, welded);
    assert_eq!(told, ["weld=0: nothing to do"]);
}

#[test]
fn vertices_are_joined_up_to_the_distance_and_no_farther() {
    // A row of points, 1 apart, hanging together by triangles to a far one.
    let mut row = Mesh::default();
    row.positions.push(Vec3::new(0.0, 100.0, 0.0));
    for at in 0..10_u16 {
        row.positions.push(Vec3::new(f32::from(at), 0.0, 0.0));
    }
    row.triangles = (1..10).map(|at| [0, at, at + 1]).collect();
    let left = |list: &str| mended(&row, list).0.positions.len() - 1;
    assert_eq!(left("weld=0.99"), 10);
    // Each second one stands for the one after it: a row does not become a point.
    assert_eq!(left("weld=1"), 5);
    assert_eq!(left("weld=2.5"), 4);
    // The diagonal is 100.4 long.
    assert_eq!(left("weld=0.9%"), 10);
    assert_eq!(left("weld=1%"), 5);
    let all = try_mended(&row, "weld=100%").unwrap_err();
    assert!(
        all.to_string()
            .contains("`weld=100%` would leave no triangle")
    );
}

#[test]
fn small_components_go_and_the_largest_stays() {
    let mut three = made::both(
        &made::placed(made::cube(), 0.05, 5.0 * Vec3::X),
        &made::sphere(2),
    );
    three = made::both(&three, &made::placed(made::tube(9, 3), 0.3, 5.0 * Vec3::Y));
    let components = |list: &str| look(&mended(&three, list).0).components.len();
    assert_eq!(components("debris"), 2);
    assert_eq!(components("debris=0.0001"), 3);
    assert_eq!(components("debris=12"), 3);
    assert_eq!(components("debris=13"), 2);
    assert_eq!(components("debris=37"), 1);
    assert_eq!(components("debris=100%"), 1);
    assert_eq!(components("largest"), 1);
    let (largest, told) = mended(&three, "largest");
    assert_eq!(largest.triangles.len(), 320);
    assert!(
        told[0].starts_with("largest: 2 components dropped, the largest kept (91.65 %"),
        "{told:?}"
    );
    let (sphere, told) = mended(&largest, "debris,largest");
    assert_eq!(sphere, largest);
    assert_eq!(
        told,
        ["debris=0.01: nothing to do", "largest: nothing to do"]
    );
    let none = try_mended(&three, "debris=1000").unwrap_err();
    assert_eq!(
        none,
        MendError::NothingLeft(Mend::parse("debris=1000").unwrap())
    );
}

#[test]
fn triangles_agree_and_face_outwards() {
    let far = |mesh, by| made::placed(mesh, 1.0, by * Vec3::X);
    let table = [
        ("some turned", made::turned(made::sphere(2), |t| t % 7 < 2)),
        ("most turned", made::turned(made::sphere(2), |t| t % 7 < 5)),
        ("inside out", made::turned(made::torus(12, 9), |_| true)),
        (
            "a soup far away",
            far(
                made::soup(&made::turned(made::sphere(1), |t| t % 2 == 0)),
                1e4,
            ),
        ),
        (
            "a tube inside out",
            made::turned(made::tube(9, 5), |_| true),
        ),
        (
            "a tube that disagrees",
            made::turned(made::tube(9, 5), |t| t % 3 > 0),
        ),
    ];
    for (name, mesh) in table {
        let (oriented, _) = mended(&mesh, "orient");
        let report = look(&oriented);
        assert!(report.inconsistent_edges.is_empty(), "{name}");
        // Once closed, so that tubes have a volume too.
        let (closed, _) = mended(&oriented, "close");
        let volume = look(&closed).components[0].signed_volume.unwrap();
        assert!(volume > 0.0, "{name}: {volume}");
        let (again, told) = mended(&oriented, "orient");
        assert_eq!(
            (again, told[0].as_str()),
            (oriented, "orient: nothing to do")
        );
    }
}

#[test]
fn what_is_right_or_has_no_outside_is_left() {
    let hollow = made::both(
        &made::sphere(2),
        &made::placed(made::turned(made::sphere(1), |_| true), 0.5, Vec3::ZERO),
    );
    assert_eq!(mended(&hollow, "orient").1, ["orient: nothing to do"]);
    let (out, told) = mended(&made::turned(hollow.clone(), |_| true), "orient");
    assert_eq!(told[0], "orient: 1 part turned to face outwards");
    assert!(
        look(&out)
            .components
            .iter()
            .all(|one| one.signed_volume.unwrap() > 0.0)
    );
    let (same, told) = mended(&made::moebius(9), "orient");
    assert_eq!(same, made::moebius(9));
    assert_eq!(
        told[0],
        "orient: 1 component left, since it has only one side"
    );
    let (_, told) = mended(&made::bow_tie(), "orient");
    assert!(
        told[0].contains("2 parts left as they faced, since they are sheets"),
        "{told:?}"
    );
}

#[test]
fn meshes_without_a_triangle_are_refused_by_all() {
    let line = Mesh {
        positions: vec![Vec3::ZERO; 3],
        triangles: vec![[0, 1, 2], [0, 0, 7]],
        ..Mesh::default()
    };
    for list in [
        "weld", "debris", "largest", "orient", "close", "smooth", "decimate", "remesh",
    ] {
        for mesh in [&Mesh::default(), &line] {
            assert_eq!(
                try_mended(mesh, list).unwrap_err(),
                MendError::Nothing,
                "{list}"
            );
        }
    }
}

#[test]
fn work_ends_when_asked_to_and_tells_how_far_it_is() {
    let mesh = made::torus(40, 30);
    for list in [
        "weld=1%", "debris", "largest", "orient", "close", "smooth", "decimate", "remesh",
    ] {
        let one = Mend::parse(list).unwrap();
        let yes = AtomicBool::new(true);
        let ended = mend(mesh.clone(), &one, &yes, &mut |_, _| {});
        assert_eq!(ended.unwrap_err(), MendError::Cancelled, "{list}");
        let (mut last, mut told) = (None, 0);
        mend(
            mesh.clone(),
            &one,
            &AtomicBool::new(false),
            &mut |done, of| {
                assert!(done <= of, "{list}");
                (last, told) = (Some((done, of)), told + 1);
            },
        )
        .unwrap();
        assert!(told > 1 && last == Some((1, 1)), "{list}");
    }
}
