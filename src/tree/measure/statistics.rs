//! Numbers in a few numbers.

use serde::{Deserialize, Serialize};

/// How a quantity is spread; the standard deviation is the population's (divided by n), as in the papers' tables. All but n are 0 where
/// there is nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// How many there are.
    pub n: usize,
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation.
    pub std: f64,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

/// The spread of values; those that are not finite are left out.
pub fn spread(values: impl IntoIterator<Item = f64>) -> Spread {
    let values: Vec<f64> = values
        .into_iter()
        .filter(|value| value.is_finite())
        .collect();
    if values.is_empty() {
        return Spread::default();
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values
        .iter()
        .map(|value| (value - mean).powi(2))
        .sum::<f64>()
        / n;
    Spread {
        n: values.len(),
        mean,
        std: variance.sqrt(),
        min: values.iter().copied().fold(f64::INFINITY, f64::min),
        max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    }
}

/// The value below which a part (0 to 1) of sorted values is, as NumPy and R have it: between two neighbours in proportion. None of nothing.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a place within the values"
)]
pub fn quantile(sorted: &[f64], part: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = part.clamp(0.0, 1.0) * last as f64;
    let below = (place.floor() as usize).min(last);
    let above = (below + 1).min(last);
    let [from, to] = [sorted[below], sorted[above]];
    // Not by their difference where it is none: those of infinities are no number.
    match place - below as f64 {
        0.0 => Some(from),
        rest => Some(from + (to - from) * rest),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    /// `numpy.quantile([1, 2, 4, 8], [0, 0.25, 0.5, 0.9, 1])`
    #[test]
    fn quantiles_are_numpys() {
        let sorted = [1.0, 2.0, 4.0, 8.0];
        for (part, expected) in [(0.0, 1.0), (0.25, 1.75), (0.5, 3.0), (0.9, 6.8), (1.0, 8.0)] {
            let found = quantile(&sorted, part).unwrap_or(f64::NAN);
            assert!((found - expected).abs() < 1e-12, "{part}: {found}");
        }
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(quantile(&[7.0], 0.3), Some(7.0));
    }
}
