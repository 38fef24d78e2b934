//! What our own part of a frame costs: `cargo bench --bench frame`.
//!
//! `record` is the time that `Renderer::draw` takes to hand over a frame of a scene with so many segments, the driver's
//! share of recording included but the drawing itself not: the picture is 16 pixels wide and the device has finished before the
//! clock starts. With `leaves`, one in five segments bears one. `a wood` is as many trees as can be planted. `edit` is the same for a frame that brings a new tree: building its segments and levels of
//! detail, staging memory, copies; nothing of it is as it was, or with `a hundredth` all but that. `ready` is all our own time from a tree that is new to one that is drawn: the same on a worker, then the frames that copy it.
//! `whole` is a frame of 256 pixels an eye with all that the device does for it, in each light and with wind; on a software device that is nearly all.
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
    sync::{Arc, atomic::AtomicBool},
    time::{Duration, Instant},
};

use criterion::{Criterion, criterion_group, criterion_main};
use glam::{Affine3A, Quat, Vec3};
use ramus::{
    mesh::{Mesh, display::Display},
    render::{
        Eye, Fov, Gpu, GpuParams, Headless, Offscreen, Renderer, RendererParams, StereoMode,
        TreeState, TreeUpload,
    },
    tree::{
        NO_PARENT, Organs, Tree,
        foliage::{Bearing, kind},
        organs::{Paint, Placed},
    },
    world::scene::{
        Ball, ModelLook, PlacedModel, PlacedTree, Rod, Scene,
        weather::{Light, Sway, Wind},
    },
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

/// The same scene, its tree's nodes moved from this one on.
fn moved(scene: &Scene, from: u32) -> Scene {
    let mut scene = scene.clone();
    let placed = scene.tree.as_mut().unwrap();
    let mut tree = (*placed.tree).clone();
    for position in tree.position.iter_mut().skip(from as usize) {
        *position += Vec3::X * 0.01;
    }
    placed.tree = Arc::new(tree);
    scene
}

/// As many trees as can be planted, of eight meshes of 20,000 triangles: those of one mesh one after the other, as the world shows them.
fn wood() -> Scene {
    let display = |turn: f32| {
        let mut mesh = Mesh::default();
        for leaf in 0..20_000_u32 {
            let turned = Quat::from_rotation_y(leaf as f32 * 2.4 + turn);
            let place = turned * Vec3::new((leaf % 97) as f32 * 0.02, leaf as f32 * 2e-4, 0.0);
            let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|at| place + turned * at * 0.06);
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners);
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        Arc::new(Display::new(Arc::new(mesh), None, &AtomicBool::new(false)).unwrap())
    };
    let displays: Vec<_> = (0..8_u8).map(|turn| display(f32::from(turn))).collect();
    let look = ModelLook {
        shadow: true,
        ..ModelLook::default()
    };
    let models = (0..256_usize).map(|at| {
        let place = Vec3::new((at % 16) as f32 * 4.0 - 30.0, 0.0, (at / 16) as f32 * -4.0);
        PlacedModel {
            display: Arc::clone(&displays[at / 32]),
            revision: (at / 32) as u64 + 1,
            world_from_model: Affine3A::from_translation(place),
            look,
        }
    });
    Scene {
        models: models.collect(),
        ..Scene::default()
    }
}

