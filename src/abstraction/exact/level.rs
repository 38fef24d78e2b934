//! A tree by how each segment stands to the one before it, in the frames of a turtle that turns by `+` and `&` alone.
//!
//! Frames are carried along, not rolled by what grows there as those of [`super::frames`] are, so that nothing changes where branches are added.

use std::f64::consts::PI;

use glam::DQuat;
use hashbrown::HashMap;

use super::frames::wrapped;
use super::number::{Sample, groups, shortest};
use super::out::Out;
use super::shape::Shape;
use crate::tree::axes::Children;
use crate::tree::{NO_PARENT, Tree};

/// Parts of what is alike that numbers are rounded by.
const ROUNDED: f64 = 0.125;
/// Turns, and lengths as multiples, that differ: more than the largest template has.
const WAYS_MOST: usize = 256;

/// How a segment stands to the one before it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stance {
    /// Turns of the turtle, `+` and then `&`, radians.
    pub(super) yaw: f64,
    pub(super) pitch: f64,
    /// The logarithm of its length as a multiple.
    pub(super) longer: f64,
}

impl Stance {
    pub(super) fn is_like(self, other: Self, apart: f64) -> bool {
        let aside = wrapped(self.yaw - other.yaw).abs() * self.pitch.cos();
        let off = [self.pitch - other.pitch, self.longer - other.longer];
        aside <= apart && off.iter().all(|off| off.abs() <= apart)
    }
}

/// A tree of segments, each at its node; node 0 is the root and has none.
pub(super) struct Level {
    pub(super) parent: Vec<u32>,
    /// Without what its length is a multiple of.
    pub(super) turn: Vec<[f64; 2]>,
    pub(super) length: Vec<f64>,
    pub(super) children: Children,
}

/// Which nodes each has for children.
pub(super) fn children(parent: &[u32]) -> Children {
    Children::new(&Tree {
        parent: parent.iter().copied().collect(),
        ..Tree::default()
    })
}

impl Level {
    pub(super) fn new(parent: Vec<u32>, turn: Vec<[f64; 2]>, length: Vec<f64>) -> Self {
        Self {
            children: children(&parent),
            parent,
            turn,
            length,
        }
    }

    /// A shape as a turtle draws it that turns by `+` and `&`; none where it has several roots, or segments without length.
    pub(super) fn of(shape: &Shape) -> Option<Self> {
        let mut frame = vec![DQuat::IDENTITY; shape.len()];
        let (mut turn, mut length) = (vec![[0.0; 2]; shape.len()], vec![0.0; shape.len()]);
        for node in 1..shape.len() {
            let parent = shape.parent[node];
            let step = shape.step(u32::try_from(node).ok()?);
            length[node] = step.length();
            if parent == NO_PARENT || length[node] <= f64::EPSILON {
                return None;
            }
            let own = frame[parent as usize].inverse() * step / length[node];
            turn[node] = [(-own.x).atan2(own.y), -own.z.clamp(-1.0, 1.0).asin()];
            let [yaw, pitch] = turn[node];
            let by = DQuat::from_rotation_z(yaw) * DQuat::from_rotation_x(-pitch);
            frame[node] = (frame[parent as usize] * by).normalize();
        }
        Some(Self::new(shape.parent.clone(), turn, length))
    }

    pub(super) fn segments(&self) -> usize {
        self.parent.len() - 1
    }

    /// How a node's segment stands to another.
    pub(super) fn stance(&self, node: u32, to: u32) -> Stance {
        let [yaw, pitch] = self.turn[node as usize];
        let longer = (self.length[node as usize] / self.length[to as usize]).ln();
        Stance { yaw, pitch, longer }
    }

    /// How a segment stands to the turtle, with its own length.
    pub(super) fn placed(&self, node: u32) -> Stance {
        let [yaw, pitch] = self.turn[node as usize];
        let longer = self.length[node as usize].ln();
        Stance { yaw, pitch, longer }
    }

    /// Which parts are of one kind: how their segments stand to each other is alike. None where they stand in more ways than a rule makes.
    pub(super) fn kinds(&self, apart: f64) -> Option<Kinds> {
        let nodes: Vec<u32> = (1..).take(self.segments()).collect();
        let of = |value: &dyn Fn(Stance) -> f64| {
            let sample = |node: &u32| {
                let parent = self.parent[*node as usize];
                let stance = self.stance(*node, if parent == 0 { *node } else { parent });
                Sample {
                    value: value(stance),
                    weight: 1.0,
                }
            };
            let samples: Vec<Sample> = nodes.iter().map(sample).collect();
            let (of, numbers) = groups(&samples, apart);
            (numbers.len() <= WAYS_MOST).then_some(of)
        };
        // A turn by half a circle is one to either side.
        let yaw = of(&|stance| (stance.yaw + apart).rem_euclid(2.0 * PI))?;
        let (pitch, longer) = (of(&|stance| stance.pitch)?, of(&|stance| stance.longer)?);
        let mut known: HashMap<Vec<[u32; 4]>, u32> = HashMap::new();
        let mut kinds = Kinds {
            of: vec![0; self.parent.len()],
            segments: vec![1; self.parent.len()],
            first: Vec::new(),
        };
        for node in nodes.iter().rev() {
            let place = *node as usize;
            let mut key = Vec::new();
            for child in self.children.of(*node) {
                let at = *child as usize - 1;
                let kind = kinds.of[*child as usize];
                key.push([yaw[at], pitch[at], longer[at], kind]);
                kinds.segments[place] += kinds.segments[*child as usize];
            }
            let next = u32::try_from(kinds.first.len()).unwrap_or(u32::MAX);
            kinds.of[place] = *known.entry(key).or_insert(next);
            if kinds.of[place] == next {
                kinds.first.push(*node);
            }
        }
        Some(kinds)
    }
}

/// Parts of a tree by their kinds; a part is all that begins with a node's segment.
pub(super) struct Kinds {
    /// By node.
    pub(super) of: Vec<u32>,
    /// Segments of each node's part.
    pub(super) segments: Vec<usize>,
    /// A node of each kind.
    pub(super) first: Vec<u32>,
}

/// A turn in degrees and a multiple, with few digits.
pub(super) fn short(Stance { yaw, pitch, longer }: Stance, apart: f64) -> ([f64; 2], f64) {
    let degrees = |angle: f64| shortest(angle.to_degrees(), apart.to_degrees() * ROUNDED);
    let multiple = longer.exp();
    let multiple = shortest(multiple, multiple * apart * ROUNDED);
    ([degrees(yaw), degrees(pitch)], multiple)
}

/// Writes a turn of the turtle.
pub(super) fn turn(out: &mut Out, degrees: [f64; 2]) {
    for (sign, angle) in ["+", "&"].iter().zip(degrees) {
        if angle != 0.0 {
            out.module(sign, &[angle.to_string()]);
        }
    }
}
