//! Which clusters are drawn, of trees and of models: what shaders/crown.wgsl and shaders/select.wgsl work out on the device, in plain Rust, as their
//! oracle.
//!
//! A cluster's errors are projected to pixels as the nearer eye sees them. Sizes of pixels are not compared as they are but in [`bin`]s of an eighth of
//! an octave, so that the triangles drawn at each threshold can be counted in one pass: a cluster adds its triangles at its own bin and takes them away at
//! its parents'. The smallest threshold from one pixel up whose triangles fit the budget is taken for all trees and models.
//!
//! Distances count from the eye and not along its axis, so that a turn of the head changes no level.

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec3, Vec4};

/// How many thresholds there are.
pub const BINS: usize = 128;
/// The coarsest threshold; what is beyond counts as this.
pub const COARSEST: u32 = 127;
/// The bin of what nothing replaces.
pub const NEVER: u32 = 255;

/// Both eyes: `Views` of shaders/shared/choice.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Views {
    /// Of each eye the planes at the picture's four edges: normals inwards and distances.
    pub planes: [[Vec4; 4]; 2],
    /// xyz: the eye; w: pixels that a metre has at a metre's distance.
    pub eyes: [Vec4; 2],
}

const _: () = assert!(
    size_of::<Views>() == 160,
    "shaders/shared/choice.wgsl reads 160 bytes"
);

/// A model or a tree as it stands: what the device is told of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Model to world: a similarity.
    pub world_from_model: Affine3A,
    /// Its scale.
    pub scale: f32,
    /// What lies in front of this plane is cut away; all zero: nothing is.
    pub cut: Vec4,
    /// Whether each triangle has its own look, so that the grain counts and not the error.
    pub by_grain: bool,
    /// Nothing is nearer than this, metres.
    pub near: f32,
    /// What the wind may move it by, metres: it is seen where it may be, and as fine as where it rests.
    pub sway: f32,
}

impl Standing {
    /// Of a model at such a place.
    #[must_use]
    pub fn new(world_from_model: Affine3A, cut: Vec4, by_grain: bool, near: f32) -> Self {
        let axes = world_from_model.matrix3;
        let scale = axes
            .x_axis
            .length()
            .max(axes.y_axis.length())
            .max(axes.z_axis.length());
        Self {
            world_from_model,
            scale,
            cut,
            by_grain,
            near,
            sway: 0.0,
        }
    }

    /// The bins of a cluster's own error and of its parents', each with the sphere that it counts from; none where neither eye sees the cluster's own
    /// sphere. `parent`: none where nothing replaces it.
    #[must_use]
    pub fn bins(
        &self,
        sphere: Vec4,
        own: (Vec4, f32),
        parent: Option<(Vec4, f32)>,
        views: &Views,
    ) -> Option<[u32; 2]> {
        if !self.is_seen(sphere, views) {
            return None;
        }
        let bin = |(sphere, error): (Vec4, f32)| bin(self.pixels(sphere, error, views));
        Some([bin(own), parent.map_or(NEVER, bin)])
    }

    /// Whether either eye sees anything of a sphere.
    #[must_use]
    pub fn is_seen(&self, sphere: Vec4, views: &Views) -> bool {
        let middle = self.world_from_model.transform_point3(sphere.truncate());
        let radius = sphere.w * self.scale + self.sway;
        let within = |plane: &Vec4| plane.truncate().dot(middle) + plane.w >= -radius;
        let normal = self.cut.truncate();
        let left = normal.dot(middle) - self.cut.w <= radius * normal.length();
        let sees = |planes: &[Vec4; 4]| planes.iter().all(within);
        left && views.planes.iter().any(sees)
    }

    /// A length at a sphere's nearest point in pixels.
    #[must_use]
    pub fn pixels(&self, sphere: Vec4, error: f32, views: &Views) -> f32 {
        let middle = self.world_from_model.transform_point3(sphere.truncate());
        let radius = sphere.w * self.scale;
        let seen = |eye: &Vec4| {
            let far = (middle.distance(eye.truncate()) - radius).max(self.near);
            error * self.scale * eye.w / far
        };
        seen(&views.eyes[0]).max(seen(&views.eyes[1]))
    }
}

/// How many pixels, in eighths of octaves: the first bin whose [`pixels`] are no fewer. From the bits of the number, so that it never falls where the
/// number grows.
#[must_use]
pub fn bin(size: f32) -> u32 {
    const EIGHTH: u32 = 1 << 20;
    let above = size.to_bits().saturating_sub(1.0_f32.to_bits());
    // No number and a negative one have the highest bits.
    above.div_ceil(EIGHTH).min(COARSEST)
}

/// The pixels that a bin stands for.
#[must_use]
pub fn pixels(bin: u32) -> f32 {
    f32::from_bits(1.0_f32.to_bits() + (bin.min(COARSEST) << 20))
}

/// Whether a cluster is drawn at a threshold.
#[must_use]
pub fn is_drawn([own, parent]: [u32; 2], threshold: u32) -> bool {
    own <= threshold && threshold < parent
}

/// Triangles are counted in so many, a cluster's rounded up, so that their sum fits 32 bits whatever stands there.
pub const COUNTED_IN: u32 = 8;

/// The smallest threshold whose triangles fit the budget. `clusters`: bins and triangles.
#[must_use]
pub fn threshold(clusters: impl Iterator<Item = ([u32; 2], u32)>, budget: u32) -> u32 {
    let mut changes = [0_i64; BINS];
    for ([own, parent], triangles) in clusters {
        for (bin, change) in [(own, 1), (parent, -1)] {
            if let Some(place) = changes.get_mut(bin as usize) {
                *place += change * i64::from(triangles.div_ceil(COUNTED_IN));
            }
        }
    }
    let mut drawn = 0;
    for (bin, change) in (0..).zip(changes) {
        drawn += change;
        if drawn <= i64::from(budget / COUNTED_IN) {
            return bin;
        }
    }
    COARSEST
}

/// A plane through `eye` with its normal towards `inwards`, spanned by two directions.
#[must_use]
pub fn side(eye: Vec3, one: Vec3, other: Vec3, inwards: Vec3) -> Vec4 {
    let normal = one.cross(other).normalize_or_zero();
    let normal = if normal.dot(inwards) < 0.0 {
        -normal
    } else {
        normal
    };
    normal.extend(-normal.dot(eye))
}
