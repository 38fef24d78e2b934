//! What mouse and keyboard become, frame by frame.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that fails shows the line"
)]

use glam::Quat;
use proptest::prelude::*;

use super::*;

const SIZE: Vec2 = Vec2::new(1280.0, 800.0);
const FRAME: f64 = 0.008;
const SELECTED: Vec3 = Vec3::new(0.0, 0.92, -0.6);

fn facts() -> Facts {
    Facts {
        selected: Some(SELECTED),
        met: None,
        left_undoes: false,
    }
}

fn met(place: Vec3, takes_trigger: bool) -> Facts {
    Facts {
        met: Some(Met {
            place,
            takes_trigger,
            scrolls: false,
        }),
        ..facts()
    }
}

fn pointer() -> Pointer {
    Pointer::new(Camera::at_work(), SIZE)
}

fn tip(hand: &Hand) -> Vec3 {
    hand.aim.position + hand.aim.orientation * Vec3::NEG_Z * HandParams::default().tip
}

/// All frames until nothing waits, as (trigger, squeeze, stick x, lower, upper).
fn shown(pointer: &mut Pointer, facts: &Facts) -> Vec<(bool, bool, f32, bool, bool)> {
    let mut frames = Vec::new();
    while pointer.is_busy() {
        let hand = pointer.step(FRAME, SIZE, facts);
        assert!(hand.is_sane(), "{hand:?}");
        frames.push((
            hand.trigger > 0.5,
            hand.squeeze > 0.5,
            hand.stick.x,
            hand.lower,
            hand.upper,
        ));
    }
    frames
}

const REST: (bool, bool, f32, bool, bool) = (false, false, 0.0, false, false);
const PULLED: (bool, bool, f32, bool, bool) = (true, false, 0.0, false, false);

#[test]
fn every_click_is_seen_however_many_come_between_two_frames() {
    let mut pointer = pointer();
    for at in [100.0, 200.0, 300.0] {
        pointer.take(Act::Moved(Vec2::splat(at - 1.0)));
        pointer.take(Act::Moved(Vec2::splat(at)));
        pointer.take(Act::Button(Button::Trigger, true));
        pointer.take(Act::Button(Button::Trigger, false));
    }
    let frames = shown(&mut pointer, &facts());
    assert_eq!(frames, [REST, PULLED, REST].repeat(3));
    assert_eq!(pointer.cursor, Vec2::splat(300.0));
}

#[test]
fn a_button_has_the_cursor_of_the_frame_before() {
    let mut pointer = pointer();
    pointer.take(Act::Moved(Vec2::new(700.0, 300.0)));
    pointer.take(Act::Button(Button::Trigger, true));
    pointer.take(Act::Moved(Vec2::new(10.0, 10.0)));
    let before = pointer.step(FRAME, SIZE, &facts());
    let pressed = pointer.step(FRAME, SIZE, &facts());
    assert!(before.trigger < 0.5 && pressed.trigger > 0.5);
    assert_eq!(before.aim, pressed.aim);
    assert!(pointer.step(FRAME, SIZE, &facts()).aim != pressed.aim);
}

#[test]
fn taps_are_released_before_the_next() {
    let mut pointer = pointer();
    for tap in [Tap::Grow, Tap::Grow, Tap::Undo, Tap::Redo, Tap::Back] {
        pointer.take(Act::Tap(tap));
    }
    let frames = shown(&mut pointer, &facts());
    let tapped: Vec<_> = frames.iter().filter(|frame| **frame != REST).collect();
    assert_eq!(
        tapped,
        [
            &(false, false, 0.0, true, false),
            &(false, false, 0.0, true, false),
            &(false, false, -1.0, false, false),
            &(false, false, 1.0, false, false),
            &(false, false, 0.0, false, true),
        ]
    );
    assert!(
        frames
            .windows(2)
            .all(|pair| pair[0] == REST || pair[1] == REST)
    );
    assert_eq!(frames.last(), Some(&REST));
}

#[test]
fn the_pointer_means_what_the_eye_sees_there() {
    let mut pointer = pointer();
    let eye = pointer.camera.pose().position;
    let node = pointer.ray(SIZE).at(0.7);
    assert_eq!(
        pointer.step(FRAME, SIZE, &met(node, true)).aim.position,
        eye
    );
    // Through the rim the trigger draws as if it was not there.
    let through = pointer.step(FRAME, SIZE, &met(node, false));
    assert_eq!(through.aim, pointer.step(FRAME, SIZE, &facts()).aim);
    pointer.take(Act::Button(Button::Trigger, true));
    let draws = pointer.step(FRAME, SIZE, &met(node, false));
    assert!(draws.trigger > 0.5 && (tip(&draws).z - SELECTED.z).abs() < 1e-4);
}

