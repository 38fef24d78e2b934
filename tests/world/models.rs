//! Scanned models in the hands: carried, turned, scaled, linked, undone.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ramus::mesh::Mesh;
use ramus::mesh::pick::Picker;
use ramus::mesh::surface::Surface;
use ramus::mesh::unit::Unit;
use ramus::world::model::{LoadedModel, MOST_MODELS, Model};
use ramus::world::models::BOX_COLOR;
use ramus::world::scene::SurfaceLook;

use super::super::*;

/// A tetrahedron of ten units.
fn tetrahedron() -> Mesh {
    Mesh {
        positions: vec![Vec3::ZERO, Vec3::X * 10.0, Vec3::Y * 10.0, Vec3::Z * 10.0],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..Mesh::default()
    }
}

/// What reading a file with such a mesh gives.
pub(super) fn loaded(mesh: Mesh) -> LoadedModel {
    let never = AtomicBool::new(false);
    let picker = Picker::new(Arc::new(mesh), &never, &mut |_, _| ()).unwrap();
    LoadedModel::new(Surface::new(picker, &never).unwrap(), &never).unwrap()
}

fn arrange(person: &Person, models: Vec<Model>, linked: bool) -> Edit {
    let platform = person.world.document().platform;
    Edit::Arrange {
        models,
        platform,
        linked,
    }
}

/// Somebody before so many models that were read.
fn with_models(count: usize, linked: bool) -> Person {
    let mut person = with_trunk(RIGHT);
    let models = (0..count)
        .map(|n| Model::new(format!("{n}.ply"), Unit::Millimetres, false, n))
        .collect();
    let edit = arrange(&person, models, linked);
    person.world.apply(edit).unwrap();
    while let Some(model) = person.world.wanted_model().cloned() {
        person.world.give_model(&model, Ok(loaded(tetrahedron())));
    }
    person.frame();
    person
}

fn place(person: &Person, at: usize) -> Vec3 {
    person.world.shown().models[at].place.position
}

/// A point on a pedestal's rim.
fn rim_before(person: &Person, at: usize) -> Vec3 {
    place(person, at) + Vec3::new(0.0, -0.004, 0.13)
}

#[test]
fn a_model_is_carried_by_its_rim_in_one_step_of_undo() {
    for hand in BOTH {
        let mut person = with_models(1, false);
        let before = place(&person, 0);
        let rim = rim_before(&person, 0);
        person.reach(hand, rim);
        person.press(hand, Button::Squeeze);
        let by = Vec3::new(0.2, 0.1, 0.3);
        person.reach(hand, rim + by);
        person.frame();
        assert!(place(&person, 0).distance(before + by) < 1e-3, "it follows");
        assert_eq!(
            person.world.document().models[0].place.position,
            before,
            "until it is let go"
        );
        person.release(hand, Button::Squeeze);
        assert!(
            person.world.document().models[0]
                .place
                .position
                .distance(before + by)
                < 1e-3
        );
        assert!(person.world.undo());
        assert_eq!(person.world.document().models[0].place.position, before);
    }
}

#[test]
fn a_model_is_gripped_where_it_is_pointed_at_and_the_trigger_draws_through_it() {
    let mut person = with_models(1, false);
    let middle = place(&person, 0) + Vec3::Y * 0.15;
    person.point(RIGHT, middle);
    let sketch = person.world.document().sketch.clone();
    person.click(RIGHT, Button::Trigger);
    assert!(
        person.message().is_some(),
        "too far from the node to draw, as if no model was there"
    );
    assert_eq!(person.world.document().sketch, sketch);
    person.press(RIGHT, Button::Squeeze);
    person.point(RIGHT, middle + Vec3::X * 0.1);
    person.frame();
    let moved = place(&person, 0);
    person.release(RIGHT, Button::Squeeze);
    assert_eq!(person.world.document().models[0].place.position, moved);
}

#[test]
fn two_hands_pull_it_to_any_size() {
    let mut person = with_models(1, false);
    let at = place(&person, 0);
    let [left, right] =
        [Vec3::new(-0.13, -0.004, 0.0), Vec3::new(0.13, -0.004, 0.0)].map(|by| at + by);
    for (hand, place) in [(LEFT, left), (RIGHT, right)] {
        person.reach(hand, place);
        person.press(hand, Button::Squeeze);
    }
    let grips = person.input.hands.map(|hand| hand.grip.position);
    let span = grips[1] - grips[0];
    // Three times as far from each other.
    person.reach(LEFT, left - span);
    person.reach(RIGHT, right + span);
    person.frame();
    let before = person.world.document().models[0].place.scale;
    let now = person.world.shown().models[0].place.scale;
    assert!((now / before - 3.0).abs() < 0.02, "{now} {before}");
    person.release(LEFT, Button::Squeeze);
    person.release(RIGHT, Button::Squeeze);
    assert_eq!(person.world.document().models[0].place.scale, now);
    assert_eq!(
        person.world.history().undo_count(),
        with_models(1, false).world.history().undo_count() + 1
    );
}

