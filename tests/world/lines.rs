//! Centerlines in the hands: wanted and given, dropped when they are out of date, pointed at, touched, chosen.

use std::sync::Arc;

use ramus::centerline::analysis::{Analysis, ModelFacts};
use ramus::centerline::{Centerline, Unreached, Why};
use ramus::mesh::endpoints::Endpoint;
use ramus::mesh::mend::Mend;
use ramus::mesh::unit::Unit;
use ramus::tree::{NO_PARENT, Node, Tree};
use ramus::world::branches::LIT;
use ramus::world::handles::Says;
use ramus::world::lines::{LineLook, Lines, Quantity};
use ramus::world::model::{LoadedModel, Model};
use ramus::world::panels::PanelId;
use ramus::world::scene::SurfaceLook;
use ramus::world::{DrawSettings, DrawTool};

use super::super::*;
use super::models::loaded;

/// A tetrahedron of ten units with a Y in it: a stem from (1, 1, 1) up to (1, 4, 1), and from there to the right and to the back.
fn tetrahedron() -> ramus::mesh::Mesh {
    ramus::mesh::Mesh {
        positions: vec![Vec3::ZERO, Vec3::X * 10.0, Vec3::Y * 10.0, Vec3::Z * 10.0],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..Default::default()
    }
}

/// Branches of the Y, as they are numbered.
const STEM: usize = 0;
const RIGHTWARDS: usize = 1;
const BACKWARDS: usize = 2;

fn found(loaded: &LoadedModel) -> Lines {
    let mut tree = Tree {
        letters: vec!["centerline".to_owned()],
        ..Tree::default()
    };
    for (parent, x, y, z) in [
        (NO_PARENT, 1.0, 1.0, 1.0),
        (0, 1.0, 4.0, 1.0),
        (1, 5.0, 4.0, 1.0),
        (1, 1.0, 4.0, -2.0),
    ] {
        tree.push(Node {
            parent,
            position: Vec3::new(x, y, z),
            radius: 0.5,
            letter: 0,
            order: 0,
            birth: 0,
        });
    }
    let centerline = Centerline {
        tree,
        unreached: vec![Unreached {
            index: 1,
            name: "lost".into(),
            point: glam::DVec3::new(0.0, 9.0, 0.0),
            why: Why::Gap {
                gap: 1.0,
                near: glam::DVec3::new(0.0, 8.0, 0.0),
            },
        }],
        ..Centerline::default()
    };
    let analysis = Analysis::new(ModelFacts::default(), &centerline, false, 0);
    let never = std::sync::atomic::AtomicBool::new(false);
    Lines::new(centerline, analysis, Vec::new(), &loaded.plain, &never).unwrap()
}

/// Brings centerlines and their colours, as far as they are wanted.
fn serve_lines(person: &mut Person) -> usize {
    let mut given = 0;
    while let Some((model, of)) = person.world.wanted_lines() {
        let model = model.clone();
        let lines = found(&of);
        person.world.give_lines(&model, Ok(lines));
        given += 1;
    }
    while let Some((model, lines)) = person.world.wanted_shading() {
        let model = model.clone();
        let by = model.lines.unwrap().by;
        person.world.give_shading(&model, lines.shaded(by));
    }
    person.frame();
    given
}

fn change(person: &mut Person, change: impl FnOnce(&mut Model)) {
    let document = person.world.document();
    let mut models = document.models.to_vec();
    change(&mut models[0]);
    let edit = Edit::Arrange {
        models,
        platform: document.platform,
        linked: document.linked,
    };
    person.world.apply(edit).unwrap();
}

/// Somebody before a model that shows its centerlines.
fn before_the_lines(tool: DrawTool) -> Person {
    let mut person = Person::new();
    let mut model = Model::new("a.ply".into(), Unit::Millimetres, false, 0);
    model.surface = Some(SurfaceLook::XRay);
    model.lines = Some(LineLook::default());
    let edit = Edit::Arrange {
        models: vec![model.clone()],
        platform: person.world.document().platform,
        linked: false,
    };
    person.world.apply(edit).unwrap();
    assert!(
        person.world.wanted_lines().is_none(),
        "not before it is read"
    );
    person.world.give_model(&model, Ok(loaded(tetrahedron())));
    assert_eq!(serve_lines(&mut person), 1);
    let settings = person.world.settings();
    person.world.set_settings(DrawSettings { tool, ..settings });
    person
}

/// A place from the mesh's origin, on the stage.
fn on_stage(person: &Person, place: Vec3) -> Vec3 {
    let model = &person.world.shown().models[0];
    let loaded = person.world.loaded_model(model).unwrap();
    loaded.stage_from_model(model).transform_point3(place)
}

