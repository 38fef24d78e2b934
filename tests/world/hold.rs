//! What hands hold: a gripped node flies to the hand, follows it, drops where it is seen, and can be deleted in the hand.

use super::super::*;

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
            person.wait(FLIGHT);
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
    person.wait(FLIGHT);
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
    person.wait(FLIGHT);
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

/// A branch, and the hand pointing from afar at the trunk's node 3, gripping it.
fn gripping(hand: usize) -> Person {
    let mut person = with_branch(hand);
    let at = person.node(A, 3);
    person.point(hand, at);
    person.press(hand, Button::Squeeze);
    person
}

/// Where the trunk's node 3 is seen.
fn seen(person: &Person) -> Vec3 {
    let shown = person.world.shown();
    let at = shown.sketch.position(NodeRef::new(A, 3)).unwrap();
    person.on_stage(at)
}

fn tip(person: &Person, hand: usize) -> Vec3 {
    let aim = person.input.hands[hand].aim;
    aim.position + aim.orientation * Vec3::NEG_Z * 0.06
}

#[test]
fn it_flies_to_the_hand_without_a_jump() {
    for hand in BOTH {
        let mut person = gripping(hand);
        let from = person.node(A, 3);
        let way = from.distance(tip(&person, hand));
        assert!(way > 0.4, "{way}");
        assert_eq!(seen(&person), from, "it starts where it was");
        let flight = WorldParams::default().tools.hold.flight_seconds;
        let begun = person.input.time;
        let (mut last, mut frames) = (from, 0);
        while seen(&person).distance(tip(&person, hand)) > 1e-4 {
            assert!(person.input.time - begun < flight + 0.02, "it is late");
            person.frame();
            let step = seen(&person).distance(last);
            assert!(step > 0.0 && step < 0.2 * way, "a jump of {step} of {way}");
            last = seen(&person);
            frames += 1;
        }
        assert!(
            frames > 8,
            "{frames} frames: at once is no flight that is seen"
        );
        // And now it is the hand's, to the bit.
        let goal = person.on_stage(Vec3::new(-0.3, 1.3, 0.1));
        person.reach(hand, goal);
        assert!(close(seen(&person), goal));
    }
}

#[test]
fn let_go_on_the_way_it_stays_where_it_is_seen() {
    for hand in BOTH {
        for frames in [0, 1, 3, 7] {
            let mut person = gripping(hand);
            let (from, to) = (person.node(A, 3), tip(&person, hand));
            for _ in 0..frames {
                person.frame();
            }
            // The hand opens in a frame that shows no later moment.
            let before = seen(&person);
            person.input.time -= 1.0 / 72.0;
            person.release(hand, Button::Squeeze);
            assert_eq!(person.node(A, 3), before, "after {frames} frames");
            let part = before.distance(from) / to.distance(from);
            assert!((0.0..0.9).contains(&part), "{part} of the way");
            assert_eq!(seen(&person), before);
        }
    }
}

#[test]
fn a_lost_hand_drops_it_on_the_way_and_lost_focus_gives_it_back() {
    for focus in [false, true] {
        let mut person = gripping(LEFT);
        let from = person.node(A, 3);
        for _ in 0..4 {
            person.frame();
        }
        let on_the_way = seen(&person);
        assert!(on_the_way.distance(from) > 0.05);
        if focus {
            person.input.focused = false;
        } else {
            person.input.hands[LEFT].tracked = false;
        }
        person.frame();
        assert_eq!(person.node(A, 3), if focus { from } else { on_the_way });
        assert_eq!(seen(&person), person.node(A, 3));
    }
}

/// Only the clock decides how far it has flown, not how often it was shown on the way.
#[test]
fn frames_shown_twice_or_not_at_all_change_nothing_on_the_way_either() {
    let mut person = gripping(RIGHT);
    let first = person.frames.len();
    for _ in 0..5 {
        person.frame();
    }
    let last = person.frames.len();
    person.release(RIGHT, Button::Squeeze);
    let expected = person.bytes();
    let frames = &person.frames;
    assert_eq!(replay(frames.iter().copied()), expected);
    let thrice = frames.iter().flat_map(|&frame| [frame; 3]);
    assert_eq!(replay(thrice), expected);
    let fewer = [&frames[..first], &frames[last..]].concat();
    assert_eq!(replay(fewer), expected);
    let slow = frames.iter().map(|&frame| Input {
        time: frame.time * 7.0,
        ..frame
    });
    assert_ne!(
        replay(slow),
        expected,
        "seven times as long it has arrived before it is let go"
    );
}

/// Whatever the clock says, the node is on its way or there.
#[test]
fn an_absurd_clock_keeps_it_between_where_it_was_and_the_hand() {
    for time in [f64::NAN, f64::INFINITY, -1e300, 0.0, f64::MAX] {
        let mut person = gripping(RIGHT);
        let (from, to) = (person.node(A, 3), tip(&person, RIGHT));
        person.input.time = time;
        for _ in 0..3 {
            person.world.update(&person.input);
            let at = seen(&person);
            let detour = at.distance(from) + at.distance(to) - from.distance(to);
            assert!(detour.abs() < 1e-3, "{time}: {at}");
        }
    }
}
