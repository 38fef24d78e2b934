//! Endpoints and measures on scanned models, as hands set them.

use ramus::mesh::Mesh;
use ramus::mesh::endpoints::{Endpoint, Kind, Proposal, Reason};
use ramus::mesh::unit::Unit;
use ramus::world::DrawTool;
use ramus::world::marks::{Found, Mark, Measuring};
use ramus::world::model::Model;
use ramus::world::models::{Cut, Looking};
use ramus::world::scene::SurfaceLook;

use super::super::*;
use super::models::loaded;

/// Corners around the tube, and rows of them.
const AROUND: u32 = 48;
const ROWS: u32 = 41;

/// An open tube of radius 1 around the third axis, 10 long, which begins far from the file's origin.
fn tube() -> Mesh {
    let corner = |n: u32| {
        let turn = (n % AROUND) as f32 / AROUND as f32 * std::f32::consts::TAU;
        Vec3::new(turn.cos(), turn.sin(), (n / AROUND) as f32 / 4.0)
    };
    let quads = (0..ROWS - 1).flat_map(|row| (0..AROUND).map(move |at| (row, at)));
    let triangles = quads.flat_map(|(row, at)| {
        let [a, b] = [at, (at + 1) % AROUND].map(|at| row * AROUND + at);
        [[a, b, b + AROUND], [a, b + AROUND, a + AROUND]]
    });
    Mesh {
        origin: glam::DVec3::new(5000.0, -300.0, 70.0),
        positions: (0..AROUND * ROWS).map(corner).collect(),
        triangles: triangles.collect(),
    }
}

/// Somebody before the tube, which stands upright: 40 cm high, 8 cm thick.
pub(super) fn before_the_tube(tool: DrawTool) -> Person {
    let mut person = with_trunk(RIGHT);
    let model = Model::new("tube.ply".into(), Unit::Millimetres, true, 0);
    let platform = person.world.document().platform;
    let edit = Edit::Arrange {
        models: vec![model.clone()],
        platform,
        linked: false,
    };
    person.world.apply(edit).unwrap();
    person.world.give_model(&model, Ok(loaded(tube())));
    choose(&mut person, tool);
    person.frame();
    person
}

fn choose(person: &mut Person, tool: DrawTool) {
    let mut settings = person.world.settings();
    settings.tool = tool;
    person.world.set_settings(settings);
}

fn ends(person: &Person) -> Vec<Endpoint> {
    person.world.document().models[0].endpoints.to_vec()
}

/// A place on the tube's front, so many of its units above its foot, on the stage.
pub(super) fn front(person: &Person, height: f32) -> Vec3 {
    person.world.shown().models[0].place.position + Vec3::new(0.0, height * 0.04, 0.04)
}

fn set(person: &mut Person, hand: usize, height: f32) {
    let at = front(person, height);
    person.point(hand, at);
    person.click(hand, Button::Trigger);
}

#[test]
fn endpoints_are_set_by_ray_and_by_touch_and_snap_to_the_middle() {
    for hand in BOTH {
        for touch in [false, true] {
            let mut person = before_the_tube(DrawTool::Mark);
            for height in [1.0, 5.0, 9.0] {
                let at = front(&person, height);
                if touch {
                    person.reach(hand, at);
                } else {
                    person.point(hand, at);
                }
                person.press(hand, Button::Trigger);
                assert!(person.felt(hand) > 0.0, "the hand feels it");
                person.release(hand, Button::Trigger);
                assert!(
                    person.message().is_none(),
                    "{:?} {height} {touch}",
                    person.message()
                );
            }
            let ends = ends(&person);
            let named: Vec<_> = ends.iter().map(|end| (&*end.name, end.kind)).collect();
            assert_eq!(
                named,
                [
                    ("source", Kind::Source),
                    ("target 1", Kind::Target),
                    ("target 2", Kind::Target)
                ],
                "the first is the source"
            );
            for (end, height) in ends.iter().zip([1.0, 5.0, 9.0]) {
                let from = end.point - tube().origin;
                // The front of the stage is the side of the tube's −y.
                let expected = glam::DVec3::new(0.0, -1.0, height);
                assert!(from.distance(expected) < 0.1, "{from} {touch}");
                let snapped = end.snapped.unwrap();
                let centre = snapped.centre - tube().origin;
                let axis = glam::DVec3::new(0.0, 0.0, from.z);
                assert!(centre.distance(axis) < 0.05, "{centre}");
                assert!((snapped.radius - 1.0).abs() < 0.02, "{}", snapped.radius);
            }
            let undo = person.world.history().undo_count();
            person.world.undo();
            assert_eq!(self::ends(&person).len(), 2, "each is a step of undo");
            assert_eq!(person.world.history().undo_count(), undo - 1);
        }
    }
}

