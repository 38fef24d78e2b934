//! A warm frame of the world allocates nothing.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that fails shows the line"
)]

mod counting;
mod person;

use counting::allocations;
use glam::Vec3;
use person::{Button, LEFT, Person, RIGHT};
use ramus::{sketch::Letter, world::scene::Scene};

fn counted(act: impl FnOnce()) -> u64 {
    let before = allocations();
    act();
    allocations() - before
}

#[test]
fn a_warm_frame_allocates_nothing() {
    assert!(
        counted(|| drop(std::hint::black_box(Box::new(1_u8)))) > 0,
        "the counter counts"
    );
    let mut person = Person::new();
    let trunk: Vec<Vec3> = (1..=6_u8).map(|n| Vec3::Y * 0.3 * f32::from(n)).collect();
    person.draw(RIGHT, &trunk);
    for _ in 0..4 {
        person.click(RIGHT, Button::Lower);
    }
    let node = person.node(Letter::TRUNK, 3);
    person.world.show_message("Hello.".into());
    let mut scene = Scene::default();
    // Hands that hover, point at the rim, leave, and come back untracked; the tree still growing.
    let play = |person: &mut Person, scene: &mut Scene| {
        for n in 0..40_u8 {
            let aside = Vec3::X * 0.01 * f32::from(n % 20);
            person.aim(LEFT, node + aside, Vec3::NEG_Z);
            person.aim(
                RIGHT,
                node + Vec3::new(0.0, 0.3, 0.2) - aside,
                Vec3::new(0.0, -1.0, -0.4),
            );
            person.input.hands[RIGHT].tracked = n % 8 != 0;
            person.input.time += 0.01;
            person.world.update(&person.input);
            person.world.scene(scene);
        }
    };
    play(&mut person, &mut scene);
    let warm = counted(|| play(&mut person, &mut scene));
    assert_eq!(warm, 0, "allocations in 40 warm frames");
}

#[test]
fn a_stroke_in_a_hand_that_rests_allocates_nothing() {
    let mut person = Person::new();
    let start = person.node(Letter::TRUNK, 0) + Vec3::Y * 0.1;
    person.reach(RIGHT, start);
    person.press(RIGHT, Button::Trigger);
    let mut scene = Scene::default();
    // Pulled and in place at first, then with a stroke.
    for far in [0.0, 0.2] {
        for n in 0..=20_u8 {
            person.reach(RIGHT, start + Vec3::X * far * f32::from(n) / 20.0);
        }
        person.world.scene(&mut scene);
        let warm = counted(|| {
            for _ in 0..40 {
                person.input.time += 0.01;
                person.world.update(&person.input);
                person.world.scene(&mut scene);
            }
        });
        assert_eq!(warm, 0, "allocations in 40 frames of rest, {far} m on");
    }
    let shown = person.world.shown().sketch.strokes[0].segments();
    assert!(shown > 4, "{shown}");
}

#[test]
fn models_on_the_stage_allocate_nothing() {
    use std::sync::{Arc, atomic::AtomicBool};

    use ramus::mesh::{Mesh, endpoints::Endpoint, pick::Picker, surface::Surface, unit::Unit};
    use ramus::world::document::Edit;
    use ramus::world::marks::Measuring;
    use ramus::world::model::{LoadedModel, Model};
    use ramus::world::models::{Cut, Looking};
    use ramus::world::{DrawSettings, DrawTool};
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..Mesh::default()
    };
    let never = AtomicBool::new(false);
    let picker = Picker::new(Arc::new(mesh), &never, &mut |_, _| ()).unwrap();
    let loaded = LoadedModel::new(Surface::new(picker, &never).unwrap(), &never).unwrap();
    let mut person = Person::new();
    let mut model = Model::new("corner.ply".into(), Unit::Millimetres, true, 0);
    model.boxed = true;
    model.endpoints = Arc::new(vec![Endpoint::default(); 3]);
    let gone = Model::new("gone.ply".into(), Unit::Metres, true, 1);
    let edit = Edit::Arrange {
        models: vec![model.clone(), gone.clone()],
        platform: person.world.document().platform,
        linked: true,
    };
    person.world.apply(edit).unwrap();
    person.world.give_model(&model, Ok(loaded));
    person
        .world
        .give_model(&gone, Err("gone.ply: no such file".into()));
    // The trigger measures: places under the hands are shown.
    let tool = DrawTool::Measure(Measuring::Along);
    let settings = person.world.settings();
    person.world.set_settings(DrawSettings { tool, ..settings });
    let cut = Cut::InHand;
    person.world.look(Looking { cut, lamp: true });
    let place = model.place.position;
    let mut scene = Scene::default();
    // Hands that point at the rim, at the model and past it.
    let play = |person: &mut Person, scene: &mut Scene| {
        for n in 0..40_u8 {
            let up = Vec3::Y * 0.015 * f32::from(n % 20);
            person.aim(RIGHT, place + up + Vec3::Z * 0.4, Vec3::NEG_Z);
            person.aim(LEFT, place + up, Vec3::NEG_Y);
            person.input.time += 0.01;
            person.world.update(&person.input);
            person.world.scene(scene);
            assert!(person.world.wanted_model().is_none());
        }
    };
    play(&mut person, &mut scene);
    assert_eq!(scene.models.len(), 1);
    let warm = counted(|| play(&mut person, &mut scene));
    assert_eq!(warm, 0, "allocations in 40 warm frames");
}

