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
use glam::{Affine3A, Quat, Vec3};
use image::{Rgba, RgbaImage};
use ramus::{
    render::{
        Backdrop, Eye, Fov, Gpu, GpuParams, Headless, NEAR, Offscreen, RenderError, Renderer,
        RendererParams, StereoMode, TreeState, TreeUpload, probe,
    },
    tree::{NO_PARENT, Tree, radii::RadiusParams},
    world::scene::{Ball, Board, Controller, PlacedTree, Plate, Rod, Scene},
};

const SIDE: u32 = 256;

/// A device with everything checked, or `None` (said aloud) where there is no Vulkan; CI must have one.
fn device() -> Option<Gpu> {
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
    Shot {
        color: offscreen.read_color().unwrap(),
        depth: offscreen.read_depth().unwrap(),
    }
}

fn plain(mode: StereoMode, level: f32) -> RendererParams {
    RendererParams {
        backdrop: Backdrop::Plain([level, level, level, 1.0]),
        ..RendererParams::new(SIDE, SIDE, mode)
    }
}

fn field() -> Fov {
    Fov::symmetric(60_f32.to_radians(), 1.0)
}

/// Standing before the platform, as the stage has it.
fn standing() -> [Eye; 2] {
    Eye::looking_at(
        Vec3::new(0.0, 1.62, 1.3),
        Vec3::new(0.0, 1.25, -1.0),
        Fov::symmetric(1.35, 1.0),
    )
    .pair(0.063)
}

