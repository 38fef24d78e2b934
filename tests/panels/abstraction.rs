//! A scanned model as an L-system: looked for while one watches, stood beside it, grown on and back, told other numbers, written.

use std::path::Path;

use glam::Vec3;
use image::DynamicImage;
use image::imageops::{FilterType, crop_imm, resize};
use ramus::abstraction::OF_DEVIATIONS;
use ramus::app::picture::Picture;
use ramus::app::portrait;
use ramus::app::store::Store;
use ramus::app::workshop::{Workshop, WorkshopParams};
use ramus::lsystem::Grammar;
use ramus::mesh::unit::Rounded;
use ramus::world::abstracting::Search;
use ramus::world::likeness::Likeness;
use ramus::world::panels::PanelId;

use super::guide::{compare, strip};
use super::models::{press, vessel, visitor};
use super::pictures::{draw, save, views};
use super::visitor::{RIGHT, Visitor};

fn search(visitor: &Visitor) -> &Search {
    let model = &visitor.document().models[0];
    visitor.workshop.world().abstraction(model).unwrap()
}

fn likeness(visitor: &Visitor, at: usize) -> Likeness {
    visitor.document().models[at].likeness.clone().unwrap()
}

pub(super) fn says(visitor: &Visitor, part: &str) -> bool {
    let mut texts = visitor.workshop.texts(PanelId::Bench);
    texts.any(|text| text.contains(part))
}

/// A press that waits for nothing.
fn touch(visitor: &mut Visitor, text: &str) {
    visitor.scroll_to(RIGHT, PanelId::Bench, text);
    visitor.click(RIGHT, PanelId::Bench, text);
}

/// Somebody before a vessel's page as an L-system.
pub(super) fn before_a_vessel(folder: &Path) -> Visitor {
    vessel(folder);
    let mut visitor = visitor(folder);
    for text in ["Models", "vessel.obj", "L-system"] {
        press(&mut visitor, text);
    }
    visitor
}

/// What the tree on the stage has: segments and tips.
fn parts(visitor: &Visitor, at: usize) -> [usize; 2] {
    let model = &visitor.document().models[at];
    let loaded = visitor.workshop.world().loaded_model(model).unwrap();
    let skeleton = loaded.skeleton.as_ref().unwrap();
    [skeleton.segment_count(), skeleton.tips().len()]
}

#[test]
fn a_model_is_abstracted_and_the_tree_stands_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 720, 720).unwrap();
    let mut visitor = before_a_vessel(folder.path());
    assert!(says(&visitor, "Its centerlines are found first."));
    press(&mut visitor, "Find centerlines");

    // It goes on beside the session, and stops where that is wanted; what was found until then stays.
    touch(&mut visitor, "Abstract this");
    assert!(search(&visitor).goes_on);
    assert!(says(&visitor, "trees drawn: "));
    while search(&visitor).found.is_none() {
        visitor.frame();
    }
    touch(&mut visitor, "Cancel");
    let stopped = search(&visitor).clone();
    let found = stopped.found.unwrap().unwrap();
    assert!(
        !stopped.goes_on && found.drawn[0] < found.drawn[1],
        "{:?}",
        found.drawn
    );

    // Another seed, to its end.
    press(&mut visitor, "Another one");
    let search = search(&visitor).clone();
    assert_eq!((search.seed, search.goes_on), (1, false));
    let found = search.found.unwrap().unwrap();
    assert_eq!(found.drawn, [20_000; 2]);
    assert!(found.ranked.len() == 6 && found.by_rules.is_some());
    let nearest_first = found
        .ranked
        .is_sorted_by(|a, b| a.0.distance <= b.0.distance);
    assert!(nearest_first);
    let best = &found.ranked[0].0;
    let off =
        |one: &&ramus::abstraction::Difference| !one.matches() && one.tolerance < OF_DEVIATIONS;
    let off: Vec<_> = best.differences.iter().filter(off).collect();
    assert!(off.is_empty(), "counts and means are the model's: {off:?}");
    let matching = best.differences.iter().filter(|one| one.matches()).count();
    let all = best.differences.len();
    let told = format!("numbers as the model has them: {matching} / {all}");
    visitor.scroll_to(RIGHT, PanelId::Bench, &told);

    // It stands beside it, as large as the model is shown.
    let edits = visitor.workshop.edits();
    press(&mut visitor, "Stand it beside the model");
    assert_eq!(visitor.workshop.edits(), edits + 1);
    let models = visitor.document().models.clone();
    assert_eq!(models.len(), 2);
    assert_eq!(likeness(&visitor, 1).params, best.params.clone().into());
    let apart = models[1].place.position - models[0].place.position;
    assert!(
        apart.x.abs() > 0.2 && apart.y.abs() < 1e-6 && apart.z.abs() < 1e-6,
        "{apart}"
    );
    let magnified = |visitor: &Visitor, at: usize| {
        let model = &visitor.document().models[at];
        let loaded = visitor.workshop.world().loaded_model(model).unwrap();
        loaded.magnification(model)
    };
    let [one, other] = [0, 1].map(|at| magnified(&visitor, at));
    assert!((one / other - 1.0).abs() < 0.1, "{one} {other}");
    assert_eq!(
        parts(&visitor, 1)[1],
        found.target.counts.centerlines.unwrap()
    );
    let middle = models[0].place.position + 0.5 * apart + Vec3::Y * 0.2;
    // From aside: this tree forks towards people.
    let near = views(middle + Vec3::new(-0.7, 0.1, 0.7), middle);
    let seen = draw(&mut visitor, &mut picture, &near);
    save(&seen, "abstraction-beside.png");
    let half = crop_imm(&seen, 0, 0, seen.width() / 2, seen.height()).to_image();
    let still = resize(&half, 480, 480, FilterType::Triangle);
    compare(
        "beside",
        &strip(&[DynamicImage::ImageRgba8(still).to_rgb8()]),
    );
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}

