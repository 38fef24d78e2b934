//! The platform in one hand and in two, and in hands that are lost.

use super::super::*;

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
