//! How far other wood is: what `?C` is told, so that ends can stop before they grow into each other (crown shyness: Putz, Parker and Archibald
//! 1984; collisions end branches in Prusinkiewicz, James and Měch 1994 and in Palubicki et al. 2009, "Self-organizing tree models").
//!
//! A *line* is what is drawn within one pair of brackets. Other wood is all segments but those of the asker's own line and of the one that it grows from,
//! which are always near: an end stands at its own last segment, and a bud on its parent. Distances are to the segments' middle lines, since how thick they are is
//! known when the tree stands. A hierarchy of boxes finds the nearest: n ends among n segments take n log n, whatever their lengths; boxes that hold nothing but
//! the asker's own line are passed over. What was found is kept while the wood grows ([`Found`]). A grid of cells would be as fast where all segments are of one
//! length, and not bounded where they are not.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, Vec3};
use hashbrown::HashMap;

use super::turtle::Pen;
use crate::tree::NO_PARENT;
use crate::tree::nearest::NearestLine;

/// No line.
const NONE: u32 = u32::MAX;

/// What is drawn, by lines.
pub(super) struct Wood {
    /// Ends of segments, metres.
    pieces: Vec<[Vec3; 2]>,
    /// The line of each.
    line_of: Vec<u32>,
    /// Of each node its line, and the brackets round it.
    nodes: Vec<(u32, u16)>,
    /// The line that each line grows from.
    parent: Vec<u32>,
    /// The pieces that stand, of which each stands once,
    standing: Vec<u32>,
    /// and of each piece how often all was begun anew when it last stood.
    stood: Vec<u32>,
    times: u32,
    found: Found,
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
            standing: Vec::new(),
            stood: Vec::new(),
            times: 0,
            found: Found::default(),
        }
    }
}

impl Wood {
    fn number(count: usize) -> u32 {
        // A string has fewer modules than 2^32 - 1.
        u32::try_from(count).unwrap_or(NONE)
    }

    /// Nothing stands any more of what is known.
    pub(super) fn begin_anew(&mut self) {
        self.standing.clear();
        self.times += 1;
    }

    /// Pieces that are known.
    pub(super) fn drawn(&self) -> u32 {
        Self::number(self.pieces.len())
    }

    /// Has known pieces stand; false where some do already: two lines in one place are in each other's way.
    pub(super) fn again(&mut self, pieces: Range<u32>) -> bool {
        for piece in pieces {
            match self.stood.get_mut(piece as usize) {
                Some(stood) if *stood != self.times => *stood = self.times,
                _ => return false,
            }
            self.standing.push(piece);
        }
        true
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
        self.standing.push(self.drawn());
        self.stood.push(self.times);
        self.pieces.push(piece);
        self.line_of.push(line);
        self.nodes.push((line, pen.order));
        Some(Self::number(self.nodes.len() - 1))
    }

    /// How far the nearest other wood is from each place, at most so far as each asks; metres.
    ///
    /// None where `cancel` is set.
    pub(super) fn clearances(
        &mut self,
        asked: &[(DVec3, Kin, f64)],
        cancel: &AtomicBool,
    ) -> Option<Vec<f64>> {
        let mut found = std::mem::take(&mut self.found);
        let all_stand = self.standing.len() == self.pieces.len();
        let before = if all_stand {
            found.settle(self);
            let before = found.groves.len();
            found.add(self, found.pieces()..self.pieces.len());
            before
        } else {
            let standing = || self.standing.iter().map(|piece| *piece as usize);
            let pieces = standing().filter_map(|piece| self.pieces.get(piece).copied());
            let line_of = standing().filter_map(|piece| self.line_of.get(piece).copied());
            let nearest = NearestLine::new(pieces.collect(), line_of.collect());
            found = Found {
                groves: vec![(0..0, nearest)],
                ..Found::default()
            };
            0
        };
        let mut told = HashMap::with_capacity(asked.len());
        let mut open = Vec::new();
        let one = |(place, kin, within): &(DVec3, Kin, f64)| {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let within = within.max(0.0);
            let asker = (place.to_array().map(f64::to_bits), *kin, within.to_bits());
            let most = within * within;
            let best = match found.told.get(&asker) {
                Some(best) => found.squared(before, *place, *kin, *best, &mut open),
                None => found.squared(0, *place, *kin, most, &mut open),
            };
            told.insert(asker, best);
            // The root of a square is not always the number itself.
            Some(if best < most { best.sqrt() } else { within })
        };
        let clearances: Option<Vec<f64>> = asked.iter().map(one).collect();
        if all_stand {
            self.found = Found { told, ..found };
        }
        clearances
    }
}

/// An asker's place, kin and how far it looks.
type Asker = ([u64; 3], Kin, u64);

/// The square of 0.01 mm: what is nearer touches, at distance 0. Where branches lie over each other in their hundreds, rounding parts them by less, and which one
/// is the nearest is no question; the first one answers it.
const TOUCHING: f64 = 1e-10;