#[test]
fn what_is_linked_turns_together() {
    for linked in [false, true] {
        let mut person = with_models(2, linked);
        let rim = rim_before(&person, 0);
        person.reach(RIGHT, rim);
        person.press(RIGHT, Button::Squeeze);
        let quarter = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
        person.input.hands[RIGHT].grip.orientation = quarter;
        person.input.hands[RIGHT].aim.orientation = quarter;
        person.frame();
        person.release(RIGHT, Button::Squeeze);
        let document = person.world.document();
        let turns = [
            document.models[0].place.yaw_deg,
            document.models[1].place.yaw_deg,
            document.platform.yaw_deg,
        ];
        let other = if linked { 90.0 } else { 0.0 };
        for (turn, expected) in turns.into_iter().zip([90.0, other, other]) {
            assert!((turn - expected).abs() < 0.1, "{linked}: {turns:?}");
        }
        person.world.undo();
        assert_eq!(person.world.document().platform.yaw_deg, 0.0);

        // And the platform turns the models.
        let platform = person.world.document().platform;
        let ring = rim_of(&platform);
        person.rest(RIGHT);
        person.reach(RIGHT, ring);
        person.press(RIGHT, Button::Squeeze);
        person.input.hands[RIGHT].grip.orientation = quarter;
        person.input.hands[RIGHT].aim.orientation = quarter;
        person.frame();
        person.release(RIGHT, Button::Squeeze);
        let document = person.world.document();
        assert!((document.platform.yaw_deg - 90.0).abs() < 0.1);
        assert!((document.models[1].place.yaw_deg - other).abs() < 0.1);
    }
}

fn rim_of(platform: &ramus::world::document::Placement) -> Vec3 {
    let ring = rim(platform, &StageParams::default());
    ring.center + Vec3::X * ring.inner.midpoint(ring.outer)
}

#[test]
fn a_model_in_whose_place_another_stands_is_let_go() {
    let mut person = with_models(3, false);
    person.reach(RIGHT, rim_before(&person, 1));
    person.press(RIGHT, Button::Squeeze);
    person.frame();
    // A panel takes the first one away: what was the second is the first now.
    let mut models = person.world.document().models.to_vec();
    models.remove(0);
    let before = models.clone();
    let edit = arrange(&person, models, false);
    person.world.apply(edit).unwrap();
    person.reach(RIGHT, Vec3::new(0.6, 1.2, -0.2));
    person.frame();
    person.release(RIGHT, Button::Squeeze);
    person.frame();
    assert_eq!(*person.world.document().models, before, "no other is moved");
}

#[test]
fn a_model_that_goes_while_it_is_held_is_let_go() {
    let mut person = with_models(2, false);
    let rim = rim_before(&person, 1);
    person.reach(LEFT, rim);
    person.press(LEFT, Button::Squeeze);
    person.reach(LEFT, rim + Vec3::X * 0.1);
    person.frame();
    let one = vec![person.world.document().models[0].clone()];
    let edit = arrange(&person, one.clone(), false);
    person.world.apply(edit).unwrap();
    person.frame();
    person.release(LEFT, Button::Squeeze);
    assert_eq!(*person.world.document().models, one);
    assert_eq!(person.scene().models.len(), 1);
}

#[test]
fn a_skeleton_is_seen_where_the_surface_hides_nothing() {
    let mut person = with_models(2, false);
    let model = person.world.document().models[1].clone();
    let mut read = loaded(tetrahedron());
    read.centerline = Some((Arc::clone(&read.plain), 77));
    person.world.give_model(&model, Ok(read));
    let seen = |person: &mut Person, surface: Option<SurfaceLook>| {
        let mut models = person.world.document().models.to_vec();
        models[1].surface = surface;
        let edit = arrange(person, models, false);
        person.world.apply(edit).unwrap();
        let scene = person.scene();
        let lines = scene.models.iter().filter(|placed| placed.revision == 77);
        let places: Vec<_> = lines.map(|line| line.world_from_model).collect();
        assert!(
            places
                .iter()
                .all(|at| *at == scene.models[1].world_from_model)
        );
        places.len()
    };
    for (surface, lines) in [
        (Some(SurfaceLook::Shaded), 0),
        (Some(SurfaceLook::XRay), 1),
        (None, 1),
        (Some(SurfaceLook::Textured), 0),
    ] {
        assert_eq!(seen(&mut person, surface), lines, "{surface:?}");
    }
}

#[test]
fn a_lost_focus_puts_it_back() {
    let mut person = with_models(1, false);
    let (before, rim) = (place(&person, 0), rim_before(&person, 0));
    person.reach(LEFT, rim);
    person.press(LEFT, Button::Squeeze);
    person.reach(LEFT, rim + Vec3::X * 0.2);
    person.frame();
    person.input.focused = false;
    person.frame();
    assert_eq!(place(&person, 0), before);
}

