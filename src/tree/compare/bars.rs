//! How far two barcodes are apart.
//!
//! **Matched** (the 1-Wasserstein distance with the ends' distances added up): the least length by which ends of bars must be moved so that one
//! barcode becomes the other, where a bar may also be made from nothing or taken away for its own length. Two bars spare what they overlap, twice,
//! so it is the length of all less twice the best overlap; what both have the same goes together and is left out before the assignment. It is worked
//! out exactly for up to a thousand bars that differ.
//!
//! **Sliced** (Carrière, Cuturi and Oudot 2017, "Sliced Wasserstein Kernel for Persistence Diagrams"): the same along lines in many directions, where
//! the best matching is the order, so that millions of bars take a second. It is scaled so that against nothing it is the length of all, as the
//! matched one is, and is no more than 2 √2 times that (with as many directions as are taken, within a hundredth).
//!
//! Both are metrics between barcodes: 0 of the same, symmetric, and no way round is shorter.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::assignment::assignment;
use super::barcode::Bar;

/// Steps that an exact matching may take: of a thousand bars to a thousand.
const STEPS_MOST: u64 = 1_000_000_000;
/// Directions of lines.
const DIRECTIONS: u8 = 16;

/// The length of all bars.
pub fn length(bars: &[Bar]) -> f64 {
    bars.iter().map(Bar::length).sum()
}

/// All bars, so many times as large.
pub fn scaled(bars: &[Bar], by: f64) -> Vec<Bar> {
    let bar = |bar: &Bar| Bar {
        start: bar.start * by,
        end: bar.end * by,
    };
    bars.iter().map(bar).collect()
}

/// The matched distance of two sorted barcodes. None where too many bars differ for it.
pub fn matched(a: &[Bar], b: &[Bar]) -> Option<f64> {
    let (mut few, mut many) = without_common(a, b);
    if few.len() > many.len() {
        std::mem::swap(&mut few, &mut many);
    }
    let steps = (few.len() as u64)
        .saturating_mul(few.len() as u64)
        .saturating_mul(many.len() as u64);
    if steps > STEPS_MOST {
        return None;
    }
    // What a pair costs more than its being taken away and made: never above zero, since it may be left alone.
    let saved = |row: usize, column: usize| {
        let (one, other) = (&few[row], &many[column]);
        (one.apart(other) - one.length() - other.length()).min(0.0)
    };
    let pairs = assignment(few.len(), many.len(), saved);
    let mut is_paired = vec![false; many.len()];
    let mut sum = 0.0;
    for (one, column) in few.iter().zip(pairs) {
        let other = &many[column];
        is_paired[column] = true;
        sum += one.apart(other).min(one.length() + other.length());
    }
    let left = many.iter().zip(is_paired).filter(|(_, paired)| !paired);
    Some(sum + left.map(|(bar, _)| bar.length()).sum::<f64>())
}

/// What each has that the other has not. For a metric whose costs are distances nothing is lost by putting together what is the same.
fn without_common(a: &[Bar], b: &[Bar]) -> (Vec<Bar>, Vec<Bar>) {
    let (mut of_a, mut of_b) = (Vec::new(), Vec::new());
    let (mut x, mut y) = (0, 0);
    while let (Some(one), Some(other)) = (a.get(x), b.get(y)) {
        let by_start = one.start.total_cmp(&other.start);
        match by_start.then(one.end.total_cmp(&other.end)) {
            std::cmp::Ordering::Less => {
                of_a.push(*one);
                x += 1;
            }
            std::cmp::Ordering::Greater => {
                of_b.push(*other);
                y += 1;
            }
            std::cmp::Ordering::Equal => (x, y) = (x + 1, y + 1),
        }
    }
    of_a.extend_from_slice(&a[x..]);
    of_b.extend_from_slice(&b[y..]);
    (of_a, of_b)
}

/// The sliced distances of all pairs of barcodes (first and second, first and third, … second and third, …): as they are, and each made as many times
/// as large as is said.
pub fn sliced(barcodes: &[&[Bar]], scales: &[f64]) -> Vec<[f64; 2]> {
    let pairs: Vec<(usize, usize)> = (0..barcodes.len())
        .flat_map(|a| (a + 1..barcodes.len()).map(move |b| (a, b)))
        .collect();
    // Collected in order, so that sums are the same for any number of threads.
    let by_direction: Vec<Vec<[f64; 2]>> = (0..DIRECTIONS)
        .into_par_iter()
        .map(|number| {
            let direction = direction(number);
            let lines: Vec<Vec<(f64, f64)>> =
                barcodes.iter().map(|bars| line(bars, direction)).collect();
            let apart = |(a, b): &(usize, usize)| {
                [[1.0, 1.0], [scales[*a], scales[*b]]]
                    .map(|scales| apart(&lines[*a], &lines[*b], scales))
            };
            pairs.iter().map(apart).collect()
        })
        .collect();
    // What a bar of length 1 is against nothing, over all directions.
    let unit: f64 = (0..DIRECTIONS)
        .map(|number| {
            let [cos, sin] = direction(number);
            (sin - cos).abs() / 2.0
        })
        .sum();
    (0..pairs.len())
        .map(|pair| {
            let sum = |which: usize| by_direction.iter().map(|all| all[pair][which]).sum::<f64>();
            [sum(0) / unit, sum(1) / unit]
        })
        .collect()
}

