//! p-values of many tests, corrected: among twenty measures that do not differ, one has a p below 0.05 by chance.

/// By Holm (1979): a p below 0.05 among these is of a difference, with at most 5 in 100 that any of them is by chance.
pub fn holm(values: &[f64]) -> Vec<f64> {
    let many = values.len();
    stepped(values, (0..many).map(|place| (many - place) as f64), false)
}

/// By Benjamini and Hochberg (1995): of those that are below 0.05, at most 5 in 100 are expected to be by chance.
pub fn benjamini_hochberg(values: &[f64]) -> Vec<f64> {
    let many = values.len();
    stepped(
        values,
        (0..many).map(|place| many as f64 / (place + 1) as f64),
        true,
    )
}

/// Multiplies values, from the smallest on, by factors, and keeps their order: by the largest of those before, or by the smallest from there on.
fn stepped(values: &[f64], factors: impl Iterator<Item = f64>, from_above: bool) -> Vec<f64> {
    let mut places: Vec<usize> = (0..values.len()).collect();
    places.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut found: Vec<(usize, f64)> = places
        .into_iter()
        .zip(factors)
        .map(|(place, factor)| (place, (values[place] * factor).min(1.0)))
        .collect();
    if from_above {
        let mut least = 1.0_f64;
        for (_, value) in found.iter_mut().rev() {
            least = least.min(*value);
            *value = least;
        }
    } else {
        let mut most = 0.0_f64;
        for (_, value) in &mut found {
            most = most.max(*value);
            *value = most;
        }
    }
    let mut corrected = vec![0.0; values.len()];
    for (place, value) in found {
        corrected[place] = value;
    }
    corrected
}
