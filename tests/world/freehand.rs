//! Strokes drawn with the trigger held: what is seen, what is kept, and what ends them.

use super::super::*;

/// A gentle S of some 0.4 m on the stage, from its start; `part` from 0 to 1.
fn path(start: Vec3, part: f32) -> Vec3 {
    let aside = 0.06 * (part * std::f32::consts::TAU).sin();
    start + Vec3::new(aside, 0.3 * part, 0.05 * part)
}

/// Pulls the trigger at the path's start and moves along it as far as `end`, in so many frames.
fn draw_along(person: &mut Person, hand: usize, start: Vec3, end: f32, frames: u16) {
    person.reach(hand, start);
    person.press(hand, Button::Trigger);
    for n in 1..=frames {
        person.reach(hand, path(start, end * f32::from(n) / f32::from(frames)));
    }
}

/// Draws the whole path and lets go.
fn stroke(person: &mut Person, hand: usize, start: Vec3) {
    draw_along(person, hand, start, 1.0, 60);
    person.release(hand, Button::Trigger);
}

/// Where a trunk begins: 8 cm above the root.
fn above_root(person: &Person) -> Vec3 {
    person.node(A, 0) + Vec3::Y * 0.08
}

fn segments(person: &Person, letter: Letter) -> u32 {
    person
        .world
        .document()
        .sketch
        .apex(letter)
        .map_or(0, |apex| apex.node)
}

#[test]
fn a_trigger_held_in_place_makes_the_one_segment() {
    for hand in BOTH {
        let mut person = Person::new();
        let tip = person.on_stage(trunk()[0]);
        person.reach(hand, tip);
        person.press(hand, Button::Trigger);
        let pulled = person.world.document().clone();
        for n in 0..200_u8 {
            let aside = Vec3::new(f32::from(n % 5) - 2.0, f32::from(n % 3), 0.0) * 0.006;
            person.reach(hand, tip + aside);
            assert_eq!(person.world.document(), &pulled);
        }
        person.release(hand, Button::Trigger);
        assert_eq!(person.world.document(), &pulled);
        assert!(close(person.in_sketch(A, 1), trunk()[0]));
        assert_eq!(person.world.history().undo_count(), 1);
    }
}

#[test]
fn a_held_trigger_that_moves_draws_one_stroke_in_one_action() {
    for hand in BOTH {
        let mut person = Person::new();
        let start = above_root(&person);
        person.reach(hand, start);
        person.press(hand, Button::Trigger);
        let mut most = 0;
        for n in 1..=60_u8 {
            let tip = path(start, f32::from(n) / 60.0);
            person.reach(hand, tip);
            let shown = person.world.shown();
            let apex = shown.sketch.apex(A).unwrap();
            let end = person.on_stage(shown.sketch.position(apex).unwrap());
            if tip.distance(start) > 0.02 {
                assert_eq!(
                    person.world.document(),
                    &Document::default(),
                    "not yet an edit"
                );
                assert!(end.distance(tip) < 1e-3, "it is seen up to the tip");
                assert_eq!(shown.selected, apex);
                assert!(
                    apex.node + 2 > most,
                    "it grows, but for how spans are rounded"
                );
                most = apex.node;
            }
        }
        let shown = person.world.shown().clone();
        person.release(hand, Button::Trigger);
        assert!(person.felt(hand) > 0.03 && person.felt(other(hand)) == 0.0);
        assert_eq!(
            person.world.document().sketch,
            shown.sketch,
            "made as it was shown"
        );
        let trunk = person.world.document().sketch.strokes[0].clone();
        assert!(
            trunk.is_curve() && trunk.handles.len() >= 4,
            "{:?}",
            trunk.handles
        );
        assert!(
            (8..=14).contains(&trunk.segments()),
            "{} segments",
            trunk.segments()
        );
        assert!(
            person.node(A, 1).distance(start) < 1e-3,
            "the first segment is the pull's"
        );
        // The curve is where the hand was.
        let way: Vec<Vec3> = (0..=600_u16)
            .map(|n| path(start, f32::from(n) / 600.0))
            .collect();
        for node in 1..=trunk.segments() {
            let at = person.node(A, node);
            let off = way
                .iter()
                .map(|place| place.distance(at))
                .fold(f32::MAX, f32::min);
            assert!(off < 0.008, "node {node} is {off} m off");
        }
        assert_eq!(
            (
                person.world.history().undo_count(),
                person.world.history().redo_count()
            ),
            (1, 0)
        );
        let mut again = History::default();
        for action in person.world.take_edits() {
            again.repeat(action).unwrap();
        }
        assert_eq!(
            again.committed(),
            person.world.document(),
            "the journal gives the same"
        );
        assert_eq!(again.undo_count(), 1);
        person.rest(hand);
        person.flick(hand, -1.0);
        assert_eq!(
            person.world.document(),
            &Document::default(),
            "one undo takes it back"
        );
        person.flick(hand, 1.0);
        assert_eq!(person.world.document().sketch, shown.sketch);
    }
}