/// The most memory that this process has had, where the system tells it.
fn peak_mb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    kilobytes.unwrap_or(0) >> 10
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
        let scene = scene(segments, leaves);
        // As a worker does it.
        let params = RendererParams {
            direct_segments: if segments > 100_000 { 0 } else { 100_000 },
            ..params
        };
        let mut renderer = Renderer::new(&gpu, &params).unwrap();
        let mut revision = 1;
        let timed = |renderer: &mut Renderer, scene: &Scene, after: bool| {
            gpu.wait_idle().unwrap();
            let start = Instant::now();
            let placed = scene.tree.as_ref().unwrap();
            let mut report = renderer.draw(scene, &eyes, &offscreen.target()).unwrap();
            if report.tree == TreeState::Wanted(placed.revision) {
                let shown = renderer.resident().filter(|_| after);
                renderer.set_tree(TreeUpload::new(&gpu, placed, shown).unwrap());
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
        timed(&mut renderer, &scene, false);
        let report = renderer.draw(&scene, &eyes, &offscreen.target()).unwrap();
        let chosen = renderer.chosen().unwrap();
        println!(
            "{segments} segments{name}: {} draws, {} triangles, {} MB on the device, {} MB of memory at most",
            report.draws,
            report.triangles + chosen.triangles,
            renderer.tree_bytes() >> 20,
            peak_mb(),
        );
        group.bench_function(format!("record/{segments}{name}"), |bencher| {
            bencher.iter_custom(|rounds| {
                (0..rounds)
                    .map(|_| timed(&mut renderer, &scene, false))
                    .sum()
            });
        });
        if segments > 1_000_000 {
            continue;
        }
        let what = if segments > 100_000 { "ready" } else { "edit" };
        // Nothing stays as it was, or all but a hundredth.
        let other = [moved(&scene, 0), moved(&scene, segments - segments / 100)];
        let trees = |at: usize| [scene.tree.as_ref(), other[at].tree.as_ref()];
        for (at, name) in ["", " a hundredth"].into_iter().enumerate() {
            let [one, two] = trees(at).map(|tree| tree.unwrap().clone());
            let mut next = scene.clone();
            group.bench_function(format!("{what}/{segments}{name}"), |bencher| {
                bencher.iter_custom(|rounds| {
                    (0..rounds)
                        .map(|round| {
                            revision += 1;
                            let tree = if round % 2 == 0 { &two } else { &one };
                            next.tree = Some(PlacedTree {
                                revision,
                                ..tree.clone()
                            });
                            timed(&mut renderer, &next, at == 1)
                        })
                        .sum()
                });
            });
        }
        gpu.wait_idle().unwrap();
    }
    let wood = wood();
    let mut renderer = Renderer::new(&gpu, &params).unwrap();
    let mut draw = || {
        gpu.wait_idle().unwrap();
        let start = Instant::now();
        let report = renderer.draw(&wood, &eyes, &offscreen.target()).unwrap();
        (start.elapsed(), report)
    };
    (0..4).for_each(|_| _ = draw());
    let report = draw().1;
    println!(
        "a wood: {} draws, {} triangles",
        report.draws,
        report.triangles + report.chosen.triangles
    );
    group.bench_function("record/a wood", |bencher| {
        bencher.iter_custom(|rounds| (0..rounds).map(|_| draw().0).sum());
    });
    group.finish();
}

/// Whole frames, the device's work included, in each light and with wind.
fn whole(criterion: &mut Criterion) {
    let Ok(gpu) = Gpu::new(&Headless::default(), &GpuParams::default()) else {
        return;
    };
    let eyes = Eye::looking_at(
        Vec3::new(0.0, 3.0, 12.0),
        Vec3::new(0.0, 1.0, 0.0),
        Fov::symmetric(1.0, 1.0),
    )
    .pair(0.063);
    let mut group = criterion.benchmark_group("whole");
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3));
    let mut scene = scene(5_000, 1_000);
    for (name, light, strength, turns) in [
        ("day", Light::Day, 0.0, false),
        ("evening", Light::Evening, 0.0, false),
        ("studio", Light::Studio, 0.0, false),
        ("day, a breeze", Light::Day, Wind::Breeze.strength(), false),
        ("day, a tree that turns", Light::Day, 0.0, true),
    ] {
        let params = RendererParams::new(256, 256, StereoMode::Multiview).lit(light);
        let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
        let mut renderer = Renderer::new(&gpu, &params).unwrap();
        let mut frame = 0.0_f32;
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                frame += 1.0;
                renderer.set_sway(Sway {
                    strength,
                    clock: (frame / 90.0 / 256.0).fract(),
                });
                if turns {
                    let tree = scene.tree.as_mut().unwrap();
                    tree.world_from_tree = Affine3A::from_rotation_y(0.001 * frame);
                }
                renderer.draw(&scene, &eyes, &offscreen.target()).unwrap();
                renderer.wait().unwrap();
            });
        });
    }
    group.finish();
}

criterion_group!(benches, frame, whole);
criterion_main!(benches);
