//! Panels in the headset, through the workshop: hands point, press, drag, poke and carry.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that fails shows the line"
)]

mod panels {
    mod abstraction;
    mod accidents;
    mod compare;
    mod controllers;
    mod guide;
    mod lessons;
    mod lines;
    mod models;
    pub(crate) mod pictures;
    mod planting;
    mod recorded;
    mod room;
    mod species;
    mod study;
    mod textured;
    mod tools;
    pub(crate) mod visitor;
    mod with_models;
}

use glam::{Quat, Vec2, Vec3};
use panels::visitor::{LEFT, RIGHT, Visitor};
use ramus::world::panels::PanelId;

const HANDS: [usize; 2] = [LEFT, RIGHT];

#[test]
fn a_button_is_pressed_by_either_hand() {
    for hand in HANDS {
        let mut visitor = Visitor::with_tree();
        visitor.click(hand, PanelId::Bench, "Grow");
        // The first such text is the tab, which is there already.
        assert_eq!(visitor.document().step, 0, "a tab grows nothing");
        visitor.click_nth(hand, PanelId::Bench, "Grow", 2);
        assert_eq!(visitor.document().step, 1);
        visitor.click(hand, PanelId::Bench, "Back");
        assert_eq!(visitor.document().step, 0);
        visitor.click(hand, PanelId::Bench, "Undo (6)");
        assert_eq!(visitor.document().step, 1);
    }
}

#[test]
fn what_is_pressed_on_a_panel_draws_nothing() {
    let mut visitor = Visitor::new();
    let at = visitor.on(PanelId::Bench, Vec2::new(0.3, 0.5));
    visitor.point(RIGHT, at);
    for _ in 0..3 {
        visitor.pull(RIGHT, true);
        visitor.pull(RIGHT, false);
    }
    assert!(visitor.document().sketch.is_empty());
    assert_eq!(visitor.workshop.edits(), 0);
    // Dragged off the panel and let go beside it: nothing either.
    visitor.pull(RIGHT, true);
    visitor.point(RIGHT, Vec3::new(0.0, 1.0, -0.5));
    visitor.frame();
    visitor.pull(RIGHT, false);
    assert!(visitor.document().sketch.is_empty());
    // There the next pull draws.
    visitor.tip_to(RIGHT, Vec3::new(0.0, 1.1, -0.55));
    visitor.pull(RIGHT, true);
    assert!(!visitor.document().sketch.is_empty());
}

#[test]
fn a_slider_shows_at_once_and_is_one_edit() {
    let mut visitor = Visitor::with_tree();
    visitor.click(RIGHT, PanelId::Bench, "Shape");
    let before = visitor.workshop.edits();
    let row = visitor.find(PanelId::Bench, "divergence angle") + Vec2::new(0.0, 0.04);
    let from = Vec2::new(0.06, row.y);
    visitor.point_on(RIGHT, PanelId::Bench, from);
    visitor.pull(RIGHT, true);
    let mut seen = Vec::new();
    for n in 1..=10_u8 {
        let to = from + Vec2::X * 0.015 * f32::from(n);
        visitor.point_on(RIGHT, PanelId::Bench, to);
        // In this frame or the next.
        visitor.frame();
        visitor.frame();
        seen.push(visitor.workshop.world().shown().sketch.divergence_deg);
        assert_eq!(visitor.workshop.edits(), before, "nothing is written yet");
    }
    assert!(seen.windows(2).all(|pair| pair[1] > pair[0]), "{seen:?}");
    visitor.pull(RIGHT, false);
    visitor.frame();
    assert_eq!(visitor.workshop.edits(), before + 1);
    let divergence = visitor.document().sketch.divergence_deg;
    assert!((divergence - seen[9]).abs() < 1e-9);
    assert!(visitor.workshop.world().history().undo_count() > 0);
}