#[test]
fn centerlines_and_a_branch_that_is_lit_allocate_nothing() {
    use std::sync::{Arc, atomic::AtomicBool};

    use ramus::centerline::Centerline;
    use ramus::centerline::analysis::{Analysis, ModelFacts};
    use ramus::mesh::{Mesh, pick::Picker, surface::Surface, unit::Unit};
    use ramus::tree::{NO_PARENT, Node, Tree};
    use ramus::world::document::Edit;
    use ramus::world::lines::{LineLook, Lines, Quantity};
    use ramus::world::model::{LoadedModel, Model};
    use ramus::world::scene::SurfaceLook;
    use ramus::world::{DrawSettings, DrawTool};
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..Mesh::default()
    };
    let never = AtomicBool::new(false);
    let picker = Picker::new(Arc::new(mesh), &never, &mut |_, _| ()).unwrap();
    let loaded = LoadedModel::new(Surface::new(picker, &never).unwrap(), &never).unwrap();
    // A line of 600 nodes, more than a lit branch has rods, and two tips.
    let mut tree = Tree {
        letters: vec![String::new()],
        ..Tree::default()
    };
    for n in 0..602_u32 {
        let (parent, up) = match n {
            0 => (NO_PARENT, 0.0),
            601 => (599, 0.8),
            n => (n - 1, n as f32 * 0.001),
        };
        let position = Vec3::new(0.2, up, 0.2);
        tree.push(Node {
            parent,
            position,
            radius: 0.05,
            letter: 0,
            order: 0,
            birth: 0,
        });
    }
    let centerline = Centerline {
        tree,
        ..Centerline::default()
    };
    let analysis = Analysis::new(ModelFacts::default(), &centerline, false, 0);
    let lines = Lines::new(centerline, analysis, Vec::new(), &loaded.plain, &never).unwrap();
    let mut person = Person::new();
    let mut model = Model::new("corner.ply".into(), Unit::Millimetres, false, 0);
    model.surface = Some(SurfaceLook::XRay);
    let by = Some(Quantity::RadiusHere);
    model.lines = Some(LineLook {
        by,
        balls: true,
        ..LineLook::default()
    });
    let edit = Edit::Arrange {
        models: vec![model.clone()],
        platform: person.world.document().platform,
        linked: false,
    };
    person.world.apply(edit).unwrap();
    person.world.give_model(&model, Ok(loaded));
    person.world.give_lines(&model, Ok(lines));
    let shading = person.world.wanted_shading().unwrap().1.shaded(by);
    person.world.give_shading(&model, shading);
    person.world.light_branch(0, Some(0));
    let tool = DrawTool::Branch;
    let settings = person.world.settings();
    person.world.set_settings(DrawSettings { tool, ..settings });
    let place = model.place.position;
    let mut scene = Scene::default();
    let mut met = 0;
    // Hands that point at the line and past it.
    let mut play = |person: &mut Person, scene: &mut Scene| {
        for n in 0..40_u8 {
            let up = Vec3::Y * 0.015 * f32::from(n % 20);
            let aside = Vec3::X * (0.4 * 0.2 - 0.2 + 0.01 * f32::from(n % 4));
            person.aim(RIGHT, place + up + aside + Vec3::Z * 0.4, Vec3::NEG_Z);
            person.aim(LEFT, place + up, Vec3::NEG_Y);
            person.input.time += 0.01;
            person.world.update(&person.input);
            person.world.scene(scene);
            met += usize::from(person.world.says().is_some());
            assert!(person.world.wanted_lines().is_none());
            assert!(person.world.wanted_shading().is_none());
        }
    };
    play(&mut person, &mut scene);
    assert_eq!(scene.models.len(), 3);
    let warm = counted(|| play(&mut person, &mut scene));
    assert_eq!(warm, 0, "allocations in 40 warm frames");
    assert!(met > 10, "the line is met: {met}");
}
