//! Flat pictures that the runtime itself puts before the eyes, at its own resolution: text in them stays sharper than in a picture that
//! is drawn into the scene, since it is sampled once and not twice.
//!
//! ```text
//! make_quad(pixels) ─▶ QuadId ─ quad_images ─▶ images to draw into
//! each frame: begin ─ acquire_quad ─▶ which image ─ draw ─ place_quad ─ end (releases it, shows all placed quads)
//! ```
//!
//! A quad shows its newest picture for as long as it is placed: it need be acquired only when the picture changes. Quads lie above the
//! scene in the order in which they were made, and nothing of the scene hides them: they are for panels, not for things.

use crate::frame::Pose;
pub use crate::vulkan::QuadImages;

/// A quad of a headset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct QuadId(usize);

impl QuadId {
    /// The quad that a headset made as its `number`-th, from 0: headsets alone make them.
    #[must_use]
    pub const fn new(number: usize) -> Self {
        Self(number)
    }

    /// Its number.
    #[must_use]
    pub const fn number(self) -> usize {
        self.0
    }
}

/// Most quads that a headset shows.
pub const MOST_QUADS: usize = 8;

/// Where a quad is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadPlace {
    /// Its middle, in the stage's frame; the picture faces along +Z and its upper edge is at +Y.
    pub pose: Pose,
    /// Width and height in metres.
    pub size: [f32; 2],
}

/// A quad larger than this many metres is a mistake.
const LARGEST: f32 = 100.0;

impl QuadPlace {
    /// A sane pose, and a size above 0 that is not absurd.
    #[must_use]
    pub fn is_sane(&self) -> bool {
        let sized = |length: &f32| *length > 0.0 && *length <= LARGEST;
        self.pose.is_sane() && self.size.iter().all(sized)
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "the table says what it expects"
    )]

    use glam::Vec3;

    use super::*;

    #[test]
    fn sizes_and_poses_are_sane_or_not() {
        let far = Pose {
            position: Vec3::splat(f32::NAN),
            ..Pose::IDENTITY
        };
        for (pose, size, sane) in [
            (Pose::IDENTITY, [0.8, 0.5], true),
            (Pose::IDENTITY, [0.0, 0.5], false),
            (Pose::IDENTITY, [0.8, -0.5], false),
            (Pose::IDENTITY, [f32::NAN, 0.5], false),
            (Pose::IDENTITY, [0.8, f32::INFINITY], false),
            (far, [0.8, 0.5], false),
        ] {
            assert_eq!(
                QuadPlace { pose, size }.is_sane(),
                sane,
                "{pose:?} {size:?}"
            );
        }
    }
}
