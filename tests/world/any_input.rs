//! Any input whatever, frame by frame: the world stays whole, and undo and replay are exact.

use glam::Vec2;
use proptest::prelude::*;
use ramus::world::marks::Measuring;
use ramus::world::{DrawSettings, DrawTool};

use super::super::*;
use super::marks::{before_the_tube, front};

/// What the trigger may do with models.
fn marking() -> impl Strategy<Value = DrawTool> {
    prop_oneof![
        Just(DrawTool::Mark),
        Just(DrawTool::Erase),
        Just(DrawTool::Measure(Measuring::Distance)),
        Just(DrawTool::Measure(Measuring::Along)),
    ]
}

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

fn settings() -> impl Strategy<Value = DrawSettings> {
    let lengths = (0.0_f32..0.1, 0.0_f32..0.02, 0.0_f32..1.0);
    let switches = (any::<bool>(), any::<bool>(), prop::bool::weighted(0.2));
    let rest = (prop::option::of(5.0_f32..60.0), 1..4_u32);
    (lengths, switches, rest).prop_map(|(lengths, switches, (snap_angle_deg, symmetry))| {
        let (spacing, tolerance, smoothing) = lengths;
        let (snap_mirror, mirror_symmetry, erase) = switches;
        DrawSettings {
            tool: if erase {
                DrawTool::Erase
            } else {
                DrawTool::Draw
            },
            spacing,
            tolerance,
            smoothing,
            snap_angle_deg,
            snap_mirror,
            symmetry,
            mirror_symmetry,
            ..DrawSettings::default()
        }
    })
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
    fn keeps_the_invariants_and_can_be_undone_and_repeated(events in prop::collection::vec(event(), 1..160), settings in settings()) {
        let mut params = WorldParams::default();
        params.tools.settings = settings;
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
        // What the hands hold goes back or, a stroke, is kept.
        person.input.focused = false;
        person.frame();
        prop_assert!(person.world.shown() == person.world.document());
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

    #[test]
    fn marks_on_a_model_are_edits_that_can_be_undone_and_repeated(
        events in prop::collection::vec((event(), prop::option::of((0..2_usize, 0.0_f32..10.0)), marking()), 1..120),
    ) {
        let mut person = before_the_tube(DrawTool::Mark);
        let heights = [0.0, 10.0].map(|height| front(&person, height));
        for (event, at, tool) in &events {
            if let Some((hand, height)) = *at {
                // Also where it was before it was carried away or undone.
                let place = heights[0].lerp(heights[1], height / 10.0);
                person.point(hand, place);
                let settings = DrawSettings { tool: *tool, ..person.world.settings() };
                person.world.set_settings(settings);
            }
            take_in(&mut person, event);
            person.frame();
            check(&person.world);
        }
        person.input.focused = false;
        person.frame();
        prop_assert!(person.world.shown() == person.world.document());
        let mut history = History::default();
        for action in person.world.take_edits() {
            history.repeat(action).unwrap();
        }
        prop_assert!(history.committed() == person.world.document(), "the journal gives the same");
        while person.world.undo() {}
        prop_assert_eq!(person.world.document(), &Document::default());
        check(&person.world);
    }
}
