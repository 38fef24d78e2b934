//! How the hierarchy is gone through: what is nearer first, and what cannot matter any more not at all.
//!
//! Depth first with a stack of fixed size, the nearest child last on it and so first off it; what lies behind the best found so far is dropped
//! when its turn comes. A heap that always takes the nearest box visits a few nodes fewer and takes longer to keep.

use glam::{DVec3, Vec3};

use super::node::{Child, EMPTY, MARGIN, Node, Slopes};
use super::{DEPTH_MOST, Picker};

/// Entries of a stack: from each node on the way down, three stay behind.
const ROOM: usize = 3 * DEPTH_MOST + 4;

/// What is left to look at.
struct Stack {
    entries: [(u32, f32); ROOM],
    len: usize,
}

impl Stack {
    fn new() -> Self {
        Self {
            entries: [(EMPTY, 0.0); ROOM],
            len: 0,
        }
    }

    /// Children of a node with how far they are, the farthest first.
    #[inline]
    fn push(&mut self, children: &mut [(u32, f32)]) {
        // There are four at most: inserted one after the other.
        for last in 1..children.len() {
            let mut place = last;
            while place > 0 && children[place - 1].1 < children[place].1 {
                children.swap(place - 1, place);
                place -= 1;
            }
        }
        for child in children {
            // There is room, since hierarchies are not deeper than the limit.
            if let Some(entry) = self.entries.get_mut(self.len) {
                *entry = *child;
                self.len += 1;
            }
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<(u32, f32)> {
        self.len = self.len.checked_sub(1)?;
        self.entries.get(self.len).copied()
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "rounded up, so that nothing is dropped that is exactly as near"
)]
fn upwards(limit: f64) -> f32 {
    (limit as f32).next_up()
}

impl Picker {
    /// Calls `visit` with triangles whose boxes the ray meets, nearer ones first; it says up to where what follows still matters.
    #[inline]
    pub(super) fn along(
        &self,
        origin: Vec3,
        direction: DVec3,
        most: f32,
        mut visit: impl FnMut(u32, [Vec3; 3]) -> f64,
    ) {
        let slopes = Slopes::new(origin, direction);
        let mut limit = most.next_up();
        self.walk(
            &mut limit,
            |node, limit| node.on_ray(&slopes, limit),
            |number, corners| upwards(visit(number, corners)),
        );
    }

    /// Calls `visit` with triangles whose boxes are as near as the square of a distance; it says which square still matters.
    #[inline]
    pub(super) fn around(
        &self,
        point: Vec3,
        squared: f64,
        mut visit: impl FnMut(u32, [Vec3; 3]) -> f64,
    ) {
        let mut limit = upwards(squared);
        self.walk(
            &mut limit,
            |node, limit| {
                let distances = node.squared_distances(point);
                let mut met = 0;
                for (slot, distance) in distances.iter().enumerate() {
                    met |= u32::from(*distance <= limit * MARGIN) << slot;
                }
                (met, distances)
            },
            |number, corners| upwards(visit(number, corners)),
        );
    }

    #[inline]
    fn walk(
        &self,
        limit: &mut f32,
        test: impl Fn(&Node, f32) -> (u32, [f32; 4]),
        mut visit: impl FnMut(u32, [Vec3; 3]) -> f32,
    ) {
        let mut stack = Stack::new();
        let mut next = (!self.hierarchy.nodes.is_empty()).then_some((0, 0.0));
        while let Some((child, near)) = next {
            if near <= *limit * MARGIN {
                match Child::new(child) {
                    Child::Empty => {}
                    Child::Run { start, length } => {
                        let run = start as usize..(start + length) as usize;
                        let corners = &self.hierarchy.corners[run.clone()];
                        for (number, corners) in self.hierarchy.order[run].iter().zip(corners) {
                            *limit = visit(*number, *corners);
                        }
                    }
                    Child::Node(place) => {
                        let node = &self.hierarchy.nodes[place as usize];
                        let (mut met, nears) = test(node, *limit);
                        let mut children = [(EMPTY, 0.0); 4];
                        let mut count = 0;
                        while met != 0 {
                            let slot = met.trailing_zeros() as usize & 3;
                            met &= met - 1;
                            if node.children[slot] != EMPTY {
                                children[count & 3] = (node.children[slot], nears[slot]);
                                count += 1;
                            }
                        }
                        stack.push(&mut children[..count]);
                    }
                }
            }
            next = stack.pop();
        }
    }
}
