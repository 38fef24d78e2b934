//! The nearest of many small pieces, straight or flat, by a hierarchy of boxes (obvhs, PLOC).

use glam::{DVec3, Vec3};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// Finds nearest points of pieces with so many corners each.
pub(crate) struct Nearest<const N: usize> {
    pieces: Vec<[Vec3; N]>,
    bvh: Bvh2,
}

impl<const N: usize> Nearest<N> {
    /// Over all pieces.
    pub(crate) fn new(pieces: Vec<[Vec3; N]>) -> Self {
        let around = |corners: &[Vec3; N]| {
            let all = || corners.iter().copied();
            let low = all().fold(Vec3::INFINITY, Vec3::min);
            let high = all().fold(Vec3::NEG_INFINITY, Vec3::max);
            Aabb::new(low.into(), high.into())
        };
        let boxes: Vec<Aabb> = pieces.iter().map(around).collect();
        let indices = (0_u32..).take(boxes.len()).collect();
        let bvh = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::VeryLow,
            &boxes,
            indices,
            SortPrecision::U64,
            0,
        );
        Self { pieces, bvh }
    }

    /// The nearest point to a point, where `on` gives that of one piece; of equally near ones that on the first piece, so that the shape of the hierarchy
    /// does not matter. None where there is no piece.
    pub(crate) fn point(
        &self,
        to: DVec3,
        on: impl Fn([DVec3; N], DVec3) -> DVec3,
    ) -> Option<DVec3> {
        let mut best: Option<(f64, u32, DVec3)> = None;
        let all = |_: usize| true;
        let (most, open) = (f64::INFINITY, &mut Vec::new());
        self.walk(to, most, all, open, |piece, corners| {
            let point = on(corners, to);
            let distance = point.distance_squared(to);
            let is_better = |(far, other, _): (f64, u32, DVec3)| (distance, piece) < (far, other);
            if best.is_none_or(is_better) {
                best = Some((distance, piece, point));
            }
            best.map_or(f64::INFINITY, |(distance, ..)| distance)
        });
        best.map(|(_, _, point)| point)
    }

    /// Shows the pieces that may be no farther than `most`, squared, nearer boxes first; `see` says what that is from then on. `counts`: whether a box, by its
    /// number, has what matters. `open` is memory for boxes that are yet to be looked at.
    fn walk(
        &self,
        to: DVec3,
        mut most: f64,
        counts: impl Fn(usize) -> bool,
        open: &mut Vec<(f64, u32)>,
        mut see: impl FnMut(u32, [DVec3; N]) -> f64,
    ) {
        open.clear();
        open.push((self.away(0, to), 0));
        while let Some((least, number)) = open.pop() {
            let Some(node) = self.bvh.nodes.get(number as usize) else {
                continue;
            };
            if least > most || !counts(number as usize) {
                continue;
            }
            if !node.is_leaf() {
                let children = [node.first_index, node.first_index + 1];
                let mut children = children.map(|child| (self.away(child, to), child));
                // The nearer one is looked at first.
                children.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
                open.extend(children);
                continue;
            }
            for piece in self.pieces_of(node) {
                if let Some(corners) = self.pieces.get(*piece as usize) {
                    most = see(*piece, corners.map(|corner| corner.as_dvec3()));
                }
            }
        }
    }

    /// The pieces of a box that holds no other.
    fn pieces_of(&self, node: &Bvh2Node) -> &[u32] {
        let first = node.first_index as usize;
        let own = first..first + node.prim_count as usize;
        self.bvh.primitive_indices.get(own).unwrap_or_default()
    }

    /// The squared distance to a node's box.
    fn away(&self, number: u32, to: DVec3) -> f64 {
        let Some(node) = self.bvh.nodes.get(number as usize) else {
            return f64::INFINITY;
        };
        let (min, max) = (node.aabb().min, node.aabb().max);
        let (min, max) = (Vec3::from(min).as_dvec3(), Vec3::from(max).as_dvec3());
        to.clamp(min, max).distance_squared(to)
    }
}

/// Pieces of lines, of which some are not asked for.
pub(crate) struct NearestLine<const N: usize> {
    nearest: Nearest<N>,
    /// The line of each piece,
    line_of: Vec<u32>,
    /// and of all pieces in each box, where they are of one.
    lines: Vec<Option<u32>>,
}

