//! What panels look like: numbers first, then pictures that were looked at.

use glam::{Quat, Vec2, Vec3};
use image::RgbaImage;
use ramus::app::picture::{Picture, side_by_side};
use ramus::app::portrait;
use ramus::world::panels::PanelId;
use ramus_xr::{Fov, Pose, View};

use super::visitor::{LEFT, RIGHT, Visitor};

/// Both eyes, looking from one place to another.
fn views(from: Vec3, to: Vec3) -> [View; 2] {
    let ahead = (to - from).normalize();
    let right = ahead.cross(Vec3::Y).normalize();
    let turn = Quat::from_mat3(&glam::Mat3::from_cols(right, right.cross(ahead), -ahead));
    [-0.032, 0.032].map(|x| View {
        pose: Pose {
            orientation: turn,
            position: from + right * x,
        },
        fov: Fov {
            left: -0.5,
            right: 0.5,
            up: 0.5,
            down: -0.5,
        },
    })
}

fn draw(visitor: &mut Visitor, picture: &mut Picture, views: &[View; 2]) -> RgbaImage {
    for (slot, painted) in visitor.workshop.take_painted() {
        picture.paint(slot, painted).unwrap();
    }
    picture.draw_whole(visitor.workshop.scene(), views, None).unwrap();
    side_by_side(&picture.read(None).unwrap())
}

fn save(image: &RgbaImage, name: &str) {
    if let Ok(folder) = std::env::var("RAMUS_SEEN") {
        image.save(std::path::Path::new(&folder).join(name)).unwrap();
    }
}

#[test]
fn each_tab_of_the_bench_is_readable_in_both_languages() {
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 720, 720).unwrap();
    let mut visitor = Visitor::with_tree();
    visitor.click_nth(RIGHT, PanelId::Bench, "Grow", 2);
    let center = visitor.center(PanelId::Bench);
    let normal = visitor.normal(PanelId::Bench);
    let views = views(center + normal * 0.62, center);
    for (tab, name) in [
        ("Grow", "grow"),
        ("Shape", "shape"),
        ("Letters", "letters"),
        ("File", "file"),
        ("Room", "room"),
    ] {
        visitor.click(RIGHT, PanelId::Bench, tab);
        let image = draw(&mut visitor, &mut picture, &views);
        save(&image, &format!("bench-{name}.png"));
        // Paper in the middle of the sheet, ink somewhere.
        let bright = image.pixels().filter(|pixel| pixel.0[1] > 150).count();
        assert!(bright > 400, "{tab}: {bright} bright pixels");
    }
    visitor.click(LEFT, PanelId::Bench, "Deutsch");
    visitor.click(LEFT, PanelId::Bench, "Form");
    save(&draw(&mut visitor, &mut picture, &views), "bench-de.png");
    // From where a person stands, with a hand on the lever.
    visitor.tip_to(RIGHT, Vec3::new(0.24, 0.9, -0.20));
    let stand = self::views(Vec3::new(0.0, 1.6, 0.35), Vec3::new(0.0, 1.0, -0.8));
    save(&draw(&mut visitor, &mut picture, &stand), "stage.png");
    visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.3, 0.3));
    visitor.frame();
    save(&draw(&mut visitor, &mut picture, &stand), "pointing.png");
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}
