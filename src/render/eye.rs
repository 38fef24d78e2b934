//! Eyes: where they are, what they see, and the matrices of both.

use glam::{Mat4, Quat, Vec3, Vec4};

pub use crate::world::scene::Pose;

/// Distance of the near plane in metres: close enough for a hand before the face.
/// Depth runs from 1 there to 0 at infinity.
pub const NEAR: f32 = 0.05;

/// Half angles in radians; left and down are usually negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fov {
    /// Left edge.
    pub left: f32,
    /// Right edge.
    pub right: f32,
    /// Upper edge.
    pub up: f32,
    /// Lower edge.
    pub down: f32,
}

impl Fov {
    /// The same angle on each side: `vertical` in all, `aspect` = width / height.
    pub fn symmetric(vertical: f32, aspect: f32) -> Self {
        let up = vertical / 2.0;
        let right = (up.tan() * aspect).atan();
        Self {
            left: -right,
            right,
            up,
            down: -up,
        }
    }

    /// Tangents left, right, up, down; a field that is no field (NaN, empty, inverted, beyond 89°) is mended to 90°,
    /// so that a runtime's bad frame gives a picture and no NaN.
    pub fn tangents(&self) -> [f32; 4] {
        const WIDEST: f32 = 1.553;
        let fine = |low: f32, high: f32| {
            low.is_finite()
                && high.is_finite()
                && low > -WIDEST
                && high < WIDEST
                && high - low > 1e-3
        };
        let [left, right] = if fine(self.left, self.right) {
            [self.left.tan(), self.right.tan()]
        } else {
            [-1.0, 1.0]
        };
        let [down, up] = if fine(self.down, self.up) {
            [self.down.tan(), self.up.tan()]
        } else {
            [-1.0, 1.0]
        };
        [left, right, up, down]
    }
}

/// One eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// The eye in the stage: looks along its −Z.
    pub world_from_eye: Pose,
    /// What it sees.
    pub fov: Fov,
}

impl Eye {
    /// An eye at `position` that looks at `target`, upright.
    pub fn looking_at(position: Vec3, target: Vec3, fov: Fov) -> Self {
        let forward = (target - position).normalize_or(Vec3::NEG_Z);
        let right = forward.cross(Vec3::Y).normalize_or(Vec3::X);
        let up = right.cross(forward);
        let orientation = Quat::from_mat3(&glam::Mat3::from_cols(right, up, -forward));
        Self {
            world_from_eye: Pose {
                orientation,
                position,
            },
            fov,
        }
    }

    /// Left and right eye about this one, `distance` metres apart (0.063 is usual).
    pub fn pair(self, distance: f32) -> [Self; 2] {
        [-0.5, 0.5].map(|side| {
            let mut eye = self;
            eye.world_from_eye.position +=
                self.world_from_eye.orientation * Vec3::X * (side * distance);
            eye
        })
    }

    /// World to the eye's frame.
    pub fn eye_from_world(&self) -> Mat4 {
        let pose = self.pose();
        Mat4::from_rotation_translation(pose.orientation, pose.position).inverse()
    }

    /// Eye to clip space: reversed infinite depth, y down as Vulkan has it.
    pub fn clip_from_eye(&self) -> Mat4 {
        let [left, right, up, down] = self.fov.tangents();
        let (width, height) = (right - left, up - down);
        Mat4::from_cols(
            Vec4::new(2.0 / width, 0.0, 0.0, 0.0),
            Vec4::new(0.0, -2.0 / height, 0.0, 0.0),
            Vec4::new((right + left) / width, -(up + down) / height, 0.0, -1.0),
            Vec4::new(0.0, 0.0, NEAR, 0.0),
        )
    }

    /// World to clip space.
    pub fn clip_from_world(&self) -> Mat4 {
        self.clip_from_eye() * self.eye_from_world()
    }

    /// The pose, mended where it is no pose.
    pub(crate) fn pose(&self) -> Pose {
        let pose = self.world_from_eye;
        let fine = pose.position.is_finite()
            && pose.orientation.is_finite()
            && pose.orientation.length_squared() > 1e-6;
        if fine {
            Pose {
                orientation: pose.orientation.normalize(),
                position: pose.position,
            }
        } else {
            Pose {
                orientation: Quat::IDENTITY,
                position: Vec3::new(0.0, 1.6, 0.0),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::*;

    const ASYMMETRIC: Fov = Fov {
        left: -0.9,
        right: 0.7,
        up: 0.8,
        down: -0.95,
    };

    fn ndc(eye: &Eye, point: Vec3) -> Vec3 {
        let clip = eye.clip_from_world() * point.extend(1.0);
        clip.truncate() / clip.w
    }

    #[test]
    fn edges_of_the_field_are_the_edges_of_the_picture() {
        let eye = Eye {
            world_from_eye: Pose {
                orientation: Quat::IDENTITY,
                position: Vec3::ZERO,
            },
            fov: ASYMMETRIC,
        };
        for distance in [NEAR, 1.0, 1000.0] {
            let at = |x: f32, y: f32| {
                ndc(
                    &eye,
                    Vec3::new(x.tan() * distance, y.tan() * distance, -distance),
                )
            };
            assert!((at(ASYMMETRIC.left, 0.0).x + 1.0).abs() < 1e-5);
            assert!((at(ASYMMETRIC.right, 0.0).x - 1.0).abs() < 1e-5);
            assert!(
                (at(0.0, ASYMMETRIC.up).y + 1.0).abs() < 1e-5,
                "up is the first row"
            );
            assert!((at(0.0, ASYMMETRIC.down).y - 1.0).abs() < 1e-5);
            assert!(
                (at(0.0, 0.0).z - NEAR / distance).abs() < 1e-6,
                "reversed: near / distance"
            );
        }
    }

    #[test]
    fn looking_at_puts_the_target_in_the_middle() {
        let fov = Fov::symmetric(1.0, 1.0);
        for target in [
            Vec3::NEG_Z,
            Vec3::X * 3.0,
            Vec3::new(1.0, -2.0, 5.0),
            Vec3::new(0.0, 9.0, 0.0),
        ] {
            let eye = Eye::looking_at(Vec3::ZERO, target, fov);
            let seen = ndc(&eye, target);
            assert!(seen.truncate().length() < 1e-5, "{target}: {seen}");
        }
    }

    #[test]
    fn nonsense_gives_numbers() {
        for bad in [f32::NAN, f32::INFINITY, 0.0] {
            let eye = Eye {
                world_from_eye: Pose {
                    orientation: Quat::from_xyzw(bad, 0.0, 0.0, 0.0),
                    position: Vec3::splat(bad),
                },
                fov: Fov {
                    left: bad,
                    right: bad,
                    up: bad,
                    down: bad,
                },
            };
            assert!(eye.clip_from_world().is_finite(), "{bad}");
        }
    }
}
