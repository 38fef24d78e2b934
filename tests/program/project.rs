//! A project looked at without a headset: every picture shows the tree of its step, whole.

use std::fs;

use glam::Vec3;
use image::RgbImage;
use ramus::app::demonstration::{MOST_PICTURES, pictured_steps};
use ramus::sketch::{Letter, NodeRef, Sketch};
use ramus::world::document::Document;
use ramus::world::project::to_bytes;

use super::{can_draw, folder, ramus, succeed};

/// A trunk of two pieces with a branch, each so long.
fn project(piece: f32, step: u32) -> Vec<u8> {
    let (sketch, _) = Sketch::default()
        .add_segments(NodeRef::ROOT, &[Vec3::Y * piece, Vec3::Y * (2.0 * piece)])
        .unwrap();
    let (sketch, _) = sketch
        .add_segment(NodeRef::new(Letter::TRUNK, 1), Vec3::new(piece, piece, 0.0))
        .unwrap();
    to_bytes(&Document {
        sketch: sketch.into(),
        step,
        ..Document::default()
    })
}

/// Pixels of each half (left eye, right eye) that differ from another picture's.
fn changed(picture: &RgbImage, other: &RgbImage) -> [usize; 2] {
    let mut count = [0; 2];
    for (x, y, pixel) in picture.enumerate_pixels() {
        let apart = |channel: usize| pixel.0[channel].abs_diff(other.get_pixel(x, y).0[channel]);
        count[usize::from(x >= picture.width() / 2)] +=
            usize::from((0..3).any(|channel| apart(channel) > 12));
    }
    count
}

#[test]
fn every_picture_shows_the_tree_of_its_step() {
    if !can_draw() {
        return;
    }
    let folder = folder();
    let path = folder.path().join("mine.ramus");
    fs::write(&path, project(0.5, 4)).unwrap();
    let said = succeed(
        ramus()
            .current_dir(folder.path())
            .args(["--headset", "simulated", "--out", "o", "--project"])
            .arg(&path),
    );
    assert!(
        said.contains("(5 growth steps, left and right eye)"),
        "{said}"
    );
    let pictures = [0, 1, 2, 3, 4].map(|step| {
        let path = folder.path().join(format!("o/step-{step:02}.png"));
        image::open(path).unwrap().into_rgb8()
    });
    // Left of the middle of each eye's picture is the tree, right of it the board, which says other numbers each time.
    let tree = |picture: &RgbImage| {
        let half = picture.width() / 2;
        let mut only = RgbImage::new(half, picture.height());
        for (x, y, pixel) in only.enumerate_pixels_mut() {
            let eye = x / (half / 2);
            *pixel = *picture.get_pixel(x + eye * (half / 2), y);
        }
        only
    };
    let [bare, grown @ ..] = pictures;
    let mut before = [0, 0];
    for (step, picture) in (1..).zip(&grown) {
        let now = changed(&tree(picture), &tree(&bare));
        for eye in 0..2 {
            assert!(
                now[eye] > before[eye] + 100,
                "step {step}, eye {eye}: {} pixels of the tree after {}",
                now[eye],
                before[eye]
            );
        }
        before = now;
    }
}

#[test]
fn a_long_project_is_pictured_from_its_beginning_to_its_end() {
    if !can_draw() {
        return;
    }
    let folder = folder();
    let path = folder.path().join("long.ramus");
    // A pole far taller than the person's picture would be from before the platform.
    let (sketch, _) = Sketch::default()
        .add_segment(NodeRef::ROOT, Vec3::Y * 0.5)
        .unwrap();
    let bytes = to_bytes(&Document {
        sketch: sketch.into(),
        step: 70,
        ..Document::default()
    });
    fs::write(&path, bytes).unwrap();
    let said = succeed(
        ramus()
            .current_dir(folder.path())
            .args(["--headset", "simulated", "--out", "o", "--project"])
            .arg(&path),
    );
    let told = format!("({MOST_PICTURES} of 71 growth steps, evenly chosen");
    assert!(said.contains(&told), "{said}");
    let steps = pictured_steps(70);
    let mut hashes = std::collections::BTreeSet::new();
    for step in &steps {
        let bytes = fs::read(folder.path().join(format!("o/step-{step:02}.png"))).unwrap();
        hashes.insert(bytes);
    }
    assert_eq!(hashes.len(), steps.len(), "every picture is another");
}
