//! Scanned models from the bench: brought, looked at in every way, taken away; and the guide's pictures of it.

use std::f32::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Vec3, Vec4};
use image::RgbImage;
use image::imageops::{FilterType, resize};
use ramus::app::model_portrait::{ModelPortrait, of_model};
use ramus::app::picture::Picture;
use ramus::app::portrait::{self, PAPER};
use ramus::app::store::Store;
use ramus::app::studies::coloured;
use ramus::app::workshop::{Workshop, WorkshopParams};
use ramus::mesh::display::Display;
use ramus::mesh::endpoints::propose;
use ramus::mesh::pick::Picker;
use ramus::mesh::surface::Surface;
use ramus::mesh::unit::Unit;
use ramus::mesh::{ReadLimits, read};
use ramus::world::model::Colouring;
use ramus::world::panels::PanelId;
use ramus::world::scene::{ModelLook, SurfaceLook};

use super::guide::{compare, strip};
use super::pictures::save;
use super::visitor::{LEFT, RIGHT, Visitor};

/// Points round a tube and along it.
pub(super) const ROUND: usize = 28;
pub(super) const ALONG: usize = 36;

/// An open tube along a path, as the lines of an OBJ file, with vertices numbered from `first`.
pub(super) fn tube(
    text: &mut String,
    first: usize,
    path: impl Fn(f32) -> Vec3,
    radius: impl Fn(f32) -> f32,
) {
    for row in 0..=ALONG {
        let t = row as f32 / ALONG as f32;
        let along = (path(t + 0.01) - path(t - 0.01)).normalize();
        let side = along.cross(Vec3::Z).normalize();
        let third = along.cross(side);
        for column in 0..ROUND {
            let turn = TAU * column as f32 / ROUND as f32;
            let at = path(t) + (side * turn.cos() + third * turn.sin()) * radius(t);
            writeln!(text, "v {} {} {}", at.x, at.y, at.z).unwrap();
        }
    }
    for row in 0..ALONG {
        for column in 0..ROUND {
            let at = |row: usize, column: usize| first + row * ROUND + column % ROUND;
            let [a, b, c, d] = [
                at(row, column),
                at(row, column + 1),
                at(row + 1, column),
                at(row + 1, column + 1),
            ];
            writeln!(text, "f {a} {b} {c}\nf {b} {d} {c}").unwrap();
        }
    }
}

/// A vessel of 100 mm with a branch pushed into it: two parts, four open ends, and a seam where they cross.
pub(super) fn vessel(folder: &Path) -> std::path::PathBuf {
    let mut text = String::new();
    let trunk = |t: f32| Vec3::new(12.0 * (t * 3.0).sin(), 100.0 * t, 8.0 * (t * 4.0).cos());
    tube(&mut text, 1, trunk, |t| {
        11.0 - 4.0 * t + 0.8 * (t * 30.0).sin()
    });
    let from = trunk(0.42);
    let branch = move |t: f32| from + Vec3::new(48.0 * t, 30.0 * t * t + 20.0 * t, 6.0 * t);
    tube(&mut text, 1 + ROUND * (ALONG + 1), branch, |t| {
        6.5 - 2.5 * t
    });
    let path = folder.join("vessel.obj");
    std::fs::write(&path, text).unwrap();
    path
}

/// Somebody whose project lies beside the vessel.
pub(super) fn visitor(folder: &Path) -> Visitor {
    let opened = Store::open(&folder.join("a.ramus")).unwrap();
    let mut workshop = Workshop::new(opened, WorkshopParams::default()).unwrap();
    workshop.offer_models();
    Visitor::at(workshop)
}

/// Presses a button that the tab may have to be scrolled for.
pub(super) fn press(visitor: &mut Visitor, text: &str) {
    visitor.scroll_to(RIGHT, PanelId::Bench, text);
    visitor.click(RIGHT, PanelId::Bench, text);
    visitor.workshop.finish_models();
    visitor.frame();
}

#[test]
fn a_model_is_brought_from_the_bench_shown_otherwise_and_taken_away() {
    let folder = tempfile::tempdir().unwrap();
    vessel(folder.path());
    let mut visitor = visitor(folder.path());
    press(&mut visitor, "Models");
    press(&mut visitor, "vessel.obj");
    let model = visitor.document().models[0].clone();
    assert_eq!(model.file, "vessel.obj");
    assert_eq!(visitor.workshop.scene().models.len(), 1);
    let texts: Vec<String> = visitor
        .workshop
        .texts(PanelId::Bench)
        .map(str::to_owned)
        .collect();
    for told in ["4032 triangles, 2072 vertices", "mm"] {
        assert!(
            texts.iter().any(|text| text.contains(told)),
            "{told}: {texts:?}"
        );
    }
    press(&mut visitor, "x-ray");
    assert_eq!(
        visitor.document().models[0].surface,
        Some(SurfaceLook::XRay)
    );
    press(&mut visitor, "edges");
    press(&mut visitor, "box");
    press(&mut visitor, "parts");
    let model = &visitor.document().models[0];
    assert!(model.wireframe && model.boxed && model.colouring == Colouring::Parts);
    press(&mut visitor, "Real size");
    let side = visitor.document().models[0].place.scale;
    assert!((0.1..0.14).contains(&side), "{side} m");
    press(&mut visitor, "Back to its place");
    assert_eq!(visitor.document().models[0].place.scale, 0.4);
    // Each press is an edit, and all can be undone.
    let edits = visitor.workshop.edits();
    assert_eq!(edits, 7);
}

