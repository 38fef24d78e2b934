//! The full-size tree: asking for it, and letting it grow on the eye.
//!
//! The world grows nothing itself: it says which tree it wants
//! ([`TreeRequest`]) and shows what it is given, so that the application may
//! grow large trees on a worker. The document moves a whole step at once; only
//! the picture moves on smoothly, by the time of the input.

use std::sync::Arc;

use glam::Affine3A;

use crate::{
    sketch::{Grown, MAX_SEGMENTS, Sketch},
    tree::{Organs, Tree, foliage::Bare},
};

use super::{
    document::Document,
    scene::{PlacedTree, new_revision},
};

/// How growth is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrowthParams {
    /// Seconds in which a step grows or shrinks.
    pub seconds: f32,
    /// A larger tree is not asked for.
    pub max_segments: u64,
}

impl Default for GrowthParams {
    fn default() -> Self {
        Self {
            seconds: 0.6,
            max_segments: MAX_SEGMENTS,
        }
    }
}

/// A tree that the world would like to show.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeRequest {
    /// To be given back with the tree; larger ids are newer wishes.
    pub id: u64,
    /// What grows.
    pub sketch: Arc<Sketch>,
    /// How far.
    pub step: u32,
    /// How many segments it will have.
    pub segments: u64,
}

/// A tree as it was given.
#[derive(Debug)]
struct Shown {
    tree: Arc<Tree>,
    organs: Arc<Organs>,
    radius_before: Arc<Vec<f32>>,
    newest: u32,
    step: u32,
}

/// See the module.
#[derive(Debug)]
pub(super) struct Growth {
    /// Sketch and step of the newest wish.
    wanted: Option<(Arc<Sketch>, u32)>,
    /// Steps of wishes that no tree has come for yet, by id, oldest first.
    open: Vec<(u64, u32)>,
    request: Option<TreeRequest>,
    last_id: u64,
    shown_id: u64,
    shown: Option<Shown>,
    /// Follows when the shown tree has shrunk.
    next: Option<Shown>,
    /// How far the newest step has grown, 0 to 1, before easing.
    fraction: f32,
    revision: u64,
    /// Where a person holds the moment, steps.
    moment: Option<f64>,
}

impl Default for Growth {
    fn default() -> Self {
        Self {
            wanted: None,
            open: Vec::new(),
            request: None,
            last_id: 0,
            shown_id: 0,
            shown: None,
            next: None,
            fraction: 1.0,
            revision: 0,
            moment: None,
        }
    }
}

impl Growth {
    /// Shows the tree at a moment (steps), or lets it move by itself.
    pub(super) fn set_moment(&mut self, moment: Option<f64>) {
        if moment.is_some() && self.moment.is_none() {
            // What was on its way is there.
            if let Some(next) = self.next.take() {
                self.shown = Some(next);
                self.revision = new_revision();
            }
            self.fraction = 1.0;
        }
        self.moment = moment;
    }

    /// How far the newest step of the shown tree has grown, eased where it moves by itself.
    fn grown(&self, shown: &Shown) -> f32 {
        let Some(moment) = self.moment else {
            return eased(self.fraction);
        };
        #[expect(clippy::cast_possible_truncation, reason = "0 to 1")]
        let part = (moment - (f64::from(shown.step) - 1.0)).clamp(0.0, 1.0) as f32;
        part
    }

    /// What the tree should bear and does not.
    pub(super) fn bare(&self) -> &[Bare] {
        self.shown.as_ref().map_or(&[], |shown| &shown.organs.bare)
    }

    /// Whether the document's tree has not been wished for yet.
    pub(super) fn is_new(&self, document: &Document) -> bool {
        !self.wanted.as_ref().is_some_and(|(sketch, step)| {
            Arc::ptr_eq(sketch, &document.sketch) && *step == document.step
        })
    }

    /// Notes that the document's tree was thought of: it is not new any more.
    pub(super) fn note(&mut self, document: &Document) {
        self.wanted = Some((Arc::clone(&document.sketch), document.step));
    }

