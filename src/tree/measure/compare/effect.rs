//! How far two groups are apart, whatever their sizes: p tells whether a difference can be chance, these how large it is.

use super::comparable;
use crate::tree::measure::{Spread, spread};

/// What a Cliff's delta is called, by Romano et al. (2006).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeltaSize {
    /// Below 0.147.
    Negligible,
    /// Below 0.33.
    Small,
    /// Below 0.474.
    Medium,
    /// From there on.
    Large,
}

impl DeltaSize {
    /// Of a delta of either sign.
    pub fn of(delta: f64) -> Self {
        match delta.abs() {
            size if size < 0.147 => Self::Negligible,
            size if size < 0.33 => Self::Small,
            size if size < 0.474 => Self::Medium,
            _ => Self::Large,
        }
    }

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Negligible => "negligible",
            Self::Small => "small",
            Self::Medium => "medium",
            Self::Large => "large",
        }
    }
}

/// Cliff's delta, which the rank-biserial correlation is, too, by U of the first group: how much more often its values are larger than smaller;
/// 1 where all of them are larger, −1 where all are smaller.
pub fn cliffs_delta(u: f64, n: usize, m: usize) -> f64 {
    let pairs = n as f64 * m as f64;
    (2.0 * u - pairs) / pairs
}

/// Hedges' g: the first group's mean less the second's, in standard deviations of both together, with the correction 1 − 3 / (4 (n + m) − 9) for
/// few values. None with fewer than two values in a group, and where nothing differs within either.
pub fn hedges_g(a: &[f64], b: &[f64]) -> Option<f64> {
    if !comparable(a, b) || a.len().min(b.len()) < 2 {
        return None;
    }
    let [of_a, of_b] = [a, b].map(|values| spread(values.iter().copied()));
    let squares = |of: Spread| of.std.powi(2) * of.n as f64;
    let all = (a.len() + b.len()) as f64;
    let together = ((squares(of_a) + squares(of_b)) / (all - 2.0)).sqrt();
    let g = (of_a.mean - of_b.mean) / together * (1.0 - 3.0 / (4.0 * all - 9.0));
    g.is_finite().then_some(g)
}