#[test]
fn endpoints_are_proposed_listed_named_written_and_read_on_the_bench() {
    let folder = tempfile::tempdir().unwrap();
    vessel(folder.path());
    let mut visitor = visitor(folder.path());
    for text in ["Models", "vessel.obj", "Places", "Propose ends"] {
        press(&mut visitor, text);
    }
    let ends = |visitor: &Visitor| visitor.document().models[0].endpoints.to_vec();
    let model = visitor.document().models[0].clone();
    let proposed = visitor.workshop.world().proposals(&model).len();
    assert!(proposed >= 3 && ends(&visitor).is_empty(), "{proposed}");
    press(&mut visitor, "refuse");
    press(&mut visitor, "take");
    assert_eq!(ends(&visitor).len(), 1);
    press(&mut visitor, "take all");
    let taken = ends(&visitor);
    assert_eq!(taken.len(), proposed - 1);
    assert_eq!(visitor.workshop.world().proposals(&model), []);
    // The list: the first is turned, then taken away.
    let first = |visitor: &Visitor| ends(visitor)[0].clone();
    let name = first(&visitor).name;
    press(&mut visitor, &name);
    press(&mut visitor, "Cancel");
    press(&mut visitor, "×");
    let listed = ends(&visitor);
    assert_eq!(listed.len(), proposed - 2);
    assert!(listed.iter().all(|end| end.name != name));
    // Out of a file and into one.
    press(&mut visitor, "CSV");
    press(&mut visitor, "JSON");
    press(&mut visitor, "Take all endpoints away");
    assert!(ends(&visitor).is_empty());
    for file in ["vessel-ends-1.csv", "vessel-ends-1.json"] {
        press(&mut visitor, file);
        assert_eq!(ends(&visitor), listed, "{file}");
        press(&mut visitor, "Take all endpoints away");
    }
    std::fs::write(folder.path().join("vessel-ends-1.csv"), "x,y\n1,2\n").unwrap();
    press(&mut visitor, "vessel-ends-1.csv");
    assert!(ends(&visitor).is_empty() && visitor.workshop.world().has_message());
}

#[test]
fn a_model_is_coloured_by_numbers_and_the_bench_says_what_they_are() {
    let folder = tempfile::tempdir().unwrap();
    vessel(folder.path());
    let mut visitor = visitor(folder.path());
    press(&mut visitor, "Models");
    press(&mut visitor, "vessel.obj");
    let plain = visitor.workshop.scene().models[0].revision;
    for (text, by) in [
        ("radius", Colouring::Radius),
        ("thickness", Colouring::Thickness),
        ("curvature", Colouring::Curvature),
    ] {
        press(&mut visitor, text);
        let model = visitor.document().models[0].clone();
        assert_eq!(model.colouring, by);
        let painting = visitor.workshop.world().painting(&model).unwrap();
        let [low, high] = painting.range.unwrap();
        // The vessel's radii are 4 to 12 mm; where its parts cross, balls are small.
        let expected = match by {
            Colouring::Radius => 0.0..12.0,
            Colouring::Thickness => 4.0..40.0,
            _ => -1.0..1.0,
        };
        assert!(
            expected.contains(&low) && expected.contains(&high) && low < high,
            "{text} {low} {high}"
        );
        assert_ne!(
            visitor.workshop.scene().models[0].revision,
            plain,
            "drawn in colours"
        );
    }
    press(&mut visitor, "nothing");
    assert_eq!(visitor.workshop.scene().models[0].revision, plain);
}

