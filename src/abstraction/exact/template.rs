//! What a production replaces a module by: a small tree of segments, and of buds, which are that module again.

use super::frames::wrapped;
use super::level::{Level, Stance, children, short, turn};
use super::out::{Out, times};
use crate::tree::NO_PARENT;
use crate::tree::axes::Children;

/// Segments of a template at most.
pub(super) const SEGMENTS_MOST: usize = 64;

/// A small tree by its places, each after the one that it grows from; at the first is its first segment.
pub(super) struct Template {
    pub(super) parent: Vec<u32>,
    /// To the place that it grows from; that of the first place says nothing.
    pub(super) stance: Vec<Stance>,
    pub(super) children: Children,
    /// Whether a bud stands there.
    pub(super) is_bud: Vec<bool>,
    /// The place behind which the tree that it is in goes on, if it does.
    pub(super) end: Option<usize>,
}

impl Template {
    /// The part that begins with a node's segment, but that `is_bud` says where no segment is; none where it is too large.
    pub(super) fn of(level: &Level, first: u32, is_bud: impl Fn(u32) -> bool) -> Option<Self> {
        let mut nodes = vec![(first, false)];
        let (mut parent, mut stance) = (vec![NO_PARENT], vec![Stance::default()]);
        let (mut at, mut segments) = (0, 1);
        while let Some((node, bud)) = nodes.get(at).copied() {
            let grows: &[u32] = if bud { &[] } else { level.children.of(node) };
            for child in grows {
                let bud = is_bud(*child);
                segments += usize::from(!bud);
                nodes.push((*child, bud));
                parent.push(u32::try_from(at).ok()?);
                stance.push(level.stance(*child, node));
            }
            if segments > SEGMENTS_MOST || nodes.len() > 2 * SEGMENTS_MOST {
                return None;
            }
            at += 1;
        }
        Some(Self {
            children: children(&parent),
            parent,
            stance,
            is_bud: nodes.into_iter().map(|(_, bud)| bud).collect(),
            end: None,
        })
    }

    pub(super) fn len(&self) -> usize {
        self.parent.len()
    }

    pub(super) fn children(&self, place: usize) -> &[u32] {
        self.children.of(u32::try_from(place).unwrap_or(NO_PARENT))
    }

    /// Its places in the order in which they are drawn, and whether brackets open before each and how many close behind it: what leads to the end is in none.
    pub(super) fn drawn(&self) -> Vec<(usize, bool, usize)> {
        let mut leads = vec![false; self.len()];
        let mut at = self.end;
        while let Some(place) = at.filter(|place| *place < self.len()) {
            leads[place] = true;
            at = Some(self.parent[place] as usize);
        }
        let mut drawn: Vec<(usize, bool, usize)> = Vec::with_capacity(self.len());
        // A segment, whether it is bracketed, and how many brackets close with what is drawn last of it.
        let mut open = vec![(0, false, 0)];
        while let Some((place, bracketed, closes)) = open.pop() {
            let closes = closes + usize::from(bracketed);
            let children = self.children(place).iter();
            let mut children: Vec<usize> = children.map(|child| *child as usize).collect();
            children.sort_by_key(|child| leads[*child]);
            let goes_on = (Some(place) != self.end)
                .then(|| children.last().copied())
                .flatten();
            // At the end all is bracketed, and what closes there closes behind the last of it.
            let own = if children.is_empty() { closes } else { 0 };
            drawn.push((place, bracketed, own));
            let last = children.len().saturating_sub(1);
            for (number, child) in children.into_iter().enumerate().rev() {
                let bracketed = Some(child) != goes_on;
                open.push((child, bracketed, if number == last { closes } else { 0 }));
            }
        }
        drawn
    }

    /// Writes it as what a production makes: segments and buds as multiples of the first segment's length, with numbers no more exact than what is alike.
    pub(super) fn write(&self, out: &mut Out, bud: &str, apart: f64) {
        let mut longer = vec![1.0; self.len()];
        for (place, opens, closes) in self.drawn() {
            let mut degrees = [0.0; 2];
            if place > 0 {
                let (turned, multiple) = short(self.stance[place], apart);
                longer[place] = longer[self.parent[place] as usize] * multiple;
                degrees = turned;
            }
            if opens {
                out.module("[", &[]);
            }
            turn(out, degrees);
            let name = if self.is_bud[place] { bud } else { "F" };
            out.module(name, &[times("l", longer[place])]);
            for _ in 0..closes {
                out.module("]", &[]);
            }
        }
    }

    /// Its stances as they are in the mean of copies, each of whose places are nodes of a level.
    pub(super) fn fitted(&mut self, level: &Level, copies: &[u32]) {
        let count = (copies.len() / self.len()).max(1) as f64;
        for place in 1..self.len() {
            let before = self.parent[place] as usize;
            let first = self.stance[place];
            let mut off = Stance::default();
            for copy in copies.chunks_exact(self.len()) {
                let one = level.stance(copy[place], copy[before]);
                off.yaw += wrapped(one.yaw - first.yaw);
                off.pitch += one.pitch - first.pitch;
                off.longer += one.longer - first.longer;
            }
            self.stance[place] = Stance {
                yaw: wrapped(first.yaw + off.yaw / count),
                pitch: first.pitch + off.pitch / count,
                longer: first.longer + off.longer / count,
            };
        }
    }
}
