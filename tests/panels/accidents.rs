//! Hands that slip, meet and are lost: nothing happens that nobody meant, and nothing that was made is lost.

use glam::{Quat, Vec2, Vec3};
use ramus::world::panels::PanelId;

use super::visitor::{LEFT, RIGHT, Visitor};

/// A visitor who drags the slider of the divergence angle with the left hand.
fn dragging() -> Visitor {
    let mut visitor = Visitor::with_tree();
    visitor.click(LEFT, PanelId::Bench, "Shape");
    let row = visitor.find(PanelId::Bench, "divergence angle") + Vec2::new(0.0, 0.04);
    visitor.point_on(LEFT, PanelId::Bench, Vec2::new(0.06, row.y));
    visitor.pull(LEFT, true);
    visitor.point_on(LEFT, PanelId::Bench, Vec2::new(0.12, row.y));
    visitor.frame();
    visitor.frame();
    visitor
}

fn shown_divergence(visitor: &Visitor) -> f64 {
    visitor.workshop.world().shown().sketch.divergence_deg
}

#[test]
fn a_tree_that_plays_is_cleared_to_step_0() {
    let mut visitor = Visitor::with_tree();
    visitor.click(RIGHT, PanelId::Bench, "Play");
    visitor.wait(2.5);
    visitor.tip_to(RIGHT, Vec3::new(0.0, 0.865, -0.19));
    for pulled in [true, false, true, false] {
        visitor.pull(RIGHT, pulled);
    }
    visitor.wait(1.0);
    assert!(visitor.document().sketch.is_empty());
    let world = visitor.workshop.world();
    assert_eq!((world.document().step, world.shown().step), (0, 0));
    assert!(!world.is_playing());
}

#[test]
fn the_buttons_of_growth_go_on_from_the_moment_that_is_seen() {
    for (grows, expected) in [(true, 4), (false, 2)] {
        let mut visitor = Visitor::with_tree();
        visitor.click(RIGHT, PanelId::Bench, "Play");
        visitor.wait(2.4);
        assert_eq!(visitor.workshop.world().shown().step, 3);
        visitor.frame.hands[RIGHT].lower = grows;
        visitor.frame.hands[RIGHT].upper = !grows;
        visitor.frame();
        assert_eq!(visitor.document().step, expected);
        assert_eq!(visitor.workshop.world().shown().step, expected);
    }
}

#[test]
fn playback_without_the_focus_stops_and_is_one_edit() {
    let mut visitor = Visitor::with_tree();
    let before = visitor.workshop.edits();
    visitor.click(RIGHT, PanelId::Bench, "Play");
    visitor.wait(1.5);
    visitor.frame.focused = false;
    visitor.wait(4.0);
    assert_eq!(visitor.workshop.edits(), before + 1);
    assert_eq!(visitor.document().step, 2);
}

#[test]
fn what_is_under_way_at_the_end_is_kept() {
    let mut visitor = dragging();
    let shown = shown_divergence(&visitor);
    assert_ne!(visitor.document().sketch.divergence_deg, shown);
    visitor.frame();
    let world = visitor.workshop.close().unwrap();
    assert_eq!(world.document().sketch.divergence_deg, shown);
}

#[test]
fn a_press_whose_hand_is_lost_is_no_click() {
    let mut visitor = Visitor::with_tree();
    let grow = visitor
        .workshop
        .find_text(PanelId::Bench, "Grow", 2)
        .unwrap();
    visitor.point_on(RIGHT, PanelId::Bench, grow);
    visitor.pull(RIGHT, true);
    visitor.frame.hands[RIGHT].tracked = false;
    visitor.frame();
    visitor.frame();
    assert_eq!(visitor.document().step, 0);
    // Back and let go, it presses as ever.
    visitor.frame.hands[RIGHT].tracked = true;
    visitor.pull(RIGHT, false);
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    assert_eq!(visitor.document().step, 1);
}

#[test]
fn a_press_that_leaves_its_panel_does_not_begin_anew_on_it() {
    let mut visitor = Visitor::with_tree();
    visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.3, 0.6));
    visitor.pull(RIGHT, true);
    let behind = visitor.frame.hands[RIGHT].aim.position + visitor.normal(PanelId::Bench);
    visitor.point(RIGHT, behind);
    visitor.frame();
    let grow = visitor
        .workshop
        .find_text(PanelId::Bench, "Grow", 2)
        .unwrap();
    visitor.point_on(RIGHT, PanelId::Bench, grow);
    visitor.frame();
    visitor.pull(RIGHT, false);
    assert_eq!(visitor.document().step, 0);
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    assert_eq!(visitor.document().step, 1);
}

