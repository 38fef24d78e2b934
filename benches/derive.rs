//! Derivation speed: systems of the literature that stand for parametric, context-free and context-sensitive grammars.
//!
//! `RAYON_NUM_THREADS=1 cargo bench --bench derive`; throughput is in modules produced, summed over all steps. Each string's length is checked before it is
//! timed.

use std::hint::black_box;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use cpu_time::ProcessTime;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ramus::lsystem::{Grammar, Limits, TurtleParams, interpret};

const HONDA: &str = include_str!("../assets/grammars/honda.lsys");
const ROW: &str = "const p = 0.3, q = 0.7, h = (0.3*0.7)^0.5\naxiom F(1,0)\n\
    F(x,t) : t==0 -> F(x*p,2)+F(x*h,1)--F(x*h,1)+F(x*q,0)\nF(x,t) : t>0 -> F(x,t-1)\n";
const ALGAE: &str = "axiom b\na -> ab\nb -> a\n";
const HOGEWEG_HESPER: &str = "ignore +-F\naxiom F1F1F1\n0 < 0 > 0 -> 1\n0 < 0 > 1 -> 1[-F1F1]\n0 < 1 > 0 -> 1\n\
    0 < 1 > 1 -> 1\n1 < 0 > 0 -> 0\n1 < 0 > 1 -> 1F1\n1 < 1 > 0 -> 1\n1 < 1 > 1 -> 0\n+ -> -\n- -> +\n";

/// Name, grammar, steps, modules of the last string, modules of all strings.
fn systems() -> Vec<(&'static str, String, u32, usize, u64)> {
    let signal = format!("axiom b{}\nb < a -> b\nb -> a\n", "a".repeat(1 << 20));
    vec![
        ("honda", HONDA.to_owned(), 18, 1_835_002, 3_669_894),
        ("row", ROW.to_owned(), 18, 3_530_486, 6_606_065),
        ("signal", signal, 20, 1_048_577, 20_971_540),
        ("algae", ALGAE.to_owned(), 35, 14_930_352, 39_088_167),
        ("hh", HOGEWEG_HESPER.to_owned(), 36, 141_946, 547_121),
    ]
}

fn derivation(criterion: &mut Criterion) {
    let cancel = AtomicBool::new(false);
    let mut group = criterion.benchmark_group("derive");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(5));
    for (name, text, steps, length, produced) in systems() {
        let grammar = Grammar::parse(&text, name).unwrap_or_else(|e| panic!("{name}: {e}"));
        let derive = || {
            grammar
                .derive(steps, &Limits::default(), &cancel)
                .map(|s| s.len())
                .ok()
        };
        assert_eq!(
            derive(),
            Some(length),
            "{name}: another string than the literature's"
        );
        group.throughput(Throughput::Elements(produced));
        group.bench_function(name, |bencher| {
            bencher.iter_custom(|rounds| {
                let start = ProcessTime::now();
                for _ in 0..rounds {
                    black_box(derive());
                }
                start.elapsed()
            });
        });
    }
    group.finish();
}

fn sketch_sized(criterion: &mut Criterion) {
    let cancel = AtomicBool::new(false);
    let params = TurtleParams::default();
    criterion.bench_function("honda 12 steps: parse, derive, interpret", |bencher| {
        bencher.iter(|| {
            let grammar = Grammar::parse(HONDA, "honda.lsys").ok()?;
            let string = grammar.derive(12, &Limits::default(), &cancel).ok()?;
            interpret(&grammar, &string, &params, &cancel)
                .ok()
                .map(|tree| tree.parent.len())
        });
    });
}

criterion_group!(benches, derivation, sketch_sized);
criterion_main!(benches);