/// A branching tree of `levels` by a fixed rule: enough like a grown one to judge pictures by.
fn grove(levels: u32, newest: u32) -> (Tree, Vec<f32>) {
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
fn stage() -> Scene {
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
fn ahead(distance: f32) -> [Eye; 2] {
    Eye::looking_at(Vec3::new(0.0, 0.0, distance), Vec3::ZERO, field()).pair(0.064)
}

fn ball(center: Vec3, radius: f32, color: [f32; 4]) -> Scene {
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
fn blob(picture: &RgbaImage, background: Rgba<u8>) -> (f32, f32, usize) {
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
fn pixels_per_tangent() -> f32 {
    SIDE as f32 / (2.0 * 30_f32.to_radians().tan())
}

#[test]
fn half_grey_reads_back_as_188() {
    let Some(gpu) = device() else { return };
    for mode in [mode(&gpu), StereoMode::PerEye] {
        let shot = shoot(&gpu, &plain(mode, 0.5), &Scene::default(), &ahead(1.0));
        for (eye, picture) in shot.color.iter().enumerate() {
            // 187.52 exactly; lavapipe's encoding of sRGB is a little low and gives 187. Unencoded it would be 128, encoded twice 222.
            let grey = |pixel: &Rgba<u8>| {
                pixel.0[..3].iter().all(|byte| (187..=188).contains(byte)) && pixel.0[3] == 255
            };
            assert!(
                picture.pixels().all(grey),
                "{mode:?} {eye}: {:?}",
                picture.get_pixel(9, 9)
            );
        }
        assert!(
            shot.depth.iter().flatten().all(|depth| *depth == 0.0),
            "nothing there: infinitely far"
        );
    }
    silent(&gpu);
}

#[test]
fn both_ways_to_two_eyes_give_the_same_bits() {
    let Some(gpu) = device() else { return };
    if mode(&gpu) == StereoMode::PerEye {
        assert!(
            std::env::var("CI").is_err(),
            "CI needs a driver whose multiview works"
        );
        eprintln!("skipped: multiview is broken here");
        return;
    }
    let scene = stage();
    let [both, each] = [StereoMode::Multiview, StereoMode::PerEye].map(|mode| {
        shoot(
            &gpu,
            &RendererParams::new(SIDE, SIDE, mode),
            &scene,
            &standing(),
        )
    });
    for eye in 0..2 {
        let differ = both.color[eye]
            .pixels()
            .zip(each.color[eye].pixels())
            .filter(|(a, b)| a != b)
            .count();
        assert_eq!(differ, 0, "colours of eye {eye}");
        assert!(both.depth[eye] == each.depth[eye], "depths of eye {eye}");
    }
    assert!(
        both.color[0] != both.color[1],
        "the eyes see different pictures"
    );
    silent(&gpu);
}

#[test]
fn a_ball_is_where_it_should_be_in_each_eye() {
    let Some(gpu) = device() else { return };
    let black = Rgba([0, 0, 0, 255]);
    for (center, radius, distance) in [
        (Vec3::ZERO, 0.2, 2.0),
        (Vec3::new(0.3, 0.2, 0.0), 0.1, 2.0),
        (Vec3::new(-0.4, -0.5, -1.0), 0.15, 1.5),
    ] {
        let scene = ball(center, radius, [0.9, 0.2, 0.1, 1.0]);
        let eyes = ahead(distance);
        let shot = shoot(&gpu, &plain(mode(&gpu), 0.0), &scene, &eyes);
        let depth = distance - center.z;
        let mut middles = [0.0; 2];
        for (eye, side) in [(0, -0.032), (1, 0.032)] {
            let (x, y, count) = blob(&shot.color[eye], black);
            middles[eye] = x;
            let scale = pixels_per_tangent();
            let expected = (
                SIDE as f32 / 2.0 + (center.x - side) / depth * scale,
                SIDE as f32 / 2.0 - center.y / depth * scale,
            );
            assert!(
                (x - expected.0).abs() < 0.8 && (y - expected.1).abs() < 0.8,
                "eye {eye}: {x}, {y} against {expected:?}"
            );
            let seen = (radius / depth).asin().tan() * scale;
            let area = std::f32::consts::PI * seen * seen;
            let across = (center.x - side).hypot(center.y) / depth;
            // Off the axis a sphere's picture is a little longer than wide; partly covered pixels count whole.
            let rim = TAU * seen * 0.75;
            let (low, high) = (
                area * 0.96,
                area * (1.0 + across * across * 1.5) * 1.02 + rim,
            );
            assert!(
                (low..high).contains(&(count as f32)),
                "{count} pixels against {low}..{high}"
            );
        }
        let disparity = middles[0] - middles[1];
        let expected = 0.064 / depth * pixels_per_tangent();
        assert!(
            (disparity - expected).abs() < 0.6,
            "left sees it further right: {disparity} against {expected}"
        );
    }
    silent(&gpu);
}

#[test]
fn depth_is_near_over_distance() {
    let Some(gpu) = device() else { return };
    for distance in [0.5_f32, 2.0, 9.0] {
        let scene = ball(Vec3::ZERO, 0.1 * distance, [1.0; 4]);
        let shot = shoot(&gpu, &plain(mode(&gpu), 0.0), &scene, &ahead(distance));
        let expected = NEAR / (distance * 0.9);
        for (eye, depth) in shot.depth.iter().enumerate() {
            let at = |x: u32, y: u32| depth[(y * SIDE + x) as usize];
            let x = SIDE / 2
                + if eye == 0 { 1 } else { 0 } * (0.032 / distance * pixels_per_tangent()) as u32;
            let found = if eye == 0 {
                at(x, SIDE / 2)
            } else {
                depth.iter().copied().fold(0.0, f32::max)
            };
            assert!(
                (found / expected - 1.0).abs() < 0.02,
                "{distance} m, eye {eye}: {found} against {expected}"
            );
            assert_eq!(at(2, 2), 0.0, "the background is infinitely far");
        }
    }
    silent(&gpu);
}

/// A trunk that bends and tapers; every row of the picture crosses it once.
fn bent(newest: u32) -> PlacedTree {
    let mut tree = Tree {
        letters: vec!["A".to_owned()],
        ..Tree::default()
    };
    for i in 0..9_u32 {
        let t = i as f32 / 8.0;
        tree.parent.push(if i == 0 { NO_PARENT } else { i - 1 });
        tree.position.push(Vec3::new(
            if i % 2 == 0 { -0.11 } else { 0.11 },
            -0.45 + 0.9 * t,
            0.08 * (t * 9.0).sin(),
        ));
        tree.radius.push(0.10 - 0.055 * t);
        tree.letter.push(0);
        tree.order.push(0);
        tree.birth.push(i);
    }
    let before = tree.radius.iter().map(|radius| radius * 0.6).collect();
    placed(tree, before, newest, Affine3A::IDENTITY)
}

#[test]
fn joints_have_no_cracks() {
    let Some(gpu) = device() else { return };
    let magenta = [1.0, 0.0, 1.0, 1.0];
    for (newest, growth) in [(99, 1.0), (5, 1.0), (5, 0.5), (1, 0.37)] {
        let mut tree = bent(newest);
        tree.growth = growth;
        let scene = Scene {
            tree: Some(tree),
            ..Scene::default()
        };
        let params = RendererParams {
            backdrop: Backdrop::Plain(magenta),
            ..RendererParams::new(SIDE, SIDE, mode(&gpu))
        };
        let shot = shoot(&gpu, &params, &scene, &ahead(1.2));
        for picture in &shot.color {
            let mut rows = 0;
            for y in 0..SIDE {
                // Anything that the background shines through counts as a hole: bark is less blue than green, magenta is not.
                let bark = |x: &u32| {
                    i32::from(picture.get_pixel(*x, y).0[2])
                        - i32::from(picture.get_pixel(*x, y).0[1])
                        < 30
                };
                let solid: Vec<u32> = (0..SIDE).filter(bark).collect();
                let (Some(first), Some(last)) = (solid.first(), solid.last()) else {
                    continue;
                };
                rows += 1;
                assert_eq!(
                    solid.len() as u32,
                    last - first + 1,
                    "a hole in row {y} at growth {growth} (newest {newest})"
                );
            }
            assert!(rows > 20, "{rows} rows of trunk");
        }
    }
    silent(&gpu);
}

/// Pixels whose depths differ by more than rounding.
fn differing(a: &[f32], b: &[f32]) -> usize {
    a.iter()
        .zip(b)
        .filter(|(a, b)| (*a - *b).abs() > 1e-6 + a.abs() * 1e-5)
        .count()
}

#[test]
fn growth_runs_from_the_step_before_to_the_whole_tree() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.3);
    let eyes =
        Eye::looking_at(Vec3::new(0.6, 1.0, 2.2), Vec3::new(0.0, 1.0, 0.0), field()).pair(0.064);
    let depth = |tree: PlacedTree| {
        shoot(
            &gpu,
            &params,
            &Scene {
                tree: Some(tree),
                ..Scene::default()
            },
            &eyes,
        )
        .depth
    };
    let at = |growth: f32| {
        let (tree, before) = grove(4, 4);
        PlacedTree {
            growth,
            ..placed(tree, before, 4, Affine3A::IDENTITY)
        }
    };
    // One step earlier: the nodes born before, at the radii they had.
    let (mut earlier, before) = grove(4, 4);
    let kept: Vec<usize> = (0..earlier.len())
        .filter(|node| earlier.birth[*node] < 4)
        .collect();
    let number = |node: u32| {
        kept.iter()
            .position(|old| *old == node as usize)
            .map_or(NO_PARENT, |new| new as u32)
    };
    earlier = Tree {
        parent: kept
            .iter()
            .map(|node| {
                if earlier.parent[*node] == NO_PARENT {
                    NO_PARENT
                } else {
                    number(earlier.parent[*node])
                }
            })
            .collect(),
        position: kept.iter().map(|node| earlier.position[*node]).collect(),
        radius: kept.iter().map(|node| before[*node]).collect(),
        letter: kept.iter().map(|node| earlier.letter[*node]).collect(),
        order: kept.iter().map(|node| earlier.order[*node]).collect(),
        birth: kept.iter().map(|node| earlier.birth[*node]).collect(),
        letters: earlier.letters,
    };
    earlier.validate().unwrap();
    let earlier = depth(placed(earlier, Vec::new(), 99, Affine3A::IDENTITY));
    let begun = depth(at(0.0));
    let half = depth(at(0.5));
    let whole = depth(at(1.0));
    let (tree, _) = grove(4, 4);
    let still = depth(placed(tree, Vec::new(), 99, Affine3A::IDENTITY));
    for eye in 0..2 {
        // Shared rings bend towards the segments that are about to grow, and tips lose their caps: a few pixels.
        let differ = differing(&begun[eye], &earlier[eye]);
        let trunk = earlier[eye].iter().filter(|depth| **depth > 0.0).count();
        assert!(
            trunk > 300 && differ * 50 < trunk,
            "growth 0: {differ} of {trunk} pixels differ from the step before"
        );
        assert_eq!(
            differing(&whole[eye], &still[eye]),
            0,
            "growth 1 is the whole tree"
        );
        let covered = |depth: &[f32]| depth.iter().filter(|depth| **depth > 0.0).count();
        let [a, b, c] = [
            covered(&begun[eye]),
            covered(&half[eye]),
            covered(&whole[eye]),
        ];
        assert!(a < b && b < c, "it grows: {a} {b} {c}");
    }
    silent(&gpu);
}

#[test]
fn large_trees_come_from_a_worker_and_in_chunks() {
    let Some(gpu) = device() else { return };
    let mode = mode(&gpu);
    let (tree, before) = grove(5, 5);
    let scene = Scene {
        tree: Some(placed(tree, before, 5, Affine3A::IDENTITY)),
        ..Scene::default()
    };
    let tree = scene.tree.clone().unwrap();
    let eyes =
        Eye::looking_at(Vec3::new(0.0, 1.4, 4.0), Vec3::new(0.0, 1.3, 0.0), field()).pair(0.064);
    let whole = shoot(&gpu, &plain(mode, 0.3), &scene, &eyes);

    let params = RendererParams {
        direct_segments: 10,
        ..plain(mode, 0.3)
    };
    let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(&gpu, &params).unwrap();
    let draw = |renderer: &mut Renderer, scene: &Scene| {
        renderer.draw(scene, &eyes, &offscreen.target()).unwrap()
    };
    let report = draw(&mut renderer, &scene);
    assert_eq!((report.tree, report.segments), (TreeState::Wanted(1), 0));

    let worker = gpu.clone();
    let upload = std::thread::spawn(move || {
        let mut segments = Vec::new();
        ramus::tree::tubes::segments(&tree.tree, &tree.radius_before, tree.newest, &mut segments);
        // 1,000 bytes: one batch of eight a chunk.
        TreeUpload::in_chunks(&worker, &segments, tree.revision, 1000).unwrap()
    });
    renderer.set_tree(upload.join().unwrap());
    let report = draw(&mut renderer, &scene);
    assert_eq!(report.tree, TreeState::Shown);
    assert!(
        report.segments > 300 && report.draws > report.segments / 8,
        "{report:?}"
    );
    let chunked = offscreen.read_color().unwrap();
    assert!(
        chunked[0] == whole.color[0] && chunked[1] == whole.color[1],
        "chunks change nothing"
    );

    // A new revision that is not there yet: the old tree stays; without a tree it goes.
    let mut later = scene.clone();
    later.tree.as_mut().unwrap().revision = 2;
    let report = draw(&mut renderer, &later);
    assert_eq!(report.tree, TreeState::Wanted(2));
    assert!(
        report.segments > 300,
        "the last tree is shown until the next is there"
    );
    let report = draw(&mut renderer, &Scene::default());
    assert_eq!((report.tree, report.segments), (TreeState::None, 0));
    drop(renderer);
    silent(&gpu);
}

#[test]
fn ghosts_let_half_of_the_light_through() {
    let Some(gpu) = device() else { return };
    let mut scene = ball(Vec3::ZERO, 0.3, [0.8, 0.8, 0.8, 1.0]);
    let solid = shoot(&gpu, &plain(mode(&gpu), 0.0), &scene, &ahead(1.0));
    scene.balls[0].color[3] = 0.5;
    // Twice the same ghost: overlaps do not add up.
    scene.balls.push(scene.balls[0]);
    let ghost = shoot(&gpu, &plain(mode(&gpu), 0.0), &scene, &ahead(1.0));
    let light = |picture: &RgbaImage| {
        let linear = |byte: u8| (f32::from(byte) / 255.0).powf(2.2);
        picture
            .pixels()
            .map(|pixel| linear(pixel.0[1]))
            .sum::<f32>()
    };
    for eye in 0..2 {
        let share = light(&ghost.color[eye]) / light(&solid.color[eye]);
        assert!((share - 0.5).abs() < 0.05, "eye {eye}: {share}");
    }
    silent(&gpu);
}

/// egui's output for a panel of 400 × 250 pixels: four coloured quarters, no text.
fn quarters() -> Vec<egui::ClippedPrimitive> {
    let rect = |x: f32, y: f32, color: egui::Color32| {
        let mut mesh = egui::Mesh::default();
        mesh.add_colored_rect(
            egui::Rect::from_min_size(egui::pos2(x, y), egui::vec2(100.0, 62.5)),
            color,
        );
        egui::ClippedPrimitive {
            clip_rect: egui::Rect::EVERYTHING,
            primitive: egui::epaint::Primitive::Mesh(mesh),
        }
    };
    vec![
        rect(0.0, 0.0, egui::Color32::from_rgb(200, 100, 50)),
        rect(100.0, 0.0, egui::Color32::from_rgb(20, 160, 60)),
        rect(0.0, 62.5, egui::Color32::from_rgb(30, 60, 220)),
        rect(100.0, 62.5, egui::Color32::from_rgb(128, 128, 128)),
    ]
}

#[test]
fn the_board_shows_what_egui_painted_upright_and_in_its_colours() {
    let Some(gpu) = device() else { return };
    let mode = mode(&gpu);
    let params = plain(mode, 0.0);
    let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(&gpu, &params).unwrap();
    let board = Board {
        world_from_board: Affine3A::IDENTITY,
        size: [0.8, 0.5],
        revision: 1,
        content: Arc::default(),
    };
    let scene = Scene {
        board: Some(board),
        ..Scene::default()
    };
    let eyes = ahead(0.8);
    // A font texture of one white pixel: what `add_colored_rect` refers to.
    let mut textures = egui::TexturesDelta::default();
    let white = egui::ColorImage::filled([2, 2], egui::Color32::WHITE);
    textures.push(
        egui::TextureId::default(),
        egui::epaint::ImageDelta::full(white, egui::TextureOptions::LINEAR),
    );
    for round in 0..3 {
        renderer
            .paint_panel(&quarters(), &mut textures, [400, 250], 2.0)
            .unwrap();
        assert!(textures.is_empty(), "taken over");
        renderer.draw(&scene, &eyes, &offscreen.target()).unwrap();
        let pictures = offscreen.read_color().unwrap();
        for (eye, side) in [(0, -0.032), (1, 0.032)] {
            for (x, y, expected) in [
                (-0.2, 0.12, [200, 100, 50]),
                (0.2, 0.12, [20, 160, 60]),
                (-0.2, -0.12, [30, 60, 220]),
                (0.2, -0.12, [128, 128, 128]),
            ] {
                let scale = pixels_per_tangent() / 0.8;
                let half = SIDE as f32 / 2.0;
                let pixel = pictures[eye].get_pixel(
                    (half + (x - side) * scale) as u32,
                    (half - y * scale) as u32,
                );
                for channel in 0..3 {
                    assert!(
                        pixel.0[channel].abs_diff(expected[channel]) <= 2,
                        "round {round}, eye {eye}: {pixel:?} against {expected:?}"
                    );
                }
            }
        }
        textures.push(
            egui::TextureId::default(),
            egui::epaint::ImageDelta::partial(
                [1, 0],
                egui::ColorImage::filled([1, 1], egui::Color32::WHITE),
                egui::TextureOptions::LINEAR,
            ),
        );
    }
    // A texture that does not fit is refused in a sentence and breaks nothing.
    let outside = egui::ColorImage::filled([9, 9], egui::Color32::WHITE);
    textures.push(
        egui::TextureId::default(),
        egui::epaint::ImageDelta::partial([1, 1], outside, egui::TextureOptions::LINEAR),
    );
    assert!(
        renderer
            .paint_panel(&quarters(), &mut textures, [400, 250], 2.0)
            .is_err()
    );
    renderer.draw(&scene, &eyes, &offscreen.target()).unwrap();
    drop(renderer);
    silent(&gpu);
}

#[test]
fn nonsense_is_drawn_without_harm() {
    let Some(gpu) = device() else { return };
    let mut scene = stage();
    for (n, bad) in [f32::NAN, f32::INFINITY, -1.0, 1e30, 0.0]
        .into_iter()
        .enumerate()
    {
        scene.balls.push(Ball {
            center: Vec3::splat(bad),
            radius: bad,
            color: [bad; 4],
        });
        scene.rods.push(Rod {
            from: Vec3::splat(bad),
            to: Vec3::ZERO,
            radius: 0.01,
            color: [1.0; 4],
        });
        scene
            .plates
            .push(disc(Vec3::splat(bad), bad, bad, [bad; 4]));
        let tree = scene.tree.as_mut().unwrap();
        tree.growth = bad;
        tree.world_from_tree = Affine3A::from_scale(Vec3::splat(bad));
        tree.revision = n as u64;
        let mut eyes = standing();
        eyes[1].world_from_eye.position.x = bad;
        eyes[0].fov.left = bad;
        let shot = shoot(
            &gpu,
            &RendererParams::new(64, 64, mode(&gpu)),
            &scene,
            &eyes,
        );
        assert_eq!(shot.color[0].dimensions(), (64, 64));
    }
    silent(&gpu);
}

#[test]
fn what_cannot_be_done_is_said_in_a_sentence() {
    let nobody = Headless {
        device: Some("No Such Card 9000".to_owned()),
    };
    match Gpu::new(&nobody, &GpuParams::default()) {
        Err(RenderError::NoLoader(_)) => {}
        Err(error) => assert!(
            error.to_string().contains("No Such Card 9000")
                && error.to_string().contains("install"),
            "{error}"
        ),
        Ok(_) => panic!("there is no such card"),
    }
    let Some(gpu) = device() else { return };
    for (width, height) in [(0, 5), (5, 0), (1 << 20, 8)] {
        let Err(error) = Offscreen::new(&gpu, vk::Extent2D { width, height }) else {
            panic!("{width} × {height}")
        };
        assert!(
            error.to_string().contains("cannot be drawn here"),
            "{error}"
        );
    }
    let offscreen = Offscreen::new(
        &gpu,
        vk::Extent2D {
            width: 32,
            height: 32,
        },
    )
    .unwrap();
    let mut renderer = Renderer::new(&gpu, &plain(mode(&gpu), 0.0)).unwrap();
    let error = renderer
        .draw(&Scene::default(), &ahead(1.0), &offscreen.target())
        .unwrap_err();
    assert!(error.to_string().contains("make a new renderer"), "{error}");
    drop(renderer);
    silent(&gpu);
}

/// Run in a process of its own by the next test.
#[test]
#[ignore = "needs a driver whose multiview is broken"]
fn broken_multiview_is_found() {
    let gpu = device().unwrap();
    assert_eq!(
        probe::multiview(&gpu).unwrap(),
        probe::Multiview::Broken,
        "{:?}",
        gpu.info()
    );
    // The other way is right: each eye sees the ball, at its own place.
    let scene = ball(Vec3::ZERO, 0.2, [0.9, 0.2, 0.1, 1.0]);
    let shot = shoot(&gpu, &plain(mode(&gpu), 0.0), &scene, &ahead(2.0));
    let [left, right] = [0, 1].map(|eye| blob(&shot.color[eye], Rgba([0, 0, 0, 255])));
    assert!(
        left.2 > 500 && right.2 > 500 && left.0 > right.0 + 3.0,
        "{left:?} {right:?}"
    );
    silent(&gpu);
}

/// Where `RAMUS_BROKEN_DRIVER` names the ICD file of a driver with broken multiview (Mesa 22's lavapipe).
#[test]
fn a_broken_driver_falls_back_to_one_pass_an_eye() {
    let Some(file) = std::env::var_os("RAMUS_BROKEN_DRIVER") else {
        eprintln!("skipped: RAMUS_BROKEN_DRIVER names no driver");
        return;
    };
    let output = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "broken_multiview_is_found", "--ignored"])
        .env("VK_ICD_FILENAMES", &file)
        .env("VK_DRIVER_FILES", &file)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stdout)
    );
}

/// Compares with `tests/images/NAME.png`, or rewrites it.
fn snapshot(name: &str, picture: &RgbaImage) {
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
