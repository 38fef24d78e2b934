//! Planting: individuals are picked by their pictures, and a brush plants them; undone, kept, erased, and played again.

use std::path::Path;
use std::time::{Duration, Instant};

use glam::{Vec2, Vec3};
use ramus::app::picture::Picture;
use ramus::app::portrait;
use ramus::app::store::{Store, read_project};
use ramus::app::workshop::{Workshop, WorkshopParams};
use ramus::world::DrawTool;
use ramus::world::document::{Document, Edit};
use ramus::world::grove::{INDIVIDUALS, PLANTS_MOST};
use ramus::world::history::History;
use ramus::world::panels::PanelId;
use ramus::world::scene::PlacedModel;
use ramus::world::species::SPECIES;
use ramus::world::{World, project};

use super::pictures::{draw, save, views};
use super::visitor::{LEFT, RIGHT, Visitor};

/// Scrolls to a text and presses it.
fn press(visitor: &mut Visitor, text: &str) {
    visitor.scroll_to(RIGHT, PanelId::Bench, text);
    visitor.click(RIGHT, PanelId::Bench, text);
    visitor.frame();
}

fn open(project: &Path) -> Workshop {
    Workshop::new(Store::open(project).unwrap(), WorkshopParams::default()).unwrap()
}

/// Somebody with a small tree that has grown, and the brush in the hand.
fn gardener(mut visitor: Visitor) -> Visitor {
    visitor.draw_tree();
    for _ in 0..3 {
        visitor.click_nth(RIGHT, PanelId::Bench, "Grow", 2);
    }
    take_brush(&mut visitor);
    visitor
}

fn take_brush(visitor: &mut Visitor) {
    visitor.click(RIGHT, PanelId::Bench, "Draw");
    press(visitor, "Plant");
    visitor.rest(RIGHT);
    assert_eq!(visitor.workshop.world().settings().tool, DrawTool::Plant);
}

/// Points the right hand at a place on the ground, or above it.
fn aim(visitor: &mut Visitor, to: Vec3) {
    let held = &mut visitor.frame.hands[RIGHT];
    held.aim.position = Vec3::new(0.6, 1.3, -0.4);
    held.grip.position = held.aim.position;
    visitor.point(RIGHT, to);
    visitor.frame();
}

fn plant(visitor: &mut Visitor, x: f32, z: f32) {
    aim(visitor, Vec3::new(x, 0.0, z));
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
}

fn places(visitor: &Visitor) -> Vec<Vec2> {
    let plants = &visitor.document().grove.plants;
    plants.iter().map(|plant| plant.at).collect()
}

fn undo(visitor: &mut Visitor) {
    stick(visitor, -1.0);
}

fn stick(visitor: &mut Visitor, x: f32) {
    visitor.rest(LEFT);
    for x in [x, 0.0] {
        visitor.frame.hands[LEFT].stick.x = x;
        visitor.frame();
    }
}

fn message(visitor: &mut Visitor) -> String {
    let board = visitor.workshop.scene().board.clone().unwrap();
    board.content.message.clone().unwrap_or_default()
}

#[test]
fn an_individual_is_picked_by_its_picture() {
    let mut visitor = Visitor::with_tree();
    press(&mut visitor, "Species");
    press(&mut visitor, "Fern");
    let fern = visitor.document().clone();
    let seed = fern.sketch.habit.seed;
    let number = |more: u32| (seed + more).to_string();
    visitor.scroll_to(RIGHT, PanelId::Bench, "More");
    visitor.workshop.finish_previews();
    visitor.frame();
    // Five pictures, each with its seed; one is taken with one edit, and the others stay to be tried.
    press(&mut visitor, &number(3));
    let picked = visitor.document().clone();
    assert_eq!(*picked.sketch, fern.sketch.with_seed(seed + 3));
    assert!(visitor.says(PanelId::Bench, &format!("individual {}", seed + 3)));
    visitor.find(PanelId::Bench, &number(1));
    visitor.find(PanelId::Bench, &number(5));
    assert!(!visitor.workshop.is_busy(), "a seed alone is no other row");
    undo(&mut visitor);
    assert_eq!(*visitor.document(), fern);
    // The next ones.
    press(&mut visitor, "More");
    visitor.find(PanelId::Bench, &number(6));
    visitor.find(PanelId::Bench, &number(10));
    assert!(visitor.workshop.is_busy(), "they are being drawn");
    visitor.workshop.finish_previews();
    assert!(!visitor.workshop.is_busy());
    press(&mut visitor, &number(8));
    assert_eq!(visitor.document().sketch.habit.seed, seed + 8);
    // Another season is another row; a tab that nobody looks at draws none.
    press(&mut visitor, "Winter");
    assert!(visitor.workshop.is_busy());
    visitor.scroll_to(RIGHT, PanelId::Bench, "More");
    press(&mut visitor, "Draw");
    assert!(!visitor.workshop.is_busy());
}