/// What was found in the step before. While nothing falls, no more than the new wood can come nearer to whoever asked before, and hierarchies of old wood stay:
/// they are put together when the next one is half as large, so that a piece is sorted anew as often as its wood doubles, and not in each step. *Tried*: putting
/// them together sooner and later takes as long.
#[derive(Default)]
struct Found {
    /// Over pieces one after the other, which stand at these places.
    groves: Vec<(Range<usize>, NearestLine<2>)>,
    /// Squared distances.
    told: HashMap<Asker, f64>,
}

impl Found {
    /// Pieces of all groves.
    fn pieces(&self) -> usize {
        self.groves.last().map_or(0, |(pieces, _)| pieces.end)
    }

    fn add(&mut self, wood: &Wood, pieces: Range<usize>) {
        let (Some(own), Some(line_of)) = (
            wood.pieces.get(pieces.clone()),
            wood.line_of.get(pieces.clone()),
        ) else {
            return;
        };
        if !own.is_empty() {
            let nearest = NearestLine::new(own.to_vec(), line_of.to_vec());
            self.groves.push((pieces, nearest));
        }
    }

    /// Puts the last groves together, as long as the one before is not twice as large.
    fn settle(&mut self, wood: &Wood) {
        let end = self.pieces();
        let mut start = end;
        let mut kept = self.groves.len();
        while let Some((pieces, _)) = self.groves.get(kept.wrapping_sub(1))
            && (start == end || pieces.len() < 2 * (end - start))
        {
            start = pieces.start;
            kept -= 1;
        }
        if self.groves.len() - kept > 1 {
            self.groves.truncate(kept);
            self.add(wood, start..end);
        }
    }

    /// The squared distance to the nearest other wood in the groves from one on, at most `best`.
    fn squared(
        &self,
        from: usize,
        place: DVec3,
        kin: Kin,
        best: f64,
        open: &mut Vec<(f64, u32)>,
    ) -> f64 {
        let squared = |ends| {
            let far = on_segment(ends, place).distance_squared(place);
            if far < TOUCHING { 0.0 } else { far }
        };
        let groves = self.groves.iter().skip(from);
        groves.fold(best, |best, (_, nearest)| {
            nearest.squared(place, best, kin, open, squared)
        })
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
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        clippy::cast_sign_loss,
        reason = "tests"
    )]
    use proptest::prelude::*;

    use super::*;

    /// A pen at a node, in so many brackets.
    fn pen(node: u32, order: u16, position: DVec3) -> Pen {
        let mut pen = Pen::new(0.1);
        (pen.node, pen.order, pen.position) = (node, order, position);
        pen
    }

    fn told(mut wood: Wood, asked: &[(DVec3, Kin, f64)]) -> Vec<f64> {
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
        /// As brute force says, for any segments, coincident and of no length among them: while they become more, and when some have fallen.
        #[test]
        fn as_brute_force(
            numbers in prop::collection::vec((0_u32..6, prop::array::uniform6(-4_i8..4)), 0..80),
            asked in prop::collection::vec((0_u32..7, 0_u32..7, prop::array::uniform3(-5.0..5.0_f64), 0.0..6.0_f64), 1..20),
            stages in prop::collection::vec(0.0..1.0_f64, 0..6),
        ) {
            let corner = |at: &[i8]| Vec3::new(at[0].into(), at[1].into(), at[2].into());
            let asked: Vec<_> = asked.into_iter()
                .map(|(own, parent, at, within)| (DVec3::from(at), [own, parent], within))
                .collect();
            let mut wood = Wood::default();
            let mut stages = stages;
            stages.sort_by(f64::total_cmp);
            let whole = stages.iter().map(|_| false).chain([false, true]);
            for (stage, has_fallen) in stages.iter().copied().chain([1.0, 1.0]).zip(whole) {
                let part = |all: usize| (all as f64 * stage) as usize;
                let new = &numbers[wood.pieces.len()..part(numbers.len())];
                wood.pieces.extend(new.iter().map(|(_, at)| [corner(&at[..3]), corner(&at[3..])]));
                wood.line_of.extend(new.iter().map(|(line, _)| *line));
                let standing = (0..wood.drawn()).filter(|piece| !has_fallen || piece % 3 > 0);
                wood.standing = standing.collect();
                let asked = &asked[..part(asked.len())];
                let brute = |(place, kin, within): &(DVec3, Kin, f64)| {
                    let all = wood.standing.iter().map(|piece| *piece as usize);
                    let others = all.filter(|piece| !kin.contains(&wood.line_of[*piece]));
                    let ends = others.map(|piece| wood.pieces[piece].map(|end| end.as_dvec3()));
                    let far = ends.map(|ends| on_segment(ends, *place).distance(*place));
                    far.map(|far| if far < 1e-5 { 0.0 } else { far }).fold(*within, f64::min)
                };
                let expected: Vec<f64> = asked.iter().map(brute).collect();
                let told = wood.clearances(asked, &AtomicBool::new(false)).unwrap();
                for (told, expected) in told.into_iter().zip(expected) {
                    prop_assert!((told - expected).abs() <= 1e-9, "{told} {expected}");
                }
            }
        }
    }
}
