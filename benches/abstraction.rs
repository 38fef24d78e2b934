//! Times of abstraction: trees of the published duct's and artery's size, whole and pruned, and the fit to their tables. `cargo bench --bench abstraction`
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "Criterion's macros make undocumented functions; a bench may end on an error"
)]

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use ramus::abstraction::{FitParams, Grower, Params, Table, fit};
use ramus::lsystem::Limits;
use rayon::prelude::*;

const DUCT: &str = include_str!("../tests/data/tables/duct.json");
const ARTERY: &str = include_str!("../tests/data/tables/artery.json");
/// Trees of one measurement.
const TREES: u64 = 1000;

fn tables() -> [(&'static str, Table); 2] {
    [("duct", DUCT), ("artery", ARTERY)].map(|(name, text)| (name, Table::read(text).unwrap()))
}

/// Parameters whose trees have the table.
fn fitted(table: &Table) -> Params {
    let params = FitParams {
        candidates: 3_000,
        ..FitParams::default()
    };
    let never = AtomicBool::new(false);
    let found = fit(table, &params, &never, &mut |_, _, _| {}).unwrap();
    found.ranked[0].params.clone()
}

fn trees(bench: &mut Criterion) {
    let never = AtomicBool::new(false);
    let mut group = bench.benchmark_group("trees");
    group.sampling_mode(SamplingMode::Flat);
    group.throughput(Throughput::Elements(TREES));
    for (name, table) in tables() {
        let params = fitted(&table);
        for (what, prune_intersections) in [("whole", false), ("pruned", true)] {
            let params = Params {
                prune_intersections,
                ..params.clone()
            };
            let grower = Grower::new(&params).unwrap();
            let segments = |grower: &mut Grower, seed| {
                let tree = grower.tree(seed, &Limits::default(), &never).unwrap();
                tree.segment_count()
            };
            group.bench_function(format!("{name}_{what}"), |bench| {
                bench.iter(|| {
                    let trees = (0..TREES).into_par_iter();
                    trees.map_init(|| grower.clone(), segments).sum::<usize>()
                });
            });
        }
    }
    group.finish();
}

fn fits(bench: &mut Criterion) {
    let never = AtomicBool::new(false);
    let mut group = bench.benchmark_group("fit");
    group.sampling_mode(SamplingMode::Flat);
    group.sample_size(10);
    group.measurement_time(Duration::from_secs(20));
    for (name, table) in tables() {
        group.bench_function(format!("{name}_20000_candidates"), |bench| {
            bench.iter(|| fit(&table, &FitParams::default(), &never, &mut |_, _, _| {}).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, trees, fits);
criterion_main!(benches);
