//! Fewer leaves: every second one goes, and its neighbour grows so that the crown stays as dense as it was.
//!
//! A leaf of length s that stands for n has a length of √n·s and is taken for off by n·s/4, as [`thin`](super::super::foliage) has it: half of the leaves
//! are left where a leaf is two pixels long, a fourth where it is one.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::{Levels, Record, mark};

/// A placed surface: `Leaf` of shaders/leaf.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Leaf {
    /// Where it hangs, in the tree's frame.
    pub place: [f32; 3],
    /// How far its surface's farthest corner is from there, metres: the device has surfaces whose farthest corner is at 1. Negative: it is turned over.
    pub scale: f32,
    /// Where it unfolds from while it grows; `place` itself where it is whole.
    pub base: [f32; 3],
    /// The number of its look.
    pub look: u32,
    /// A quaternion, four snorm16.
    pub orientation: [i16; 4],
    /// Of the sky's light, 0 to 1.
    pub light: f32,
    /// Bit 0: it grows. Bits 8…15 ([`LARGER_SHIFT`]): how much larger it is than a leaf, where it stands for others, too.
    pub flags: u32,
}

/// Bits to shift [`Leaf::flags`] right by to get how much larger it is than a leaf: sixteenths of powers of two, up to 255. It is lit where the leaf is, since
/// what is larger stands out of the shadow of the others.
pub const LARGER_SHIFT: u32 = 8;
const LARGER: u32 = 0xff << LARGER_SHIFT;

/// All leaves of one surface in levels of detail.
pub type LeafLevels = Levels<Leaf>;

const _: () = assert!(size_of::<Leaf>() == 48, "shaders/leaf.wgsl reads 48 bytes");

/// Parts of a leaf's length that half of the leaves may be off by, twice.
const PART: f32 = 0.25;

impl Record for Leaf {
    fn corners(&self) -> [Vec3; 2] {
        let [place, base] = [self.place, self.base].map(Vec3::from);
        let reach = self.size();
        [place.min(base) - reach, place.max(base) + reach]
    }

    fn size(&self) -> f32 {
        self.scale.abs()
    }

    fn ends(&self) -> bool {
        false
    }

    fn mark(&self) -> u64 {
        mark(self.place)
    }

    /// How many leaves it stands for.
    const NOTE: f32 = 1.0;

    fn halve(run: &mut Vec<(Self, f32)>, most: usize) -> f32 {
        let mut worst = 0.0_f32;
        while run.len() > most {
            let surplus = (run.len() - most).min(run.len() / 2);
            let count = run.len();
            // Pairs that become one, evenly among all.
            let mut gone = 0;
            let mut at = 0;
            let mut left = Vec::with_capacity(most);
            while let Some(one) = run.get(at).copied() {
                let next = run.get(at + 1).copied();
                at += 1;
                let due = gone < surplus && gone * count <= at * surplus;
                left.push(match next.filter(|_| due) {
                    Some(next) => {
                        at += 1;
                        gone += 1;
                        let both = together(one, next);
                        worst = worst.max(both.0.size() * both.1.sqrt() * PART);
                        both
                    }
                    None => one,
                });
            }
            *run = left;
        }
        worst
    }
}

/// One leaf for two: the larger one, as wide as both.
fn together((one, many): (Leaf, f32), (other, more): (Leaf, f32)) -> (Leaf, f32) {
    let (mut leaf, smaller) = if one.size() < other.size() {
        (other, one)
    } else {
        (one, other)
    };
    let size = leaf.size().hypot(smaller.size());
    leaf.flags = larger(leaf.flags, size / leaf.size());
    leaf.scale = size.copysign(leaf.scale);
    leaf.light = f32::midpoint(one.light, other.light);
    (leaf, many + more)
}

/// A leaf's flags when it is so much larger.
fn larger(flags: u32, factor: f32) -> u32 {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "1 at least, of two leaves without size no number, and `as` makes 0 of that"
    )]
    let more = (16.0 * factor.log2()).round() as u32;
    let all = ((flags & LARGER) >> LARGER_SHIFT).saturating_add(more);
    flags & !LARGER | all.min(0xff) << LARGER_SHIFT
}
