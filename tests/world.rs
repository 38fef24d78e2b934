//! The workshop as a person uses it: what each button of either hand does, told as events and results.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    reason = "a test that fails shows the line; numbers are small"
)]

mod person;
mod world {
    mod any_input;
    mod freehand;
    mod hold;
    mod lines;
    mod marks;
    mod models;
    mod platform;
    mod settings;
    mod trouble;
}

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

/// Seconds after which a gripped node is at the hand.
const FLIGHT: f64 = 0.16;

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

/// A place on the platform's rim, to the right.
fn on_rim(person: &Person) -> Vec3 {
    let ring = rim(&person.world.document().platform, &StageParams::default());
    ring.center + Vec3::X * (ring.inner + ring.outer) * 0.5
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
fn choosing_a_node_is_an_action_where_it_changes_what_is_chosen() {
    let mut person = with_trunk(RIGHT);
    let (drawn, apex) = (person.world.history().undo_count(), NodeRef::new(A, 4));
    let at = person.node(A, 2);
    for _ in 0..2 {
        person.point(RIGHT, at);
        person.click(RIGHT, Button::Trigger);
        assert_eq!(person.world.document().selected, NodeRef::new(A, 2));
        assert_eq!(person.world.history().undo_count(), drawn + 1, "once");
    }
    person.rest(RIGHT);
    person.flick(RIGHT, -1.0);
    let document = person.world.document();
    assert_eq!(
        (document.selected, document.sketch.apex(A)),
        (apex, Some(apex))
    );
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
    person.wait(FLIGHT);
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
