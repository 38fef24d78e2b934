//! Once it is warm, drawing a frame allocates nothing on the heap and makes no pipeline.
#![allow(clippy::unwrap_used, reason = "tests")]

mod counting;

use std::sync::{Arc, atomic::AtomicBool};

use counting::allocations;
use glam::{Affine3A, Vec3};
use ramus::{
    mesh::{Mesh, display::Display},
    render::{Eye, Fov, Gpu, GpuParams, Headless, Offscreen, Renderer, RendererParams, StereoMode},
    tree::{NO_PARENT, Tree},
    world::scene::{
        Ball, Board, Controller, ModelLook, PlacedModel, PlacedTree, Plate, Rod, Scene, SurfaceLook,
    },
};

fn scene() -> Scene {
    let mut tree = Tree {
        letters: vec!["A".to_owned()],
        ..Tree::default()
    };
    for node in 0..500_u16 {
        tree.parent.push(if node == 0 {
            NO_PARENT
        } else {
            u32::from(node) - 1
        });
        tree.position.push(Vec3::new(
            0.1 * (f32::from(node) * 0.3).sin(),
            f32::from(node) * 0.004,
            -2.0,
        ));
        tree.radius.push(0.02);
        tree.letter.push(0);
        tree.order.push(0);
        tree.birth.push(u32::from(node) / 100);
    }
    let mut scene = Scene::default();
    for i in 0..50_u16 {
        let at = Vec3::new(f32::from(i) * 0.01, 1.0, -0.5);
        scene.rods.push(Rod {
            from: at,
            to: at + Vec3::Y,
            radius: 0.01,
            color: [0.5, 0.5, 0.5, if i % 2 == 0 { 1.0 } else { 0.4 }],
        });
        scene.balls.push(Ball {
            center: at,
            radius: 0.02,
            color: [0.5; 4],
        });
    }
    scene.plates.push(Plate {
        world_from_plate: Affine3A::IDENTITY,
        color: [0.5; 4],
    });
    scene.controllers.push(Controller {
        world_from_grip: Affine3A::IDENTITY,
        hand: 1,
        trigger: 0.5,
    });
    scene.board = Some(Board {
        world_from_board: Affine3A::IDENTITY,
        size: [0.8, 0.5],
        revision: 1,
        content: Arc::default(),
    });
    scene.tree = Some(PlacedTree {
        tree: Arc::new(tree),
        organs: Arc::default(),
        radius_before: Arc::default(),
        revision: 1,
        world_from_tree: Affine3A::IDENTITY,
        growth: 0.0,
        newest: 4,
    });
    let looks = [Some(SurfaceLook::Shaded), Some(SurfaceLook::XRay), None];
    scene
        .models
        .extend((1..).zip(looks).map(|(revision, surface)| PlacedModel {
            display: display(),
            revision,
            world_from_model: Affine3A::from_translation(Vec3::Y),
            look: ModelLook {
                surface,
                wireframe: true,
                vertices: true,
                ..ModelLook::default()
            },
        }));
    scene
}

/// A wavy sheet that has levels of detail.
fn display() -> Arc<Display> {
    const SIDE: u16 = 80;
    let point = |number: u16| {
        let (x, y) = (f32::from(number % SIDE), f32::from(number / SIDE));
        Vec3::new(x, y, (0.3 * x).sin() * (0.2 * y).cos()) / f32::from(SIDE)
    };
    let squares = (0..SIDE - 1).flat_map(|row| (0..SIDE - 1).map(move |at| row * SIDE + at));
    let triangles = squares.flat_map(|at| {
        let [a, b, c, d] = [at, at + 1, at + SIDE, at + SIDE + 1].map(u32::from);
        [[a, b, d], [a, d, c]]
    });
    let mesh = Mesh {
        positions: (0..SIDE * SIDE).map(point).collect(),
        triangles: triangles.collect(),
        ..Mesh::default()
    };
    let display = Display::new(Arc::new(mesh), None, &AtomicBool::new(false)).unwrap();
    assert!(
        display.levels.clusters.len() > display.levels.finest,
        "it has coarser levels"
    );
    Arc::new(display)
}

#[test]
fn a_warm_frame_allocates_nothing_and_makes_no_pipeline() {
    let gpu = match Gpu::new(&Headless::default(), &GpuParams::default()) {
        Ok(gpu) => gpu,
        Err(error) => {
            assert!(
                std::env::var("CI").is_err(),
                "CI needs a Vulkan device: {error}"
            );
            eprintln!("skipped: {error}");
            return;
        }
    };
    for mode in [StereoMode::Multiview, StereoMode::PerEye] {
        let params = RendererParams::new(32, 32, mode);
        let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
        let mut renderer = Renderer::new(&gpu, &params).unwrap();
        let mut scene = scene();
        let made = gpu.pipelines_made();
        assert!(made > 0, "the renderer makes its pipelines at its start");
        let mut counted = 0;
        for frame in 0..12_u16 {
            let t = f32::from(frame) / 12.0;
            let eyes = Eye::looking_at(
                Vec3::new(t, 1.5, 1.0),
                Vec3::new(0.0, 1.0, -1.0),
                Fov::symmetric(1.2, 1.0),
            )
            .pair(0.063);
            // Everything moves and the tree grows; the shadow is drawn again in each frame.
            if let Some(tree) = &mut scene.tree {
                tree.growth = t;
            }
            for model in &mut scene.models {
                model.world_from_model.translation.x = t;
            }
            let before = allocations();
            renderer.draw(&scene, &eyes, &offscreen.target()).unwrap();
            if frame >= 4 {
                counted += allocations() - before;
            }
        }
        assert_eq!(counted, 0, "allocations in eight warm frames ({mode:?})");
        assert_eq!(gpu.pipelines_made(), made, "pipelines of frames ({mode:?})");
    }
}
