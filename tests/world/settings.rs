//! What a person may set about drawing: symmetry, snapping, the eraser.

use ramus::world::{DrawSettings, DrawTool};

use super::super::*;

fn set(person: &mut Person, change: impl FnOnce(&mut DrawSettings)) {
    let mut settings = person.world.settings();
    change(&mut settings);
    person.world.set_settings(settings);
}

#[test]
fn settings_are_standard_at_first_and_kept_within_bounds() {
    let mut person = Person::new();
    assert_eq!(person.world.settings(), DrawSettings::default());
    set(&mut person, |settings| {
        settings.spacing = f32::NAN;
        settings.symmetry = 1000;
    });
    let settings = person.world.settings();
    assert_eq!(
        (settings.spacing, settings.symmetry),
        (DrawSettings::default().spacing, 16)
    );
}

#[test]
fn a_branch_is_drawn_with_its_copies_in_one_action() {
    for hand in BOTH {
        for free_hand in [false, true] {
            let mut person = with_trunk(hand);
            set(&mut person, |settings| {
                settings.symmetry = 2;
                settings.mirror_symmetry = true;
            });
            let before = person.world.document().clone();
            let at = person.node(A, 2);
            person.reach(hand, at);
            if free_hand {
                person.press(hand, Button::Trigger);
                for n in 1..=30_u8 {
                    let up = Vec3::new(0.008, 0.006, 0.002) * f32::from(n);
                    person.reach(hand, at + up);
                }
                person.release(hand, Button::Trigger);
            } else {
                person.click(hand, Button::Trigger);
                person.draw(hand, &[Vec3::new(0.5, 1.0, 0.1), Vec3::new(0.8, 1.2, 0.1)]);
            }
            let sketch = &person.world.document().sketch;
            assert_eq!(sketch.strokes.len(), 1 + 4);
            let own = sketch.strokes[1].clone();
            assert!(own.segments() >= 2);
            for copy in &sketch.strokes[2..] {
                assert_eq!(
                    (copy.attachment, &copy.handles),
                    (own.attachment, &own.handles)
                );
                for (own, copy) in own.points.iter().zip(&copy.points) {
                    let signs = [own.x.abs(), own.y, own.z.abs()];
                    assert_eq!(signs, [copy.x.abs(), copy.y, copy.z.abs()]);
                }
            }
            assert_eq!(person.world.document().selected.letter, C);
            if free_hand {
                assert!(person.world.undo());
                assert_eq!(person.world.document(), &before, "one action");
            }
        }
    }
}

#[test]
fn a_segment_snaps_to_round_angles_where_the_preview_shows_it() {
    for on in [false, true] {
        let mut person = Person::new();
        set(&mut person, |settings| {
            settings.snap_angle_deg = on.then_some(15.0)
        });
        let tilt = 46.5_f32.to_radians();
        let place = Vec3::new(tilt.sin(), tilt.cos(), 0.0) * 0.5;
        let tip = person.on_stage(place);
        person.reach(LEFT, tip);
        assert_eq!(person.felt(LEFT) > 0.0, on, "a snap is felt");
        let ghost = Palette::default().ghost;
        let shown = person
            .scene()
            .rods
            .into_iter()
            .find(|rod| rod.color == ghost)
            .unwrap();
        person.click(LEFT, Button::Trigger);
        assert!(person.node(A, 1).distance(shown.to) < 1e-6, "made as shown");
        let angle = person.in_sketch(A, 1).angle_between(Vec3::Y).to_degrees();
        let expected = if on { 45.0 } else { 46.5 };
        assert!((angle - expected).abs() < 0.05, "{angle}");
    }
}

