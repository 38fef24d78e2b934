//! The drawn lines at full size: what the grammar's shapes say.
//!
//! Each branch is given in the frame of the segment it sits on, so that its first copy stands exactly where it was drawn.
//! A stroke's entry depends on the stroke, that frame and the scale; where none of them changed it stays, so that a
//! node that moves costs its own stroke and what turns with it.

use std::{collections::HashMap, sync::Arc};

use glam::{DQuat, DVec3, Vec3};

use super::{Letter, Sketch, Stroke, quantize};
use crate::lsystem::shape_frames;

/// Decimals of a displacement: 1 nm, so that a thousand segments end where they were drawn.
const DECIMALS: usize = 9;

/// One stroke.
#[derive(Clone, Debug)]
struct Entry {
    stroke: Arc<Stroke>,
    /// The frame of the segment that it sits on, in the sketch's axes.
    base: DQuat,
    /// From node to node, metres at full size in that frame, rounded to what the grammar says.
    displacements: Vec<DVec3>,
    /// The frame along each segment, in the sketch's axes.
    frames: Vec<DQuat>,
}

impl Entry {
    fn new(stroke: &Arc<Stroke>, base: DQuat, scale: f64) -> Self {
        let base_from_sketch = base.inverse();
        let mut below = DVec3::ZERO;
        let mut displacements = Vec::with_capacity(stroke.points.len());
        for point in stroke.points.iter().copied().map(quantize::exact) {
            displacements.push(rounded(base_from_sketch * (point - below) * scale));
            below = point;
        }
        let own = shape_frames(&displacements).into_iter();
        Self {
            stroke: Arc::clone(stroke),
            base,
            displacements,
            frames: own.map(|frame| (base * frame).normalize()).collect(),
        }
    }
}

/// The entries of a sketch, in the order drawn.
#[derive(Clone, Debug, Default)]
pub(super) struct Dictionary {
    scale: f64,
    entries: Vec<Entry>,
}

impl Dictionary {
    /// The dictionary of a sketch.
    pub(super) fn of(sketch: &Sketch) -> Self {
        let mut dictionary = Self::default();
        dictionary.follow(sketch);
        dictionary
    }

    /// Brings it up to a sketch; gives the places of entries that are not as they were.
    pub(super) fn follow(&mut self, sketch: &Sketch) -> Vec<usize> {
        let scale = quantize::exact(Vec3::splat(sketch.scale)).x;
        if self.scale != scale {
            (self.scale, self.entries) = (scale, Vec::new());
        }
        self.entries.truncate(sketch.strokes.len());
        let mut place_of: HashMap<Letter, usize> = HashMap::with_capacity(sketch.strokes.len());
        let mut changed = Vec::new();
        for (place, stroke) in sketch.strokes.iter().enumerate() {
            let base = stroke.attachment.and_then(|at| {
                let parent = self.entries.get(*place_of.get(&at.letter)?)?;
                parent.frames.get(at.node.checked_sub(1)? as usize).copied()
            });
            let base = base.unwrap_or(DQuat::IDENTITY);
            place_of.insert(stroke.letter, place);
            let stays = |entry: &Entry| entry.stroke == *stroke && entry.base == base;
            if self.entries.get(place).is_some_and(stays) {
                continue;
            }
            let entry = Entry::new(stroke, base, scale);
            match self.entries.get_mut(place) {
                Some(old) => *old = entry,
                None => self.entries.push(entry),
            }
            changed.push(place);
        }
        changed
    }

    /// Letter and displacements of the entry at a place.
    pub(super) fn get(&self, place: usize) -> Option<(Letter, &[DVec3])> {
        let entry = self.entries.get(place)?;
        Some((entry.stroke.letter, &entry.displacements))
    }

    /// All entries.
    pub(super) fn iter(&self) -> impl Iterator<Item = (Letter, &[DVec3])> {
        (0..self.entries.len()).filter_map(|place| self.get(place))
    }
}

/// What reading the grammar's text will give, so that frames are computed from the same numbers.
fn rounded(displacement: DVec3) -> DVec3 {
    let through_text = |value: f64| number(value).parse().unwrap_or(value);
    DVec3::new(
        through_text(displacement.x),
        through_text(displacement.y),
        through_text(displacement.z),
    )
}

/// A number with as many decimals as it needs, at most [`DECIMALS`].
pub(super) fn number(value: f64) -> String {
    let fixed = format!("{value:.DECIMALS$}");
    let short = fixed.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" {
        "0".to_owned()
    } else {
        short.to_owned()
    }
}
