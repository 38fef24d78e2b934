//! Where neighbours are cut into runs, so that what is edited changes the clusters about it and leaves the others as they were.
//!
//! A cut is where what stands there says so, not where so many came before: one segment more shifts all behind it, but their next cut is where it was
//! (content-defined chunking: Muthitacharoen, Chen and Mazières 2001, "A Low-bandwidth Network File System", §3.1). Clusters are numbered from their run's
//! beginning, and become half as many inside it, [`ROUNDS`] times; then what is left is cut into runs anew.

/// After so many halvings a run of 8 to 15 is one; what is left of the last one's 16 is two, which are cut anew with the others.
pub(super) const ROUNDS: usize = 3;
/// Members of a run, at least; twice as many are too many. Where there are fewer in all there is one.
const LEAST: usize = 1 << ROUNDS;

/// How long each run is of so many in a row, `each` of which stand in a cluster. `mark`: a number for what stands at a place, the same wherever that is.
pub(super) fn lengths(count: usize, each: usize, mark: impl Fn(usize) -> u64) -> Vec<usize> {
    let (least, most) = (LEAST * each, (2 * LEAST - 1) * each);
    // Tried on random marks: rarer or more often, and more runs differ behind an edit before cuts meet again.
    let one_in = (least / 2).max(1) as u64;
    let mut lengths = Vec::with_capacity(count / least + 1);
    let mut start = 0;
    while count - start >= 2 * least {
        let longest = most.min(count - least - start);
        let is_cut = |length: &usize| mark(start + length).is_multiple_of(one_in);
        let length = (least..longest).find(is_cut).unwrap_or(longest);
        lengths.push(length);
        start += length;
    }
    if start < count {
        lengths.push(count - start);
    }
    lengths
}

/// A number that looks random, from another and from how many halvings came before: what was a cut then need be none now.
pub(super) fn stirred(mark: u64, round: usize) -> u64 {
    // The steps of splitmix64 (Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number Generators").
    let salt = (round as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut mixed = mark.wrapping_add(salt);
    mixed = (mixed ^ mixed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ mixed >> 31
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    #[test]
    fn runs_hold_everything_and_none_is_short() {
        for count in [0, 1, 7, 8, 15, 16, 17, 100, 5000] {
            for each in [1, 64] {
                let lengths = lengths(count, each, |at| stirred(at as u64, 0));
                assert_eq!(lengths.iter().sum::<usize>(), count);
                let (least, most) = (8 * each, 16 * each);
                for length in &lengths {
                    assert!(*length < most && (*length >= least || lengths.len() == 1));
                }
            }
        }
    }

    /// Something more in the middle: cuts before it stay, and so do those from soon behind it on.
    #[test]
    fn one_more_moves_few_cuts() {
        let cuts = |lengths: Vec<usize>| -> Vec<usize> {
            let ends = lengths.iter().scan(0, |end, length| {
                *end += length;
                Some(*end)
            });
            ends.collect()
        };
        for each in [1, 64] {
            let before = cuts(lengths(20_000, each, |at| stirred(at as u64, 0)));
            for more in [1, 5, 63, 700] {
                // What was at `at` stands `more` further from 9,000 on.
                let mark = |at: usize| match at {
                    ..9_000 => stirred(at as u64, 0),
                    _ if at < 9_000 + more => stirred(1_000_000 + at as u64, 0),
                    _ => stirred((at - more) as u64, 0),
                };
                let after = cuts(lengths(20_000 + more, each, mark));
                let kept = |cut: &&usize| {
                    after.contains(&if **cut <= 9_000 { **cut } else { **cut + more })
                };
                let lost = before.iter().filter(|cut| !kept(cut)).count();
                assert!(lost <= 12, "{lost} of {} with {more}", before.len());
            }
        }
    }
}
