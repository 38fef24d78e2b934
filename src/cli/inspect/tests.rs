//! The screen and the JSON object of made models.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use super::*;
use crate::mesh::made;

fn loaded(mesh: Mesh, unit: Option<Unit>) -> Loaded {
    Loaded {
        mesh,
        format: "PLY".to_owned(),
        unit,
        skipped_faces: 0,
    }
}

fn facts(mesh: Mesh, unit: Option<Unit>) -> Facts {
    let loaded = loaded(mesh, unit);
    let never = AtomicBool::new(false);
    Facts::new(&inspect(Path::new("duct.ply"), &loaded, &never).unwrap())
}

#[test]
fn the_screen_tells_problems_first_and_hints() {
    let tube = made::placed(made::tube(6, 4), 10.0, glam::Vec3::ZERO);
    let expected = "\
duct.ply: PLY, 36 triangles, 24 vertices

! 2 open ends (boundary loops)
    as it should be where a vessel or duct was cut; else fill the holes (Blender: Mesh › Clean Up › Fill Holes)

Size      20.00 × 17.32 × 30.00, from (-10.00 -8.6603 0) to (10.00 8.6603 30.00)
Unit      millimetres (guessed by size): 3.0 cm long, or 30 cm if in centimetres, or 30 m if in metres
Surface   open, area 1800
Shape     two sides in 1 part, 2 open ends, genus 0, Euler characteristic 0

Open ends
  1       about 19.10 wide, 6 edges, centre (0 0 0)
  2       about 19.10 wide, 6 edges, centre (0 0 30.00)
";
    let mut tube = facts(tube, None);
    // Sines are not exact zeros.
    for end in &mut tube.open_ends {
        end.centre = end.centre.map(|c| (c * 1e3).round().abs() / 1e3);
    }
    assert_eq!(text::screen(&tube), expected);
}

#[test]
fn many_parts_are_cut_and_one_is_not_told_again() {
    let cube = text::screen(&facts(made::cube(), Some(Unit::Metres)));
    assert!(cube.contains("Nothing is wrong with it."));
    assert!(cube.contains("metres (as the format has it): 1.0 m long\n"));
    assert!(cube.contains("watertight, area 6.0000, encloses 1.0000\n"));
    assert!(!cube.contains("Parts"));
    let ten = (1..10_u16).fold(made::cube(), |all, one| {
        let next = made::placed(made::cube(), 1.0, 3.0 * f32::from(one) * glam::Vec3::X);
        made::both(&all, &next)
    });
    let ten = text::screen(&facts(ten, None));
    assert!(ten.contains("\nParts\n  1       12 triangles, area 6.0000, closed\n"));
    assert!(ten.contains("\n  and 2 more\n"));
}

#[test]
fn the_screen_is_one_screen_whatever_is_wrong() {
    let bad = [
        made::moebius(9),
        made::book(),
        made::bow_tie(),
        made::soup(&made::tube(9, 3)),
    ];
    let mut mesh = bad
        .iter()
        .fold(made::turned(made::sphere(1), |t| t < 70), |all, one| {
            made::both(&all, one)
        });
    mesh.positions.push(glam::Vec3::NAN);
    mesh.triangles.extend([[0, 0, 1], [0, 1, u32::MAX]]);
    let screen = text::screen(&facts(mesh, None));
    assert!(screen.lines().count() <= 50, "{screen}");
}

#[test]
fn json_has_its_names_and_no_holes() {
    let json = serde_json::to_value(facts(
        made::both(
            &made::cube(),
            &made::placed(made::tube(5, 2), 1.0, glam::Vec3::splat(0.3)),
        ),
        None,
    ))
    .unwrap();
    let mut names: Vec<&str> = json
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    names.sort_unstable();
    assert_eq!(
        names.join(" "),
        "area component_count components euler_characteristic file format manifold max min open_end_count open_ends orientable \
         problems scale size skipped_faces triangles vertices volume watertight"
    );
    assert_eq!(json["components"][0]["triangles"], 12);
    assert_eq!(json["components"][0]["genus"], 0);
    assert_eq!(json["open_ends"].as_array().unwrap().len(), 2);
    assert_eq!(json["scale"]["unit"], "metres");
    assert_eq!(json["scale"]["confidence"], "guessed");
    let faults: Vec<_> = json["problems"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["fault"].clone())
        .collect();
    assert_eq!(faults, ["self_intersections", "open_ends"]);
    let nothing = facts(Mesh::default(), None);
    assert!(nothing.scale.is_none() && !nothing.watertight);
    assert!(text::screen(&nothing).contains("no size"));
}

#[test]
fn what_cannot_be_read_is_an_error_and_what_can_is_printed() {
    let args = |json| Args {
        model: PathBuf::from("duct.ply"),
        json,
        repair: None,
        out: None,
    };
    let refused = run(&args(false), |_, _| Err(anyhow!("no such file")));
    assert_eq!(refused.unwrap_err().to_string(), "no such file");
    for json in [false, true] {
        assert!(run(&args(json), |_, _| Ok(loaded(made::cube(), None))).is_ok());
    }
}
