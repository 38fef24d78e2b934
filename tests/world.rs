//! The workshop as a person uses it: what each button of either hand does, told as events and results.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    reason = "a test that fails shows the line; numbers are small"
)]

mod person;

use glam::{Quat, Vec3};
use person::{Button, LEFT, Person, RIGHT, replay, serve};
use ramus::{
    sketch::{BOUNDS, Letter, NodeRef},
    world::{
        World, WorldParams,
        document::{Document, Edit},
        history::{Action, History},
        input::{Input, Pose},
        scene::Scene,
        stage::{Palette, StageParams, rim},
    },
};

const A: Letter = Letter::TRUNK;
/// The first branch.
const C: Letter = Letter::from_index(1);

const BOTH: [usize; 2] = [LEFT, RIGHT];

fn other(hand: usize) -> usize {
    1 - hand
}

/// A trunk of four segments, metres in the sketch.
fn trunk() -> Vec<Vec3> {
    (1..=4_u8)
        .map(|n| Vec3::new(0.05 * f32::from(n), 0.4 * f32::from(n), 0.0))
        .collect()
}

fn branch() -> Vec<Vec3> {
    (1..=3_u8)
        .map(|n| Vec3::new(0.1 + 0.35 * f32::from(n), 0.8 + 0.2 * f32::from(n), 0.1))
        .collect()
}

fn with_trunk(hand: usize) -> Person {
    let mut person = Person::new();
    person.draw(hand, &trunk());
    person
}

fn with_branch(hand: usize) -> Person {
    let mut person = with_trunk(hand);
    let at = person.node(A, 2);
    person.point(hand, at);
    person.click(hand, Button::Trigger);
    person.draw(hand, &branch());
    person
}

fn close(a: Vec3, b: Vec3) -> bool {
    a.distance(b) < 2e-4
}

#[test]
fn the_trigger_makes_exactly_what_the_preview_shows() {
    let palette = Palette::default();
    for hand in BOTH {
        let mut person = Person::new();
        let mut from = person.node(A, 0);
        for (n, place) in (1..).zip(trunk()) {
            let tip = person.on_stage(place);
            person.reach(hand, tip);
            let scene = person.scene();
            let ball = scene
                .balls
                .iter()
                .find(|ball| ball.color == palette.ghost && ball.center.distance(tip) < 0.01)
                .unwrap();
            let rod = scene
                .rods
                .iter()
                .find(|rod| rod.color == palette.ghost && rod.to == ball.center)
                .unwrap();
            assert_eq!(rod.from, from, "the preview starts at the selected apex");
            person.press(hand, Button::Trigger);
            assert!(
                person.node(A, n).distance(ball.center) < 1e-6,
                "made where it was shown"
            );
            assert!(close(person.in_sketch(A, n), place));
            assert!(
                person.felt(hand) > 0.03 && person.felt(other(hand)) == 0.0,
                "the acting hand feels it"
            );
            person.release(hand, Button::Trigger);
            from = person.node(A, n);
        }
        assert_eq!(person.world.document().selected, NodeRef::new(A, 4));
    }
}

#[test]
fn a_held_trigger_draws_once() {
    for hand in BOTH {
        let mut person = Person::new();
        let tip = person.on_stage(trunk()[0]);
        person.reach(hand, tip);
        person.press(hand, Button::Trigger);
        for n in 0..20_u8 {
            person.reach(hand, tip + Vec3::X * 0.02 * f32::from(n));
        }
        assert_eq!(
            person.world.document().sketch.apex(A),
            Some(NodeRef::new(A, 1))
        );
    }
}

#[test]
fn a_branch_starts_at_a_node_that_is_no_apex() {
    for hand in BOTH {
        for touch in [false, true] {
            let mut person = with_trunk(hand);
            let at = person.node(A, 2);
            if touch {
                person.reach(hand, at)
            } else {
                person.point(hand, at)
            }
            let scene = person.scene();
            let palette = Palette::default();
            assert!(
                scene
                    .balls
                    .iter()
                    .any(|ball| ball.color == palette.hovered && ball.center == at),
                "highlighted"
            );
            person.click(hand, Button::Trigger);
            assert_eq!(person.world.document().selected, NodeRef::new(A, 2));
            assert_eq!(
                person.world.document().sketch.strokes.len(),
                1,
                "nothing is drawn yet"
            );
            person.draw(hand, &branch());
            let sketch = &person.world.document().sketch;
            let stroke = sketch.stroke(C).unwrap();
            assert_eq!(
                (stroke.attachment, stroke.points.len()),
                (Some(NodeRef::new(A, 2)), 3)
            );
            assert!(
                close(person.in_sketch(C, 1), branch()[0]),
                "it stands where it was drawn"
            );
            assert_eq!(
                sketch.apex(A),
                Some(NodeRef::new(A, 4)),
                "the trunk is as it was"
            );
        }
    }
}

