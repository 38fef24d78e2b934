//! What each family of controllers looks like in the tutorial, part by part: for the guide's page on controls.

use glam::Vec3;
use image::{Rgb, RgbImage};
use ramus::app::picture::Picture;
use ramus::app::portrait::{self, looking_at};
use ramus::world::{lesson::Lesson, panels::PanelId};
use ramus_xr::bindings::Action;
use ramus_xr::profiles::PROFILES;

use super::guide::{compare, strip};
use super::pictures::save;
use super::visitor::{RIGHT, Visitor};

/// Width and height of a drawing.
const PIXELS: [u16; 2] = [176, 206];
/// Side of a pixel, and where the drawing's middle is from the lesson's, metres.
const PIXEL: f32 = 0.001;
const MIDDLE: [f32; 2] = [0.148, 0.058];

/// A picture's name, and a profile that has it.
const FAMILIES: [(&str, &str); 9] = [
    ("touch", "oculus/touch_controller"),
    ("index", "valve/index_controller"),
    ("generic", "khr/generic_controller"),
    ("motion", "microsoft/motion_controller"),
    ("vive", "htc/vive_controller"),
    ("magic-leap", "ml/ml2_controller"),
    ("pen", "logitech/mx_ink_stylus_logitech"),
    ("hand", "ext/hand_interaction_ext"),
    ("simple", "khr/simple_controller"),
];

/// One lesson for each part: draw, grip, grow, step back, undo.
const LESSONS: [Lesson; 5] = [
    Lesson::Draw,
    Lesson::Move,
    Lesson::Grow,
    Lesson::Back,
    Lesson::Undo,
];

/// What does it.
const ACTIONS: [Action; 5] = [
    Action::Draw,
    Action::Grab,
    Action::Lower,
    Action::Upper,
    Action::Stick,
];

/// Orange, as nothing else is there.
fn is_lit(pixel: &Rgb<u8>) -> bool {
    let [red, green, blue] = pixel.0;
    red > 200 && (120..200).contains(&green) && blue < 60
}

/// The lesson's picture of the controller.
fn drawing(visitor: &mut Visitor, picture: &mut Picture, lesson: Lesson) -> RgbImage {
    let at = Lesson::ALL.iter().position(|other| *other == lesson);
    visitor.workshop.teach(at.unwrap());
    visitor.frame();
    visitor.frame();
    let shown = visitor.workshop.world().lesson().unwrap();
    assert_eq!(shown.1, lesson);
    let normal = visitor.normal(PanelId::Lesson);
    let right = Vec3::Y.cross(normal).normalize();
    let [aside, above] = MIDDLE;
    let middle = visitor.center(PanelId::Lesson) + right * aside + normal.cross(right) * above;
    let mut view = looking_at(middle + normal, middle, 0.0);
    let half = PIXELS.map(|pixels| (f32::from(pixels) * 0.5 * PIXEL).atan());
    (view.fov.left, view.fov.right) = (-half[0], half[0]);
    (view.fov.down, view.fov.up) = (-half[1], half[1]);
    for (slot, painted) in visitor.workshop.take_painted() {
        picture.paint(slot, painted).unwrap();
    }
    picture
        .draw_whole(visitor.workshop.scene(), &[view; 2], None)
        .unwrap();
    let [left, _] = picture.read(None).unwrap();
    image::DynamicImage::ImageRgba8(left).to_rgb8()
}

#[test]
fn each_family_of_controllers_is_drawn_with_the_part_in_question_lit() {
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, PIXELS[0].into(), PIXELS[1].into()).unwrap();
    let mut visitor = Visitor::with_tree();
    visitor.click_nth(RIGHT, PanelId::Bench, "Grow", 2);
    for (name, path) in FAMILIES {
        let profile = PROFILES.iter().find(|profile| profile.path.ends_with(path));
        visitor.workshop.hold([profile; 2]);
        let cards = LESSONS.map(|lesson| drawing(&mut visitor, &mut picture, lesson));
        for ((card, lesson), action) in cards.iter().zip(LESSONS).zip(ACTIONS) {
            let has = profile.is_some_and(|profile| profile.part(action).is_some());
            let lit = card.pixels().filter(|pixel| is_lit(pixel)).count();
            assert_eq!(lit > 40, has, "{name}, {lesson:?}: {lit} pixels are lit");
            assert!(has || lit == 0, "{name}, {lesson:?}: {lit} pixels are lit");
        }
        compare(&format!("controllers/{name}"), &strip(&cards));
    }
    in_german(&mut visitor, &mut picture);
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}

/// The same with German names, which are longer: to be looked at, and within the picture.
fn in_german(visitor: &mut Visitor, picture: &mut Picture) {
    visitor.click(RIGHT, PanelId::Bench, "Room");
    visitor.click(RIGHT, PanelId::Bench, "Deutsch");
    for (name, path) in FAMILIES {
        let profile = PROFILES.iter().find(|profile| profile.path.ends_with(path));
        visitor.workshop.hold([profile; 2]);
        let cards = LESSONS.map(|lesson| drawing(visitor, picture, lesson));
        let strip = image::DynamicImage::ImageRgb8(strip(&cards)).to_rgba8();
        save(&strip, &format!("controller-{name}-de.png"));
        for (card, lesson) in cards.iter().zip(LESSONS) {
            assert!(
                keeps_from_the_edges(card),
                "{name}, {lesson:?}: the name is cut"
            );
        }
    }
}

/// Whether nothing of the name below the controller is at the left or right edge.
fn keeps_from_the_edges(card: &RgbImage) -> bool {
    let (width, height) = card.dimensions();
    let bright = |x, y| card.get_pixel(x, y).0[1] > 120;
    (height - 44..height).all(|y| !bright(0, y) && !bright(width - 1, y))
}
