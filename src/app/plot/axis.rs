//! Numbers as heights, and where an axis has its marks.

/// The axis is logarithmic where all numbers are above zero and the largest is more than so many times the smallest.
const LOGARITHMIC_FROM: f64 = 50.0;
/// Marks at most.
const MARKS_MOST: f64 = 6.0;

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axis {
    /// Its ends, as they are shown: logarithms where it is logarithmic.
    ends: [f64; 2],
    /// Whether it shows logarithms.
    pub(crate) logarithmic: bool,
}

impl Axis {
    /// Around numbers; None where there are none, or where they are too far apart for any picture.
    pub(crate) fn around(
        numbers: impl Iterator<Item = f64> + Clone,
        may_be_logarithmic: bool,
    ) -> Option<Self> {
        let low = numbers.clone().fold(f64::INFINITY, f64::min);
        let high = numbers.fold(f64::NEG_INFINITY, f64::max);
        let logarithmic = may_be_logarithmic && low > 0.0 && high / low > LOGARITHMIC_FROM;
        let [low, high] = match logarithmic {
            true => [low.log10(), high.log10()],
            false => [low, high],
        };
        let span = high - low;
        if !span.is_finite() {
            return None;
        }
        // What is all the same stands in the middle.
        let margin = match span > 0.0 {
            true => 0.08 * span,
            false if low == 0.0 => 1.0,
            false => 0.1 * low.abs(),
        };
        let ends = [low - margin, high + margin];
        // Numbers so near to each other that no step leads from one to the other.
        let fits = (ends[1] - ends[0]).is_finite() && ends[1] - ends[0] > 1e-12 * ends[1].abs();
        fits.then_some(Self { ends, logarithmic })
    }

    /// A number as it is shown.
    pub(crate) fn shown(&self, number: f64) -> f64 {
        if self.logarithmic {
            number.log10()
        } else {
            number
        }
    }

    /// Where a shown number is: 0 at the lower end, 1 at the upper.
    pub(crate) fn part(&self, shown: f64) -> f64 {
        (shown - self.ends[0]) / (self.ends[1] - self.ends[0])
    }

    /// Marks: where they are, and what stands there.
    pub(crate) fn marks(&self) -> Vec<(f64, String)> {
        let [low, high] = self.ends;
        let step = step(high - low);
        if self.logarithmic && high - low >= 1.0 {
            let whole = step.max(1.0).round();
            let marks = multiples(low, high, whole);
            return marks.map(|mark| (self.part(mark), power(mark))).collect();
        }
        if self.logarithmic {
            let [from, to] = [10_f64.powf(low), 10_f64.powf(high)];
            let step = self::step(to - from);
            let marks = multiples(from, to, step).filter(|mark| *mark > 0.0);
            return marks
                .map(|mark| (self.part(mark.log10()), written(mark, step)))
                .collect();
        }
        let marks = multiples(low, high, step);
        marks
            .map(|mark| (self.part(mark), written(mark, step)))
            .collect()
    }
}

/// 1, 2 or 5 times a power of ten, of which a span has at most so many.
fn step(span: f64) -> f64 {
    let rough = span / MARKS_MOST;
    let power = 10_f64.powf(rough.log10().floor());
    let factors = [1.0, 2.0, 5.0].into_iter();
    let mut steps = factors.map(|factor| factor * power);
    steps.find(|step| *step >= rough).unwrap_or(10.0 * power)
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "at most a handful of steps"
)]
fn multiples(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let first = (low / step).ceil();
    let count = ((high / step).floor() - first).clamp(-1.0, 2.0 * MARKS_MOST) as i32;
    (0..=count).map(move |place| (first + f64::from(place)) * step)
}

/// A mark with the decimals that its step has; very large and very small ones with their power of ten.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a handful of decimals"
)]
fn written(mark: f64, step: f64) -> String {
    // Rounding leaves next to nothing where zero is meant.
    if mark.abs() < step / 2.0 {
        return "0".to_owned();
    }
    let of_step = step.log10().floor();
    let size = mark.abs().log10().floor();
    let text = match !(-3.0..6.0).contains(&size) {
        true => format!("{mark:.*e}", (size - of_step).clamp(0.0, 6.0) as usize),
        false => format!("{mark:.*}", (-of_step).clamp(0.0, 9.0) as usize),
    };
    match text.strip_prefix('-') {
        Some(size) => format!("−{size}"),
        None => text,
    }
}

fn power(exponent: f64) -> String {
    match (-3.0..=4.0).contains(&exponent) {
        true => format!("{}", 10_f64.powf(exponent)),
        false => format!("1e{exponent:.0}"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "the table says it"
    )]
    use super::*;

    #[test]
    fn marks_are_round_numbers_within_the_axis() {
        for (numbers, logarithmic, expected) in [
            (vec![0.0, 10.0], false, "0 2 4 6 8 10"),
            (vec![3.0], false, "2.7 2.8 2.9 3.0 3.1 3.2"),
            (vec![0.0], false, "−1.0 −0.5 0 0.5 1.0"),
            (vec![-0.021, 0.03], false, "−0.02 −0.01 0 0.01 0.02 0.03"),
            (
                vec![2.79, 2.79004],
                false,
                "2.79000 2.79001 2.79002 2.79003 2.79004",
            ),
            (
                vec![3e7, 3.1e7],
                false,
                "3.00e7 3.02e7 3.04e7 3.06e7 3.08e7 3.10e7",
            ),
            (vec![1.0, 20_000.0], true, "1 10 100 1000 10000"),
            (vec![1.0, 40.0], true, "0 10 20 30 40"),
            (vec![-1.0, 4000.0], true, "0 1000 2000 3000 4000"),
            (vec![1e-9, 5e-9], false, "1e-9 2e-9 3e-9 4e-9 5e-9"),
        ] {
            let axis = Axis::around(numbers.iter().copied(), logarithmic).unwrap();
            let marks = axis.marks();
            let told: Vec<&str> = marks.iter().map(|(_, told)| told.as_str()).collect();
            assert_eq!(told.join(" "), expected, "{numbers:?}");
            assert!(
                marks.iter().all(|(part, _)| (0.0..=1.0).contains(part)),
                "{marks:?}"
            );
        }
    }

    #[test]
    fn what_no_axis_holds_has_none() {
        for numbers in [
            vec![],
            vec![f64::MIN, f64::MAX],
            vec![1e300, -1e308, 1.7e308],
        ] {
            assert_eq!(
                Axis::around(numbers.iter().copied(), true),
                None,
                "{numbers:?}"
            );
        }
    }
}
