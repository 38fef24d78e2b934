//! The test by Wilcoxon (1945): whether one of two values that belong together tends to be larger than the other.

use super::Method;

/// With more pairs than this the normal distribution is near enough; as SciPy has it.
const EXACT_MOST: usize = 50;

/// What the signed ranks of pairs tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wilcoxon {
    /// Pairs that differ: equal ones say nothing of a direction and are left out.
    pub n: usize,
    /// Ranks of the pairs whose second value is larger, summed.
    pub plus: f64,
    /// Ranks of those whose first is.
    pub minus: f64,
    /// The smaller sum, in standard deviations from the middle, without a correction for continuity: never above zero, as SPSS and papers print it.
    pub z: f64,
    /// How likely a smaller sum as small as this is where neither side tends to be larger.
    pub p: f64,
    /// How p was had: by counting up to 50 pairs, of equal differences too, else by the normal distribution.
    pub method: Method,
    /// p by the normal distribution in any case: that of `z`.
    pub p_limit: f64,
}

impl Wilcoxon {
    /// The matched-pairs rank-biserial correlation (Kerby 2014): 1 where all second values are larger, −1 where all are smaller.
    pub fn effect(&self) -> f64 {
        (self.plus - self.minus) / (self.plus + self.minus)
    }
}

/// Compares pairs. None where none of them differs or one has something that is no number.
///
/// Equal differences share the middle of their ranks; differences are equal where they are to the last bit, so scores should be compared by
/// the whole numbers that they were made of.
pub fn wilcoxon(pairs: &[[f64; 2]]) -> Option<Wilcoxon> {
    if !pairs.iter().flatten().all(|value| value.is_finite()) {
        return None;
    }
    let mut differences: Vec<f64> = pairs.iter().map(|[a, b]| b - a).collect();
    differences.retain(|difference| *difference != 0.0 && difference.is_finite());
    differences.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let n = differences.len();
    if n == 0 {
        return None;
    }
    // Twice the ranks are whole numbers, which those in the middle of two are not.
    let (mut doubled, mut plus, mut ties) = (Vec::with_capacity(n), 0_usize, 0.0);
    for equal in differences.chunk_by(|a, b| a.abs() == b.abs()) {
        let rank = 2 * doubled.len() + equal.len() + 1;
        let larger = equal.iter().filter(|difference| **difference > 0.0).count();
        doubled.extend(std::iter::repeat_n(rank, equal.len()));
        plus += rank * larger;
        let count = equal.len() as f64;
        ties += count.powi(3) - count;
    }
    let least = plus.min(n * (n + 1) - plus);
    let z = standard(least, n, ties);
    let p_limit = libm::erfc(-z / std::f64::consts::SQRT_2).min(1.0);
    let (p, method) = match n <= EXACT_MOST {
        true => ((2.0 * tail(&doubled, least)).min(1.0), Method::Exact),
        false => (p_limit, Method::Limit),
    };
    let plus = plus as f64 / 2.0;
    Some(Wilcoxon {
        n,
        plus,
        minus: (n * (n + 1)) as f64 / 2.0 - plus,
        z,
        p,
        method,
        p_limit,
    })
}

/// Half of a doubled sum of ranks, in standard deviations from its middle.
fn standard(least: usize, n: usize, ties: f64) -> f64 {
    let count = n as f64;
    let middle = count * (count + 1.0) / 4.0;
    let variance = count * (count + 1.0) * (2.0 * count + 1.0) / 24.0 - ties / 48.0;
    (least as f64 / 2.0 - middle) / variance.sqrt()
}

