//! The screen and the JSON object of made models.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use std::sync::Arc;

use super::*;
use crate::mesh::made;
use crate::mesh::paint::{Image, ImageKind, Material, WHITE};
use crate::mesh::unit::Unit;

fn loaded(mesh: Mesh, unit: Option<Unit>) -> Loaded {
    Loaded {
        mesh,
        format: "PLY".to_owned(),
        scale: unit.map(Scale::stated),
        beside: Beside::default(),
        paint: None,
        skeleton: None,
        remarks: Vec::new(),
        z_up: true,
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
    as it should be where a vessel or duct was cut; else fill the holes (mend: `close`)

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
    assert!(
        cube.contains("metres (as the format has it): 1.0 m long, or 1.0 mm if in millimetres")
    );
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
fn what_stands_beside_the_surface_is_told() {
    let mut loaded = loaded(made::cube(), None);
    loaded.scale = Some(Scale::customary(Unit::Micrometres));
    loaded.beside = Beside {
        skipped_faces: 1,
        skipped_lines: 2000,
        skipped_points: 3,
        surplus_bytes: 4,
        skeleton_nodes: Some(5),
    };
    let never = AtomicBool::new(false);
    let facts = Facts::new(&inspect(Path::new("a.swc"), &loaded, &never).unwrap());
    let screen = text::screen(&facts);
    let told = "\
Skeleton  5 nodes, around which the surface was made
Left out  1 faces of the file have fewer than three corners
Left out  2,000 lines of the file are no surface
Left out  3 points of the file are no surface
Left out  4 bytes of the file stand behind its last triangle
";
    assert!(screen.contains(told), "{screen}");
    assert!(
        screen.contains(
            "micrometres (by the format's custom): 1.0 µm long, or 1.0 nm if in nanometres"
        ),
        "{screen}"
    );
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
        "area component_count components euler_characteristic file format has_colours has_texture_coordinates image_count images manifold \
         material_count materials max min open_end_count open_ends orientable problems remarks scale size skeleton_nodes skipped_faces \
         skipped_lines skipped_points surplus_bytes triangles vertices volume watertight"
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
fn what_colours_the_surface_is_told_and_what_is_not_shown() {
    let image = Image {
        name: "moss".into(),
        kind: ImageKind::Png,
        size_px: [16, 8],
        encoded: Arc::default(),
    };
    let paint = Paint {
        colours: vec![WHITE; 8],
        materials: vec![Material::default(); 2],
        images: vec![image],
        ..Paint::default()
    };
    let loaded = Loaded {
        paint: Some(paint),
        remarks: vec!["image bark is damaged".into()],
        ..loaded(made::cube(), None)
    };
    let never = AtomicBool::new(false);
    let facts = Facts::new(&inspect(Path::new("tree.glb"), &loaded, &never).unwrap());
    let screen = text::screen(&facts);
    for told in [
        "\nRemark    image bark is damaged\n",
        "\nPaint     2 materials, 1 image (PNG 16 × 8), colours at the vertices\n",
    ] {
        assert!(screen.contains(told), "{screen}");
    }
    let json = serde_json::to_value(&facts).unwrap();
    assert_eq!(json["images"][0]["width_px"], 16);
    assert_eq!(json["material_count"], 2);
    assert_eq!(json["has_texture_coordinates"], false);
}

#[test]
fn what_cannot_be_read_is_an_error_and_what_can_is_printed() {
    let args = |json| Args {
        model: PathBuf::from("duct.ply"),
        json,
        repair: None,
        out: None,
        png: None,
        propose: None,
        endpoints: None,
        look: Vec::new(),
        up: None,
        size: 64,
    };
    let refused = run(&args(false), |_, _| Err(anyhow!("no such file")));
    assert_eq!(refused.unwrap_err().to_string(), "no such file");
    for json in [false, true] {
        assert!(run(&args(json), |_, _| Ok(loaded(made::cube(), None))).is_ok());
    }
}
