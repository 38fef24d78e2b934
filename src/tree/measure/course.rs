//! How a line bends and twists, point by point.
//!
//! Derivatives amplify noise: differences of neighbouring points, as VMTK takes them, say more of the noise than of the line. So the line is
//! put in equal steps, and about each of them a polynomial of the fourth degree is fitted with weights of a bell whose width is one and a half
//! radii (local regression; Fan and Gijbels 1996): a line of a tube bends no faster than that. Curvature is |x′ × x″| / |x′|³, torsion
//! (x′ × x″) · x‴ / |x′ × x″|², above zero for right-handed helices.

use glam::DVec3;

use crate::tree::solve::solve;

/// Width of the bell, in radii: its standard deviation.
const WIDTH: f64 = 1.5;
/// The bell's reach, in widths.
const REACH: f64 = 2.5;
/// Steps to a width.
const STEPS_PER_WIDTH: f64 = 8.0;
/// Steps of a line at most.
const STEPS_MOST: f64 = 8192.0;
/// A line that bends by less over a width, radians, is straight and has no torsion.
const STRAIGHT: f64 = 0.02;
/// Numbers of a polynomial.
const TERMS: usize = 5;

/// A line in equal steps, with its derivatives.
#[derive(Clone, Debug, Default)]
pub(super) struct Course {
    /// Curvature at each step that has the whole bell about it, or at all where none has.
    curvatures: Vec<f64>,
    torsions: Vec<f64>,
    ends: [DVec3; 2],
}

impl Course {
    /// Of points in order, of a tube of a radius.
    pub(super) fn new(points: &[DVec3], radius: f64) -> Self {
        let mut lengths = vec![0.0];
        for pair in points.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + pair[0].distance(pair[1]));
        }
        let length = lengths[lengths.len() - 1];
        if !(length > 0.0 && length.is_finite()) {
            return Self::default();
        }
        // Half of the line at most is looked at at once.
        let width = (WIDTH * radius)
            .min(length / (2.0 * REACH))
            .max(length / STEPS_MOST);
        let count = (length / width * STEPS_PER_WIDTH)
            .ceil()
            .clamp(8.0, STEPS_MOST * STEPS_PER_WIDTH);
        let step = length / count;
        let steps = spread(points, &lengths, step, count);
        let reach = (REACH * width / step).floor();
        let mut course = Self::default();
        let mut place = 0.0;
        let window = |place: f64| {
            let from = (place - reach).max(0.0);
            let to = (place + reach).min(count);
            (from, to)
        };
        while place <= count {
            let (from, to) = window(place);
            let is_end = place == 0.0 || place == count;
            let is_whole = to - from >= 2.0 * reach - 0.5;
            if (is_whole || is_end)
                && let Some(derivatives) =
                    derivatives(&steps, place, (from, to), step / width, width)
            {
                let [first, second, third] = derivatives;
                if is_whole {
                    let across = first.cross(second);
                    let curvature = across.length() / first.length().powi(3);
                    course.curvatures.push(curvature);
                    if curvature * width > STRAIGHT {
                        course
                            .torsions
                            .push(across.dot(third) / across.length_squared());
                    }
                }
                if is_end {
                    course.ends[usize::from(place > 0.0)] = first.normalize_or_zero();
                }
            }
            place += 1.0;
        }
        course
    }

    pub(super) fn mean_curvature(&self) -> f64 {
        mean(&self.curvatures).unwrap_or(0.0)
    }

    pub(super) fn mean_torsion(&self) -> Option<f64> {
        // Where it is straight here and there, what is left says little.
        (2 * self.torsions.len() > self.curvatures.len())
            .then(|| mean(&self.torsions))
            .flatten()
    }

    pub(super) fn end_tangents(&self) -> [DVec3; 2] {
        self.ends
    }

    #[cfg(test)]
    pub(super) fn pointwise(&self) -> (&[f64], &[f64]) {
        (&self.curvatures, &self.torsions)
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Points at equal steps along a line.
fn spread(points: &[DVec3], lengths: &[f64], step: f64, count: f64) -> Vec<DVec3> {
    let mut steps = Vec::new();
    let (mut place, mut segment) = (0.0, 0);
    while place <= count {
        let at = place * step;
        while segment + 2 < lengths.len() && lengths[segment + 1] < at {
            segment += 1;
        }
        let length = lengths[segment + 1] - lengths[segment];
        let part = if length > 0.0 {
            ((at - lengths[segment]) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        steps.push(points[segment].lerp(points[segment + 1], part));
        place += 1.0;
    }
    steps
}

/// The first three derivatives by length at a step, from the steps of a window; `step` is in widths.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "numbers of steps within the line"
)]
fn derivatives(
    steps: &[DVec3],
    place: f64,
    (from, to): (f64, f64),
    step: f64,
    width: f64,
) -> Option<[DVec3; 3]> {
    let mut matrix = [[0.0; TERMS]; TERMS];
    let mut right = [DVec3::ZERO; TERMS];
    let middle = *steps.get(place as usize)?;
    let mut at = from;
    while at <= to {
        let s = (at - place) * step;
        let weight = (-s * s / 2.0).exp();
        let mut row = [1.0; TERMS];
        (1..TERMS).for_each(|i| row[i] = row[i - 1] * s);
        let point = *steps.get(at as usize)? - middle;
        for i in 0..TERMS {
            (0..=i).for_each(|j| matrix[i][j] += weight * row[i] * row[j]);
            right[i] += weight * row[i] * point;
        }
        at += 1.0;
    }
    let axis = |axis: usize| solve(matrix, right.map(|sum| sum[axis]));
    let [x, y, z] = [axis(0)?, axis(1)?, axis(2)?];
    let term = |i: usize, factor: f64| factor / width.powi(i as i32) * DVec3::new(x[i], y[i], z[i]);
    Some([term(1, 1.0), term(2, 2.0), term(3, 6.0)])
}