#[test]
fn an_endpoint_is_moved_by_the_grip_and_goes_by_the_trigger_in_it() {
    let mut person = before_the_tube(DrawTool::Mark);
    set(&mut person, RIGHT, 2.0);
    set(&mut person, RIGHT, 8.0);
    // With the pen in hand, too.
    choose(&mut person, DrawTool::Draw);
    let before = ends(&person);
    let at = front(&person, 8.0);
    person.point(LEFT, at);
    person.press(LEFT, Button::Squeeze);
    let to = front(&person, 5.0);
    person.point(LEFT, to);
    person.frame();
    let seen = person.world.shown().models[0].endpoints[1].clone();
    assert_eq!(ends(&person), before, "until it is let go");
    person.release(LEFT, Button::Squeeze);
    let moved = ends(&person);
    assert_eq!(moved[1], seen, "where it was seen");
    assert!(((moved[1].point - tube().origin).z - 5.0).abs() < 0.1);
    assert_eq!((&*moved[1].name, &moved[0]), ("target 1", &before[0]));
    let centre = moved[1].snapped.unwrap().centre - tube().origin;
    assert!(centre.truncate().length() < 0.05 && (centre.z - 5.0).abs() < 0.15);
    person.world.undo();
    assert_eq!(ends(&person), before);
    // Gripped and pointed past the model, it stays; with the trigger it goes.
    person.point(LEFT, at);
    person.press(LEFT, Button::Squeeze);
    person.point(LEFT, at + Vec3::X * 2.0);
    person.release(LEFT, Button::Squeeze);
    assert_eq!(ends(&person), before);
    person.point(LEFT, at);
    person.press(LEFT, Button::Squeeze);
    person.press(LEFT, Button::Trigger);
    assert_eq!(ends(&person), before[..1]);
    person.release(LEFT, Button::Trigger);
    person.release(LEFT, Button::Squeeze);
    person.world.undo();
    assert_eq!(ends(&person), before);
}

#[test]
fn the_trigger_on_an_endpoint_turns_it_and_the_eraser_takes_it() {
    let mut person = before_the_tube(DrawTool::Mark);
    set(&mut person, RIGHT, 5.0);
    let kind = |person: &Person| ends(person)[0].kind;
    assert_eq!(kind(&person), Kind::Source);
    set(&mut person, RIGHT, 5.0);
    assert_eq!((ends(&person).len(), kind(&person)), (1, Kind::Target));
    // The pen draws as if it was not there.
    choose(&mut person, DrawTool::Draw);
    let sketch = person.world.document().sketch.clone();
    set(&mut person, RIGHT, 5.0);
    let drawn = person.world.document().sketch != sketch;
    assert!(drawn || person.message().is_some());
    if drawn {
        person.world.undo();
    }
    assert_eq!((ends(&person).len(), kind(&person)), (1, Kind::Target));
    choose(&mut person, DrawTool::Erase);
    set(&mut person, RIGHT, 5.0);
    assert!(ends(&person).is_empty());
}

