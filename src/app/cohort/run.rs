//! Models analyzed several at a time.
//!
//! A thread of its own takes one model after the other, as many threads as there are for all work; within a model the common workers go on, as
//! they do for one alone. (Models as tasks of those workers would be begun within each other while one waits: as many in memory as there are.) A
//! model begins when what it may take fits beside those that are under way.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError, mpsc};

use anyhow::{Context as _, Result};

use super::entries::Entry;
use super::told::Told;
use crate::app::analysis::{Wanted, checked, endpoints, found, measured, prepared, skeleton};
use crate::app::{ends, memory, sentence};
use crate::mesh::{ReadLimits, read};

/// Bytes that the analysis of a model takes for each of its file, and besides: most models of megabytes take 20 to 30 for each, and soups of leaves
/// 50 million for files of a tenth of a million (the largest resident size of `ramus analyze`).
const PER_BYTE: u64 = 50;
const BESIDES: u64 = 64 << 20;
/// What is taken where the system does not tell how much memory there is.
const ROOM_UNKNOWN: u64 = 2 << 30;

/// Analyzes models, of which each that fails has its reason. `cap`: lines of surfaces go on to the middles of open ends. `progress` gets how many are done of how many.
pub(super) fn analyzed(
    entries: &[&Entry],
    cap: bool,
    progress: &mut dyn FnMut(usize, usize),
) -> Vec<Result<Told, String>> {
    let threads = rayon::current_num_threads().min(entries.len());
    let gate = Gate::new(memory::room().map_or(ROOM_UNKNOWN, |room| room / 2));
    let next = AtomicUsize::new(0);
    let mut results: Vec<Option<Result<Told, String>>> = vec![None; entries.len()];
    let (send, receive) = mpsc::channel();
    progress(0, entries.len());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            let send = send.clone();
            let (gate, next) = (&gate, &next);
            let work = move || {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(entry) = entries.get(place) else {
                        return;
                    };
                    let bytes = entry.path.metadata().map_or(0, |known| known.len());
                    let needed = bytes.saturating_mul(PER_BYTE).saturating_add(BESIDES);
                    gate.enter(needed);
                    let result = analyze(entry, cap).map_err(|error| sentence(&error));
                    gate.leave(needed);
                    if send.send((place, result)).is_err() {
                        return;
                    }
                }
            };
            scope.spawn(work);
        }
        drop(send);
        for (done, (place, result)) in receive.iter().enumerate() {
            results[place] = Some(result);
            progress(done + 1, entries.len());
        }
    });
    results
        .into_iter()
        .map(|result| result.unwrap_or_else(|| Err("its analysis was stopped".to_owned())))
        .collect()
}

/// As `ramus analyze` does.
fn analyze(entry: &Entry, cap: bool) -> Result<Told> {
    let never = AtomicBool::new(false);
    let given = entry.endpoints.as_deref().map(ends::read).transpose();
    let wanted = Wanted {
        source: entry.source,
        endpoints: given.map_err(anyhow::Error::msg)?,
        ..Wanted::default()
    };
    let path: &Path = &entry.path;
    let name = path.display().to_string();
    let model = read(path, &ReadLimits::default(), &never)?;
    let scale = model.scale();
    if let Some(tree) = &model.skeleton {
        let (analysis, _) = skeleton(&wanted, tree, model.mesh.origin, &name, scale)?;
        return Told::new(analysis);
    }
    // A cohort may have skeletons as well, which have no open ends.
    let wanted = Wanted { cap, ..wanted };
    let silent = &mut |_, _| {};
    let mut analysis = || {
        let report = checked(&model.mesh, silent)?;
        let prepared = prepared(&model.mesh, report, silent)?;
        let endpoints = endpoints(&wanted, &prepared)?;
        let found = found(&wanted, &prepared, &endpoints, silent)?;
        Ok(measured(&wanted, &prepared, &found, name.clone(), scale))
    };
    let analysis: Result<_> = analysis();
    Told::new(analysis.with_context(|| format!("cannot analyze {name}"))?)
}

/// Lets work begin while there is room for what it takes; one piece always has it.
struct Gate {
    room: u64,
    taken: Mutex<(usize, u64)>,
    left: Condvar,
}

impl Gate {
    fn new(room: u64) -> Self {
        Self {
            room,
            taken: Mutex::new((0, 0)),
            left: Condvar::new(),
        }
    }

    fn enter(&self, bytes: u64) {
        let full =
            |taken: &mut (usize, u64)| taken.0 > 0 && taken.1.saturating_add(bytes) > self.room;
        let taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let mut taken = self
            .left
            .wait_while(taken, full)
            .unwrap_or_else(PoisonError::into_inner);
        taken.0 += 1;
        taken.1 = taken.1.saturating_add(bytes);
    }

    fn leave(&self, bytes: u64) {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        taken.0 -= 1;
        taken.1 = if taken.0 == 0 {
            0
        } else {
            taken.1.saturating_sub(bytes)
        };
        drop(taken);
        self.left.notify_all();
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    #[test]
    fn no_more_begins_than_has_room_and_one_always_does() {
        for (room, bytes, most) in [(100, 40, 2), (100, 1000, 1), (0, 0, 8), (100, u64::MAX, 1)] {
            let gate = Gate::new(room);
            let (now, peak) = (AtomicUsize::new(0), AtomicUsize::new(0));
            std::thread::scope(|scope| {
                for _ in 0..8 {
                    scope.spawn(|| {
                        for _ in 0..20 {
                            gate.enter(bytes);
                            let together = now.fetch_add(1, Ordering::SeqCst) + 1;
                            peak.fetch_max(together, Ordering::SeqCst);
                            std::thread::yield_now();
                            now.fetch_sub(1, Ordering::SeqCst);
                            gate.leave(bytes);
                        }
                    });
                }
            });
            let peak = peak.into_inner();
            assert!((1..=most).contains(&peak), "{peak} of {most}");
        }
    }
}