#[test]
fn a_tree_grows_on_and_back_and_has_other_seeds_and_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let mut visitor = visitor(folder.path());
    for text in ["Models", "duct", "L-system"] {
        press(&mut visitor, text);
    }
    let whole = parts(&visitor, 0);
    assert_eq!(whole[1], 13, "the published duct's tips");
    assert!(says(&visitor, "tips: 13"));
    let last = f64::from(likeness(&visitor, 0).last());

    // Back by a step, and on again.
    press(&mut visitor, "Back");
    assert_eq!(likeness(&visitor, 0).moment, Some(last - 1.0));
    visitor.scroll_to(RIGHT, PanelId::Bench, "Back");
    visitor.click_nth(RIGHT, PanelId::Bench, "Grow", 2);
    visitor.workshop.finish_models();
    assert_eq!(likeness(&visitor, 0).moment, None);
    assert_eq!(parts(&visitor, 0), whole);

    // Another seed is another tree; undo brings the first one back.
    let seed = likeness(&visitor, 0).params.seed;
    press(&mut visitor, "Another one");
    assert_eq!(likeness(&visitor, 0).params.seed, seed + 1);
    press(&mut visitor, "nothing runs into the tree");
    assert!(likeness(&visitor, 0).params.prune_intersections);
    press(&mut visitor, "nothing leaves an ellipsoid");
    let within = likeness(&visitor, 0).params.bounding_ellipsoid;
    assert!(within.is_some_and(|radii| radii.iter().all(|radius| *radius > 0.0)));
    assert!(parts(&visitor, 0)[0] < 200);

    // Each order can have numbers of its own; looking at them changes nothing.
    for _ in 0..2 {
        press(&mut visitor, "one order more");
    }
    let factors = |visitor: &Visitor| likeness(visitor, 0).params.length_by_order.clone();
    assert_eq!(factors(&visitor), [1.0; 2]);
    let edits = visitor.workshop.edits();
    visitor.frame();
    assert_eq!(visitor.workshop.edits(), edits);
    press(&mut visitor, "one order less");
    assert_eq!(
        (factors(&visitor), visitor.workshop.edits()),
        (vec![1.0], edits + 1)
    );

    // It is written as a grammar that grows the same, and as files for others.
    for ending in ["LSYS", "GLB", "OBJ", "SWC"] {
        press(&mut visitor, ending);
        visitor.workshop.finish_tree();
        let file = format!("duct-like-1.{}", ending.to_lowercase());
        let bytes = std::fs::read(folder.path().join(&file)).unwrap();
        assert!(bytes.len() > 200, "{file}");
    }
    let text = std::fs::read_to_string(folder.path().join("duct-like-1.lsys")).unwrap();
    assert_eq!(Grammar::parse(&text, "duct.lsys").unwrap().seed(), seed + 1);

    // The project keeps it.
    let kept = visitor.document().models.clone();
    visitor.workshop.close().unwrap();
    let opened = Store::open(&folder.path().join("a.ramus")).unwrap();
    let mut again = Workshop::new(opened, WorkshopParams::default()).unwrap();
    assert_eq!(again.document().models, kept);
    again.finish_models();
    assert_eq!(again.scene().models.len(), 1);
}