    /// Wishes for the document's tree, which will have so many segments.
    pub(super) fn wish(&mut self, document: &Document, segments: u64) {
        self.note(document);
        self.last_id += 1;
        self.open.push((self.last_id, document.step));
        let (sketch, step) = (Arc::clone(&document.sketch), document.step);
        self.request = Some(TreeRequest {
            id: self.last_id,
            sketch,
            step,
            segments,
        });
    }

    pub(super) fn take_request(&mut self) -> Option<TreeRequest> {
        self.request.take()
    }

    /// Takes a tree in, unless it is older than the one shown. Gives its string where it was taken.
    pub(super) fn give(&mut self, id: u64, grown: Grown) -> Option<String> {
        let step = self.close(id)?;
        if id <= self.shown_id {
            return None;
        }
        self.shown_id = id;
        let Grown {
            tree,
            organs,
            radius_before,
            string,
            newest,
            ..
        } = grown;
        let given = Shown {
            tree: Arc::new(tree),
            organs: Arc::new(organs),
            radius_before: Arc::new(radius_before),
            newest,
            step,
        };
        if self.moment.is_some() {
            // A hand moves it: it has no ways of its own.
            self.next = None;
            self.fraction = 1.0;
        } else if self
            .shown
            .as_ref()
            .is_some_and(|shown| shown.step == given.step)
        {
            // Another tree of the same step: growth goes on where it was, shrinking turns round.
            self.next = None;
        } else {
            // Where the last tree is still shrinking, its successor is what was there before.
            let shrinking = self.next.is_some();
            let before = self.next.take().or(self.shown.take());
            let step_before = before.as_ref().map(|before| before.step);
            if given.step.checked_add(1) == step_before {
                // Seen for the last time: it shrinks, then gives way.
                self.shown = before;
                self.next = Some(given);
                self.fraction = if shrinking { 1.0 } else { self.fraction };
                self.revision = new_revision();
                return Some(string);
            }
            let grows = step_before.is_some() && step_before == given.step.checked_sub(1);
            self.fraction = if grows { 0.0 } else { 1.0 };
        }
        self.shown = Some(given);
        self.revision = new_revision();
        Some(string)
    }

    /// Notes that no tree comes for a wish. Gives whether it was a wish.
    pub(super) fn fail(&mut self, id: u64) -> bool {
        self.close(id).is_some()
    }

    /// Ends a wish, and all older ones; gives its step.
    fn close(&mut self, id: u64) -> Option<u32> {
        let step = self
            .open
            .iter()
            .find(|open| open.0 == id)
            .map(|open| open.1);
        self.open.retain(|open| open.0 > id);
        step
    }

    /// Moves the picture on.
    pub(super) fn advance(&mut self, seconds: f32, params: &GrowthParams) {
        let moved = if params.seconds > 0.0 {
            seconds / params.seconds
        } else {
            1.0
        };
        if self.next.is_none() {
            self.fraction = (self.fraction + moved).min(1.0);
            return;
        }
        self.fraction -= moved;
        if self.fraction <= 0.0 {
            self.shown = self.next.take();
            self.fraction = 1.0;
            self.revision = new_revision();
        }
    }

    /// Whether the picture moves.
    pub(super) fn is_moving(&self) -> bool {
        self.next.is_some() || self.fraction < 1.0
    }

    /// Whether a tree is being waited for.
    pub(super) fn is_waiting(&self) -> bool {
        !self.open.is_empty()
    }

    /// Segments of the tree that is shown or about to be.
    pub(super) fn segments(&self) -> usize {
        let tree = self.next.as_ref().or(self.shown.as_ref());
        // Every node but the root is a segment.
        tree.map_or(0, |shown| shown.tree.parent.len().saturating_sub(1))
    }

    /// The tree that is shown, in its whole last state.
    pub(super) fn tree(&self) -> Option<&Arc<Tree>> {
        self.shown.as_ref().map(|shown| &shown.tree)
    }

    /// The tree as it stands now.
    pub(super) fn placed(&self, world_from_tree: Affine3A) -> Option<PlacedTree> {
        let shown = self.shown.as_ref()?;
        Some(PlacedTree {
            tree: Arc::clone(&shown.tree),
            organs: Arc::clone(&shown.organs),
            radius_before: Arc::clone(&shown.radius_before),
            revision: self.revision,
            world_from_tree,
            growth: self.grown(shown),
            newest: shown.newest,
        })
    }
}

