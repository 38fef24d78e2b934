//! What a person may set about drawing: plain data for a panel, all of it off or standard at first.
//!
//! It belongs to the hands and not to the document: an edit carries what it was made with, so
//! undo, files and journals know nothing of these.

use crate::sketch::{FreehandParams, Symmetry};

use super::marks::Measuring;
use super::tools::DrawParams;
use crate::mesh::endpoints::Kind;

/// What the trigger does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DrawTool {
    /// It draws.
    #[default]
    Draw,
    /// It deletes the node that it is pulled at, and each that the tip touches while it is held.
    Erase,
    /// It sets endpoints on scanned models.
    Mark,
    /// It measures on scanned models.
    Measure(Measuring),
    /// It chooses branches of centerlines.
    Branch,
    /// It plants trees on the ground.
    Plant,
}

/// How drawing acts. Lengths are metres in the hand, on the stage: a larger platform draws more finely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawSettings {
    /// What the trigger does.
    pub tool: DrawTool,
    /// Distance between the nodes of a free-hand stroke, 0.01 to 0.5 m.
    pub spacing: f32,
    /// How far a free-hand stroke may be from its handles' polyline, 0 to 0.1 m: more gives fewer handles.
    pub tolerance: f32,
    /// How much a free-hand stroke is smoothed, 0 (nothing) to 1.
    pub smoothing: f32,
    /// A new segment that is almost at a multiple of this to the segment below it, or to the vertical, is turned there;
    /// degrees, 5 to 90. None: off.
    pub snap_angle_deg: Option<f32>,
    /// Whether what is drawn or moved near the plane x = 0 of the sketch is put onto it.
    pub snap_mirror: bool,
    /// How many times a branch is drawn around the vertical, itself counted: 1 (off) to 16.
    pub symmetry: u32,
    /// Whether a branch is drawn with its mirror image in the plane x = 0 of the sketch.
    pub mirror_symmetry: bool,
    /// What the next endpoint on a scanned model is.
    pub next_end: Kind,
    /// Whether endpoints snap to the middle of the tube that they are on.
    pub snap_ends: bool,
    /// Distance between trees that one pull plants, 0.3 to 20 m at full size.
    pub plant_spacing: f32,
    /// By what part of its size a planted tree is larger or smaller at most, 0 to 0.6.
    pub plant_vary: f32,
}

impl Default for DrawSettings {
    fn default() -> Self {
        Self {
            tool: DrawTool::Draw,
            spacing: 0.04,
            tolerance: 0.004,
            smoothing: 0.5,
            snap_angle_deg: None,
            snap_mirror: false,
            symmetry: 1,
            mirror_symmetry: false,
            next_end: Kind::Source,
            snap_ends: true,
            plant_spacing: 4.0,
            plant_vary: 0.2,
        }
    }
}

impl DrawSettings {
    /// Smallest and largest spacing, metres.
    pub const SPACING: [f32; 2] = [0.01, 0.5];
    /// Smallest and largest tolerance, metres.
    pub const TOLERANCE: [f32; 2] = [0.0, 0.1];
    /// Smallest and largest snapping angle, degrees.
    pub const SNAP_ANGLE_DEG: [f32; 2] = [5.0, 90.0];

    /// Smallest and largest distance between planted trees, metres.
    pub const PLANT_SPACING: [f32; 2] = [0.3, 20.0];
    /// Smallest and largest variation of their size.
    pub const PLANT_VARY: [f32; 2] = [0.0, 0.6];

    /// These within their bounds; what is no number becomes the default.
    #[must_use]
    pub fn checked(&self) -> Self {
        let default = Self::default();
        let within = |value: f32, default: f32, [least, most]: [f32; 2]| match value.is_nan() {
            true => default,
            false => value.clamp(least, most),
        };
        Self {
            spacing: within(self.spacing, default.spacing, Self::SPACING),
            tolerance: within(self.tolerance, default.tolerance, Self::TOLERANCE),
            smoothing: within(self.smoothing, default.smoothing, [0.0, 1.0]),
            snap_angle_deg: self
                .snap_angle_deg
                .filter(|angle| !angle.is_nan())
                .map(|angle| within(angle, angle, Self::SNAP_ANGLE_DEG)),
            plant_spacing: within(
                self.plant_spacing,
                default.plant_spacing,
                Self::PLANT_SPACING,
            ),
            plant_vary: within(self.plant_vary, default.plant_vary, Self::PLANT_VARY),
            symmetry: self.symmetry.clamp(1, Symmetry::TURNS_MOST),
            ..*self
        }
    }

    /// The copies of a branch.
    pub(super) fn copies(&self) -> Symmetry {
        Symmetry {
            turns: self.symmetry,
            mirror: self.mirror_symmetry,
        }
    }

    /// How a path in a sketch becomes a curve, where a metre of the sketch is `scale` metres in the hand.
    pub(super) fn freehand(&self, draw: &DrawParams, scale: f32) -> FreehandParams {
        let in_sketch = |metres: f32| metres / scale;
        let snap = if self.snap_mirror {
            draw.snap_distance
        } else {
            0.0
        };
        FreehandParams {
            sample: in_sketch(draw.sample),
            spacing: in_sketch(self.spacing),
            tolerance: in_sketch(self.tolerance),
            smoothing: self.smoothing,
            reach: in_sketch(draw.smoothing_reach),
            snap: in_sketch(snap),
            ..FreehandParams::default()
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    #[test]
    fn everything_is_off_at_first_and_absurd_settings_are_brought_within_bounds() {
        let default = DrawSettings::default();
        assert_eq!(default.checked(), default);
        assert!(default.copies().is_off() && default.snap_angle_deg.is_none());
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e30] {
            let absurd = DrawSettings {
                spacing: value,
                tolerance: value,
                smoothing: value,
                snap_angle_deg: Some(value),
                plant_spacing: value,
                plant_vary: value,
                symmetry: 0,
                ..default
            };
            let checked = absurd.checked();
            assert!((0.01..=0.5).contains(&checked.spacing), "{value}");
            assert!((0.0..=0.1).contains(&checked.tolerance), "{value}");
            assert!((0.0..=1.0).contains(&checked.smoothing), "{value}");
            assert!((0.3..=20.0).contains(&checked.plant_spacing), "{value}");
            assert!((0.0..=0.6).contains(&checked.plant_vary), "{value}");
            assert!(
                checked
                    .snap_angle_deg
                    .is_none_or(|angle| (5.0..=90.0).contains(&angle))
            );
            assert_eq!((checked.symmetry, checked.checked()), (1, checked));
        }
    }
}
