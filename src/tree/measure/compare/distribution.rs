//! The test by Kolmogorov and Smirnov for two samples: how far apart two distributions are, wherever they differ most.

use std::f64::consts::PI;

use super::{Method, comparable};

/// With more values than this in a group the limit is near enough; as SciPy has it.
const EXACT_MOST: usize = 10_000;

/// What the test tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KolmogorovSmirnov {
    /// The largest difference between the parts of both groups that are at or below a value; 0 to 1.
    pub d: f64,
    /// How likely such a difference or a larger one is where both groups are of one distribution. With equal values it is rather too large.
    pub p: f64,
    /// How p was had: by counting up to 10,000 values in a group.
    pub method: Method,
}

/// Compares two groups by their distributions. None where one is empty or has something that is no number.
pub fn kolmogorov_smirnov(a: &[f64], b: &[f64]) -> Option<KolmogorovSmirnov> {
    if !comparable(a, b) {
        return None;
    }
    let mut sorted = [a.to_vec(), b.to_vec()];
    for values in &mut sorted {
        values.sort_by(f64::total_cmp);
    }
    let apart = farthest(&sorted[0], &sorted[1]);
    let [n, m] = [a.len() as f64, b.len() as f64];
    let d = apart as f64 / (n * m);
    let (p, method) = if a.len().max(b.len()) <= EXACT_MOST {
        (beyond(a.len(), b.len(), apart), Method::Exact)
    } else {
        (limit(d * (n * m / (n + m)).sqrt()), Method::Limit)
    };
    Some(KolmogorovSmirnov { d, p, method })
}

/// The largest difference of the distributions, in parts of both numbers' product.
fn farthest(a: &[f64], b: &[f64]) -> usize {
    let (mut x, mut y, mut apart) = (0, 0, 0);
    while x < a.len() && y < b.len() {
        let value = a[x].min(b[y]);
        x += a[x..].iter().take_while(|other| **other <= value).count();
        y += b[y..].iter().take_while(|other| **other <= value).count();
        apart = apart.max((x * b.len()).abs_diff(y * a.len()));
    }
    apart
}

/// Which part of all orders of the values has a difference of `apart` somewhere. An order is a path from corner to corner of a grid; of the
/// paths to a point, as many parts come from the left as it is from there, so the parts that were outside are weighted so. Nothing is
/// taken from anything, so small ones are as exact as large ones.
fn beyond(n: usize, m: usize, apart: usize) -> f64 {
    if apart == 0 {
        return 1.0;
    }
    let mut outside = vec![0.0_f64; m + 1];
    for x in 0..=n {
        let mut left = 0.0; // Of the point before in this row.
        for (y, here) in outside.iter_mut().enumerate() {
            let steps = (x + y) as f64;
            *here = if (x * m).abs_diff(y * n) >= apart {
                1.0
            } else if x + y == 0 {
                0.0
            } else {
                (x as f64 * *here + y as f64 * left) / steps
            };
            left = *here;
        }
    }
    outside[m].min(1.0)
}

/// Kolmogorov's distribution from `x` on: one series where it is small, another where it is large.
fn limit(x: f64) -> f64 {
    if x < 1.0 {
        let term = |k: f64| (-((2.0 * k - 1.0) * PI / x).powi(2) / 8.0).exp();
        let below = (2.0 * PI).sqrt() / x * (1..=4).map(|k| term(f64::from(k))).sum::<f64>();
        return if x > 0.0 { 1.0 - below } else { 1.0 };
    }
    let term = |k: f64| (-2.0 * k * k * x * x).exp();
    2.0 * (term(1.0) - term(2.0) + term(3.0) - term(4.0))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    /// `[scipy.stats.kstwobign.sf(x) for x in (0.3, 0.7, 0.99, 1.0, 1.5, 3.0)]`
    #[test]
    fn the_limit_is_scipys() {
        for (x, expected) in [
            (0.3, 0.9999906941986655),
            (0.7, 0.7112351950296893),
            (0.99, 0.2808738392255489),
            (1.0, 0.26999967167735456),
            (1.5, 0.022217962616525127),
            (3.0, 3.045995948942526e-08),
        ] {
            let found = limit(x);
            assert!((found / expected - 1.0).abs() < 1e-9, "{x}: {found}");
        }
        assert_eq!(limit(0.0), 1.0);
    }
}
