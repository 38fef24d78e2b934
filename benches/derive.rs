//! Derivation speed: systems of the literature that stand for parametric, context-free and context-sensitive grammars.
//!
//! `RAYON_NUM_THREADS=1 cargo bench --bench derive`; throughput is in modules produced, summed over all steps, by CPU second
//! of the process. Each string's length is checked before it is timed.

#![allow(clippy::unwrap_used, reason = "a benchmark")]

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

const BUSH: &str = "axiom A\nA -> [&FL!A]/////'[&FL!A]///////'[&FL!A]\nF -> S/////F\nS -> FL\n\
    L -> ['''^^{-f+f+f-|-f+f+f}]\n";
const STOCH: &str = "axiom F\nF : weight 0.33 -> F[+F]F[-F]F\nF : weight 0.33 -> F[+F]F\nF : weight 0.34 -> F[-F]F\n";

/// A system to time.
struct System {
    name: &'static str,
    grammar: String,
    steps: u32,
    /// Modules of the last string; none where it is random.
    length: Option<usize>,
}

fn systems() -> Vec<System> {
    let system = |name, grammar: &str, steps, length| System {
        name,
        grammar: grammar.to_owned(),
        steps,
        length,
    };
    let signal = format!("axiom b{}\nb < a -> b\nb -> a\n", "a".repeat(1 << 20));
    let cells: Vec<String> = (0..1_u32 << 17)
        .map(|i| format!("C({})", i.count_ones()))
        .collect();
    let diffuse = format!(
        "axiom {}\nC(l) < C(x) > C(r) : x>=0 -> C(x+0.25*(l+r-2*x))\n",
        cells.concat()
    );
    vec![
        system("algae", ALGAE, 35, Some(14_930_352)),
        system("bush", BUSH, 11, Some(6_351_974)),
        system("stoch", STOCH, 11, None),
        system("honda", HONDA, 18, Some(1_835_002)),
        system("row", ROW, 18, Some(3_530_486)),
        system("signal", &signal, 20, Some(1_048_577)),
        system("hh", HOGEWEG_HESPER, 36, Some(141_946)),
        system("diffuse", &diffuse, 10, Some(131_072)),
    ]
}

/// Modules of all strings behind the axiom.
fn produced(grammar: &Grammar, steps: u32) -> u64 {
    let (limits, cancel) = (Limits::default(), AtomicBool::new(false));
    let mut string = grammar.derive(0, &limits, &cancel).unwrap();
    let mut sum = 0;
    for step in 1..=steps {
        string = grammar
            .derive_next(&string, step, &limits, &cancel)
            .unwrap();
        sum += string.len() as u64;
    }
    sum
}

fn derivation(criterion: &mut Criterion) {
    let cancel = AtomicBool::new(false);
    let mut group = criterion.benchmark_group("derive");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(5));
    for System {
        name,
        grammar,
        steps,
        length,
    } in systems()
    {
        let grammar = Grammar::parse(&grammar, name).unwrap_or_else(|e| panic!("{name}: {e}"));
        let derive = || {
            let string = grammar.derive(steps, &Limits::default(), &cancel);
            string.map(|s| s.len()).ok()
        };
        let derived = derive();
        assert_eq!(
            derived,
            length.or(derived),
            "{name}: another string than the literature's"
        );
        group.throughput(Throughput::Elements(produced(&grammar, steps)));
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
