//! Arms of a surface: where what is far from a place falls apart into pieces.
//!
//! Vertices are taken from the farthest to the nearest. Each that has no farther neighbour begins a piece; pieces grow, and where two meet, the one
//! whose peak is nearer ends (the "elder rule" of persistent homology: Edelsbrunner, Letscher and Zomorodian 2002). How far its peak is above
//! that place is the arm's length. A branch makes one arm from its tip to the fork, however it bends; bumps make arms too, but short ones.
//!
//! How thick an arm is, its area says: 2π · radius · length. Only the stretch from the peak to the first fork counts, so that an arm that forks
//! again and again is not taken for a thick one.

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::mesh::report::NONE;
use crate::mesh::surface::graph::{Field, Graph, STEPS};

/// An arm that is not so many times as long as thick is not looked at further. A half-ball on a wall has 2.5; only what is flatter has less than 1.
const SLENDER: f64 = 0.6;
/// Part of the longer arm's area that an arm must have for the place to be a fork of it, and not a bump.
const FORK: f64 = 0.05;

/// A whole part that has no fork must be so many times as long as thick to have ends. A ball has 4.9.
const SLENDER_WHOLE: f64 = 7.0;

/// From a peak to where it meets a longer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arm {
    pub(super) peak: u32,
    /// Where it meets the longer one; None where it meets none.
    pub(super) foot: Option<u32>,
    pub(super) length: f64,
    /// By its area, below the peak.
    pub(super) radius: f64,
}

impl Arm {
    fn is_slender(&self, times: f64) -> bool {
        self.length > times * self.radius
    }
}

/// A piece that grows.
#[derive(Clone, Copy)]
struct Piece {
    peak: u32,
    area: f64,
    /// Length and area of the stretch below the peak, once it has forked.
    stretch: Option<(f64, f64)>,
}

impl Piece {
    fn arm(&self, length: f64, foot: Option<u32>) -> Arm {
        let (own, area) = self.stretch.unwrap_or((length, self.area));
        Arm {
            peak: self.peak,
            foot,
            length,
            radius: area / (TAU * own),
        }
    }
}

/// All arms that are not flat, and for each part of the surface the one that is left in the end, which leads to where distances are
/// counted from.
pub(super) struct Arms {
    pub(super) side: Vec<Arm>,
    pub(super) whole: Vec<Arm>,
}

impl Arms {
    pub(super) fn all(&self) -> impl Iterator<Item = &Arm> {
        self.side.iter().chain(&self.whole)
    }
}

/// Finds them; `areas` are those of vertices. None when `cancel` was set.
pub(super) fn arms(
    graph: &Graph,
    field: &Field,
    areas: &[f64],
    cancel: &AtomicBool,
) -> Option<Arms> {
    let distance = |vertex: u32| field.distances[vertex as usize];
    let mut order: Vec<u32> = (0..graph.vertices())
        .filter(|vertex| distance(*vertex).is_finite())
        .collect();
    order.sort_unstable_by(|a, b| distance(*b).total_cmp(&distance(*a)).then(a.cmp(b)));
    let mut pieces = Pieces {
        parent: vec![NONE; graph.vertices() as usize],
        of_root: vec![NONE; graph.vertices() as usize],
        pieces: Vec::new(),
    };
    let mut side = Vec::new();
    for (step, vertex) in order.iter().enumerate() {
        if step.is_multiple_of(STEPS) && cancel.load(Ordering::Relaxed) {
            return None;
        }
        pieces.add(*vertex, areas[*vertex as usize]);
        for other in graph.neighbours(*vertex) {
            if pieces.parent[*other as usize] == NONE {
                continue;
            }
            let level = distance(*vertex);
            let Some((ended, longer)) = pieces.join(*vertex, *other, &distance) else {
                continue;
            };
            let arm = ended.arm(distance(ended.peak) - level, Some(*vertex));
            let grown = &mut pieces.pieces[longer as usize];
            if ended.peak != *vertex && arm.is_slender(SLENDER) {
                let own = (distance(grown.peak) - level, grown.area);
                if ended.area > FORK * grown.area {
                    grown.stretch.get_or_insert(own);
                }
                side.push(arm);
            }
            grown.area += ended.area;
        }
    }
    let roots = order
        .iter()
        .filter(|vertex| pieces.parent[**vertex as usize] == **vertex);
    let whole = roots.filter_map(|root| {
        let piece = pieces.pieces[pieces.of_root[*root as usize] as usize];
        let arm = piece.arm(distance(piece.peak), None);
        let times = piece.stretch.map_or(SLENDER_WHOLE, |_| SLENDER);
        arm.is_slender(times).then_some(arm)
    });
    Some(Arms {
        whole: whole.collect(),
        side,
    })
}

struct Pieces {
    parent: Vec<u32>,
    /// The piece of each root.
    of_root: Vec<u32>,
    pieces: Vec<Piece>,
}

impl Pieces {
    fn add(&mut self, vertex: u32, area: f64) {
        self.parent[vertex as usize] = vertex;
        self.of_root[vertex as usize] = u32::try_from(self.pieces.len()).unwrap_or(NONE);
        self.pieces.push(Piece {
            peak: vertex,
            area,
            stretch: None,
        });
    }

    fn find(&mut self, mut vertex: u32) -> u32 {
        loop {
            let parent = self.parent[vertex as usize];
            if parent == vertex {
                return vertex;
            }
            self.parent[vertex as usize] = self.parent[parent as usize];
            vertex = parent;
        }
    }

    /// Joins the pieces of two vertices: the one that ends, and the number of the one that goes on; None where they are one.
    fn join(
        &mut self,
        one: u32,
        other: u32,
        distance: &impl Fn(u32) -> f64,
    ) -> Option<(Piece, u32)> {
        let (one, other) = (self.find(one), self.find(other));
        if one == other {
            return None;
        }
        let [first, second] = [one, other].map(|root| self.of_root[root as usize]);
        let [a, b] = [first, second].map(|piece| self.pieces[piece as usize].peak);
        let second_goes_on = distance(b).total_cmp(&distance(a)).then(a.cmp(&b)).is_gt();
        let (ends, goes_on) = if second_goes_on {
            (first, second)
        } else {
            (second, first)
        };
        let (root, below) = (one.min(other), one.max(other));
        self.parent[below as usize] = root;
        self.of_root[root as usize] = goes_on;
        Some((self.pieces[ends as usize], goes_on))
    }
}
