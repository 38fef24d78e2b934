//! A device, one shot with both eyes, and scenes to shoot.

use std::{f32::consts::TAU, sync::Arc};

use glam::{Affine3A, Quat, Vec3};
use image::{Rgba, RgbaImage};
use ramus::{
    render::{
        Backdrop, Eye, Fov, Gpu, GpuParams, Headless, Offscreen, RenderError, Renderer,
        RendererParams, StereoMode, probe,
    },
    tree::{NO_PARENT, Tree, radii::RadiusParams},
    world::scene::{Ball, Board, Controller, PlacedTree, Plate, Rod, Scene},
};

pub(crate) const SIDE: u32 = 256;

/// A device with everything checked, or `None` (said aloud) where there is no Vulkan; CI must have one.
pub(crate) fn device() -> Option<Gpu> {
    match Gpu::new(&Headless::default(), &GpuParams::checked()) {
        Ok(gpu) => {
            assert!(
                gpu.info().validation || std::env::var("CI").is_err(),
                "CI needs the validation layer"
            );
            Some(gpu)
        }
        Err(
            error @ (RenderError::NoLoader(_)
            | RenderError::NoDevice(_)
            | RenderError::OldDriver { .. }),
        ) => {
            assert!(
                std::env::var("CI").is_err(),
                "CI needs a Vulkan device: {error}"
            );
            eprintln!("skipped: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// The mode that works here.
pub(crate) fn mode(gpu: &Gpu) -> StereoMode {
    probe::multiview(gpu).unwrap().mode(gpu)
}

pub(crate) fn silent(gpu: &Gpu) {
    assert_eq!(gpu.messages().list(), Vec::<String>::new(), "validation");
    assert_eq!(gpu.messages().count(), 0);
}

/// Draws once and reads back.
pub(crate) struct Shot {
    pub(crate) color: [RgbaImage; 2],
    pub(crate) depth: [Vec<f32>; 2],
}

pub(crate) fn shoot(gpu: &Gpu, params: &RendererParams, scene: &Scene, eyes: &[Eye; 2]) -> Shot {
    let offscreen = Offscreen::new(gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(gpu, params).unwrap();
    renderer.draw(scene, eyes, &offscreen.target()).unwrap();
    Shot {
        color: offscreen.read_color().unwrap(),
        depth: offscreen.read_depth().unwrap(),
    }
}

pub(crate) fn plain(mode: StereoMode, level: f32) -> RendererParams {
    RendererParams {
        backdrop: Backdrop::Plain([level, level, level, 1.0]),
        ..RendererParams::new(SIDE, SIDE, mode)
    }
}

pub(crate) fn field() -> Fov {
    Fov::symmetric(60_f32.to_radians(), 1.0)
}

/// Standing before the platform, as the stage has it.
pub(crate) fn standing() -> [Eye; 2] {
    Eye::looking_at(
        Vec3::new(0.0, 1.62, 1.3),
        Vec3::new(0.0, 1.25, -1.0),
        Fov::symmetric(1.35, 1.0),
    )
    .pair(0.063)
}

/// A branching tree of `levels` by a fixed rule: enough like a grown one to judge pictures by.
pub(crate) fn grove(levels: u32, newest: u32) -> (Tree, Vec<f32>) {
    let mut tree = Tree {
        letters: vec!["A".to_owned()],
        ..Tree::default()
    };
    let push = |tree: &mut Tree, parent: u32, at: Vec3, order: u16, birth: u32| {
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
                frame *= Quat::from_rotation_z(bend)
                    * Quat::from_rotation_x(0.07 * (piece as f32 + roll).cos());
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

pub(crate) fn placed(tree: Tree, before: Vec<f32>, newest: u32, at: Affine3A) -> PlacedTree {
    PlacedTree {
        tree: Arc::new(tree),
        organs: Arc::default(),
        radius_before: Arc::new(before),
        revision: 1,
        world_from_tree: at,
        growth: 1.0,
        newest,
    }
}

pub(crate) fn disc(at: Vec3, radius: f32, thick: f32, color: [f32; 4]) -> Plate {
    Plate {
        world_from_plate: Affine3A::from_scale_rotation_translation(
            Vec3::new(radius, thick, radius),
            Quat::IDENTITY,
            at,
        ),
        color,
    }
}

/// The whole stage: platform with a small sketch, tree behind, controllers, rays, board.
pub(crate) fn stage() -> Scene {
    let mut scene = Scene::default();
    let wood = [0.36, 0.24, 0.14, 1.0];
    scene
        .plates
        .push(disc(Vec3::new(0.0, 0.90, 0.0), 0.35, 0.04, wood));
    scene.plates.push(disc(
        Vec3::new(0.0, 0.86, 0.0),
        0.06,
        0.82,
        [0.22, 0.15, 0.10, 1.0],
    ));
    scene
        .plates
        .push(disc(Vec3::new(0.0, 0.05, 0.0), 0.24, 0.05, wood));
    let mut last = Vec3::new(0.0, 0.90, 0.0);
    for step in 1..=8 {
        let t = step as f32 / 8.0;
        let next = Vec3::new(
            0.05 * (t * 5.0).sin(),
            0.90 + 0.32 * t,
            0.02 * (t * 3.0).cos(),
        );
        scene.rods.push(Rod {
            from: last,
            to: next,
            radius: 0.006,
            color: [0.80, 0.55, 0.20, 1.0],
        });
        scene.balls.push(Ball {
            center: next,
            radius: 0.010,
            color: [0.95, 0.85, 0.60, 1.0],
        });
        last = next;
    }
    scene.rods.push(Rod {
        from: Vec3::new(0.04, 1.06, 0.0),
        to: Vec3::new(0.17, 1.17, 0.05),
        radius: 0.006,
        color: [0.30, 0.75, 0.95, 0.45],
    });
    scene.balls.push(Ball {
        center: Vec3::new(0.17, 1.17, 0.05),
        radius: 0.014,
        color: [0.30, 0.75, 0.95, 0.45],
    });
    for (hand, x) in [(0, -0.22), (1, 0.26)] {
        let grip = Affine3A::from_rotation_translation(
            Quat::from_rotation_y(if hand == 0 { -0.3 } else { 0.3 }) * Quat::from_rotation_x(0.5),
            Vec3::new(x, 1.18, 0.62),
        );
        scene.controllers.push(Controller {
            world_from_grip: grip,
            hand,
            trigger: hand as f32,
        });
        scene.rods.push(Rod {
            from: Vec3::new(x, 1.20, 0.55),
            to: Vec3::new(x * 0.3, 1.10, 0.0),
            radius: 0.0015,
            color: [0.95, 0.95, 0.85, 0.6],
        });
    }
    let (tree, before) = grove(6, 6);
    scene.tree = Some(placed(
        tree,
        before,
        6,
        Affine3A::from_translation(Vec3::new(0.0, 0.0, -2.6)),
    ));
    scene.board = Some(Board {
        world_from_board: Affine3A::from_rotation_translation(
            Quat::from_rotation_y(0.5),
            Vec3::new(-1.05, 1.45, -0.55),
        ),
        size: [0.8, 0.5],
        revision: 1,
        content: Arc::default(),
    });
    scene
}

/// Straight on at the origin from `distance` metres, both eyes 64 mm apart.
pub(crate) fn ahead(distance: f32) -> [Eye; 2] {
    Eye::looking_at(Vec3::new(0.0, 0.0, distance), Vec3::ZERO, field()).pair(0.064)
}

pub(crate) fn ball(center: Vec3, radius: f32, color: [f32; 4]) -> Scene {
    Scene {
        balls: vec![Ball {
            center,
            radius,
            color,
        }],
        ..Scene::default()
    }
}

/// Middle (in pixels) and number of the pixels that are not the background.
pub(crate) fn blob(picture: &RgbaImage, background: Rgba<u8>) -> (f32, f32, usize) {
    let found: Vec<_> = picture
        .enumerate_pixels()
        .filter(|(_, _, pixel)| **pixel != background)
        .collect();
    let n = found.len().max(1) as f32;
    let sum = |pick: fn(u32, u32) -> u32| {
        found
            .iter()
            .map(|(x, y, _)| pick(*x, *y) as f32 + 0.5)
            .sum::<f32>()
            / n
    };
    (sum(|x, _| x), sum(|_, y| y), found.len())
}

/// Pixels a unit of tangent.
pub(crate) fn pixels_per_tangent() -> f32 {
    SIDE as f32 / (2.0 * 30_f32.to_radians().tan())
}
