//! How far other wood is: what `?C` is told, so that ends can stop before they grow into each other (crown shyness: Putz, Parker and Archibald
//! 1984; collisions end branches in Prusinkiewicz, James and Měch 1994 and in Palubicki et al. 2009, "Self-organizing tree models").
//!
//! A *line* is what is drawn within one pair of brackets. Other wood is all segments but those of the asker's own line and of the one that it grows from,
//! which are always near: an end stands at its own last segment, and a bud on its parent. Distances are to the segments' middle lines, since how thick they are is
//! known when the tree stands. A hierarchy of boxes finds the nearest: n ends among n segments take n log n, whatever their lengths; boxes that hold nothing but
//! the asker's own line are passed over. A grid of cells would be as fast where all segments are of one length, and not bounded where they are not.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, Vec3};

use super::turtle::Pen;
use crate::tree::NO_PARENT;
use crate::tree::nearest::NearestLine;

/// No line.
const NONE: u32 = u32::MAX;

/// What is drawn, by lines.
#[derive(Debug)]
pub(super) struct Wood {
    /// Ends of segments, metres.
    pieces: Vec<[Vec3; 2]>,
    /// The line of each.
    line_of: Vec<u32>,
    /// Of each node its line, and the brackets round it.
    nodes: Vec<(u32, u16)>,
    /// The line that each line grows from.
    parent: Vec<u32>,
}

/// Whom a query does not mean: its own line and that line's parent.
pub(super) type Kin = [u32; 2];

impl Default for Wood {
    /// The turtle's start.
    fn default() -> Self {
        Self {
            pieces: Vec::new(),
            line_of: Vec::new(),
            nodes: vec![(0, 0)],
            parent: vec![NONE],
        }
    }
}

impl Wood {
    fn number(count: usize) -> u32 {
        // A string has fewer modules than 2^32 - 1.
        u32::try_from(count).unwrap_or(NONE)
    }

    /// A line that begins.
    fn begin(&mut self, parent: u32) -> u32 {
        self.parent.push(parent);
        Self::number(self.parent.len() - 1)
    }

    /// A node where the pen stands after a move without drawing.
    pub(super) fn root(&mut self, pen: &Pen) -> u32 {
        let line = self.begin(NONE);
        self.nodes.push((line, pen.order));
        Self::number(self.nodes.len() - 1)
    }

    /// The line on which the pen draws, if that has begun, and the one that it grows from.
    pub(super) fn kin(&self, pen: &Pen) -> Kin {
        let at = (pen.node != NO_PARENT).then(|| self.nodes.get(pen.node as usize));
        match at.flatten() {
            Some((line, order)) if *order == pen.order => {
                let parent = self.parent.get(*line as usize);
                [*line, parent.copied().unwrap_or(NONE)]
            }
            Some((line, _)) => [NONE, *line],
            None => [NONE; 2],
        }
    }

    /// A segment from the pen; None where it ends farther away than a tree holds.
    pub(super) fn segment(&mut self, pen: &Pen, end: DVec3) -> Option<u32> {
        let piece = [pen.position.as_vec3(), end.as_vec3()];
        if !piece.iter().all(|corner| corner.is_finite()) {
            return None;
        }
        let line = match self.kin(pen) {
            [NONE, parent] => self.begin(parent),
            [line, _] => line,
        };
        self.pieces.push(piece);
        self.line_of.push(line);
        self.nodes.push((line, pen.order));
        Some(Self::number(self.nodes.len() - 1))
    }

    /// How far the nearest other wood is from each place, at most so far as each asks; metres.
    ///
    /// None where `cancel` is set.
    pub(super) fn clearances(
        self,
        asked: &[(DVec3, Kin, f64)],
        cancel: &AtomicBool,
    ) -> Option<Vec<f64>> {
        let Self {
            pieces, line_of, ..
        } = self;
        let nearest = NearestLine::new(pieces, line_of);
        let one = |(place, kin, within): &(DVec3, Kin, f64)| {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let squared = |ends| on_segment(ends, *place).distance_squared(*place);
            Some(nearest.distance(*place, within.max(0.0), *kin, squared))
        };
        asked.iter().map(one).collect()
    }
}

