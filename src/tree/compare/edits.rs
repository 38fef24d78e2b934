//! How many branches must be taken away or added so that two trees fork alike: the constrained edit distance of unordered trees (Zhang 1996, "A
//! Constrained Edit Distance Between Unordered Labeled Trees").
//!
//! The edit distance of unordered trees without a constraint is NP-hard. Zhang's keeps separate subtrees separate, takes time by the product of both
//! numbers of branches, and is a metric. A branch costs 1 to take away or to add; nothing else counts, so it tells how trees fork and nothing of
//! lengths.

use super::assignment::assignment;
use crate::tree::measure::Branch;

/// Pairs of branches, and steps of all assignments, at most: about a second.
const PAIRS_MOST: u64 = 4_000_000;
const STEPS_MOST: u64 = 400_000_000;

/// Branches and what grows from each; the last is what all roots grow from.
struct Shape {
    children: Vec<Vec<usize>>,
    /// Branches of what hangs at each, without itself.
    below: Vec<u32>,
}

impl Shape {
    fn new(branches: &[Branch]) -> Self {
        let all = branches.len();
        let mut children = vec![Vec::new(); all + 1];
        let mut below = vec![0_u32; all + 1];
        // Each branch stands behind its parent.
        for (place, branch) in branches.iter().enumerate().rev() {
            let parent = branch.parent.unwrap_or(all);
            children[parent].push(place);
            below[parent] = below[parent].saturating_add(below[place].saturating_add(1));
        }
        Self { children, below }
    }

    /// Children first, what all grow from last.
    fn upwards(&self) -> impl Iterator<Item = usize> {
        let all = self.children.len() - 1;
        (0..all).rev().chain([all])
    }

    /// Steps of assignments with one who has so many children.
    fn steps(&self, with: usize) -> u64 {
        let of = |children: &Vec<usize>| {
            let [few, many] = [children.len().min(with), children.len().max(with)];
            (few as u64)
                .saturating_mul(few as u64)
                .saturating_mul(many as u64)
        };
        self.children.iter().map(of).fold(0, u64::saturating_add)
    }
}

/// How many branches must be taken away or added. None where that would take too long.
pub fn edits(a: &[Branch], b: &[Branch]) -> Option<u32> {
    if a.is_empty() || b.is_empty() {
        return u32::try_from(a.len().max(b.len())).ok();
    }
    if (a.len() as u64 + 1).saturating_mul(b.len() as u64 + 1) > PAIRS_MOST {
        return None;
    }
    let (a, b) = (Shape::new(a), Shape::new(b));
    let steps = a.children.iter().map(|children| b.steps(children.len()));
    if steps.fold(0, u64::saturating_add) > STEPS_MOST {
        return None;
    }
    let width = b.children.len();
    // Of each pair: between what hangs at them, and between them with what hangs at them.
    let mut forests = vec![0_u32; a.children.len() * width];
    let mut trees = forests.clone();
    for one in a.upwards() {
        for other in b.upwards() {
            let forest = forest(&a, &b, [one, other], &forests, &trees);
            forests[one * width + other] = forest;
            let [of_one, of_other] = [a.below[one], b.below[other]];
            let into =
                |child: &usize| trees[one * width + child] as i64 - i64::from(b.below[*child] + 1);
            let from = |child: &usize| {
                trees[child * width + other] as i64 - i64::from(a.below[*child] + 1)
            };
            let all_of = |size: u32| i64::from(size + 1);
            let deeper = [
                b.children[other]
                    .iter()
                    .map(into)
                    .min()
                    .map(|gain| all_of(of_other) + gain),
                a.children[one]
                    .iter()
                    .map(from)
                    .min()
                    .map(|gain| all_of(of_one) + gain),
            ];
            let least = deeper
                .into_iter()
                .flatten()
                .fold(i64::from(forest), i64::min);
            trees[one * width + other] = u32::try_from(least).unwrap_or(0);
        }
    }
    forests.last().copied()
}

/// Between what hangs at a branch and at another.
fn forest(a: &Shape, b: &Shape, [one, other]: [usize; 2], forests: &[u32], trees: &[u32]) -> u32 {
    let width = b.children.len();
    let [of_one, of_other] = [i64::from(a.below[one]), i64::from(b.below[other])];
    let (few, many) = (&a.children[one], &b.children[other]);
    if few.is_empty() || many.is_empty() {
        return a.below[one].max(b.below[other]);
    }
    let into = |child: &usize| i64::from(forests[one * width + child]) - i64::from(b.below[*child]);
    let from =
        |child: &usize| i64::from(forests[child * width + other]) - i64::from(a.below[*child]);
    let deeper = [
        many.iter().map(into).min().map(|gain| of_other + gain),
        few.iter().map(from).min().map(|gain| of_one + gain),
    ];
    // What a pair of children costs more than taking one away and adding the other; never above zero.
    let saved = |x: usize, y: usize| {
        let sizes = i64::from(a.below[x] + 1) + i64::from(b.below[y] + 1);
        (i64::from(trees[x * width + y]) - sizes).min(0)
    };
    let matched = of_one + of_other + most_saved(few, many, &saved);
    let least = deeper.into_iter().flatten().fold(matched, i64::min);
    u32::try_from(least).unwrap_or(0)
}