#[test]
fn from_a_touched_node_it_draws_a_branch() {
    for hand in BOTH {
        let mut person = with_trunk(hand);
        let before = person.world.document().clone();
        let undo = person.world.history().undo_count();
        let at = person.node(A, 2);
        stroke(&mut person, hand, at);
        let document = person.world.document();
        let branch = document.sketch.stroke(C).unwrap();
        assert_eq!(branch.attachment, Some(NodeRef::new(A, 2)));
        assert!(branch.is_curve() && branch.segments() >= 6);
        assert_eq!(document.selected, document.sketch.apex(C).unwrap());
        assert_eq!(
            person.world.history().undo_count(),
            undo + 1,
            "choosing is no step of its own"
        );
        assert!(person.world.undo());
        assert_eq!(person.world.document(), &before);
    }
}

#[test]
fn from_the_root_it_draws_the_trunk_and_from_its_apex_it_goes_on() {
    let mut person = Person::new();
    let root = person.node(A, 0);
    stroke(&mut person, RIGHT, root);
    let first = segments(&person, A);
    assert!(first >= 6);
    let apex = person.node(A, first);
    let places: Vec<Vec3> = (1..=first).map(|node| person.in_sketch(A, node)).collect();
    stroke(&mut person, LEFT, apex);
    assert!(segments(&person, A) >= first + 6);
    for (node, place) in (1..).zip(places) {
        assert_eq!(person.in_sketch(A, node), place, "what is drawn stays");
    }
}

#[test]
fn a_node_pointed_at_from_afar_is_only_chosen() {
    let mut person = with_trunk(RIGHT);
    let at = person.node(A, 2);
    person.point(RIGHT, at);
    person.press(RIGHT, Button::Trigger);
    for n in 0..20_u8 {
        person.reach(RIGHT, at + Vec3::new(0.1, 0.0, 0.3 - 0.01 * f32::from(n)));
    }
    person.release(RIGHT, Button::Trigger);
    assert_eq!(person.world.document().selected, NodeRef::new(A, 2));
    assert_eq!(person.world.document().sketch.strokes.len(), 1);
}

#[test]
fn a_lost_controller_ends_the_stroke_where_it_was_last_seen() {
    for hand in BOTH {
        let mut person = Person::new();
        let start = above_root(&person);
        draw_along(&mut person, hand, start, 0.6, 40);
        let shown = person.world.shown().clone();
        person.input.hands[hand].tracked = false;
        person.input.hands[hand].aim.position = Vec3::splat(5.0);
        person.frame();
        assert_eq!(person.world.document(), &shown, "kept as it was seen");
        person.input.hands[hand].tracked = true;
        for n in 0..20_u8 {
            person.reach(hand, start + Vec3::X * 0.02 * f32::from(n));
        }
        assert_eq!(
            person.world.document(),
            &shown,
            "the trigger must come up first"
        );
        assert_eq!(person.world.history().undo_count(), 1);
    }
}

#[test]
fn lost_focus_ends_the_stroke_and_keeps_it() {
    for hand in BOTH {
        let mut person = Person::new();
        let start = above_root(&person);
        draw_along(&mut person, hand, start, 0.6, 40);
        let shown = person.world.shown().clone();
        person.input.focused = false;
        person.reach(hand, start + Vec3::X * 0.4);
        assert_eq!(person.world.document(), &shown);
        assert_eq!(person.world.shown(), &shown);
        person.input.focused = true;
        person.reach(hand, start + Vec3::X * 0.5);
        person.reach(hand, start - Vec3::X * 0.5);
        person.release(hand, Button::Trigger);
        assert_eq!(
            person.world.document(),
            &shown,
            "nothing goes on afterwards"
        );
    }
}

