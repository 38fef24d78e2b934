//! What helps a person in the room, as it is seen: the dark edge, the figure to measure by, where a teleport goes.
//!
//! Numbers first: each picture is set beside the same one without what is looked at. Then the guide's pictures.

use glam::{Mat3, Quat, Vec2, Vec3};
use image::RgbImage;
use ramus::app::picture::Picture;
use ramus::app::portrait::{self, looking_at};
use ramus::world::panels::PanelId;
use ramus::world::room::RoomSettings;
use ramus::world::scene::weather::{Light, Wind};
use ramus_xr::{Pose, View};

use super::guide::{compare, far, strip};
use super::visitor::{LEFT, RIGHT, Visitor};

const SIDE: u16 = 300;
/// Field of view, radians.
const FIELD: f32 = 1.4;
/// How tall the figure is, and where its feet are, metres.
const TALL: f32 = 1.75;
const FEET: Vec3 = Vec3::new(1.1, 0.0, -5.6);

/// Somebody with these settings of the room, turning about by the left stick if they like.
fn somebody(room: RoomSettings) -> Visitor {
    let mut visitor = Visitor::with_tree();
    let settings = ramus::ui::Settings {
        room,
        ..visitor.workshop.settings()
    };
    visitor.workshop.set(settings);
    visitor.frame();
    visitor
}

fn push(visitor: &mut Visitor, x: f32, y: f32) {
    visitor.frame.hands[LEFT].stick = Vec2::new(x, y);
    visitor.frame();
}

/// What the head sees that looks at a place from where it is in its room.
fn seen(visitor: &Visitor, at: Vec3, field: f32) -> View {
    let view = looking_at(visitor.frame.head.position, at, field);
    visitor.workshop.on_stage([view; 2])[0]
}

fn draw(visitor: &mut Visitor, picture: &mut Picture, view: View) -> RgbImage {
    for (slot, painted) in visitor.workshop.take_painted() {
        picture.paint(slot, painted).unwrap();
    }
    let scene = visitor.workshop.scene();
    picture.draw_whole(scene, &[view; 2], None).unwrap();
    let [left, _] = picture.read(None).unwrap();
    image::DynamicImage::ImageRgba8(left).to_rgb8()
}

/// Where a place of the stage is in the picture, pixels from its left upper corner.
fn pixel(view: &View, place: Vec3) -> Vec2 {
    let to_eye = Mat3::from_quat(view.pose.orientation).transpose();
    let at = to_eye * (place - view.pose.position);
    let scale = f32::from(SIDE) * 0.5 / (-at.z * view.fov.right.tan());
    Vec2::new(at.x, -at.y) * scale + Vec2::splat(f32::from(SIDE) * 0.5)
}