impl<const N: usize> NearestLine<N> {
    /// Over all pieces, each of the line of its place in `line_of`.
    pub(crate) fn new(pieces: Vec<[Vec3; N]>, line_of: Vec<u32>) -> Self {
        let mut nearest = Nearest::new(pieces);
        // Children come after their parents then, so that one pass from behind is enough.
        nearest.bvh.reorder_in_stack_traversal_order();
        let nodes = &nearest.bvh.nodes;
        let mut lines: Vec<Option<u32>> = vec![None; nodes.len()];
        for (number, node) in nodes.iter().enumerate().rev() {
            let first = node.first_index as usize;
            lines[number] = if node.is_leaf() {
                let own = nearest.pieces_of(node).iter();
                common(own.map(|piece| line_of.get(*piece as usize).copied()))
            } else {
                common((first..first + 2).map(|child| lines.get(child).copied().flatten()))
            };
        }
        Self {
            nearest,
            line_of,
            lines,
        }
    }

    /// How far the nearest piece is that is of none of these lines, squared, at most `most`; `squared` gives that of one piece. Boxes of nothing else are
    /// passed over, so a long line is in nobody's way. `open` is memory that is used again.
    pub(crate) fn squared(
        &self,
        to: DVec3,
        most: f64,
        without: [u32; 2],
        open: &mut Vec<(f64, u32)>,
        squared: impl Fn([DVec3; N]) -> f64,
    ) -> f64 {
        let mut best = most;
        let counts = |line: Option<u32>| line.is_none_or(|line| !without.contains(&line));
        let boxes = |number: usize| counts(self.lines.get(number).copied().flatten());
        // What is just as far is no nearer: a thousand pieces in one place are looked at once.
        let most = best.next_down();
        self.nearest.walk(to, most, boxes, open, |piece, corners| {
            if counts(self.line_of.get(piece as usize).copied()) {
                best = best.min(squared(corners));
            }
            best.next_down()
        });
        best
    }
}

/// The line that all are of, if they are of one.
fn common(mut lines: impl Iterator<Item = Option<u32>>) -> Option<u32> {
    let first = lines.next().flatten();
    first.filter(|_| lines.all(|line| line == first))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    /// A line of ten thousand pieces with two of another: who asks for others is shown a handful.
    #[test]
    fn a_long_line_is_passed_over() {
        let piece = |at: u16| [0.0, 0.9].map(|part| Vec3::X * (f32::from(at) + part));
        let mut pieces: Vec<[Vec3; 2]> = (0..10_000).map(piece).collect();
        let mut line_of = vec![7; pieces.len()];
        for at in [2000_usize, 7000] {
            pieces[at] = pieces[at].map(|end| end + Vec3::Y);
            line_of[at] = 8;
        }
        let lines = NearestLine::new(pieces, line_of);
        let to = DVec3::new(5000.0, 0.0, 0.0);
        let open = &mut Vec::new();
        let squared = |ends: [DVec3; 2]| ends[0].distance_squared(to);
        let found = lines.squared(to, 1e12, [7, u32::MAX], open, squared).sqrt();
        assert!((found - 2000.0_f64.hypot(1.0)).abs() < 1e-3, "{found}");
        let mut seen = 0;
        let other = |number: usize| lines.lines[number] != Some(7);
        lines.nearest.walk(to, f64::INFINITY, other, open, |_, _| {
            seen += 1;
            f64::INFINITY
        });
        assert!((2..60).contains(&seen), "{seen} of 10,000");
        assert_eq!(lines.squared(to, 9.0, [7, 8], open, squared), 9.0);
    }

    /// As where a grammar draws branch over branch.
    #[test]
    fn a_pile_in_one_place_is_looked_at_once() {
        let (pieces, line_of) = (vec![[Vec3::ONE]; 10_000], (0..10_000).collect());
        let lines = NearestLine::new(pieces, line_of);
        for (to, expected) in [(DVec3::ONE, 0.0), (DVec3::ZERO, 3.0)] {
            let seen = std::cell::Cell::new(0);
            let squared = |[end]: [DVec3; 1]| {
                seen.set(seen.get() + 1);
                end.distance_squared(to)
            };
            let found = lines.squared(to, 9.0, [0, 1], &mut Vec::new(), squared);
            assert_eq!(found, expected);
            assert!(seen.get() < 10, "{} of 10,000", seen.get());
        }
    }
}
