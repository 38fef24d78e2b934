//! Distances along the edges of a surface.
//!
//! Dijkstra's: a way along edges is longer than the straight one, by a tenth or so and everywhere alike, which does not matter for which place
//! is an end.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::atomic::{AtomicBool, Ordering};

use super::Surface;
use crate::mesh::report::NONE;

/// Steps between two looks at whether to stop.
pub(in crate::mesh) const STEPS: usize = 1 << 12;

/// Which vertices have an edge to which; most stand twice, once for each triangle at the edge.
#[derive(Clone, Debug)]
pub(crate) struct Graph {
    starts: Vec<u32>,
    ends: Vec<u32>,
}

impl Graph {
    pub(crate) fn new(surface: &Surface) -> Self {
        let vertices = surface.mesh().positions.len();
        let mut starts = vec![0_u32; vertices + 1];
        for (_, face) in surface.triangles() {
            face.iter().for_each(|vertex| starts[*vertex as usize] += 2);
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut ends = vec![0; sum as usize];
        for (_, [a, b, c]) in surface.triangles() {
            for (from, others) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                let start = &mut starts[from as usize];
                *start -= 2;
                ends[*start as usize..*start as usize + 2].copy_from_slice(&others);
            }
        }
        Self { starts, ends }
    }

    pub(crate) fn neighbours(&self, vertex: u32) -> &[u32] {
        let place = vertex as usize;
        &self.ends[self.starts[place] as usize..self.starts[place + 1] as usize]
    }

    pub(crate) fn vertices(&self) -> u32 {
        u32::try_from(self.starts.len() - 1).unwrap_or(0)
    }
}

/// How far vertices are from the nearest of some.
pub(in crate::mesh) struct Field {
    /// Infinite where none is reached.
    pub(in crate::mesh) distances: Vec<f64>,
    /// The place of the nearest in the list of sources.
    pub(in crate::mesh) sources: Vec<u32>,
}

/// The shortest way along edges from one of some vertices to one of others, each with what the way costs before or after it: its vertices. None
/// inside where there is no way, outside when `cancel` was set.
pub(in crate::mesh) fn way(
    surface: &Surface,
    graph: &Graph,
    from: &[(u32, f64)],
    to: &[(u32, f64)],
    cancel: &AtomicBool,
) -> Option<Option<Vec<u32>>> {
    let goal = surface.position(to.first().map_or(0, |(vertex, _)| *vertex));
    // No way from here is shorter than the straight one; ends of `to` are corners of one triangle, and the slack is its size.
    let slack = to
        .iter()
        .map(|(vertex, _)| surface.position(*vertex).distance(goal));
    let slack = slack.fold(0.0, f64::max);
    let left = |vertex: u32| (surface.position(vertex).distance(goal) - slack).max(0.0);
    let mut distances = vec![f64::INFINITY; graph.vertices() as usize];
    let mut before = vec![NONE; graph.vertices() as usize];
    let mut heap = BinaryHeap::new();
    for (vertex, distance) in from {
        distances[*vertex as usize] = *distance;
        heap.push(Reverse(((distance + left(*vertex)).to_bits(), *vertex)));
    }
    let mut best: Option<(f64, u32)> = None;
    let mut steps = 0_usize;
    while let Some(Reverse((bits, vertex))) = heap.pop() {
        steps += 1;
        if steps.is_multiple_of(STEPS) && cancel.load(Ordering::Relaxed) {
            return None;
        }
        let distance = distances[vertex as usize];
        if best.is_some_and(|(best, _)| f64::from_bits(bits) >= best) {
            break;
        }
        if f64::from_bits(bits) > distance + left(vertex) {
            continue;
        }
        for (_, behind) in to.iter().filter(|(end, _)| *end == vertex) {
            if best.is_none_or(|(best, _)| distance + behind < best) {
                best = Some((distance + behind, vertex));
            }
        }
        let here = surface.position(vertex);
        for other in graph.neighbours(vertex) {
            let farther = distance + here.distance(surface.position(*other));
            if farther < distances[*other as usize] {
                distances[*other as usize] = farther;
                before[*other as usize] = vertex;
                heap.push(Reverse(((farther + left(*other)).to_bits(), *other)));
            }
        }
    }
    Some(best.map(|(_, end)| {
        let mut way = vec![end];
        let mut at = end;
        while before[at as usize] != NONE {
            at = before[at as usize];
            way.push(at);
        }
        way.reverse();
        way
    }))
}

/// Distances from sources, each up to a distance of its own. None when `cancel` was set.
pub(in crate::mesh) fn field(
    surface: &Surface,
    graph: &Graph,
    sources: &[(u32, u32)],
    most: impl Fn(u32) -> f64,
    cancel: &AtomicBool,
) -> Option<Field> {
    let mut field = Field {
        distances: vec![f64::INFINITY; graph.vertices() as usize],
        sources: vec![NONE; graph.vertices() as usize],
    };
    let mut heap = BinaryHeap::new();
    for (vertex, source) in sources {
        field.distances[*vertex as usize] = 0.0;
        field.sources[*vertex as usize] = *source;
        heap.push(Reverse((0_u64, *vertex)));
    }
    let mut steps = 0_usize;
    // Distances are not negative, so their bits are in the order of their values.
    while let Some(Reverse((bits, vertex))) = heap.pop() {
        steps += 1;
        if steps.is_multiple_of(STEPS) && cancel.load(Ordering::Relaxed) {
            return None;
        }
        let distance = f64::from_bits(bits);
        if distance > field.distances[vertex as usize] {
            continue;
        }
        let (source, here) = (field.sources[vertex as usize], surface.position(vertex));
        for other in graph.neighbours(vertex) {
            let farther = distance + here.distance(surface.position(*other));
            if farther < field.distances[*other as usize] && farther <= most(source) {
                field.distances[*other as usize] = farther;
                field.sources[*other as usize] = source;
                heap.push(Reverse((farther.to_bits(), *other)));
            }
        }
    }
    (!cancel.load(Ordering::Relaxed)).then_some(field)
}