#[test]
fn what_is_gripped_stays_under_the_cursor_and_does_not_jump() {
    let mut pointer = pointer();
    let cursor = SIZE * 0.5 + Vec2::new(30.0, 40.0);
    pointer.take(Act::Moved(cursor));
    pointer.step(FRAME, SIZE, &facts());
    // A little beside the ray, as the tolerance allows.
    let node = pointer.ray(SIZE).at(1.2) + Vec3::new(0.01, 0.005, 0.0);
    pointer.take(Act::Button(Button::Squeeze, true));
    let gripped = pointer.step(FRAME, SIZE, &met(node, true));
    assert_eq!(gripped.aim.position, pointer.camera.pose().position);
    let held = pointer.step(FRAME, SIZE, &facts());
    assert!(tip(&held).distance(node) < 1e-4, "it stays where it is");
    assert_eq!(held.grip, gripped.grip, "and so does the platform");
    pointer.take(Act::Moved(cursor + Vec2::new(100.0, 0.0)));
    let moved = pointer.step(FRAME, SIZE, &facts());
    let by = tip(&moved) - node;
    assert!(
        by.x > 0.05 && by.y.abs() < 1e-3 && by.z.abs() < 1e-3,
        "{by}"
    );
    assert!((moved.grip.position - held.grip.position).distance(by) < 1e-4);
    pointer.take(Act::Button(Button::Squeeze, false));
    let let_go = pointer.step(FRAME, SIZE, &facts());
    assert!(
        let_go.squeeze < 0.5 && let_go.aim == moved.aim,
        "where it was held last"
    );
    assert!(!pointer.is_holding());
}

#[test]
fn a_window_without_the_keyboard_lets_go() {
    let mut pointer = pointer();
    pointer.take(Act::Button(Button::Trigger, true));
    pointer.step(FRAME, SIZE, &facts());
    pointer.take(Act::Focus(false));
    assert_eq!(pointer.step(FRAME, SIZE, &facts()), Hand::ABSENT);
    // The click that brings the window back draws only after a frame with nothing pressed.
    pointer.take(Act::Focus(true));
    pointer.take(Act::Button(Button::Trigger, true));
    assert_eq!(shown(&mut pointer, &facts()), [REST, PULLED]);
}

#[test]
fn the_wheel_comes_nearer_or_scrolls() {
    let mut pointer = pointer();
    let far = pointer.camera;
    pointer.take(Act::Wheel(1.0));
    pointer.take(Act::Wheel(1.0));
    assert_eq!(pointer.step(FRAME, SIZE, &facts()).stick, Vec2::ZERO);
    assert!(pointer.camera != far && !pointer.is_busy());
    let near = pointer.camera;
    // A notch is three lines, however often the window draws.
    for seconds in [0.002, FRAME, 0.05, 3.0] {
        pointer.take(Act::Wheel(-1.0));
        pointer.take(Act::Button(Button::Trigger, true));
        pointer.take(Act::Button(Button::Trigger, false));
        let mut points = 0.0;
        while pointer.is_busy() {
            let hand = pointer.step(seconds, SIZE, &panel());
            assert!(
                hand.trigger == 0.0 || hand.stick == Vec2::ZERO,
                "one after the other"
            );
            points += f64::from(hand.stick.y * SCROLL_POINTS) * seconds.min(LONGEST);
        }
        assert!(
            (points + 54.0).abs() < 0.1,
            "{points} points in frames of {seconds} s"
        );
    }
    assert_eq!(pointer.camera, near);
    // What is left of it goes nowhere else.
    pointer.take(Act::Wheel(4.0));
    pointer.step(FRAME, SIZE, &panel());
    assert!(pointer.step(FRAME, SIZE, &panel()).stick.y > 0.5);
    assert_eq!(pointer.step(FRAME, SIZE, &facts()).stick, Vec2::ZERO);
    assert!(!pointer.is_busy());
}

fn panel() -> Facts {
    let mut facts = met(SELECTED, true);
    facts.met.as_mut().unwrap().scrolls = true;
    facts
}

#[test]
fn undo_is_the_stick_that_undoes() {
    for (tap, x) in [(Tap::Undo, -1.0), (Tap::Redo, 1.0)] {
        for left_undoes in [false, true] {
            let facts = Facts {
                left_undoes,
                ..facts()
            };
            let mut pointer = pointer();
            pointer.take(Act::Tap(tap));
            let right = pointer.step(FRAME, SIZE, &facts);
            let left = pointer.left(&facts);
            assert!(left.is_sane() && left.tracked == left_undoes);
            let expected = if left_undoes { [x, 0.0] } else { [0.0, x] };
            assert_eq!([left.stick.x, right.stick.x], expected);
            pointer.step(FRAME, SIZE, &facts);
            assert_eq!(pointer.left(&facts).stick, Vec2::ZERO);
            pointer.take(Act::Focus(false));
            pointer.step(FRAME, SIZE, &facts);
            assert_eq!(pointer.left(&facts), Hand::ABSENT);
        }
    }
}

