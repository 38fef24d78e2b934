//! The tests of groups beside SciPy's, and beside counting by hand.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that fails shows the line"
)]

use super::*;

fn close(found: f64, expected: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= 1e-11 * expected.abs(),
        "{found} instead of {expected}"
    );
}

fn series(count: u32, value: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..count).map(|i| value(f64::from(i))).collect()
}

/// Numbers by SciPy 1.17.1, `a` and `b` being the groups:
///
/// ```python
/// u, k = stats.mannwhitneyu(a, b), stats.ks_2samp(a, b)
/// n, m, a, b = len(a), len(b), np.array(a), np.array(b)
/// s = np.sqrt(((n-1)*a.var(ddof=1) + (m-1)*b.var(ddof=1)) / (n+m-2))
/// print(u.statistic, u.pvalue, k.statistic, k.pvalue, (a.mean()-b.mean())/s * (1-3/(4*(n+m)-9)))
/// ```
#[test]
#[allow(clippy::type_complexity, reason = "a table")]
fn the_tests_are_scipys() {
    let table: [(Vec<f64>, Vec<f64>, Method, [f64; 5]); 8] = [
        (
            vec![1.2, 3.4, 2.2, 5.1],
            vec![2.8, 6.3, 7.1, 5.5, 9.0],
            Method::Exact,
            [
                2.0,
                0.06349206349206349,
                0.8,
                0.07936507936507936,
                -1.3788885463035312,
            ],
        ),
        (
            vec![19.0, 22.0, 16.0, 29.0, 24.0],
            vec![20.0, 11.0, 17.0, 12.0],
            Method::Exact,
            [
                17.0,
                0.1111111111111111,
                0.6,
                0.2857142857142857,
                1.3352812282117033,
            ],
        ),
        (
            vec![1.0, 2.0, 2.0, 3.0, 4.0],
            vec![2.0, 4.0, 4.0, 5.0, 6.0, 7.0],
            Method::Limit,
            [
                4.0,
                0.050835668685518316,
                0.6333333333333333,
                0.17748917748917747,
                -1.372022135001668,
            ],
        ),
        (
            series(12, |i| 0.1 * i * i),
            series(15, |i| 0.15 * i * i + 3.0),
            Method::Limit,
            [
                33.0,
                0.005834903437075228,
                0.5,
                0.050718482546454,
                -1.1131587965390914,
            ],
        ),
        (
            vec![1.0, 2.0],
            vec![3.0, 4.0],
            Method::Exact,
            [
                0.0,
                0.3333333333333333,
                1.0,
                0.3333333333333333,
                -1.6162440712835369,
            ],
        ),
        (
            series(8, |i| 5.0 + 0.5 * i),
            series(100, |i| 0.37 * i),
            Method::Exact,
            [
                149.0,
                0.0021222667830603863,
                0.77,
                5.3326918365411737e-05,
                -1.1064156790183977,
            ],
        ),
        (
            series(40, |i| i % 7.0),
            series(30, |i| i % 9.0),
            Method::Limit,
            [
                498.0,
                0.22463330558716998,
                0.2,
                0.4508544239231963,
                -0.35425491775643364,
            ],
        ),
        (
            series(20, |i| 1e-9 * i),
            series(25, |i| 1.0 + i),
            Method::Limit,
            [
                0.0,
                1.205252299499121e-08,
                1.0,
                6.309405358074171e-13,
                -2.3228388171869816,
            ],
        ),
    ];
    for (a, b, method, [u, p, d, p_of_d, g]) in table {
        let ranks = mann_whitney(&a, &b).unwrap();
        assert_eq!((ranks.u, ranks.method), (u, method));
        close(ranks.p, p);
        let apart = kolmogorov_smirnov(&a, &b).unwrap();
        close(apart.d, d);
        close(apart.p, p_of_d);
        close(hedges_g(&a, &b).unwrap(), g);
        // The other way round it is the same difference.
        let back = mann_whitney(&b, &a).unwrap();
        let [delta, turned] = [
            cliffs_delta(u, a.len(), b.len()),
            cliffs_delta(back.u, b.len(), a.len()),
        ];
        assert!((delta + turned).abs() < 1e-12);
        close(back.p, p);
        close(hedges_g(&b, &a).unwrap(), -g);
    }
}

