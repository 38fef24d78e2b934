//! Symmetry: one branch drawn, its turned and mirrored copies drawn with it.
//!
//! The copies hang on the node of the branch they copy, turned about the vertical and mirrored in
//! the plane x = 0 of the sketch. They are strokes of their own. Drawing on at the apex of one draws on at
//! the others too, as long as they are images of each other; that is read from the sketch, so nothing
//! has to be remembered, and a copy that was changed by hand goes its own way from then on.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::{Letter, NodeRef, Sketch, Stroke, quantize};

/// How far an image's node may be from where it is expected, metres: two steps of the grid and a half.
const IMAGE_SLACK: f64 = 0.000_25;

/// Which copies of a branch are drawn with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Symmetry {
    /// How many times it stands around the vertical, itself counted: 1 is none, at most [`Self::TURNS_MOST`].
    pub turns: u32,
    /// Whether each of these has a mirror image.
    pub mirror: bool,
}

impl Default for Symmetry {
    fn default() -> Self {
        Self::OFF
    }
}

impl Symmetry {
    /// No copies.
    pub const OFF: Self = Self {
        turns: 1,
        mirror: false,
    };
    /// The most turns.
    pub const TURNS_MOST: u32 = 16;

    /// Whether nothing is copied.
    #[must_use]
    pub fn is_off(&self) -> bool {
        *self == Self::OFF
    }

    pub(super) fn images(self) -> impl Iterator<Item = Image> {
        let mirrors = if self.mirror { 2 } else { 1 };
        (0..self.turns)
            .flat_map(move |turn| (0..mirrors).map(move |mirror| (turn, mirror == 1)))
            .skip(1)
            .map(move |(turn, mirror)| Image::new(turn, self.turns, mirror))
    }
}

/// A turn about the vertical, after a reflection in x = 0 where wanted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Image {
    sin: f64,
    cos: f64,
    mirror: bool,
}

impl Image {
    fn new(turn: u32, turns: u32, mirror: bool) -> Self {
        // Quarter turns are exact: they are the usual ones, and a quarter's cosine is no 6e-17.
        let (sin, cos) = match (turn * 4).checked_rem(turns) {
            Some(0) => {
                [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][(turn * 4 / turns) as usize % 4]
            }
            _ => (std::f64::consts::TAU * f64::from(turn) / f64::from(turns.max(1))).sin_cos(),
        };
        Self { sin, cos, mirror }
    }

    fn exact(&self, at: Vec3) -> DVec3 {
        let at = quantize::exact(at);
        let x = if self.mirror { -at.x } else { at.x };
        DVec3::new(
            self.cos * x + self.sin * at.z,
            at.y,
            self.cos * at.z - self.sin * x,
        )
    }

    #[expect(clippy::cast_possible_truncation, reason = "positions are f32")]
    pub(super) fn of(&self, at: Vec3) -> Vec3 {
        let at = self.exact(at);
        quantize::point(Vec3::new(at.x as f32, at.y as f32, at.z as f32))
    }

    /// The stroke's copy under another name.
    pub(super) fn of_stroke(&self, stroke: &Stroke, letter: Letter) -> Stroke {
        Stroke {
            letter,
            points: stroke.points.iter().map(|&point| self.of(point)).collect(),
            handles: stroke.handles.clone(),
            attachment: stroke.attachment,
            self_similar: stroke.self_similar,
            radii: stroke.radii.clone(),
        }
    }

    fn is_image(&self, stroke: &Stroke, other: &Stroke) -> bool {
        let alike = other.letter != stroke.letter
            && other.attachment == stroke.attachment
            && other.points.len() == stroke.points.len()
            && other.handles == stroke.handles;
        alike
            && stroke
                .points
                .iter()
                .zip(&other.points)
                .all(|(&point, &other)| {
                    self.exact(point).distance(quantize::exact(other)) <= IMAGE_SLACK
                })
    }
}

