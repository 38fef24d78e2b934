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
//! the strokes from the last to the first meets every S_Y before it is needed.
//!
//! This is asked on the frame loop, so it stops as soon as a bound is passed. Each table reaches only as far
//! as the oldest line of its stroke and nesting is old, and each such line has a segment for every
//! entry: so there are never more entries than segments, and too many are refused before any is
//! computed. A short horizon is tried first, since counts only grow and pass the bound early in just those
//! sketches that would be dear. A [`Predictor`] keeps the last answers, for they do not depend on where the nodes are.

use super::{BOUNDS, Letter, NodeRef, SelfSimilar, Sketch};

/// The horizons tried in turn: each multiplies the age by this, from this on.
const HORIZON_FACTOR: u32 = 16;

/// The exact number of segments of `sketch` at growth step `step` where it is no more than `most`; the effort is
/// bounded by `most`, too. Steps beyond [`BOUNDS`] count as the last one. With rules of a person's own nothing is known
/// beforehand: `most`, and growing itself keeps to its limits.
#[must_use]
pub fn predict_segments_within(sketch: &Sketch, step: u32, most: u64) -> Option<u64> {
    let Some(age) = step.min(BOUNDS.step).checked_sub(1) else {
        return Some(0);
    };
    if sketch.is_empty() {
        return Some(0);
    }
    if !sketch.own_rules.is_empty() || sketch.habit.is_uncertain() {
        return Some(most);
    }
    let branches = branches(sketch);
    let mut horizon = HORIZON_FACTOR.min(age);
    loop {
        let count = count_at(&branches, horizon, most)?;
        if horizon == age {
            return Some(count);
        }
        horizon = horizon.saturating_mul(HORIZON_FACTOR).min(age);
    }
}

/// What a count depends on, of one stroke.
type Rules = (Letter, Option<NodeRef>, Option<SelfSimilar>);

/// Answers of a [`Predictor`] that are kept: a person steps back and forth between a few.
const KEPT: usize = 4;

/// Predicts for one sketch after the other and keeps the last answers. While a node is moved or a step is shown
/// the answer is there without counting anew.
#[derive(Clone, Debug, Default)]
pub struct Predictor {
    /// Of the sketch that the answers are about; none: it has no segments.
    rules: Vec<Rules>,
    /// Step, bound and answer, the oldest first.
    answers: Vec<(u32, u64, Option<u64>)>,
}

impl Predictor {
    /// What [`predict_segments_within`] gives.
    pub fn within(&mut self, sketch: &Sketch, step: u32, most: u64) -> Option<u64> {
        if sketch.is_empty() {
            return Some(0);
        }
        if !sketch.own_rules.is_empty() || sketch.habit.is_uncertain() {
            return predict_segments_within(sketch, step, most);
        }
        let rules = sketch
            .strokes
            .iter()
            .map(|stroke| (stroke.letter, stroke.attachment, stroke.self_similar));
        if !rules.clone().eq(self.rules.iter().copied()) {
            self.rules.clear();
            self.rules.extend(rules);
            self.answers.clear();
        }
        let known = self
            .answers
            .iter()
            .find(|(of, bound, _)| (*of, *bound) == (step, most));
        if let Some((_, _, answer)) = known {
            return *answer;
        }
        let answer = predict_segments_within(sketch, step, most);
        if self.answers.len() >= KEPT {
            self.answers.remove(0);
        }
        self.answers.push((step, most, answer));
        answer
    }
}

/// A stroke among the others.
struct Branch {
    /// Index of the stroke it hangs on, and its rate there; none: the trunk.
    on: Option<(usize, u32)>,
    own: Option<SelfSimilar>,
    /// Age of the trunk when the first line of this stroke appears.
    first: u32,
}

