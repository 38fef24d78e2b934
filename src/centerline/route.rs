//! Ways from ball to ball, from the source to each target, as one tree.
//!
//! The cheapest ways by Dijkstra's algorithm. A step costs its length in radii, to a power above one: many short steps are cheaper
//! than a long one, so that ways in one tube run through the same balls, and thin places and walls are dear, as with VMTK's ∫ ds / R.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::atomic::{AtomicBool, Ordering};

use super::cover::Cover;
use super::skin::Ball;
use crate::mesh::report::NONE;

/// Power of a step's length in radii.
const POWER: f64 = 1.25;
/// Nearer than so many radii of the smaller ball, two balls are in one tube.
const SAME: f64 = 0.4;
/// If their radii are to each other as so much, or nearer.
const ALIKE: f64 = 0.75;
/// Steps between two looks at whether to stop.
const STEPS: usize = 1 << 12;

/// Balls in a tree: each stands behind its parent, the source is the first.
#[derive(Clone, Debug, Default)]
pub(super) struct Skeleton {
    pub(super) balls: Vec<Ball>,
    /// [`NONE`] for the first.
    pub(super) parent: Vec<u32>,
    /// The node where each target's way ends; None where there is no way.
    pub(super) ends: Vec<Option<u32>>,
}

/// The balls before each on the cheapest way, and what the way costs. None when `cancel` was set.
fn cheapest(cover: &Cover, source: u32, cancel: &AtomicBool) -> Option<(Vec<u32>, Vec<f64>)> {
    let mut costs = vec![f64::INFINITY; cover.balls.len()];
    let mut before = vec![NONE; cover.balls.len()];
    let mut heap = BinaryHeap::from([Reverse((0_u64, source))]);
    costs[source as usize] = 0.0;
    let mut steps = 0_usize;
    while let Some(Reverse((bits, at))) = heap.pop() {
        steps += 1;
        if steps.is_multiple_of(STEPS) && cancel.load(Ordering::Relaxed) {
            return None;
        }
        let cost = f64::from_bits(bits);
        if cost > costs[at as usize] {
            continue;
        }
        let here = cover.balls[at as usize];
        for next in &cover.links[at as usize] {
            let there = cover.balls[*next as usize];
            let thinner = here.radius.min(there.radius);
            let step = (here.centre.distance(there.centre) / thinner).powf(POWER);
            // Balls in one place are not free, or ways would go round in them.
            let farther = cost + step + 1e-9;
            if farther < costs[*next as usize] {
                costs[*next as usize] = farther;
                before[*next as usize] = at;
                heap.push(Reverse((farther.to_bits(), *next)));
            }
        }
    }
    Some((before, costs))
}

impl Skeleton {
    /// The ways from a ball to others. None when `cancel` was set.
    pub(super) fn new(
        cover: &Cover,
        source: u32,
        targets: &[Option<u32>],
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let (before, costs) = cheapest(cover, source, cancel)?;
        let mut skeleton = Self {
            balls: vec![cover.balls[source as usize]],
            parent: vec![NONE],
            ends: vec![None; targets.len()],
        };
        let mut node_of = vec![NONE; cover.balls.len()];
        node_of[source as usize] = 0;
        // The farthest first; places make the order one.
        let reached = targets.iter().enumerate().filter_map(|(one, ball)| {
            let ball = (*ball)?;
            let cost = costs[ball as usize];
            cost.is_finite().then_some((one, ball, cost))
        });
        let mut order: Vec<(usize, u32, f64)> = reached.collect();
        let place = |ball: u32| cover.balls[ball as usize].centre.to_array();
        order.sort_by(|(_, one, cost), (_, other, other_cost)| {
            let places = place(*one).into_iter().zip(place(*other));
            let places = places.map(|(a, b)| a.total_cmp(&b));
            let by_place = places.reduce(std::cmp::Ordering::then);
            other_cost
                .total_cmp(cost)
                .then(by_place.unwrap_or(std::cmp::Ordering::Equal))
        });
        for (one, target, _) in order {
            let (mut way, mut at) = (Vec::new(), target);
            let mut node = loop {
                if let Some(node) = skeleton.same_place(cover, at, &node_of) {
                    break node;
                }
                way.push(at);
                at = before[at as usize];
            };
            for ball in way.into_iter().rev() {
                let parent = node;
                node = u32::try_from(skeleton.balls.len()).unwrap_or(NONE);
                skeleton.balls.push(cover.balls[ball as usize]);
                skeleton.parent.push(parent);
                node_of[ball as usize] = node;
            }
            skeleton.ends[one] = Some(node);
        }
        Some(skeleton)
    }

    /// The node of a ball, or of one beside it that is in the same place of the same tube.
    fn same_place(&self, cover: &Cover, ball: u32, node_of: &[u32]) -> Option<u32> {
        let node = |ball: u32| Some(node_of[ball as usize]).filter(|node| *node != NONE);
        if let Some(node) = node(ball) {
            return Some(node);
        }
        let here = cover.balls[ball as usize];
        let around = cover.links[ball as usize].iter().copied();
        let around = around.flat_map(|next| {
            std::iter::once(next).chain(cover.links[next as usize].iter().copied())
        });
        let near = around.filter_map(|other| {
            let there = cover.balls[other as usize];
            let thinner = here.radius.min(there.radius);
            let distance = here.centre.distance(there.centre) / thinner;
            let is_same = distance < SAME && thinner > ALIKE * here.radius.max(there.radius);
            is_same.then_some((distance, node(other)?))
        });
        near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            .map(|(_, node)| node)
    }

    /// Nodes without children and those with several, and the chains between them, from the first to the last node; parents first.
    pub(super) fn chains(&self) -> Vec<Vec<u32>> {
        let mut children: Vec<Vec<u32>> = vec![Vec::new(); self.parent.len()];
        for (node, parent) in (0_u32..).zip(&self.parent) {
            if *parent != NONE {
                children[*parent as usize].push(node);
            }
        }
        let mut chains = Vec::new();
        let mut open = vec![0_u32];
        while let Some(from) = open.pop() {
            for child in &children[from as usize] {
                let (mut chain, mut at) = (vec![from, *child], *child);
                while let [next] = children[at as usize].as_slice() {
                    at = *next;
                    chain.push(at);
                }
                open.push(at);
                chains.push(chain);
            }
        }
        chains
    }
}
