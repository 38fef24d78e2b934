//! What models in levels of detail cost: `cargo bench --bench levels [-- NAME]`.
//!
//! `build` makes a mesh of 1.3 million triangles ready to be drawn: vertices of one place joined, normals, box, all levels. `frame` is the processor time
//! of the thread that hands over a frame with a model of ten million triangles, the driver's share of recording included; choosing and drawing are the
//! device's, which here is the same processor, but other threads. Memory: `ramus inspect` of a file of ten million, under `/usr/bin/time -v`.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "Criterion's macros make undocumented functions; a bench may end on an error"
)]

use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use cpu_time::ThreadTime;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{Affine3A, Vec3};
use ramus::mesh::Mesh;
use ramus::mesh::display::Display;
use ramus::render::{
    Eye, Fov, Gpu, GpuParams, Headless, ModelUpload, Offscreen, Renderer, RendererParams,
    StereoMode,
};
use ramus::world::scene::{ModelLook, PlacedModel, Scene};

mod torus;

use torus::{soup, torus};

fn display(mesh: &Arc<Mesh>) -> Display {
    Display::new(Arc::clone(mesh), None, &AtomicBool::new(false)).unwrap()
}

fn build(criterion: &mut Criterion) {
    let mesh = torus(1300, 500);
    let (soup, mesh) = (Arc::new(soup(&mesh)), Arc::new(mesh));
    let mut group = criterion.benchmark_group("levels");
    group
        .throughput(Throughput::Elements(mesh.triangles.len() as u64))
        .sample_size(10)
        .measurement_time(Duration::from_secs(10));
    for (name, mesh) in [("build/1.3M", &mesh), ("build/1.3M_of_soup", &soup)] {
        group.bench_function(name, |bencher| {
            bencher.iter_with_large_drop(|| display(black_box(mesh)));
        });
    }
    group.finish();
}

fn frame(criterion: &mut Criterion) {
    let gpu = match Gpu::new(&Headless::default(), &GpuParams::default()) {
        Ok(gpu) => gpu,
        Err(error) => {
            eprintln!("skipped: {error}");
            return;
        }
    };
    let display = Arc::new(display(&Arc::new(torus(3200, 1563))));
    let params = RendererParams::new(256, 256, StereoMode::Multiview);
    let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(&gpu, &params).unwrap();
    let side = display.size().max_element();
    let placed = PlacedModel {
        display,
        revision: 1,
        world_from_model: Affine3A::from_scale(Vec3::splat(1.0 / side)),
        look: ModelLook::default(),
    };
    let scene = Scene {
        models: vec![placed.clone()],
        ..Scene::default()
    };
    renderer.set_model(ModelUpload::new(&gpu, &placed).unwrap());
    let field = Fov::symmetric(1.0, 1.0);
    let eyes = Eye::looking_at(Vec3::new(0.0, 0.0, 1.2), Vec3::ZERO, field).pair(0.063);
    let mut timed = || {
        gpu.wait_idle().unwrap();
        let start = ThreadTime::now();
        black_box(renderer.draw(&scene, &eyes, &offscreen.target()).unwrap());
        let time = start.elapsed();
        (time, renderer.has_models(&scene))
    };
    while !timed().1 {}
    let mut group = criterion.benchmark_group("levels");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(10));
    group.bench_function("frame/10M", |bencher| {
        bencher.iter_custom(|rounds| (0..rounds).map(|_| timed().0).sum());
    });
    group.finish();
    eprintln!("{:?}", renderer.chosen().unwrap());
}

criterion_group!(benches, build, frame);
criterion_main!(benches);
