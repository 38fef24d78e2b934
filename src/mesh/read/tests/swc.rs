//! Skeletons: read as they are, with a closed surface around them.

use glam::DVec3;

use super::*;
use crate::mesh::report::{ReportParams, report};
use crate::mesh::unit::{Confidence, Unit};

/// A trunk with a fork, far from zero.
fn fork() -> Vec<u8> {
    b"# made by hand\n1 1 90000 0 0 4 -1\n2 3 90000 20 0 3 1\n3 3 90012 40 0 2 2\n4 3 89990 44 3 1.5 2\n".to_vec()
}

#[test]
fn a_skeleton_is_kept_beside_the_surface_of_its_tubes() {
    let model = read(&fork()).unwrap();
    assert_eq!(model.format, Format::Swc);
    let skeleton = model.skeleton.as_ref().unwrap();
    assert_eq!(skeleton.len(), 4);
    assert_eq!(skeleton.segment_count(), 3);
    let third = model.mesh.origin + skeleton.position[2].as_dvec3();
    assert_eq!(third, DVec3::new(90_012.0, 40.0, 0.0));
    assert!(
        skeleton.position[2].length() < 100.0,
        "counted from the origin"
    );
    let scale = model.scale().unwrap();
    assert_eq!(scale.unit, Unit::Micrometres);
    assert_eq!(scale.confidence, Confidence::Customary);

    let never = AtomicBool::new(false);
    let found = report(
        &model.mesh,
        &ReportParams::default(),
        &never,
        &mut |_, _| {},
    )
    .unwrap();
    assert!(found.is_watertight());
    assert!(found.is_manifold());
    assert!(found.is_orientable());
    assert_eq!(found.components.len(), 2, "the axis and the lateral");
    let inside_out = found.components.iter().filter(|one| one.is_inside_out());
    assert_eq!(inside_out.count(), 0);
    // Around the trunk's foot, four wide.
    assert!(
        (found.min.x - 89_986.0).abs() < 4.5 && found.max.x < 90_020.0,
        "{}",
        found.min
    );
    // No vertex twice.
    assert!(found.duplicate_vertices.is_empty());
}

#[test]
fn skeletons_that_are_none_are_told() {
    for (text, told) in [
        (
            "1 1 0 0 0 1 -1\n2 3 0 1 0 x 1\n",
            "line 2 of the SWC file has the radius `x`",
        ),
        (
            "1 1 0 0 0 1 -1\n2 3 0 1 0 1 7\n",
            "line 2 of the SWC file names the parent 7",
        ),
        ("1 1 0 0 0 1 2\n2 3 0 1 0 1 1\n", "is its own ancestor"),
        ("1 1 0 0 0 1 -1\n2 1 0 0 0 1 -1\n", "no node has a parent"),
        (
            "1 1 0 0 0 0 -1\n2 3 0 0 0 0 1\n",
            "has 0 vertices and no triangle",
        ),
    ] {
        let found = fault(text.as_bytes());
        assert!(found.contains(told), "{found}\nis not\n{told}");
    }
}

#[test]
fn long_skeletons_have_plainer_tubes() {
    let mut text = String::from("1 1 0 0 0 1 -1\n");
    for node in 2..200 {
        text += &format!("{node} 3 0 {node} 0 1 {}\n", node - 1);
    }
    let sides = |triangles: usize| {
        let limits = ReadLimits {
            triangles,
            ..ReadLimits::default()
        };
        let model = read_bytes(text.as_bytes(), &limits, &AtomicBool::new(false));
        model.map(|model| model.mesh.triangles.len())
    };
    let finest = sides(100_000).unwrap();
    assert!((2 * 12 * 198..2 * 12 * 200).contains(&finest), "{finest}");
    let plainest = sides(2 * 3 * 200).unwrap();
    assert!((2 * 3 * 198..2 * 3 * 200).contains(&plainest), "{plainest}");
    assert!(matches!(sides(1000), Err(MeshError::TooMany { .. })));
}
