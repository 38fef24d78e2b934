//! Trees like models on the stage: looked for on a worker, shown as they get nearer, and stopped as soon as nobody wants them any more.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

use crate::abstraction::{Candidate, FitParams, Table, fit, grow};
use crate::app::queue::Queue;
use crate::lsystem::Limits;
use crate::tree::measure::Measures;
use crate::world::World;
use crate::world::abstracting::Abstraction;
use crate::world::lines::Lines;
use crate::world::model::Model;

/// Trees that are drawn for a model.
const CANDIDATES: usize = 20_000;
/// How many of the best are shown.
const RANKED: usize = 6;

/// What is to be looked for.
#[derive(Clone, Debug)]
struct Wanted(Model, Arc<Lines>, u64);

/// What was found for a model with a seed, or why nothing can be.
type Done = (Model, u64, Result<Arc<Abstraction>, String>);

/// Found so far; frames take it where it is new.
type SoFar = Arc<Mutex<Option<Arc<Abstraction>>>>;

/// Looks for what is wanted.
pub(super) struct Abstracting {
    queue: Queue<Wanted, Done>,
    so_far: SoFar,
}

impl Abstracting {
    /// # Errors
    /// Where the system gives no thread.
    pub(super) fn start() -> std::io::Result<Self> {
        let so_far = SoFar::default();
        let told = Arc::clone(&so_far);
        let job = move |Wanted(model, lines, seed): &Wanted, cancel: &AtomicBool| {
            let found = found(lines, *seed, &told, cancel);
            let found = found.map_err(|why| format!("{}: {why}", model.file));
            (model.clone(), *seed, found)
        };
        Ok(Self {
            queue: Queue::start("ramus-abstracting", job)?,
            so_far,
        })
    }

    /// Stops what nobody wants any more, and begins what the world wants next, unless something is under way. Whether something is.
    pub(super) fn follow(&mut self, world: &World) -> bool {
        let at_work = self.queue.open().next();
        if at_work.is_some_and(|Wanted(model, _, seed)| !world.wants_abstraction(model, *seed)) {
            self.queue.stop();
            self.take();
        }
        if !self.queue.is_busy()
            && let Some((model, lines, seed)) = world.wanted_abstraction()
        {
            // The line is empty.
            let _ = self.queue.ask(Wanted(model.clone(), lines, seed));
        }
        self.queue.is_busy()
    }

    /// What was found of what is at work since it was asked last.
    pub(super) fn so_far(&mut self) -> Option<(Model, u64, Arc<Abstraction>)> {
        let found = self.take()?;
        let Wanted(model, _, seed) = self.queue.open().next()?;
        Some((model.clone(), *seed, found))
    }

    fn take(&self) -> Option<Arc<Abstraction>> {
        let so_far = self.so_far.lock();
        so_far.unwrap_or_else(PoisonError::into_inner).take()
    }

    pub(super) fn poll(&mut self) -> Option<Done> {
        self.queue.poll()
    }

    pub(super) fn wait(&mut self) -> Option<Done> {
        self.queue.wait()
    }
}

/// Looks for trees like the lines of a model.
fn found(
    lines: &Lines,
    seed: u64,
    so_far: &SoFar,
    cancel: &AtomicBool,
) -> Result<Arc<Abstraction>, String> {
    let target = Table::of(&Measures::new(&lines.centerline.tree));
    let params = FitParams {
        candidates: CANDIDATES,
        seed,
        ranked: RANKED,
    };
    let mut last = Vec::new();
    let mut told = |done: usize, of: usize, ranked: &[Candidate]| {
        let seeds = ranked.iter().map(|one| (one.params.seed, one.distance));
        let seeds: Vec<(u64, f64)> = seeds.take(RANKED).collect();
        let known = so_far.lock();
        let mut known = known.unwrap_or_else(PoisonError::into_inner);
        // Trees are grown once for as long as they are the best.
        let trees = match known.as_ref().filter(|_| seeds == last) {
            Some(known) => known.ranked.clone(),
            None => with_trees(ranked, cancel),
        };
        last = seeds;
        *known = Some(Arc::new(Abstraction {
            target: target.clone(),
            ranked: trees,
            by_rules: None,
            drawn: [done, of],
        }));
    };
    let fit = fit(&target, &params, cancel, &mut told).map_err(|error| error.to_string())?;
    Ok(Arc::new(Abstraction {
        ranked: with_trees(&fit.ranked, cancel),
        target,
        by_rules: fit.by_rules,
        drawn: [fit.candidates, CANDIDATES],
    }))
}

/// The best of them, with their trees.
fn with_trees(
    ranked: &[Candidate],
    cancel: &AtomicBool,
) -> Vec<(Candidate, Arc<crate::tree::Tree>)> {
    let limits = Limits::default();
    let trees = ranked.iter().take(RANKED).filter_map(|one| {
        let tree = grow(&one.params, &limits, cancel).ok()?;
        Some((one.clone(), Arc::new(tree)))
    });
    trees.collect()
}
