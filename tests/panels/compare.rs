//! Trees on the stage beside each other: chosen on a panel, judged, counted, laid over each other; and the guide's picture of it.

use glam::Vec3;
use image::imageops::{FilterType, crop_imm, resize};
use image::{DynamicImage, RgbaImage};
use ramus::app::picture::Picture;
use ramus::app::portrait;
use ramus::tree::compare::verdict::Kind;
use ramus::world::comparing::{Comparison, Overlay, Subject};
use ramus::world::panels::PanelId;

use super::abstraction::{before_a_vessel, says};
use super::guide::{compare, strip};
use super::models::press;
use super::pictures::{draw, save, views};
use super::visitor::{RIGHT, Visitor};

fn found(visitor: &Visitor, at: usize) -> Comparison {
    let (found, is_new) = visitor.workshop.world().comparison(at).unwrap();
    assert!(is_new);
    found.unwrap().as_ref().clone()
}

/// How many pixels are nearest to the colours in which trees are laid over each other: blue and orange.
fn inks(picture: &RgbaImage) -> [usize; 2] {
    let is = |[red, green, blue, _]: [u8; 4]| {
        let [red, green, blue] = [red, green, blue].map(i32::from);
        [
            blue > red + 60 && blue > green + 20 && red < 60,
            red > blue + 90 && red > green + 50 && red > 140,
        ]
    };
    let count = |which: usize| picture.pixels().filter(|pixel| is(pixel.0)[which]).count();
    [count(0), count(1)]
}

/// Scrolls the tab to its top.
fn top(visitor: &mut Visitor) {
    let resting = visitor.frame.hands[RIGHT];
    for _ in 0..200 {
        let (_, size) = visitor.place(PanelId::Bench);
        visitor.point_on(RIGHT, PanelId::Bench, size * 0.5);
        visitor.frame.hands[RIGHT].stick.y = 1.0;
        visitor.frame();
    }
    visitor.frame.hands[RIGHT] = resting;
    visitor.frame();
}

/// Opens a model's page, whose name stands there.
fn page(visitor: &mut Visitor, name: &str) {
    top(visitor);
    press(visitor, name);
}