/// How bright a picture is on average, where the angle from its middle lies in a range, 0 to 255.
fn brightness(picture: &RgbImage, [from, to]: [f32; 2]) -> f32 {
    let half = f32::from(SIDE) * 0.5;
    let (mut sum, mut count) = (0.0, 0.0);
    for (x, y, pixel) in picture.enumerate_pixels() {
        let place = |n: u32| (f32::from(u16::try_from(n).unwrap()) + 0.5 - half) / half;
        let tangent = Vec2::new(place(x), place(y)).length() * (FIELD * 0.5).tan();
        if (from..to).contains(&tangent.atan()) {
            sum += f32::from(pixel.0[1]);
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn the_edge_is_dark_for_a_moment_after_a_jump_and_the_middle_never() {
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, SIDE.into(), SIDE.into()).unwrap();
    let mut people = [true, false].map(|vignette| {
        somebody(RoomSettings {
            turning: true,
            vignette,
            ..RoomSettings::default()
        })
    });
    let ahead = people[0].frame.head.position + Vec3::new(0.0, -0.4, -1.0);
    for visitor in &mut people {
        // The edge lies about the line of sight of the head.
        let head = looking_at(visitor.frame.head.position, ahead, FIELD);
        visitor.frame.head.orientation = head.pose.orientation;
        visitor.frame();
    }
    let mut both = |people: &mut [Visitor; 2]| {
        people.each_mut().map(|visitor| {
            let view = seen(visitor, ahead, FIELD);
            draw(visitor, &mut picture, view)
        })
    };
    let [still, plain] = both(&mut people);
    assert_eq!(far(&still, &plain), 0, "nobody moves: no edge");
    for visitor in &mut people {
        push(visitor, 1.0, 0.0);
    }
    let [dark, plain] = both(&mut people);
    let (middle, rim) = ([0.0, 0.35], [0.55, 0.8]);
    assert!((brightness(&dark, middle) - brightness(&plain, middle)).abs() < 0.5);
    let [edge, without] = [&dark, &plain].map(|picture| brightness(picture, rim));
    assert!(edge < 1.0 && without > 60.0, "{edge} against {without}");
    for visitor in &mut people {
        push(visitor, 0.0, 0.0);
        visitor.wait(0.5);
    }
    let [later, plain] = both(&mut people);
    assert_eq!(far(&later, &plain), 0, "it is over");
    compare("room/dark-edge", &strip(&[still, dark, later]));
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}

#[test]
fn the_figure_is_as_tall_as_a_person_where_it_stands() {
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, SIDE.into(), SIDE.into()).unwrap();
    let [with, without] = [true, false].map(|figure| {
        let mut visitor = somebody(RoomSettings {
            figure,
            ..RoomSettings::default()
        });
        for _ in 0..5 {
            visitor.frame.hands[LEFT].lower = true;
            visitor.frame();
            visitor.frame.hands[LEFT].lower = false;
            visitor.wait(1.5);
        }
        let view = seen(&visitor, Vec3::new(0.4, 1.3, -5.8), 0.75);
        (draw(&mut visitor, &mut picture, view), view)
    });
    let (view, plain) = (with.1, without.0);
    let [feet, top] = [0.0, TALL].map(|height| pixel(&view, FEET + Vec3::Y * height));
    // Above the ground, where its shadow lies, nothing else than the figure is new.
    let (mut low, mut high, mut count) = (Vec2::MAX, Vec2::MIN, 0_u16);
    for (x, y, new) in with.0.enumerate_pixels() {
        let old = plain.get_pixel(x, y);
        if (0..3).any(|n| new.0[n].abs_diff(old.0[n]) > 32) {
            let at = [x, y].map(|n| f32::from(u16::try_from(n).unwrap()));
            (low, high) = (low.min(at.into()), high.max(at.into()));
            count += 1;
        }
    }
    assert!(
        (low.y - top.y).abs() < 2.5,
        "head at {} of {}",
        low.y,
        top.y
    );
    assert!(
        (high.y - feet.y).abs() < 4.0,
        "feet at {} of {}",
        high.y,
        feet.y
    );
    let tall = feet.y - top.y;
    assert!((low.x..high.x).contains(&feet.x), "it stands there");
    let part = f32::from(count) / (tall * tall);
    assert!((0.08..0.35).contains(&part), "{part} of its height squared");
    compare("room/figure", &strip(&[plain, with.0]));
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}

#[test]
fn a_teleport_goes_where_the_ball_is_seen_to_fall() {
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, SIDE.into(), SIDE.into()).unwrap();
    let mut visitor = somebody(RoomSettings {
        turning: true,
        ..RoomSettings::default()
    });
    let hand = &mut visitor.frame.hands[LEFT];
    hand.aim = Pose {
        position: Vec3::new(-0.25, 1.25, -0.35),
        orientation: Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::new(-0.22, 0.1, -1.0).normalize()),
    };
    hand.grip = hand.aim;
    visitor.frame();
    let look = Vec3::new(-0.9, 0.9, -3.0);
    let view = seen(&visitor, look, 0.9);
    let before = draw(&mut visitor, &mut picture, view);
    push(&mut visitor, 0.0, 1.0);
    let aimed = draw(&mut visitor, &mut picture, view);
    let scene = visitor.workshop.scene();
    let ball = scene.balls.iter().find(|ball| ball.radius == 0.12);
    let target = ball.unwrap().center;
    assert_eq!(target.y, 0.0, "on the ground");
    let middle = pixel(&view, target);
    let near = |picture: &RgbImage| {
        let all = picture.enumerate_pixels();
        let in_ball = all.filter(|(x, y, _)| {
            let at = [*x, *y].map(|n| f32::from(u16::try_from(n).unwrap()));
            (Vec2::from(at) + 0.5 - middle).length() < 5.0
        });
        in_ball
            .map(|(_, _, pixel)| u32::from(pixel.0[1]))
            .sum::<u32>()
    };
    assert!(
        near(&aimed) > near(&before) * 11 / 10,
        "the ball is seen at {middle}"
    );
    assert!(far(&aimed, &before) > 150, "and its flight");
    push(&mut visitor, 0.0, 0.0);
    let there = visitor.workshop.on_stage([view; 2])[0].pose.position;
    let moved = there - view.pose.position;
    let feet = visitor.frame.head.position.with_y(0.0) + moved;
    assert!(feet.distance(target) < 1e-3, "{feet} is not {target}");
    let landed = seen(&visitor, look, 0.9);
    let landed = draw(&mut visitor, &mut picture, landed);
    compare("room/teleport", &strip(&[aimed, landed]));
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}

#[test]
fn light_and_wind_are_set_on_the_bench() {
    let mut visitor = Visitor::with_tree();
    visitor.click(RIGHT, PanelId::Bench, "Room");
    let set = |visitor: &Visitor| {
        let settings = visitor.workshop.settings();
        (settings.light, settings.wind)
    };
    assert_eq!(
        set(&visitor),
        (Light::Day, Wind::Still),
        "off until it is asked for"
    );
    for (text, light, wind) in [
        ("evening", Light::Evening, Wind::Still),
        ("breeze", Light::Evening, Wind::Breeze),
        ("studio", Light::Studio, Wind::Breeze),
        ("strong", Light::Studio, Wind::Strong),
        ("day", Light::Day, Wind::Strong),
        ("still", Light::Day, Wind::Still),
    ] {
        visitor.scroll_to(RIGHT, PanelId::Bench, text);
        visitor.click(RIGHT, PanelId::Bench, text);
        assert_eq!(set(&visitor), (light, wind), "{text}");
    }
}
