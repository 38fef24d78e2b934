//! How the hierarchy is built, and filled with boxes.
//!
//! obvhs clusters the triangles' boxes (PLOC) and improves the binary hierarchy a little (reinsertion); Ramus then takes from it what hangs
//! together and makes nodes of four children and runs of up to four triangles. Boxes are made anew from the triangles: obvhs sees the
//! model scaled to size one, so that products of its coordinates neither overflow nor vanish.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;

use super::node::{Child, EMPTY, NOTHING, Node, RUN_MOST, TRIANGLES_MOST, union};
use super::{DEPTH_MOST, Hierarchy};
use crate::mesh::Mesh;

/// Part of the nodes that reinsertion tries.
const REINSERTED: f32 = 0.01;

/// Triangles of one piece of work.
const CHUNK: usize = 1 << 14;

/// Corners of a triangle, if all are there and finite.
pub(super) fn usable(mesh: &Mesh, triangle: [u32; 3]) -> Option<[Vec3; 3]> {
    let corner = |vertex: u32| mesh.positions.get(vertex as usize).copied();
    let corners = [
        corner(triangle[0])?,
        corner(triangle[1])?,
        corner(triangle[2])?,
    ];
    corners
        .iter()
        .all(|corner| corner.is_finite())
        .then_some(corners)
}

/// The box around a triangle.
fn around([a, b, c]: [Vec3; 3]) -> [Vec3; 2] {
    [a.min(b).min(c), a.max(b).max(c)]
}

/// Which triangles can be picked, sorted.
pub(super) fn usable_triangles(mesh: &Mesh) -> Vec<u32> {
    let count = u32::try_from(mesh.triangles.len().min(TRIANGLES_MOST)).unwrap_or(0);
    (0..count)
        .into_par_iter()
        .filter(|triangle| usable(mesh, mesh.triangles[*triangle as usize]).is_some())
        .collect()
}

impl Hierarchy {
    /// Builds the hierarchy over all usable triangles; None when `cancel` was set.
    pub(super) fn new(
        mesh: &Mesh,
        cancel: &AtomicBool,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Option<Self> {
        let mut done = 0;
        let mut stage = || {
            progress(done, STAGES);
            done += 1;
            (!cancel.load(Ordering::Relaxed)).then_some(())
        };
        stage()?;
        let numbers = usable_triangles(mesh);
        let boxes = scaled_boxes(mesh, &numbers);
        stage()?;
        let mut bvh = clustered(&boxes);
        drop(boxes);
        stage()?;
        ReinsertionOptimizer::default().run(&mut bvh, REINSERTED, None);
        stage()?;
        let mut hierarchy = Self::from_binary(&bvh, &numbers);
        drop(bvh);
        stage()?;
        hierarchy.fit(mesh);
        stage()?;
        Some(hierarchy)
    }

    fn from_binary(bvh: &Bvh2, numbers: &[u32]) -> Self {
        let (order, lengths) = runs(bvh);
        let mut topology = Vec::new();
        if !bvh.nodes.is_empty() && !order.is_empty() {
            topology = wide(bvh, &lengths);
        }
        if depth(&topology).is_none_or(|depth| depth > DEPTH_MOST) {
            topology = balanced(order.len());
        }
        Self {
            nodes: topology.into_iter().map(Node::new).collect(),
            order: order
                .into_iter()
                .map(|place| numbers[place as usize])
                .collect(),
            corners: Vec::new(),
        }
    }

    /// The volume of pyramids from the middle of the box to all triangles is below zero. Sums of chunks are added in their order, so it does not depend on
    /// the number of threads.
    pub(super) fn is_inside_out(&self) -> bool {
        let Some(root) = self.nodes.first() else {
            return false;
        };
        let [min, max] = root.bounds().map(Vec3::as_dvec3);
        let middle = min.midpoint(max);
        let volume = |corners: &[Vec3; 3]| {
            let [a, b, c] = corners.map(|corner| corner.as_dvec3() - middle);
            a.dot(b.cross(c))
        };
        let chunks: Vec<f64> = self
            .corners
            .par_chunks(CHUNK)
            .map(|chunk| chunk.iter().map(volume).sum())
            .collect();
        chunks.into_iter().sum::<f64>() < 0.0
    }

    /// Makes all boxes anew from the triangles. Children stand behind their parents, so they are known first from the end.
    pub(super) fn fit(&mut self, mesh: &Mesh) {
        self.corners = self
            .order
            .par_iter()
            .map(|triangle| {
                usable(mesh, mesh.triangles[*triangle as usize]).unwrap_or([Vec3::INFINITY; 3])
            })
            .collect();
        let corners = &self.corners;
        let of_triangle = |place: u32| around(corners[place as usize]);
        self.nodes.par_iter_mut().for_each(|node| {
            for slot in 0..4 {
                if let Child::Run { start, length } = Child::new(node.children[slot]) {
                    let run = (start..start + length).map(of_triangle);
                    node.set_bounds(slot, run.fold(NOTHING, union));
                }
            }
        });
        for place in (0..self.nodes.len()).rev() {
            for slot in 0..4 {
                if let Child::Node(below) = Child::new(self.nodes[place].children[slot]) {
                    let bounds = self.nodes[below as usize].bounds();
                    self.nodes[place].set_bounds(slot, bounds);
                }
            }
        }
    }
}

/// How many stages are told.
const STAGES: usize = 5;

/// Boxes around triangles, moved and scaled so that all are between −½ and ½.
fn scaled_boxes(mesh: &Mesh, numbers: &[u32]) -> Vec<Aabb> {
    let of = |triangle: &u32| {
        usable(mesh, mesh.triangles[*triangle as usize]).map_or([Vec3::ZERO; 2], around)
    };
    let [min, max] = numbers
        .par_iter()
        .map(of)
        .reduce(|| NOTHING, union)
        .map(Vec3::as_dvec3);
    let size = (max - min).max_element();
    let scale = if size > 0.0 { size.recip() } else { 1.0 };
    let middle = min.midpoint(max);
    let place = |point: Vec3| ((point.as_dvec3() - middle) * scale).as_vec3a();
    numbers
        .par_iter()
        .map(|triangle| {
            let [min, max] = of(triangle);
            Aabb::new(place(min), place(max))
        })
        .collect()
}

fn clustered(boxes: &[Aabb]) -> Bvh2 {
    let indices = (0_u32..).take(boxes.len()).collect();
    PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Minimum,
        boxes,
        indices,
        SortPrecision::U64,
        0,
    )
}

