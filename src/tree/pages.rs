//! Memory in pages of its own, kept when it is given back.
//!
//! To touch fresh memory is most of the time that a long string takes: the system clears each page first, and the threads that ask for
//! pages wait for each other. A string that is derived again, after an edit or for the next frame, finds the pages of the last one.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

use memmap2::MmapMut;

/// Bytes of a huge page.
pub(super) const HUGE_PAGE: usize = 2 << 20;
/// Bytes that are kept at most.
const MOST_KEPT: usize = 256 << 20;

/// What was given back, the oldest first.
static KEPT: Mutex<Vec<MmapMut>> = Mutex::new(Vec::new());

/// Pages that nobody else has.
pub(super) struct Pages(Option<MmapMut>);

impl Pages {
    fn fresh(bytes: usize) -> Option<Self> {
        let pages = MmapMut::map_anon(bytes).ok()?;
        // Where there are no huge pages, small ones serve.
        #[cfg(target_os = "linux")]
        let _ = pages.advise(memmap2::Advice::HugePage);
        Some(Self(Some(pages)))
    }

    /// Pages for so many bytes that will all be written; none where the memory is not there. They are kept ones where some have about
    /// that size; else the kept ones go back to the system, so that there is never more than is asked for.
    pub(super) fn unwritten(bytes: usize) -> Option<Self> {
        let kept = fitting(&mut lock(), bytes);
        if kept.is_some() {
            return Some(Self(kept));
        }
        forget();
        Self::fresh(bytes)
    }
}

fn lock() -> std::sync::MutexGuard<'static, Vec<MmapMut>> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Gives the kept pages back to the system.
fn forget() {
    let kept = std::mem::take(&mut *lock());
    drop(kept); // the lock is free meanwhile
}

/// The smallest of them with room for so many bytes, and not for more than twice as many.
fn fitting(kept: &mut Vec<MmapMut>, bytes: usize) -> Option<MmapMut> {
    let fit = kept.iter().enumerate();
    let fit = fit.filter(|(_, pages)| pages.len() >= bytes && pages.len() / 2 <= bytes);
    let (at, _) = fit.min_by_key(|(_, pages)| pages.len())?;
    Some(kept.remove(at))
}

impl Drop for Pages {
    fn drop(&mut self) {
        let Some(pages) = self.0.take() else { return };
        let gone = {
            let mut kept = lock();
            kept.push(pages);
            past_most(&mut kept)
        };
        drop(gone); // the lock is free meanwhile
    }
}

/// Takes out the oldest, as many as are too much.
fn past_most(kept: &mut Vec<MmapMut>) -> Vec<MmapMut> {
    let mut bytes: usize = kept.iter().map(|pages| pages.len()).sum();
    let mut past = 0;
    for pages in kept.iter() {
        if bytes <= MOST_KEPT {
            break;
        }
        bytes -= pages.len();
        past += 1;
    }
    kept.drain(..past).collect()
}

impl Deref for Pages {
    type Target = [u8];

    #[inline]
    fn deref(&self) -> &[u8] {
        self.0.as_deref().unwrap_or(&[])
    }
}

impl DerefMut for Pages {
    #[inline]
    fn deref_mut(&mut self) -> &mut [u8] {
        self.0.as_deref_mut().unwrap_or(&mut [])
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    /// Kept pages of so many bytes each.
    fn kept(sizes: &[usize]) -> Vec<MmapMut> {
        let pages = sizes.iter().map(|bytes| MmapMut::map_anon(*bytes));
        pages.map(Result::unwrap).collect()
    }

    #[test]
    fn pages_of_about_the_size_are_used_again() {
        const PAGE: usize = 4096;
        let sizes = [9 * PAGE, 4 * PAGE, 5 * PAGE];
        for (wanted, found) in [
            (1, None),
            (2 * PAGE, Some(4 * PAGE)),
            (4 * PAGE, Some(4 * PAGE)),
            (4 * PAGE + 1, Some(5 * PAGE)),
            (6 * PAGE, Some(9 * PAGE)),
            (9 * PAGE + 1, None),
        ] {
            let mut kept = kept(&sizes);
            let fit = fitting(&mut kept, wanted).map(|pages| pages.len());
            assert_eq!(fit, found, "{wanted}");
            assert_eq!(kept.len(), 3 - usize::from(found.is_some()));
        }
    }

    #[test]
    fn the_oldest_go_back_to_the_system() {
        const MIB: usize = 1 << 20;
        for (sizes, left) in [
            (vec![], vec![]),
            (vec![100 * MIB, 156 * MIB], vec![100 * MIB, 156 * MIB]),
            (vec![100 * MIB, 157 * MIB], vec![157 * MIB]),
            (vec![MIB, 200 * MIB, 100 * MIB], vec![100 * MIB]),
            (vec![MIB, MOST_KEPT + MIB], vec![]),
        ] {
            let mut kept = kept(&sizes);
            let gone = past_most(&mut kept);
            let lengths: Vec<usize> = kept.iter().map(|pages| pages.len()).collect();
            assert_eq!(lengths, left);
            assert_eq!(gone.len(), sizes.len() - left.len());
        }
    }
}