impl Sketch {
    /// The branches that are images of a branch, each with how; every one once.
    pub(super) fn twins(&self, letter: Letter, symmetry: Symmetry) -> Vec<(Letter, Image)> {
        let mut twins: Vec<(Letter, Image)> = Vec::new();
        let Some(stroke) = self.stroke(letter).filter(|own| own.attachment.is_some()) else {
            return twins;
        };
        for image in symmetry.images() {
            let twin = self.strokes.iter().find(|other| {
                image.is_image(stroke, other)
                    && twins.iter().all(|&(taken, _)| taken != other.letter)
            });
            twins.extend(twin.map(|twin| (twin.letter, image)));
        }
        twins
    }

    /// What symmetry would add to a segment drawn from a node to a place: where each copy starts and ends, in the sketch.
    pub fn copies_of_segment(
        &self,
        from: NodeRef,
        to: Vec3,
        symmetry: Symmetry,
    ) -> impl Iterator<Item = [Vec3; 2]> + '_ {
        // A branch that is begun there, or the one that goes on; the trunk that goes on is neither.
        let goes_on = self.stroke(from.letter).filter(|_| self.is_apex(from));
        let at = goes_on.map_or(Some(from), |stroke| stroke.attachment);
        let start = at.and_then(|at| self.position(at));
        symmetry.images().filter_map(move |image| {
            let start = start?;
            let end = start + image.of(to - start);
            let Some(stroke) = goes_on else {
                return Some([start, end]);
            };
            let is_twin = |other: &&Arc<Stroke>| image.is_image(stroke, other);
            let twin = self.strokes.iter().find(is_twin)?;
            let apex = NodeRef::new(twin.letter, from.node);
            Some([self.position(apex)?, end])
        })
    }

    /// Adds the copies of a branch that has just been drawn; images that fall on each other are one.
    pub(super) fn add_copies(
        &mut self,
        of: &Arc<Stroke>,
        symmetry: Symmetry,
    ) -> Result<(), super::SketchError> {
        let mut made: Vec<Arc<Stroke>> = vec![Arc::clone(of)];
        // Looked for once: the preview makes all copies anew with each movement of the hand.
        let mut letters = self.free_letters().peekable();
        for image in symmetry.images() {
            let letter = *letters.peek().ok_or(super::change::NO_LETTER)?;
            let copy = image.of_stroke(of, letter);
            if made.iter().all(|other| other.points != copy.points) {
                letters.next();
                let copy = Arc::new(copy);
                made.push(Arc::clone(&copy));
                self.strokes.push(copy);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    fn trunk() -> (Sketch, NodeRef) {
        let up: Vec<Vec3> = (1..=4_u8).map(|n| Vec3::Y * 0.2 * f32::from(n)).collect();
        let (sketch, _) = Sketch::default().add_segments(NodeRef::ROOT, &up).unwrap();
        (sketch, NodeRef::new(Letter::TRUNK, 2))
    }

    #[test]
    fn a_branch_is_drawn_with_its_copies_and_goes_on_with_them() {
        let (sketch, at) = trunk();
        let symmetry = Symmetry {
            turns: 3,
            mirror: true,
        };
        let first = Vec3::new(0.2, 0.5, 0.05);
        let (sketch, apex) = sketch.draw_curve(at, &[first], &[1], symmetry).unwrap();
        assert_eq!(sketch.strokes.len(), 1 + 6);
        let further = Vec3::new(0.3, 0.7, 0.06);
        let (sketch, end) = sketch.draw_curve(apex, &[further], &[2], symmetry).unwrap();
        assert_eq!(end, NodeRef::new(apex.letter, 3));
        for stroke in &sketch.strokes[1..] {
            assert_eq!((stroke.points.len(), stroke.attachment), (3, Some(at)));
            let level = |at: Vec3| at.x.hypot(at.z);
            assert!((level(stroke.points[2]) - level(further)).abs() < 2e-4);
            assert!((stroke.points[2].y - 0.3).abs() < 1e-6);
        }
        let ends: std::collections::HashSet<[i32; 2]> = sketch.strokes[1..]
            .iter()
            .map(|stroke| {
                #[allow(clippy::cast_possible_truncation, reason = "small")]
                [stroke.points[2].x, stroke.points[2].z].map(|x| (x * 1e4).round() as i32)
            })
            .collect();
        assert_eq!(ends.len(), 6, "each stands elsewhere");
    }

    #[test]
    fn what_is_foretold_of_copies_is_what_is_drawn() {
        let (mut sketch, mut from) = trunk();
        let symmetry = Symmetry {
            turns: 3,
            mirror: true,
        };
        for to in [Vec3::new(0.2, 0.5, 0.05), Vec3::new(0.3, 0.7, 0.06)] {
            let told: Vec<_> = sketch.copies_of_segment(from, to, symmetry).collect();
            let (after, apex) = sketch.draw_curve(from, &[to], &[1], symmetry).unwrap();
            assert_eq!(told.len(), 5);
            for (stroke, [start, end]) in after.strokes[2..].iter().zip(told) {
                let drawn = |node| after.position(NodeRef::new(stroke.letter, node)).unwrap();
                assert!(drawn(apex.node).distance(end) < 2e-4);
                assert!(drawn(apex.node - 1).distance(start) < 2e-4);
            }
            (sketch, from) = (after, apex);
        }
        let top = sketch.apex(Letter::TRUNK).unwrap();
        let none = sketch.copies_of_segment(top, Vec3::Y, symmetry);
        assert_eq!(none.count(), 0, "the trunk has no copies");
    }

    #[test]
    fn images_that_fall_on_each_other_are_drawn_once() {
        let (sketch, at) = trunk();
        let both = Symmetry {
            turns: 2,
            mirror: true,
        };
        // In the mirror plane: its reflection is itself.
        let place = Vec3::new(0.0, 0.5, 0.2);
        let (plane, _) = sketch.draw_curve(at, &[place], &[1], both).unwrap();
        assert_eq!(plane.strokes.len(), 1 + 2);
        // Straight up: all are one.
        let up = Vec3::new(0.0, 0.9, 0.0);
        let (up, _) = sketch.draw_curve(at, &[up], &[1], both).unwrap();
        assert_eq!(up.strokes.len(), 1 + 1);
    }

    #[test]
    fn a_copy_that_was_moved_goes_its_own_way() {
        let (sketch, at) = trunk();
        let mirror = Symmetry {
            turns: 1,
            mirror: true,
        };
        let (sketch, apex) = sketch
            .draw_curve(at, &[Vec3::new(0.2, 0.5, 0.0)], &[1], mirror)
            .unwrap();
        let copy = NodeRef::new(sketch.strokes[2].letter, 1);
        let sketch = sketch.move_node(copy, Vec3::new(-0.3, 0.6, 0.0)).unwrap();
        let (sketch, _) = sketch
            .draw_curve(apex, &[Vec3::new(0.3, 0.7, 0.0)], &[1], mirror)
            .unwrap();
        let lengths = sketch.strokes.iter().map(|stroke| stroke.points.len());
        assert_eq!(lengths.collect::<Vec<_>>(), [4, 2, 1]);
    }

    #[test]
    fn the_trunk_has_no_copies() {
        let four = Symmetry {
            turns: 4,
            mirror: true,
        };
        let (sketch, _) = Sketch::default()
            .draw_curve(NodeRef::ROOT, &[Vec3::new(0.1, 0.4, 0.0)], &[4], four)
            .unwrap();
        assert_eq!(sketch.strokes.len(), 1);
    }

    #[test]
    fn absurd_symmetries_are_refused() {
        let (sketch, at) = trunk();
        for turns in [0, Symmetry::TURNS_MOST + 1, u32::MAX] {
            let symmetry = Symmetry {
                turns,
                mirror: false,
            };
            let error = sketch
                .draw_curve(at, &[Vec3::new(0.2, 0.5, 0.0)], &[1], symmetry)
                .unwrap_err();
            assert!(error.to_string().contains("symmetry"), "{error}");
        }
    }
}