#[test]
fn the_guide_shows_endpoints_and_colours_by_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = vessel(folder.path());
    let never = AtomicBool::new(false);
    let mesh = read(&path, &ReadLimits::default(), &never).unwrap().mesh;
    let picker = Picker::new(Arc::new(mesh), &never, &mut |_, _| ()).unwrap();
    let surface = Surface::new(picker, &never).unwrap();
    let proposals = propose(&surface, &never).unwrap();
    let endpoints: Vec<_> = proposals.into_iter().map(|one| one.endpoint).collect();
    let display = Display::new(Arc::clone(surface.mesh()), None, &never).unwrap();
    let still = |by: Option<Colouring>| {
        let colours = by.map(|by| coloured(&surface, by, &never).unwrap());
        let how = ModelPortrait {
            look: ModelLook {
                surface: Some(match by {
                    Some(_) => SurfaceLook::Matte,
                    None => SurfaceLook::XRay,
                }),
                ..ModelLook::default()
            },
            boxed: false,
            unit: Unit::Millimetres,
            centerline: None,
            endpoints: if by.is_none() {
                endpoints.clone()
            } else {
                Vec::new()
            },
            z_up: false,
            turn: 0.5,
            backdrop: PAPER,
            pixels: 640,
        };
        let display = match colours {
            Some((colours, _)) => display.painted(colours),
            None => display.clone(),
        };
        let large = of_model(display, &how).unwrap();
        let small = resize(&large, 320, 320, FilterType::Triangle);
        image::DynamicImage::ImageRgba8(small).to_rgb8()
    };
    let stills = [
        still(None),
        still(Some(Colouring::Radius)),
        still(Some(Colouring::Thickness)),
        still(Some(Colouring::Curvature)),
    ];
    // One source, red, and targets, blue; yellow is thick and dark blue is thin; bulges are red.
    let count = |still: &RgbImage, is: fn([i32; 3]) -> bool| {
        let pixels = still.pixels().map(|pixel| pixel.0.map(i32::from));
        pixels.filter(|pixel| is(*pixel)).count()
    };
    let red = |[red, green, blue]: [i32; 3]| red > green + 60 && red > blue + 60;
    let blue = |[red, green, blue]: [i32; 3]| blue > red + 40 && blue > green + 20;
    let yellow = |[red, green, blue]: [i32; 3]| red > blue + 60 && green > blue + 60;
    let [ends, radius, thickness, curvature] = &stills;
    let marks = [count(ends, red), count(ends, blue)];
    assert!(
        marks.iter().all(|&pixels| (8..2_000).contains(&pixels)),
        "{marks:?}"
    );
    assert!(
        marks[1] > marks[0],
        "three targets and one source: {marks:?}"
    );
    for still in [radius, thickness] {
        let found = [count(still, yellow), count(still, blue)];
        assert!(found.iter().all(|&pixels| pixels > 300), "{found:?}");
    }
    assert!(count(curvature, red) > 300, "tubes bulge");
    compare("models/places", &strip(&stills));
}

#[test]
fn the_guide_shows_the_tab_and_a_model_in_five_ways() {
    let folder = tempfile::tempdir().unwrap();
    let path = vessel(folder.path());
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 720, 720).unwrap();
    let mut visitor = visitor(folder.path());
    press(&mut visitor, "Models");
    press(&mut visitor, "vessel.obj");
    press(&mut visitor, "box");
    let middle = visitor.center(PanelId::Bench);
    let near = super::pictures::views(middle + visitor.normal(PanelId::Bench) * 0.62, middle);
    save(
        &super::pictures::draw(&mut visitor, &mut picture, &near),
        "bench-models.png",
    );
    visitor.tip_to(LEFT, Vec3::new(0.3, 1.0, -0.5));
    let stand = super::pictures::views(Vec3::new(0.0, 1.6, 0.35), Vec3::new(0.1, 1.05, -0.9));
    let stage = super::pictures::draw(&mut visitor, &mut picture, &stand);
    save(&stage, "stage-models.png");

    let mesh = read(&path, &ReadLimits::default(), &AtomicBool::new(false))
        .unwrap()
        .mesh;
    let display = Display::new(Arc::new(mesh), None, &AtomicBool::new(false)).unwrap();
    let still = |boxed: bool, change: &dyn Fn(&mut ModelLook)| -> RgbImage {
        let mut look = ModelLook::default();
        change(&mut look);
        let how = ModelPortrait {
            look,
            boxed,
            unit: Unit::Millimetres,
            centerline: None,
            endpoints: Vec::new(),
            z_up: false,
            turn: 0.5,
            backdrop: PAPER,
            pixels: 640,
        };
        let large = of_model(display.clone(), &how).unwrap();
        let small = resize(&large, 320, 320, FilterType::Triangle);
        image::DynamicImage::ImageRgba8(small).to_rgb8()
    };
    let stills = [
        still(true, &|_| ()),
        still(false, &|look| {
            (look.wireframe, look.surface) = (true, Some(SurfaceLook::Matte));
        }),
        still(false, &|look| look.surface = Some(SurfaceLook::XRay)),
        still(false, &|look| {
            look.cut = Some(Vec4::new(0.0, 0.0, 1.0, 0.02))
        }),
        still(false, &|look| {
            (look.surface, look.wireframe, look.vertices) = (None, true, true);
        }),
    ];
    // Numbers first: what is darker than paper, of the whole.
    let ink = stills.each_ref().map(|still| {
        let dark = still.pixels().filter(|pixel| pixel.0[0] < 205).count();
        dark as f32 / still.pixels().len() as f32
    });
    let [boxed, edged, x_ray, cut, alone] = ink;
    assert!(
        boxed > 0.08 && (0.08..0.5).contains(&edged) && cut < edged,
        "{ink:?}"
    );
    assert!(
        x_ray > 0.02 && x_ray < edged && alone > 0.02 && alone < edged,
        "{ink:?}"
    );
    compare("models/looks", &strip(&stills));
}