#[test]
fn a_press_that_loses_its_hand_ends_and_keeps_what_was_seen() {
    for lost in [true, false] {
        let mut visitor = Visitor::with_tree();
        visitor.click(RIGHT, PanelId::Bench, "Shape");
        let row = visitor.find(PanelId::Bench, "divergence angle") + Vec2::new(0.0, 0.04);
        visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.06, row.y));
        visitor.pull(RIGHT, true);
        visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.14, row.y));
        visitor.frame();
        visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.16, row.y));
        visitor.frame();
        let shown = visitor.workshop.world().shown().sketch.divergence_deg;
        if lost {
            visitor.frame.hands[RIGHT].tracked = false;
        } else {
            visitor.frame.focused = false;
        }
        visitor.frame();
        visitor.frame();
        assert_eq!(visitor.document().sketch.divergence_deg, shown);
        // The trigger, still pulled when the hand is back, presses nothing.
        visitor.frame.hands[RIGHT].tracked = true;
        visitor.frame.focused = true;
        visitor.frame();
        let pointer = visitor.workshop.world().pointer(PanelId::Bench);
        assert!(!pointer.is_some_and(|pointer| pointer.pressed));
    }
}

#[test]
fn an_untracked_hand_points_at_nothing() {
    let mut visitor = Visitor::new();
    visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.2, 0.2));
    visitor.frame();
    assert!(visitor.workshop.world().pointer(PanelId::Bench).is_some());
    visitor.frame.hands[RIGHT].tracked = false;
    visitor.frame();
    assert_eq!(visitor.workshop.world().pointer(PanelId::Bench), None);
}

#[test]
fn one_hand_at_a_time_has_a_panel() {
    let mut visitor = Visitor::new();
    let owner = |visitor: &Visitor| {
        visitor
            .workshop
            .world()
            .pointer(PanelId::Bench)
            .unwrap()
            .hand
    };
    visitor.point_on(LEFT, PanelId::Bench, Vec2::new(0.1, 0.5));
    visitor.frame();
    assert_eq!(owner(&visitor), LEFT);
    visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.3, 0.5));
    visitor.frame();
    assert_eq!(owner(&visitor), RIGHT, "the hand that came last");
    visitor.pull(LEFT, true);
    assert_eq!(owner(&visitor), LEFT, "the hand that presses");
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    visitor.frame.hands[LEFT].tracked = false;
    visitor.frame();
    assert_eq!(owner(&visitor), RIGHT, "the hand that is left");
}

#[test]
fn a_tip_that_comes_through_the_face_presses() {
    let mut visitor = Visitor::with_tree();
    let back = visitor.find(PanelId::Bench, "Back");
    visitor.click_nth(RIGHT, PanelId::Bench, "Grow", 2);
    assert_eq!(visitor.document().step, 1);
    let normal = visitor.normal(PanelId::Bench);
    let at = visitor.on(PanelId::Bench, back);
    for millimetres in [60.0_f32, 40.0, 20.0, 8.0, 2.0, -5.0, -12.0, 4.0, 30.0, 60.0] {
        let tip = at + normal * (millimetres / 1000.0);
        visitor.tip_to_along(LEFT, tip, -normal);
        visitor.frame();
    }
    assert_eq!(visitor.document().step, 0, "poked once");
    assert!(visitor.felt.iter().any(|pulse| pulse.hand == LEFT));
}

#[test]
fn a_panel_is_carried_and_faces_the_head() {
    let mut visitor = Visitor::new();
    visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.3, 0.3));
    visitor.frame.hands[RIGHT].squeeze = 1.0;
    visitor.frame();
    let before = visitor.center(PanelId::Bench);
    let to = Vec3::new(0.1, 0.2, 0.05);
    visitor.frame.hands[RIGHT].grip.position += to;
    visitor.frame.hands[RIGHT].aim.position += to;
    visitor.frame();
    visitor.frame.hands[RIGHT].squeeze = 0.0;
    visitor.frame();
    let after = visitor.center(PanelId::Bench);
    assert!((after - before - to).length() < 1e-4, "{before} {after}");
    let head = visitor.frame.head.position;
    let cosine = visitor
        .normal(PanelId::Bench)
        .dot((head - after).normalize());
    assert!(cosine > 0.999, "{cosine}");
    assert_eq!(visitor.workshop.edits(), 0, "no edit of the document");
}