#[test]
fn a_file_that_cannot_be_read_leaves_an_empty_pedestal_and_its_reason() {
    let mut person = with_trunk(LEFT);
    let plates = person.scene().plates.len();
    let model = Model::new("gone.ply".into(), Unit::Metres, false, 0);
    let edit = arrange(&person, vec![model.clone()], false);
    person.world.apply(edit).unwrap();
    assert_eq!(person.world.wanted_model(), Some(&model));
    person
        .world
        .give_model(&model, Err("gone.ply: there is no such file".into()));
    person.frame();
    assert_eq!(person.world.wanted_model(), None, "asked once");
    assert!(person.message().unwrap().contains("no such file"));
    assert!(person.scene().models.is_empty() && person.scene().plates.len() > plates);
    // Its pedestal is carried all the same.
    let rim = rim_before(&person, 0);
    person.reach(LEFT, rim);
    person.press(LEFT, Button::Squeeze);
    person.reach(LEFT, rim + Vec3::X * 0.2);
    person.frame();
    person.release(LEFT, Button::Squeeze);
    assert!(person.world.document().models[0].place.position.x > 0.6);
}

#[test]
fn projects_keep_models_and_older_programs_read_those_without() {
    use ramus::world::project::{from_bytes, to_bytes};
    let person = with_models(3, true);
    let bytes = to_bytes(person.world.document());
    let text = String::from_utf8(bytes.clone()).unwrap();
    assert!(
        text.contains("\"version\": 3") && text.contains("\"linked\": true"),
        "{text}"
    );
    let again = from_bytes(&bytes).unwrap();
    assert_eq!(again, *person.world.document());
    assert_eq!(to_bytes(&again), bytes);
    let without = String::from_utf8(to_bytes(with_trunk(LEFT).world.document())).unwrap();
    assert!(without.contains("\"version\": 1"), "{without}");
    // An older version has no models, and no file has too many.
    let older = text.replace("\"version\": 3", "\"version\": 2");
    assert!(
        from_bytes(older.as_bytes())
            .unwrap_err()
            .to_string()
            .contains("no models")
    );
    let many = (0..=MOST_MODELS).map(|n| Model::new(n.to_string(), Unit::Metres, true, n));
    let edit = arrange(&person, many.collect(), false);
    let mut person = person;
    assert!(
        person
            .world
            .apply(edit)
            .unwrap_err()
            .to_string()
            .contains("at most 8 models")
    );
}

#[test]
fn the_scale_bar_and_the_box_are_drawn_with_it() {
    let mut person = with_models(1, false);
    let rods = |person: &Person| person.scene().rods;
    let edges = |person: &Person| {
        rods(person)
            .iter()
            .filter(|rod| rod.color == BOX_COLOR)
            .count()
    };
    let (before, signs) = (edges(&person), rods(&person).len());
    let mut models = person.world.document().models.to_vec();
    models[0].boxed = true;
    let edit = arrange(&person, models, false);
    person.world.apply(edit).unwrap();
    assert_eq!(edges(&person), before + 12);
    // Three sides of 10.0 mm: of each the digits and letters have more strokes than one.
    assert!(rods(&person).len() > signs + 12 + 3 * 20);
    // The bar: 2 of 10 units, so a fifth of the model's 0.4 m.
    let place = place(&person, 0);
    let bar = person
        .scene()
        .rods
        .iter()
        .filter(|rod| {
            rod.color[0] == rod.color[2]
                && rod.from.y == rod.to.y
                && (rod.from.z - place.z - 0.165).abs() < 1e-4
        })
        .map(|rod| rod.from.distance(rod.to))
        .sum::<f32>();
    assert!((bar - 0.08).abs() < 1e-4, "{bar}");
}

#[test]
fn a_plane_follows_the_left_hand_and_a_light_the_right_one() {
    use ramus::world::models::{Cut, Looking};
    for left_handed in [false, true] {
        let mut person = with_models(1, false);
        let mut room = person.world.room();
        room.left_handed = left_handed;
        person.world.set_room(room);
        let look = |person: &Person| person.scene().models[0].look;
        assert_eq!((look(&person).cut, look(&person).lamp), (None, None));
        let (cut, lamp) = (Cut::InHand, true);
        person.world.look(Looking { cut, lamp });
        let (cutting, lighting) = if left_handed {
            (RIGHT, LEFT)
        } else {
            (LEFT, RIGHT)
        };
        let at = Vec3::new(0.48, 1.0, -0.9);
        person.aim(cutting, at, Vec3::NEG_Z);
        person.reach(lighting, Vec3::new(0.2, 1.1, -0.4));
        person.frame();
        let plane = look(&person).cut.unwrap();
        assert!(
            plane.truncate().distance(Vec3::Z) < 1e-4,
            "towards the person"
        );
        assert!((plane.w - at.z).abs() < 1e-3);
        assert!(
            look(&person)
                .lamp
                .unwrap()
                .distance(Vec3::new(0.2, 1.1, -0.4))
                < 1e-3
        );
        // It stays, whatever the hand does, and goes when it is to.
        let cut = Cut::Stays;
        person.world.look(Looking { cut, lamp: false });
        person.aim(cutting, at + Vec3::X, Vec3::X);
        person.frame();
        assert_eq!((look(&person).cut, look(&person).lamp), (Some(plane), None));
        person.world.look(Looking::default());
        person.frame();
        assert_eq!(look(&person).cut, None);
    }
}
