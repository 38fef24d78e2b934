//! Tapered tubes whose rings join: the tree as the GPU draws it and as files hold it.

use bytemuck::{Pod, Zeroable};

/// One segment of a tube, as the vertex shader (`shaders/tree.wgsl`) and its CPU twin read it: 80 bytes.
///
/// A segment continues its parent's tube when both records hold the same ring (same point,
/// frame and radius, bit for bit), so no crack can open. Growth is a shader parameter g in 0…1:
/// a point p of a growing segment stands at `base + g·(p − base)`, and each radius is
/// `mix(before, after, g)`; whole segments have `GROWING` unset and stay where they are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct TubeSegment {
    /// Centre of the first ring, metres.
    pub from: [f32; 3],
    /// Length along the tube at the first ring in metres: the texture's v.
    pub v: f32,
    /// Centre of the second ring.
    pub to: [f32; 3],
    /// Bit 0 ([`GROWING`]): part of the newest step. Bit 1 ([`CAPPED`]): the tube ends here. Bits 16…31: letter.
    pub flags: u32,
    /// The nearest whole ancestor's position, from which a growing segment unfolds.
    pub base: [f32; 3],
    /// Spare, 0.
    pub pad: u32,
    /// First ring's radius before and after the newest step, second ring's before and after.
    pub radii: [f32; 4],
    /// First ring's frame: quaternion x y z w as snorm16; turns +Y into the tube's direction, +X into the ring's first point.
    pub from_frame: [i16; 4],
    /// Second ring's frame.
    pub to_frame: [i16; 4],
}

/// Flag of a segment that is part of the newest step.
pub const GROWING: u32 = 1;
/// Flag of a segment that ends its tube.
pub const CAPPED: u32 = 2;

const _: () = assert!(
    size_of::<TubeSegment>() == 80,
    "shaders/tree.wgsl reads 80 bytes"
);