fn lit(person: &Person) -> Option<usize> {
    person.world.lit_branch(&person.world.document().models[0])
}

/// Where the label beside a hand stands.
fn label(person: &Person) -> Vec3 {
    let mut scene = Scene::default();
    person.world.scene(&mut scene);
    let slot = PanelId::Label.slot();
    let panel = scene.panels.iter().find(|panel| panel.slot == slot);
    panel.unwrap().world_from_panel.translation.into()
}

/// The middles of what is drawn in the colour of what is lit.
fn lights(person: &Person) -> Vec<Vec3> {
    let mut scene = Scene::default();
    person.world.scene(&mut scene);
    let rods = scene.rods.iter().filter(|rod| rod.color == LIT);
    rods.map(|rod| rod.from.midpoint(rod.to)).collect()
}

const MIDDLES: [(usize, Vec3); 3] = [
    (STEM, Vec3::new(1.0, 2.5, 1.0)),
    (RIGHTWARDS, Vec3::new(3.5, 4.0, 1.0)),
    (BACKWARDS, Vec3::new(1.0, 4.0, -1.0)),
];

#[test]
fn a_branch_is_chosen_by_ray_and_by_touch_at_any_size_and_goes_out_again() {
    for size in [0.05, 0.4, 2.0, 40.0] {
        for hand in BOTH {
            let mut person = before_the_lines(DrawTool::Branch);
            change(&mut person, |model| model.place.scale = size);
            assert_eq!(serve_lines(&mut person), 0, "its place changes nothing");
            for (branch, place) in MIDDLES {
                let at = on_stage(&person, place);
                if branch == STEM {
                    person.reach(hand, at);
                } else {
                    let from = Vec3::new(0.1, 0.2, 1.0).normalize();
                    person.aim(hand, at + from * (0.3 + size * 0.2), -from);
                    person.frame();
                }
                let says = person.world.says();
                assert_eq!(says, Some(Says::Branch { model: 0, branch }), "{size} m");
                let aim = person.input.hands[hand].aim.position;
                assert!(label(&person).distance(aim) < 1.1, "it can be read");
                let before = person.world.history().undo_count();
                person.click(hand, Button::Trigger);
                assert_eq!(lit(&person), Some(branch));
                assert_eq!(person.world.history().undo_count(), before, "no edit");
                let lights = lights(&person);
                assert_eq!(lights.len(), 1, "a straight branch of two nodes");
                let ends = person.world.lines(&person.world.document().models[0]);
                let ends = ends.unwrap().unwrap().nodes_of(branch).len();
                assert_eq!(ends, 2);
                person.click(hand, Button::Trigger);
                assert_eq!(lit(&person), None, "pulled once more");
            }
            // Past it: it is told, and nothing is drawn.
            person.reach(hand, Vec3::new(0.0, 1.9, 0.3));
            person.click(hand, Button::Trigger);
            assert!(person.message().unwrap().contains("chooses branches"));
            assert!(person.world.document().sketch.is_empty());
        }
    }
}

#[test]
fn no_branch_is_meant_by_other_tools_nor_behind_a_surface_nor_where_it_is_cut_away() {
    let place = MIDDLES[1].1;
    let says = |person: &mut Person| {
        let at = on_stage(person, place);
        person.aim(RIGHT, at + Vec3::Z * 0.4, Vec3::NEG_Z);
        person.frame();
        person.world.says()
    };
    let chosen = Some(Says::Branch {
        model: 0,
        branch: RIGHTWARDS,
    });
    let mut person = before_the_lines(DrawTool::Draw);
    assert_eq!(says(&mut person), None);
    let mut person = before_the_lines(DrawTool::Branch);
    assert_eq!(says(&mut person), chosen);
    for surface in [SurfaceLook::Shaded, SurfaceLook::Matte] {
        change(&mut person, |model| model.surface = Some(surface));
        assert_eq!(says(&mut person), None);
        assert!(lights(&person).is_empty());
    }
    change(&mut person, |model| model.surface = None);
    assert_eq!(says(&mut person), chosen);
    // What lies before a plane is cut away: behind the branch it takes the branch along.
    use ramus::world::models::{Cut, Looking};
    let at = on_stage(&person, place);
    for (behind, expected) in [(-0.02, chosen), (0.02, None)] {
        person.world.look(Looking {
            cut: Cut::InHand,
            lamp: false,
        });
        person.reach(LEFT, at - Vec3::Z * behind);
        person.frame();
        person.world.look(Looking {
            cut: Cut::Stays,
            lamp: false,
        });
        person.input.hands[LEFT].tracked = false;
        assert_eq!(says(&mut person), expected, "{behind}");
        person.input.hands[LEFT].tracked = true;
    }
    // A mouse's ray means it, too, and its button uses it.
    let person = before_the_lines(DrawTool::Branch);
    let at = on_stage(&person, place);
    let met = person.world.met(at + Vec3::Z, Vec3::NEG_Z).unwrap();
    assert!(met.takes_trigger && met.place.distance(at) < 0.01);
}

