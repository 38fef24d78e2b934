//! Species on the bench: one is begun with, grows, is set otherwise, wears another season, and is undone; one's own stand beside them.

use std::path::Path;
use std::process::Command;

use image::RgbImage;
use ramus::app::picture::Picture;
use ramus::app::portrait;
use ramus::app::store::Store;
use ramus::app::workshop::{Workshop, WorkshopParams};
use ramus::sketch::habit::Habit;
use ramus::tree::bark::Bark;
use ramus::tree::foliage::Season;
use ramus::ui::Recent;
use ramus::world::World;
use ramus::world::document::Edit;
use ramus::world::history::History;
use ramus::world::panels::PanelId;
use ramus::world::scene::{PlacedTree, Scene};
use ramus::world::species::SPECIES;

use glam::{Vec2, Vec3};

use super::guide::compare;
use super::pictures::{draw, save, views};
use super::visitor::{RIGHT, Visitor};

/// Scrolls to a text and presses it; what it makes is grown.
fn press(visitor: &mut Visitor, text: &str) {
    visitor.scroll_to(RIGHT, PanelId::Bench, text);
    visitor.click(RIGHT, PanelId::Bench, text);
    visitor.workshop.finish_tree();
    visitor.frame();
}

/// The tree on the stage.
fn tree(visitor: &Visitor) -> PlacedTree {
    let mut scene = Scene::default();
    visitor.workshop.world().scene(&mut scene);
    scene.tree.unwrap()
}

/// Its leaves.
fn leaves(visitor: &Visitor) -> usize {
    tree(visitor).organs.placed.len()
}

#[test]
fn a_species_is_begun_with_set_otherwise_and_undone() {
    let mut visitor = Visitor::with_tree();
    let drawn = visitor.document().clone();
    press(&mut visitor, "Species");
    press(&mut visitor, "Oak");
    let oak = visitor.document().clone();
    assert_eq!(oak.sketch.habit.bark, Some(Bark::Oak));
    assert!(oak.step > 10 && oak.platform == drawn.platform);
    visitor.wait(2.0);
    let summer = leaves(&visitor);
    assert!(summer > 10_000, "{summer} leaves");
    let before = tree(&visitor).tree;

    // Another individual, another season, other bark: one edit each.
    press(&mut visitor, "Another");
    assert_eq!(
        visitor.document().sketch.habit.seed,
        oak.sketch.habit.seed + 1
    );
    let after = tree(&visitor).tree;
    assert_ne!(after.position, before.position);
    press(&mut visitor, "Winter");
    assert_eq!(visitor.document().sketch.habit.season, Season::Winter);
    assert_eq!(leaves(&visitor), 0, "an oak is bare in winter");
    press(&mut visitor, "birch");
    assert_eq!(visitor.document().sketch.habit.bark, Some(Bark::Birch));
    press(&mut visitor, "+ needles");
    assert_eq!(visitor.document().sketch.habit.bears.len(), 2);
    assert!(leaves(&visitor) > 1000, "needles stay");

    // A law by its slider: seen at once, one edit, in the grammar.
    let edits = visitor.workshop.edits();
    visitor.scroll_to(RIGHT, PanelId::Bench, "they hang");
    let row = visitor.find(PanelId::Bench, "they hang") + Vec2::new(0.0, 0.04);
    visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.06, row.y));
    visitor.pull(RIGHT, true);
    visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.10, row.y));
    visitor.frame();
    visitor.pull(RIGHT, false);
    visitor.frame();
    assert_eq!(visitor.workshop.edits(), edits + 1);
    let gravity = visitor.document().sketch.habit.gravity;
    assert!(gravity > 0.0 && gravity <= 1.0, "{gravity}");
    let text = visitor.document().sketch.grammar_text();
    assert!(
        text.contains(&format!("const gravity = {gravity}")),
        "{text}"
    );

    visitor.rest(RIGHT);
    for _ in 0..6 {
        for stick in [-1.0, 0.0] {
            visitor.frame.hands[RIGHT].stick.x = stick;
            visitor.frame();
        }
    }
    assert_eq!(*visitor.document(), drawn, "all of it is undone");
}

