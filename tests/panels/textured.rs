//! Models that their files colour: on the bench, mended, and in the guide's picture.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use image::RgbImage;
use image::imageops::{FilterType, resize};
use ramus::app::model_portrait::{ModelPortrait, of_model};
use ramus::app::portrait::PAPER;
use ramus::mesh::display::Display;
use ramus::mesh::mend::{list_from_text, mend_all};
use ramus::mesh::textured::{LayerLimits, Textured, moved};
use ramus::mesh::unit::Unit;
use ramus::mesh::{ReadLimits, read};
use ramus::world::scene::{ModelLook, SurfaceLook};

use super::guide::{compare, strip};
use super::models::{press, visitor};

const BRANCH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/models/branch.glb");

#[test]
fn a_model_comes_as_its_file_colours_it_and_stays_so_when_it_is_mended() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(BRANCH, folder.path().join("branch.glb")).unwrap();
    super::models::vessel(folder.path());
    let mut visitor = visitor(folder.path());
    press(&mut visitor, "Models");
    press(&mut visitor, "branch.glb");
    let surface = |visitor: &super::visitor::Visitor| visitor.document().models[0].surface;
    let materials = |visitor: &mut super::visitor::Visitor| {
        let scene = visitor.workshop.scene();
        let textured = scene.models[0].display.textured.clone();
        textured.map(|textured| (textured.materials.len(), textured.layers.count))
    };
    assert_eq!(surface(&visitor), Some(SurfaceLook::Textured));
    assert_eq!(materials(&mut visitor), Some((2, 2)));
    press(&mut visitor, "shaded");
    assert_eq!(surface(&visitor), Some(SurfaceLook::Shaded));
    assert_eq!(materials(&mut visitor), None);
    press(&mut visitor, "textured");
    // Colours that say something are shown instead, and hide nothing for good.
    press(&mut visitor, "parts");
    assert_eq!(materials(&mut visitor), None);
    press(&mut visitor, "nothing");
    assert_eq!(materials(&mut visitor), Some((2, 2)));
    let before = visitor.workshop.scene().models[0]
        .display
        .mesh
        .triangles
        .len();
    press(&mut visitor, "Mend");
    press(&mut visitor, "half the triangles");
    let after = visitor.workshop.scene().models[0]
        .display
        .mesh
        .triangles
        .len();
    assert!(after < before, "{after} of {before} triangles");
    assert_eq!(materials(&mut visitor), Some((2, 2)));
    press(&mut visitor, "As in the file");
    let again = visitor.workshop.scene().models[0]
        .display
        .mesh
        .triangles
        .len();
    assert_eq!((again, materials(&mut visitor)), (before, Some((2, 2))));
}

#[test]
fn what_has_no_colours_is_not_offered_textured() {
    let folder = tempfile::tempdir().unwrap();
    super::models::vessel(folder.path());
    let mut visitor = visitor(folder.path());
    press(&mut visitor, "Models");
    press(&mut visitor, "vessel.obj");
    assert_eq!(
        visitor.document().models[0].surface,
        Some(SurfaceLook::Shaded)
    );
    let mut texts = visitor.workshop.texts(ramus::world::panels::PanelId::Bench);
    assert!(!texts.any(|text| text == "textured"));
}

#[test]
fn the_guide_shows_a_model_as_its_file_colours_it() {
    let never = AtomicBool::new(false);
    let model = read(Path::new(BRANCH), &ReadLimits::default(), &never).unwrap();
    let paint = model.paint.unwrap();
    let still = |mends: &str, change: &dyn Fn(&mut ModelLook)| -> RgbImage {
        let mends = list_from_text(mends).unwrap_or_default();
        let before = model.mesh.clone();
        let (mesh, paint) = if mends.is_empty() {
            (before, paint.clone())
        } else {
            let mended = mend_all(before.clone(), &mends, &never, &mut |_, _, _| ()).unwrap();
            moved(&paint, before, &mended.0, &never).unwrap()
        };
        let (textured, told) = Textured::new(paint, &LayerLimits::default(), &never).unwrap();
        assert!(told.is_empty(), "{told:?}");
        let textured = textured.unwrap();
        let display = Display::new(Arc::new(mesh), Some(&textured), &never).unwrap();
        let mut look = ModelLook {
            surface: Some(SurfaceLook::Textured),
            ..ModelLook::default()
        };
        change(&mut look);
        let how = ModelPortrait {
            look,
            boxed: false,
            unit: Unit::Metres,
            centerline: None,
            endpoints: Vec::new(),
            z_up: false,
            turn: 0.5,
            backdrop: PAPER,
            pixels: 640,
        };
        let large = of_model(display.textured(Arc::new(textured)), &how).unwrap();
        let small = resize(&large, 320, 320, FilterType::Triangle);
        image::DynamicImage::ImageRgba8(small).to_rgb8()
    };
    let stills = [
        still("", &|_| ()),
        still("", &|look| look.wireframe = true),
        still("decimate=40%", &|_| ()),
        still("", &|look| look.surface = Some(SurfaceLook::Shaded)),
    ];
    // Leaves are green, bark is brown; each leaf is cut out of a square, of which half is not there.
    let count = |still: &RgbImage, is: fn([i32; 3]) -> bool| {
        let pixels = still.pixels().map(|pixel| pixel.0.map(i32::from));
        pixels.filter(|pixel| is(*pixel)).count()
    };
    let green = |[red, green, blue]: [i32; 3]| green > red + 25 && green > blue + 25;
    let brown = |[red, green, blue]: [i32; 3]| red > green + 8 && green > blue && red < 160;
    let dark = |[red, _, blue]: [i32; 3]| red.min(blue) < 190;
    let found = stills
        .each_ref()
        .map(|still| [green, brown, dark].map(|is: fn([i32; 3]) -> bool| count(still, is)));
    let [whole, edges, mended, shaded] = found;
    assert!(whole[0] > 1_000 && whole[1] > 2_000, "{found:?}");
    assert!(edges[2] > whole[2] * 9 / 10, "{found:?}");
    assert!(
        mended[0] > whole[0] * 3 / 4 && mended[1] > whole[1] * 3 / 4,
        "{found:?}"
    );
    assert!(shaded[0] < whole[0] / 20, "{found:?}");
    assert!(
        shaded[2] > whole[2],
        "squares are larger than leaves: {found:?}"
    );
    compare("models/textured", &strip(&stills));
}