/// How likely it is that the ranks of one side sum up to no more than `most`, where each rank falls to either side. At most 2⁵⁰ ways, which are whole numbers.
fn tail(ranks: &[usize], most: usize) -> f64 {
    let mut ways = vec![0.0_f64; most + 1];
    ways[0] = 1.0;
    for rank in ranks {
        for sum in (*rank..=most).rev() {
            ways[sum] += ways[sum - rank];
        }
    }
    let all: f64 = ways.iter().sum();
    ranks.iter().fold(all, |part, _| part / 2.0)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use proptest::prelude::*;

    use super::*;

    fn of(differences: &[f64]) -> Option<Wilcoxon> {
        let pairs: Vec<[f64; 2]> = differences.iter().map(|one| [3.0, 3.0 + one]).collect();
        wilcoxon(&pairs)
    }

    /// By every choice of signs: how many give a smaller sum as small as that of these differences.
    fn counted(differences: &[f64]) -> f64 {
        let differ: Vec<f64> = differences
            .iter()
            .copied()
            .filter(|one| *one != 0.0)
            .collect();
        let rank = |one: f64| {
            let below = differ
                .iter()
                .filter(|other| other.abs() < one.abs())
                .count();
            let equal = differ
                .iter()
                .filter(|other| other.abs() == one.abs())
                .count();
            below as f64 + f64::midpoint(equal as f64, 1.0)
        };
        let ranks: Vec<f64> = differ.iter().map(|one| rank(*one)).collect();
        let all: f64 = ranks.iter().sum();
        let least = |is_plus: &dyn Fn(usize) -> bool| {
            let plus: f64 = (0..ranks.len())
                .filter(|at| is_plus(*at))
                .map(|at| ranks[at])
                .sum();
            plus.min(all - plus)
        };
        let found = least(&|at| differ[at] > 0.0);
        let ways = 1_u32 << ranks.len();
        let as_small = (0..ways).filter(|signs| least(&|at| signs >> at & 1 == 1) <= found);
        as_small.count() as f64 / f64::from(ways)
    }

    #[test]
    fn sums_and_z_are_those_worked_out_by_hand() {
        // differences, n, plus, minus, z by the formula with the correction for ties
        type Row<'a> = (&'a [f64], usize, f64, f64, f64);
        let rows: [Row<'_>; 4] = [
            (
                &[67.5, -5.0, 20.0, 12.5, 47.5, 5.0, 17.5],
                7,
                26.5,
                1.5,
                -2.116_668_787,
            ),
            (&[1.0, 2.0, 3.0, 0.0, 4.0], 4, 10.0, 0.0, -1.825_741_858),
            (&[1.0, -1.0], 2, 1.5, 1.5, 0.0),
            (&[-2.0, -2.0, -2.0, 0.0], 3, 0.0, 6.0, -1.732_050_808),
        ];
        for (differences, n, plus, minus, z) in rows {
            let found = of(differences).unwrap();
            assert_eq!((found.n, found.plus, found.minus), (n, plus, minus));
            assert!((found.z - z).abs() < 1e-8, "{found:?}");
            assert!((found.p - counted(differences)).abs() < 1e-12, "{found:?}");
        }
        let first = of(rows[0].0).unwrap();
        assert_eq!((first.p, first.method), (6.0 / 128.0, Method::Exact));
        assert!((first.p_limit - 0.034_288).abs() < 1e-6, "{first:?}");
        assert!((first.effect() - 25.0 / 28.0).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_compared_is_not() {
        for none in [&[][..], &[0.0, 0.0], &[f64::NAN], &[1.0, f64::INFINITY]] {
            assert_eq!(of(none), None);
        }
    }

    /// From 51 pairs on by the normal distribution, which is near the count at 50 already.
    #[test]
    fn many_pairs_are_compared_by_the_normal_distribution() {
        let some = |count: u32| -> Vec<f64> {
            let value = |at: u32| f64::from(at + 1) * if at.is_multiple_of(3) { -1.0 } else { 1.0 };
            (0..count).map(value).collect()
        };
        let [fifty, more] = [50, 51].map(|count| of(&some(count)).unwrap());
        assert_eq!((fifty.method, more.method), (Method::Exact, Method::Limit));
        assert_eq!(more.p, more.p_limit);
        assert!((fifty.p - fifty.p_limit).abs() < 0.01, "{fifty:?}");
    }

    proptest! {
        #[test]
        fn p_is_what_counting_all_signs_gives(values in prop::collection::vec(-4_i8..=4, 0..10)) {
            let values: Vec<f64> = values.into_iter().map(f64::from).collect();
            match of(&values) {
                None => prop_assert!(values.iter().all(|one| *one == 0.0)),
                Some(found) => {
                    prop_assert!((found.p - counted(&values)).abs() < 1e-12, "{:?}", found);
                    let turned: Vec<f64> = values.iter().map(|one| -one).collect();
                    let turned = of(&turned).unwrap();
                    prop_assert_eq!((turned.plus, turned.p, turned.z), (found.minus, found.p, found.z));
                }
            }
        }
    }
}