#[test]
fn the_stick_scrolls_on_a_panel_and_undoes_elsewhere() {
    let mut visitor = Visitor::with_tree();
    let edits = visitor.workshop.edits();
    visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.3, 0.3));
    visitor.frame();
    visitor.frame.hands[RIGHT].stick = Vec2::new(-1.0, 0.0);
    visitor.frame();
    assert_eq!(visitor.workshop.edits(), edits);
    visitor.frame.hands[RIGHT].stick = Vec2::ZERO;
    visitor.point(RIGHT, Vec3::new(0.0, 3.0, -3.0));
    visitor.frame();
    visitor.frame.hands[RIGHT].stick = Vec2::new(-1.0, 0.0);
    visitor.frame();
    assert_eq!(visitor.workshop.edits(), edits + 1, "an undo");
}

#[test]
fn the_back_of_a_hand_shows_its_panel_to_the_head_and_to_the_other_hand() {
    for hand in HANDS {
        let other = 1 - hand;
        let mut visitor = Visitor::with_tree();
        assert!(!visitor.workshop.world().has_panel(PanelId::Wrist));
        // The back of the hand up, the head above it.
        let outwards = if hand == LEFT { Vec3::NEG_X } else { Vec3::X };
        let turn = Quat::from_rotation_arc(outwards, Vec3::new(0.0, 0.9, 0.44).normalize());
        let held = &mut visitor.frame.hands[hand];
        (held.grip.position, held.grip.orientation) = (Vec3::new(0.0, 1.2, -0.35), turn);
        visitor.frame();
        assert!(visitor.workshop.world().has_panel(PanelId::Wrist));
        visitor.frame();
        visitor.click(other, PanelId::Wrist, "Hide");
        assert!(!visitor.workshop.world().has_panel(PanelId::Bench));
        visitor.click(other, PanelId::Wrist, "Bench");
        assert!(visitor.workshop.world().has_panel(PanelId::Bench));
    }
}

#[test]
fn a_session_on_panels_played_again_gives_the_same_document() {
    let mut visitor = Visitor::with_tree();
    visitor.click_nth(RIGHT, PanelId::Bench, "Grow", 2);
    visitor.click(LEFT, PanelId::Bench, "Shape");
    visitor.click(LEFT, PanelId::Bench, "alternate");
    assert_eq!(visitor.document().sketch.divergence_deg, 180.0);
    let mut again = Visitor::blank();
    again.workshop.unseen();
    for frame in &visitor.frames {
        again.workshop.update(frame);
        again.workshop.finish_tree();
    }
    assert_eq!(again.document(), visitor.document());
}

#[test]
fn a_rule_is_rewritten_on_the_keyboard_and_its_fault_stands_in_place() {
    let mut visitor = Visitor::with_tree();
    visitor.click(RIGHT, PanelId::Bench, "Rules");
    let first = "A(x) > B -> A(x) A(x+1)";
    visitor.find(PanelId::Bench, first);
    visitor.click(RIGHT, PanelId::Bench, "Change");
    // The box of the rule takes the focus, and the keyboard comes.
    assert!(!visitor.workshop.world().has_panel(PanelId::Keyboard));
    visitor.click(RIGHT, PanelId::Bench, first);
    assert!(visitor.workshop.world().has_panel(PanelId::Keyboard));
    visitor.frame();
    visitor.click(LEFT, PanelId::Keyboard, "(");
    assert!(
        visitor.says(PanelId::Bench, "the sketch:"),
        "its fault stands there"
    );
    visitor.click(RIGHT, PanelId::Bench, "Apply");
    assert!(
        visitor.document().sketch.own_rules.is_empty(),
        "not while it is wrong"
    );
    visitor.click(RIGHT, PanelId::Bench, "A(x) > B ->( A(x) A(x+1)");
    visitor.click(LEFT, PanelId::Keyboard, "Delete");
    assert!(!visitor.says(PanelId::Bench, "the sketch:"));
}