#[test]
fn the_trigger_on_an_apex_goes_on_with_that_line() {
    for hand in BOTH {
        let mut person = with_branch(hand);
        let apex = person.node(A, 4);
        person.point(hand, apex);
        person.click(hand, Button::Trigger);
        assert_eq!(person.world.document().selected, NodeRef::new(A, 4));
        person.draw(hand, &[Vec3::new(0.2, 2.0, 0.2)]);
        assert_eq!(
            person.world.document().sketch.apex(A),
            Some(NodeRef::new(A, 5))
        );
    }
}

#[test]
fn no_branch_starts_at_the_root() {
    let mut person = with_trunk(RIGHT);
    let before = person.bytes();
    let root = person.node(A, 0);
    person.point(RIGHT, root);
    person.click(RIGHT, Button::Trigger);
    assert_eq!(person.bytes(), before);
    assert!(person.message().unwrap().contains("root"));
}

#[test]
fn a_gripped_node_follows_and_stays_where_it_is_dropped() {
    for hand in BOTH {
        for touch in [false, true] {
            let mut person = with_branch(hand);
            let before = person.world.document().clone();
            let at = person.node(A, 2);
            if touch {
                person.reach(hand, at)
            } else {
                person.point(hand, at)
            }
            person.press(hand, Button::Squeeze);
            assert!(person.felt(hand) > 0.0);
            let goal = Vec3::new(-0.2, 0.9, 0.3);
            for place in [Vec3::new(0.3, 0.7, 0.0), Vec3::new(0.0, 0.9, 0.2), goal] {
                let tip = person.on_stage(place);
                person.reach(hand, tip);
                let scene = person.scene();
                assert!(
                    scene
                        .balls
                        .iter()
                        .any(|ball| ball.center.distance(tip) < 1e-3),
                    "it follows"
                );
                assert_eq!(*person.world.document(), before, "not yet an edit");
            }
            person.release(hand, Button::Squeeze);
            assert!(close(person.in_sketch(A, 2), goal));
            for node in [1, 3, 4] {
                let stayed = before.sketch.position(NodeRef::new(A, node)).unwrap();
                assert_eq!(person.in_sketch(A, node), stayed, "neighbours stay");
            }
            person.rest(hand);
            person.flick(hand, -1.0);
            assert_eq!(*person.world.document(), before, "one undo takes it back");
        }
    }
}

#[test]
fn the_tree_follows_a_node_in_the_hand() {
    let mut person = with_trunk(RIGHT);
    person.click(RIGHT, Button::Lower);
    person.click(RIGHT, Button::Lower);
    let at = person.node(A, 1);
    person.reach(RIGHT, at);
    person.press(RIGHT, Button::Squeeze);
    let before = person.scene().tree.unwrap().tree;
    person.reach(RIGHT, at + Vec3::X * 0.1);
    let after = person.scene().tree.unwrap().tree;
    assert_ne!(
        before.position, after.position,
        "cause and effect in one frame"
    );
}

#[test]
fn the_trigger_deletes_a_gripped_node_and_all_above_it() {
    for hand in BOTH {
        let mut person = with_branch(hand);
        let at = person.node(A, 2);
        person.point(hand, at);
        person.press(hand, Button::Squeeze);
        person.press(hand, Button::Trigger);
        let sketch = &person.world.document().sketch;
        assert_eq!(sketch.apex(A), Some(NodeRef::new(A, 1)));
        assert_eq!(
            sketch.stroke(C),
            None,
            "the branch that was attached there is gone too"
        );
        assert!(person.felt(hand) > 0.05);
        person.release(hand, Button::Trigger);
        person.release(hand, Button::Squeeze);
        assert_eq!(
            person.world.document().sketch.apex(A),
            Some(NodeRef::new(A, 1)),
            "letting go does nothing more"
        );
    }
}

#[test]
fn both_hands_may_hold_a_node_each() {
    let mut person = with_trunk(RIGHT);
    for (hand, node) in [(LEFT, 1), (RIGHT, 3)] {
        let at = person.node(A, node);
        person.reach(hand, at);
        person.press(hand, Button::Squeeze);
    }
    let goals = [Vec3::new(-0.3, 0.4, 0.0), Vec3::new(0.5, 1.2, 0.0)];
    for (hand, goal) in BOTH.into_iter().zip(goals) {
        let tip = person.on_stage(goal);
        person.reach(hand, tip);
    }
    person.release(LEFT, Button::Squeeze);
    person.release(RIGHT, Button::Squeeze);
    assert!(close(person.in_sketch(A, 1), goals[0]) && close(person.in_sketch(A, 3), goals[1]));
}