#[test]
fn ones_own_projects_stand_beside_the_species() {
    let folder = tempfile::tempdir().unwrap();
    let [oak, elm] = ["mine", "elm"].map(|name| folder.path().join(format!("{name}.ramus")));
    let open = |project: &Path| {
        Workshop::new(Store::open(project).unwrap(), WorkshopParams::default()).unwrap()
    };
    let mut drawn = Visitor::at(open(&elm));
    drawn.draw_tree();
    let strokes = drawn.document().sketch.strokes.clone();
    drawn.workshop.close().unwrap();
    let mut visitor = Visitor::at(open(&oak));
    let broken = folder.path().join("broken.ramus");
    std::fs::write(&broken, "{").unwrap();
    let recent = |project: &Path| Recent {
        project: project.to_owned(),
        picture: None,
    };
    visitor.workshop.offer(vec![recent(&broken), recent(&elm)]);
    press(&mut visitor, "Species");
    press(&mut visitor, "broken");
    assert!(visitor.document().sketch.is_empty(), "nothing was taken");
    press(&mut visitor, "elm");
    assert_eq!(visitor.document().sketch.strokes, strokes);
    assert_eq!(
        visitor.workshop.project(),
        Some(&*oak),
        "it is the same project still"
    );
}

/// The tab as it is looked at, and the tree that was chosen behind it.
#[test]
fn the_tab_of_species_is_readable_and_its_tree_stands_there() {
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 720, 720).unwrap();
    let mut visitor = Visitor::with_tree();
    press(&mut visitor, "Species");
    let center = visitor.center(PanelId::Bench);
    let near = views(center + visitor.normal(PanelId::Bench) * 0.62, center);
    let image = draw(&mut visitor, &mut picture, &near);
    save(&image, "bench-species.png");
    // Eight pictures of green trees on paper.
    let green = image
        .pixels()
        .filter(|p| p.0[1] > p.0[0].saturating_add(12) && p.0[1] > p.0[2].saturating_add(12))
        .count();
    assert!(green > 1500, "{green} green pixels");
    press(&mut visitor, "Maple");
    visitor.wait(2.0);
    let stand = views(Vec3::new(0.0, 1.6, 0.6), Vec3::new(0.0, 3.0, -5.0));
    let image = draw(&mut visitor, &mut picture, &stand);
    save(&image, "species-stage.png");
    let leafy = image
        .pixels()
        .filter(|p| p.0[1] > p.0[0].saturating_add(20) && p.0[1] > p.0[2].saturating_add(20))
        .count();
    assert!(leafy > 3000, "{leafy} pixels of leaves");
    for _ in 0..300 {
        let (_, size) = visitor.place(PanelId::Bench);
        visitor.point_on(RIGHT, PanelId::Bench, size * 0.5);
        visitor.frame.hands[RIGHT].stick.y = -1.0;
        visitor.frame();
    }
    visitor.rest(RIGHT);
    let end = draw(&mut visitor, &mut picture, &near);
    save(&end, "bench-species-end.png");
    press(&mut visitor, "Autumn");
    visitor.wait(1.0);
    let image = draw(&mut visitor, &mut picture, &stand);
    save(&image, "species-autumn.png");
    let red = image
        .pixels()
        .filter(|p| p.0[0] > p.0[1].saturating_add(30))
        .count();
    assert!(red > 2000, "{red} red pixels");
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}