#[test]
fn a_sketch_without_chance_says_why_all_are_the_same() {
    let mut visitor = Visitor::with_tree();
    press(&mut visitor, "Species");
    assert!(
        visitor.says(PanelId::Bench, "Let the tree grow"),
        "at step 0"
    );
    visitor.frame.hands[RIGHT].lower = true;
    visitor.frame();
    visitor.frame.hands[RIGHT].lower = false;
    visitor.frame();
    assert_eq!(visitor.document().step, 1);
    visitor.workshop.finish_previews();
    visitor.frame();
    let told = "Nothing in this sketch is left to chance";
    visitor.scroll_to(RIGHT, PanelId::Bench, "Plant them");
    assert!(visitor.says(PanelId::Bench, told));
}

#[test]
fn pictures_hold_up_no_frame() {
    let mut visitor = Visitor::with_tree();
    press(&mut visitor, "Species");
    press(&mut visitor, "Maple");
    visitor.workshop.finish_tree();
    visitor.scroll_to(RIGHT, PanelId::Bench, "More");
    press(&mut visitor, "More");
    let began = Instant::now();
    let mut slowest = Duration::ZERO;
    let mut frames = 0_u32;
    while visitor.workshop.is_busy() {
        let frame = Instant::now();
        visitor.frame.time += 1.0 / 90.0;
        visitor.workshop.update(&visitor.frame);
        slowest = slowest.max(frame.elapsed());
        frames += 1;
        std::thread::sleep(Duration::from_millis(2));
    }
    let all = began.elapsed();
    eprintln!("five pictures in {all:?}, {frames} frames meanwhile, the slowest {slowest:?}");
    assert!(frames > 20, "{frames}");
    assert!(slowest * 4 < all, "{slowest:?} of {all:?}");
}

#[test]
fn three_are_planted_undone_kept_and_found_again() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wood.ramus");
    let mut visitor = gardener(Visitor::at(open(&file)));
    for (x, z) in [(2.0, -5.0), (4.0, -7.0), (-2.0, -8.0)] {
        plant(&mut visitor, x, z);
    }
    let stand = places(&visitor);
    let expected = [(2.0, -5.0), (4.0, -7.0), (-2.0, -8.0)].map(Vec2::from);
    assert_eq!(stand.len(), 3);
    for (is, wanted) in stand.iter().zip(expected) {
        assert!(is.distance(wanted) < 0.01, "{is} {wanted}");
    }
    let plants = visitor.document().grove.plants.clone();
    assert!(plants.iter().all(|one| one.individual < INDIVIDUALS));
    assert!(plants.iter().all(|one| (0.8..=1.2).contains(&one.size)));
    assert!(plants[0].yaw_deg != plants[1].yaw_deg && plants[0].size != plants[1].size);
    // They stand there, at full size, beside the tree.
    let models = visitor.workshop.scene().models.clone();
    assert_eq!(models.len(), 3);
    let is_at = |model: &PlacedModel, at: Vec2| {
        let foot = model.world_from_model.translation;
        Vec2::new(foot.x, foot.z).distance(at) < 0.01 && foot.y == 0.0
    };
    for at in expected {
        let here = models.iter().filter(|model| is_at(model, at));
        let here: Vec<_> = here.collect();
        assert!(here.len() == 1 && here[0].display.high.y > 0.3, "{at}");
    }
    // Each is one step of undo.
    undo(&mut visitor);
    assert_eq!(places(&visitor), stand[..2]);
    assert_eq!(visitor.workshop.scene().models.len(), 2);
    stick(&mut visitor, 1.0);
    assert_eq!(places(&visitor), stand);
    // A session that is killed comes back with all three, and so does one that is closed.
    let made = visitor.document().clone();
    drop(visitor);
    assert!(Store::has_journal(&file));
    let again = Visitor::at(open(&file));
    assert_eq!(*again.document(), made);
    again.workshop.close().unwrap();
    assert_eq!(read_project(&file).unwrap(), made);
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.contains("\"version\": 6") && text.contains("\"plants\": ["));
}