/// A part of a movement's time (0 to 1) as a part of its way, eased at both ends: nothing on the stage starts or stops
/// with a jerk.
pub(super) fn eased(part: f32) -> f32 {
    let part = part.clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    fn grown(step: u32) -> Grown {
        Grown {
            newest: step,
            string: format!("step {step}"),
            ..Grown::default()
        }
    }

    fn at(step: u32) -> Document {
        Document {
            step,
            ..Document::default()
        }
    }

    fn wish(growth: &mut Growth, step: u32) -> u64 {
        growth.wish(&at(step), 0);
        growth.take_request().unwrap().id
    }

    fn seen(growth: &Growth) -> (u32, f32) {
        let placed = growth.placed(Affine3A::IDENTITY).unwrap();
        (placed.newest, placed.growth)
    }

    #[test]
    fn a_step_grows_and_shrinks_without_jumps() {
        let (mut growth, params) = (Growth::default(), GrowthParams::default());
        let id = wish(&mut growth, 3);
        assert!(growth.give(id, grown(3)).is_some());
        assert_eq!(seen(&growth), (3, 1.0), "the first tree is there at once");
        let id = wish(&mut growth, 4);
        growth.give(id, grown(4));
        assert_eq!(seen(&growth), (4, 0.0));
        growth.advance(0.3, &params);
        assert!((seen(&growth).1 - 0.5).abs() < 1e-5);
        growth.advance(5.0, &params);
        assert_eq!(seen(&growth), (4, 1.0));
        let id = wish(&mut growth, 3);
        growth.give(id, grown(3));
        assert_eq!(
            seen(&growth),
            (4, 1.0),
            "the newest segments are still whole"
        );
        growth.advance(0.3, &params);
        assert!((seen(&growth).1 - 0.5).abs() < 1e-5);
        growth.advance(0.4, &params);
        assert_eq!(seen(&growth), (3, 1.0));
        assert!(!growth.is_moving());
    }

    #[test]
    fn a_change_of_mind_while_it_moves_turns_it_round() {
        let (mut growth, params) = (Growth::default(), GrowthParams::default());
        for step in [3, 4] {
            let id = wish(&mut growth, step);
            growth.give(id, grown(step));
        }
        growth.advance(0.3, &params);
        for (step, expected) in [(3, (4, 0.5)), (4, (4, 0.5)), (3, (4, 0.5)), (2, (3, 1.0))] {
            let id = wish(&mut growth, step);
            growth.give(id, grown(step));
            let (newest, fraction) = seen(&growth);
            assert!(
                newest == expected.0 && (fraction - expected.1).abs() < 1e-5,
                "{step}: {newest} {fraction}"
            );
        }
    }

    #[test]
    fn late_and_unknown_trees_are_not_shown() {
        let mut growth = Growth::default();
        let first = wish(&mut growth, 1);
        let second = wish(&mut growth, 5);
        assert!(growth.give(second, grown(5)).is_some());
        assert!(
            growth.give(first, grown(1)).is_none(),
            "older than what is shown"
        );
        assert!(growth.give(99, grown(9)).is_none(), "never wished for");
        assert_eq!(seen(&growth).0, 5);
        assert!(!growth.is_waiting());
    }

    #[test]
    fn the_revision_tells_every_change_of_tree() {
        let (mut growth, params) = (Growth::default(), GrowthParams::default());
        let mut last = 0;
        for step in [1, 2, 3, 2, 2, 0, 7] {
            let id = wish(&mut growth, step);
            growth.give(id, grown(step));
            growth.advance(10.0, &params);
            let placed = growth.placed(Affine3A::IDENTITY).unwrap();
            assert!(placed.revision > last && placed.newest == step, "{step}");
            last = placed.revision;
            growth.advance(1.0, &params);
            assert_eq!(
                growth.placed(Affine3A::IDENTITY).unwrap().revision,
                last,
                "and nothing else"
            );
        }
    }
}
