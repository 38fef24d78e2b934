//! Numbers with no more digits than a tolerance asks for, and numbers that are alike.

/// Digits behind the point at most.
const DECIMALS: i32 = 17;

/// The number with the fewest digits that is within a distance of a value.
pub(super) fn shortest(value: f64, within: f64) -> f64 {
    if value.abs() <= within || value == 0.0 {
        return 0.0;
    }
    let whole = (value.abs().log10().floor().clamp(-300.0, 300.0) as i32).saturating_add(1);
    for decimals in -whole..=DECIMALS {
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
