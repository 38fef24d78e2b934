//! Times of writing trees as grammars that draw them again: Honda's tree, a random one and a long path. `cargo bench --bench exact`
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "Criterion's macros make undocumented functions; a bench may end on an error"
)]

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use ramus::abstraction::exact::{exact, size};
use ramus::lsystem::{Grammar, Limits, TurtleParams, interpret};
use ramus::tree::{NO_PARENT, Node, Tree};

const HONDA: &str = include_str!("../assets/grammars/honda.lsys");

fn honda() -> Tree {
    let never = AtomicBool::new(false);
    let grammar = Grammar::parse(HONDA, "honda.lsys").unwrap();
    let string = grammar.derive(10, &Limits::default(), &never).unwrap();
    interpret(&grammar, &string, &TurtleParams::default(), &never).unwrap()
}

/// A tree in which each node grows from one of so many before it: 1 is a path.
fn random(nodes: u32, back: u32) -> Tree {
    let mut tree = Tree {
        letters: vec!["F".to_owned()],
        ..Tree::default()
    };
    let mut state = 1_u32;
    let mut draw = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 16
    };
    for at in 0..nodes {
        let parent = at.checked_sub(1 + draw() % back.min(at.max(1)));
        let mut step = || f32::from(u16::try_from(draw()).unwrap()) / 65_536.0 - 0.5;
        let step = Vec3::new(step(), step() + 0.3, step());
        let from = parent.map_or(Vec3::ZERO, |parent| tree.position[parent as usize]);
        tree.push(Node {
            parent: parent.unwrap_or(NO_PARENT),
            position: from + step,
            radius: 0.1,
            letter: 0,
            order: 0,
            birth: 0,
        });
    }
    tree
}

fn grammars(bench: &mut Criterion) {
    let never = AtomicBool::new(false);
    let mut group = bench.benchmark_group("exact");
    group.sampling_mode(SamplingMode::Flat);
    group.sample_size(10);
    group.measurement_time(Duration::from_secs(10));
    for (name, tree) in [
        ("honda", honda()),
        ("random_10000", random(10_000, 500)),
        ("path_100000", random(100_000, 1)),
        ("random_100000", random(100_000, 2_000)),
    ] {
        group.throughput(Throughput::Elements(tree.len() as u64));
        let tolerance = 0.005 * size(&tree);
        group.bench_function(name, |bench| {
            bench.iter(|| exact(&tree, tolerance, &never, &|_, _| {}).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, grammars);
criterion_main!(benches);