#[test]
fn twice_as_many_frames_draw_nearly_the_same() {
    let drawn = |frames: u16| {
        let mut person = Person::new();
        let start = above_root(&person);
        draw_along(&mut person, RIGHT, start, 1.0, frames);
        person.release(RIGHT, Button::Trigger);
        let count = segments(&person, A);
        (1..=count)
            .map(|node| person.node(A, node))
            .collect::<Vec<_>>()
    };
    let [rare, often, twice] = [36, 72, 144].map(drawn);
    for (what, other) in [("36", rare), ("144", twice)] {
        assert_eq!(other.len(), often.len(), "{what}");
        for (a, b) in other.iter().zip(&often) {
            assert!(a.distance(*b) < 0.004, "{what}: {a} {b}");
        }
    }
}

#[test]
fn frames_shown_twice_draw_the_same_stroke() {
    let mut person = with_trunk(LEFT);
    let at = person.node(A, 3);
    stroke(&mut person, RIGHT, at);
    person.rest(RIGHT);
    let expected = person.bytes();
    let frames = &person.frames;
    assert_eq!(replay(frames.iter().copied()), expected);
    assert_eq!(
        replay(frames.iter().flat_map(|&frame| [frame; 3])),
        expected
    );
    let slow = frames.iter().map(|&frame| Input {
        time: frame.time * 7.0,
        ..frame
    });
    assert_eq!(replay(slow), expected);
}

#[test]
fn a_scaled_platform_draws_what_the_hand_does() {
    // On the largest platform a centimetre of the hand is half a millimetre: segments are as long as they must be.
    for (scale, least) in [(0.05, 8), (0.25, 8), (1.0, 8), (20.0, 4)] {
        let platform = ramus::world::document::Placement {
            scale,
            yaw_deg: 33.0,
            ..Default::default()
        };
        let mut person = Person::with(Document {
            platform,
            ..Document::default()
        });
        let start = above_root(&person);
        stroke(&mut person, RIGHT, start);
        let count = segments(&person, A);
        assert!((least..=14).contains(&count), "{count} segments at {scale}");
        let end = path(start, 1.0);
        assert!(
            person.node(A, count).distance(end) < 1e-3 * scale.max(1.0),
            "at {scale}"
        );
    }
}

#[test]
fn undo_in_the_middle_takes_the_stroke_back() {
    for panel in [false, true] {
        let mut person = with_trunk(LEFT);
        let before = person.world.document().clone();
        let at = person.node(A, 2);
        draw_along(&mut person, RIGHT, at, 0.5, 30);
        if panel {
            assert!(person.world.undo());
        } else {
            person.flick(LEFT, -1.0);
        }
        assert_eq!(person.world.document(), &before);
        assert_eq!(person.world.shown(), &before);
        person.reach(RIGHT, at + Vec3::X * 0.3);
        person.release(RIGHT, Button::Trigger);
        assert_eq!(person.world.document(), &before, "the hand draws no more");
        assert!(person.world.redo());
        assert!(person.world.document().sketch.stroke(C).is_some());
    }
}

#[test]
fn the_other_hand_may_grow_hold_and_draw_meanwhile() {
    let mut person = with_trunk(LEFT);
    let at = person.node(A, 2);
    draw_along(&mut person, RIGHT, at, 0.4, 30);
    // A step of growth, and a node in the other hand: the stroke goes on.
    person.click(LEFT, Button::Lower);
    let held = person.node(A, 4);
    person.reach(LEFT, held);
    person.press(LEFT, Button::Squeeze);
    person.wait(FLIGHT);
    person.reach(LEFT, held - Vec3::X * 0.1);
    for n in 1..=20_u8 {
        person.reach(RIGHT, path(at, 0.4 + 0.03 * f32::from(n)));
    }
    let shown = person.world.shown().clone();
    person.release(LEFT, Button::Squeeze);
    assert!(person.world.document().sketch.stroke(C).is_none());
    assert_eq!(person.world.shown().sketch, shown.sketch);
    // Its trigger ends the stroke, and draws on from there.
    let end = person.on_stage(shown.sketch.position(shown.selected).unwrap());
    person.reach(LEFT, end + Vec3::X * 0.1);
    person.click(LEFT, Button::Trigger);
    let drawn = person.world.document().sketch.stroke(C).unwrap();
    assert_eq!(
        drawn.segments(),
        shown.sketch.stroke(C).unwrap().segments() + 1
    );
}