/// Laws that a tree began without: each by its slider is one edit, stands in the grammar, and is undone.
#[test]
fn lines_end_and_ends_keep_away_by_sliders() {
    let mut visitor = Visitor::with_tree();
    let drawn = visitor.document().clone();
    press(&mut visitor, "Species");
    // With what stands below it, since the slider is below its label.
    for (label, below, law, line) in [
        (
            "lines end after segments",
            "longest branch, of its line",
            7,
            "const length = ",
        ),
        (
            "ends die nearer to wood than",
            "Summer",
            10,
            "const room = ",
        ),
    ] {
        let edits = visitor.workshop.edits();
        visitor.scroll_to(RIGHT, PanelId::Bench, below);
        let row = visitor.find(PanelId::Bench, label) + Vec2::new(0.0, 0.04);
        visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.06, row.y));
        visitor.pull(RIGHT, true);
        visitor.point_on(RIGHT, PanelId::Bench, Vec2::new(0.10, row.y));
        visitor.frame();
        visitor.pull(RIGHT, false);
        visitor.frame();
        assert_eq!(visitor.workshop.edits(), edits + 1, "{label}");
        let sketch = visitor.document().sketch.clone();
        assert!(sketch.habit.law(law) > 0.0, "{label}");
        assert!(sketch.grammar_text().contains(line), "{label}");
        visitor.rest(RIGHT);
        for stick in [-1.0, 0.0] {
            visitor.frame.hands[RIGHT].stick.x = stick;
            visitor.frame();
        }
        assert_eq!(*visitor.document(), drawn, "{label}: undone");
    }
}

/// What no twig bears, and what would stand in the dark, is said below its name, and only there.
#[test]
fn what_a_tree_does_not_bear_is_said_below_its_name() {
    let mut history = History::default();
    history.apply(SPECIES[0].edit()).unwrap();
    let mut habit = Habit::clone(&history.committed().sketch.habit);
    habit.bears = [
        "oak order 99",
        "oak",
        "birch size 100 every 0.01 light 1",
        "fruit",
    ]
    .map(str::to_owned)
    .to_vec();
    let to = Box::new(habit);
    history.apply(Edit::SetHabit { to }).unwrap();
    let mut visitor = Visitor::at(Workshop::unsaved(World::new(history)).unwrap());
    press(&mut visitor, "Species");
    let [twigs, dark] = [
        "none: no twig bears any",
        "none: all would stand in the dark",
    ];
    for (name, says) in [("oak", twigs), ("birch", dark)] {
        visitor.scroll_to(RIGHT, PanelId::Bench, says);
        let texts: Vec<&str> = visitor.workshop.texts(PanelId::Bench).collect();
        let at = texts.iter().position(|text| *text == says).unwrap();
        assert_eq!(texts[at - 2], name, "{texts:?}");
        assert_eq!(texts.iter().filter(|text| **text == says).count(), 1);
    }
}

/// The guide's pictures of all species in other light; `scripts/species.sh` draws them anew.
#[test]
#[ignore = "grows and draws all species twice, for people"]
fn species_in_other_light() {
    const COLUMNS: u32 = 4;
    const TILE: u32 = 136;
    let folder = tempfile::tempdir().unwrap();
    let species = [
        "maple", "oak", "birch", "spruce", "willow", "apple", "fern", "cactus",
    ];
    for light in ["evening", "studio"] {
        let mut all = RgbImage::new(COLUMNS * TILE, 2 * TILE);
        for (at, name) in (0..).zip(species) {
            let project = Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("assets/species")
                .join(name)
                .with_extension("ramus");
            let sheet = folder.path().join(format!("{name}.png"));
            let drawn = Command::new(env!("CARGO_BIN_EXE_ramus"))
                .arg("export")
                .arg(project)
                .args(["--light", light, "--size", &TILE.to_string(), "--sheet"])
                .arg(&sheet)
                .output()
                .unwrap();
            assert!(drawn.status.success(), "{drawn:?}");
            let tile = image::open(&sheet).unwrap().to_rgb8();
            let [x, y] = [at % COLUMNS, at / COLUMNS].map(|place| i64::from(place * TILE));
            image::imageops::replace(&mut all, &tile, x, y);
        }
        compare(&format!("species/{light}"), &all);
    }
}
