//! The window's eye: it goes round a point that it looks at, nearer and farther, and moves with that point.
//!
//! Pure: a few numbers in, a pose and rays out. The eye never stands on its head (its pitch is clamped short of straight down) and
//! never goes below the ground.

use std::f32::consts::FRAC_PI_2;

use glam::{Mat3, Quat, Vec2, Vec3};
use ramus_xr::{Fov, Pose, View};

/// How the eye moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraParams {
    /// Vertical field of view, radians.
    pub field: f32,
    /// Radians for a drag over the window's height.
    pub turn: f32,
    /// Part of the distance by which one notch of the wheel comes nearer.
    pub notch: f32,
    /// Nearest and farthest from the focus, metres.
    pub distance: [f32; 2],
    /// Steepest look down, radians.
    pub steepest: f32,
    /// Steepest look up, radians (negative).
    pub lowest: f32,
    /// Least height of the eye above the ground, metres.
    pub ground: f32,
    /// Farthest that the focus goes from the middle along one axis, metres.
    pub farthest: f32,
}

impl Default for CameraParams {
    fn default() -> Self {
        Self {
            field: 0.87,
            turn: 3.2,
            notch: 0.12,
            distance: [0.2, 80.0],
            steepest: FRAC_PI_2 - 0.05,
            lowest: -0.9,
            ground: 0.1,
            farthest: 30.0,
        }
    }
}

/// A ray on the stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Metres.
    pub origin: Vec3,
    /// Unit vector.
    pub direction: Vec3,
}

impl Ray {
    /// The point so many metres along.
    #[must_use]
    pub fn at(&self, along: f32) -> Vec3 {
        self.origin + self.direction * along
    }
}

/// The eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    params: CameraParams,
    /// What it looks at, metres on the stage.
    focus: Vec3,
    /// Where it stands round the focus, radians: 0 looks along −Z.
    yaw: f32,
    /// How steeply it looks down, radians.
    pitch: f32,
    /// Metres from the focus.
    distance: f32,
}

impl Default for Camera {
    fn default() -> Self {
        Self::at_work()
    }
}

impl Camera {
    /// Before the platform, the board at its right, the tree behind.
    #[must_use]
    pub fn at_work() -> Self {
        Self::looking(Vec3::new(0.2, 1.17, -0.6), 0.0, 0.2, 1.75)
    }

    /// Before a box, lowest and highest corner in metres, such that all of it is seen.
    #[must_use]
    pub fn before([low, high]: [Vec3; 2]) -> Self {
        let middle = (low + high) * 0.5;
        // Trees are rounder than their boxes: a ball a little within the corners is what is to be seen.
        let half = (high - low).length() * 0.5 * ROUND;
        let distance = half / (CameraParams::default().field * 0.5).sin();
        Self::looking(middle, 0.35, 0.08, distance)
    }

    /// An eye that looks at `focus` (metres) from a yaw and a pitch (radians) and a distance (metres).
    #[must_use]
    pub fn looking(focus: Vec3, yaw: f32, pitch: f32, distance: f32) -> Self {
        let mut camera = Self {
            params: CameraParams::default(),
            focus,
            yaw,
            pitch,
            distance,
        };
        camera.mend();
        camera
    }

    /// Brings everything back into its range.
    fn mend(&mut self) {
        let CameraParams {
            distance: [nearest, farthest],
            steepest,
            lowest,
            ground,
            farthest: around,
            ..
        } = self.params;
        let level = Vec3::new(around, 0.0, around);
        self.focus = self
            .focus
            .clamp(-level + Vec3::Y * ground, level + Vec3::Y * around);
        self.distance = self.distance.clamp(nearest, farthest);
        // The eye is at focus.y + sin(pitch) · distance.
        let above = ((ground - self.focus.y) / self.distance).clamp(-1.0, 1.0);
        self.pitch = self.pitch.clamp(lowest.max(above.asin()), steepest);
        self.yaw = self.yaw.rem_euclid(std::f32::consts::TAU);
    }

    /// Goes round the focus by a drag of so many pixels (right, down) in a window of this height.
    pub fn orbit(&mut self, by: Vec2, height_px: f32) {
        let turn = self.params.turn / height_px.max(1.0);
        self.yaw -= by.x * turn;
        self.pitch += by.y * turn;
        self.mend();
    }

