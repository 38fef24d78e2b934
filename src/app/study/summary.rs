//! Numbers of a group in a few numbers, and two of them compared by pairs.

use serde::Serialize;

use crate::tree::measure::compare::{Wilcoxon, holm, wilcoxon};
use crate::tree::measure::{quantile, spread};

/// How scores are spread.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// How many there are.
    pub n: usize,
    /// Their mean.
    pub mean: f64,
    /// The standard deviation of a sample (divided by n − 1); none of one score.
    pub sd: Option<f64>,
    /// Their median.
    pub median: f64,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl Summary {
    /// Of scores; none of nothing.
    pub fn of(scores: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut scores: Vec<f64> = scores.into_iter().collect();
        scores.sort_by(f64::total_cmp);
        let median = quantile(&scores, 0.5)?;
        let n = scores.len();
        let found = spread(scores);
        let of_sample = |n: f64| found.std * (n / (n - 1.0)).sqrt();
        Some(Self {
            n,
            mean: found.mean,
            sd: (n > 1).then(|| of_sample(n as f64)),
            median,
            min: found.min,
            max: found.max,
        })
    }
}

/// Pairs of scores of the same people, compared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Paired {
    /// What the second score has more than the first.
    pub difference: Summary,
    /// The test; none where no pair differs.
    pub test: Option<Test>,
}

/// Wilcoxon's test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Test {
    /// Pairs that differ.
    pub n: usize,
    /// Ranks of pairs whose second score is larger, summed.
    pub w_plus: f64,
    /// Ranks of those whose first is.
    pub w_minus: f64,
    /// The smaller sum in standard deviations from its middle.
    pub z: f64,
    /// Two-sided.
    pub p: f64,
    /// How it was had: exact or limit.
    pub p_method: &'static str,
    /// By the normal distribution, without a correction for continuity.
    pub p_limit: f64,
    /// p corrected by Holm where several statements are tested together.
    pub p_holm: Option<f64>,
    /// The matched-pairs rank-biserial correlation, −1 to 1.
    pub effect: f64,
}

impl From<Wilcoxon> for Test {
    fn from(found: Wilcoxon) -> Self {
        Self {
            n: found.n,
            w_plus: found.plus,
            w_minus: found.minus,
            z: found.z,
            p: found.p,
            p_method: found.method.name(),
            p_limit: found.p_limit,
            p_holm: None,
            effect: found.effect(),
        }
    }
}

/// Compares pairs of whole numbers, of which each is worth `weight`: differences of weighted ones would differ in their last digits, and equal
/// ones with them. None without pairs.
pub fn paired(pairs: &[[f64; 2]], weight: f64) -> Option<Paired> {
    Some(Paired {
        difference: Summary::of(pairs.iter().map(|[a, b]| (b - a) * weight))?,
        test: wilcoxon(pairs).map(Test::from),
    })
}

/// Corrects the p of tests that were made together.
pub fn corrected(all: &mut [Option<Paired>]) {
    let mut tests: Vec<&mut Test> = all
        .iter_mut()
        .flatten()
        .filter_map(|one| one.test.as_mut())
        .collect();
    let values: Vec<f64> = tests.iter().map(|test| test.p).collect();
    for (test, p) in tests.iter_mut().zip(holm(&values)) {
        test.p_holm = Some(p);
    }
}
