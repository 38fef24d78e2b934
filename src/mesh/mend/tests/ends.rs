//! Open ends closed.

use super::*;

/// A sphere without its triangles on one side.
fn bowl(times: u32, from: f32) -> Mesh {
    let mut sphere = made::sphere(times);
    let positions = sphere.positions.clone();
    sphere.triangles.retain(|face| {
        face.iter()
            .all(|vertex| positions[*vertex as usize].z < from)
    });
    mended(&sphere, "weld").0
}

#[test]
fn closed_ends_leave_none_and_keep_all_vertices() {
    let mut saddle = made::tube(24, 3);
    for position in &mut saddle.positions {
        // Far out of any plane.
        position.z += position.x * position.y * 4.0;
    }
    let table = [
        ("tube", made::tube(40, 5), 2),
        ("bowl", bowl(3, 0.5), 1),
        ("saddles", saddle, 2),
        ("two triangles that touch", made::bow_tie(), 0),
        ("sphere", made::sphere(1), 0),
    ];
    for (name, mesh, closed) in table {
        for list in ["close", "close=smooth"] {
            let (caps, told) = mended(&mesh, list);
            assert!(is_clean(&caps), "{name}");
            assert_eq!(
                caps.positions[..mesh.positions.len()],
                mesh.positions,
                "{name}"
            );
            assert_eq!(
                caps.triangles[..mesh.triangles.len()],
                mesh.triangles,
                "{name}"
            );
            if closed > 0 {
                assert_eq!(facts(&caps), (true, true, Some(0), 1, 0), "{name} {list}");
                assert!(look(&caps).inconsistent_edges.is_empty(), "{name}");
                assert!(told[0].contains(&format!("{closed} open end")), "{told:?}");
            }
            assert_eq!(
                mended(&caps, list).0,
                caps,
                "{name}: a second time changes nothing"
            );
        }
    }
}

#[test]
fn flat_ends_are_flat_and_smooth_ends_go_on_as_the_surface_does() {
    let tube = made::tube(40, 5);
    let (flat, told) = mended(&tube, "close");
    let prism = 4.0 * 20.0 * (std::f64::consts::TAU / 40.0).sin();
    assert!((look(&flat).volume().unwrap() / prism - 1.0).abs() < 1e-6);
    assert_eq!(flat.positions, tube.positions);
    assert!(
        told[0].contains("2 flat, 0 by least area, 0 by a fan"),
        "{told:?}"
    );
    // A dome over the cut of a sphere comes back to the sphere, near enough.
    let bowl = bowl(4, 0.5);
    let (flat, _) = mended(&bowl, "close");
    let (smooth, _) = mended(&bowl, "close=smooth");
    let ball = 4.0 / 3.0 * std::f64::consts::PI;
    let [flat, smooth_volume] = [&flat, &smooth].map(|mesh| look(mesh).volume().unwrap() / ball);
    assert!(flat < 0.86, "{flat}");
    assert!((smooth_volume - 1.0).abs() < 0.03, "{smooth_volume}");
    for position in &smooth.positions[bowl.positions.len()..] {
        assert!((position.length() - 1.0).abs() < 0.1, "{position}");
    }
    // In triangles as those around.
    let edge = |mesh: &Mesh| (look(mesh).area() / mesh.triangles.len() as f64).sqrt();
    let caps = Mesh {
        triangles: smooth.triangles[bowl.triangles.len()..].to_vec(),
        ..smooth.clone()
    };
    let ratio = edge(&mended(&caps, "weld").0) / edge(&bowl);
    assert!((0.7..1.4).contains(&ratio), "{ratio}");
}

#[test]
fn loops_that_are_longer_than_asked_for_stay_open() {
    let ends = made::both(
        &bowl(3, 0.9),
        &made::placed(made::tube(12, 3), 2.0, 9.0 * Vec3::X),
    );
    let open = |list: &str| look(&mended(&ends, list).0).boundary_loops.len();
    assert_eq!(open("close=flat:1"), 3);
    assert_eq!(open("close=flat:5"), 2);
    assert_eq!(open("close=flat:50"), 0);
    let (_, told) = mended(&ends, "close=smooth:5");
    assert!(
        told[0].contains("2 loops longer than asked for left open"),
        "{told:?}"
    );
}

#[test]
fn caps_make_no_edge_that_is_there() {
    // Two quads on one diagonal each, so that the outer loop has an edge of the mesh for each of its chords.
    let mut sheet = made::cube();
    sheet.triangles.truncate(2);
    let sheet = mended(&sheet, "weld").0;
    for list in ["close", "close=smooth"] {
        let (closed, told) = mended(&sheet, list);
        assert!(
            look(&closed).is_watertight() && look(&closed).is_manifold(),
            "{told:?}"
        );
    }
    // With both chords there, a fan is left.
    let mut both = made::cube();
    both.triangles.truncate(2);
    let mut both = mended(&both, "weld").0;
    let [a, b, c] = both.triangles[0];
    let d = *both.triangles[1]
        .iter()
        .find(|v| ![a, b, c].contains(*v))
        .unwrap();
    let shared: Vec<u32> = both.triangles[1]
        .iter()
        .copied()
        .filter(|v| [a, b, c].contains(v))
        .collect();
    let other = *[a, b, c].iter().find(|v| !shared.contains(*v)).unwrap();
    both.positions.push(Vec3::new(0.5, 0.5, 7.0));
    both.triangles.push([other, d, 4]);
    let (closed, told) = mended(&both, "close");
    assert!(told[0].contains("by a fan"), "{told:?}");
    assert!(look(&closed).non_manifold_edges.is_empty(), "{told:?}");
    assert!(
        told[0].contains("1 triangle that is alone left open") || look(&closed).is_watertight()
    );
    // Lines between non-manifold edges are no loops.
    let (book, told) = mended(&made::book(), "close");
    assert!(
        told[0].contains("interrupted by non-manifold edges left open"),
        "{told:?}"
    );
    assert!(is_clean(&book));
}

#[test]
fn giant_loops_are_closed_in_bounded_time() {
    // A crown of 30,000 edges that no plane holds.
    let mut crown = made::tube(30_000, 2);
    for (at, position) in crown.positions.iter_mut().enumerate() {
        position.z += (at as f32 / 500.0).sin();
    }
    let (closed, told) = mended(&crown, "close");
    assert!(look(&closed).is_watertight(), "{told:?}");
    assert_eq!(closed.triangles.len(), crown.triangles.len() + 2 * 29_998);
}