#[test]
fn a_tree_grows_by_itself_which_is_one_edit() {
    let folder = tempfile::tempdir().unwrap();
    let mut visitor = visitor(folder.path());
    for text in ["Models", "sapling", "L-system"] {
        press(&mut visitor, text);
    }
    let whole = parts(&visitor, 0);
    let edits = visitor.workshop.edits();
    touch(&mut visitor, "Play");
    let mut moments = Vec::new();
    while visitor.workshop.world().grows_on(0) {
        // A slow machine: five frames a second.
        visitor.frame.time += 0.2;
        visitor.frame();
        visitor.frames.clear();
        let shown = visitor.workshop.world().shown().models[0].likeness.clone();
        moments.extend(shown.unwrap().moment);
    }
    visitor.workshop.finish_models();
    moments.dedup();
    assert!(moments.is_sorted() && moments.len() > 5, "{moments:?}");
    let between = moments.iter().filter(|moment| moment.fract() > 0.01);
    assert!(between.count() > 3, "{moments:?}");
    assert_eq!(
        (likeness(&visitor, 0).moment, parts(&visitor, 0)),
        (None, whole)
    );
    assert!(visitor.workshop.edits() <= edits + 1);
}

#[test]
fn a_model_becomes_a_sketch_and_its_branch_a_brush() {
    let folder = tempfile::tempdir().unwrap();
    vessel(folder.path());
    let mut visitor = visitor(folder.path());
    for text in ["Models", "vessel.obj", "Centerlines", "Find centerlines"] {
        press(&mut visitor, text);
    }
    let edits = visitor.workshop.edits();
    press(&mut visitor, "Make a sketch of it");
    assert_eq!(visitor.workshop.edits(), edits + 1, "one action");
    let sketch = visitor.document().sketch.clone();
    assert_eq!(
        sketch.strokes.len(),
        2,
        "a trunk that goes on, and a branch"
    );
    assert!(sketch.strokes[0].points.len() > 20);
    let high = sketch.strokes[0].points.iter().map(|at| at.y);
    let high = high.fold(0.0, f32::max);
    assert!((1.5..2.1).contains(&high), "{high} m");

    // A row lights its branch, which is then drawn with, from the selected node.
    let model = visitor.document().models[0].clone();
    let lines = visitor.workshop.world().lines(&model).unwrap().unwrap();
    let row = Rounded(lines.analysis.branches[2].length).to_string();
    press(&mut visitor, &row);
    let points = |visitor: &Visitor| {
        let strokes = visitor.document().sketch.strokes.clone();
        strokes.iter().map(|one| one.points.len()).sum::<usize>()
    };
    let before = points(&visitor);
    press(&mut visitor, "Draw with this branch");
    assert!(points(&visitor) > before + 5);
    assert_eq!(visitor.workshop.edits(), edits + 2);

    // It is as thick as the scan until that is switched off.
    let thick = |visitor: &Visitor| {
        let strokes = visitor.document().sketch.strokes.clone();
        strokes
            .iter()
            .map(|one| one.radii.len())
            .collect::<Vec<_>>()
    };
    let before = thick(&visitor);
    assert_eq!(before[0], visitor.document().sketch.strokes[0].points.len());
    press(&mut visitor, "Letters");
    press(&mut visitor, "as thick as the scan");
    assert_eq!(thick(&visitor), [[0].as_slice(), &before[1..]].concat());
    assert_eq!(visitor.workshop.edits(), edits + 3);
}
