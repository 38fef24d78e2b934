//! What an edit costs: the document, the grammar's text, the count beforehand, and growing anew.
//!
//! `cargo bench --bench sketch`. The workshop grows up to 100,000 segments within a frame's edit, so
//! that is the size to watch.
#![allow(missing_docs, clippy::unwrap_used, reason = "a bench")]

use std::{hint::black_box, sync::atomic::AtomicBool};

use criterion::{Criterion, criterion_group, criterion_main};
use glam::Vec3;
use ramus::{
    sketch::{Grower, Letter, NodeRef, Sketch, grow, predict_segments_within},
    world::{
        document::{Document, Edit},
        history::History,
        project,
    },
};

/// A trunk with two branches that carry copies of themselves.
fn sketch() -> Sketch {
    let trunk: Vec<Vec3> = (1..=5_u8)
        .map(|n| Vec3::new(0.0, f32::from(n) * 0.1, 0.0))
        .collect();
    let (sketch, _) = Sketch::default()
        .add_segments(NodeRef::ROOT, &trunk)
        .unwrap();
    let branch = |sketch: &Sketch, node, x| {
        let from = NodeRef::new(Letter::TRUNK, node);
        let start = sketch.position(from).unwrap();
        let to = [
            start + Vec3::new(x, 0.1, 0.0),
            start + Vec3::new(x * 2.0, 0.15, 0.02),
        ];
        sketch.add_segments(from, &to).unwrap().0
    };
    branch(&branch(&sketch, 2, 0.1), 3, -0.1)
}

/// The last step with at most so many segments.
fn step_with(sketch: &Sketch, segments: u64) -> u32 {
    (1..)
        .take_while(|&step| predict_segments_within(sketch, step, segments).is_some())
        .last()
        .unwrap()
}

fn benches(c: &mut Criterion) {
    let never = AtomicBool::new(false);
    let sketch = sketch();
    for segments in [1_000, 100_000] {
        let step = step_with(&sketch, segments);
        let exact = predict_segments_within(&sketch, step, segments).unwrap();
        c.bench_function(&format!("grow {exact} segments"), |b| {
            b.iter(|| grow(black_box(&sketch), step, &never).unwrap());
        });
    }
    let step = step_with(&sketch, 100_000);
    let mut grower = Grower::default();
    let at = NodeRef::new(Letter::TRUNK, 1);
    let moved = [0.01, 0.02].map(|x| sketch.move_node(at, Vec3::new(x, 0.1, 0.0)).unwrap());
    let mut turn = 0;
    c.bench_function("move a node and grow anew", |b| {
        b.iter(|| {
            turn ^= 1;
            grower.grow(&moved[turn], step, &never).unwrap()
        });
    });
    c.bench_function("grammar text", |b| {
        b.iter(|| black_box(&sketch).grammar_text())
    });
    c.bench_function("predict step 10,000", |b| {
        b.iter(|| predict_segments_within(black_box(&sketch), 10_000, u64::MAX - 1));
    });
    let mut history = History::default();
    let long: Vec<Vec3> = (1..=10_000_u16)
        .map(|n| Vec3::new(f32::from(n % 7) * 0.1, f32::from(n) * 0.01, 0.0))
        .collect();
    history.apply(Edit::AddStroke { to: long }).unwrap();
    let document: Document = history.committed().clone();
    c.bench_function("move a node among 10,000", |b| {
        let at = NodeRef::new(Letter::TRUNK, 5_000);
        let edit = Edit::MoveNode {
            at,
            to: Vec3::new(1.0, 50.0, 1.0),
        };
        b.iter(|| document.after(black_box(&edit)).unwrap());
    });
    c.bench_function("project of 10,000 nodes", |b| {
        b.iter(|| project::from_bytes(&project::to_bytes(black_box(&document))).unwrap());
    });
}

criterion_group!(sketch_benches, benches);
criterion_main!(sketch_benches);