#[test]
fn nodes_near_the_mirror_plane_are_put_onto_it() {
    let mut person = Person::new();
    set(&mut person, |settings| settings.snap_mirror = true);
    person.draw(
        RIGHT,
        &[Vec3::new(0.04, 0.4, 0.1), Vec3::new(0.3, 0.8, 0.0)],
    );
    assert!(
        close(person.in_sketch(A, 1), Vec3::new(0.0, 0.4, 0.1)),
        "near"
    );
    assert!(
        close(person.in_sketch(A, 2), Vec3::new(0.3, 0.8, 0.0)),
        "far"
    );
    // A node that is moved there, and a free-hand stroke along the plane.
    let at = person.node(A, 2);
    person.reach(LEFT, at);
    person.press(LEFT, Button::Squeeze);
    person.wait(FLIGHT);
    let to = person.on_stage(Vec3::new(-0.03, 0.9, 0.0));
    person.reach(LEFT, to);
    person.release(LEFT, Button::Squeeze);
    assert!(close(person.in_sketch(A, 2), Vec3::new(0.0, 0.9, 0.0)));
    let at = person.node(A, 2);
    person.reach(RIGHT, at);
    person.press(RIGHT, Button::Trigger);
    for n in 1..=40_u8 {
        let wave = 0.012 * (f32::from(n) * 0.4).sin();
        person.reach(RIGHT, at + Vec3::new(wave, 0.006 * f32::from(n), 0.0));
    }
    person.release(RIGHT, Button::Trigger);
    let trunk = &person.world.document().sketch.strokes[0];
    assert!(trunk.points.len() > 6);
    assert!(
        trunk.points[1..].iter().all(|point| point.x == 0.0),
        "{:?}",
        trunk.points
    );
}

#[test]
fn the_eraser_deletes_what_the_tip_passes_and_shows_no_preview() {
    for hand in BOTH {
        let mut person = with_branch(hand);
        set(&mut person, |settings| settings.tool = DrawTool::Erase);
        let undo = person.world.history().undo_count();
        let beside = person.node(C, 3) + Vec3::new(0.1, 0.02, 0.0);
        person.reach(hand, beside);
        let ghost = Palette::default().ghost;
        assert!(person.scene().balls.iter().all(|ball| ball.color != ghost));
        person.press(hand, Button::Trigger);
        assert_eq!(
            person.world.history().undo_count(),
            undo,
            "there is nothing here"
        );
        // In one frame past the branch's apex: what lies between two frames is met too.
        let past = person.node(C, 3) - Vec3::new(0.03, 0.0, 0.0);
        person.reach(hand, past);
        let sketch = &person.world.document().sketch;
        assert_eq!(sketch.apex(C), Some(NodeRef::new(C, 2)));
        assert_eq!(
            person.world.history().undo_count(),
            undo + 1,
            "one edit a node"
        );
        assert!(person.felt(hand) > 0.05);
        // And on to the trunk's node 2: the branch goes with it.
        let at = person.node(A, 2);
        person.reach(hand, at + Vec3::Z * 0.2);
        person.reach(hand, at);
        let sketch = &person.world.document().sketch;
        assert_eq!(
            (sketch.apex(A), sketch.stroke(C)),
            (Some(NodeRef::new(A, 1)), None)
        );
        // The root stays, whatever passes it.
        let root = person.node(A, 0);
        for way in [
            at + Vec3::Z * 0.2,
            root + Vec3::Z * 0.2,
            root,
            root + Vec3::Z * 0.2,
        ] {
            person.reach(hand, way);
        }
        assert_eq!(person.message(), None);
        person.release(hand, Button::Trigger);
        let left = person.bytes();
        let at = person.node(A, 1);
        person.reach(hand, at);
        assert_eq!(person.bytes(), left, "the trigger is up");
        set(&mut person, |settings| settings.tool = DrawTool::Draw);
        person.click(hand, Button::Trigger);
        assert_eq!(person.world.document().selected, NodeRef::new(A, 1));
    }
}

#[test]
fn the_eraser_says_that_the_root_stays() {
    let mut person = with_trunk(RIGHT);
    set(&mut person, |settings| settings.tool = DrawTool::Erase);
    let before = person.bytes();
    let root = person.node(A, 0);
    person.reach(RIGHT, root);
    person.click(RIGHT, Button::Trigger);
    assert_eq!(person.bytes(), before);
    assert!(person.message().unwrap().contains("root"));
}

#[test]
fn another_tool_ends_the_stroke_in_the_hand() {
    let mut person = with_trunk(RIGHT);
    let at = person.node(A, 2);
    person.reach(RIGHT, at);
    person.press(RIGHT, Button::Trigger);
    for n in 1..=20_u8 {
        person.reach(RIGHT, at + Vec3::X * 0.01 * f32::from(n));
    }
    set(&mut person, |settings| settings.tool = DrawTool::Erase);
    let drawn = person.bytes();
    assert!(person.world.document().sketch.stroke(C).is_some());
    person.reach(RIGHT, at);
    assert_eq!(person.bytes(), drawn, "the pull belonged to the other tool");
}
