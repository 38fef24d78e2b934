//! As what a cluster is drawn, by its size on the screen: tubes of 16, 8, 5 and 3 sides, then ribbons that face the eye; leaves as they are, then as kites.

use super::{BATCH, Cluster};

/// Kinds at most; those of one family have their table filled up with [`Kind::default`].
pub const KINDS: usize = 8;

/// No kind.
pub const NONE: u32 = u32::MAX;

/// Sides of tubes of each kind; 2: a ribbon.
pub const SIDES: [u32; 5] = [16, 8, 5, 3, 2];

/// The first kind of tubes' ends: cones of as many sides, of tubes of the first three kinds.
pub const ENDS: usize = SIDES.len();

/// A kind: `Kind` of shaders/crown.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Kind {
    /// Indices of a batch.
    pub indices: u32,
    /// The first of them.
    pub first: u32,
    /// It is drawn where the cluster's size is less than so many pixels; 0: it is no cluster's kind.
    pub below: f32,
    /// The kind of its ends, or [`NONE`].
    pub ends: u32,
}

impl Default for Kind {
    fn default() -> Self {
        Self {
            indices: 0,
            first: 0,
            below: 0.0,
            ends: NONE,
        }
    }
}

/// Pixels that a tube's width stays below in each kind.
pub const TUBES_BELOW: [f32; SIDES.len()] = [f32::INFINITY, 64.0, 24.0, 8.0, 3.0];

/// Pixels that a leaf's length stays below in each kind. A leaf longer than twelve bounds keeps its shape in files, too.
pub const LEAVES_BELOW: [f32; 2] = [f32::INFINITY, 12.0];

/// How a batch of segments is drawn as each kind: tubes of [`SIDES`], then their ends, with indices one after the other.
#[must_use]
pub fn of_tubes() -> [Kind; KINDS] {
    let mut kinds = [Kind::default(); KINDS];
    let tubes = SIDES.map(|sides| 6 * if sides == 2 { 1 } else { sides });
    let ends = SIDES.map(|sides| (3 * sides, 0.0));
    let each = tubes.into_iter().zip(TUBES_BELOW).chain(ends);
    let count = |n: usize| u32::try_from(n).unwrap_or(NONE);
    let mut first = 0;
    for (number, (kind, (indices, below))) in kinds.iter_mut().zip(each).enumerate() {
        *kind = Kind {
            indices: indices * count(BATCH),
            first,
            below,
            ends: if number < KINDS - ENDS {
                count(number + ENDS)
            } else {
                NONE
            },
        };
        first += kind.indices;
    }
    kinds
}

/// The kind of a cluster of so many pixels.
#[must_use]
pub fn kind_of(kinds: &[Kind; KINDS], pixels: f32) -> u32 {
    let among = (1_u32..).zip(kinds.iter().skip(1));
    among
        .filter(|(_, kind)| pixels < kind.below)
        .fold(0, |_, (number, _)| number)
}

/// Triangles of a cluster that is drawn as a kind.
#[must_use]
pub fn triangles(kinds: &[Kind; KINDS], cluster: &Cluster, kind: u32) -> u32 {
    let of = |kind: u32| kinds.get(kind as usize);
    let batch = |kind: u32| of(kind).map_or(0, |kind| kind.indices / 3);
    let ends = of(kind).map_or(0, |kind| batch(kind.ends));
    cluster.batches * batch(kind) + cluster.ends * ends
}
