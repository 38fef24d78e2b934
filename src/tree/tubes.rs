//! Tapered tubes whose rings join: the tree as the GPU draws it and as files hold it.
//!
//! ```text
//!        ○  CAPPED: cone on the last ring
//!       ╱ ╲
//!  ────┤   ├──── ring shared by a segment and the axis child that continues it, in the plane that halves the bend
//!      │ ╭─┼──── STARTS: a lateral begins with a ring of its own, round the node on its parent's axis
//!      │ │ │
//!  ────┤   ├────
//! ```
//!
//! One record a segment, made once for each step by [`SegmentBuilder`]; the vertex shader (`shaders/tree.wgsl`) and
//! [`super::mesh`](mod@super::mesh) (its CPU twin, used for export and as the oracle of image tests) expand it by one formula, written down
//! in [`super::mesh`](mod@super::mesh). Growth is a parameter of that formula, so nothing is uploaded while a tree grows.
//!
//! **Frames** are rotation-minimizing along each tube: every bend applies the smallest rotation between the two directions, so
//! texture and ring corners never twist or flip (a fixed up vector would on vertical strokes; Frenet frames would at
//! inflections). The ring at a bend stands half-way. The ring is round in that plane, so a bend of angle θ thins the tube by
//! cos(θ/2) in the plane of the bend, where a true mitre's ellipse would be as wide as the tube but shoot out a spike
//! of 1/cos(θ/2) at sharp bends. Beyond [`SHARP_BEND_COSINE`] (120°) the tube ends with a cap and a new one starts at
//! the same node, as a snapped and regrown twig does: no pinch, no spike, and nothing undefined at 180°.
//!
//! **Tips** taper: the segment that ends in a tip narrows to [`TIP`] of its radius there, and the cap makes it a point, as
//! shoots are. Only what is drawn and meshed does so; the tree's radii, and files that hold nodes (SWC), stay as they are.
//!
//! A lateral begins round the node itself, in the middle of its parent's tube, and no thicker than the
//! parent is there: its open side is always buried.

use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};
use rayon::prelude::*;

pub use super::mesh::{TubeMesh, mesh};
use super::{NO_PARENT, Tree, axes};

/// One segment of a tube, as the vertex shader (`shaders/tree.wgsl`) and its CPU twin read it: 80 bytes.
///
/// A segment continues its parent's tube when both records hold the same ring (same point,
/// frame and radius, bit for bit), so no crack can open. Growth is a shader parameter g in 0…1:
/// a point p of a growing segment stands at `base + g·(p − base)` (p itself where g ≥ 1), and each radius is
/// `before + g·(after − before)` (after itself where g ≥ 1); whole segments have `GROWING` unset and stay where they are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct TubeSegment {
    /// Centre of the first ring, metres.
    pub from: [f32; 3],
    /// The texture's v at the first ring: length along the tube, in circumferences of the tube where it runs, so that a texture
    /// is never stretched however thin the tube gets. Does not change while the tree grows.
    pub v_from: f32,
    /// Centre of the second ring.
    pub to: [f32; 3],
    /// Bit 0 ([`GROWING`]): part of the newest step. Bit 1 ([`CAPPED`]): the tube ends here.
    /// Bit 2 ([`STARTS`]): the tube begins here. Bit 3 ([`PAINTED`]): bits 16…31 are a look's number and not the letter. Bits 4…11 ([`WIDER_SHIFT`]): how
    /// much wider than its twig it is, where it stands for others, too.
    pub flags: u32,
    /// The nearest whole ancestor's position, from which a growing segment unfolds (of a whole segment: its own second point).
    pub base: [f32; 3],
    /// The texture's v at the second ring.
    pub v_to: f32,
    /// First ring's radius before and after the newest step, second ring's before and after.
    pub radii: [f32; 4],
    /// First ring's frame: quaternion x y z w as snorm16; turns +Y into the tube's direction, +X into the ring's first point.
    pub from_frame: [i16; 4],
    /// Second ring's frame.
    pub to_frame: [i16; 4],
}

