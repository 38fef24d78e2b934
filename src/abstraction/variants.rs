//! More trees of the same parameters: individuals of one kind, each of a seed of its own.

use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use super::fit::{Candidate, sort};
use super::grow::grow;
use super::params::Params;
use super::table::Table;
use crate::lsystem::Limits;
use crate::tree::measure::Measures;

/// Trees that are drawn for each that is kept.
pub const DRAWS: usize = 100;
/// Modules of a tree at most: one that is larger is no individual of a kind that has been fitted.
const MODULES_MOST: u64 = 4_000_000;

/// So many trees of some parameters with other seeds, the nearest to a table of a hundred times as many that are drawn, the nearest first. Fewer where `cancel` is
/// set, or where most grow beyond bounds. How many tips a tree has is left to chance, as its parameters say.
pub fn variants(of: &Params, target: &Table, count: usize, cancel: &AtomicBool) -> Vec<Candidate> {
    let limits = Limits {
        modules: MODULES_MOST,
        bytes: 1 << 30,
    };
    let draws = u32::try_from(count.saturating_mul(DRAWS)).unwrap_or(u32::MAX);
    let drawn = |number: u32| {
        let params = Params {
            seed: of.seed.wrapping_add(u64::from(number)) & u64::from(u32::MAX),
            ..of.clone()
        };
        let tree = grow(&params, &limits, cancel).ok()?;
        if tree.segment_count() == 0 {
            return None;
        }
        let table = Table::of(&Measures::whole(&tree));
        Some(Candidate::new(params, tree.segment_count(), table, target))
    };
    let mut all: Vec<Candidate> = (1..=draws).into_par_iter().filter_map(drawn).collect();
    sort(&mut all);
    all.truncate(count);
    all
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    #[test]
    fn variants_are_of_other_seeds_and_the_nearest_first() {
        let params = Params {
            iterations: 6.0,
            iterations_std: 1.0,
            bifurcation_probability: 0.8,
            seed: u64::from(u32::MAX),
            ..Params::default()
        };
        let never = AtomicBool::new(false);
        let Ok(tree) = grow(&params, &Limits::default(), &never) else {
            panic!("it grows");
        };
        let target = Table::of(&Measures::whole(&tree));
        let found = variants(&params, &target, 4, &never);
        assert_eq!(found.len(), 4);
        let mut seeds: Vec<u64> = found.iter().map(|one| one.params.seed).collect();
        assert!(found.is_sorted_by(|a, b| a.distance <= b.distance));
        seeds.sort_unstable();
        seeds.dedup();
        assert!(seeds.len() == 4 && !seeds.contains(&params.seed));
        assert!(variants(&params, &target, 0, &never).is_empty());
        assert!(variants(&params, &target, 4, &AtomicBool::new(true)).is_empty());
    }
}
