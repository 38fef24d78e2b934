//! A warm frame of the workshop, with a hand that rests on a panel, allocates nothing.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    dead_code,
    reason = "a test that fails shows the line; helpers are shared"
)]

mod counting;
mod panels {
    pub(crate) mod visitor;
}

use counting::allocations;
use glam::Vec2;
use panels::visitor::{LEFT, RIGHT, Visitor};
use ramus::world::panels::PanelId;

#[test]
fn a_hand_that_rests_on_a_panel_costs_nothing() {
    let mut visitor = Visitor::with_tree();
    visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.3, 0.3));
    visitor.workshop.unseen();
    let mut frame = visitor.frame;
    let mut play = |frames: u32, wanders: f32| {
        let before = allocations();
        for n in 0..frames {
            frame.time += 1.0 / 90.0;
            frame.hands[RIGHT].aim.position.x += if n % 2 == 0 { wanders } else { -wanders };
            frame.hands[LEFT].aim.position.y += 0.002;
            visitor.workshop.update(&frame);
        }
        allocations() - before
    };
    play(20, 1e-5);
    // A hand trembles, less than a pixel; it wanders, and stays on the same part.
    for wanders in [1e-5, 2e-3] {
        assert_eq!(play(40, wanders), 0, "40 warm frames, {wanders} m");
    }
    frame.hands[RIGHT].aim.position.x += 0.1;
    let before = allocations();
    visitor.workshop.update(&frame);
    assert!(
        allocations() > before,
        "the counter counts: another part has the pointer"
    );
}