/// Flag of a segment that is part of the newest step.
pub const GROWING: u32 = 1;
/// Flag of a segment that ends its tube: a cone closes the second ring.
pub const CAPPED: u32 = 2;
/// Flag of a segment that starts its tube: a disc closes the first ring.
pub const STARTS: u32 = 4;
/// Flag of a segment with a look of its own, whose number then stands in the place of its letter.
pub const PAINTED: u32 = 8;
/// Bits to shift [`TubeSegment::flags`] right by to get how much wider a segment is than its twig: sixteenths of powers of two, up to 255. By it a coarser
/// level's segment has the colour that its twig has.
pub const WIDER_SHIFT: u32 = 4;
/// Bits to shift [`TubeSegment::flags`] right by to get the letter.
pub const LETTER_SHIFT: u32 = 16;

/// A bend whose cosine is smaller (sharper than 120°) ends the tube and starts a new one.
pub const SHARP_BEND_COSINE: f32 = -0.5;

/// How much of its radius a tip keeps.
pub const TIP: f32 = 0.2;

/// Marks of a node that bears a child, that bears one that is whole, and that is whole itself.
const BEARS: u8 = 1;
const BORE: u8 = 2;
const WHOLE: u8 = 4;

/// A segment shorter than this in metres has no direction of its own and takes its parent's.
const SHORTEST: f32 = 1e-9;

/// Squares of lengths up to this are far from the end of f32.
const LARGEST_SQUARE: f32 = 1e36;

/// A segment never counts for more circumferences than this in v, however thin it is.
const MOST_TURNS: f32 = 1000.0;

const _: () = assert!(
    size_of::<TubeSegment>() == 80,
    "shaders/tree.wgsl reads 80 bytes"
);

/// What the builder keeps for a node until its children are done.
#[derive(Clone, Copy, Debug)]
struct Work {
    /// Frame of the segment that ends here: turns +Y into `direction`.
    frame: Quat,
    /// Unit direction of the segment that ends here.
    direction: Vec3,
    /// v of the ring at this node.
    v: f32,
    /// The shared ring's frame.
    ring: [i16; 4],
    /// Nearest whole node at or below this one.
    base: u32,
    /// Whether this node's segment continues its parent's tube; `frame` and `direction` are then known before its turn.
    continues: bool,
}

/// Trees of up to so many nodes are worked on by the thread that asks: a frame may wait for them, and must not wait for what other threads have taken on.
const ALONE: usize = 1 << 17;

/// Bytes that the making of segments takes for each node: the segment itself and all that is kept on the way.
pub const NODE_BYTES: usize =
    size_of::<TubeSegment>() + size_of::<Work>() + 5 * size_of::<u32>() + size_of::<u8>();

/// Makes segments, keeping its scratch memory, so that a warm call allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct SegmentBuilder {
    axis: Vec<u32>,
    work: Vec<Work>,
    marks: Vec<u8>,
    /// The nodes at which segments end.
    ends: Vec<u32>,
}

/// Writes the segments of a valid tree into `out` (cleared first), one for each node that has a parent, in the order of nodes.
///
/// `radius_before`: radius of each node one step earlier (see [`super::radii::da_vinci`]); where it is shorter than the tree
/// the radius did not change. `newest`: the step whose segments grow (see [`super::growth`]).
pub fn segments(tree: &Tree, radius_before: &[f32], newest: u32, out: &mut Vec<TubeSegment>) {
    SegmentBuilder::default().build(tree, radius_before, newest, out);
}

