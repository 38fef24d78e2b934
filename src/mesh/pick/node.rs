//! Four boxes at a time, and what rays and points ask of them.
//!
//! Boxes are tested in single precision and never miss what the exact test would reach: distances along a ray carry a relative error of a few
//! roundings, and so they are compared with a margin of more than that (Ize 2013, "Robust BVH Ray Traversal"). Nothing depends on the model's
//! size or on how far the ray begins from it.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3, Vec4};

/// No child.
pub(super) const EMPTY: u32 = u32::MAX;
/// Set in children that are runs of triangles.
const RUN: u32 = 1 << 31;
/// Where the length of a run stands, less one.
const LENGTH: u32 = 29;
/// Most triangles of one run.
pub(super) const RUN_MOST: u32 = 4;
/// Most triangles that can be numbered.
pub(super) const TRIANGLES_MOST: usize = (1 << LENGTH) - 8;

/// More than all roundings of a box test together, relative to the distance.
pub(super) const MARGIN: f32 = 1.0 + 2e-6;
/// Directions are taken for zero below this, where one over them would not be finite.
const FLAT: f32 = 1e-30;
/// Stands for the distance to where a ray leaves a slab that it runs along: more than any model is long.
const SLACK: f32 = 1e25;

/// Boxes of four children, side by side so that one instruction works on all.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Node {
    /// Smallest x of each, smallest y, smallest z.
    min: [Vec4; 3],
    /// Largest.
    max: [Vec4; 3],
    /// What is in each; see [`Child`].
    pub(super) children: [u32; 4],
}

/// What a child's number says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    /// Nothing.
    Empty,
    /// A node.
    Node(u32),
    /// So many triangles from a place on in the hierarchy's order.
    Run { start: u32, length: u32 },
}

impl Child {
    #[inline]
    pub(super) fn new(number: u32) -> Self {
        match number {
            EMPTY => Self::Empty,
            node if node & RUN == 0 => Self::Node(node),
            run => Self::Run {
                start: run & ((1 << LENGTH) - 1),
                length: (run >> LENGTH & 3) + 1,
            },
        }
    }

    pub(super) fn number(self) -> u32 {
        match self {
            Self::Empty => EMPTY,
            Self::Node(node) => node,
            Self::Run { start, length } => RUN | (length.clamp(1, RUN_MOST) - 1) << LENGTH | start,
        }
    }
}

/// A box around nothing.
pub(super) const NOTHING: [Vec3; 2] = [Vec3::INFINITY, Vec3::NEG_INFINITY];

/// The box around two.
pub(super) fn union([min, max]: [Vec3; 2], [other_min, other_max]: [Vec3; 2]) -> [Vec3; 2] {
    [min.min(other_min), max.max(other_max)]
}

impl Node {
    /// A node whose boxes are not known yet.
    pub(super) fn new(children: [u32; 4]) -> Self {
        let mut node = Self {
            min: [Vec4::ZERO; 3],
            max: [Vec4::ZERO; 3],
            children,
        };
        (0..4).for_each(|slot| node.set_bounds(slot, NOTHING));
        node
    }

    /// Sets the box of a child.
    pub(super) fn set_bounds(&mut self, slot: usize, [min, max]: [Vec3; 2]) {
        for axis in 0..3 {
            self.min[axis][slot] = min[axis];
            self.max[axis][slot] = max[axis];
        }
    }

    /// The box around all children.
    pub(super) fn bounds(&self) -> [Vec3; 2] {
        [
            Vec3::from(self.min.map(|four| four.min_element())),
            Vec3::from(self.max.map(|four| four.max_element())),
        ]
    }

    /// Which boxes a ray meets up to a distance, as bits, and where it enters them.
    #[inline]
    pub(super) fn on_ray(&self, ray: &Slopes, most: f32) -> (u32, [f32; 4]) {
        let (mut near, mut far) = (Vec4::ZERO, Vec4::splat(most));
        for axis in 0..3 {
            let (first, last) = match ray.backwards[axis] {
                true => (self.max[axis], self.min[axis]),
                false => (self.min[axis], self.max[axis]),
            };
            let (from, inverse) = (
                Vec4::splat(ray.origin[axis]),
                Vec4::splat(ray.inverse[axis]),
            );
            let slack = Vec4::splat(ray.slack[axis]);
            near = near.max((first - from) * inverse - slack);
            far = far.min((last - from) * inverse + slack);
        }
        (near.cmple(far * MARGIN).bitmask(), near.to_array())
    }

    /// The square of the distance from a point to each box, within the margin.
    #[inline]
    pub(super) fn squared_distances(&self, point: Vec3) -> [f32; 4] {
        let mut sum = Vec4::ZERO;
        for axis in 0..3 {
            let at = Vec4::splat(point[axis]);
            let out = (self.min[axis] - at)
                .max(at - self.max[axis])
                .max(Vec4::ZERO);
            sum += out * out;
        }
        sum.to_array()
    }
}

/// A ray as boxes need it.
pub(super) struct Slopes {
    origin: [f32; 3],
    /// One over the direction.
    inverse: [f32; 3],
    /// The ray goes to smaller coordinates.
    backwards: [bool; 3],
    /// [`SLACK`] where the ray runs along the axis' slabs: then it is in a box that it touches, where zero over zero would say nothing.
    slack: [f32; 3],
}

impl Slopes {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "rounding is within the margin"
    )]
    pub(super) fn new(origin: Vec3, direction: DVec3) -> Self {
        let direction = direction.to_array().map(|along| along as f32);
        let flat = direction.map(|along| along.abs() < FLAT);
        Self {
            origin: origin.to_array(),
            inverse: [0, 1, 2].map(|axis| match flat[axis] {
                true => f32::MAX,
                false => 1.0 / direction[axis],
            }),
            backwards: [0, 1, 2].map(|axis| !flat[axis] && direction[axis] < 0.0),
            slack: flat.map(|flat| if flat { SLACK } else { 0.0 }),
        }
    }
}