/// The sum of a best matching, at or below zero.
fn most_saved(few: &[usize], many: &[usize], saved: &dyn Fn(usize, usize) -> i64) -> i64 {
    match (few, many) {
        ([one], many) => many
            .iter()
            .map(|other| saved(*one, *other))
            .min()
            .unwrap_or(0),
        (few, [other]) => few.iter().map(|one| saved(*one, *other)).min().unwrap_or(0),
        ([a, b], [c, d]) => (saved(*a, *c) + saved(*b, *d)).min(saved(*a, *d) + saved(*b, *c)),
        _ => {
            let swap = few.len() > many.len();
            let (rows, columns) = if swap { (many, few) } else { (few, many) };
            let cost = |row: usize, column: usize| match swap {
                true => saved(columns[column], rows[row]),
                false => saved(rows[row], columns[column]),
            };
            let pairs = assignment(rows.len(), columns.len(), |row, column| {
                cost(row, column) as f64
            });
            pairs
                .into_iter()
                .enumerate()
                .map(|(row, column)| cost(row, column))
                .sum()
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "the table says it"
    )]
    use super::super::tests::{mirrored, spec};
    use super::*;
    use crate::tree::measure::Measures;
    use proptest::prelude::*;

    /// Branches from their parents' places.
    fn branches(parents: &[Option<usize>]) -> Vec<Branch> {
        let branch = |parent: &Option<usize>| Branch {
            parent: *parent,
            ..Branch::default()
        };
        parents.iter().map(branch).collect()
    }

    #[test]
    fn branches_that_are_more_are_counted() {
        let y = [None, Some(0), Some(0)];
        let third = [None, Some(0), Some(0), Some(0)];
        let deeper = [None, Some(0), Some(0), Some(1), Some(1)];
        let both = [None, Some(0), Some(0), Some(1), Some(1), Some(2), Some(2)];
        // Four in a row on one side, against two and two.
        let comb = [None, Some(0), Some(0), Some(1), Some(1), Some(3), Some(3)];
        for (a, b, expected) in [
            (&[][..], &[][..], 0),
            (&y[..], &[], 3),
            (&y, &y, 0),
            (&y, &third, 1),
            (&y, &deeper, 2),
            (&deeper, &both, 2),
            (&deeper, &third, 3),
            (&both, &comb, 4),
        ] {
            assert_eq!(
                edits(&branches(a), &branches(b)),
                Some(expected),
                "{a:?} {b:?}"
            );
            assert_eq!(edits(&branches(b), &branches(a)), Some(expected));
        }
    }

    #[test]
    fn what_would_take_too_long_is_not_begun() {
        let star: Vec<Option<usize>> = (0..1500_usize)
            .map(|place| place.checked_sub(1).map(|_| 0))
            .collect();
        assert_eq!(edits(&branches(&star), &branches(&star)), None);
        let comb: Vec<Option<usize>> = (0..2001_usize)
            .map(|place| place.checked_sub(1).map(|place| place / 2 * 2))
            .collect();
        assert_eq!(edits(&branches(&comb), &branches(&comb)), None);
        let comb = &comb[..1501];
        assert_eq!(edits(&branches(comb), &branches(&comb[..1401])), Some(100));
    }

    /// What all trees that fork alike have, and no others (Aho, Hopcroft and Ullman 1974).
    fn form(branches: &[Branch], of: Option<usize>) -> String {
        let children = (0..branches.len()).filter(|place| branches[*place].parent == of);
        let mut forms: Vec<String> = children.map(|child| form(branches, Some(child))).collect();
        forms.sort();
        format!("({})", forms.concat())
    }

    proptest! {
        #[test]
        fn it_is_a_metric_of_how_trees_fork(a in spec(14), b in spec(14), c in spec(14)) {
            let [one, other, third] = [&a, &b, &c].map(|tree| Measures::whole(tree).branches);
            let far = |a: &[Branch], b: &[Branch]| edits(a, b).unwrap();
            let [ab, bc, ac] = [far(&one, &other), far(&other, &third), far(&one, &third)];
            prop_assert_eq!(ab, far(&other, &one));
            prop_assert!(ac <= ab + bc);
            prop_assert_eq!(ab == 0, form(&one, None) == form(&other, None));
            prop_assert!(ab as usize >= one.len().abs_diff(other.len()));
            prop_assert!(ab as usize <= one.len() + other.len());
            let swapped = Measures::whole(&mirrored(&a)).branches;
            prop_assert_eq!(far(&swapped, &other), ab);
        }
    }
}
