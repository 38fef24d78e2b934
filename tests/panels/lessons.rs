//! The tutorial, done from the first lesson to the last by hands.

use glam::{Quat, Vec3};
use ramus::world::{lesson::Lesson, panels::PanelId};

use super::visitor::{LEFT, RIGHT, Visitor};

const ROOT: Vec3 = Vec3::new(0.0, 0.9, -0.55);

fn lesson(visitor: &Visitor) -> Option<Lesson> {
    visitor.workshop.world().lesson().map(|(_, lesson)| lesson)
}

pub(crate) fn draw(visitor: &mut Visitor, tip: Vec3) {
    visitor.tip_to(RIGHT, ROOT + tip);
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
}

pub(crate) fn rest(visitor: &mut Visitor) {
    for hand in [LEFT, RIGHT] {
        visitor.rest(hand);
    }
    visitor.frame();
}

/// Does what a lesson teaches.
pub(crate) fn does(visitor: &mut Visitor, lesson: Lesson) {
    let step = |visitor: &mut Visitor, press: fn(&mut Visitor, bool)| {
        press(visitor, true);
        visitor.frame();
        press(visitor, false);
        visitor.frame();
    };
    match lesson {
        Lesson::Draw => draw(visitor, Vec3::Y * 0.08),
        Lesson::DrawOn => draw(visitor, Vec3::Y * 0.16),
        Lesson::FreeHand => {
            visitor.tip_to(RIGHT, ROOT + Vec3::Y * 0.2);
            visitor.frame.hands[RIGHT].trigger = 1.0;
            for n in 0..=12_u8 {
                let along = f32::from(n) / 12.0;
                let tip = Vec3::new(0.05 * along * along, 0.2 + 0.15 * along, 0.0);
                visitor.tip_to(RIGHT, ROOT + tip);
            }
            visitor.pull(RIGHT, false);
        }
        Lesson::Branch => {
            draw(visitor, Vec3::Y * 0.08);
            draw(visitor, Vec3::new(0.08, 0.12, 0.0));
        }
        Lesson::Grow => step(visitor, |v, on| v.frame.hands[RIGHT].lower = on),
        Lesson::Back => step(visitor, |v, on| v.frame.hands[LEFT].upper = on),
        Lesson::Undo => step(visitor, |v, on| {
            v.frame.hands[LEFT].stick.x = if on { -1.0 } else { 0.0 }
        }),
        Lesson::Redo => step(visitor, |v, on| {
            v.frame.hands[LEFT].stick.x = if on { 1.0 } else { 0.0 }
        }),
        Lesson::Move => {
            visitor.tip_to(RIGHT, ROOT + Vec3::Y * 0.16);
            visitor.grip(RIGHT, true);
            visitor.tip_to(RIGHT, ROOT + Vec3::new(0.03, 0.18, 0.0));
            visitor.wait(0.3);
            visitor.grip(RIGHT, false);
        }
        Lesson::Delete => {
            visitor.tip_to(RIGHT, ROOT + Vec3::new(0.03, 0.18, 0.0));
            visitor.grip(RIGHT, true);
            visitor.pull(RIGHT, true);
            visitor.pull(RIGHT, false);
            visitor.grip(RIGHT, false);
        }
        Lesson::Platform => {
            visitor.tip_to(LEFT, ROOT + Vec3::new(-0.255, 0.0, 0.0));
            visitor.grip(LEFT, true);
            visitor.tip_to(LEFT, ROOT + Vec3::new(-0.255, 0.05, 0.0));
            visitor.tip_to(LEFT, ROOT + Vec3::new(-0.255, 0.0, 0.0));
            visitor.tip_to(LEFT, ROOT + Vec3::new(-0.254, 0.0, 0.0));
            visitor.grip(LEFT, false);
        }
        Lesson::Lever => turn(visitor, Vec3::new(0.24, 0.84, -0.28), 137.508),
        Lesson::Wheel => turn(visitor, Vec3::new(-0.24, 0.84, -0.28), 0.0),
        Lesson::Panel => {
            let tab = visitor.find(PanelId::Bench, "Shape");
            visitor.point_on(RIGHT, PanelId::Bench, tab);
            visitor.pull(RIGHT, true);
            visitor.pull(RIGHT, false);
        }
        Lesson::Wrist => {
            let turn = Quat::from_rotation_arc(Vec3::NEG_X, Vec3::new(0.0, 0.9, 0.44).normalize());
            let held = &mut visitor.frame.hands[LEFT];
            (held.grip.position, held.grip.orientation) = (Vec3::new(-0.1, 1.15, -0.2), turn);
            visitor.frame();
            visitor.frame();
        }
        Lesson::Stump => {
            visitor.tip_to(RIGHT, Vec3::new(0.0, 0.865, -0.19));
            for pulled in [true, false, true, false] {
                visitor.pull(RIGHT, pulled);
            }
        }
    }
}

