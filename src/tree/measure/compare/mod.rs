//! Two groups of numbers, compared: by ranks, by their distributions, and by how far apart they are.
//!
//! ```text
//! a, b ─▶ Mann–Whitney: U, p ─▶ Cliff's delta          p of many measures ─▶ Holm, Benjamini–Hochberg
//!    ├──▶ Kolmogorov–Smirnov: D, p
//!    └──▶ Hedges' g
//! pairs ─▶ Wilcoxon's signed ranks: W, z, p
//! ```
//!
//! All of groups agree with SciPy's default methods to the last digits, so that a reader can check them. `statrs` 0.19 has the first two tests and was
//! left: its exact ranks go through every choice of models, which are 10¹¹ of 8 among 100, and its tail is 1 less something near 1, so
//! that no p is below 10⁻¹⁶.

mod correct;
mod distribution;
mod effect;
mod paired;
mod ranks;

pub use self::correct::{benjamini_hochberg, holm};
pub use self::distribution::{KolmogorovSmirnov, kolmogorov_smirnov};
pub use self::effect::{DeltaSize, cliffs_delta, hedges_g};
pub use self::paired::{Wilcoxon, wilcoxon};
pub use self::ranks::{MannWhitney, mann_whitney};

/// How a p-value was had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// By counting all ways that the values could have fallen.
    Exact,
    /// By the distribution that it nears with many values.
    Limit,
}

impl Method {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Limit => "limit",
        }
    }
}

/// Both groups have values, and all are numbers.
fn comparable(a: &[f64], b: &[f64]) -> bool {
    !a.is_empty() && !b.is_empty() && a.iter().chain(b).all(|value| value.is_finite())
}

#[cfg(test)]
mod tests;
