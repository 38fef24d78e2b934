//! Centerlines in the session: found beside it, seen inside the model, listed, lit from the panel and from the model, written, stopped.

use glam::Vec3;
use image::RgbaImage;
use ramus::app::picture::Picture;
use ramus::app::portrait;
use ramus::world::lines::Lines;
use ramus::world::panels::PanelId;
use ramus::world::scene::SurfaceLook;

use super::models::{press, vessel, visitor};
use super::pictures::{draw, save, views};
use super::visitor::{LEFT, RIGHT, Visitor};

/// The only model's centerlines.
fn lines(visitor: &Visitor) -> &Lines {
    let model = &visitor.document().models[0];
    visitor.workshop.world().lines(model).unwrap().unwrap()
}

/// Pixels of the colour in which branches are lit, and their middle.
fn lit(picture: &RgbaImage) -> (usize, [f32; 2]) {
    let is = |[red, green, blue, _]: [u8; 4]| red > 150 && green < 90 && blue > 90;
    let found = picture
        .enumerate_pixels()
        .filter(|(_, _, pixel)| is(pixel.0));
    let (mut count, mut sum) = (0, [0.0; 2]);
    for (x, y, _) in found {
        count += 1;
        sum = [sum[0] + x as f32, sum[1] + y as f32];
    }
    (count, sum.map(|sum| sum / count.max(1) as f32))
}

#[test]
fn centerlines_are_found_seen_listed_and_lit() {
    let folder = tempfile::tempdir().unwrap();
    vessel(folder.path());
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 720, 720).unwrap();
    let mut visitor = visitor(folder.path());
    for text in ["Models", "vessel.obj", "Centerlines", "Find centerlines"] {
        press(&mut visitor, text);
    }
    assert_eq!(
        visitor.document().models[0].surface,
        Some(SurfaceLook::XRay)
    );
    let counts = lines(&visitor).analysis.counts;
    println!("{counts:?}");
    let place = visitor.document().models[0].place.position;
    let near = views(place + Vec3::new(0.0, 0.25, 0.75), place + Vec3::Y * 0.2);
    save(&draw(&mut visitor, &mut picture, &near), "lines-plain.png");
    press(&mut visitor, "radius at each place");
    press(&mut visitor, "largest balls within");
    save(&draw(&mut visitor, &mut picture, &near), "lines-radius.png");
    let middle = visitor.center(PanelId::Bench);
    let bench = views(middle + visitor.normal(PanelId::Bench) * 0.62, middle);
    save(&draw(&mut visitor, &mut picture, &bench), "bench-lines.png");
}
