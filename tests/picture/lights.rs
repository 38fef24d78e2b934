//! Light on the stage: day, evening and studio, and shadows that get softer with the distance from what throws them. Numbers from pictures; then pictures
//! to be looked at.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use image::RgbaImage;
use ramus::render::{Eye, Fov, Gpu, Offscreen, Renderer, RendererParams, StereoMode};
use ramus::tree::foliage::{Bearing, Dress, kind};
use ramus::tree::{NO_PARENT, Organs, Tree};
use ramus::world::scene::weather::Light;
use ramus::world::scene::{PlacedTree, Scene};

use super::support::{SIDE, device, grove, mode, placed, shoot, silent};

/// Two metres high, with some 30,000 leaves.
pub(crate) fn leafy() -> PlacedTree {
    let (tree, before) = grove(7, 99);
    let mut organs = Organs::default();
    let bears = [("maple", 0.06), ("apple", 0.04)].map(|(name, size)| Bearing {
        size,
        every: 0.05,
        ..Bearing::of(kind(name).unwrap())
    });
    let dress = Dress {
        bears: bears.to_vec(),
        ..Dress::default()
    };
    dress.put_on(&tree, &mut organs, 7, None);
    PlacedTree {
        organs: Arc::new(organs),
        revision: 2,
        ..placed(tree, before, 99, Affine3A::IDENTITY)
    }
}

/// What draws trees of any size within the frame, lit by this.
pub(crate) fn params(mode: StereoMode, side: u32, light: Light) -> RendererParams {
    RendererParams {
        direct_segments: usize::MAX,
        direct_levels: usize::MAX,
        ..RendererParams::new(side, side, mode).lit(light)
    }
}

/// A straight pole up from the ground, so thick, held at an end by nothing.
pub(crate) fn pole(from: f32, to: f32, radius: f32) -> PlacedTree {
    let count = 9_u16;
    let tree = Tree {
        parent: (0..u32::from(count))
            .map(|node| node.checked_sub(1).unwrap_or(NO_PARENT))
            .collect(),
        position: (0..count)
            .map(|node| Vec3::Y * (from + (to - from) * f32::from(node) / f32::from(count - 1)))
            .collect(),
        radius: vec![radius; usize::from(count)].into(),
        letter: vec![0; usize::from(count)].into(),
        order: vec![0; usize::from(count)].into(),
        birth: vec![0; usize::from(count)].into(),
        letters: vec!["F".to_owned()],
    };
    placed(tree, Vec::new(), 99, Affine3A::IDENTITY)
}

fn scene(tree: PlacedTree) -> Scene {
    Scene {
        tree: Some(tree),
        ..Scene::default()
    }
}