/// Cosine and sine of a direction.
fn direction(number: u8) -> [f64; 2] {
    let angle = (f64::from(number) + 0.5) * PI / f64::from(DIRECTIONS);
    [angle.cos(), angle.sin()]
}

/// Where a barcode's bars are on a line, each counted once for and, where it would be if it had no length, once against.
fn line(bars: &[Bar], [cos, sin]: [f64; 2]) -> Vec<(f64, f64)> {
    let mut line: Vec<(f64, f64)> = Vec::with_capacity(2 * bars.len());
    for bar in bars {
        line.push((bar.start * cos + bar.end * sin, 1.0));
        line.push((f64::midpoint(bar.start, bar.end) * (cos + sin), -1.0));
    }
    // Between what is at one place there is no area, whatever its order.
    line.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    line
}

/// The area between the counts of two lines, each stretched.
fn apart(a: &[(f64, f64)], b: &[(f64, f64)], scales: [f64; 2]) -> f64 {
    let (mut x, mut y) = (0, 0);
    let (mut area, mut count, mut last) = (0.0, 0.0_f64, 0.0);
    loop {
        let next = [(a.get(x), scales[0]), (b.get(y), scales[1])]
            .map(|(one, scale)| one.map(|(at, sign)| (at * scale, *sign)));
        let (at, sign) = match next {
            [None, None] => return area,
            [Some(one), Some(other)] if other.0 < one.0 => {
                y += 1;
                (other.0, -other.1)
            }
            [Some(one), _] => {
                x += 1;
                one
            }
            [None, Some(other)] => {
                y += 1;
                (other.0, -other.1)
            }
        };
        area += count.abs() * (at - last);
        count += sign;
        last = at;
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
    use proptest::prelude::*;

    fn bars(most: usize) -> impl Strategy<Value = Vec<Bar>> {
        let bar = (0_u8..6, 0_u8..6).prop_map(|(start, end)| Bar {
            start: f64::from(start),
            end: f64::from(end) + 0.25,
        });
        prop::collection::vec(bar, 0..most).prop_map(|mut bars| {
            bars.sort_by(|a, b| a.start.total_cmp(&b.start).then(a.end.total_cmp(&b.end)));
            bars
        })
    }

    /// The least over all ways to put some of one's bars with some of the other's.
    fn of_all(a: &[Bar], b: &mut Vec<Bar>) -> f64 {
        let Some((first, rest)) = a.split_first() else {
            return length(b);
        };
        let mut least = first.length() + of_all(rest, b);
        for place in 0..b.len() {
            let other = b.remove(place);
            least = least.min(first.apart(&other) + of_all(rest, b));
            b.insert(place, other);
        }
        least
    }

    fn slice(a: &[Bar], b: &[Bar]) -> f64 {
        sliced(&[a, b], &[1.0, 1.0])[0][0]
    }

    proptest! {
        #[test]
        fn the_matched_distance_is_the_least_of_all(a in bars(6), b in bars(6)) {
            let found = matched(&a, &b).unwrap();
            prop_assert!((found - of_all(&a, &mut b.clone())).abs() < 1e-9);
            prop_assert!(slice(&a, &b) <= 1.01 * 8.0_f64.sqrt() * found + 1e-9);
        }

        #[test]
        fn both_are_metrics(a in bars(9), b in bars(9), c in bars(9)) {
            let exact = |a: &[Bar], b: &[Bar]| matched(a, b).unwrap();
            for distance in [&exact as &dyn Fn(&[Bar], &[Bar]) -> f64, &slice] {
                let [ab, ba, bc, ac] = [distance(&a, &b), distance(&b, &a), distance(&b, &c), distance(&a, &c)];
                prop_assert!((ab - ba).abs() < 1e-9);
                prop_assert!(ac <= ab + bc + 1e-9, "{ac} {ab} {bc}");
                prop_assert!(distance(&a, &a) == 0.0);
                prop_assert_eq!(ab < 1e-9, a == b);
                prop_assert!(ab <= length(&a) + length(&b) + 1e-9);
            }
        }
    }

    #[test]
    fn against_nothing_both_are_the_length_of_all_and_scales_are_taken() {
        let bar = |start, end| Bar { start, end };
        let some = [bar(0.0, 5.0), bar(1.0, 2.0), bar(1.5, 4.0)];
        assert_eq!(matched(&some, &[]), Some(8.5));
        assert!((slice(&some, &[]) - 8.5).abs() < 1e-9);
        let twice = scaled(&some, 2.0);
        let [plain, scaled] = sliced(&[&some, &twice], &[2.0, 1.0])[0];
        assert!(plain > 1.0 && scaled.abs() < 1e-9, "{plain} {scaled}");
        assert_eq!(matched(&twice, &twice), Some(0.0));
    }

    #[test]
    fn too_many_bars_are_sliced_alone_and_many_that_are_the_same_are_matched() {
        let many = |step: f64| -> Vec<Bar> {
            (0..3000_u32)
                .map(|place| Bar {
                    start: f64::from(place) * step,
                    end: f64::from(place) * step + 10.0,
                })
                .collect()
        };
        let (a, b) = (many(1.0), many(1.01));
        assert_eq!(matched(&a, &a), Some(0.0));
        assert_eq!(matched(&a, &b), None);
        assert!(slice(&a, &b) > 1.0);
    }
}
