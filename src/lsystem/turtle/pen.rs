//! Where the turtle stands, how it is turned and what it draws with: what brackets save.
//!
//! Its frame is a unit quaternion whose own axes are X = right (−L), Y = heading H, Z = up U, so that the start (H = +Y, L = −X, U = +Z) is the
//! quaternion 1 and a shape's x, y, z are the stage's. `+` turns about U, `&` about L, `/` about H, all right-handed. Every few
//! turns the frame is brought back to length 1 by a Newton step, exact where the length is off by no more than rounding; positions are
//! summed in f64.

use glam::{DQuat, DVec3};

use super::action::{Axis, Half};
use crate::tree::NO_PARENT;

/// A heading whose horizontal part is shorter than this is vertical.
const VERTICAL: f64 = 1e-12;

/// No dictionary letter: there are fewer.
pub(super) const NO_SHAPE: u16 = u16::MAX;

// Up to here a pen is copied without a call.
const _: () = assert!(size_of::<Pen>() <= 120, "brackets save many pens");

/// Turns after which the frame is brought back to length 1: each rounds it by some 1e-16.
const TURNS: u8 = 16;

/// Whether the pen draws a generalized cylinder, between `@Gs` and `@Ge`. A branch in between is one of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cylinder {
    /// Each segment is a tube of its own kind.
    #[default]
    None,
    /// The next segment begins one.
    Begins,
    /// The next segment goes on with the one whose first segment ends at this node.
    Of(u32),
}

/// The turtle's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    /// Metres.
    pub position: DVec3,
    /// The stage from the turtle's own axes: X right, Y ahead, Z up.
    pub frame: DQuat,
    /// Metres, a diameter.
    pub width: f64,
    /// Strength of the tropism.
    pub tropism: f64,
    /// Multiplies the length of a step without a parameter.
    pub length_scale: f64,
    /// Multiplies the angle of a turn without a parameter.
    pub angle_scale: f64,
    /// The node at this position, or `NO_PARENT` after a move without drawing.
    pub node: u32,
    /// Brackets round it; 65535 where there are more.
    pub order: u16,
    /// Index of the colour, at first 0.
    pub colour: u16,
    /// Index of the material, at first 0.
    pub material: u16,
    /// Whether a generalized cylinder is drawn.
    pub cylinder: Cylinder,
    /// Turns since the frame was of length 1 to the last bit.
    turns: u8,
    /// The dictionary letter drawn last, if nothing else was drawn since; else [`NO_SHAPE`].
    pub(super) shape: u16,
    /// Its parameter.
    pub(super) segment: f64,
}

impl Pen {
    /// The turtle's start, with a width in metres.
    #[must_use]
    pub fn new(width: f64) -> Self {
        Self {
            position: DVec3::ZERO,
            frame: DQuat::IDENTITY,
            width,
            tropism: 0.0,
            length_scale: 1.0,
            angle_scale: 1.0,
            node: 0,
            order: 0,
            colour: 0,
            material: 0,
            cylinder: Cylinder::None,
            turns: 0,
            shape: NO_SHAPE,
            segment: 0.0,
        }
    }

    /// Where it stands and how it is turned.
    #[inline(always)]
    pub(super) fn stance(&self) -> Stance {
        Stance {
            position: self.position,
            frame: self.frame,
            turns: self.turns,
        }
    }

    /// Stands there.
    #[inline(always)]
    pub(super) fn stand(&mut self, stance: Stance) {
        self.position = stance.position;
        self.frame = stance.frame;
        self.turns = stance.turns;
    }

    /// Changes where it stands.
    #[inline(always)]
    pub(super) fn change<T>(&mut self, by: impl FnOnce(&mut Stance) -> T) -> T {
        let mut stance = self.stance();
        let given = by(&mut stance);
        self.stand(stance);
        given
    }

    /// The degrees of a turn without a parameter, where they are not the grammar's.
    #[expect(clippy::float_cmp, reason = "1 until something is multiplied")]
    #[inline]
    pub(super) fn scaled_turn(&self, degrees: f64) -> Option<f64> {
        (self.angle_scale != 1.0).then_some(degrees * self.angle_scale)
    }

    /// H, the direction of the next segment.
    #[must_use]
    #[inline(always)]
    pub fn heading(&self) -> DVec3 {
        self.stance().heading()
    }

    /// L.
    #[must_use]
    pub fn left(&self) -> DVec3 {
        self.frame * DVec3::NEG_X
    }

    /// U = H × L.
    #[must_use]
    pub fn up(&self) -> DVec3 {
        self.frame * DVec3::Z
    }

    /// Goes somewhere without drawing.
    #[inline(always)]
    pub(super) fn jump(&mut self, to: DVec3) {
        self.position = to;
        self.node = NO_PARENT;
        if let Cylinder::Of(_) = self.cylinder {
            self.cylinder = Cylinder::Begins;
        }
    }
}