#[test]
fn a_hand_lets_go_of_a_node_that_the_other_hand_deletes() {
    let mut person = with_trunk(RIGHT);
    for (hand, node) in [(LEFT, 3), (RIGHT, 2)] {
        let at = person.node(A, node);
        person.reach(hand, at);
        person.press(hand, Button::Squeeze);
    }
    person.press(RIGHT, Button::Trigger);
    assert_eq!(
        person.world.document().sketch.apex(A),
        Some(NodeRef::new(A, 1))
    );
    let left = person.bytes();
    person.release(LEFT, Button::Squeeze);
    assert_eq!(person.bytes(), left);
}

/// A place on the platform's rim, to the right.
fn on_rim(person: &Person) -> Vec3 {
    let ring = rim(&person.world.document().platform, &StageParams::default());
    ring.center + Vec3::X * (ring.inner + ring.outer) * 0.5
}

#[test]
fn the_rim_moves_and_turns_the_platform_level() {
    for hand in BOTH {
        for touch in [false, true] {
            let mut person = with_trunk(hand);
            let before = person.world.document().clone();
            let at = on_rim(&person);
            if touch {
                person.reach(hand, at);
            } else {
                person.aim(
                    hand,
                    at + Vec3::new(0.1, 0.5, 0.3),
                    Vec3::new(-0.1, -0.5, -0.3),
                );
                person.frame();
            }
            let palette = Palette::default();
            assert!(
                person
                    .scene()
                    .plates
                    .iter()
                    .any(|plate| plate.color == palette.rim_hovered),
                "highlighted"
            );
            person.press(hand, Button::Squeeze);
            // The hand goes 10 cm to the right and nods: the platform goes along and stays level.
            let pose = &mut person.input.hands[hand].grip;
            pose.position += Vec3::X * 0.1;
            pose.orientation = Quat::from_rotation_x(0.4) * pose.orientation;
            person.frame();
            assert_eq!(
                person.world.document().platform,
                before.platform,
                "not yet an edit"
            );
            person.release(hand, Button::Squeeze);
            let platform = person.world.document().platform;
            assert!(
                platform
                    .position
                    .distance(before.platform.position + Vec3::X * 0.1)
                    < 1e-3,
                "{platform:?}"
            );
            assert!(
                platform.yaw_deg.min(360.0 - platform.yaw_deg) < 0.1
                    && platform.scale == before.platform.scale
            );
            assert_eq!(person.world.document().sketch, before.sketch);
            person.rest(hand);
            person.flick(other(hand), -1.0);
            assert_eq!(*person.world.document(), before);
        }
    }
}

#[test]
fn two_hands_scale_the_platform_and_that_is_one_action() {
    for first in BOTH {
        let mut person = with_trunk(RIGHT);
        let before = person.world.document().clone();
        let undo_before = person.world.history().undo_count();
        let center = before.platform.position;
        let side = on_rim(&person) - center;
        for hand in [first, other(first)] {
            let sign = if hand == LEFT { -1.0 } else { 1.0 };
            person.reach(hand, center + side * sign);
            person.press(hand, Button::Squeeze);
        }
        let middle = (person.input.hands[LEFT].grip.position
            + person.input.hands[RIGHT].grip.position)
            * 0.5;
        for hand in BOTH {
            let sign = if hand == LEFT { -1.0 } else { 1.0 };
            person.input.hands[hand].grip.position.x += sign * side.x;
        }
        person.frame();
        person.release(first, Button::Squeeze);
        assert_eq!(
            *person.world.document(),
            before,
            "the other hand still holds it"
        );
        person.release(other(first), Button::Squeeze);
        let platform = person.world.document().platform;
        assert!(
            (platform.scale / before.platform.scale - 2.0).abs() < 0.02,
            "{platform:?}"
        );
        // Twice as far from the middle of the hands, which stays where it is.
        assert!(
            platform.position.distance(middle + (center - middle) * 2.0) < 2e-3,
            "{platform:?}"
        );
        assert_eq!(person.world.history().undo_count(), undo_before + 1);
    }
}

#[test]
fn a_grip_on_nothing_does_nothing() {
    for hand in BOTH {
        let mut person = with_trunk(hand);
        let before = person.bytes();
        person.reach(hand, Vec3::new(0.9, 1.8, 0.5));
        person.press(hand, Button::Squeeze);
        let at = person.node(A, 2);
        person.reach(hand, at);
        person.release(hand, Button::Squeeze);
        assert_eq!(person.bytes(), before);
        assert!(person.haptics.is_empty());
    }
}