/// The point of a segment that is nearest to a place.
fn on_segment([from, to]: [DVec3; 2], place: DVec3) -> DVec3 {
    let along = to - from;
    let square = along.length_squared();
    if square > 0.0 {
        from + along * ((place - from).dot(along) / square).clamp(0.0, 1.0)
    } else {
        from
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use proptest::prelude::*;

    use super::*;

    /// A pen at a node, in so many brackets.
    fn pen(node: u32, order: u16, position: DVec3) -> Pen {
        let mut pen = Pen::new(0.1);
        (pen.node, pen.order, pen.position) = (node, order, position);
        pen
    }

    fn told(wood: Wood, asked: &[(DVec3, Kin, f64)]) -> Vec<f64> {
        wood.clearances(asked, &AtomicBool::new(false)).unwrap()
    }

    /// A trunk of two segments with branches to the left and to the right of its first node.
    #[test]
    fn a_line_and_its_parent_are_not_in_each_others_way_and_siblings_are() {
        let mut wood = Wood::default();
        let first = wood.segment(&pen(0, 0, DVec3::ZERO), DVec3::Y).unwrap();
        let [left, right] = [-1.0, 1.0].map(|x| DVec3::new(x, 1.0, 0.0));
        let from = pen(first, 1, DVec3::Y);
        let [at_left, at_right] = [left, right].map(|to| wood.segment(&from, to).unwrap());
        let top = DVec3::Y * 2.0;
        let at_top = wood.segment(&pen(first, 0, DVec3::Y), top).unwrap();
        let kin_of = |node, order| wood.kin(&pen(node, order, DVec3::ZERO));
        assert_eq!(kin_of(at_top, 0), kin_of(first, 0), "the trunk goes on");
        assert_ne!(kin_of(at_left, 1)[0], kin_of(at_right, 1)[0]);
        assert_eq!(kin_of(at_left, 1)[1], kin_of(first, 0)[0]);
        // Before its first segment a branch has a parent alone.
        assert_eq!(kin_of(at_left, 2), [NONE, kin_of(at_left, 1)[0]]);
        let asked = [
            (left, kin_of(at_left, 1), 9.0),
            (top, kin_of(at_top, 0), 9.0),
            (top, kin_of(at_top, 0), 0.5),
            (top, kin_of(at_top, 0), -1.0),
            (left, [NONE; 2], 9.0),
        ];
        // The sibling begins where the branch does; the trunk's end is a metre above both.
        assert_eq!(told(wood, &asked), [1.0, 1.0, 0.5, 0.0, 0.0]);
    }

    #[test]
    fn without_wood_there_is_all_room_and_too_far_is_no_segment() {
        assert_eq!(
            told(Wood::default(), &[(DVec3::ONE, [NONE; 2], 3.0)]),
            [3.0]
        );
        let far = DVec3::X * 1e300;
        assert!(
            Wood::default()
                .segment(&pen(0, 0, DVec3::ZERO), far)
                .is_none()
        );
        let set = AtomicBool::new(true);
        let asked = [(DVec3::ONE, [NONE; 2], 3.0)];
        assert!(Wood::default().clearances(&asked, &set).is_none());
    }

    proptest! {
        /// As brute force says, for any segments, coincident and of no length among them.
        #[test]
        fn as_brute_force(
            numbers in prop::collection::vec((0_u32..6, prop::array::uniform6(-4_i8..4)), 0..80),
            asked in prop::collection::vec((0_u32..7, 0_u32..7, prop::array::uniform3(-5.0..5.0_f64), 0.0..6.0_f64), 1..20),
        ) {
            let corner = |at: &[i8]| Vec3::new(at[0].into(), at[1].into(), at[2].into());
            let wood = Wood {
                pieces: numbers.iter().map(|(_, at)| [corner(&at[..3]), corner(&at[3..])]).collect(),
                line_of: numbers.iter().map(|(line, _)| *line).collect(),
                ..Wood::default()
            };
            let asked: Vec<_> = asked.into_iter()
                .map(|(own, parent, at, within)| (DVec3::from(at), [own, parent], within))
                .collect();
            let brute = |(place, kin, within): &(DVec3, Kin, f64)| {
                let others = wood.pieces.iter().zip(&wood.line_of).filter(|(_, line)| !kin.contains(line));
                let far = others.map(|(ends, _)| on_segment(ends.map(|end| end.as_dvec3()), *place).distance(*place));
                far.fold(*within, f64::min)
            };
            let expected: Vec<f64> = asked.iter().map(brute).collect();
            for (told, expected) in told(wood, &asked).into_iter().zip(expected) {
                prop_assert!((told - expected).abs() <= 1e-9, "{told} {expected}");
            }
        }
    }
}