impl SegmentBuilder {
    /// [`segments`] with this builder's scratch memory.
    pub fn build(
        &mut self,
        tree: &Tree,
        radius_before: &[f32],
        newest: u32,
        out: &mut Vec<TubeSegment>,
    ) {
        let unborn = Work {
            frame: Quat::IDENTITY,
            direction: Vec3::Y,
            v: 0.0,
            ring: pack_frame(Quat::IDENTITY),
            base: 0,
            continues: false,
        };
        axes::axis_children_into(tree, &mut self.axis);
        self.work.clear();
        self.work.resize(tree.len(), unborn);
        self.mark(tree, newest);
        self.turn(tree, newest);
        self.ends.clear();
        let ends = (0_u32..).zip(&tree.parent);
        self.ends.extend(
            ends.filter(|(_, parent)| **parent != NO_PARENT)
                .map(|(node, _)| node),
        );
        let segment = |node: &u32| self.segment(tree, radius_before, *node);
        if tree.len() > ALONE {
            self.ends.par_iter().map(segment).collect_into_vec(out);
        } else {
            out.clear();
            out.extend(self.ends.iter().map(segment));
        }
    }

    /// Finds from the roots up what each node's tube goes on with.
    fn turn(&mut self, tree: &Tree, newest: u32) {
        for (node, &parent) in tree.parent.iter().enumerate() {
            #[allow(
                clippy::cast_possible_truncation,
                reason = "a valid tree's indices fit u32"
            )]
            let index = node as u32;
            if parent == NO_PARENT {
                self.work[node].base = index;
                continue;
            }
            let below = parent as usize;
            let under = self.work[below];
            let [from, to] = [tree.position[below], tree.position[node]];
            let mut work = self.work[node];
            let whole = tree.birth[node] < newest && under.base == parent;
            work.base = if whole { index } else { under.base };
            let mut v_from = under.v;
            if !work.continues {
                work.direction = direction(from, to).unwrap_or(under.direction);
                work.frame = (Quat::from_rotation_arc(under.direction, work.direction)
                    * under.frame)
                    .normalize();
                v_from = 0.0;
            }
            // Of the radii without their taper, which goes away when the tip grows on.
            let end = tree.radius[node];
            let start = self.start(index, parent, tree.radius[below], end);
            work.v = v_from + circumferences(from.distance(to), start + end);

            // The ring at the end: half-way into the next segment's direction, where one goes on.
            let next = self.axis[node];
            let mut end_frame = work.frame;
            if next != NO_PARENT {
                let onward = direction(to, tree.position[next as usize]).unwrap_or(work.direction);
                if work.direction.dot(onward) > SHARP_BEND_COSINE {
                    let half = half_bend(work.direction, onward);
                    end_frame = half * work.frame;
                    let after = &mut self.work[next as usize];
                    after.continues = true;
                    after.direction = onward;
                    after.frame = (half * end_frame).normalize();
                }
            }
            work.ring = pack_frame(end_frame);
            self.work[node] = work;
        }
    }

    /// A segment's radius where it starts: that of the node below it, on a side branch no more than its own.
    fn start(&self, node: u32, parent: u32, below: f32, own: f32) -> f32 {
        if self.axis[parent as usize] == node {
            below
        } else {
            below.min(own)
        }
    }

    /// The segment that ends at a node.
    fn segment(&self, tree: &Tree, radius_before: &[f32], index: u32) -> TubeSegment {
        let node = index as usize;
        let parent = tree.parent[node];
        let below = parent as usize;
        let (work, under) = (&self.work[node], &self.work[below]);
        let before = |node: usize| {
            let known = radius_before.get(node);
            known.copied().unwrap_or(tree.radius[node])
        };
        let tapered = |node: usize, mark: u8, radius: f32| match self.marks[node] & mark {
            0 => radius * TIP,
            _ => radius,
        };
        let [then, now] = [before(node), tree.radius[node]];
        let start = |radius: f32, own: f32| self.start(index, parent, radius, own);
        let radii = [
            start(tapered(below, BORE, before(below)), then),
            start(tree.radius[below], now),
            tapered(node, BORE, then),
            tapered(node, BEARS, now),
        ];
        let mut flags = u32::from(tree.letter[node]) << LETTER_SHIFT;
        if work.base != index {
            flags |= GROWING;
        }
        let (from_frame, v_from) = if work.continues {
            (under.ring, under.v)
        } else {
            flags |= STARTS;
            (pack_frame(work.frame), 0.0)
        };
        let next = self.work.get(self.axis[node] as usize);
        if !next.is_some_and(|next| next.continues) {
            flags |= CAPPED;
        }
        TubeSegment {
            from: tree.position[below].to_array(),
            v_from,
            to: tree.position[node].to_array(),
            flags,
            base: tree.position[work.base as usize].to_array(),
            v_to: work.v,
            radii,
            from_frame,
            to_frame: work.ring,
        }
    }
}