#[test]
fn the_face_buttons_step_at_once_and_the_picture_follows() {
    for hand in BOTH {
        let mut person = with_branch(hand);
        for step in 1..=4 {
            person.press(hand, Button::Lower);
            assert_eq!(
                person.world.document().step,
                step,
                "the document steps at once"
            );
            assert!(person.felt(hand) > 0.0);
            let mut last = -1.0;
            while person.world.is_growing() {
                let growth = person.scene().tree.unwrap().growth;
                assert!(
                    growth >= last && growth - last < 0.1 || last < 0.0,
                    "no jumps: {last} {growth}"
                );
                last = growth;
                person.frame();
            }
            let tree = person.scene().tree.unwrap();
            assert_eq!((tree.growth, tree.newest), (1.0, step));
            person.release(hand, Button::Lower);
        }
        person.press(hand, Button::Upper);
        assert_eq!(person.world.document().step, 3);
        let tree = person.scene().tree.unwrap();
        assert!(
            tree.newest == 4 && tree.growth > 0.9,
            "what goes is seen going"
        );
        for _ in 0..50 {
            person.frame();
        }
        let tree = person.scene().tree.unwrap();
        assert_eq!((tree.newest, tree.growth), (3, 1.0));
        person.release(hand, Button::Upper);
        for _ in 0..5 {
            person.click(hand, Button::Upper);
        }
        assert_eq!(person.world.document().step, 0);
        assert!(person.message().unwrap().contains("root"));
    }
}

#[test]
fn the_stick_undoes_and_redoes_everything() {
    for hand in BOTH {
        let mut person = with_branch(hand);
        person.click(hand, Button::Lower);
        let end = person.bytes();
        let mut seen = vec![end.clone()];
        while person.world.history().undo_count() > 0 {
            person.flick(hand, -1.0);
            seen.push(person.bytes());
        }
        assert_eq!(*person.world.document(), Document::default());
        person.flick(hand, -1.0);
        assert!(person.message().unwrap().contains("undo"));
        for expected in seen.iter().rev().skip(1) {
            person.flick(hand, 1.0);
            assert_eq!(person.bytes(), *expected);
        }
        person.flick(hand, 1.0);
        assert!(person.message().unwrap().contains("redo"));
        assert_eq!(person.bytes(), end);
    }
}

#[test]
fn growth_beyond_the_limit_is_refused_with_a_sentence() {
    let mut params = WorldParams::default();
    params.tools.draw.max_segments = 50;
    for hand in BOTH {
        let mut person = with_branch(hand);
        person.world = World::with_params(History::new(person.world.document().clone()), params);
        person.frame();
        for _ in 0..30 {
            person.click(hand, Button::Lower);
        }
        let stopped = person.world.document().step;
        assert!((3..30).contains(&stopped));
        assert!(
            person.message().unwrap().contains("50"),
            "{:?}",
            person.message()
        );
        person.press(hand, Button::Lower);
        assert!(person.felt(hand) > 0.1);
    }
}

#[test]
fn an_edit_that_makes_the_tree_too_large_is_kept_and_told() {
    let mut params = WorldParams::default();
    params.growth.max_segments = 10;
    let mut person = Person::new();
    person.world = World::with_params(History::default(), params);
    person.frame();
    person.draw(RIGHT, &trunk());
    for _ in 0..9 {
        person.click(RIGHT, Button::Lower);
    }
    let at = person.node(A, 1);
    person.point(RIGHT, at);
    person.click(RIGHT, Button::Trigger);
    person.draw(RIGHT, &branch()[..1]);
    assert!(person.world.document().sketch.stroke(C).is_some());
    assert!(
        person.message().unwrap().contains("10 segments"),
        "{:?}",
        person.message()
    );
    assert!(person.world.tree_request().is_none());
}

#[test]
fn nothing_grows_before_something_is_drawn() {
    let mut person = Person::new();
    person.click(LEFT, Button::Lower);
    assert_eq!(person.world.document().step, 0);
    assert!(person.message().unwrap().contains("trunk"));
}

#[test]
fn a_hand_out_of_reach_draws_nothing() {
    let mut person = with_trunk(LEFT);
    let before = person.bytes();
    person.reach(LEFT, Vec3::new(-0.8, 0.5, 0.4));
    assert!(
        person
            .scene()
            .balls
            .iter()
            .all(|ball| ball.color != Palette::default().ghost)
    );
    person.click(LEFT, Button::Trigger);
    assert_eq!(person.bytes(), before);
    assert!(person.message().is_some());
}

