//! Small reference images, and large pictures for people.

use std::path::Path;

use glam::{Affine3A, Vec3};
use image::RgbaImage;
use ramus::{
    render::{Eye, Fov, RendererParams},
    world::scene::Scene,
};

use super::support::{
    SIDE, device, field, grove, mode, placed, plain, shoot, silent, stage, standing,
};

/// Compares with `tests/images/NAME.png`, or rewrites it.
pub(super) fn snapshot(name: &str, picture: &RgbaImage) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/images");
    let file = folder.join(format!("{name}.png"));
    let picture = image::DynamicImage::ImageRgba8(picture.clone()).to_rgb8();
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some_and(|value| value == "1") {
        picture.save(&file).unwrap();
        assert!(
            std::fs::metadata(&file).unwrap().len() <= 65_536,
            "{name}.png is larger than 64 KiB"
        );
        return;
    }
    let expected = image::open(&file)
        .unwrap_or_else(|error| panic!("{}: {error}", file.display()))
        .to_rgb8();
    assert_eq!(picture.dimensions(), expected.dimensions(), "{name}");
    let result = image_compare::rgb_hybrid_compare(&picture, &expected).unwrap();
    let far = picture
        .pixels()
        .zip(expected.pixels())
        .filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 32))
        .count();
    // Another version of the compiler in the driver moves an edge here and there.
    let fine = result.score > 0.985 && far * 200 < (picture.width() * picture.height()) as usize;
    let [actual, diff] = ["actual", "diff"].map(|kind| folder.join(format!("{name}.{kind}.png")));
    if fine {
        let _ = std::fs::remove_file(actual);
        let _ = std::fs::remove_file(diff);
    } else {
        picture.save(&actual).unwrap();
        result.image.to_color_map().to_rgb8().save(&diff).unwrap();
        panic!(
            "{name}: score {}, {far} pixels far off; see {} and {}",
            result.score,
            actual.display(),
            diff.display()
        );
    }
}

#[test]
fn pictures_are_as_they_were_when_looked_at() {
    let Some(gpu) = device() else { return };
    let mode = mode(&gpu);
    let params = RendererParams::new(SIDE, SIDE, mode);
    let scene = stage();
    let shot = shoot(&gpu, &params, &scene, &standing());
    snapshot("standing-left", &shot.color[0]);
    snapshot("standing-right", &shot.color[1]);
    let fov = Fov::symmetric(0.75, 1.0);
    let joint =
        Eye::looking_at(Vec3::new(0.35, 1.15, -1.9), Vec3::new(0.0, 0.95, -2.6), fov).pair(0.063);
    // Bark does not pack well: a smaller picture.
    snapshot(
        "joint",
        &shoot(&gpu, &RendererParams::new(200, 200, mode), &scene, &joint).color[0],
    );
    let (tree, before) = grove(5, 5);
    let alone = Scene {
        tree: Some(placed(tree, before, 5, Affine3A::IDENTITY)),
        ..Scene::default()
    };
    let eyes =
        Eye::looking_at(Vec3::new(0.6, 1.2, 2.5), Vec3::new(0.0, 1.05, 0.0), field()).pair(0.063);
    snapshot(
        "tree-alone",
        &shoot(&gpu, &plain(mode, 0.75), &alone, &eyes).color[0],
    );
    silent(&gpu);
}

/// Where pictures for people go.
fn out_dir() -> std::path::PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/pictures");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Pictures to be looked at: `cargo test --test picture -- --ignored look`.
#[test]
#[ignore = "makes large pictures for people"]
fn look() {
    let Some(gpu) = device() else { return };
    let side = 900;
    let params = RendererParams::new(side, side, mode(&gpu));
    let mut scene = stage();
    let save = |name: &str, scene: &Scene, eye: Eye| {
        let shot = shoot(&gpu, &params, scene, &eye.pair(0.063));
        shot.color[0]
            .save(out_dir().join(format!("{name}.png")))
            .unwrap();
    };
    save("standing", &scene, standing()[0]);
    let aim = |from: [f32; 3], to: [f32; 3], fov: f32| {
        Eye::looking_at(from.into(), to.into(), Fov::symmetric(fov, 1.0))
    };
    save("tree", &scene, aim([1.5, 1.6, 2.2], [0.0, 1.6, -2.6], 0.9));
    save(
        "joint",
        &scene,
        aim([0.35, 1.15, -1.9], [0.0, 0.95, -2.6], 0.75),
    );
    save(
        "platform",
        &scene,
        aim([0.45, 1.45, 0.75], [0.0, 0.98, 0.0], 0.8),
    );
    save("right", &scene, aim([0.0, 1.6, 1.3], [3.0, 1.9, 0.8], 1.3));
    save("wide", &scene, aim([5.0, 2.2, 5.0], [0.0, 1.2, -1.5], 1.0));
    scene.tree.as_mut().unwrap().growth = 0.4;
    save(
        "growing",
        &scene,
        aim([1.5, 1.6, 2.2], [0.0, 1.6, -2.6], 0.9),
    );
    save(
        "hands",
        &scene,
        aim([0.0, 1.45, 0.95], [0.03, 1.15, 0.45], 0.9),
    );
    silent(&gpu);
}
