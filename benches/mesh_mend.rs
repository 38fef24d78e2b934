//! Times of mending a mesh of 1.3 million triangles. `cargo bench --bench mesh_mend [-- NAME]`
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "Criterion's macros make undocumented functions; a bench may end on an error"
)]

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use ramus::mesh::Mesh;
use ramus::mesh::mend::{Mend, mend};

mod torus;

use torus::{soup, torus};

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