#[test]
fn lost_focus_gives_back_what_was_held_and_hides_the_hands() {
    for hand in BOTH {
        let mut person = with_branch(hand);
        let before = person.bytes();
        let at = person.node(C, 2);
        person.point(hand, at);
        person.press(hand, Button::Squeeze);
        person.reach(hand, at + Vec3::Y * 0.1);
        person.input.focused = false;
        person.frame();
        let scene = person.scene();
        assert!(scene.controllers.is_empty());
        assert!(
            scene
                .balls
                .iter()
                .all(|ball| ball.color != Palette::default().ghost)
        );
        assert!(
            scene.balls.iter().any(|ball| ball.center == at),
            "the node is back"
        );
        // Released while someone else had the input, and gripped again before it came back.
        person.input.focused = true;
        person.frame();
        person.release(hand, Button::Squeeze);
        assert_eq!(
            person.bytes(),
            before,
            "a grip that began before is not a grip"
        );
        person.set(hand, Button::Trigger, true);
        person.input.focused = false;
        person.frame();
        person.input.focused = true;
        person.frame();
        person.release(hand, Button::Trigger);
        assert_eq!(person.bytes(), before, "nor is a trigger");
        // And everything works again.
        person.point(hand, at);
        person.press(hand, Button::Squeeze);
        person.reach(hand, at + Vec3::Y * 0.1);
        person.release(hand, Button::Squeeze);
        assert_ne!(person.bytes(), before);
    }
}

#[test]
fn a_lost_controller_drops_the_node_where_it_was_last_seen() {
    for hand in BOTH {
        let mut person = with_branch(hand);
        let at = person.node(A, 3);
        person.point(hand, at);
        person.press(hand, Button::Squeeze);
        let last = Vec3::new(-0.3, 1.3, 0.1);
        let tip = person.on_stage(last);
        person.reach(hand, tip);
        person.input.hands[hand].tracked = false;
        // What an untracked controller says is of no interest.
        person.input.hands[hand].aim.position = Vec3::new(5.0, 5.0, 5.0);
        person.frame();
        assert!(close(person.in_sketch(A, 3), last));
        let scene = person.scene();
        assert!(
            scene
                .controllers
                .iter()
                .all(|controller| controller.hand != hand)
        );
        let before = person.bytes();
        person.click(hand, Button::Trigger);
        person.click(hand, Button::Lower);
        person.flick(hand, -1.0);
        assert_eq!(person.bytes(), before, "it does not act either");
    }
}

#[test]
fn the_platform_in_a_hand_that_is_lost() {
    for hand in BOTH {
        let mut person = with_trunk(hand);
        let before = person.world.document().clone();
        let at = on_rim(&person);
        let grip_and_move = |person: &mut Person| {
            person.reach(hand, at);
            person.press(hand, Button::Squeeze);
            person.input.hands[hand].grip.position += Vec3::Y * 0.1;
            person.frame();
            assert!(
                person.world.shown().platform != before.platform,
                "it follows"
            );
        };
        grip_and_move(&mut person);
        person.input.focused = false;
        person.frame();
        assert_eq!(
            person.world.shown().platform,
            before.platform,
            "another has the input: it is back"
        );
        person.input.focused = true;
        person.rest(hand);
        assert_eq!(*person.world.document(), before);
        grip_and_move(&mut person);
        person.input.hands[hand].tracked = false;
        person.frame();
        let moved = person.world.document().platform.position - before.platform.position;
        assert!(
            moved.distance(Vec3::Y * 0.1) < 1e-3,
            "no tracking: it stays where it was last seen"
        );
    }
}

#[test]
fn one_of_two_hands_that_hold_the_platform_may_be_lost() {
    let mut person = with_trunk(RIGHT);
    let before = person.world.document().clone();
    let center = before.platform.position;
    let side = on_rim(&person) - center;
    for (hand, sign) in [(LEFT, -1.0), (RIGHT, 1.0)] {
        person.reach(hand, center + side * sign);
        person.press(hand, Button::Squeeze);
    }
    person.input.hands[LEFT].tracked = false;
    person.frame();
    assert_eq!(
        person.world.shown().platform,
        before.platform,
        "it does not jump"
    );
    person.input.hands[RIGHT].grip.position += Vec3::X * 0.2;
    person.frame();
    person.release(RIGHT, Button::Squeeze);
    let platform = person.world.document().platform;
    assert!(
        platform.position.distance(center + Vec3::X * 0.2) < 1e-3,
        "the other hand goes on with it"
    );
    assert_eq!(platform.scale, before.platform.scale);
}

#[test]
fn both_triggers_in_one_frame_draw_left_then_right() {
    let mut person = Person::new();
    let (first, second) = (trunk()[0], trunk()[1]);
    for (hand, place) in [(LEFT, first), (RIGHT, second)] {
        let tip = person.on_stage(place);
        person.aim(hand, tip, Vec3::new(0.0, 0.2, -1.0));
        person.set(hand, Button::Trigger, true);
    }
    person.frame();
    assert!(close(person.in_sketch(A, 1), first) && close(person.in_sketch(A, 2), second));
}

