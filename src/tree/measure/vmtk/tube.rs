//! The tube of a line: all balls of its points and between them. What matters here is which lines' tubes a point is in.
//!
//! Segments stand in the order of the [lines](super::lines), in boxes of eight, those again in boxes of eight, and so on: what is near in
//! that order is near in space, and what is below a node is a stretch of it.

use glam::DVec3;

use super::lines::{Ball, Lines};
use super::ranges::Ranges;

/// Segments, or boxes, in a box.
const IN_BOX: usize = 8;

/// Lines that part at a fork from the own one, which is in the tubes of some of them still.
#[derive(Clone, Debug)]
pub(super) struct Siblings {
    /// Where they part.
    pub(super) fork: u32,
    /// The fork's child on the own line.
    pub(super) own: u32,
    /// The tips of those in whose tubes the line was all the way since.
    pub(super) tips: Ranges,
}

/// All segments of a tree.
pub(super) struct Tubes<'a> {
    lines: &'a Lines<'a>,
    /// Smallest and largest corners; the first are boxes of segments.
    levels: Vec<Vec<[DVec3; 2]>>,
    /// Segments that may still be looked at.
    left: u64,
}

impl<'a> Tubes<'a> {
    /// `most`: how many segments are looked at, until all answers are None.
    pub(super) fn new(lines: &'a Lines<'a>, most: u64) -> Self {
        let of_ball = |ball: Ball| [ball.centre - ball.radius, ball.centre + ball.radius];
        let of_segment = |node: &u32| {
            let own = of_ball(lines.ball(*node));
            let parent = lines.parent(*node).map(|parent| lines.ball(parent));
            parent.map_or(own, |parent| around([own, of_ball(parent)]))
        };
        let boxes = lines.order.chunks(IN_BOX);
        let mut levels: Vec<Vec<[DVec3; 2]>> = vec![
            boxes
                .map(|nodes| around(nodes.iter().map(of_segment)))
                .collect(),
        ];
        while let Some(last) = levels.last().filter(|last| last.len() > 1) {
            let boxes = last.chunks(IN_BOX).map(|some| around(some.iter().copied()));
            levels.push(boxes.collect());
        }
        Self {
            lines,
            levels,
            left: most,
        }
    }

    /// Those of siblings in whose tubes a point is. None where too much was looked at.
    pub(super) fn covering(&mut self, point: DVec3, siblings: &Siblings) -> Option<Ranges> {
        let lines = self.lines;
        let Siblings { fork, own, tips } = siblings;
        let [of_fork, of_own] = [*fork, *own].map(|node| lines.place[node as usize]);
        let [end_of_own, end] = [*own, *fork].map(|node| lines.end[node as usize]);
        let mut found = Ranges::default();
        let mut beside = |node: u32| {
            found.add(tips.common(lines.tips[node as usize]));
            found != *tips
        };
        // First what is likely: the siblings' own ways from the fork on; then what all have in common.
        let is_partly = self.each(point, (of_fork + 1, of_own), &mut beside)?
            && self.each(point, (end_of_own, end), &mut beside)?
            && self.each(point, (0, of_fork + 1), &mut |node| {
                !lines.is_above(node, *fork)
            })?;
        Some(if is_partly { found } else { tips.clone() })
    }

    /// Calls for each segment of a stretch in whose balls a point is, until it is enough; says whether it went through all.
    fn each(
        &mut self,
        point: DVec3,
        (from, to): (u32, u32),
        found: &mut dyn FnMut(u32) -> bool,
    ) -> Option<bool> {
        if from >= to {
            return Some(true);
        }
        let mut open = vec![(self.levels.len() - 1, 0)];
        while let Some((level, place)) = open.pop() {
            let size = IN_BOX.pow(u32::try_from(level).unwrap_or(0) + 1);
            if (place + 1) * size <= from as usize || place * size >= to as usize {
                continue;
            }
            let [low, high] = self.levels[level][place];
            if point.cmplt(low).any() || point.cmpgt(high).any() {
                continue;
            }
            if level > 0 {
                let last = ((place + 1) * IN_BOX).min(self.levels[level - 1].len());
                open.extend((place * IN_BOX..last).rev().map(|place| (level - 1, place)));
                continue;
            }
            let first = (place * IN_BOX).max(from as usize);
            let last = ((place + 1) * IN_BOX).min(to as usize);
            for node in &self.lines.order[first..last] {
                self.left = self.left.checked_sub(1)?;
                if is_in_segment(self.lines, *node, point) && !found(*node) {
                    return Some(false);
                }
            }
        }
        Some(true)
    }
}

/// The box around boxes.
fn around(boxes: impl IntoIterator<Item = [DVec3; 2]>) -> [DVec3; 2] {
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let boxes = boxes.into_iter();
    boxes.fold(none, |[low, high], one| [low.min(one[0]), high.max(one[1])])
}

/// Whether a point is in a ball of the segment that ends in a node; at a root there is none.
fn is_in_segment(lines: &Lines<'_>, node: u32, point: DVec3) -> bool {
    let to = lines.ball(node);
    let parent = lines.parent(node);
    parent.is_some_and(|parent| depth(lines.ball(parent), to, point) <= 0.0)
}

/// The tube function of a segment: the least of squared distance less squared radius of its balls, below zero within.
pub(super) fn depth(from: Ball, to: Ball, point: DVec3) -> f64 {
    let (way, wider) = (to.centre - from.centre, to.radius - from.radius);
    let off = point - from.centre;
    let value = |part: f64| {
        let ball = from.lerp(to, part);
        ball.centre.distance_squared(point) - ball.radius * ball.radius
    };
    // A parabola over the part of the way; where one ball is within the other it opens downwards, and an end is lowest.
    let bend = way.length_squared() - wider * wider;
    let ends = value(0.0).min(value(1.0));
    if bend > 0.0 {
        let part = (way.dot(off) + wider * from.radius) / bend;
        ends.min(value(part.clamp(0.0, 1.0)))
    } else {
        ends
    }
}