#[test]
fn another_hand_does_not_take_a_drag_over() {
    let mut visitor = dragging();
    let shown = shown_divergence(&visitor);
    let row = visitor.find(PanelId::Bench, "divergence angle") + Vec2::new(0.0, 0.04);
    visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.2, row.y));
    visitor.pull(RIGHT, true);
    assert_eq!(shown_divergence(&visitor), shown);
    visitor.pull(RIGHT, false);
    assert_eq!(shown_divergence(&visitor), shown);
    // The hand that drags is lost while the other one points elsewhere.
    visitor.frame.hands[LEFT].tracked = false;
    visitor.frame();
    visitor.frame();
    assert_eq!(visitor.document().sketch.divergence_deg, shown);
}

#[test]
fn a_tip_that_comes_through_the_back_or_from_the_side_presses_nothing() {
    let mut visitor = Visitor::with_tree();
    let grow = visitor
        .workshop
        .find_text(PanelId::Bench, "Grow", 2)
        .unwrap();
    let normal = visitor.normal(PanelId::Bench);
    let at = visitor.on(PanelId::Bench, grow);
    for millimetres in [-40.0_f32, -11.0, -8.0, -3.0, 2.0, 30.0, 60.0] {
        visitor.tip_to_along(LEFT, at + normal * (millimetres / 1000.0), -normal);
        visitor.frame();
    }
    assert_eq!(visitor.document().step, 0, "through the back");
    let aside = visitor.on(PanelId::Bench, grow - Vec2::X * 0.4);
    for tip in [aside, at, at] {
        visitor.tip_to_along(LEFT, tip + normal * 0.003, -normal);
    }
    visitor.tip_to_along(LEFT, at + normal * 0.06, -normal);
    visitor.frame();
    assert_eq!(visitor.document().step, 0, "from the side");
}

#[test]
fn a_hand_that_drags_on_a_panel_undoes_nothing() {
    let mut visitor = dragging();
    let (shown, edits) = (shown_divergence(&visitor), visitor.workshop.edits());
    visitor.frame.hands[LEFT].stick = Vec2::new(-1.0, 0.0);
    visitor.frame();
    visitor.frame();
    assert_eq!(visitor.workshop.edits(), edits);
    assert_eq!(shown_divergence(&visitor), shown);
}

#[test]
fn the_keyboard_goes_with_the_bench() {
    let mut visitor = Visitor::with_tree();
    visitor.click(RIGHT, PanelId::Bench, "Rules");
    visitor.click(RIGHT, PanelId::Bench, "Change");
    visitor.click(RIGHT, PanelId::Bench, "A(x) > B -> A(x) A(x+1)");
    assert!(visitor.workshop.world().has_panel(PanelId::Keyboard));
    let turn = Quat::from_rotation_arc(Vec3::NEG_X, Vec3::new(0.0, 0.9, 0.44).normalize());
    let held = &mut visitor.frame.hands[LEFT];
    (held.grip.position, held.grip.orientation) = (Vec3::new(0.0, 1.2, -0.35), turn);
    visitor.frame();
    visitor.frame();
    visitor.click(RIGHT, PanelId::Wrist, "Hide");
    visitor.frame();
    visitor.frame();
    assert!(!visitor.workshop.world().has_panel(PanelId::Keyboard));
}

#[test]
fn a_hand_that_moves_a_little_while_it_presses_has_clicked() {
    let mut visitor = Visitor::with_tree();
    let grow = visitor
        .workshop
        .find_text(PanelId::Bench, "Grow", 2)
        .unwrap();
    visitor.point_on(RIGHT, PanelId::Bench, grow);
    visitor.frame();
    visitor.pull(RIGHT, true);
    visitor.point_on(RIGHT, PanelId::Bench, grow + Vec2::new(0.014, 0.004));
    visitor.wait(1.2);
    visitor.pull(RIGHT, false);
    assert_eq!(visitor.document().step, 1);
}

#[test]
fn the_growth_slider_does_not_run_from_the_hand() {
    let mut visitor = Visitor::with_tree();
    let row = visitor.find(PanelId::Bench, "step");
    visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.06, row.y));
    visitor.pull(RIGHT, true);
    visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.3, row.y));
    visitor.frame();
    visitor.frame();
    let moment = visitor.workshop.world().moment();
    visitor.wait(0.5);
    assert_eq!(visitor.workshop.world().moment(), moment);
    assert!((1.0..=20.0).contains(&moment), "{moment}");
}