#[test]
fn a_pull_that_is_moved_plants_a_row_at_the_spacing_and_the_grip_uproots() {
    let mut visitor = gardener(Visitor::new());
    let edits = visitor.workshop.edits();
    aim(&mut visitor, Vec3::new(-6.0, 0.0, -9.0));
    visitor.pull(RIGHT, true);
    // Over twelve metres at four: the place of the pull and three more, however many frames there are.
    for n in 0..=61_u8 {
        aim(
            &mut visitor,
            Vec3::new(-6.0 + 0.2 * f32::from(n), 0.0, -9.0),
        );
    }
    let seen = visitor.workshop.world().shown().grove.plants.len();
    assert_eq!(
        (seen, places(&visitor).len()),
        (4, 0),
        "seen, and no edit yet"
    );
    visitor.pull(RIGHT, false);
    let row = places(&visitor);
    assert_eq!((row.len(), visitor.workshop.edits()), (4, edits + 1));
    assert!(
        row.windows(2)
            .all(|pair| (pair[0].distance(pair[1]) - 4.0).abs() < 0.02)
    );
    // The grip takes the one away that the hand points at, by its trunk, and what it passes then.
    aim(&mut visitor, Vec3::new(row[1].x, 0.4, row[1].y));
    visitor.grip(RIGHT, true);
    for n in 0..=20_u8 {
        let to = row[1].lerp(row[2], f32::from(n) / 20.0);
        aim(&mut visitor, Vec3::new(to.x, 0.0, to.y));
    }
    visitor.grip(RIGHT, false);
    assert_eq!(places(&visitor), [row[0], row[3]]);
    assert_eq!(
        visitor.workshop.edits(),
        edits + 2,
        "one movement, one edit"
    );
    undo(&mut visitor);
    assert_eq!(places(&visitor), row);
    // The eraser does so with the trigger.
    visitor.click(LEFT, PanelId::Bench, "Eraser");
    aim(&mut visitor, Vec3::new(row[3].x, 0.3, row[3].y));
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    assert_eq!(places(&visitor), row[..3]);
    // All of them, when it is asked twice.
    visitor.click(LEFT, PanelId::Bench, "Plant");
    press(&mut visitor, "Uproot all");
    assert_eq!(places(&visitor).len(), 3, "once is not enough");
    press(&mut visitor, "Really uproot all");
    assert!(places(&visitor).is_empty());
}

/// While one hand holds what it has uprooted, the other uproots what it points at; and a trunk is met high above the ground, whether its mesh has come or not.
#[test]
fn two_hands_uproot_what_each_points_at() {
    let mut visitor = gardener(Visitor::new());
    for x in [-6.0, 0.0, 6.0] {
        plant(&mut visitor, x, -9.0);
    }
    let before = places(&visitor);
    assert_eq!(before.len(), 3);
    let left = &mut visitor.frame.hands[LEFT];
    // Before the bench, which stands to the left.
    left.aim.position = Vec3::new(0.4, 1.4, -0.5);
    left.grip.position = left.aim.position;
    let [size_left, size_right] = [1, 2].map(|at| visitor.document().grove.plants[at].size);
    visitor.point(LEFT, Vec3::new(before[1].x, 1.6 * size_left, before[1].y));
    visitor.grip(LEFT, true);
    aim(
        &mut visitor,
        Vec3::new(before[2].x, 1.6 * size_right, before[2].y),
    );
    visitor.grip(RIGHT, true);
    visitor.grip(RIGHT, false);
    visitor.grip(LEFT, false);
    assert_eq!(places(&visitor), [before[0]]);
}