#[test]
fn nonsense_poses_and_triggers_count_as_untracked() {
    type Spoil = fn(&mut Input, usize);
    let spoils: [(&str, Spoil); 5] = [
        ("NaN position", |input, hand| {
            input.hands[hand].aim.position.x = f32::NAN
        }),
        ("short quaternion", |input, hand| {
            input.hands[hand].grip.orientation = Quat::from_xyzw(0.0, 0.0, 0.0, 0.3)
        }),
        ("far away", |input, hand| {
            input.hands[hand].aim.position.z = -500.0
        }),
        ("NaN trigger", |input, hand| {
            input.hands[hand].trigger = f32::NAN
        }),
        ("infinite squeeze", |input, hand| {
            input.hands[hand].squeeze = f32::INFINITY
        }),
    ];
    for (what, spoil) in spoils {
        for hand in BOTH {
            let mut person = with_trunk(hand);
            let before = person.bytes();
            let tip = person.on_stage(Vec3::new(0.2, 2.0, 0.0));
            person.reach(hand, tip);
            person.set(hand, Button::Trigger, true);
            let sound = person.input.hands[hand];
            spoil(&mut person.input, hand);
            person.frame();
            assert_eq!(person.bytes(), before, "{what}");
            assert_eq!(person.scene().controllers.len(), 1, "{what}");
            person.input.hands[hand] = sound;
            person.frame();
            assert_eq!(
                person.bytes(),
                before,
                "{what}: the trigger was pulled before the hand came back"
            );
            person.release(hand, Button::Trigger);
            person.click(hand, Button::Trigger);
            assert_ne!(person.bytes(), before, "{what}: and now it draws");
        }
    }
}

#[test]
fn a_nan_head_or_an_absurd_time_changes_nothing_that_is_kept() {
    let mut person = with_trunk(LEFT);
    person.click(LEFT, Button::Lower);
    person.click(LEFT, Button::Lower);
    let before = person.bytes();
    for time in [f64::NAN, f64::INFINITY, -1e300, 1e300, 0.0] {
        person.input.time = time;
        person.input.head = Pose {
            orientation: Quat::from_xyzw(f32::NAN, 0.0, 0.0, 0.0),
            position: Vec3::NAN,
        };
        let growth = person.scene().tree.unwrap().growth;
        person.world.update(&person.input);
        let moved = person.scene().tree.unwrap().growth - growth;
        assert!((0.0..0.3).contains(&moved), "{time}: {moved}");
    }
    assert_eq!(person.bytes(), before);
}

#[test]
fn hovering_is_felt_once() {
    for hand in BOTH {
        let mut person = with_trunk(other(hand));
        let at = person.node(A, 2);
        person.point(hand, at);
        assert!(
            (0.01..=0.02).contains(&person.felt(hand)),
            "{}",
            person.felt(hand)
        );
        person.frame();
        assert_eq!(person.felt(hand), 0.0);
        let at = person.node(A, 3);
        person.point(hand, at);
        assert!(person.felt(hand) > 0.0, "the next node is felt again");
    }
}

#[test]
fn marks_show_the_selection_attachments_and_repeats() {
    let person = with_branch(RIGHT);
    let (stage, palette) = (StageParams::default(), Palette::default());
    let scene = person.scene();
    let around = |at: Vec3, radius: f32| {
        scene
            .balls
            .iter()
            .any(|ball| ball.center == at && ball.radius == radius)
    };
    assert!(around(person.node(C, 3), stage.selected_radius));
    assert!(around(person.node(A, 2), stage.attachment_radius));
    assert!(around(person.node(A, 4), stage.repeat_radius));
    let letter = |letter: Letter| {
        scene
            .rods
            .iter()
            .filter(|rod| rod.color == palette.letter(letter.index()))
            .count()
    };
    assert_eq!((letter(A), letter(C)), (4, 3));
}

#[test]
fn the_board_says_what_stands_there() {
    let mut person = with_branch(RIGHT);
    for _ in 0..3 {
        person.click(RIGHT, Button::Lower);
    }
    let board = person.scene().board.unwrap();
    let text = board.content.lines.join("\n");
    assert!(text.contains("step 3") && text.contains("A(0)"), "{text}");
    assert!(text.contains("->") && text.contains("trigger"), "{text}");
    person.frame();
    assert_eq!(
        person.scene().board.unwrap().revision,
        board.revision,
        "nothing changed"
    );
    person.world.show_message("Saved.".into());
    assert_eq!(person.message().as_deref(), Some("Saved."));
    for _ in 0..72 * 9 {
        person.frame();
    }
    assert_eq!(person.message(), None, "it goes after a while");
}