#[test]
fn a_drag_moves_the_eye_alone() {
    let mut pointer = pointer();
    let before = pointer.camera;
    pointer.take(Act::Drag(Some(Drag::Orbit)));
    pointer.take(Act::Moved(SIZE * 0.5 + Vec2::X * 80.0));
    pointer.take(Act::Drag(None));
    let hand = pointer.step(FRAME, SIZE, &facts());
    assert!(pointer.camera != before && hand.trigger == 0.0 && hand.squeeze == 0.0);
    let turned = pointer.camera;
    pointer.take(Act::Moved(SIZE * 0.2));
    pointer.step(FRAME, SIZE, &facts());
    assert_eq!(pointer.camera, turned);
}

proptest! {
    /// The tip is where the cursor's ray meets the plane through the selected node.
    #[test]
    fn the_tip_lies_where_the_person_clicks(
        x in 0.0_f32..1280.0, y in 0.0_f32..800.0, yaw in 0.0_f32..6.2, pitch in -0.2_f32..1.5, distance in 0.4_f32..4.0,
        axis in 0..4_u8,
    ) {
        let camera = Camera::looking(SELECTED, yaw, pitch, distance);
        let mut pointer = Pointer::new(camera, SIZE);
        let across = [None, Some(Axis::X), Some(Axis::Y), Some(Axis::Z)][usize::from(axis)];
        pointer.take(Act::Moved(Vec2::new(x, y)));
        pointer.take(Act::Across(across));
        let hand = pointer.step(FRAME, SIZE, &facts());
        prop_assert!(hand.is_sane());
        let ray = camera.ray(Vec2::new(x, y), SIZE);
        let normal = match across {
            Some(Axis::X) => Vec3::X,
            Some(Axis::Y) => Vec3::Y,
            Some(Axis::Z) => Vec3::Z,
            None if pitch.sin() > STEEP => Vec3::Y,
            None => Quat::from_rotation_y(yaw) * Vec3::Z,
        };
        let along = (SELECTED - ray.origin).dot(normal) / ray.direction.dot(normal);
        // Nearly along the plane a hair's breadth of the cursor is a metre of the stage.
        if along > 0.1 && along < 5.0 && ray.direction.dot(normal).abs() > 0.1 {
            prop_assert!(tip(&hand).distance(ray.at(along)) < 1e-4, "{} {}", tip(&hand), ray.at(along));
        }
        let aside = (tip(&hand) - ray.origin).cross(ray.direction).length();
        prop_assert!(aside < 1e-3, "always on the cursor's ray");
    }
}

#[test]
fn the_brush_plants_under_the_cursor_and_the_right_button_uproots() {
    use crate::app::convert::input_from_frame;
    use crate::world::panels::PanelId;
    use crate::world::species::SPECIES;
    use crate::world::{DrawSettings, DrawTool, World, history::History};
    use ramus_xr::Frame;

    let mut world = World::new(History::new(SPECIES[0].document()));
    world.show_panel(PanelId::Bench, false);
    world.set_settings(DrawSettings {
        tool: DrawTool::Plant,
        ..world.settings()
    });
    let mut pointer = pointer();
    let mut frame = Frame::start();
    let mut go_on = |pointer: &mut Pointer, world: &mut World| {
        while pointer.is_busy() {
            let ray = pointer.ray(SIZE);
            let facts = Facts {
                met: world.met(ray.origin, ray.direction),
                ..facts()
            };
            frame.time += FRAME;
            frame.hands[1] = pointer.step(FRAME, SIZE, &facts);
            world.update(&input_from_frame(&frame));
        }
    };
    let click = |pointer: &mut Pointer, button| {
        pointer.take(Act::Button(button, true));
        pointer.take(Act::Button(button, false));
    };
    let mut wanted = Vec::new();
    for at in [Vec2::new(1150.0, 560.0), Vec2::new(200.0, 500.0)] {
        pointer.take(Act::Moved(at));
        go_on(&mut pointer, &mut world);
        let ray = pointer.ray(SIZE);
        let foot = ray.at(-ray.origin.y / ray.direction.y);
        wanted.push(Vec2::new(foot.x, foot.z));
        click(&mut pointer, Button::Trigger);
        go_on(&mut pointer, &mut world);
    }
    let planted = |world: &World| -> Vec<Vec2> {
        let plants = &world.document().grove.plants;
        plants.iter().map(|plant| plant.at).collect()
    };
    let stand = planted(&world);
    assert_eq!(stand.len(), 2);
    for (is, wanted) in stand.iter().zip(&wanted) {
        assert!(is.distance(*wanted) < 0.01, "{is} {wanted}");
    }
    // The cursor is at the foot of the last one still.
    click(&mut pointer, Button::Squeeze);
    go_on(&mut pointer, &mut world);
    assert_eq!(planted(&world), stand[..1]);
}
