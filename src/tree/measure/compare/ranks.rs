//! The test by Mann and Whitney (1947): whether values of one group tend to be larger than those of another.

use super::{Method, comparable};

/// With more values than this in both groups the normal distribution is near enough; as SciPy has it.
const EXACT_MOST: usize = 8;

/// What the test tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MannWhitney {
    /// Pairs of a value of each group in which the first group's is larger; equal ones count half.
    pub u: f64,
    /// How likely it is that U is as far from its middle, to either side, where both groups are of one distribution.
    pub p: f64,
    /// How p was had: by counting where one group has eight values or fewer and no two are equal, else by the normal distribution, corrected
    /// for equal values and for continuity.
    pub method: Method,
}

/// Compares two groups by ranks. None where one is empty or has something that is no number.
pub fn mann_whitney(a: &[f64], b: &[f64]) -> Option<MannWhitney> {
    if !comparable(a, b) {
        return None;
    }
    let mut all: Vec<(f64, bool)> = a.iter().map(|value| (*value, true)).collect();
    all.extend(b.iter().map(|value| (*value, false)));
    all.sort_by(|one, other| one.0.total_cmp(&other.0));
    let [n, m] = [a.len() as f64, b.len() as f64];
    let (mut ranks, mut before, mut ties) = (0.0, 0.0, 0.0);
    // −0 and 0 are equal, as they stand beside each other.
    for equal in all.chunk_by(|one, other| one.0 == other.0) {
        let count = equal.len() as f64;
        let own = equal.iter().filter(|(_, first)| *first).count() as f64;
        ranks += own * (before + f64::midpoint(count, 1.0));
        before += count;
        ties += count.powi(3) - count;
    }
    let u = ranks - n * (n + 1.0) / 2.0;
    let farther = u.max(n * m - u);
    let few = a.len().min(b.len());
    let (p, method) = if few <= EXACT_MOST && ties == 0.0 {
        let p = 2.0 * tail(few, a.len().max(b.len()), farther);
        (p, Method::Exact)
    } else {
        (2.0 * normal_tail(farther, n, m, ties), Method::Limit)
    };
    let p = p.min(1.0);
    Some(MannWhitney { u, p, method })
}

/// How likely a U from `from` on is without equal values.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "without equal values U is a whole number that is not below zero"
)]
fn tail(few: usize, many: usize, from: f64) -> f64 {
    let ways = ways(few, many);
    let sum = |ways: &[i128]| ways.iter().sum::<i128>() as f64;
    let from = (from as usize).min(ways.len());
    sum(&ways[from..]) / sum(&ways)
}

/// In how many ways each U comes about: the coefficients of the Gaussian binomial. They are whole numbers below 2¹²⁷ for all groups of which
/// the smaller has eight values and the other a million.
fn ways(few: usize, many: usize) -> Vec<i128> {
    let mut ways = vec![0_i128; few * many + 1];
    ways[0] = 1;
    for factor in 1..=few {
        for place in (many + factor..ways.len()).rev() {
            ways[place] -= ways[place - many - factor];
        }
        for place in factor..ways.len() {
            ways[place] += ways[place - factor];
        }
    }
    ways
}

fn normal_tail(u: f64, n: f64, m: f64, ties: f64) -> f64 {
    let all = n + m;
    let variance = n * m / 12.0 * (all + 1.0 - ties / (all * (all - 1.0)));
    let z = (u - n * m / 2.0 - 0.5) / variance.sqrt();
    // Where all are equal there is no variance, and z is below all numbers.
    libm::erfc(z / std::f64::consts::SQRT_2) / 2.0
}