#[test]
fn a_model_is_compared_with_a_tree_and_a_sketch_and_they_are_laid_over_it() {
    let folder = tempfile::tempdir().unwrap();
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 720, 720).unwrap();
    let mut visitor = before_a_vessel(folder.path());
    press(&mut visitor, "Compare");
    assert!(says(&visitor, "Its centerlines are found first."));
    press(&mut visitor, "Find centerlines");
    assert!(says(&visitor, "Nothing else here has a tree"));

    // A sketch of it that has grown a little.
    press(&mut visitor, "Centerlines");
    press(&mut visitor, "Make a sketch of it");
    press(&mut visitor, "Grow");
    for _ in 0..12 {
        visitor.click_nth(RIGHT, PanelId::Bench, "Grow", 2);
    }
    visitor.workshop.finish_tree();
    press(&mut visitor, "Models");
    press(&mut visitor, "Compare");
    press(&mut visitor, "the sketch");
    let one = found(&visitor, 0);
    let pair = &one.pairs[0];
    assert_eq!(pair.branches[0], 3);
    assert!(pair.scale > 2.0, "{}", pair.scale);
    assert_eq!(
        pair.verdict.kind,
        Kind::Different,
        "half of it has not grown"
    );
    assert!(says(&visitor, "different"));

    // Stepped back to nothing it is compared no more, and grown again it is.
    press(&mut visitor, "Grow");
    for _ in 0..12 {
        visitor.click(RIGHT, PanelId::Bench, "Back");
    }
    visitor.workshop.finish_tree();
    assert_eq!(visitor.document().step, 0);
    press(&mut visitor, "Models");
    top(&mut visitor);
    assert!(visitor.workshop.world().comparison(0).is_none());
    assert!(says(&visitor, "Nothing else here has a tree"));
    assert!(!says(&visitor, "different"));
    press(&mut visitor, "Grow");
    visitor.click_nth(RIGHT, PanelId::Bench, "Grow", 2);
    visitor.workshop.finish_tree();
    press(&mut visitor, "Models");
    visitor.workshop.finish_models();
    let less = found(&visitor, 0);
    assert_ne!(less.numbers[1], one.numbers[1]);

    // So is a tree that was found like it, but for its places.
    press(&mut visitor, "L-system");
    press(&mut visitor, "Abstract this");
    press(&mut visitor, "Stand it beside the model");
    assert!(
        visitor.workshop.world().compared_with(0).is_empty(),
        "models have other numbers"
    );
    press(&mut visitor, "Compare");
    let seed = visitor.document().models[1]
        .likeness
        .clone()
        .unwrap()
        .params
        .seed;
    let tree = format!("vessel.obj * {seed}");
    // Above, where that is seen, the same name chooses its page.
    visitor.scroll_to(RIGHT, PanelId::Bench, "Compare with:");
    let second = visitor.workshop.find_text(PanelId::Bench, &tree, 2);
    visitor.click_nth(
        RIGHT,
        PanelId::Bench,
        &tree,
        1 + usize::from(second.is_some()),
    );
    visitor.workshop.finish_models();
    visitor.frame();
    let with = visitor.workshop.world().compared_with(0).to_vec();
    assert_eq!(with, [Subject::Model(1)]);
    let two = found(&visitor, 0);
    let pair = &two.pairs[0];
    assert_eq!(pair.branches, [3, 3]);
    assert_eq!(pair.verdict.kind, Kind::TooFew, "{}", pair.verdict.words);
    let [within, of] = pair.verdict.within;
    assert!(of == 11 && within >= 9, "{within} of {of}");
    for text in [
        format!("numbers alike: {within} / {of}"),
        "too few branches to tell".to_owned(),
        "branches to take away or add: 0".to_owned(),
    ] {
        assert!(says(&visitor, &text), "{text}");
    }
    press(&mut visitor, "all numbers");
    visitor.scroll_to(RIGHT, PanelId::Bench, "murray: mean");
    press(&mut visitor, "all numbers");
    assert!(!says(&visitor, "murray: mean"));
    // All of them at once.
    press(&mut visitor, "the sketch");
    assert_eq!(found(&visitor, 0).pairs.len(), 2);
    press(&mut visitor, "the sketch");

    // Laid over it, both are seen in their colours, where the model stands.
    let place = visitor.document().models[0].place;
    let middle = place.position + Vec3::Y * 0.2;
    let near = views(middle + Vec3::new(-0.15, 0.05, 0.5), middle);
    let edits = visitor.workshop.edits();
    press(&mut visitor, "no");
    let bare = draw(&mut visitor, &mut picture, &near);
    let models = visitor.workshop.scene().models.len();
    press(&mut visitor, "fitted");
    assert_eq!(visitor.workshop.world().overlay(), Overlay::Fitted);
    let seen = draw(&mut visitor, &mut picture, &near);
    assert_eq!(visitor.workshop.scene().models.len(), models + 2);
    save(&seen, "compare-overlay.png");
    let half = |picture: &RgbaImage| {
        crop_imm(picture, 0, 0, picture.width() / 2, picture.height()).to_image()
    };
    let ([blue, orange], before) = (inks(&half(&seen)), inks(&half(&bare)));
    assert!(blue > before[0] + 300, "{blue} {before:?}");
    assert!(orange > before[1] + 300, "{orange} {before:?}");
    assert_eq!(visitor.workshop.edits(), edits, "looking is no edit");
    let middle = visitor.center(PanelId::Bench);
    let bench = views(middle + visitor.normal(PanelId::Bench) * 0.62, middle);
    visitor.scroll_to(RIGHT, PanelId::Bench, "Compare with:");
    visitor.scroll_to(RIGHT, PanelId::Bench, "length: mean");
    let numbers = draw(&mut visitor, &mut picture, &bench);
    visitor.scroll_to(RIGHT, PanelId::Bench, "all turn together");
    let curves = draw(&mut visitor, &mut picture, &bench);
    let stills = [&seen, &numbers, &curves].map(|one| {
        let still = resize(&half(one), 400, 400, FilterType::Triangle);
        DynamicImage::ImageRgba8(still).to_rgb8()
    });
    compare("overlay", &strip(&stills));

    // Where the tree is another one it is compared anew; taken away, it is compared no more.
    page(&mut visitor, &tree);
    press(&mut visitor, "L-system");
    press(&mut visitor, "Another one");
    page(&mut visitor, "vessel.obj");
    press(&mut visitor, "Compare");
    assert_ne!(found(&visitor, 0).numbers[1], two.numbers[1]);
    press(
        &mut visitor,
        &tree.replace(&seed.to_string(), &(seed + 1).to_string()),
    );
    press(&mut visitor, "Take it away");
    assert_eq!(visitor.document().models.len(), 1);
    assert!(visitor.workshop.world().comparison(0).is_none());
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}
