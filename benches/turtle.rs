//! Drawing speed: from a derived string to a `Tree`, in segments by second.
//!
//! `cargo bench --bench turtle`, with `RAYON_NUM_THREADS=1` or 2; by the clock, so the machine should have nothing else to do.

#![allow(clippy::unwrap_used, reason = "a benchmark")]

use std::fmt::Write as _;
use std::hint::black_box;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ramus::lsystem::turtle::Extent;
use ramus::lsystem::{Grammar, Limits, TurtleParams, draw_on, interpret};

const HONDA: &str = include_str!("../assets/grammars/honda.lsys");
/// ABOP, figure 1.24 c.
const BUSH_2D: &str = "angle 22.5\naxiom F\nF -> FF-[-F+F+F]+[+F-F-F]\n";
/// ABOP, figure 1.25; its leaves are outlines.
const BUSH: &str = "angle 22.5\naxiom A\nA -> [&FL!A]/////'[&FL!A]///////'[&FL!A]\nF -> S/////F\nS -> FL\n\
    L -> ['''^^{-f+f+f-|-f+f+f}]\n";
/// ABOP, figure 1.8: a ternary tree with lengths and widths.
const TERNARY: &str = include_str!("../assets/grammars/ternary.lsys");
/// Koch's curve: no branch anywhere.
const KOCH: &str = "angle 60\naxiom F\nF -> F+F--F+F\n";

/// A sketch as the workshop writes it, grown far: two strokes of a few segments.
fn sketch() -> String {
    let mut text = String::from(
        "context literal\naxiom A(0) B\nA(x) > B -> A(x) A(x+1)\n\
         A(x) > A(y) : y == x+1 && (x+1) % 2 == 0 -> A(x) [ /(137.508 * ((x+1)/2 - 1)) C(0) B ]\n\
         C(x) > B -> C(x) C(x+1)\nC(x) > C(y) : y == x+1 && (x+1) % 3 == 0 -> C(x) [ /(90) A(0) B ]\n",
    );
    for letter in ['A', 'C'] {
        let _ = writeln!(
            text,
            "shape {letter} = [(0.1 0.4 0) (0.3 0.2 0.1) (0 0.3 0.1)]"
        );
    }
    text
}

fn drawing(criterion: &mut Criterion) {
    let cancel = AtomicBool::new(false);
    let params = TurtleParams::default();
    let mut group = criterion.benchmark_group("turtle");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(5));
    for (name, text, steps) in [
        ("honda 18", HONDA, 18),
        ("ternary 12", TERNARY, 12),
        ("bush 11, with leaves", BUSH, 11),
        ("plane bush 7", BUSH_2D, 7),
        ("koch 11", KOCH, 11),
        ("sketch 24", &sketch(), 24),
    ] {
        let grammar = Grammar::parse(text, name).unwrap_or_else(|e| panic!("{name}: {e}"));
        let string = grammar.derive(steps, &Limits::default(), &cancel).unwrap();
        let tree = interpret(&grammar, &string, &params, &cancel).unwrap();
        eprintln!(
            "{name}: {} modules, {} segments",
            string.len(),
            tree.segment_count()
        );
        group.throughput(Throughput::Elements(tree.segment_count() as u64));
        drop(tree);
        group.bench_function(format!("{name}: tree"), |bencher| {
            bencher.iter(|| black_box(interpret(&grammar, &string, &params, &cancel).unwrap()));
        });
        group.bench_function(format!("{name}: bounds"), |bencher| {
            let canvas = |_: &TurtleParams| Extent::default();
            bencher.iter(|| black_box(draw_on(&grammar, &string, &params, &cancel, canvas)));
        });
    }
    group.finish();
}

criterion_group!(benches, drawing);
criterion_main!(benches);