#[test]
fn an_edit_between_pull_and_stroke_leaves_the_segment() {
    let mut person = Person::new();
    let start = above_root(&person);
    person.reach(RIGHT, start);
    person.press(RIGHT, Button::Trigger);
    person.click(LEFT, Button::Lower);
    let document = person.world.document().clone();
    person.reach(RIGHT, start + Vec3::X * 0.2);
    person.release(RIGHT, Button::Trigger);
    assert_eq!(
        (person.world.document(), segments(&person, A)),
        (&document, 1)
    );
}

#[test]
fn a_stroke_whose_node_is_deleted_goes_with_it() {
    let mut person = with_trunk(LEFT);
    let at = person.node(A, 3);
    draw_along(&mut person, RIGHT, at, 0.5, 30);
    let edit = Edit::DeleteNode {
        at: NodeRef::new(A, 2),
    };
    person.world.apply(edit).unwrap();
    assert!(person.world.shown().sketch.stroke(C).is_none());
    person.release(RIGHT, Button::Trigger);
    assert_eq!(
        (
            person.world.document().sketch.strokes.len(),
            segments(&person, A)
        ),
        (1, 1)
    );
}

#[test]
fn the_trigger_that_deletes_a_held_node_draws_nothing_after_it() {
    let mut person = with_trunk(RIGHT);
    let at = person.node(A, 3);
    person.reach(RIGHT, at);
    person.press(RIGHT, Button::Squeeze);
    person.press(RIGHT, Button::Trigger);
    let document = person.world.document().clone();
    person.reach(RIGHT, at + Vec3::X * 0.2);
    person.reach(RIGHT, at + Vec3::X * 0.3);
    person.release(RIGHT, Button::Trigger);
    assert_eq!(person.world.document(), &document);
}

#[test]
fn a_long_stroke_ends_where_it_is_full_and_says_so() {
    let mut person = Person::new();
    let mut settings = person.world.settings();
    settings.spacing = 0.01;
    person.world.set_settings(settings);
    let start = above_root(&person);
    person.reach(RIGHT, start);
    person.press(RIGHT, Button::Trigger);
    // Jumps across the room, so that the test is short: 2,000 nodes of 1 cm are twenty metres.
    for n in 0..16_u8 {
        let side = if n % 2 == 0 { 1.0 } else { -1.0 };
        person.aim(
            RIGHT,
            start + Vec3::new(side, 0.02 * f32::from(n), 0.0),
            Vec3::NEG_Z,
        );
        person.input.time += 0.01;
        person.world.update(&person.input);
    }
    person.release(RIGHT, Button::Trigger);
    assert!(
        (1_990..=2_001).contains(&segments(&person, A)),
        "{}",
        segments(&person, A)
    );
    assert!(
        person.message().unwrap().contains("full"),
        "{:?}",
        person.message()
    );
}

#[test]
fn a_gripped_node_of_a_curve_bends_it_as_it_is_shown() {
    for hand in BOTH {
        let mut person = Person::new();
        let start = above_root(&person);
        stroke(&mut person, hand, start);
        person.rest(hand);
        let before = person.world.document().sketch.strokes[0].clone();
        let handle = before.handles[2];
        let at = person.node(A, handle);
        person.reach(hand, at);
        person.press(hand, Button::Squeeze);
        person.wait(FLIGHT);
        person.reach(hand, at + Vec3::new(0.05, 0.0, 0.04));
        let shown = person.world.shown().sketch.clone();
        person.release(hand, Button::Squeeze);
        assert_eq!(person.world.document().sketch, shown);
        let after = &shown.strokes[0];
        assert_eq!(
            (after.segments(), &after.handles),
            (before.segments(), &before.handles)
        );
        let others = before.handles.iter().filter(|&&other| other != handle);
        for &other in others {
            assert_eq!(
                after.offset(other),
                before.offset(other),
                "other handles stay"
            );
        }
        let bent = (1..=after.segments()).filter(|&node| after.offset(node) != before.offset(node));
        assert!(bent.count() > 1, "the nodes beside it follow");
    }
}
