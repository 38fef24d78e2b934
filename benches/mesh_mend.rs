//! Times of mending a mesh of 1.3 million triangles. `cargo bench --bench mesh_mend [-- NAME]`
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "Criterion's macros make undocumented functions; a bench may end on an error"
)]

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, Vec3};
use ramus::mesh::Mesh;
use ramus::mesh::mend::{Mend, mend};

/// A ring with a hole, of 2 · round · rows triangles.
fn torus(round: u32, rows: u32) -> Mesh {
    let angle =
        |part: u32, of: u32| (f64::from(part) / f64::from(of) * std::f64::consts::TAU).sin_cos();
    let point = |column, row| {
        let ((sin, cos), (sin_tube, cos_tube)) = (angle(column, round), angle(row, rows));
        let radius = 2.0 + 0.5 * cos_tube;
        DVec3::new(radius * cos, radius * sin, 0.5 * sin_tube).as_vec3()
    };
    let number = |column: u32, row: u32| row % rows * round + column % round;
    let squares = || (0..rows).flat_map(|row| (0..round).map(move |column| (column, row)));
    Mesh {
        origin: DVec3::ZERO,
        positions: squares().map(|(column, row)| point(column, row)).collect(),
        triangles: squares()
            .flat_map(|(column, row)| {
                let [a, b] = [number(column, row), number(column + 1, row)];
                let [c, d] = [number(column + 1, row + 1), number(column, row + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect(),
    }
}

/// Three vertices for each triangle, as STL files have them.
fn soup(mesh: &Mesh) -> Mesh {
    let corners = mesh.triangles.as_flattened().iter();
    let positions: Vec<Vec3> = corners
        .map(|vertex| mesh.positions[*vertex as usize])
        .collect();
    let first = (0_u32..).step_by(3).take(mesh.triangles.len());
    Mesh {
        origin: mesh.origin,
        positions,
        triangles: first.map(|a| [a, a + 1, a + 2]).collect(),
    }
}

/// The same with a slit from end to end, which leaves one boundary loop, and with some holes.
fn slit(mut mesh: Mesh) -> Mesh {
    let mut number = 0_u32;
    mesh.triangles.retain(|_| {
        number += 1;
        number > 2600 && !number.is_multiple_of(4001)
    });
    mesh
}

fn benches_of_mends(criterion: &mut Criterion) {
    let torus = torus(1300, 500);
    let (soup, slit) = (soup(&torus), slit(torus.clone()));
    let never = AtomicBool::new(false);
    let mut group = criterion.benchmark_group("1.3M");
    group
        .throughput(Throughput::Elements(torus.triangles.len() as u64))
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(5));
    for (name, mesh, text) in [
        ("weld_of_soup", &soup, "weld"),
        ("weld_by_distance", &torus, "weld=0.0001"),
        ("orient", &torus, "orient"),
        ("close", &slit, "close"),
        ("close_smooth", &slit, "close=smooth"),
        ("smooth", &torus, "smooth=10"),
        ("decimate", &torus, "decimate=10%"),
    ] {
        let one = Mend::parse(text).unwrap();
        group.bench_function(name, |b| {
            b.iter_batched(
                || mesh.clone(),
                |mesh| mend(mesh, &one, &never, &mut |_, _| {}).unwrap(),
                BatchSize::LargeInput,
            )
        });
    }
    group.finish();
}

criterion_group!(benches, benches_of_mends);
criterion_main!(benches);
