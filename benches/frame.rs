//! What our own part of a frame costs: `cargo bench --bench frame`.
//!
//! `record` is the time that `Renderer::draw` takes to hand over a frame of a scene with 100,000 segments, the driver's
//! share of recording included but the drawing itself not: the picture is 16 pixels wide and the device has finished before the
//! clock starts. `edit` is the same for a frame that brings a new tree: building its segments, staging memory, copies.
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
    render::{Eye, Fov, Gpu, GpuParams, Headless, Offscreen, Renderer, RendererParams, StereoMode},
    tree::{NO_PARENT, Tree},
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

fn scene(segments: u32) -> Scene {
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
        organs: Arc::default(),
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
    // The camera looks away from the tree: what is measured is ours, not the processor's drawing.
    let eyes = Eye::looking_at(
        Vec3::new(0.0, 1.6, 2.0),
        Vec3::new(0.0, 1.6, 9.0),
        Fov::symmetric(1.0, 1.0),
    )
    .pair(0.063);
    let mut group = criterion.benchmark_group("frame");
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(5));
    for segments in [1_000, 100_000] {
        let mut scene = scene(segments);
        let mut renderer = Renderer::new(&gpu, &params).unwrap();
        let mut timed = |scene: &Scene| {
            gpu.wait_idle().unwrap();
            let start = Instant::now();
            black_box(renderer.draw(scene, &eyes, &offscreen.target()).unwrap());
            start.elapsed()
        };
        timed(&scene);
        group.bench_function(format!("record/{segments}"), |bencher| {
            bencher.iter_custom(|rounds| (0..rounds).map(|_| timed(&scene)).sum());
        });
        group.bench_function(format!("edit/{segments}"), |bencher| {
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
