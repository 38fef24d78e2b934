//! Numbers with no more digits than a tolerance asks for, and numbers that are alike.

/// Digits behind the point at most.
const DECIMALS: i32 = 17;

/// Digits before the point at most.
const LARGEST: i32 = 40;

/// The number with the fewest digits that is within a distance of a value.
pub(super) fn shortest(value: f64, within: f64) -> f64 {
    if value.abs() <= within || value == 0.0 {
        return 0.0;
    }
    // A number of so many digits before its point may be rounded to all but the first of them.
    let whole = (-DECIMALS..=LARGEST)
        .rev()
        .find(|at| value.abs() >= 10.0_f64.powi(*at));
    let first = whole.map_or(DECIMALS, |whole| -1 - whole);
    for decimals in first..=DECIMALS {
        let scale = 10.0_f64.powi(decimals.abs());
        let rounded = if decimals < 0 {
            (value / scale).round() * scale
        } else {
            (value * scale).round() / scale
        };
        if (rounded - value).abs() <= within {
            return rounded;
        }
    }
    value
}

/// The same for widths: what is thick is never written as 0, so that a tree is seen however much may be off.
pub(super) fn thickness(width: f64, within: f64) -> f64 {
    shortest(width, within.min(0.1 * width))
}

/// A value among others that are alike.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) value: f64,
    /// How well it is known.
    pub(super) weight: f64,
}

/// Values put into groups no wider than `width`: the group of each, and the number that stands for each group, with few digits.
pub(super) fn groups(samples: &[Sample], width: f64) -> (Vec<u32>, Vec<f64>) {
    let mut by_value: Vec<usize> = (0..samples.len()).collect();
    by_value.sort_by(|a, b| {
        samples[*a]
            .value
            .total_cmp(&samples[*b].value)
            .then(a.cmp(b))
    });
    let (mut group_of, mut numbers) = (vec![0; samples.len()], Vec::new());
    let mut rest = by_value.as_slice();
    while let Some(first) = rest.first() {
        let least = samples[*first].value;
        let inside = rest.partition_point(|at| samples[*at].value - least <= width);
        let (group, behind) = rest.split_at(inside.max(1));
        let number = u32::try_from(numbers.len()).unwrap_or(u32::MAX);
        let (mut sum, mut weight) = (0.0, 0.0);
        for at in group {
            group_of[*at] = number;
            sum += samples[*at].value * samples[*at].weight;
            weight += samples[*at].weight;
        }
        let mean = if weight > 0.0 { sum / weight } else { least };
        numbers.push(mean);
        rest = behind;
    }
    (group_of, numbers)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_they_need() {
        for (value, within, expected) in [
            (0.899_999_97, 1e-4, 0.9),
            (137.500_01, 0.01, 137.5),
            (137.500_01, 1.0, 138.0),
            (-25.714_28, 0.05, -25.7),
            (1234.5, 50.0, 1200.0),
            (0.001_23, 5e-5, 0.001_2),
            (0.3, 0.4, 0.0),
            (0.0, 0.0, 0.0),
            (9.99, 0.1, 10.0),
        ] {
            let found = shortest(value, within);
            assert!((found - expected).abs() < 1e-12, "{value}: {found}");
        }
        for value in [1.0 / 3.0, 1e-12, -7e9, f64::MIN_POSITIVE, f64::MAX] {
            assert!(
                (shortest(value, 0.0) - value).abs() <= value.abs() * 1e-15,
                "{value}"
            );
        }
    }

    #[test]
    fn groups_are_no_wider_than_they_may_be() {
        let samples = [0.7, 0.1, 0.11, 0.69, 5.0, 0.12].map(|value| Sample { value, weight: 1.0 });
        let (of, numbers) = groups(&samples, 0.05);
        assert_eq!(of, [1, 0, 0, 1, 2, 0]);
        assert!((numbers[0] - 0.11).abs() < 1e-12 && numbers.len() == 3);
    }
}