#[test]
fn what_is_behind_the_surface_is_found_only_where_it_is_seen_through() {
    let mut person = before_the_tube(DrawTool::Mark);
    // On the back of the tube.
    let back = Endpoint {
        point: tube().origin + glam::DVec3::new(0.0, 1.0, 5.0),
        name: "back".into(),
        ..Endpoint::default()
    };
    person.world.set_endpoints(0, vec![back]).unwrap();
    let at = front(&person, 5.0);
    // Straight through the middle: the back is 8 cm behind the front.
    person.aim(RIGHT, at + Vec3::Z * 0.5, Vec3::NEG_Z);
    person.click(RIGHT, Button::Trigger);
    assert_eq!(ends(&person).len(), 2, "the front is marked");
    person.world.undo();
    let mut models = person.world.document().models.to_vec();
    models[0].surface = Some(SurfaceLook::XRay);
    let platform = person.world.document().platform;
    let edit = Edit::Arrange {
        models,
        platform,
        linked: false,
    };
    person.world.apply(edit).unwrap();
    person.click(RIGHT, Button::Trigger);
    let ends = ends(&person);
    assert_eq!(
        (ends.len(), ends[0].kind),
        (1, Kind::Source),
        "it was turned"
    );
}

#[test]
fn hands_reach_through_what_is_cut_away() {
    let mut person = before_the_tube(DrawTool::Mark);
    let at = front(&person, 5.0);
    // The left hand holds the plane within the tube; what is before it is gone.
    person.world.look(Looking {
        cut: Cut::InHand,
        lamp: false,
    });
    let middle = at - Vec3::Z * 0.04;
    person.aim(LEFT, middle, Vec3::NEG_Z);
    person.frame();
    person.aim(RIGHT, at + Vec3::Z * 0.5, Vec3::NEG_Z);
    person.click(RIGHT, Button::Trigger);
    let from = ends(&person)[0].point - tube().origin;
    assert!((from.y - 1.0).abs() < 0.05, "the back, from within: {from}");
}

#[test]
fn lengths_angles_and_thickness_are_measured_where_the_trigger_is_pulled() {
    let mut person = before_the_tube(DrawTool::Measure(Measuring::Distance));
    let (sketch, undo) = (person.bytes(), person.world.history().undo_count());
    for height in [2.0, 8.0] {
        set(&mut person, RIGHT, height);
    }
    let found = |person: &Person, at: usize| person.world.measures()[at].found;
    let Found::Length(length) = found(&person, 0) else {
        panic!("{:?}", found(&person, 0));
    };
    assert!((length - 6.0).abs() < 0.1, "{length}");
    choose(&mut person, DrawTool::Measure(Measuring::Angle));
    for height in [2.0, 5.0, 8.0] {
        set(&mut person, LEFT, height);
    }
    let Found::Degrees(degrees) = found(&person, 1) else {
        panic!("{:?}", found(&person, 1));
    };
    assert!(degrees > 170.0, "straight up: {degrees}");
    choose(&mut person, DrawTool::Measure(Measuring::Thickness));
    set(&mut person, RIGHT, 5.0);
    let Found::Thickness(thick) = found(&person, 2) else {
        panic!("{:?}", found(&person, 2));
    };
    assert!((thick.opposite.unwrap() - 2.0).abs() < 0.05, "{thick:?}");
    choose(&mut person, DrawTool::Measure(Measuring::Along));
    for height in [2.0, 8.0] {
        set(&mut person, RIGHT, height);
    }
    assert_eq!(found(&person, 3), Found::Waiting);
    let way = person.world.wanted_way().unwrap();
    let never = std::sync::atomic::AtomicBool::new(false);
    let [from, to] = &way.ends;
    let along = ramus::mesh::measure::along(&way.loaded.surface, from, to, &never);
    let along = along.unwrap().unwrap();
    person
        .world
        .give_way(way.id, Some((along.length, along.points)));
    let Found::Length(length) = found(&person, 3) else {
        panic!("{:?}", found(&person, 3));
    };
    assert!((length - 6.0).abs() < 0.1, "{length}");
    assert!(person.world.wanted_way().is_none());
    assert_eq!(person.bytes(), sketch, "nothing of it is in the project");
    assert_eq!(person.world.history().undo_count(), undo);
    // They lie on the model, and go with it.
    let signs = person.scene().rods.len();
    let id = person.world.measures()[0].id;
    person.world.mark(Mark::Unmeasure(Some(id))).unwrap();
    assert!(person.world.measures().len() == 3 && person.scene().rods.len() < signs);
    let platform = person.world.document().platform;
    let none = Edit::Arrange {
        models: Vec::new(),
        platform,
        linked: false,
    };
    person.world.apply(none).unwrap();
    assert!(person.world.measures().is_empty());
}