/// All ways that `n` of so many places can be the first group's.
fn every_choice(n: u32, all: u32) -> impl Iterator<Item = Vec<bool>> {
    (0_u32..1 << all)
        .filter(move |bits| bits.count_ones() == n)
        .map(move |bits| (0..all).map(|place| bits >> place & 1 == 1).collect())
}

#[test]
fn small_groups_are_counted() {
    for (n, m) in [(1, 1), (1, 6), (3, 4), (5, 5), (6, 3)] {
        let groups = |first: &[bool]| {
            let of = |wanted: bool| -> Vec<f64> {
                let places = (0_u32..).zip(first).filter(|(_, one)| **one == wanted);
                places.map(|(place, _)| f64::from(place)).collect()
            };
            (of(true), of(false))
        };
        let both = |first: &[bool]| {
            let (a, b) = groups(first);
            (
                mann_whitney(&a, &b).unwrap(),
                kolmogorov_smirnov(&a, &b).unwrap(),
            )
        };
        let middle = f64::from(n * m) / 2.0;
        for first in every_choice(n, n + m).step_by(5) {
            let (ranks, apart) = both(&first);
            let (mut as_far, mut as_apart, mut ways) = (0.0, 0.0, 0.0);
            for choice in every_choice(n, n + m) {
                let (other, other_apart) = both(&choice);
                ways += 1.0;
                as_far += f64::from((other.u - middle).abs() >= (ranks.u - middle).abs());
                as_apart += f64::from(other_apart.d >= apart.d - 1e-9);
            }
            close(ranks.p, as_far / ways);
            close(apart.p, as_apart / ways);
        }
    }
}

#[test]
fn what_cannot_be_compared_is_not() {
    let some = [1.0, 2.0];
    for (a, b) in [
        (&[][..], &some[..]),
        (&some, &[]),
        (&[f64::NAN], &some),
        (&some, &[1.0, f64::INFINITY]),
    ] {
        assert_eq!(mann_whitney(a, b), None);
        assert_eq!(kolmogorov_smirnov(a, b), None);
        assert_eq!(hedges_g(a, b), None);
    }
    let same = [3.0; 4];
    assert_eq!(
        mann_whitney(&same, &same).map(|one| (one.u, one.p)),
        Some((8.0, 1.0))
    );
    assert_eq!(
        kolmogorov_smirnov(&same, &same).map(|one| (one.d, one.p)),
        Some((0.0, 1.0))
    );
    assert_eq!(hedges_g(&same, &same), None);
    assert_eq!(hedges_g(&[1.0], &some), None, "one value has no spread");
    // Zero has two spellings.
    let zeros = mann_whitney(&[0.0, -0.0, 1.0], &[-0.0, 0.0, 1.0]).unwrap();
    assert_eq!((zeros.u, zeros.method), (4.5, Method::Limit));
}

#[test]
fn large_groups_take_no_time() {
    let (a, b) = (
        series(8, |i| i * 1000.0 + 0.53),
        series(100_000, |i| i * 0.1),
    );
    let ranks = mann_whitney(&a, &b).unwrap();
    assert!(ranks.method == Method::Exact && ranks.p > 0.0 && ranks.p < 1.0);
    let apart = kolmogorov_smirnov(&a, &b).unwrap();
    assert!(apart.method == Method::Limit && apart.p > 0.0 && apart.p < 1.0);
}

/// `scipy.stats.false_discovery_control(p)`, and Holm's by hand: the n-th smallest times 7 + 1 − n, never below the one before.
#[test]
fn corrections_are_scipys() {
    let p = [0.01, 0.04, 0.03, 0.005, 0.5, 0.03, 0.9];
    let by_holm = [0.06, 0.15, 0.15, 0.035, 1.0, 0.15, 1.0];
    let by_rate = [0.035, 0.056, 0.0525, 0.035, 0.5833333333333334, 0.0525, 0.9];
    for (found, expected) in holm(&p).into_iter().zip(by_holm) {
        close(found, expected);
    }
    for (found, expected) in benjamini_hochberg(&p).into_iter().zip(by_rate) {
        close(found, expected);
    }
    assert_eq!(holm(&[]), benjamini_hochberg(&[]));
    assert_eq!(holm(&[0.2]), [0.2]);
}

#[test]
fn deltas_have_names() {
    for (delta, size) in [
        (0.0, "negligible"),
        (-0.2, "small"),
        (0.4, "medium"),
        (-0.474, "large"),
        (1.0, "large"),
    ] {
        assert_eq!(DeltaSize::of(delta).name(), size, "{delta}");
    }
}
