//! Pictures drawn without a headset, measured: what is where, in which colour, at which depth, for which eye.
//!
//! Everything runs with the validation layer and its synchronisation checks; any message fails the test. Numbers first, then small
//! reference images (`UPDATE_SNAPSHOTS=1` rewrites them; look at them before you commit them).
#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::missing_assert_message,
    reason = "tests"
)]

use std::{f32::consts::TAU, path::Path, sync::Arc};

use ash::vk;
use glam::{Affine3A, Quat, Vec3, Vec4};
use image::{Rgba, RgbaImage};
use ramus::{
    render::{
        Backdrop, Eye, Fov, Gpu, GpuParams, Headless, NEAR, Offscreen, RenderError, Renderer, RendererParams, StereoMode,
        TreeState, TreeUpload, probe,
    },
    tree::{NO_PARENT, Tree, radii::RadiusParams},
    world::scene::{Ball, Board, Controller, PlacedTree, Plate, Rod, Scene},
};

const SIDE: u32 = 256;

/// A device with everything checked, or `None` (said aloud) where there is no Vulkan; CI must have one.
fn device() -> Option<Gpu> {
    match Gpu::new(&Headless::default(), &GpuParams::checked()) {
        Ok(gpu) => {
            assert!(gpu.info().validation || std::env::var("CI").is_err(), "CI needs the validation layer");
            Some(gpu)
        }
        Err(error @ (RenderError::NoLoader(_) | RenderError::NoDevice(_) | RenderError::OldDriver { .. })) => {
            assert!(std::env::var("CI").is_err(), "CI needs a Vulkan device: {error}");
            eprintln!("skipped: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// The mode that works here.
fn mode(gpu: &Gpu) -> StereoMode {
    probe::multiview(gpu).unwrap().mode(gpu)
}

fn silent(gpu: &Gpu) {
    assert_eq!(gpu.messages().list(), Vec::<String>::new(), "validation");
    assert_eq!(gpu.messages().count(), 0);
}

/// Draws once and reads back.
struct Shot {
    color: [RgbaImage; 2],
    depth: [Vec<f32>; 2],
}

fn shoot(gpu: &Gpu, params: &RendererParams, scene: &Scene, eyes: &[Eye; 2]) -> Shot {
    let offscreen = Offscreen::new(gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(gpu, params).unwrap();
    renderer.draw(scene, eyes, &offscreen.target()).unwrap();
    Shot { color: offscreen.read_color().unwrap(), depth: offscreen.read_depth().unwrap() }
}

fn plain(mode: StereoMode, level: f32) -> RendererParams {
    RendererParams { backdrop: Backdrop::Plain([level, level, level, 1.0]), ..RendererParams::new(SIDE, SIDE, mode) }
}

fn field() -> Fov {
    Fov::symmetric(60_f32.to_radians(), 1.0)
}

/// Standing before the platform, as the stage has it.
fn standing() -> [Eye; 2] {
    Eye::looking_at(Vec3::new(0.0, 1.62, 1.3), Vec3::new(0.0, 1.25, -1.0), Fov::symmetric(1.35, 1.0)).pair(0.063)
}

/// A branching tree of `levels` by a fixed rule: enough like a grown one to judge pictures by.
fn grove(levels: u32, newest: u32) -> (Tree, Vec<f32>) {
    let mut tree = Tree { letters: vec!["A".to_owned()], ..Tree::default() };
    let mut push = |tree: &mut Tree, parent: u32, at: Vec3, order: u16, birth: u32| {
        tree.parent.push(parent);
        tree.position.push(at);
        tree.radius.push(0.01);
        tree.letter.push(0);
        tree.order.push(order);
        tree.birth.push(birth);
        tree.parent.len() as u32 - 1
    };
    let root = push(&mut tree, NO_PARENT, Vec3::ZERO, 0, 0);
    let mut tips = vec![(root, Quat::IDENTITY, 1.0_f32, 0_u16, 0.0_f32)];
    for level in 1..=levels {
        let mut next = Vec::new();
        for (node, turned, size, order, roll) in tips {
            let mut frame = turned;
            let mut at = node;
            for piece in 0..4 {
                let bend = 0.10 * ((level * 7 + piece * 3) as f32 + roll).sin();
                frame *= Quat::from_rotation_z(bend) * Quat::from_rotation_x(0.07 * (piece as f32 + roll).cos());
                let here = tree.position[at as usize] + frame * Vec3::Y * (0.17 * size);
                at = push(&mut tree, at, here, order, level);
                if piece == 1 && level > 1 {
                    let out = Quat::from_rotation_y(roll) * Quat::from_rotation_z(0.9);
                    next.push((at, frame * out, size * 0.62, order + 1, roll + 2.4));
                }
            }
            for side in 0..2 {
                let roll = roll + 2.4 + side as f32 * TAU / 2.0;
                let out = Quat::from_rotation_y(roll) * Quat::from_rotation_z(0.42);
                next.push((at, frame * out, size * 0.80, order + side as u16, roll));
            }
        }
        tips = next;
    }
    let before = ramus::tree::radii::da_vinci(&mut tree, &RadiusParams::default(), newest);
    (tree, before)
}

fn placed(tree: Tree, before: Vec<f32>, newest: u32, at: Affine3A) -> PlacedTree {
    PlacedTree {
        tree: Arc::new(tree),
        radius_before: Arc::new(before),
        revision: 1,
        world_from_tree: at,
        growth: 1.0,
        newest,
    }
}

fn disc(at: Vec3, radius: f32, thick: f32, color: [f32; 4]) -> Plate {
    Plate { world_from_plate: Affine3A::from_scale_rotation_translation(Vec3::new(radius, thick, radius), Quat::IDENTITY, at), color }
}

/// The whole stage: platform with a small sketch, tree behind, controllers, rays, board.
fn stage() -> Scene {
    let mut scene = Scene::default();
    let wood = [0.36, 0.24, 0.14, 1.0];
    scene.plates.push(disc(Vec3::new(0.0, 0.90, 0.0), 0.35, 0.04, wood));
    scene.plates.push(disc(Vec3::new(0.0, 0.86, 0.0), 0.06, 0.82, [0.22, 0.15, 0.10, 1.0]));
    scene.plates.push(disc(Vec3::new(0.0, 0.05, 0.0), 0.24, 0.05, wood));
    let mut last = Vec3::new(0.0, 0.90, 0.0);
    for step in 1..=8 {
        let t = step as f32 / 8.0;
        let next = Vec3::new(0.05 * (t * 5.0).sin(), 0.90 + 0.32 * t, 0.02 * (t * 3.0).cos());
        scene.rods.push(Rod { from: last, to: next, radius: 0.006, color: [0.80, 0.55, 0.20, 1.0] });
        scene.balls.push(Ball { center: next, radius: 0.010, color: [0.95, 0.85, 0.60, 1.0] });
        last = next;
    }
    scene.rods.push(Rod {
        from: Vec3::new(0.04, 1.06, 0.0),
        to: Vec3::new(0.17, 1.17, 0.05),
        radius: 0.006,
        color: [0.30, 0.75, 0.95, 0.45],
    });
    scene.balls.push(Ball { center: Vec3::new(0.17, 1.17, 0.05), radius: 0.014, color: [0.30, 0.75, 0.95, 0.45] });
    for (hand, x) in [(0, -0.22), (1, 0.26)] {
        let grip = Affine3A::from_rotation_translation(
            Quat::from_rotation_y(if hand == 0 { -0.3 } else { 0.3 }) * Quat::from_rotation_x(0.5),
            Vec3::new(x, 1.18, 0.62),
        );
        scene.controllers.push(Controller { world_from_grip: grip, hand, trigger: hand as f32 });
        scene.rods.push(Rod {
            from: Vec3::new(x, 1.20, 0.55),
            to: Vec3::new(x * 0.3, 1.10, 0.0),
            radius: 0.0015,
            color: [0.95, 0.95, 0.85, 0.6],
        });
    }
    let (tree, before) = grove(6, 6);
    scene.tree = Some(placed(tree, before, 6, Affine3A::from_translation(Vec3::new(0.0, 0.0, -2.6))));
    scene.board = Some(Board {
        world_from_board: Affine3A::from_rotation_translation(Quat::from_rotation_y(0.5), Vec3::new(-1.05, 1.45, -0.55)),
        size: [0.8, 0.5],
        revision: 1,
        content: Arc::default(),
    });
    scene
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
    let mut save = |name: &str, scene: &Scene, eye: Eye| {
        let shot = shoot(&gpu, &params, scene, &eye.pair(0.063));
        shot.color[0].save(out_dir().join(format!("{name}.png"))).unwrap();
    };
    save("standing", &scene, standing()[0]);
    let aim = |from: [f32; 3], to: [f32; 3], fov: f32| Eye::looking_at(from.into(), to.into(), Fov::symmetric(fov, 1.0));
    save("tree", &scene, aim([1.5, 1.6, 2.2], [0.0, 1.6, -2.6], 0.9));
    save("joint", &scene, aim([0.35, 1.15, -1.9], [0.0, 0.95, -2.6], 0.75));
    save("platform", &scene, aim([0.45, 1.45, 0.75], [0.0, 0.98, 0.0], 0.8));
    save("right", &scene, aim([0.0, 1.6, 1.3], [3.0, 1.9, 0.8], 1.3));
    save("wide", &scene, aim([5.0, 2.2, 5.0], [0.0, 1.2, -1.5], 1.0));
    scene.tree.as_mut().unwrap().growth = 0.4;
    save("growing", &scene, aim([1.5, 1.6, 2.2], [0.0, 1.6, -2.6], 0.9));
    save("hands", &scene, aim([0.0, 1.45, 0.95], [0.03, 1.15, 0.45], 0.9));
    silent(&gpu);
}