#[test]
fn there_are_so_many_measures_and_no_more() {
    let mut person = before_the_tube(DrawTool::Measure(Measuring::Thickness));
    for _ in 0..20 {
        set(&mut person, RIGHT, 5.0);
    }
    assert_eq!(person.world.measures().len(), 16);
    assert!(person.message().unwrap().contains("16 measures"));
    person.world.mark(Mark::Unmeasure(None)).unwrap();
    assert!(person.world.measures().is_empty());
    // One that was begun goes when something else is measured.
    choose(&mut person, DrawTool::Measure(Measuring::Angle));
    set(&mut person, RIGHT, 5.0);
    choose(&mut person, DrawTool::Measure(Measuring::Distance));
    set(&mut person, RIGHT, 5.0);
    let measures = person.world.measures();
    assert_eq!((measures.len(), measures[0].what), (1, Measuring::Distance));
}

#[test]
fn a_trigger_that_marks_and_meets_no_model_says_so() {
    let mut person = before_the_tube(DrawTool::Mark);
    let before = person.bytes();
    person.aim(RIGHT, Vec3::new(0.0, 1.5, 0.0), Vec3::Y);
    person.click(RIGHT, Button::Trigger);
    assert!(person.message().unwrap().contains("take the pen"));
    assert_eq!(person.bytes(), before);
}

#[test]
fn proposals_are_taken_and_refused_one_by_one_or_all() {
    let mut person = before_the_tube(DrawTool::Draw);
    person.world.mark(Mark::Propose(0)).unwrap();
    let (model, loaded) = person.world.wanted_proposals().unwrap();
    let model = model.clone();
    let never = std::sync::atomic::AtomicBool::new(false);
    let found = ramus::mesh::endpoints::propose(&loaded.surface, &never).unwrap();
    assert_eq!(found.len(), 2, "both open ends");
    let more: Vec<Proposal> = found.iter().chain(&found).cloned().collect();
    person.world.give_proposals(&model, more);
    assert!(person.world.wanted_proposals().is_none());
    let open = |person: &Person| person.world.proposals(&model).len();
    assert_eq!(
        (open(&person), ends(&person).len()),
        (4, 0),
        "nothing is taken unasked"
    );
    assert!(
        person.scene().balls.iter().any(|ball| ball.color[0] > 0.8),
        "they are seen"
    );
    person.world.mark(Mark::Refuse(0, Some(0))).unwrap();
    assert_eq!((open(&person), ends(&person).len()), (3, 0));
    person.world.mark(Mark::Take(0, Some(1))).unwrap();
    assert_eq!((open(&person), ends(&person).len()), (2, 1));
    person.world.mark(Mark::Take(0, None)).unwrap();
    let taken = ends(&person);
    assert_eq!((open(&person), taken.len()), (0, 3));
    let kinds = taken.iter().filter(|end| end.kind == Kind::Source).count();
    assert_eq!(kinds, 1, "one source: {taken:?}");
    assert!(taken.iter().all(|end| end.snapped.is_some()));
    assert_eq!(found[0].reason, Reason::OpenEnd);
    person.world.undo();
    assert_eq!(ends(&person).len(), 1);
    // What is no model's number does nothing.
    for mark in [
        Mark::Propose(7),
        Mark::Take(7, None),
        Mark::Refuse(0, Some(99)),
    ] {
        person.world.mark(mark).unwrap();
    }
    assert!(person.world.wanted_proposals().is_none());
}