fn branches(sketch: &Sketch) -> Vec<Branch> {
    let letters: Vec<Letter> = sketch.strokes.iter().map(|stroke| stroke.letter).collect();
    let mut all: Vec<Branch> = Vec::with_capacity(letters.len());
    for stroke in &sketch.strokes {
        let parent = stroke.attachment.and_then(|at| {
            // Of an earlier stroke, as every sketch keeps it.
            let index = letters[..all.len()].iter().position(|l| *l == at.letter)?;
            Some((index, at.node))
        });
        let first = match (parent, stroke.attachment) {
            (Some((index, node)), _) => all[index].first.saturating_add(node).saturating_add(1),
            (None, None) => 0,
            (None, Some(_)) => u32::MAX, // it hangs nowhere, so it never grows
        };
        all.push(Branch {
            on: parent,
            own: stroke.self_similar,
            first,
        });
    }
    all
}

/// Nestings of a line in itself that the oldest line of age `age` can have.
fn nestings(own: SelfSimilar, age: usize) -> usize {
    let possible = age / (own.rate as usize + 1);
    own.depth_limit
        .map_or(possible, |limit| possible.min(limit as usize))
}

/// Segments of the oldest line of each stroke and each nesting: so many at least there are.
fn least(branches: &[Branch], age: u32) -> u64 {
    let mut sum = 0_u64;
    for branch in branches {
        let Some(age) = age.checked_sub(branch.first) else {
            continue;
        };
        let (levels, apart) = branch.own.map_or((0, 0), |own| {
            (nestings(own, age as usize) as u64, u64::from(own.rate) + 1)
        });
        // At most 10,000 levels of at most 10,000 each.
        sum += (levels + 1) * (u64::from(age) + 1) - apart * (levels * (levels + 1) / 2);
    }
    sum
}

/// The number of segments when the trunk has the given age, if it is no more than `most`.
fn count_at(branches: &[Branch], age: u32, most: u64) -> Option<u64> {
    if least(branches, age) > most {
        return None;
    }
    // For each stroke, the segments of the branches on it at each age; none: no branches.
    let mut on_stroke: Vec<Option<Vec<u64>>> = vec![None; branches.len()];
    let mut copies = Vec::new();
    for (index, branch) in branches.iter().enumerate().rev() {
        let Some(age) = age.checked_sub(branch.first) else {
            continue;
        };
        let age = age as usize;
        let mut line = on_stroke[index].take().unwrap_or_else(|| vec![0; age + 1]);
        for (own, count) in (1..).zip(&mut line) {
            *count = count.saturating_add(own);
        }
        let whole = match branch.own {
            None => line,
            Some(own) => with_copies(&line, own, &mut copies),
        };
        let Some((parent, rate)) = branch.on else {
            let count = whole[age];
            return (count <= most).then_some(count);
        };
        // The oldest line of this stroke is one of those on the oldest line of its parent.
        let counts = on_stroke[parent].get_or_insert_with(|| vec![0; age + rate as usize + 2]);
        if whole[age] > most {
            return None;
        }
        add_copies(&mut copies, rate as usize, &whole, counts);
    }
    Some(0)
}

/// Segments of a line with copies of itself, nested without end or to a depth limit.
fn with_copies(line: &[u64], own: SelfSimilar, copies: &mut Vec<u64>) -> Vec<u64> {
    let rate = own.rate as usize;
    if own.depth_limit.is_none() {
        // The copies are younger than the line, so their counts are known when needed.
        copies.clear();
        let mut whole: Vec<u64> = Vec::with_capacity(line.len());
        for (a, own) in line.iter().enumerate() {
            let more = copies_at(copies, rate, &whole, a);
            copies.push(more);
            whole.push(own.saturating_add(more));
        }
        return whole;
    }
    // The innermost copies are as much younger as they are deep.
    let levels = nestings(own, line.len().saturating_sub(1));
    let ages = |level: usize| line.len() - level * (rate + 1);
    let mut whole = line[..ages(levels)].to_vec();
    for level in (0..levels).rev() {
        let mut next = line[..ages(level)].to_vec();
        add_copies(copies, rate, &whole, &mut next);
        whole = next;
    }
    whole
}

