//! Where lines leave each other's tubes.
//!
//! Two lines have all in common up to a fork. From there on it is looked at each node in which of the other lines' tubes it is still,
//! once for all lines that go through the node; so nothing is looked at away from forks. VMTK compares every line with every point of
//! every other.

use super::lines::{HALVINGS, Lines, Place};
use super::ranges::Ranges;
use super::tube::{Siblings, Tubes};

/// A place where all lines that go through it leave the tubes of others.
#[derive(Clone, Debug)]
pub(super) struct Exit {
    /// Where.
    pub(super) at: Place,
    /// The fork at which those lines parted from this one.
    pub(super) fork: u32,
    /// The tips of those lines.
    pub(super) left: Ranges,
}

/// All of a tree.
#[derive(Debug, Default)]
pub(super) struct Exits {
    /// In the order of lines, those of a segment along it.
    pub(super) all: Vec<Exit>,
    /// For each tip, by number: the tips of lines that it never leaves.
    pub(super) never: Vec<Vec<Ranges>>,
}

/// Finds the exits. None where tubes overlap so much that it takes too long.
pub(super) fn exits(lines: &Lines<'_>, tubes: &mut Tubes<'_>) -> Option<Exits> {
    let mut exits = Exits::default();
    // The way to the node: each with the siblings in whose tubes it is.
    let mut way: Vec<(u32, Vec<Siblings>)> = Vec::new();
    for node in &lines.order {
        let Some(parent) = lines.parent(*node) else {
            way.clear();
            way.push((*node, Vec::new()));
            if lines.children.of(*node).is_empty() {
                exits.never.push(Vec::new());
            }
            continue;
        };
        while way.last().is_some_and(|(last, _)| *last != parent) {
            way.pop();
        }
        let children = lines.children.of(parent);
        let mut inside = match way.last_mut() {
            Some((_, inside)) if children.len() == 1 => std::mem::take(inside),
            Some((_, inside)) => inside.clone(),
            None => Vec::new(),
        };
        if children.len() > 1 {
            let tips = |node: u32| lines.tips[node as usize];
            inside.push(Siblings {
                fork: parent,
                own: *node,
                tips: Ranges::without(tips(parent), tips(*node)),
            });
        }
        let from = exits.all.len();
        for siblings in &mut inside {
            let point = lines.ball(*node).centre;
            let still = tubes.covering(point, siblings)?;
            let left = siblings.tips.minus(&still);
            if !left.is_empty() {
                let segment = Segment { lines, node: *node };
                segment.exits(tubes, siblings, left, &mut exits.all)?;
                siblings.tips = still;
            }
        }
        inside.retain(|siblings| !siblings.tips.is_empty());
        exits.all[from..].sort_by(|a, b| a.at.part.total_cmp(&b.at.part));
        if lines.children.of(*node).is_empty() {
            let never = inside.iter().map(|siblings| siblings.tips.clone());
            exits.never.push(never.collect());
        }
        way.push((*node, inside));
    }
    Some(exits)
}

/// The segment that ends in a node.
struct Segment<'a> {
    lines: &'a Lines<'a>,
    node: u32,
}

impl Segment<'_> {
    /// Finds where tubes are left, in which its start is and its end is not, by halving; those that are left on different sides of a middle go on by themselves.
    fn exits(
        &self,
        tubes: &mut Tubes<'_>,
        siblings: &Siblings,
        left: Ranges,
        to: &mut Vec<Exit>,
    ) -> Option<()> {
        let mut open = vec![(0.0, 1.0, HALVINGS, left)];
        while let Some((from, end, halvings, left)) = open.pop() {
            if halvings == 0 {
                to.push(Exit {
                    at: self.lines.on(self.node, end),
                    fork: siblings.fork,
                    left,
                });
                continue;
            }
            let middle = f64::midpoint(from, end);
            let point = self.lines.ball_at(self.lines.on(self.node, middle)).centre;
            let looked_for = Siblings {
                tips: left,
                ..*siblings
            };
            let later = tubes.covering(point, &looked_for)?;
            let earlier = looked_for.tips.minus(&later);
            for (from, end, left) in [(from, middle, earlier), (middle, end, later)] {
                if !left.is_empty() {
                    open.push((from, end, halvings - 1, left));
                }
            }
        }
        Some(())
    }
}