/// Triangles in the order of the leaves from left to right, and for each node where its triangles begin and how many they are.
fn runs(bvh: &Bvh2) -> (Vec<u32>, Vec<[u32; 2]>) {
    let mut of_node = vec![[0; 2]; bvh.nodes.len()];
    let mut order = Vec::with_capacity(bvh.primitive_indices.len());
    let mut open: Vec<(u32, bool)> = Vec::from_iter((!bvh.nodes.is_empty()).then_some((0, false)));
    while let Some((number, seen)) = open.pop() {
        let node = &bvh.nodes[number as usize];
        let here = u32::try_from(order.len()).unwrap_or(EMPTY);
        if seen {
            let start = of_node[number as usize][0];
            of_node[number as usize][1] = here - start;
        } else if node.is_leaf() {
            let first = node.first_index as usize;
            order.extend(&bvh.primitive_indices[first..first + node.prim_count as usize]);
            of_node[number as usize] = [here, node.prim_count];
        } else {
            of_node[number as usize][0] = here;
            open.extend([
                (number, true),
                (node.first_index + 1, false),
                (node.first_index, false),
            ]);
        }
    }
    (order, of_node)
}

/// Children of nodes with four children each, every node before those below it.
fn wide(bvh: &Bvh2, runs: &[[u32; 2]]) -> Vec<[u32; 4]> {
    let is_run = |number: u32| runs[number as usize][1] <= RUN_MOST;
    let area = |number: u32| bvh.nodes[number as usize].aabb().half_area();
    let mut topology = vec![[EMPTY; 4]];
    let mut open = vec![(0_u32, 0_usize)];
    while let Some((number, place)) = open.pop() {
        let mut children = vec![number];
        while children.len() < 4 {
            // The largest box is opened.
            let largest = (0..children.len())
                .filter(|slot| !is_run(children[*slot]))
                .max_by(|a, b| area(children[*a]).total_cmp(&area(children[*b])));
            let Some(slot) = largest else { break };
            let first = bvh.nodes[children[slot] as usize].first_index;
            children[slot] = first;
            children.insert(slot + 1, first + 1);
        }
        for (slot, child) in children.into_iter().enumerate() {
            let [start, length] = runs[child as usize];
            topology[place][slot] = match is_run(child) {
                true => Child::Run { start, length },
                false => {
                    open.push((child, topology.len()));
                    topology.push([EMPTY; 4]);
                    Child::Node(u32::try_from(topology.len() - 1).unwrap_or(EMPTY))
                }
            }
            .number();
        }
    }
    topology
}

/// The same over triangles in their order, halved again and again: for hierarchies that are too deep to be walked with a stack of fixed
/// size, as they come of thousands of triangles in one place.
fn balanced(triangles: usize) -> Vec<[u32; 4]> {
    let triangles = u32::try_from(triangles).unwrap_or(0);
    if triangles == 0 {
        return Vec::new();
    }
    let mut topology = vec![[EMPTY; 4]];
    let mut open = VecDeque::from([(0..triangles, 0_usize)]);
    while let Some((run, place)) = open.pop_front() {
        let length = run.end - run.start;
        let quarter = length.div_ceil(4).max(RUN_MOST.min(length));
        for slot in 0..4 {
            let start = run.start.saturating_add(quarter * slot).min(run.end);
            let end = start.saturating_add(quarter).min(run.end);
            let below = u32::try_from(topology.len()).unwrap_or(EMPTY);
            topology[place][slot as usize] = match end - start {
                0 => Child::Empty,
                length if length <= RUN_MOST => Child::Run { start, length },
                _ => {
                    open.push_back((start..end, topology.len()));
                    topology.push([EMPTY; 4]);
                    Child::Node(below)
                }
            }
            .number();
        }
    }
    topology
}

/// Levels of nodes; None where a node does not stand behind its parent.
pub(super) fn depth(topology: &[[u32; 4]]) -> Option<usize> {
    let mut depths = vec![1_u32; topology.len()];
    for (place, children) in topology.iter().enumerate() {
        for child in children {
            if let Child::Node(below) = Child::new(*child) {
                if below as usize <= place {
                    return None;
                }
                *depths.get_mut(below as usize)? = depths[place] + 1;
            }
        }
    }
    Some(depths.into_iter().max().unwrap_or(0) as usize)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    #[test]
    fn halving_covers_all_triangles_once() {
        for triangles in [0, 1, 3, 4, 5, 16, 17, 1000, 4097] {
            let topology = balanced(triangles);
            let mut covered = vec![0; triangles];
            for child in topology.as_flattened() {
                if let Child::Run { start, length } = Child::new(*child) {
                    (start..start + length).for_each(|place| covered[place as usize] += 1);
                }
            }
            assert!(covered.iter().all(|count| *count == 1), "{triangles}");
            assert!(depth(&topology).is_some_and(|depth| depth <= 8));
        }
    }
}
