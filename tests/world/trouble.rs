//! What a person cannot help: lost focus, lost controllers, nonsense from devices; and what is seen and felt.

use super::super::*;

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
        person.wait(FLIGHT);
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

#[test]
fn a_rule_of_ones_own_that_decides_over_a_branch_is_spoken_of() {
    let mut person = with_branch(RIGHT);
    let rule = Edit::SetRule {
        of: "A > A :".into(),
        to: Some("A(x) > A(y) : x < 1 -> A(x) [ +(40) C(0) B ]".into()),
    };
    let node = |letter, node| NodeRef::new(letter, node);
    let (foot, first) = (node(A, 1), node(C, 1));
    let second = node(Letter::from_index(2), 1);
    let to = Vec3::new(0.1, 0.5, 0.1);
    let delete = |at| vec![Edit::DeleteNode { at }];
    for (edits, said) in [
        (vec![rule], None),
        (
            vec![Edit::Select { at: foot }, Edit::AddSegment { to }],
            Some("names it"),
        ),
        (delete(first), None),
        (delete(second), Some("undo brings both back")),
    ] {
        person.world.show_message("-".into());
        for edit in &edits {
            person.world.apply(edit.clone()).unwrap();
        }
        assert!(!person.world.take_edits().is_empty());
        let message = person.message().unwrap();
        assert!(
            message.contains(said.unwrap_or("-")),
            "{edits:?}: {message}"
        );
    }
}