#[test]
fn the_platform_is_the_ground_in_miniature() {
    let mut visitor = gardener(Visitor::new());
    // A hand's breadth beside the root, on the top: the platform is one to four, the tree twice the sketch.
    let root = Vec3::new(0.0, 0.9, -0.55);
    visitor.tip_to_along(RIGHT, root + Vec3::new(0.1, 0.0, 0.1), Vec3::NEG_Y);
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    let [at] = places(&visitor)[..] else {
        panic!("one tree")
    };
    assert!(at.distance(Vec2::new(0.8, -6.0 + 0.8)) < 0.01, "{at}");
    // It is seen there, too, and uprooted there.
    let near = |visitor: &mut Visitor| {
        let place = root + Vec3::new(0.1, 0.0, 0.1);
        let scene = visitor.workshop.scene();
        scene.rods.iter().any(|rod| rod.from.distance(place) < 1e-3)
    };
    assert!(near(&mut visitor));
    visitor.grip(RIGHT, true);
    visitor.grip(RIGHT, false);
    assert!(places(&visitor).is_empty() && !near(&mut visitor));
}

#[test]
fn planted_trees_follow_the_tree_until_another_takes_its_place() {
    let mut visitor = gardener(Visitor::new());
    plant(&mut visitor, 3.0, -6.0);
    let height = |visitor: &mut Visitor| visitor.workshop.scene().models[0].display.high.y;
    let before = height(&mut visitor);
    visitor.rest(RIGHT);
    for _ in 0..2 {
        visitor.frame.hands[RIGHT].lower = true;
        visitor.frame();
        visitor.frame.hands[RIGHT].lower = false;
        visitor.frame();
    }
    let grown = height(&mut visitor);
    assert!(grown > before + 0.1, "{before} {grown}");
    // A species on the platform: the planted tree stays, and the brush plants the species beside it.
    press(&mut visitor, "Species");
    press(&mut visitor, "Fern");
    visitor.workshop.finish_tree();
    visitor.frame();
    assert_eq!(height(&mut visitor), grown);
    plant(&mut visitor, -3.0, -6.0);
    let grove = visitor.document().grove.clone();
    assert_eq!((grove.kinds.len(), grove.plants.len()), (1, 2));
    let models = visitor.workshop.scene().models.clone();
    assert!(models[0].display.mesh != models[1].display.mesh);
    // Kept and read again as it is.
    let bytes = project::to_bytes(visitor.document());
    assert_eq!(project::from_bytes(&bytes).unwrap(), *visitor.document());
}

#[test]
fn what_cannot_be_planted_is_said_in_one_sentence() {
    let mut visitor = Visitor::new();
    take_brush(&mut visitor);
    plant(&mut visitor, 2.0, -5.0);
    let told = message(&mut visitor);
    assert!(told.contains("nothing to plant yet"), "{told}");
    aim(&mut visitor, Vec3::new(0.6, 9.0, -1.0));
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    let told = message(&mut visitor);
    assert!(told.contains("on the ground"), "{told}");
    assert!(
        visitor.document().sketch.is_empty(),
        "the brush draws nothing"
    );

    // A stage that is full takes no more, by pulls or by a row.
    let full = full_wood();
    let mut visitor = Visitor::at(Workshop::unsaved(World::new(History::new(full))).unwrap());
    take_brush(&mut visitor);
    plant(&mut visitor, 2.0, -5.0);
    assert_eq!(places(&visitor).len(), PLANTS_MOST);
    let told = message(&mut visitor);
    assert!(
        told.contains("256 trees are planted") && told.contains("uproot some"),
        "{told}"
    );
}