#[test]
fn a_lost_headset_keeps_the_tab_and_the_rule_that_is_being_written() {
    let mut visitor = Visitor::with_tree();
    visitor.click(RIGHT, PanelId::Bench, "Rules");
    visitor.click(RIGHT, PanelId::Bench, "Change");
    visitor.click(RIGHT, PanelId::Bench, "A(x) > B -> A(x) A(x+1)");
    visitor.frame();
    visitor.click(LEFT, PanelId::Keyboard, "(");
    visitor.workshop.let_go();
    visitor.workshop.keep_texts();
    visitor.frame();
    visitor.frame();
    let draft = "A(x) > B ->( A(x) A(x+1)";
    visitor.find(PanelId::Bench, draft);
    assert!(visitor.says(PanelId::Bench, "the sketch:"));
    visitor.click(RIGHT, PanelId::Bench, draft);
    visitor.click(LEFT, PanelId::Keyboard, "Delete");
    assert!(!visitor.says(PanelId::Bench, "the sketch:"));
}

#[test]
fn the_lever_turns_the_divergence_live_and_snaps() {
    for hand in HANDS {
        let mut visitor = Visitor::with_tree();
        let center = Vec3::new(0.24, 0.84, -0.28);
        let on_dial = |degrees: f32| {
            let angle = degrees.to_radians();
            center + Vec3::new(angle.sin(), 0.25, angle.cos()) * 0.06
        };
        visitor.tip_to(hand, on_dial(137.508));
        assert!(
            visitor.workshop.world().says().is_some(),
            "the knob is under the hand"
        );
        let before = visitor.workshop.edits();
        visitor.pull(hand, true);
        for degrees in [140.0, 150.0, 160.0, 170.0, 178.5] {
            visitor.tip_to(hand, on_dial(degrees));
            let shown = visitor.workshop.world().shown().sketch.divergence_deg;
            let expected = if degrees > 177.0 {
                180.0
            } else {
                f64::from(degrees)
            };
            let near = if degrees == 140.0 { 3.1 } else { 0.2 };
            assert!((shown - expected).abs() < near, "{shown} at {degrees}");
        }
        assert_eq!(visitor.workshop.edits(), before);
        visitor.pull(hand, false);
        assert_eq!(visitor.document().sketch.divergence_deg, 180.0);
        assert_eq!(visitor.workshop.edits(), before + 1);
    }
}

#[test]
fn a_handle_does_not_jump_when_the_hand_leaves_its_reach() {
    let mut visitor = Visitor::with_tree();
    let center = Vec3::new(0.24, 0.84, -0.28);
    let angle = 137.508_f32.to_radians();
    let on_dial = center + Vec3::new(angle.sin(), 0.25, angle.cos()) * 0.06;
    // It points down and away, so that its ray meets the dial's plane elsewhere.
    let direction = Vec3::new(0.6, -0.8, 0.0);
    visitor.tip_to_along(RIGHT, on_dial, direction);
    visitor.pull(RIGHT, true);
    for n in 0..=20_u8 {
        visitor.tip_to_along(RIGHT, on_dial + Vec3::Y * 0.01 * f32::from(n), direction);
        let shown = visitor.workshop.world().shown().sketch.divergence_deg;
        assert_eq!(shown, 137.508, "{n} cm above");
    }
}

