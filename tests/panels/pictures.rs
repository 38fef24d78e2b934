//! What panels look like: numbers first, then pictures that were looked at.

use glam::{Quat, Vec3};
use image::RgbaImage;
use ramus::app::picture::{Picture, side_by_side};
use ramus::app::portrait;
use ramus::world::panels::PanelId;
use ramus_xr::{Fov, Pose, View};

use super::visitor::{LEFT, RIGHT, Visitor};

/// Both eyes, looking from one place to another.
pub(super) fn views(from: Vec3, to: Vec3) -> [View; 2] {
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

pub(super) fn draw(visitor: &mut Visitor, picture: &mut Picture, views: &[View; 2]) -> RgbaImage {
    for (slot, painted) in visitor.workshop.take_painted() {
        picture.paint(slot, painted).unwrap();
    }
    picture
        .draw_whole(visitor.workshop.scene(), views, None)
        .unwrap();
    side_by_side(&picture.read(None).unwrap())
}

pub(super) fn save(image: &RgbaImage, name: &str) {
    if let Ok(folder) = std::env::var("RAMUS_SEEN") {
        image
            .save(std::path::Path::new(&folder).join(name))
            .unwrap();
    }
}

#[test]
fn the_tutorial_shows_the_controller_in_hand() {
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 720, 720).unwrap();
    let mut visitor = Visitor::with_tree();
    visitor.workshop.teach(5);
    visitor.frame();
    let center = visitor.center(PanelId::Lesson);
    let near = views(center + visitor.normal(PanelId::Lesson) * 0.55, center);
    let stand = views(Vec3::new(0.0, 1.6, 0.35), Vec3::new(0.0, 1.25, -1.0));
    save(
        &draw(&mut visitor, &mut picture, &stand),
        "lesson-stand.png",
    );
    let mut seen = Vec::new();
    for (name, path) in [
        ("touch", "oculus/touch_controller"),
        ("vive", "vive_controller"),
        ("hand", "hand_interaction_ext"),
        ("pen", "mx_ink_stylus_logitech"),
    ] {
        let profile = ramus_xr::profiles::PROFILES
            .iter()
            .find(|profile| profile.path.ends_with(path));
        visitor.workshop.hold([profile; 2]);
        // What only follows may take a frame more.
        visitor.frame();
        visitor.frame();
        let image = draw(&mut visitor, &mut picture, &near);
        save(&image, &format!("lesson-{name}.png"));
        assert!(
            seen.iter().all(|other| *other != image),
            "{name} looks like another"
        );
        seen.push(image);
    }
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
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
        ("Draw", "draw"),
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
    visitor.click(RIGHT, PanelId::Bench, "Rules");
    visitor.click(RIGHT, PanelId::Bench, "Change");
    visitor.click(RIGHT, PanelId::Bench, "A(x) > B -> A(x) A(x+1)");
    visitor.frame();
    visitor.click(LEFT, PanelId::Keyboard, "(");
    save(&draw(&mut visitor, &mut picture, &views), "bench-rules.png");
    let keys = visitor.center(PanelId::Keyboard);
    let over = visitor.normal(PanelId::Keyboard) * 0.5;
    let near = self::views(keys + over, keys);
    save(&draw(&mut visitor, &mut picture, &near), "keyboard.png");
    visitor.click(RIGHT, PanelId::Bench, "Cancel");
    visitor.click(RIGHT, PanelId::Bench, "Room");
    visitor.click(LEFT, PanelId::Bench, "Deutsch");
    visitor.click(LEFT, PanelId::Bench, "Form");
    save(&draw(&mut visitor, &mut picture, &views), "bench-de.png");
    // From where a person stands, with a hand on the lever.
    visitor.tip_to(RIGHT, Vec3::new(0.24, 0.9, -0.20));
    let stand = self::views(Vec3::new(0.0, 1.6, 0.35), Vec3::new(0.0, 1.0, -0.8));
    save(&draw(&mut visitor, &mut picture, &stand), "stage.png");
    // With the lever in hand, and the hand's own panel read by the left hand.
    let lever = Vec3::new(0.24, 0.86, -0.28) + Vec3::new(0.675, 0.0, -0.737) * 0.06;
    visitor.tip_to(RIGHT, lever);
    visitor.pull(RIGHT, true);
    let low = self::views(Vec3::new(0.0, 1.35, 0.25), Vec3::new(0.1, 0.85, -0.4));
    save(&draw(&mut visitor, &mut picture, &low), "lever.png");
    visitor.pull(RIGHT, false);
    let turn = Quat::from_rotation_arc(Vec3::NEG_X, Vec3::new(0.0, 0.9, 0.44).normalize());
    let held = &mut visitor.frame.hands[LEFT];
    (held.grip.position, held.grip.orientation) = (Vec3::new(-0.1, 1.15, -0.25), turn);
    visitor.frame();
    visitor.frame();
    save(&draw(&mut visitor, &mut picture, &stand), "wrist.png");
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}