/// As many planted ferns as there may be, in rows.
fn full_wood() -> Document {
    let fern = SPECIES.iter().find(|one| one.name == "fern").unwrap();
    let mut document = fern.document();
    let mut trees = Vec::new();
    for n in 0..u16::try_from(PLANTS_MOST).unwrap() {
        let (row, place) = (n / 16, n % 16);
        trees.push(ramus::world::grove::Plant {
            at: Vec2::new(f32::from(place) * 2.0 - 15.0, -4.0 - 2.0 * f32::from(row)),
            yaw_deg: f64::from(n),
            size: 1.0,
            individual: u8::try_from(n % 8).unwrap(),
            kind: None,
        });
    }
    document = document.after(&Edit::Plant { trees }).unwrap();
    document
}

#[test]
fn a_session_that_is_played_again_plants_the_same() {
    let mut visitor = gardener(Visitor::new());
    aim(&mut visitor, Vec3::new(-6.0, 0.0, -9.0));
    visitor.pull(RIGHT, true);
    for n in 0..=31_u8 {
        aim(
            &mut visitor,
            Vec3::new(-6.0 + 0.4 * f32::from(n), 0.0, -9.0),
        );
    }
    visitor.pull(RIGHT, false);
    plant(&mut visitor, 3.0, -5.0);
    // The hand is lost in the middle of a row: what was planted stays.
    aim(&mut visitor, Vec3::new(-6.0, 0.0, -13.0));
    visitor.pull(RIGHT, true);
    aim(&mut visitor, Vec3::new(-1.9, 0.0, -13.0));
    visitor.frame.hands[RIGHT].tracked = false;
    visitor.frame();
    assert_eq!(places(&visitor).len(), 7);
    let mut again = Visitor::blank();
    again.workshop.unseen();
    for frame in &visitor.frames {
        again.workshop.update(frame);
    }
    assert_eq!(again.document(), visitor.document());
}

/// The tab with its row, a planted stage, and the brush's settings, as they are looked at.
#[test]
fn the_row_and_a_planted_stage_are_seen() {
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 720, 720).unwrap();
    let mut visitor = Visitor::with_tree();
    press(&mut visitor, "Species");
    press(&mut visitor, "Apple");
    visitor.scroll_to(RIGHT, PanelId::Bench, "branches spread");
    visitor.workshop.finish_previews();
    visitor.frame();
    let center = visitor.center(PanelId::Bench);
    let near = views(center + visitor.normal(PanelId::Bench) * 0.62, center);
    let image = draw(&mut visitor, &mut picture, &near);
    save(&image, "bench-individuals.png");
    let green = |image: &image::RgbaImage| {
        let leafy = |p: &&image::Rgba<u8>| {
            p.0[1] > p.0[0].saturating_add(12) && p.0[1] > p.0[2].saturating_add(12)
        };
        image.pixels().filter(leafy).count()
    };
    let row = green(&image);
    assert!(row > 1000, "{row} green pixels in the row");
    take_brush(&mut visitor);
    let image = draw(&mut visitor, &mut picture, &near);
    save(&image, "bench-plant.png");
    for (x, z) in [
        (-5.0, -8.0),
        (4.5, -9.0),
        (-9.0, -14.0),
        (0.5, -14.0),
        (9.0, -15.0),
        (-3.0, -20.0),
        (5.0, -22.0),
    ] {
        plant(&mut visitor, x, z);
    }
    press(&mut visitor, "Species");
    press(&mut visitor, "Birch");
    for (x, z) in [(-8.0, -9.5), (7.0, -12.0), (-1.5, -17.0), (12.0, -20.0)] {
        plant(&mut visitor, x, z);
    }
    visitor.workshop.finish_tree();
    for model in &visitor.workshop.scene().models {
        let triangles = model.display.mesh.triangles.len();
        assert!((5_000..=60_000).contains(&triangles), "{triangles}");
    }
    aim(&mut visitor, Vec3::new(2.2, 0.0, -4.6));
    visitor.wait(1.0);
    let stand = views(Vec3::new(0.0, 1.7, 1.2), Vec3::new(0.0, 2.6, -8.0));
    let image = draw(&mut visitor, &mut picture, &stand);
    save(&image, "planted.png");
    let leafy = green(&image);
    assert!(leafy > 20_000, "{leafy} pixels of leaves");
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}
