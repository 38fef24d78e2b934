//! A smooth line through points that are known more or less well.
//!
//! Points' squared distances from what is known, in their spreads, plus the square of the line's third derivative by its length, in radii,
//! are least: a line may bend, and bends change slowly. (Second derivatives would pull bends straight, and at a line's end, where it is led
//! into a fork, its tangent instead of its bend would go on.) Coordinates are independent of each other, and each is a banded system.

use glam::DVec3;

/// A point with where it is known to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot {
    pub(super) known: DVec3,
    /// How far off that may be; infinite where nothing is known.
    pub(super) spread: f64,
    /// The unit of lengths there.
    pub(super) radius: f64,
}

/// A smooth line.
#[derive(Clone, Debug)]
pub(super) struct Smooth {
    pub(super) points: Vec<DVec3>,
    /// How far the first and the last may be off.
    pub(super) ends: [f64; 2],
}

/// Rows of a symmetric matrix: the diagonal and three before it.
type Row = [f64; 4];

/// The smooth line through knots, which are in order; `jerk` is what the third derivative is expected to be, in radii to the minus two.
pub(super) fn smooth(knots: &[Knot], jerk: f64) -> Option<Smooth> {
    let count = knots.len();
    if count < 2 {
        return None;
    }
    let radius = knots.iter().map(|knot| knot.radius).sum::<f64>() / count as f64;
    let mut places = vec![0.0];
    for pair in knots.windows(2) {
        let mean = f64::midpoint(pair[0].radius, pair[1].radius);
        let step = (pair[0].known.distance(pair[1].known) / mean).max(1e-6);
        places.push(places[places.len() - 1] + step);
    }
    let mut matrix: Vec<Row> = vec![[0.0; 4]; count];
    let mut right = vec![DVec3::ZERO; count];
    for (place, knot) in knots.iter().enumerate() {
        // What is not known is known a little, so that there is a line.
        let spread = knot.spread.min(1e3 * radius);
        let weight = (radius / spread).powi(2);
        matrix[place][0] += weight;
        right[place] += weight * knot.known;
    }
    let order = 3.min(count - 1);
    for first in 0..count - order {
        let window = &places[first..=first + order];
        // Divided differences, and how much of the line they stand for.
        let weights: Vec<f64> = (0..=order)
            .map(|i| {
                let others = (0..=order).filter(|j| *j != i);
                others
                    .map(|j| window[i] - window[j])
                    .product::<f64>()
                    .recip()
                    * 6.0
            })
            .collect();
        let length = (window[order] - window[0]) / order as f64;
        let stiff = length / (jerk * jerk);
        for i in 0..=order {
            for j in 0..=i {
                matrix[first + i][i - j] += stiff * weights[i] * weights[j];
            }
        }
    }
    let factor = factored(matrix)?;
    let unit = |place: usize| {
        let mut right = vec![0.0; count];
        right[place] = 1.0;
        solved(&factor, right)[place].max(0.0).sqrt() * radius
    };
    let axis = |axis: usize| solved(&factor, right.iter().map(|sum| sum[axis]).collect());
    let [x, y, z] = [axis(0), axis(1), axis(2)];
    let points = (0..count).map(|i| DVec3::new(x[i], y[i], z[i]));
    Some(Smooth {
        points: points.collect(),
        ends: [unit(0), unit(count - 1)],
    })
}

/// The lower factor of a banded matrix (Cholesky).
fn factored(mut matrix: Vec<Row>) -> Option<Vec<Row>> {
    for i in 0..matrix.len() {
        for back in (0..=3.min(i)).rev() {
            let j = i - back;
            let from = i.saturating_sub(3).max(j.saturating_sub(3));
            let sum = (from..j).fold(matrix[i][back], |sum, k| {
                sum - matrix[i][i - k] * matrix[j][j - k]
            });
            matrix[i][back] = if back > 0 {
                sum / matrix[j][0]
            } else if sum > 0.0 && sum.is_finite() {
                sum.sqrt()
            } else {
                return None;
            };
        }
    }
    Some(matrix)
}

fn solved(factor: &[Row], mut right: Vec<f64>) -> Vec<f64> {
    for i in 0..right.len() {
        let sum =
            (i.saturating_sub(3)..i).fold(right[i], |sum, k| sum - factor[i][i - k] * right[k]);
        right[i] = sum / factor[i][0];
    }
    for i in (0..right.len()).rev() {
        let sum = (i + 1..(i + 4).min(right.len()))
            .fold(right[i], |sum, k| sum - factor[k][k - i] * right[k]);
        right[i] = sum / factor[i][0];
    }
    right
}