    /// Moves eye and focus by a drag of so many pixels, so that what is at the focus stays under the cursor.
    pub fn pan(&mut self, by: Vec2, height_px: f32) {
        let metres = 2.0 * (self.params.field * 0.5).tan() * self.distance / height_px.max(1.0);
        let orientation = self.orientation();
        let right = orientation * Vec3::X;
        let up = orientation * Vec3::Y;
        self.focus += (up * by.y - right * by.x) * metres;
        self.mend();
    }

    /// Comes nearer by so many notches; negative: goes away.
    pub fn zoom(&mut self, notches: f32) {
        let factor = (1.0 - self.params.notch).powf(notches.clamp(-20.0, 20.0));
        self.distance *= factor;
        self.mend();
    }

    /// Unit vector from the focus to the eye.
    fn back(&self) -> Vec3 {
        let (sin, cos) = self.pitch.sin_cos();
        Vec3::new(self.yaw.sin() * cos, sin, self.yaw.cos() * cos)
    }

    fn orientation(&self) -> Quat {
        Quat::from_rotation_y(self.yaw) * Quat::from_rotation_x(-self.pitch)
    }

    /// Where the eye is and how it is turned.
    #[must_use]
    pub fn pose(&self) -> Pose {
        Pose {
            orientation: self.orientation(),
            position: self.focus + self.back() * self.distance,
        }
    }

    /// Unit vector into which the eye looks.
    #[must_use]
    pub fn forward(&self) -> Vec3 {
        -self.back()
    }

    /// Tangents of the half angles of a window of so many pixels: right, up.
    fn tangents(&self, size_px: Vec2) -> Vec2 {
        let up = (self.params.field * 0.5).tan();
        let size = size_px.max(Vec2::ONE);
        Vec2::new((up * size.x / size.y).min(MOST_TANGENT), up)
    }

    /// The field of view of a window of so many pixels.
    #[must_use]
    pub fn fov(&self, size_px: Vec2) -> Fov {
        let tangents = self.tangents(size_px);
        let [right, up] = [tangents.x.atan(), tangents.y.atan()];
        Fov {
            left: -right,
            right,
            up,
            down: -up,
        }
    }

    /// The eye in a window of so many pixels.
    #[must_use]
    pub fn view(&self, size_px: Vec2) -> View {
        View {
            pose: self.pose(),
            fov: self.fov(size_px),
        }
    }

    /// The ray through a pixel (from the left upper corner) of a window of so many pixels.
    #[must_use]
    pub fn ray(&self, cursor_px: Vec2, size_px: Vec2) -> Ray {
        let size = size_px.max(Vec2::ONE);
        let part = cursor_px / size * 2.0 - 1.0;
        let tangents = self.tangents(size_px);
        let Pose {
            orientation,
            position,
        } = self.pose();
        let ahead = Vec3::new(part.x * tangents.x, -part.y * tangents.y, -1.0);
        Ray {
            origin: position,
            direction: (orientation * ahead).normalize_or(Vec3::NEG_Z),
        }
    }
}

/// How far a tree fills the ball through its box's corners.
const ROUND: f32 = 0.85;

/// Tangent of the widest half angle (85°): a window may be very much wider than high.
const MOST_TANGENT: f32 = 11.4;

