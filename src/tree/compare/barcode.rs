//! How a tree branches, as a barcode: one bar for each tip, from where it leaves a farther one to its end.
//!
//! The topological morphology descriptor of Kanari et al. (2018), "A Topological Representation of Branching Neuronal Morphologies": from the tips
//! down, where branches meet the one with the farthest tip goes on, and every other is a bar from there to its own tip; what arrives at the root
//! is the last. How far a node is, is told by the way from the root or by the straight line. A barcode does not know which sibling came first,
//! where a tree stands or how it is turned; that of ways is the tree cut into pieces, so its bars are together as long as the tree.

use glam::DVec3;

use crate::tree::{NO_PARENT, Tree};

/// How far a node is from its root.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Height {
    /// Along the branches.
    Path,
    /// In a straight line.
    Radial,
}

/// A bar, in the tree's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bar {
    /// How far from the root it leaves a farther one; 0 of those that begin at the root.
    pub start: f64,
    /// How far its tip is. By straight lines this may be nearer than the start.
    pub end: f64,
}

impl Bar {
    /// From start to end.
    pub fn length(&self) -> f64 {
        (self.end - self.start).abs()
    }

    /// How far the ends of two are apart, together.
    pub fn apart(&self, other: &Self) -> f64 {
        (self.start - other.start).abs() + (self.end - other.end).abs()
    }
}

/// The bars of a tree in order, without those that have no length. Trees of several roots have the bars of all.
pub fn barcode(tree: &Tree, by: Height) -> Vec<Bar> {
    let heights = heights(tree, by);
    let mut bars = Vec::new();
    // Of what hangs at each node the farthest tip; none before there was one.
    let mut farthest: Vec<Option<f64>> = vec![None; tree.len()];
    for node in (0..tree.len()).rev() {
        let tip = farthest[node].unwrap_or(heights[node]);
        let parent = tree.parent[node];
        if parent == NO_PARENT {
            bars.push(Bar {
                start: 0.0,
                end: tip,
            });
            continue;
        }
        let at = parent as usize;
        farthest[at] = Some(match farthest[at] {
            None => tip,
            Some(other) => {
                bars.push(Bar {
                    start: heights[at],
                    end: tip.min(other),
                });
                tip.max(other)
            }
        });
    }
    bars.retain(|bar| bar.length() > 0.0);
    bars.sort_by(|a, b| a.start.total_cmp(&b.start).then(a.end.total_cmp(&b.end)));
    bars
}

/// How far each node is from its root.
fn heights(tree: &Tree, by: Height) -> Vec<f64> {
    let place = |node: usize| tree.position[node].as_dvec3();
    let mut heights = vec![0.0; tree.len()];
    let mut roots: Vec<DVec3> = Vec::with_capacity(tree.len());
    for node in 0..tree.len() {
        let parent = tree.parent[node];
        if parent == NO_PARENT {
            roots.push(place(node));
            continue;
        }
        let at = parent as usize;
        roots.push(roots[at]);
        heights[node] = match by {
            Height::Path => heights[at] + place(node).distance(place(at)),
            Height::Radial => place(node).distance(roots[node]),
        };
    }
    heights
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        clippy::cast_possible_truncation,
        reason = "the table says it, and its trees are small"
    )]
    use super::super::tests::{grown, mirrored, spec};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_fork_of_three_has_a_bar_for_each_tip() {
        // A stem of 2, then tips 1, 3 and 2 farther on.
        let tree = grown(&[
            (0, [0.0, 2.0, 0.0]),
            (1, [1.0, 0.0, 0.0]),
            (1, [0.0, 3.0, 0.0]),
            (1, [0.0, 0.0, 2.0]),
        ]);
        let bar = |start, end| Bar { start, end };
        assert_eq!(
            barcode(&tree, Height::Path),
            [bar(0.0, 5.0), bar(2.0, 3.0), bar(2.0, 4.0)]
        );
        let radial = barcode(&tree, Height::Radial);
        assert_eq!(radial[0], bar(0.0, 5.0));
        assert!((radial[1].end - 5.0_f64.sqrt()).abs() < 1e-12);
        assert!((radial[2].end - 8.0_f64.sqrt()).abs() < 1e-12);
        assert!(barcode(&Tree::default(), Height::Path).is_empty());
        assert!(barcode(&grown(&[]), Height::Path).is_empty());
    }

    /// The definition, word for word: of the tips below each fork all but the farthest end there.
    fn by_definition(tree: &Tree, heights: &[f64]) -> Vec<Bar> {
        let mut bars = Vec::new();
        for node in 0..tree.len() {
            let children = (0..tree.len()).filter(|child| tree.parent[*child] == node as u32);
            let farthest = |of: usize| {
                let is_tip = |tip: &usize| !tree.parent.contains(&(*tip as u32));
                let hangs = |tip: &usize| {
                    let mut at = *tip as u32;
                    while at != NO_PARENT && at != of as u32 {
                        at = tree.parent[at as usize];
                    }
                    at == of as u32
                };
                let tips = (0..tree.len()).filter(is_tip).filter(hangs);
                tips.map(|tip| heights[tip])
                    .fold(f64::NEG_INFINITY, f64::max)
            };
            let mut all: Vec<f64> = children.map(farthest).collect();
            all.sort_by(f64::total_cmp);
            all.pop();
            bars.extend(all.into_iter().map(|end| Bar {
                start: heights[node],
                end,
            }));
            if tree.parent[node] == NO_PARENT {
                bars.push(Bar {
                    start: 0.0,
                    end: farthest(node),
                });
            }
        }
        bars.retain(|bar| bar.length() > 0.0);
        bars.sort_by(|a, b| a.start.total_cmp(&b.start).then(a.end.total_cmp(&b.end)));
        bars
    }

    proptest! {
        #[test]
        fn bars_are_those_of_the_definition_and_as_long_as_the_tree(tree in spec(30)) {
            for by in [Height::Path, Height::Radial] {
                let found = barcode(&tree, by);
                prop_assert_eq!(&found, &by_definition(&tree, &heights(&tree, by)));
                // In another order of siblings, and mirrored.
                prop_assert_eq!(&found, &barcode(&mirrored(&tree), by));
            }
            let length: f64 = barcode(&tree, Height::Path).iter().map(Bar::length).sum();
            prop_assert!((length - tree.total_length()).abs() <= 1e-9 * (1.0 + length));
        }
    }
}
