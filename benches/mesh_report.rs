//! Times of the report on a mesh and of the search for places where it passes through itself. `cargo bench --bench mesh_report [-- NAME]`
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "Criterion's macros make undocumented functions; a bench may end on an error"
)]

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ramus::mesh::intersect::{IntersectParams, intersections};
use ramus::mesh::report::{ReportParams, report};

mod torus;

use torus::{soup, torus};

fn benches_of_reports(criterion: &mut Criterion) {
    let torus = torus(1300, 500);
    let soup = soup(&torus);
    let never = AtomicBool::new(false);
    let mut group = criterion.benchmark_group("1.3M");
    group
        .throughput(Throughput::Elements(torus.triangles.len() as u64))
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(5));
    for (name, mesh) in [("report", &torus), ("report_of_soup", &soup)] {
        group.bench_function(name, |b| {
            b.iter(|| report(mesh, &ReportParams::default(), &never, &mut |_, _| {}).unwrap())
        });
    }
    group.bench_function("intersections", |b| {
        b.iter(|| {
            intersections(&torus, &IntersectParams::default(), &never, &mut |_, _| {}).unwrap()
        })
    });
    group.finish();
}

criterion_group!(benches, benches_of_reports);
criterion_main!(benches);