#[test]
fn what_is_out_of_date_does_not_come_in_and_undo_finds_it_anew() {
    let wanted = |person: &Person| person.world.wanted_lines().is_some();
    let look = LineLook::default;
    let changes: [&dyn Fn(&mut Model); 5] = [
        &|model| model.mends = vec![Mend::Orient],
        &|model| model.lines = None,
        &|model| model.endpoints = Arc::new(vec![Endpoint::default()]),
        &|model| {
            model.lines = Some(LineLook {
                caps: true,
                ..look()
            });
        },
        &|model| {
            model.lines = Some(LineLook {
                bridge: Some(5),
                ..look()
            });
        },
    ];
    for (at, edit) in changes.into_iter().enumerate() {
        let mut person = before_the_lines(DrawTool::Branch);
        person.world.light_branch(0, Some(STEM));
        assert_eq!(lights(&person).len(), 1);
        let before = person.world.document().models[0].clone();
        let late = found(person.world.loaded_model(&before).unwrap());
        change(&mut person, edit);
        let now = person.world.document().models[0].clone();
        assert!(person.world.lines(&now).is_none(), "{at}");
        assert_eq!((lit(&person), lights(&person).len()), (None, 0), "{at}");
        // One that was on its way from before.
        assert!(!person.world.wants_lines(&before));
        person.world.give_lines(&before, Ok(late));
        person.world.give_lines(&before, Err("Too late.".into()));
        assert!(person.world.lines(&now).is_none() && person.message().is_none());
        // Mended otherwise it is read first.
        assert_eq!(wanted(&person), at >= 2);
        person.world.undo();
        assert!(
            person.world.lines(&before).is_none() && wanted(&person),
            "{at}"
        );
        assert_eq!(serve_lines(&mut person), 1);
        assert!(person.world.lines(&before).unwrap().is_ok());
    }
}

#[test]
fn why_there_are_none_is_told_until_it_is_tried_again() {
    let mut person = before_the_lines(DrawTool::Draw);
    change(&mut person, |model| {
        model.endpoints = Arc::new(vec![Endpoint::default()]);
    });
    let model = person.world.document().models[0].clone();
    let why = "a.ply: there is no source";
    person.world.give_lines(&model, Err(why.into()));
    assert_eq!(person.world.lines(&model).unwrap().err(), Some(why));
    assert!(person.world.wanted_lines().is_none(), "asked once");
    assert!(person.world.has_message());
    person.world.find_lines_again(0);
    assert!(person.world.wanted_lines().is_some());
    assert_eq!(serve_lines(&mut person), 1);
    person.world.find_lines_again(0);
    assert!(person.world.wanted_lines().is_none(), "what is there stays");
}

#[test]
fn other_colours_are_wanted_and_what_is_not_reached_is_marked() {
    let mut person = before_the_lines(DrawTool::Draw);
    let drawn = |person: &Person| {
        let mut scene = Scene::default();
        person.world.scene(&mut scene);
        scene
    };
    let plain = drawn(&person);
    assert_eq!(plain.models.len(), 2, "surface and line");
    change(&mut person, |model| {
        model.lines = Some(LineLook {
            by: Some(Quantity::Length),
            balls: true,
            ..LineLook::default()
        });
    });
    assert!(person.world.wanted_shading().is_some() && person.world.wanted_lines().is_none());
    let meanwhile = drawn(&person);
    assert_eq!(meanwhile.models[1].revision, plain.models[1].revision);
    serve_lines(&mut person);
    let coloured = drawn(&person);
    assert_eq!(coloured.models.len(), 3, "and balls");
    assert_ne!(coloured.models[1].revision, plain.models[1].revision);
    let model = &person.world.document().models[0];
    let range = person.world.shading(model).unwrap().range;
    assert_eq!(range, Some([3.0, 4.0]));
    // The gap is a ball, the target a cross.
    let gap = on_stage(&person, Vec3::Y * 8.0);
    let near = |at: Vec3, place: Vec3| at.distance(place) < 1e-4;
    assert!(coloured.balls.iter().any(|ball| near(ball.center, gap)));
    let lost = on_stage(&person, Vec3::Y * 9.0);
    let arms = coloured.rods.iter();
    let arms = arms.filter(|rod| near(rod.from.midpoint(rod.to), lost));
    assert_eq!(arms.count(), 3);
}