/// Adds to the counts of a line at each age those of its branches of one kind, of which the oldest one is `rate` + 1
/// younger than the line. `copies` is room to work in.
fn add_copies(copies: &mut Vec<u64>, rate: usize, whole: &[u64], counts: &mut [u64]) {
    copies.clear();
    let grown = counts.iter_mut().skip(rate + 1).zip(whole);
    for (a, (count, newest)) in grown.enumerate() {
        let earlier = a.checked_sub(rate).and_then(|before| copies.get(before));
        let more = earlier.copied().unwrap_or(0).saturating_add(*newest);
        copies.push(more);
        *count = count.saturating_add(more);
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
    use super::*;
    use crate::sketch::Stroke;
    use glam::Vec3;

    /// However many there are.
    fn predicted(sketch: &Sketch, step: u32) -> u64 {
        predict_segments_within(sketch, step, u64::MAX - 1).unwrap()
    }

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
                .map(|w| predicted(&one_branch(n), w + 1))
                .collect()
        };
        assert_eq!(counts(1, 0), [1, 2, 4, 7, 12, 20, 33], "n = 1, from w0");
        assert_eq!(counts(2, 3), [5, 7, 10, 14, 19, 26, 35], "n = 2, from w3");
        assert_eq!(predicted(&one_branch(3), 11), 26, "n = 3 at w10");
        assert_eq!(predicted(&one_branch(3), 0), 0, "the root alone");
        assert_eq!(predicted(&Sketch::default(), 9), 0, "nothing drawn");
    }

    #[test]
    fn horizons_do_not_matter() {
        let sketch = one_branch(2)
            .with_self_similar(Letter::from_index(1), None)
            .unwrap();
        for step in [16, 17, 18, 255, 256, 257, 300, 10_000] {
            let exact = count_at(&branches(&sketch), step - 1, u64::MAX - 1);
            assert_eq!(Some(predicted(&sketch, step)), exact, "step {step}");
        }
        // Without copies in copies: a line and a triangle of branches.
        let (a, n) = (9_999_u64, 2);
        let branches: u64 = (1..=(a - 1) / n).map(|k| a - k * n).sum();
        assert_eq!(predicted(&sketch, 10_000), a + 1 + branches, "closed form");
    }

    /// The recurrence as it is written, each count on its own.
    fn slow(sketch: &Sketch, stroke: usize, nested: u32, age: i64) -> u64 {
        if age < 0 {
            return 0;
        }
        let it = &sketch.strokes[stroke];
        let mut count = age as u64 + 1;
        let mut add = |branch: usize, rate: u32, nested: u32| {
            let rate = i64::from(rate);
            let mut young = age - rate - 1;
            while young >= 0 {
                count += slow(sketch, branch, nested, young);
                young -= rate;
            }
        };
        if let Some(own) = it.self_similar
            && own.depth_limit.is_none_or(|limit| nested < limit)
        {
            add(stroke, own.rate, nested + 1);
        }
        for (index, other) in sketch.strokes.iter().enumerate() {
            if let Some(at) = other.attachment.filter(|at| at.letter == it.letter) {
                add(index, at.node, 0);
            }
        }
        count
    }

    /// A trunk of seven nodes, branches on it and on a branch.
    fn nested(rates: [u32; 3], limits: [Option<u32>; 3]) -> Sketch {
        let mut sketch = one_branch(6);
        let (trunk, c) = (Letter::TRUNK, Letter::from_index(1));
        let c_at = NodeRef::new(c, 1);
        let from = sketch.position(c_at).unwrap();
        for (at, to) in [
            (NodeRef::new(trunk, 2), Vec3::new(0.2, 0.5, 0.0)),
            (c_at, from + Vec3::new(0.1, 0.0, 0.0)),
            (c_at, from + Vec3::new(0.1, 0.1, 0.0)),
        ] {
            sketch = sketch.add_segment(at, to).unwrap().0;
        }
        for (stroke, (rate, depth_limit)) in sketch
            .strokes
            .iter_mut()
            .skip(1)
            .zip(rates.into_iter().zip(limits))
        {
            std::sync::Arc::make_mut(stroke).self_similar = Some(SelfSimilar { rate, depth_limit });
        }
        sketch
    }

    #[test]
    fn the_count_is_the_recurrence() {
        for (rates, limits) in [
            ([1, 2, 3], [None, None, None]),
            ([1, 1, 1], [Some(0), Some(1), Some(2)]),
            ([2, 1, 3], [Some(64), None, Some(1)]),
            ([5, 7, 1], [Some(3), Some(2), Some(64)]),
        ] {
            let sketch = nested(rates, limits);
            for step in 1..22 {
                let expected = slow(&sketch, 0, 0, i64::from(step) - 1);
                assert_eq!(
                    predicted(&sketch, step),
                    expected,
                    "{rates:?} {limits:?} at {step}"
                );
                for most in [expected - 1, expected, expected + 1] {
                    assert_eq!(
                        predict_segments_within(&sketch, step, most),
                        (expected <= most).then_some(expected),
                        "{rates:?} {limits:?} at {step}, at most {most}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_predictor_says_the_same_whatever_it_was_asked_before() {
        let mut predictor = Predictor::default();
        let sketches = [
            one_branch(2),
            Sketch::default(),
            nested([1, 2, 3], [None, Some(1), None]),
            nested([1, 2, 3], [None, Some(2), None]),
            one_branch(3),
        ];
        for round in 0..200_u32 {
            let sketch = &sketches[(round / 7 * round % 5) as usize];
            let (step, most) = (round * 5 % 23, u64::from(round % 3) * 40 + 9);
            assert_eq!(
                predictor.within(sketch, step, most),
                predict_segments_within(sketch, step, most),
                "round {round}"
            );
        }
    }

    /// 511 branches from nodes far up a long trunk: as many entries as the bound lets through.
    fn wide(node: u32, own: Option<SelfSimilar>) -> Sketch {
        let mut sketch = one_branch(1);
        let branch = std::sync::Arc::clone(&sketch.strokes[1]);
        for index in 1..BOUNDS.strokes {
            let stroke = Stroke {
                letter: Letter::from_index(u16::try_from(index).unwrap()),
                attachment: Some(NodeRef::new(Letter::TRUNK, node)),
                self_similar: own,
                ..(*branch).clone()
            };
            sketch.strokes.truncate(index);
            sketch.strokes.push(std::sync::Arc::new(stroke));
        }
        sketch
    }

    #[test]
    fn the_dearest_sketches_are_counted_quickly() {
        let own = |rate| {
            Some(SelfSimilar {
                rate,
                depth_limit: Some(BOUNDS.depth),
            })
        };
        for (what, sketch, most) in [
            ("deep", wide(1, own(100)), None),
            ("refused at once", wide(9_000, own(1)), None),
            ("just let through", wide(6_150, None), Some(2_000_000)),
            (
                "the same with copies",
                wide(7_100, own(2_200)),
                Some(2_000_000),
            ),
        ] {
            let mut predictor = Predictor::default();
            let begun = std::time::Instant::now();
            let found = predictor.within(&sketch, BOUNDS.step, 2_000_000);
            let first = begun.elapsed();
            let begun = std::time::Instant::now();
            for _ in 0..100 {
                assert_eq!(predictor.within(&sketch, BOUNDS.step, 2_000_000), found);
            }
            let again = begun.elapsed() / 100;
            eprintln!("{what}: {found:?} in {first:?}, then {again:?}");
            assert_eq!(found.is_some(), most.is_some(), "{what}: {found:?}");
            // Generous: an unoptimized build on a busy machine. It took seconds before there was a bound.
            assert!(first.as_millis() < 500, "{what} took {first:?}");
        }
    }
}