impl SegmentBuilder {
    /// Of each node of the tree that was built last the child that continues its axis, or [`NO_PARENT`].
    #[must_use]
    pub fn axis(&self) -> &[u32] {
        &self.axis
    }

    /// Finds which nodes are tips, now and one step earlier. A root is none: its ring is a foot.
    fn mark(&mut self, tree: &Tree, newest: u32) {
        self.marks.clear();
        self.marks.resize(tree.len(), 0);
        for (node, &parent) in tree.parent.iter().enumerate() {
            if parent == NO_PARENT {
                self.marks[node] = BEARS | BORE | WHOLE;
                continue;
            }
            let whole = tree.birth[node] < newest && self.marks[parent as usize] & WHOLE != 0;
            self.marks[node] = if whole { WHOLE } else { 0 };
            self.marks[parent as usize] |= if whole { BEARS | BORE } else { BEARS };
        }
    }
}

/// Unit vector from one point to another, or `None` where they coincide (or lie too far apart for f32).
fn direction(from: Vec3, to: Vec3) -> Option<Vec3> {
    let difference = to - from;
    let squared = difference.length_squared();
    if (SHORTEST * SHORTEST..=LARGEST_SQUARE).contains(&squared) {
        return Some(difference / squared.sqrt());
    }
    // Scaled first, so that a huge square does not overflow.
    let size = difference.abs().max_element();
    (size > SHORTEST && size.is_finite()).then(|| (difference / size).normalize())
}

/// Rotation by half the angle from one unit vector to another; they must not be opposite.
fn half_bend(from: Vec3, to: Vec3) -> Quat {
    // The quaternion (from × to, 1 + from·to) turns `from` into `to`; with the vector half-way in the place of `to`
    // it turns half as far.
    let between = (from + to).normalize();
    let axis = from.cross(between);
    Quat::from_xyzw(axis.x, axis.y, axis.z, 1.0 + from.dot(between)).normalize()
}

/// A length in circumferences of a tube whose two end radii have this sum.
fn circumferences(length: f32, sum_of_radii: f32) -> f32 {
    // Mean circumference 2π·(r₀ + r₁)/2.
    let circumference = std::f32::consts::PI * sum_of_radii;
    if length <= circumference * MOST_TURNS {
        if length > 0.0 {
            length / circumference
        } else {
            0.0
        }
    } else {
        MOST_TURNS
    }
}

/// A unit quaternion as four snorm16.
fn pack_frame(frame: Quat) -> [i16; 4] {
    // Rounded by hand: `round` is a call into the C library on x86-64 without SSE 4.1.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "lies within ±32767.5, and `as` saturates"
    )]
    frame
        .to_array()
        .map(|part| (part * f32::from(i16::MAX) + 0.5_f32.copysign(part)) as i16)
}

/// The unit quaternion that [`TubeSegment::from_frame`] and [`TubeSegment::to_frame`] hold.
pub fn unpack_frame(packed: [i16; 4]) -> Quat {
    Quat::from_array(packed.map(|part| f32::from(part) / f32::from(i16::MAX))).normalize()
}