/// The orientation of something that points along `direction`, upright as far as that goes.
#[must_use]
pub fn pointing(direction: Vec3) -> Quat {
    let right = direction.cross(Vec3::Y).normalize_or(Vec3::X);
    let up = right.cross(direction);
    Quat::from_mat3(&Mat3::from_cols(right, up, -direction)).normalize()
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use proptest::prelude::*;

    use super::*;

    const SIZE: Vec2 = Vec2::new(1280.0, 800.0);

    /// Where a point is seen, pixels.
    fn seen(camera: &Camera, point: Vec3, size: Vec2) -> Vec2 {
        let Pose {
            orientation,
            position,
        } = camera.pose();
        let at = orientation.inverse() * (point - position);
        let fov = camera.fov(size);
        let part = Vec2::new(at.x / -at.z / fov.right.tan(), -at.y / -at.z / fov.up.tan());
        (part + 1.0) * 0.5 * size
    }

    #[test]
    fn it_looks_at_its_focus_and_keeps_its_distance() {
        let camera = Camera::looking(Vec3::new(0.1, 1.2, -0.5), 0.7, 0.3, 2.0);
        assert!((camera.pose().position.distance(camera.focus) - 2.0).abs() < 1e-5);
        assert!((camera.pose().orientation * Vec3::NEG_Z).distance(camera.forward()) < 1e-5);
        let middle = camera.ray(SIZE * 0.5, SIZE);
        assert!(middle.at(2.0).distance(camera.focus) < 1e-5);
        assert!(seen(&camera, camera.focus, SIZE).distance(SIZE * 0.5) < 1e-2);
    }

    #[test]
    fn what_is_dragged_follows_the_cursor() {
        let mut camera = Camera::at_work();
        let point = camera.focus;
        camera.pan(Vec2::new(100.0, -40.0), SIZE.y);
        let moved = seen(&camera, point, SIZE) - SIZE * 0.5;
        assert!(moved.distance(Vec2::new(100.0, -40.0)) < 1.0, "{moved}");
        let yaw = camera.yaw;
        // What is before the focus goes to the right with the hand: the eye goes to the left.
        let near = camera.focus - camera.forward() * 0.5;
        camera.orbit(Vec2::new(50.0, 0.0), SIZE.y);
        assert!(camera.yaw != yaw && seen(&camera, near, SIZE).x > SIZE.x * 0.5 + 10.0);
    }

    #[test]
    fn before_a_box_all_sides_of_it_are_seen() {
        for size in [0.5_f32, 3.0, 9.0] {
            let (middle, half) = (Vec3::new(0.0, size, -6.0), Vec3::splat(size));
            let camera = Camera::before([middle - half, middle + half]);
            for side in Vec3::AXES.into_iter().flat_map(|axis| [axis, -axis]) {
                let seen = seen(&camera, middle + half * side, SIZE);
                let inside = seen.cmpge(Vec2::ZERO).all() && seen.cmple(SIZE).all();
                assert!(inside, "{size} {side}: {seen}");
            }
        }
    }

    #[test]
    fn the_wheel_comes_nearer_and_back() {
        let mut camera = Camera::at_work();
        camera.zoom(3.0);
        assert!(camera.distance < 1.3);
        camera.zoom(-3.0);
        assert!((camera.distance - 1.75).abs() < 1e-4);
    }

    proptest! {
        #[test]
        fn no_drag_turns_it_over_or_puts_it_underground(
            drags in prop::collection::vec((0..3_u8, -3000.0_f32..3000.0, -3000.0_f32..3000.0), 1..30),
        ) {
            let mut camera = Camera::at_work();
            for (kind, x, y) in drags {
                match kind {
                    0 => camera.orbit(Vec2::new(x, y), 800.0),
                    1 => camera.pan(Vec2::new(x, y), 800.0),
                    _ => camera.zoom(x / 100.0),
                }
                let pose = camera.pose();
                prop_assert!(pose.is_sane() && camera.view(SIZE).fov.is_sane());
                prop_assert!((pose.orientation * Vec3::Y).y > 0.0, "upright: {camera:?}");
                prop_assert!(pose.position.y >= 0.099, "above the ground: {camera:?}");
            }
        }

        #[test]
        fn a_pixels_ray_goes_through_what_is_seen_there(
            x in 0.0_f32..1280.0, y in 0.0_f32..800.0, yaw in 0.0_f32..6.0, pitch in -0.3_f32..1.4, along in 0.5_f32..5.0,
        ) {
            let camera = Camera::looking(Vec3::new(0.0, 1.2, -0.6), yaw, pitch, 1.5);
            let cursor = Vec2::new(x, y);
            let ray = camera.ray(cursor, SIZE);
            prop_assert!(seen(&camera, ray.at(along), SIZE).distance(cursor) < 0.05);
            prop_assert!((pointing(ray.direction) * Vec3::NEG_Z).distance(ray.direction) < 1e-4);
        }
    }
}