pub(crate) fn luminance(pixel: &image::Rgba<u8>) -> f64 {
    let [red, green, blue, _] = pixel.0.map(f64::from);
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// Mean of a part of a picture, by colour: x and y from and to, as parts of its side.
fn mean(picture: &RgbaImage, x: [f32; 2], y: [f32; 2]) -> [f64; 3] {
    let within = |n: u32, [from, to]: [f32; 2], side: u32| {
        let at = (n as f32 + 0.5) / side as f32;
        (from..to).contains(&at)
    };
    let mut sum = [0.0; 4];
    for (column, row, pixel) in picture.enumerate_pixels() {
        if within(column, x, picture.width()) && within(row, y, picture.height()) {
            for (sum, part) in sum.iter_mut().zip([pixel.0[0], pixel.0[1], pixel.0[2], 1]) {
                *sum += f64::from(part);
            }
        }
    }
    [0, 1, 2].map(|part| sum[part] / sum[3])
}

/// How wide the edge of a pole's shadow is on the ground, metres, at a place that throws so high: from an eye right above, across the shadow.
fn edge(gpu: &Gpu, light: Light, height: f32) -> f32 {
    let params = params(mode(gpu), 512, light);
    // Towards the sun and away from it on the ground.
    let sun = params.sun.normalize();
    let away = -sun.with_y(0.0).normalize();
    let at = away * (height * sun.with_y(0.0).length() / sun.y);
    let across = 1.2_f32;
    let eye = Eye {
        world_from_eye: ramus::render::Pose {
            // Down, with the picture's right across the shadow.
            orientation: Quat::from_mat3(&glam::Mat3::from_cols(
                away.cross(Vec3::Y),
                away,
                Vec3::Y,
            )),
            position: at + Vec3::Y * 3.0,
        },
        fov: Fov::symmetric(2.0 * (across / 2.0 / 3.0).atan(), 1.0),
    };
    // As thick as its shadow's edges are wide, or more: its middle is dark.
    let shot = |scene: &Scene| shoot(gpu, &params, scene, &eye.pair(0.0)).color[0].clone();
    let [with, without] = [shot(&scene(pole(0.0, 4.0, 0.16))), shot(&Scene::default())];
    // Light by column, of the rows in the middle, as a part of what is there without the pole.
    let columns: Vec<f64> = (0..512)
        .map(|x| {
            let sum = |picture: &RgbaImage| -> f64 {
                (236..276).map(|y| luminance(picture.get_pixel(x, y))).sum()
            };
            sum(&with) / sum(&without)
        })
        .collect();
    let dark = columns.iter().copied().fold(f64::MAX, f64::min);
    let part = |column: f64| (column - dark) / (1.0 - dark);
    // Both edges: columns between a tenth and nine tenths of the light.
    let between = columns
        .iter()
        .filter(|column| (0.1..0.9).contains(&part(**column)))
        .count();
    assert!(dark < 0.85, "{light:?} {height}: {dark}");
    between as f32 * across / 512.0 / 2.0
}

#[test]
fn shadows_are_wider_the_farther_off_what_throws_them() {
    let Some(gpu) = device() else { return };
    for (light, heights, least) in [
        (Light::Day, [1.1, 2.2, 3.6], 2.0),
        (Light::Evening, [0.3, 0.6, 1.2], 2.0),
    ] {
        let widths = heights.map(|height| edge(&gpu, light, height));
        eprintln!("{light:?}: edges {widths:?} m wide of what is {heights:?} m high");
        assert!(widths.is_sorted(), "{light:?} {widths:?}");
        assert!(widths[2] > least * widths[0], "{light:?} {widths:?}");
    }
    let [day, evening] = [Light::Day, Light::Evening].map(|light| edge(&gpu, light, 1.1));
    assert!(evening > 2.0 * day, "{evening} {day}");
    silent(&gpu);
}

fn before_the_tree() -> [Eye; 2] {
    let fov = Fov::symmetric(0.9, 1.0);
    Eye::looking_at(Vec3::new(0.0, 1.5, 4.6), Vec3::new(0.0, 1.1, 0.0), fov).pair(0.064)
}

#[test]
fn each_light_has_its_sky_ground_and_shadows() {
    let Some(gpu) = device() else { return };
    let tree = scene(leafy());
    let mut seen = Vec::new();
    for light in Light::ALL {
        let params = params(mode(&gpu), SIDE, light);
        let shot = shoot(&gpu, &params, &tree, &before_the_tree());
        seen.push(shot.color[0].clone());
    }
    let top = |picture: &RgbaImage| mean(picture, [0.0, 1.0], [0.0, 0.1]);
    let [day, evening, studio] = [0, 1, 2].map(|light| top(&seen[light]));
    // Of another brightness and colour.
    let all = |color: [f64; 3]| {
        color
            .iter()
            .map(|part| (part / 255.0).powf(2.2))
            .sum::<f64>()
    };
    assert!(all(evening) < 0.65 * all(day), "{evening:?} {day:?}");
    assert!(
        studio.iter().all(|part| (part - studio[0]).abs() < 4.0),
        "{studio:?}"
    );
    assert!(day[2] > 1.2 * day[0], "{day:?}");
    // The crown's light is warm in the evening.
    let crown = |picture: &RgbaImage| mean(picture, [0.4, 0.6], [0.3, 0.5]);
    let warmth = |color: [f64; 3]| color[0] / color[2];
    let [day, evening] = [0, 1].map(|light| warmth(crown(&seen[light])));
    assert!(evening > 1.15 * day, "{evening} {day}");
    // The floor receives the tree in each.
    for (light, picture) in Light::ALL.into_iter().zip(&seen) {
        let params = params(mode(&gpu), SIDE, light);
        let empty = shoot(&gpu, &params, &Scene::default(), &before_the_tree());
        let darker = picture.enumerate_pixels().filter(|(x, y, pixel)| {
            let ground = *y > SIDE * 7 / 10;
            ground && luminance(pixel) < 0.93 * luminance(empty.color[0].get_pixel(*x, *y))
        });
        let darker = darker.count();
        assert!(darker > 300, "{light:?}: {darker} pixels");
    }
    silent(&gpu);
}

#[test]
fn soft_shadows_are_the_same_for_both_eyes_and_from_frame_to_frame() {
    let Some(gpu) = device() else { return };
    let tree = scene(leafy());
    let lit = |mode| params(mode, SIDE, Light::Evening);
    let eyes = before_the_tree();
    let first = shoot(&gpu, &lit(mode(&gpu)), &tree, &eyes);
    let again = shoot(&gpu, &lit(mode(&gpu)), &tree, &[eyes[1], eyes[0]]);
    // What an eye sees depends on where it is and not on which one it is: nothing is drawn by the pixel's number but the sky's grain.
    let ground = |picture: &RgbaImage| {
        let rows = picture.height() * 8 / 10;
        image::imageops::crop_imm(picture, 0, rows, picture.width(), picture.height() - rows)
            .to_image()
    };
    assert!(ground(&first.color[0]) == ground(&again.color[1]));
    assert!(ground(&first.color[1]) == ground(&again.color[0]));
    silent(&gpu);
}

/// A light set later is the one that a renderer may begin with.
#[test]
fn light_may_change_from_frame_to_frame() {
    let Some(gpu) = device() else { return };
    let tree = scene(leafy());
    let offscreen = Offscreen::new(&gpu, params(mode(&gpu), SIDE, Light::Day).extent).unwrap();
    let mut renderer = Renderer::new(&gpu, &params(mode(&gpu), SIDE, Light::Day)).unwrap();
    let mut pictures = Vec::new();
    for light in [Light::Day, Light::Studio, Light::Evening, Light::Day] {
        renderer.set_light(light);
        renderer
            .draw(&tree, &before_the_tree(), &offscreen.target())
            .unwrap();
        pictures.push(offscreen.read_color().unwrap());
    }
    assert!(pictures[0] == pictures[3], "back in daylight");
    let params = params(mode(&gpu), SIDE, Light::Evening);
    let evening = shoot(&gpu, &params, &tree, &before_the_tree());
    assert!(pictures[2] == evening.color);
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2]);
    silent(&gpu);
}

/// Pictures to be looked at: `cargo test --test picture -- --ignored look_at_lights`.
#[test]
#[ignore = "makes large pictures for people"]
fn look_at_lights() {
    let Some(gpu) = device() else { return };
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("target/pictures");
    std::fs::create_dir_all(&folder).unwrap();
    for (what, tree) in [("leafy", leafy()), ("pole", pole(0.0, 2.5, 0.05))] {
        for light in Light::ALL {
            let params = params(mode(&gpu), 720, light);
            let fov = Fov::symmetric(1.0, 1.0);
            let eye = Eye::looking_at(Vec3::new(0.8, 1.7, 4.6), Vec3::new(0.0, 0.9, 0.0), fov);
            let shot = shoot(&gpu, &params, &scene(tree.clone()), &eye.pair(0.063));
            shot.color[0]
                .save(folder.join(format!("light-{what}-{}.png", light.name())))
                .unwrap();
        }
    }
    silent(&gpu);
}
