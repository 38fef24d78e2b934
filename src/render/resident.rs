//! What the device has of a shown tree: the next one takes what is the same from there, and only what is new is sent.
//!
//! Clusters are known by what they hold. Their cuts depend on that alone ([`crate::tree::levels`]), so a branch that is edited changes the clusters about
//! it, and of each coarser level those that stand for them.

use std::sync::Arc;

use ash::vk;
use hashbrown::HashMap;
use rayon::prelude::*;
use xxhash_rust::xxh3::xxh3_128;

use super::{
    memory::{ALONE, Buffer},
    staging::{Part, Source},
};

/// Clusters on the device, by the hash of their records.
#[derive(Default)]
pub struct Resident {
    places: HashMap<u128, (u32, u64)>,
    /// What they stand in; alive as long as somebody copies from it.
    buffers: Vec<Arc<Buffer>>,
}

impl Resident {
    /// Adds a buffer of these runs.
    pub(crate) fn add(&mut self, buffer: &Arc<Buffer>, runs: &[&[u8]], hashes: &[u128]) {
        let number = u32::try_from(self.buffers.len()).unwrap_or(u32::MAX);
        self.buffers.push(Arc::clone(buffer));
        let mut at = 0;
        self.places
            .extend(runs.iter().zip(hashes).map(|(run, hash)| {
                let place = (number, at);
                at += run.len() as u64;
                (*hash, place)
            }));
    }

    /// Where a cluster is.
    fn place(&self, hash: u128) -> Option<Source> {
        let (number, at) = self.places.get(&hash)?;
        let buffer = self.buffers.get(*number as usize)?;
        Some(Source::Device(buffer.handle, *at))
    }
}

/// The hashes of runs of bytes, which follow each other.
pub(crate) fn hashes(runs: &[&[u8]]) -> Vec<u128> {
    let bytes: usize = runs.iter().map(|run| run.len()).sum();
    if bytes > ALONE {
        runs.par_iter().map(|run| xxh3_128(run)).collect()
    } else {
        runs.iter().map(|run| xxh3_128(run)).collect()
    }
}

/// The parts that a buffer of these runs comes in: from the device where it has them, the others staged. Neighbours are one part.
pub(crate) fn parts(
    runs: &[&[u8]],
    hashes: &[u128],
    to: vk::Buffer,
    before: Option<&Resident>,
) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    let mut at = 0;
    for (run, hash) in runs.iter().zip(hashes) {
        let from = before.and_then(|before| before.place(*hash));
        let part = Part {
            from: from.unwrap_or(Source::Staged),
            to,
            at,
            size: run.len() as u64,
        };
        at += part.size;
        match parts.last_mut() {
            Some(last) if follows(last, part.from) => last.size += part.size,
            _ => parts.push(part),
        }
    }
    parts
}

/// Whether what comes from there goes on where a part ends.
fn follows(part: &Part, from: Source) -> bool {
    match (part.from, from) {
        (Source::Staged, Source::Staged) => true,
        (Source::Device(buffer, at), Source::Device(next, there)) => {
            buffer == next && at + part.size == there
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    #[test]
    fn what_is_new_is_staged_and_neighbours_go_together() {
        let runs: [&[u8]; 4] = [&[1; 80], &[2; 80], &[3; 48], &[1; 80]];
        let hashes = hashes(&runs);
        assert_eq!(hashes[0], hashes[3]);
        let to = vk::Buffer::null();
        let part = |from, at, size| Part { from, to, at, size };
        let all = part(Source::Staged, 0, 288);
        assert_eq!(parts(&runs, &hashes, to, None), [all]);
        let none = Resident::default();
        assert_eq!(parts(&runs, &hashes, to, Some(&none)), [all]);
    }

    #[test]
    fn parts_go_on_where_the_source_does() {
        let to = vk::Buffer::null();
        let device = |at| Source::Device(to, at);
        let part = |from| Part {
            from,
            to,
            at: 0,
            size: 80,
        };
        for (part, from, goes_on) in [
            (part(Source::Staged), Source::Staged, true),
            (part(Source::Staged), device(0), false),
            (part(device(0)), device(80), true),
            (part(device(0)), device(160), false),
            (part(device(0)), Source::Staged, false),
        ] {
            assert_eq!(follows(&part, from), goes_on, "{part:?} {from:?}");
        }
    }
}