/// Where a pen stands and how it is turned: what each module changes and the next one needs. Reading keeps it in registers.
#[derive(Clone, Copy)]
pub(super) struct Stance {
    pub(super) position: DVec3,
    frame: DQuat,
    turns: u8,
}

impl Stance {
    /// H.
    #[inline(always)]
    fn heading(&self) -> DVec3 {
        let DQuat { x, y, z, w } = self.frame;
        DVec3::new(
            2.0 * (x * y - w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z + w * x),
        )
    }

    /// The point so far ahead.
    #[inline(always)]
    pub(super) fn ahead(&self, length: f64) -> DVec3 {
        self.position + self.heading() * length
    }

    /// Turns about one of the turtle's own axes.
    #[inline(always)]
    pub(super) fn turn_about(&mut self, axis: Axis, half: Half) {
        self.set_frame(turned(self.frame, axis, half));
    }

    #[inline(always)]
    fn set_frame(&mut self, frame: DQuat) {
        self.frame = frame;
        self.turns += 1;
        if self.turns >= TURNS {
            self.turns = 0;
            self.frame = normal(frame);
        }
    }

    /// Where a segment of this length ends above a ground, for which the heading is lifted as far as it must be: a way down takes half of what is
    /// left of it, so that a bough that sinks comes to lie on the ground, and what begins below it goes no further down.
    pub(super) fn ahead_above(&mut self, length: f64, ground: f64) -> DVec3 {
        let end = self.ahead(length);
        let height = self.position.y;
        let lowest = height.min(f64::midpoint(height, ground));
        if end.y >= lowest || !end.is_finite() {
            return end;
        }
        let heading = self.heading();
        let aside = DVec3::new(heading.x, 0.0, heading.z).normalize_or(self.frame * DVec3::Z);
        let up = (lowest - height) / length;
        let lifted = aside * (1.0 - up * up).max(0.0).sqrt() + DVec3::Y * up;
        self.set_frame(DQuat::from_rotation_arc(heading, lifted) * self.frame);
        self.ahead(length)
    }

    /// Turns by a rotation in the turtle's own axes.
    #[inline(always)]
    pub(super) fn turn(&mut self, by: DQuat) {
        self.set_frame(self.frame * by);
    }

    /// Half a turn about U.
    #[inline(always)]
    pub(super) fn turn_around(&mut self) {
        let DQuat { x, y, z, w } = self.frame;
        self.frame = DQuat::from_xyzw(y, -x, w, -z);
    }

    /// Rolls so that L is horizontal and U is not below it; a vertical heading stays as it is.
    #[inline(always)]
    pub(super) fn level(&mut self) {
        let DQuat { x, y, z, w } = self.frame;
        // How high the ends of the own axes X and Z (U) lie; a roll by φ makes them cos φ·right − sin φ·up, which is to be 0, and
        // sin φ·right + cos φ·up, which is to be above 0.
        let right = 2.0 * (x * y + w * z);
        let up = 2.0 * (y * z - w * x);
        let level = (right * right + up * up).sqrt();
        if level < VERTICAL {
            return;
        }
        // Half the angle, by that one of two formulas which does not cancel.
        let (sin, cos) = if up >= 0.0 {
            (right, level + up)
        } else {
            (level - up, right)
        };
        // The square of their length, by which the turned frame is divided.
        let square = 2.0 * level * (level + up.abs());
        self.set_frame(
            turned(self.frame, Axis::Heading, Half { sin, cos }) * (1.0 / square.sqrt()),
        );
    }

    /// Turns the heading toward a vector T by e·|H × T| radians (ABOP, section 2.1), e being the strength of the tropism.
    #[inline(always)]
    pub(super) fn bend(&mut self, vector: DVec3, tropism: f64) {
        let torque = self.heading().cross(vector);
        let half = tropism * 0.5;
        // The square of half the angle.
        let square = half * half * torque.length_squared();
        let by = if square <= SMALL_SQUARE {
            let (sine, cosine) = small_half(square);
            let axis = torque * (half * sine);
            DQuat::from_xyzw(axis.x, axis.y, axis.z, cosine)
        } else {
            let strength = torque.length();
            DQuat::from_axis_angle(torque / strength, tropism * strength)
        };
        self.set_frame(by * self.frame);
    }
}

/// Up to this square of half an angle, 0.4 radians, a few terms of the series say sine and cosine to the last bit, with neither a
/// root nor a division: a tropism bends each segment.
const SMALL_SQUARE: f64 = 0.16;

