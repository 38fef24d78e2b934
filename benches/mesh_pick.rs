//! Times of picking on a million triangles: building, rays side by side and at random, nearest points. `cargo bench --bench mesh_pick [-- NAME]`
//!
//! Rays and points are asked by one thread, thousands a turn; the throughput is of single ones.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "Criterion's macros make undocumented functions; a bench may end on an error"
)]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, Vec3};
use ramus::mesh::Mesh;
use ramus::mesh::pick::Picker;

/// A closed, lumpy ball of about as many triangles, between 0.8 and 1.2 from zero.
fn ball(triangles: u32) -> Mesh {
    let rows = f64::from(triangles / 4).sqrt().round();
    let round = 2.0 * rows;
    let (rows, round) = (whole(rows), whole(round));
    let point = |column: u32, row: u32| {
        let around = f64::from(column) / f64::from(round) * std::f64::consts::TAU;
        let down = f64::from(row) / f64::from(rows) * std::f64::consts::PI;
        let on = DVec3::new(
            down.sin() * around.cos(),
            down.sin() * around.sin(),
            down.cos(),
        );
        let lumps = (9.0 * on.x).sin() + (11.0 * on.y).sin() + (7.0 * on.z).cos();
        (on * (1.0 + lumps / 15.0)).as_vec3()
    };
    let number = |column: u32, row: u32| row * round + column % round;
    let squares = || (0..rows).flat_map(|row| (0..round).map(move |column| (column, row)));
    Mesh {
        origin: DVec3::ZERO,
        positions: (0..=rows)
            .flat_map(|row| (0..round).map(move |column| point(column, row)))
            .collect(),
        triangles: squares()
            .flat_map(|(column, row)| {
                let [a, b] = [number(column, row), number(column + 1, row)];
                let [c, d] = [number(column + 1, row + 1), number(column, row + 1)];
                [[a, d, c], [a, c, b]]
            })
            .collect(),
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "small and rounded"
)]
fn whole(number: f64) -> u32 {
    number as u32
}

/// Points between −1 and 1, the same in each run (a linear congruential generator, Knuth's MMIX).
fn points(count: usize) -> Vec<Vec3> {
    let mut state = 1_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        f32::from(u16::try_from(state >> 48).unwrap_or(0)) / 32_768.0 - 1.0
    };
    (0..count)
        .map(|_| Vec3::new(next(), next(), next()))
        .collect()
}

/// Rays of a picture of 256 × 256.
fn picture() -> Vec<(Vec3, Vec3)> {
    let eye = Vec3::new(0.3, 0.2, 3.0);
    let at = |pixel: u8| f32::from(pixel) / 128.0 - 1.0;
    (0..=255)
        .flat_map(|y| (0..=255).map(move |x| (eye, Vec3::new(at(x), at(y), 0.0) - eye)))
        .collect()
}

fn benches_of_picking(criterion: &mut Criterion) {
    let mesh = Arc::new(ball(1_000_000));
    let never = AtomicBool::new(false);
    let build = || Picker::new(Arc::clone(&mesh), &never, &mut |_, _| {}).unwrap();
    let mut group = criterion.benchmark_group("1.0M");
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(5));
    group.throughput(Throughput::Elements(mesh.triangles.len() as u64));
    group.bench_function("build", |b| b.iter(build));
    let picker = build();
    let rays = picture();
    let random = points(2 << 14);
    group.throughput(Throughput::Elements(rays.len() as u64));
    group.bench_function("coherent_rays", |b| {
        b.iter(|| {
            rays.iter()
                .filter(|(origin, towards)| picker.ray(*origin, *towards, f32::INFINITY).is_some())
                .count()
        });
    });
    group.throughput(Throughput::Elements(random.len() as u64 / 2));
    group.bench_function("random_rays", |b| {
        b.iter(|| {
            let pairs = random.as_chunks::<2>().0.iter();
            pairs
                .filter(|[origin, to]| picker.ray(*origin * 2.0, *to - *origin, 9.0).is_some())
                .count()
        });
    });
    group.throughput(Throughput::Elements(random.len() as u64));
    group.bench_function("nearest", |b| {
        b.iter(|| {
            let near = random
                .iter()
                .filter_map(|point| picker.nearest(*point * 1.5, f32::INFINITY));
            near.map(|hit| hit.distance).sum::<f32>()
        });
    });
    group.finish();
}

criterion_group!(benches, benches_of_picking);
criterion_main!(benches);
