//! What our own part of a frame costs: `cargo bench --bench frame`.
//!
//! `record` is the time that `Renderer::draw` takes to hand over a frame of a scene with so many segments, the driver's
//! share of recording included but the drawing itself not: the picture is 16 pixels wide and the device has finished before the
//! clock starts. With `leaves`, one in five segments bears one. `edit` is the same for a frame that brings a new tree: building its segments and levels of
//! detail, staging memory, copies. `ready` is all our own time from a tree that is new to one that is drawn: the same on a worker, then the frames that copy it.
//! Wall-clock numbers of a shared machine are pessimistic; compare runs, not machines.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    reason = "a benchmark"
)]

use std::{
    hint::black_box,
    sync::Arc,
    time::{Duration, Instant},
};

use criterion::{Criterion, criterion_group, criterion_main};
use glam::{Affine3A, Quat, Vec3};
use ramus::{
    render::{
        Eye, Fov, Gpu, GpuParams, Headless, Offscreen, Renderer, RendererParams, StereoMode,
        TreeState, TreeUpload,
    },
    tree::{
        NO_PARENT, Organs, Tree,
        foliage::{Bearing, kind},
        organs::{Paint, Placed},
    },
    world::scene::{Ball, PlacedTree, Rod, Scene},
};

/// A tree of `segments`, each branch of ten segments starting on an earlier one.
fn tree(segments: u32) -> Tree {
    let mut tree = Tree {
        letters: vec!["A".to_owned()],
        ..Tree::default()
    };
    for node in 0..=segments {
        let parent = if node == 0 {
            NO_PARENT
        } else if node % 10 == 1 && node > 10 {
            node / 10
        } else {
            node - 1
        };
        let turned = Quat::from_rotation_y(node as f32 * 2.4) * Quat::from_rotation_z(0.5);
        let from = if parent == NO_PARENT {
            Vec3::ZERO
        } else {
            tree.position[parent as usize]
        };
        tree.parent.push(parent);
        tree.position.push(from + turned * Vec3::Y * 0.02);
        tree.radius.push(0.004);
        tree.letter.push(0);
        tree.order.push(0);
        tree.birth.push(node % 5);
    }
    tree
}

/// So many leaves, on nodes all over a tree.
fn organs(segments: u32, leaves: u32) -> Organs {
    let leaf = Bearing::of(kind("maple").unwrap());
    let placed = (0..leaves).map(|at| Placed {
        surface: 0,
        paint: Paint::default(),
        position: Vec3::new((at % 100) as f32, (at / 100 % 100) as f32, 0.0) * 0.1,
        orientation: Quat::from_rotation_y(at as f32),
        scale: 0.05,
        birth: 0,
        node: at * (segments / leaves),
        light: 0.7,
    });
    if leaves == 0 {
        return Organs::default();
    }
    Organs {
        surfaces: vec![leaf.surface],
        placed: placed.collect(),
        ..Organs::default()
    }
}

fn scene(segments: u32, leaves: u32) -> Scene {
    let mut scene = Scene::default();
    for i in 0..200_u16 {
        let at = Vec3::new(f32::from(i) * 0.001, 1.0, 0.0);
        scene.rods.push(Rod {
            from: at,
            to: at + Vec3::Y * 0.1,
            radius: 0.005,
            color: [1.0; 4],
        });
        scene.balls.push(Ball {
            center: at,
            radius: 0.01,
            color: [1.0; 4],
        });
    }
    scene.tree = Some(PlacedTree {
        tree: Arc::new(tree(segments)),
        organs: Arc::new(organs(segments, leaves)),
        radius_before: Arc::default(),
        revision: 1,
        world_from_tree: Affine3A::IDENTITY,
        growth: 1.0,
        newest: 5,
    });
    scene
}

fn frame(criterion: &mut Criterion) {
    let gpu = match Gpu::new(&Headless::default(), &GpuParams::default()) {
        Ok(gpu) => gpu,
        Err(error) => {
            eprintln!("skipped: {error}");
            return;
        }
    };
    let params = RendererParams::new(16, 16, StereoMode::Multiview);
    let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
    // All of it is in sight, far away.
    let eyes = Eye::looking_at(
        Vec3::new(0.0, 1.6, 30.0),
        Vec3::new(0.0, 1.6, 0.0),
        Fov::symmetric(1.0, 1.0),
    )
    .pair(0.063);
    let mut group = criterion.benchmark_group("frame");
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(5));
    for (segments, leaves) in [
        (1_000, 0),
        (100_000, 0),
        (1_000_000, 0),
        (10_000_000, 2_000_000),
    ] {
        let name = if leaves > 0 { " with leaves" } else { "" };
        let mut scene = scene(segments, leaves);
        // As a worker does it.
        let params = RendererParams {
            direct_segments: if segments > 100_000 { 0 } else { 100_000 },
            ..params
        };
        let mut renderer = Renderer::new(&gpu, &params).unwrap();
        let mut timed = |scene: &Scene| {
            gpu.wait_idle().unwrap();
            let start = Instant::now();
            let placed = scene.tree.as_ref().unwrap();
            let mut report = renderer.draw(scene, &eyes, &offscreen.target()).unwrap();
            if report.tree == TreeState::Wanted(placed.revision) {
                renderer.set_tree(TreeUpload::new(&gpu, placed).unwrap());
            }
            let mut spent = start.elapsed();
            while report.tree != TreeState::Shown {
                gpu.wait_idle().unwrap();
                let start = Instant::now();
                report = renderer.draw(scene, &eyes, &offscreen.target()).unwrap();
                spent += start.elapsed();
            }
            black_box(spent)
        };
        timed(&scene);
        group.bench_function(format!("record/{segments}{name}"), |bencher| {
            bencher.iter_custom(|rounds| (0..rounds).map(|_| timed(&scene)).sum());
        });
        if segments > 1_000_000 {
            continue;
        }
        let what = if segments > 100_000 { "ready" } else { "edit" };
        group.bench_function(format!("{what}/{segments}"), |bencher| {
            bencher.iter_custom(|rounds| {
                (0..rounds)
                    .map(|_| {
                        scene.tree.as_mut().unwrap().revision += 1;
                        timed(&scene)
                    })
                    .sum()
            });
        });
        gpu.wait_idle().unwrap();
    }
    group.finish();
}

criterion_group!(benches, frame);
criterion_main!(benches);
