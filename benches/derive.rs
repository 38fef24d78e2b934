//! Derivation speed: systems of the literature that stand for parametric, context-free and context-sensitive grammars.
//!
//! `RAYON_NUM_THREADS=1 cargo bench --bench derive`; throughput is in modules produced, summed over all steps, by CPU second
//! of the process. Each string's length is checked before it is timed.

#![allow(clippy::unwrap_used, reason = "a benchmark")]

use std::cell::Cell;
use std::hint::black_box;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ramus::lsystem::{Grammar, History, Limits, TurtleParams, interpret};
use ramus::tree::tubes::{mesh, segments};

#[path = "peers/src/systems.rs"]
mod systems;

use systems::{System, systems};

const HONDA: &str = include_str!("../assets/grammars/honda.lsys");

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

/// Triangles of a tree grown, drawn and meshed from a text, with tubes of eight sides.
fn grown_and_meshed(text: &str, steps: u32) -> usize {
    let cancel = AtomicBool::new(false);
    let grammar = Grammar::parse(text, "honda.lsys").unwrap();
    let string = grammar.derive(steps, &Limits::default(), &cancel).unwrap();
    let tree = interpret(&grammar, &string, &TurtleParams::default(), &cancel).unwrap();
    let mut tubes = Vec::new();
    segments(&tree, &[], u32::MAX, &mut tubes);
    mesh(&tubes, 1.0, 8).indices.len() / 3
}

fn sketch_sized(criterion: &mut Criterion) {
    // 4,095 segments of sixteen triangles each, and the ends that are closed.
    let triangles = grown_and_meshed(HONDA, 12);
    assert!(triangles >= 65_520, "{triangles} triangles are too few");
    criterion.bench_function(
        "honda 12 steps: parse, derive, interpret, mesh",
        |bencher| {
            bencher.iter(|| grown_and_meshed(black_box(HONDA), 12));
        },
    );
}

/// A step forward, a step back and an edit where the string has some 100,000 modules.
fn history(criterion: &mut Criterion) {
    const LAST: u32 = 14;
    let (limits, cancel) = (Limits::default(), AtomicBool::new(false));
    let grammar = Grammar::parse(HONDA, "honda.lsys").unwrap();
    let edited = HONDA.replace("C(l, w) -> !(w) F(l)", "C(l, w) -> !(w) F(l) X");
    let edited = Grammar::parse(&edited, "honda.lsys").unwrap();
    let looked_at = |steps: &[u32]| {
        let mut history = History::new(grammar.clone(), 64 << 20);
        for step in steps {
            history.at(*step, &limits, &cancel).unwrap();
        }
        history
    };
    let length = grammar.derive(LAST, &limits, &cancel).unwrap().len();
    assert_eq!(length, 114_682, "another string than the literature's");
    let mut group = criterion.benchmark_group("history of 114,682 modules");
    let mut time = |name: &str, before: &History, deed: &dyn Fn(&mut History)| {
        group.bench_function(name, |bencher| {
            bencher.iter_custom(|rounds| {
                let mut spent = Duration::ZERO;
                for _ in 0..rounds {
                    let mut history = before.clone();
                    let start = ProcessTime::now();
                    deed(&mut history);
                    spent += start.elapsed();
                }
                spent
            });
        });
    };
    let look = |history: &mut History, step: u32| {
        black_box(history.at(step, &limits, &cancel).unwrap());
    };
    let seen = looked_at(&[LAST - 1]);
    time("a step forward", &seen, &|history| look(history, LAST));
    let seen = looked_at(&[LAST - 1, LAST]);
    time("a step back", &seen, &|history| look(history, LAST - 1));
    time("an edit, seen at once", &seen, &|history| {
        history.edit(edited.clone());
        look(history, LAST);
    });
    group.finish();
}

/// How long work goes on after it was cancelled, at any moment of it: strings of gigabytes, contexts, chance, drawing. The most of all
/// moments is printed beside the figures, which are of all moments together.
fn cancelling(criterion: &mut Criterion) {
    const MOMENTS: u32 = 20;
    let text = |name: &str| {
        let found = systems().into_iter().find(|system| system.name == name);
        Grammar::parse(&found.unwrap().grammar, name).unwrap()
    };
    let limits = Limits {
        bytes: 8 << 30,
        ..Limits::default()
    };
    let never = AtomicBool::new(false);
    let derived = |name: &str, steps: u32| {
        let (grammar, limits) = (text(name), &limits);
        Box::new(move |cancel: &AtomicBool| drop(grammar.derive(steps, limits, cancel)))
    };
    let tree = Grammar::parse(HONDA, "honda.lsys").unwrap();
    let string = tree.derive(20, &limits, &never).unwrap();
    let params = TurtleParams::default();
    let drawn = |cancel: &AtomicBool| drop(interpret(&tree, &string, &params, cancel));
    type Work<'w> = Box<dyn Fn(&AtomicBool) + 'w>;
    let works: Vec<(&str, Work<'_>)> = vec![
        ("algae, 1.1 billion modules", derived("algae", 44)),
        ("stoch, 49 million", derived("stoch", 13)),
        ("hh, 17 million", derived("hh", 50)),
        ("diffuse, 200 steps", derived("diffuse", 200)),
        ("honda drawn, 1 million segments", Box::new(drawn)),
    ];
    let mut group = criterion.benchmark_group("cancelled");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(3));
    for (name, work) in works {
        let began = Instant::now();
        work(&never);
        let whole = began.elapsed();
        let most = Cell::new(Duration::ZERO);
        let moment = Cell::new(0);
        group.bench_function(name, |bencher| {
            bencher.iter_custom(|rounds| {
                let mut spent = Duration::ZERO;
                for _ in 0..rounds {
                    moment.set(moment.get() % MOMENTS + 1);
                    let cancel = AtomicBool::new(false);
                    let delay = whole * moment.get() / (MOMENTS + 2);
                    let cancelled = std::thread::scope(|scope| {
                        let timer = scope.spawn(|| {
                            std::thread::sleep(delay);
                            cancel.store(true, Ordering::Relaxed);
                            Instant::now()
                        });
                        work(&cancel);
                        let ended = Instant::now();
                        // Work that was done before is none to be cancelled.
                        ended.saturating_duration_since(timer.join().unwrap())
                    });
                    most.set(most.get().max(cancelled));
                    spent += cancelled.max(Duration::from_nanos(1));
                }
                spent
            });
        });
        eprintln!(
            "{name}: of {whole:.2?} at most {:.2?} after it was cancelled",
            most.get()
        );
    }
    group.finish();
}

criterion_group!(benches, derivation, sketch_sized, history, cancelling);
criterion_main!(benches);
