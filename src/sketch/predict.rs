//! How many segments a sketch will have at a step, without deriving it.
//!
//! Trees of copies in copies grow exponentially, so the app must know beforehand whether a step can
//! be grown at once, on a worker, or not at all. The count follows from the growth rules alone: a
//! line of age a (rewrites since its first letter appeared) has a + 1 letters, and its branch of
//! rate n starts its k-th copy at age k·n + 1. So with S the count of a whole branch,
//!
//! S_X(a) = a + 1 + Σ over branches Y of X at rate n: T(a), T(a) = T(a − n) + S_Y(a − n − 1)
//!
//! where terms of negative age are 0. Branches are drawn after their parents, so going through
//! the strokes from the last to the first meets every S_Y before it is needed. That costs
//! strokes × depth limit × steps; a short horizon is tried first, since counts only grow and
//! saturate early in just those sketches that would be dear.

use super::{BOUNDS, Sketch};

/// The horizons tried in turn: each multiplies the age by this, from this on.
const HORIZON_FACTOR: u32 = 16;

/// The exact number of segments of `sketch` at growth step `step`, [`u64::MAX`] where it is that
/// large or larger. Steps beyond [`BOUNDS`] count as the last one.
#[must_use]
pub fn predict_segments(sketch: &Sketch, step: u32) -> u64 {
    let Some(age) = step.min(BOUNDS.step).checked_sub(1) else {
        return 0;
    };
    if sketch.is_empty() {
        return 0;
    }
    let mut horizon = HORIZON_FACTOR.min(age);
    loop {
        let count = count_at(sketch, horizon as usize);
        if horizon == age || count == u64::MAX {
            return count;
        }
        horizon = horizon.saturating_mul(HORIZON_FACTOR).min(age);
    }
}

/// The number of segments when the trunk has the given age.
fn count_at(sketch: &Sketch, age: usize) -> u64 {
    // For each stroke, the segments of the branches on it at each age; none: no branches.
    let mut on_stroke: Vec<Option<Vec<u64>>> = vec![None; sketch.strokes.len()];
    for (index, stroke) in sketch.strokes.iter().enumerate().rev() {
        let branches = on_stroke[index].take();
        let line: Vec<u64> = (0..=age)
            .map(|a| {
                let own = a as u64 + 1;
                branches
                    .as_ref()
                    .map_or(own, |counts| counts[a].saturating_add(own))
            })
            .collect();
        let whole = match stroke.self_similar {
            None => line,
            Some(own) => with_copies(&line, own.rate as usize, own.depth_limit),
        };
        let Some(at) = stroke.attachment else {
            return whole[age];
        };
        if let Some(parent) = sketch.index_of(at.letter) {
            let counts = on_stroke[parent].get_or_insert_with(|| vec![0; age + 1]);
            let mut copies = vec![0_u64; age + 1];
            add_copies(&mut copies, at.node as usize, &whole, |a, more| {
                counts[a] = counts[a].saturating_add(more);
            });
        }
    }
    0
}

/// Segments of a line with copies of itself, nested without end or to a depth limit.
fn with_copies(line: &[u64], rate: usize, depth_limit: Option<u32>) -> Vec<u64> {
    let mut copies = vec![0_u64; line.len()];
    let Some(limit) = depth_limit else {
        // The copies are younger than the line, so their counts are known when needed.
        let mut whole: Vec<u64> = Vec::with_capacity(line.len());
        for (a, own) in line.iter().enumerate() {
            copies[a] = copies_at(&copies, rate, &whole, a);
            whole.push(own.saturating_add(copies[a]));
        }
        return whole;
    };
    let mut whole = line.to_vec();
    for _ in 0..limit {
        let mut next = line.to_vec();
        add_copies(&mut copies, rate, &whole, |a, more| {
            next[a] = next[a].saturating_add(more)
        });
        whole = next;
    }
    whole
}

fn add_copies(copies: &mut [u64], rate: usize, whole: &[u64], mut add: impl FnMut(usize, u64)) {
    for a in 0..copies.len() {
        copies[a] = copies_at(copies, rate, whole, a);
        add(a, copies[a]);
    }
}

/// T(a) of the module's documentation.
fn copies_at(copies: &[u64], rate: usize, whole: &[u64], a: usize) -> u64 {
    let earlier = a.checked_sub(rate).map_or(0, |before| copies[before]);
    let newest = a
        .checked_sub(rate.saturating_add(1))
        .map_or(0, |age| whole[age]);
    earlier.saturating_add(newest)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::super::{NodeRef, SelfSimilar};
    use super::*;
    use crate::sketch::Letter;
    use glam::Vec3;

    fn one_branch(n: u32) -> Sketch {
        let mut sketch = Sketch::default();
        for y in 1..=n + 1 {
            let apex = sketch.apex(Letter::TRUNK).unwrap();
            sketch = sketch
                .add_segment(apex, Vec3::new(0.0, y as f32 * 0.1, 0.0))
                .unwrap()
                .0;
        }
        let from = NodeRef::new(Letter::TRUNK, n);
        sketch
            .add_segment(from, Vec3::new(0.1, 1.0, 0.0))
            .unwrap()
            .0
    }

    #[test]
    fn counts_of_the_thesis() {
        let counts = |n: u32, from: u32| -> Vec<u64> {
            (from..from + 7)
                .map(|w| predict_segments(&one_branch(n), w + 1))
                .collect()
        };
        assert_eq!(counts(1, 0), [1, 2, 4, 7, 12, 20, 33], "n = 1, from w0");
        assert_eq!(counts(2, 3), [5, 7, 10, 14, 19, 26, 35], "n = 2, from w3");
        assert_eq!(predict_segments(&one_branch(3), 11), 26, "n = 3 at w10");
        assert_eq!(predict_segments(&one_branch(3), 0), 0, "the root alone");
        assert_eq!(predict_segments(&Sketch::default(), 9), 0, "nothing drawn");
    }

    #[test]
    fn horizons_do_not_matter() {
        let sketch = one_branch(2)
            .with_self_similar(Letter::from_index(1), None)
            .unwrap();
        for step in [16, 17, 18, 255, 256, 257, 300, 10_000] {
            let exact = count_at(&sketch, step as usize - 1);
            assert_eq!(predict_segments(&sketch, step), exact, "step {step}");
        }
        // Without copies in copies: a line and a triangle of branches.
        let (a, n) = (9_999_u64, 2);
        let branches: u64 = (1..=(a - 1) / n).map(|k| a - k * n).sum();
        assert_eq!(
            predict_segments(&sketch, 10_000),
            a + 1 + branches,
            "closed form"
        );
    }

    #[test]
    fn the_dearest_sketch_is_counted_quickly() {
        let mut sketch = one_branch(1);
        while sketch.strokes.len() < BOUNDS.strokes {
            let from = NodeRef::new(Letter::TRUNK, 1);
            sketch = sketch
                .add_segment(from, Vec3::new(0.2, 1.0, 0.0))
                .unwrap()
                .0;
            if let Some(last) = sketch.strokes.last_mut() {
                let limit = SelfSimilar {
                    rate: 100,
                    depth_limit: Some(BOUNDS.depth),
                };
                std::sync::Arc::make_mut(last).self_similar = Some(limit);
            }
        }
        assert_eq!(
            predict_segments(&sketch, BOUNDS.step),
            u64::MAX,
            "saturates"
        );
        let begun = std::time::Instant::now();
        std::hint::black_box(predict_segments(&sketch, BOUNDS.step));
        assert!(begun.elapsed().as_secs() < 5, "took {:?}", begun.elapsed());
    }
}
