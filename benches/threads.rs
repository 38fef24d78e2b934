//! What a second thread brings: each work on one thread and on two, in turns, by the clock.
//!
//! `cargo bench --bench threads`. The figures are those of two threads; behind each stands how many times as fast they are as one, by
//! the medians and by the best of all times: of two threads that wait for each other either may be disturbed. In brackets stands what the
//! machine gives: how much more is done where the same work is done twice at once, by two threads that know nothing of each other. Two
//! plain works come first: numbers that are computed, and memory that is copied as blocks are.

#![allow(clippy::unwrap_used, reason = "a benchmark")]

use std::hint::black_box;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use ramus::lsystem::{Grammar, Limits, TurtleParams, interpret};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

#[path = "peers/src/systems.rs"]
mod systems;

const HONDA: &str = include_str!("../assets/grammars/honda.lsys");

/// A work with its name.
type Work<'w> = (String, Box<dyn Fn() + Sync + 'w>);

fn threads(criterion: &mut Criterion) {
    let pool = |threads| ThreadPoolBuilder::new().num_threads(threads).build();
    let pools = Pools {
        one: pool(1).unwrap(),
        two: pool(2).unwrap(),
        other: pool(1).unwrap(),
    };
    let never = AtomicBool::new(false);
    let honda = Grammar::parse(HONDA, "honda.lsys").unwrap();
    let string = honda.derive(18, &Limits::default(), &never).unwrap();
    let params = TurtleParams::default();
    let mut works: Vec<Work<'_>> = vec![computed(), copied()];
    works.extend(derivations(&never));
    works.push((
        String::from("honda 18, drawn"),
        Box::new(|| drop(black_box(interpret(&honda, &string, &params, &never)))),
    ));
    let mut group = criterion.benchmark_group("two threads");
    group
        .sample_size(20)
        .measurement_time(Duration::from_secs(5));
    for (name, work) in works {
        let mut spent = [Vec::new(), Vec::new(), Vec::new()];
        group.bench_function(&name, |bencher| {
            bencher.iter_custom(|rounds| pools.in_turns(&work, rounds, &mut spent));
        });
        if spent[0].is_empty() {
            continue; // another was asked for
        }
        let [ones, twos, boths] = spent.map(|mut all| {
            all.sort_unstable();
            [all[all.len() / 2], all[0]]
        });
        let [median, best] = [0, 1].map(|at| {
            let seconds = |all: &[Duration; 2]| all[at].as_secs_f64();
            let times = seconds(&ones) / seconds(&twos);
            format!("{times:.2} ({:.2})", 2.0 * seconds(&ones) / seconds(&boths))
        });
        let ([one, _], [two, _]) = (ones, twos);
        eprintln!(
            "{name}: {one:.2?} on one thread, {two:.2?} on two, times as fast {median}, by the best {best}"
        );
    }
    group.finish();
}

/// One thread, two that share a work, and one more that has a work of its own.
struct Pools {
    one: ThreadPool,
    two: ThreadPool,
    other: ThreadPool,
}

impl Pools {
    /// Does a work so many times on one thread, on two, and twice at once, and notes how long each took. Returns how long two threads
    /// took in all.
    fn in_turns(
        &self,
        work: &(impl Fn() + Sync),
        rounds: u64,
        [one, two, both]: &mut [Vec<Duration>; 3],
    ) -> Duration {
        let timed = |spent: &mut Vec<Duration>, work: &dyn Fn()| {
            let began = Instant::now();
            work();
            spent.push(began.elapsed());
            began.elapsed()
        };
        let mut shared = Duration::ZERO;
        for _ in 0..rounds {
            timed(one, &|| self.one.install(work));
            shared += timed(two, &|| self.two.install(work));
            timed(both, &|| {
                std::thread::scope(|scope| {
                    scope.spawn(|| self.other.install(work));
                    self.one.install(work);
                });
            });
        }
        shared
    }
}

/// Numbers in registers.
fn computed<'w>() -> Work<'w> {
    let chain = |first: u64| {
        (0..200_000_u64).fold(first, |x, i| {
            (x ^ i).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(7)
        })
    };
    let work = move || {
        black_box((0..16_u64).into_par_iter().map(chain).sum::<u64>());
    };
    (String::from("plain: computed"), Box::new(work))
}

/// 32 MiB written over, from a source that stays in the cache: so blocks are copied.
fn copied<'w>() -> Work<'w> {
    const PART: usize = 1 << 16;
    let source = vec![7_u64; PART];
    let targets = [(); 2].map(|()| Mutex::new(vec![0_u64; 64 * PART]));
    let work = move || {
        let free = targets.iter().find_map(|target| target.try_lock().ok());
        let mut target = free.unwrap();
        let parts = target.par_chunks_mut(PART);
        parts.for_each(|part| part.copy_from_slice(&source));
    };
    (String::from("plain: copied"), Box::new(work))
}

/// The systems as they are timed elsewhere, and where those strings are short, longer ones.
fn derivations<'w>(never: &'w AtomicBool) -> Vec<Work<'w>> {
    let longer = |name: &str| match name {
        "algae" => Some(42),
        "bush" | "stoch" => Some(13),
        "honda" | "row" => Some(22),
        "hh" => Some(46),
        _ => None,
    };
    let mut works: Vec<Work<'w>> = Vec::new();
    for system in systems::systems() {
        for steps in [Some(system.steps), longer(system.name)]
            .into_iter()
            .flatten()
        {
            let grammar = Grammar::parse(&system.grammar, system.name).unwrap();
            let name = format!("{}, {steps} steps", system.name);
            let length = system.length.filter(|_| steps == system.steps);
            let work = move || {
                let string = grammar.derive(steps, &Limits::default(), never);
                let derived = string.unwrap().len();
                assert_eq!(derived, length.unwrap_or(derived), "another string");
            };
            works.push((name, Box::new(work)));
        }
    }
    works
}

criterion_group!(benches, threads);
criterion_main!(benches);