#[test]
fn a_handle_is_let_go_by_what_took_it() {
    let center = Vec3::new(0.24, 0.84, -0.28);
    let angle = 137.508_f32.to_radians();
    let on_dial = center + Vec3::new(angle.sin(), 0.25, angle.cos()) * 0.06;
    type Press = fn(&mut Visitor, usize, bool);
    let buttons: [Press; 2] = [Visitor::pull, Visitor::grip];
    for [took, other] in [buttons, [buttons[1], buttons[0]]] {
        let mut visitor = Visitor::with_tree();
        visitor.tip_to(RIGHT, on_dial);
        took(&mut visitor, RIGHT, true);
        other(&mut visitor, RIGHT, true);
        other(&mut visitor, RIGHT, false);
        let before = visitor.workshop.edits();
        visitor.tip_to(RIGHT, center + Vec3::new(0.0, 0.25, 1.0) * 0.06);
        let shown = visitor.workshop.world().shown().sketch.divergence_deg;
        assert!(!(1.0..=359.0).contains(&shown), "still held: {shown}");
        assert_eq!(visitor.workshop.edits(), before, "one movement, one action");
        took(&mut visitor, RIGHT, false);
        assert_eq!(visitor.workshop.edits(), before + 1);
    }
}

#[test]
fn the_wheel_grows_without_jumps() {
    let mut visitor = Visitor::with_tree();
    let center = Vec3::new(-0.24, 0.84, -0.28);
    let on_dial = |turn: f32| center + Vec3::new(turn.sin(), 0.25, turn.cos()) * 0.06;
    visitor.tip_to(LEFT, on_dial(0.0));
    visitor.pull(LEFT, true);
    let mut last = 0.0;
    for n in 1..=20_u8 {
        visitor.tip_to(LEFT, on_dial(f32::from(n) * 0.2));
        let moment = visitor.workshop.world().moment();
        assert!(moment > last && moment - last < 0.25, "{last} {moment}");
        last = moment;
        let growth = visitor.workshop.scene().tree.as_ref().unwrap().growth;
        let part = moment - (moment.ceil() - 1.0);
        assert!((f64::from(growth) - part).abs() < 1e-3, "{growth} {part}");
    }
    visitor.pull(LEFT, false);
    assert_eq!(f64::from(visitor.document().step), last.ceil());
    let moment = visitor.workshop.world().moment();
    assert!((moment - last).abs() < 1e-9, "it stays where it was let go");
}

#[test]
fn the_stump_clears_when_it_is_asked_twice() {
    let mut visitor = Visitor::with_tree();
    let stump = Vec3::new(0.0, 0.865, -0.19);
    let resting = visitor.frame.hands[RIGHT];
    visitor.tip_to(RIGHT, stump);
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    assert!(!visitor.document().sketch.is_empty(), "once is not enough");
    // After some seconds it has forgotten.
    visitor.wait(5.0);
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    assert!(!visitor.document().sketch.is_empty());
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    assert!(visitor.document().sketch.is_empty());
    visitor.frame.hands[RIGHT] = resting;
    visitor.frame();
    visitor.frame.hands[RIGHT].stick = Vec2::new(-1.0, 0.0);
    visitor.frame();
    assert!(!visitor.document().sketch.is_empty(), "undo brings it back");
}

#[test]
fn playback_is_one_edit() {
    let mut visitor = Visitor::with_tree();
    let before = visitor.workshop.edits();
    visitor.click(RIGHT, PanelId::Bench, "Play");
    visitor.wait(3.5);
    assert!(visitor.workshop.world().is_playing());
    let moment = visitor.workshop.world().moment();
    assert!((3.3..4.2).contains(&moment), "{moment}");
    assert_eq!(visitor.workshop.edits(), before);
    visitor.click(RIGHT, PanelId::Bench, "Pause");
    assert_eq!(visitor.workshop.edits(), before + 1);
    assert!((4..=5).contains(&visitor.document().step));
    assert!(visitor.document().step > 0);
}