/// Something of everything: what the tests below repeat in other ways.
fn walk() -> Person {
    let mut person = with_branch(RIGHT);
    for step in 0..4_u8 {
        person.click(usize::from(step % 2), Button::Lower);
    }
    let at = person.node(A, 3);
    person.point(LEFT, at);
    person.press(LEFT, Button::Squeeze);
    person.reach(LEFT, at + Vec3::new(-0.05, 0.02, 0.03));
    person.release(LEFT, Button::Squeeze);
    person.rest(LEFT);
    person.flick(RIGHT, -1.0);
    person.flick(RIGHT, 1.0);
    let at = on_rim(&person);
    person.reach(RIGHT, at);
    person.press(RIGHT, Button::Squeeze);
    person.input.hands[RIGHT].grip.position += Vec3::new(0.03, 0.01, 0.02);
    person.frame();
    person.release(RIGHT, Button::Squeeze);
    let at = person.node(C, 3);
    person.point(LEFT, at);
    person.press(LEFT, Button::Squeeze);
    person.press(LEFT, Button::Trigger);
    person.release(LEFT, Button::Trigger);
    person.release(LEFT, Button::Squeeze);
    person.rest(LEFT);
    person.rest(RIGHT);
    person
}

/// What of a frame can be an edge.
fn buttons(frame: &Input) -> [(bool, bool, bool, bool, i8); 2] {
    frame.hands.map(|hand| {
        let flick = if hand.stick.x.abs() > 0.7 {
            hand.stick.x.signum() as i8
        } else {
            0
        };
        (
            hand.trigger > 0.5,
            hand.squeeze > 0.5,
            hand.lower,
            hand.upper,
            flick,
        )
    })
}

#[test]
fn frames_shown_twice_or_not_at_all_change_nothing() {
    let person = walk();
    let expected = person.bytes();
    let frames = &person.frames;
    assert_eq!(replay(frames.iter().copied()), expected, "replay");
    assert_eq!(
        replay(frames.iter().flat_map(|&frame| [frame; 3])),
        expected,
        "each three times"
    );
    let mut last = None;
    let edges: Vec<Input> = frames
        .iter()
        .copied()
        .filter(|frame| last.replace(buttons(frame)) != Some(buttons(frame)))
        .collect();
    assert!(edges.len() < frames.len());
    assert_eq!(
        replay(edges),
        expected,
        "only the frames in which a button changes"
    );
    let slow = frames.iter().map(|&frame| Input {
        time: frame.time * 7.0,
        ..frame
    });
    assert_eq!(replay(slow), expected, "at another speed");
    let still = frames.iter().map(|&frame| Input { time: 0.0, ..frame });
    assert_eq!(replay(still), expected, "without time");
}

#[test]
fn the_journal_repeats_the_walk() {
    let mut person = walk();
    let actions = person.world.take_edits();
    assert!(actions.iter().any(|action| matches!(action, Action::Undo)));
    let mut history = History::default();
    for action in actions {
        history.repeat(action).unwrap();
    }
    assert_eq!(history.committed(), person.world.document());
    assert!(person.world.take_edits().is_empty(), "taken once");
}

#[test]
fn a_panel_edits_through_the_same_door() {
    let mut person = with_branch(RIGHT);
    let at = person.node(C, 2);
    person.reach(LEFT, at);
    person.press(LEFT, Button::Squeeze);
    person.world.apply(Edit::Clear).unwrap();
    assert!(person.world.shown().sketch.is_empty());
    person.release(LEFT, Button::Squeeze);
    assert!(
        person.world.document().sketch.is_empty(),
        "the hand let go of what was cleared"
    );
    assert!(person.world.undo() && person.world.document().sketch.stroke(C).is_some());
    assert!(person.world.redo() && person.world.document().sketch.is_empty());
    assert!(
        person
            .world
            .apply(Edit::SetStep {
                step: BOUNDS.step + 1
            })
            .is_err()
    );
}

mod any_input {
    use glam::Vec2;
    use proptest::prelude::*;

    use super::*;

    /// One change of what a person does; a frame follows.
    #[derive(Clone, Debug)]
    enum Event {
        /// The tip goes to a node, counted through all of them, and a bit beside it.
        ToNode(usize, usize, [f32; 3]),
        /// The tip goes somewhere near the platform.
        Near(usize, [f32; 3]),
        /// To the rim.
        ToRim(usize, f32),
        Button(usize, u8, f32),
        Stick(usize, f32),
        Focus(bool),
        Tracked(usize, bool),
        /// Any bits whatever.
        Bits(usize, [u32; 12]),
        Time(f64),
    }