/// sin(√x)/√x and cos √x for x up to [`SMALL_SQUARE`]: the first terms left out are x⁷/15! and x⁸/16!, below 1e-17.
#[inline]
fn small_half(x: f64) -> (f64, f64) {
    // Horner's scheme; from one factorial to the next is that many times.
    let series = |steps: [f64; 7]| {
        steps
            .iter()
            .rev()
            .fold(1.0, |sum, step| 1.0 - sum * (x * step))
    };
    let sine = series([6.0, 20.0, 42.0, 72.0, 110.0, 156.0, 210.0].map(f64::recip));
    let cosine = series([2.0, 12.0, 30.0, 56.0, 90.0, 132.0, 182.0].map(f64::recip));
    (sine, cosine)
}

/// A frame turned about one of its own axes.
#[inline(always)]
fn turned(frame: DQuat, axis: Axis, Half { sin, cos }: Half) -> DQuat {
    let DQuat { x, y, z, w } = frame;
    match axis {
        Axis::X => DQuat::from_xyzw(
            x * cos + w * sin,
            y * cos + z * sin,
            z * cos - y * sin,
            w * cos - x * sin,
        ),
        Axis::Heading => DQuat::from_xyzw(
            x * cos - z * sin,
            y * cos + w * sin,
            z * cos + x * sin,
            w * cos - y * sin,
        ),
        Axis::Up => DQuat::from_xyzw(
            x * cos + y * sin,
            y * cos - x * sin,
            z * cos + w * sin,
            w * cos - z * sin,
        ),
    }
}

/// A quaternion that is all but of length 1, of length 1.
#[inline(always)]
fn normal(q: DQuat) -> DQuat {
    q * (1.5 - 0.5 * q.length_squared())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// A segment is as long above a ground as without one, turns no further than it must, and goes down by half of what is left at most.
        #[test]
        fn segments_come_to_lie_on_the_ground(
            turn in prop::array::uniform3(-7.0_f64..7.0),
            height in -2.0_f64..2.0,
            ground in -1.0_f64..1.0,
            length in -3.0_f64..3.0,
        ) {
            let [x, y, z] = turn;
            let mut stance = Pen::new(1.0).stance();
            stance.turn(DQuat::from_euler(glam::EulerRot::YXZ, y, x, z));
            stance.position.y = height;
            let free = stance.ahead(length);
            let (before, from) = (stance, stance.position);
            let end = stance.ahead_above(length, ground);
            let lowest = height.min(f64::midpoint(height, ground));
            prop_assert!(end.y >= lowest - 1e-9, "{} below {lowest}", end.y);
            prop_assert!((end.distance(from) - length.abs()).abs() < 1e-9);
            prop_assert!((stance.frame.length() - 1.0).abs() < 1e-9);
            if free.y >= lowest {
                prop_assert_eq!((end, stance.frame), (free, before.frame));
            } else {
                prop_assert!((end.y - lowest).abs() < 1e-9);
                // In the upright plane of the way that it would have gone.
                let [to, was] = [end, free].map(|at| at - from);
                prop_assert!(to.cross(was).y.abs() < 1e-9 && to.dot(DVec3::new(was.x, 0.0, was.z)) >= -1e-9);
            }
        }
    }

    #[test]
    fn straight_down_is_lifted_and_what_is_no_number_is_left() {
        let mut stance = Pen::new(1.0).stance();
        stance.turn(DQuat::from_rotation_x(std::f64::consts::PI));
        let end = stance.ahead_above(2.0, 0.0);
        assert!(
            end.y.abs() < 1e-12 && (end.length() - 2.0).abs() < 1e-12,
            "{end}"
        );
        for (length, ground) in [
            (f64::INFINITY, 0.0),
            (1.0, f64::NAN),
            (f64::NAN, 0.0),
            (1e308, 1e308),
        ] {
            let mut stance = Pen::new(1.0).stance();
            let _ = stance.ahead_above(length, ground);
            assert!(stance.frame.is_finite(), "{length} {ground}");
        }
    }

    #[test]
    fn small_angles_are_turned_by_as_by_large_ones() {
        for step in 0..=1000 {
            let half = 0.4 * f64::from(step) / 1000.0;
            let (sine, cosine) = small_half(half * half);
            let expected = if half == 0.0 { 1.0 } else { half.sin() / half };
            assert!((sine - expected).abs() <= 2.3e-16, "sin {half}: {sine}");
            assert!(
                (cosine - half.cos()).abs() <= 2.3e-16,
                "cos {half}: {cosine}"
            );
        }
        // On both sides of the bound a bend is that of its axis and angle.
        for strength in [0.0, 1e-9, 0.3, 0.799, 0.801, 2.0, -0.5, -3.0] {
            let mut pen = Pen::new(1.0);
            pen.change(|stance| stance.turn(DQuat::from_rotation_x(0.7)));
            let torque = pen.heading().cross(DVec3::X);
            let angle = strength * torque.length();
            let expected = DQuat::from_axis_angle(torque.normalize(), angle) * pen.frame;
            pen.change(|stance| stance.bend(DVec3::X, strength));
            let off = (pen.frame - expected).length();
            assert!(off < 1e-15, "{strength}: {off}");
        }
    }
}