#[test]
fn drawing_is_set_on_the_bench() {
    use ramus::world::DrawTool;
    let mut visitor = Visitor::with_tree();
    visitor.click(RIGHT, PanelId::Bench, "Draw");
    let settings = |visitor: &Visitor| visitor.workshop.world().settings();
    visitor.click(LEFT, PanelId::Bench, "Eraser");
    assert_eq!(settings(&visitor).tool, DrawTool::Erase);
    visitor.click(LEFT, PanelId::Bench, "Pen");
    assert_eq!(settings(&visitor).tool, DrawTool::Draw);
    visitor.click(RIGHT, PanelId::Bench, "snap to angles");
    assert_eq!(settings(&visitor).snap_angle_deg, Some(15.0));
    visitor.click(RIGHT, PanelId::Bench, "snap to the middle plane");
    assert!(settings(&visitor).snap_mirror);
    visitor.click(RIGHT, PanelId::Bench, "snap to angles");
    assert_eq!(settings(&visitor).snap_angle_deg, None);
}

#[test]
fn another_project_is_taken_up_and_nothing_is_lost() {
    use ramus::app::{
        store::{Store, read_project},
        workshop::{Workshop, WorkshopParams},
    };
    use ramus::ui::Recent;
    let folder = tempfile::tempdir().unwrap();
    let [oak, elm] = ["oak", "elm"].map(|name| folder.path().join(format!("{name}.ramus")));
    let open = |project: &std::path::Path| {
        Workshop::new(Store::open(project).unwrap(), WorkshopParams::default()).unwrap()
    };
    let mut drawn = Visitor::at(open(&elm));
    drawn.draw_tree();
    drawn.workshop.close().unwrap();
    let mut visitor = Visitor::at(open(&oak));
    visitor.draw_tree();
    visitor.click(RIGHT, PanelId::Bench, "Draw");
    let made = visitor.document().clone();
    let recent = |project: &std::path::Path| Recent {
        project: project.to_owned(),
        picture: None,
    };
    visitor.workshop.offer(vec![
        recent(&folder.path().join("none.ramus/none")),
        recent(&elm),
        recent(&oak),
    ]);
    visitor.click(RIGHT, PanelId::Bench, "File");
    visitor.click(RIGHT, PanelId::Bench, "Go on with it");
    assert_eq!(
        visitor.workshop.project(),
        Some(&*oak),
        "that one cannot be opened"
    );
    assert_eq!(visitor.document(), &made);
    visitor.click_nth(LEFT, PanelId::Bench, "Go on with it", 3);
    assert_eq!(visitor.workshop.project(), Some(&*oak), "it is the one");
    visitor.click_nth(LEFT, PanelId::Bench, "Go on with it", 2);
    assert_eq!(visitor.workshop.project(), Some(&*elm));
    assert_eq!(read_project(&oak).unwrap(), made);
    assert!(!Store::has_journal(&oak), "it was closed");
    assert_eq!(visitor.document().sketch.strokes.len(), 2);
    assert_eq!(visitor.workshop.world().history().undo_count(), 0);
    visitor.click_nth(RIGHT, PanelId::Bench, "Grow", 1);
    visitor.click_nth(RIGHT, PanelId::Bench, "Grow", 2);
    assert_eq!(visitor.document().step, 1);
    visitor.workshop.close().unwrap();
    assert_eq!(read_project(&elm).unwrap().step, 1);
}

#[test]
fn a_recording_stays_with_its_project() {
    use ramus::app::{
        store::Store,
        workshop::{Workshop, WorkshopParams},
    };
    use ramus::ui::Recent;
    let folder = tempfile::tempdir().unwrap();
    let [oak, elm] = ["oak", "elm"].map(|name| folder.path().join(format!("{name}.ramus")));
    let opened = Store::open(&oak).unwrap();
    let workshop = Workshop::new(opened, WorkshopParams::default()).unwrap();
    let mut visitor = Visitor::at(workshop);
    visitor.workshop.stay_in_project();
    visitor.workshop.offer(vec![Recent {
        project: elm,
        picture: None,
    }]);
    visitor.click(RIGHT, PanelId::Bench, "File");
    visitor.click(RIGHT, PanelId::Bench, "Go on with it");
    assert_eq!(visitor.workshop.project(), Some(&*oak));
    let board = visitor.workshop.scene().board.clone().unwrap();
    let told = board.content.message.clone().unwrap();
    assert!(
        told.contains("a recording stays with one project"),
        "{told}"
    );
}