    fn event() -> impl Strategy<Value = Event> {
        let hand = || 0..2_usize;
        let small = || prop::array::uniform3(-0.02_f32..0.02);
        prop_oneof![
            5 => (hand(), any::<prop::sample::Index>(), small()).prop_map(|(hand, node, aside)| Event::ToNode(hand, node.index(64), aside)),
            6 => (hand(), prop::array::uniform3(-0.4_f32..0.4)).prop_map(|(hand, place)| Event::Near(hand, place)),
            2 => (hand(), 0.0..6.3_f32).prop_map(|(hand, angle)| Event::ToRim(hand, angle)),
            16 => (hand(), 0..4_u8, prop_oneof![Just(0.0_f32), Just(1.0), 0.0..1.0_f32]).prop_map(|(hand, button, value)| Event::Button(hand, button, value)),
            4 => (hand(), prop_oneof![Just(0.0_f32), Just(-1.0), Just(1.0), -1.0..1.0_f32]).prop_map(|(hand, x)| Event::Stick(hand, x)),
            1 => any::<bool>().prop_map(Event::Focus),
            2 => (hand(), any::<bool>()).prop_map(|(hand, tracked)| Event::Tracked(hand, tracked)),
            1 => (hand(), prop::array::uniform12(any::<u32>())).prop_map(|(hand, bits)| Event::Bits(hand, bits)),
            1 => any::<f64>().prop_map(Event::Time),
        ]
    }

    fn take_in(person: &mut Person, event: &Event) {
        let document = person.world.document();
        let ahead = Vec3::new(0.0, 0.2, -1.0);
        match *event {
            Event::ToNode(hand, number, aside) => {
                let nodes: Vec<Vec3> = document.sketch.nodes().map(|(_, place)| place).collect();
                let tip = person.on_stage(nodes[number % nodes.len()]) + Vec3::from(aside);
                person.aim(hand, tip, ahead);
            }
            Event::Near(hand, place) => {
                let tip = document.platform.position + Vec3::Y * 0.3 + Vec3::from(place);
                person.aim(hand, tip, ahead);
            }
            Event::ToRim(hand, angle) => {
                let ring = rim(&document.platform, &StageParams::default());
                let tip = ring.center + Quat::from_rotation_y(angle) * Vec3::X * ring.outer;
                person.aim(hand, tip, ahead);
            }
            Event::Button(hand, button, value) => {
                let hand = &mut person.input.hands[hand];
                match button {
                    0 => hand.trigger = value,
                    1 => hand.squeeze = value,
                    2 => hand.lower = value > 0.5,
                    _ => hand.upper = value > 0.5,
                }
            }
            Event::Stick(hand, x) => person.input.hands[hand].stick = Vec2::new(x, 0.0),
            Event::Focus(focused) => person.input.focused = focused,
            Event::Tracked(hand, tracked) => person.input.hands[hand].tracked = tracked,
            Event::Bits(hand, bits) => {
                let f = |i: usize| f32::from_bits(bits[i]);
                let pose = Pose {
                    orientation: Quat::from_xyzw(f(0), f(1), f(2), f(3)),
                    position: Vec3::new(f(4), f(5), f(6)),
                };
                let hand = &mut person.input.hands[hand];
                (hand.aim, hand.grip) = (pose, pose);
                (hand.trigger, hand.squeeze, hand.stick) = (f(7), f(8), Vec2::new(f(9), f(10)));
            }
            Event::Time(time) => person.input.time = time,
        }
    }

    fn check(world: &World) {
        world.document().validate().unwrap();
        world.shown().validate().unwrap();
        let mut scene = Scene::default();
        world.scene(&mut scene);
        assert!(
            scene
                .rods
                .iter()
                .all(|rod| rod.from.is_finite() && rod.to.is_finite())
        );
        assert!(scene.balls.iter().all(|ball| ball.center.is_finite()));
        assert!(
            scene
                .plates
                .iter()
                .all(|plate| plate.world_from_plate.is_finite())
        );
        assert!(
            scene
                .controllers
                .iter()
                .all(|controller| controller.world_from_grip.is_finite())
        );
        assert!(
            scene
                .tree
                .is_none_or(|tree| (0.0..=1.0).contains(&tree.growth))
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]
        #[test]
        fn keeps_the_invariants_and_can_be_undone_and_repeated(events in prop::collection::vec(event(), 1..160)) {
            let mut params = WorldParams::default();
            params.tools.draw.max_segments = 300;
            params.growth.max_segments = 300;
            let mut person = Person::new();
            person.world = World::with_params(History::default(), params);
            person.frames.clear();
            for event in &events {
                take_in(&mut person, event);
                person.frame();
                check(&person.world);
            }
            let bytes = person.bytes();

            let mut again = World::with_params(History::default(), params);
            for frame in &person.frames {
                again.update(frame);
            }
            prop_assert!(again.document() == person.world.document(), "replay gives the same");

            let mut history = History::default();
            for action in person.world.take_edits() {
                history.repeat(action).unwrap();
            }
            prop_assert!(history.committed() == person.world.document(), "the journal gives the same");

            let undone = std::iter::from_fn(|| person.world.undo().then_some(())).count();
            prop_assert_eq!(person.world.document(), &Document::default());
            serve(&mut person.world);
            check(&person.world);
            for _ in 0..undone {
                prop_assert!(person.world.redo());
            }
            prop_assert!(person.bytes() == bytes, "undone and redone is the same");
        }
    }
}