fn turn(visitor: &mut Visitor, center: Vec3, from: f32) {
    let at = |degrees: f32| {
        let angle = degrees.to_radians();
        center + Vec3::new(angle.sin(), 0.25, angle.cos()) * 0.06
    };
    visitor.tip_to(RIGHT, at(from));
    visitor.grip(RIGHT, true);
    for n in 1..=6_u8 {
        visitor.tip_to(RIGHT, at(from + 12.0 * f32::from(n)));
    }
    visitor.grip(RIGHT, false);
}

#[test]
fn every_lesson_is_learnt_by_doing_it() {
    let mut visitor = Visitor::new();
    visitor.workshop.teach(0);
    visitor.frame();
    for (number, taught) in Lesson::ALL.into_iter().enumerate() {
        assert_eq!(lesson(&visitor), Some(taught));
        assert!(visitor.says(PanelId::Lesson, &format!("{} / 16", number + 1)));
        does(&mut visitor, taught);
        rest(&mut visitor);
        let now = visitor.workshop.world().lesson().map(|(at, _)| at);
        let next = number + 1;
        assert_eq!(
            now,
            (next < Lesson::ALL.len()).then_some(next),
            "after {taught:?}"
        );
    }
    assert!(
        !visitor.workshop.world().has_panel(PanelId::Lesson),
        "it is over"
    );
}

#[test]
fn a_lesson_whose_need_is_gone_teaches_that_first() {
    let mut visitor = Visitor::new();
    let at = |wanted| {
        Lesson::ALL
            .iter()
            .position(|lesson| *lesson == wanted)
            .unwrap()
    };
    for (number, shown) in [
        (at(Lesson::Branch), Lesson::Draw),
        (at(Lesson::Back), Lesson::Draw),
        (at(Lesson::Redo), Lesson::Draw),
        (at(Lesson::Stump), Lesson::Draw),
        (at(Lesson::Platform), Lesson::Platform),
    ] {
        visitor.workshop.teach(number);
        assert_eq!(lesson(&visitor), Some(shown));
    }
    visitor.workshop.teach(at(Lesson::Redo));
    does(&mut visitor, Lesson::Draw);
    rest(&mut visitor);
    assert_eq!(
        lesson(&visitor),
        Some(Lesson::Undo),
        "there is something to undo now"
    );
    does(&mut visitor, Lesson::Undo);
    assert_eq!(lesson(&visitor), Some(Lesson::Redo));
    does(&mut visitor, Lesson::Redo);
    assert_eq!(lesson(&visitor), Some(Lesson::Platform));
}

#[test]
fn it_is_skipped_gone_back_in_ended_and_resumed() {
    let mut visitor = Visitor::new();
    visitor.workshop.teach(0);
    visitor.frame();
    for _ in 0..3 {
        visitor.click(RIGHT, PanelId::Lesson, "Next");
    }
    assert_eq!(
        lesson(&visitor),
        Some(Lesson::Draw),
        "nothing is drawn that could grow"
    );
    assert_eq!(visitor.workshop.settings().lesson, 3);
    visitor.click(LEFT, PanelId::Lesson, "Back");
    assert_eq!(visitor.workshop.settings().lesson, 2);
    visitor.click(LEFT, PanelId::Lesson, "End the tutorial");
    assert_eq!(lesson(&visitor), None);
    visitor.click(RIGHT, PanelId::Bench, "Room");
    visitor.click(RIGHT, PanelId::Bench, "Tutorial");
    assert_eq!(visitor.workshop.world().lesson().map(|(at, _)| at), Some(2));
    assert_eq!(
        visitor.document().sketch.strokes[0].points.len(),
        0,
        "nothing was drawn meanwhile"
    );
}
