//! Lists, files good and hostile, and proposals on shapes whose ends are known.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::Vec3;
use proptest::prelude::*;

use super::*;
use crate::mesh::pick::Picker;
use crate::mesh::surface::Surface;
use crate::mesh::{Mesh, made, truth};

fn surface(mesh: Mesh) -> Surface {
    let never = AtomicBool::new(false);
    let picker = Picker::new(Arc::new(mesh), &never, &mut |_, _| {}).unwrap();
    Surface::new(picker, &never).unwrap()
}

fn proposals(mesh: Mesh) -> Vec<Proposal> {
    propose(&surface(mesh), &AtomicBool::new(false)).unwrap()
}

#[test]
fn the_next_one_has_a_name_that_no_other_has() {
    let named = |name: &str, kind| Endpoint {
        name: name.to_owned(),
        kind,
        ..Endpoint::default()
    };
    let mut list = Vec::new();
    for (kind, expected) in [
        (Kind::Source, "source"),
        (Kind::Target, "target 1"),
        (Kind::Target, "target 2"),
        (Kind::Source, "source 2"),
    ] {
        let name = next_name(&list, kind);
        assert_eq!(name, expected);
        list.push(named(&name, kind));
    }
    list.remove(1);
    assert_eq!(next_name(&list, Kind::Target), "target 1");
    assert_eq!(
        (count(&list, Kind::Source), count(&list, Kind::Target)),
        (2, 1)
    );
}

