//! Long vectors made by all threads, each number written once.
//!
//! To zero a vector before all of it is written is a pass over memory of its own, a tenth of the time of reading a file of plain numbers; and without
//! `unsafe` nothing but rayon's collecting writes where nothing stood. So rows are made in blocks on the stack, which rayon collects, and
//! the vector of blocks is taken as one of rows.
//!
//! *Tried*: rows collected one by one: the loop over them is then rayon's and takes no numbers at once, and a fault has to be looked for at each.

use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::stretch::Window;
use super::{Stop, Task, with_room};

/// Rows of a block: a KiB or two, which stay in the nearest cache, also where two threads share it. *Tried*: 2048, twice as slow.
const BLOCK: usize = 128;
/// Blocks that a thread takes at once at least: some ten microseconds of work.
const BLOCKS: usize = 64;

/// So many rows: `fill` is given the number of the first and the places of some. Of several faults the first is told, whatever the number of threads. The
/// caller has seen that the file can fill them.
pub(super) fn rows<T: Copy + Default + Send>(
    count: usize,
    task: &Task<'_>,
    fill: impl Fn(usize, &mut [T]) -> Result<(), Stop> + Sync,
) -> Result<Vec<T>, Stop> {
    rows_by(count, task, |_, first, to| fill(first, to))
}

/// The same of a file that may not be in memory.
pub(super) fn rows_by<T: Copy + Default + Send>(
    count: usize,
    task: &Task<'_>,
    fill: impl Fn(&mut Window, usize, &mut [T]) -> Result<(), Stop> + Sync,
) -> Result<Vec<T>, Stop> {
    let whole = count / BLOCK;
    let mut blocks: Vec<[T; BLOCK]> = with_room(count.div_ceil(BLOCK))?;
    let faults = Faults::default();
    let block = |window: &mut Window, block: usize| {
        let mut made = [T::default(); BLOCK];
        if !faults.are_before(block) {
            let done = task
                .go_on()
                .and_then(|()| fill(window, block * BLOCK, &mut made));
            faults.add(block, done);
        }
        made
    };
    let all = (0..whole).into_par_iter().with_min_len(BLOCKS);
    all.map_init(Window::default, block)
        .collect_into_vec(&mut blocks);
    faults.first()?;
    let mut made = blocks.into_flattened();
    // There is room for a block more.
    made.resize(count, T::default());
    let from = whole * BLOCK;
    let last = made.get_mut(from..).unwrap_or_default();
    fill(&mut Window::default(), from, last)?;
    Ok(made)
}

/// The fault of the first block that has one.
struct Faults {
    /// Its number; blocks behind it need not be made.
    block: AtomicUsize,
    fault: Mutex<Option<(usize, Stop)>>,
}

impl Default for Faults {
    fn default() -> Self {
        Self {
            block: AtomicUsize::new(usize::MAX),
            fault: Mutex::default(),
        }
    }
}

impl Faults {
    fn are_before(&self, block: usize) -> bool {
        self.block.load(Ordering::Relaxed) < block
    }

    fn add(&self, block: usize, done: Result<(), Stop>) {
        let Err(stop) = done else { return };
        self.block.fetch_min(block, Ordering::Relaxed);
        let mut fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        if fault.as_ref().is_none_or(|(first, _)| block < *first) {
            *fault = Some((block, stop));
        }
    }

    fn first(self) -> Result<(), Stop> {
        let fault = self.fault.into_inner();
        match fault.unwrap_or_else(PoisonError::into_inner) {
            Some((_, stop)) => Err(stop),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use std::sync::atomic::AtomicBool;

    use super::super::ReadLimits;
    use super::*;

    fn numbers(count: usize, wrong: &[usize], is_stopped: bool) -> Result<Vec<usize>, Stop> {
        let task = Task {
            limits: &ReadLimits::default(),
            cancel: &AtomicBool::new(is_stopped),
            folder: None,
        };
        rows(count, &task, |first, to| {
            for (number, to) in (first..).zip(to) {
                if wrong.contains(&number) {
                    return Err(Stop::fault(number, "is wrong"));
                }
                *to = number;
            }
            Ok(())
        })
    }

    #[test]
    fn all_are_made_and_none_more() {
        for count in [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 100 * BLOCK * BLOCKS + 7] {
            let made = numbers(count, &[], false).unwrap();
            assert!(made.iter().copied().eq(0..count), "{count}");
            assert!(made.capacity() < count + BLOCK);
        }
    }

    #[test]
    fn the_first_fault_is_told() {
        let count = 100 * BLOCK * BLOCKS + 7;
        for first in [0, BLOCK * BLOCKS * 50 + 3, count - 1] {
            let wrong = [count - 1, first, count - BLOCK, first + BLOCK];
            let wrong = wrong.map(|number| number.max(first));
            let stop = numbers(count, &wrong, false).unwrap_err();
            assert!(
                matches!(stop, Stop::Fault { at, .. } if at == first),
                "{stop:?}"
            );
        }
    }

    #[test]
    fn it_stops_when_asked_to() {
        let stop = numbers(BLOCK, &[], true).unwrap_err();
        assert!(matches!(stop, Stop::Cancelled));
    }
}