#[test]
fn a_table_may_have_its_columns_in_any_order() {
    let all = from_csv(
        "\u{feff}Z, x ,note,y,Kind,name\n3,1,?,2,SOURCE,\"left, upper\"\n 6 ,4,,5e0,,\n".as_bytes(),
    )
    .unwrap();
    assert_eq!(all[0].point, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(
        (all[0].kind, all[0].name.as_str()),
        (Kind::Source, "left, upper")
    );
    assert_eq!((all[1].point.y, all[1].kind), (5.0, Kind::Target));
    assert!(from_csv(b"x,y,z\n").unwrap().is_empty());
}

#[test]
fn hostile_files_are_refused_in_one_sentence_with_the_line() {
    let name = "n".repeat(201);
    let long = format!("x,y,z,name\n1,2,3,{name}");
    let table: &[(&[u8], &str)] = &[
        (b"", "line 1 of the endpoints has no column x"),
        (b"x,y\n1,2", "no column z"),
        (
            b"x,y,z\n1,2,3\n1,2",
            "line 3 of the endpoints has 2 columns and the first line 3",
        ),
        (
            b"x,y,z\n1,2,drei",
            "line 2 of the endpoints has \"drei\" in column z",
        ),
        (
            b"x,y,z\n1,nan,3",
            "line 2 of the endpoints has the coordinate NaN",
        ),
        (b"x,y,z\n1,2,-1e16", "has the coordinate -10000000000000000"),
        (
            b"x,y,z,kind\n1,2,3,root",
            "has the kind \"root\": write source or target",
        ),
        (
            b"x,y,z,radius\n1,2,3,4",
            "line 2 of the endpoints has \"\" in column centre_x",
        ),
        (
            b"x,y,z,centre_x,centre_y,centre_z,radius\n1,2,3,4,5,6,0",
            "has the radius 0: write",
        ),
        (
            b"x,y,z,name\n1,2,3,\"a\nb\"",
            "line 2 of the endpoints has a name with a line break",
        ),
        (
            b"x,y,z\n1,2,\xff",
            "line 2 of the endpoints has bytes that are no UTF-8",
        ),
        (
            long.as_bytes(),
            "line 2 of the endpoints has a name of 201 bytes",
        ),
    ];
    for (bytes, expected) in table {
        let told = from_csv(bytes).unwrap_err().to_string();
        assert!(told.contains(expected), "{told}");
        assert_eq!(told.lines().count(), 1);
    }
    let deep = "[".repeat(100_000);
    let table = [
        ("", "line 1 of the endpoints is not as JSON"),
        (deep.as_str(), "is not as JSON of endpoints must be"),
        (
            "{\"format\":\"other/9\",\"endpoints\":[]}",
            "the JSON is \"other/9\"",
        ),
        (
            "{\"format\":\"ramus-endpoints/1\",\n\"endpoints\":[{\"point\":[1,2]}]}",
            "line 2 of",
        ),
        (
            "{\"format\":\"ramus-endpoints/1\",\"endpoints\":[{\"point\":[1,2,1e300]}]}",
            "endpoint 1 in the JSON has the coordinate",
        ),
        (
            "{\"format\":\"ramus-endpoints/1\",\"endpoints\":[{\"point\":[1,2,3],\"radius\":1}]}",
            "only one of centre and radius",
        ),
    ];
    for (text, expected) in table {
        let told = from_json(text.as_bytes()).unwrap_err().to_string();
        assert!(told.contains(expected), "{told}");
        assert_eq!(told.lines().count(), 1);
    }
    let many = format!("x,y,z\n{}", "1,2,3\n".repeat(ENDPOINTS_MOST + 1));
    let told = from_csv(many.as_bytes()).unwrap_err().to_string();
    assert!(
        told.starts_with("line 100002 begins endpoint 100001"),
        "{told}"
    );
}

fn any_endpoint() -> impl Strategy<Value = Endpoint> {
    let point = || prop::array::uniform3(-1e15..1e15_f64).prop_map(DVec3::from);
    let snapped = (point(), 1e-9..1e9_f64).prop_map(|(centre, radius)| Snapped { centre, radius });
    (
        "[ -~äß]{0,30}",
        point(),
        any::<bool>(),
        prop::option::of(snapped),
    )
        .prop_map(|(name, point, is_source, snapped)| Endpoint {
            point,
            name: name.trim().to_owned(),
            kind: if is_source {
                Kind::Source
            } else {
                Kind::Target
            },
            snapped,
        })
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(all in prop::collection::vec(any_endpoint(), 0..20)) {
                prop_assert_eq!(&from_csv(to_csv(&all).as_bytes()).unwrap(), &all);
        prop_assert_eq!(&from_json(to_json(&all).as_bytes()).unwrap(), &all);
    }

    #[test]
    fn no_bytes_stop_the_readers(bytes in prop::collection::vec(any::<u8>(), 0..200), text in "[xyz,\"\n0-9.e-]{0,100}") {
        for bytes in [bytes.as_slice(), text.as_bytes()] {
            let _ = from_csv(bytes);
            let _ = from_json(bytes);
        }
    }
}

#[test]
fn an_open_tube_has_two_ends_and_a_ball_and_a_ring_none() {
    let found = proposals(made::tube(24, 30));
    let told: Vec<_> = found
        .iter()
        .map(|one| (one.reason, one.endpoint.kind))
        .collect();
    assert_eq!(
        told,
        [
            (Reason::OpenEnd, Kind::Source),
            (Reason::OpenEnd, Kind::Target)
        ]
    );
    let mut heights: Vec<f64> = found.iter().map(|one| one.endpoint.point.z).collect();
    heights.sort_by(f64::total_cmp);
    assert!(
        heights[0].abs() < 1e-6 && (heights[1] - 29.0).abs() < 1e-5,
        "{heights:?}"
    );
    assert!(
        found
            .iter()
            .all(|one| one.arm > 20.0 && (one.endpoint.snapped.unwrap().radius - 1.0).abs() < 0.01)
    );
    for none in [
        made::sphere(4),
        made::torus(60, 24),
        made::cube(),
        made::bow_tie(),
        Mesh::default(),
    ] {
        assert_eq!(
            proposals(none.clone()),
            [],
            "{} triangles",
            none.triangles.len()
        );
    }
}

#[test]
fn a_hole_in_a_wall_is_no_end() {
    let mut mesh = made::tube(48, 200);
    mesh.positions
        .iter_mut()
        .for_each(|position| position.z *= 0.13);
    let middle = Vec3::new(1.0, 0.0, 13.0);
    let near = |triangle: &[u32; 3]| {
        triangle
            .iter()
            .any(|v| mesh.positions[*v as usize].distance(middle) < 0.4)
    };
    mesh.triangles = mesh
        .triangles
        .iter()
        .filter(|t| !near(t))
        .copied()
        .collect();
    assert_eq!(proposals(mesh).len(), 2);
}

#[test]
fn proposals_can_be_cancelled() {
    let surface = surface(made::tube(24, 30));
    assert_eq!(propose(&surface, &AtomicBool::new(true)), None);
}

/// Seeds of the truth, and what is proposed: each within 1.5 radii of one of them.
#[test]
fn ends_of_models_are_those_of_their_truth() {
    for (name, seeds) in [
        ("a_tapered_tube.ply", "a_tapered_tube"),
        ("b_helix.ply", "b_helix"),
        ("c_y60.ply", "c_y60"),
        ("d_duct13.ply", "d_duct13"),
        ("e_artery40_50k.ply", "e_artery40"),
        ("e_artery40_10k.ply", "e_artery40"),
        ("lungnoodle_airway60_80k.ply", "lungnoodle_airway60"),
    ] {
        let Some(mesh) = truth::model(name) else {
            return;
        };
        let (skeleton, seeds) = (truth::skeleton(seeds), truth::seeds(seeds));
        let surface = surface(mesh);
        let begun = std::time::Instant::now();
        let found = propose(&surface, &AtomicBool::new(false)).unwrap();
        let took = begun.elapsed();
        let is_near = |end: DVec3, one: &Proposal| {
            let (_, radius) = skeleton.nearest(end);
            one.endpoint.point.distance(end) <= 1.5 * radius
        };
        let ends: Vec<DVec3> = std::iter::once(seeds.source).chain(seeds.targets).collect();
        let missed = ends
            .iter()
            .filter(|end| !found.iter().any(|one| is_near(**end, one)));
        let wrong: Vec<&Proposal> = found
            .iter()
            .filter(|one| !ends.iter().any(|end| is_near(*end, one)))
            .collect();
        let (missed, count) = (missed.count(), ends.len());
        let least = found
            .iter()
            .map(|one| one.slenderness)
            .fold(f64::INFINITY, f64::min);
        println!(
            "{name}: {} of {count} ends found, {missed} missed, {} wrong; least slender {least:.1}; {took:?}",
            count - missed,
            wrong.len()
        );
        for one in &wrong {
            println!("  wrong: {one:?}");
        }
        println!(
            "  source {:?}",
            found
                .first()
                .map(|one| (one.endpoint.point, is_near(ends[0], one)))
        );
        assert_eq!((missed, wrong.len(), found.len()), (0, 0, count), "{name}");
        assert!(
            is_near(ends[0], &found[0]),
            "{name}: the source is the thickest end"
        );
    }
}

#[test]
fn the_aorta_has_three_ends_open_and_closed() {
    for (name, reason) in [
        ("vmtk_aorta-surface-open-ends.stl", Reason::OpenEnd),
        ("vmtk_aorta-surface.vtp", Reason::Tip),
    ] {
        let Some(mesh) = truth::model_of("real", name) else {
            continue;
        };
        let found = proposals(mesh);
        println!("{name}: {found:#?}");
        assert_eq!(found.len(), 3, "{name}");
        assert!(found.iter().all(|one| one.reason == reason), "{name}");
    }
}

/// An arm of a ball: ends where it is longer than thick, and none where it is a bump.
#[test]
fn bumps_are_no_arms() {
    let sphere = made::sphere(5);
    for (length, ends) in [(0.1, 0), (6.0, 2)] {
        let mut mesh = sphere.clone();
        for position in &mut mesh.positions {
            // A column of radius 0.3 around z, pulled out of the ball.
            let across = position.truncate().length();
            if position.z > 0.0 && across < 0.3 {
                position.z += length * (1.0 - (across / 0.3).powi(8));
            }
        }
        let found = proposals(mesh);
        println!("{length}: {found:?}");
        assert_eq!(found.len(), ends, "{length}");
    }
}
