//! Where a surface passes through itself: pairs of triangles that share no vertex and yet have a point in common.
//!
//! A hierarchy of boxes (obvhs, PLOC) is gone down against itself, which finds each pair of triangles whose boxes touch once; [`fn@meet`] then
//! decides exactly. (Asked for each triangle from the top, it would be gone down much oftener and find each pair twice.) Triangles
//! count as closed: an edge that ends on another triangle, a corner that rests on it and faces that lie on each other are all told.
//! Triangles with a common vertex (or two of equal coordinates) are neighbours and never told, even where one is folded onto the other;
//! triangles without area and those with vertices that are not there or not finite are left to the [report](super::report).
//!
//! Parts pushed into each other thousands of times would have more pairs than memory, so the search ends when there are more than a bound.
//! Then it goes on in the order of the triangles, until there are as many as the bound: what is told never depends on the number of threads.
//! Boxes and hierarchy take about 240 bytes a triangle while they are built.

mod meet;

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;

pub use self::meet::meet;
use super::Mesh;
use super::report::is_line;

/// Triangles between two tellings of progress, where pairs are looked for in order.
const BLOCK: usize = 1 << 14;

/// Pieces of work, where all pairs are looked for.
const JOBS: usize = 1 << 12;

/// How far to look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IntersectParams {
    /// Pairs that are told and counted at most.
    pub pairs_most: usize,
}

impl Default for IntersectParams {
    fn default() -> Self {
        Self {
            pairs_most: 1_000_000,
        }
    }
}

/// Pairs of triangles that pass through each other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Intersections {
    /// Pairs by the numbers of the triangles, the smaller first, sorted.
    pub pairs: Vec<[u32; 2]>,
    /// Whether these are all; else there are more than the bound.
    pub complete: bool,
}

impl Intersections {
    /// Each triangle that is in a pair, once, sorted.
    pub fn triangles(&self) -> Vec<u32> {
        let mut all = self.pairs.as_flattened().to_vec();
        all.par_sort_unstable();
        all.dedup();
        all
    }
}

/// Finds the pairs. `progress` gets how many parts of the work of how many are done. None when `cancel` was set.
pub fn intersections(
    mesh: &Mesh,
    params: &IntersectParams,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(usize, usize),
) -> Option<Intersections> {
    let hierarchy = Hierarchy::new(mesh);
    let all = hierarchy.all_pairs(params.pairs_most, cancel, progress);
    let found = Intersections {
        complete: all.is_some(),
        pairs: all.unwrap_or_else(|| hierarchy.first_pairs(params.pairs_most, cancel, progress)),
    };
    // What was cut short has not found all.
    (!cancel.load(Ordering::Relaxed)).then_some(found)
}

/// The triangles that can meet others, and boxes over them.
struct Hierarchy<'a> {
    mesh: &'a Mesh,
    /// Numbers of these triangles, sorted.
    numbers: Vec<u32>,
    boxes: Vec<Aabb>,
    bvh: Bvh2,
}

impl<'a> Hierarchy<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        let count = u32::try_from(mesh.triangles.len()).unwrap_or(u32::MAX);
        let (numbers, boxes): (Vec<u32>, Vec<Aabb>) = (0..count)
            .into_par_iter()
            .filter_map(|triangle| {
                let corners = corners(mesh, triangle)?;
                (!is_line(corners)).then(|| (triangle, around(corners)))
            })
            .unzip();
        let indices = (0_u32..).take(boxes.len()).collect();
        let bvh = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::VeryLow,
            &boxes,
            indices,
            SortPrecision::U64,
            0,
        );
        Self {
            mesh,
            numbers,
            boxes,
            bvh,
        }
    }

    /// All pairs, sorted; None where there are more than `most`.
    fn all_pairs(
        &self,
        most: usize,
        cancel: &AtomicBool,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Option<Vec<[u32; 2]>> {
        let jobs = self.jobs();
        let count = AtomicUsize::new(0);
        let is_over = || count.load(Ordering::Relaxed) > most || cancel.load(Ordering::Relaxed);
        let mut found = Vec::new();
        for (done, part) in jobs.chunks(JOBS / 32).enumerate() {
            progress(done * (JOBS / 32), jobs.len());
            found.par_extend(part.par_iter().flat_map_iter(|job| {
                let (mut open, mut pairs) = (vec![*job], Vec::new());
                while let Some(nodes) = open.pop().filter(|_| !is_over()) {
                    let before = pairs.len();
                    pairs.extend(self.split(nodes, &mut open));
                    count.fetch_add(pairs.len() - before, Ordering::Relaxed);
                }
                pairs
            }));
        }
        progress(jobs.len(), jobs.len());
        found.par_sort_unstable();
        (count.into_inner() <= most).then_some(found)
    }

    /// Pairs of nodes below which all pairs are, enough of them for all threads.
    fn jobs(&self) -> Vec<[u32; 2]> {
        let mut jobs: VecDeque<[u32; 2]> = VecDeque::new();
        // A node that is a triangle has no pairs below it.
        jobs.extend((self.boxes.len() > 1).then_some([0, 0]));
        let mut parts = Vec::new();
        while jobs.len() < JOBS
            && let Some(job) = jobs.pop_front()
        {
            match self.is_pair(job) {
                true => parts.push(job),
                false => {
                    self.split(job, &mut jobs);
                }
            }
        }
        parts.extend(jobs);
        parts
    }

    /// Both are triangles.
    fn is_pair(&self, [a, b]: [u32; 2]) -> bool {
        a != b
            && [a, b]
                .iter()
                .all(|node| self.bvh.nodes[*node as usize].is_leaf())
    }

    /// Looks at all pairs below two nodes, or below one where both are the same: gives the pair where both are triangles that meet, else
    /// adds to `open` what is a level below.
    fn split(&self, [a, b]: [u32; 2], open: &mut impl Extend<[u32; 2]>) -> Option<[u32; 2]> {
        let [one, other] = [a, b].map(|node| &self.bvh.nodes[node as usize]);
        if a == b {
            let (left, right) = (one.first_index, one.first_index + 1);
            let inner = !one.is_leaf();
            open.extend(
                [[left, left], [right, right], [left, right]]
                    .into_iter()
                    .filter(|_| inner),
            );
            return None;
        }
        if !one.aabb().intersect_aabb(other.aabb()) {
            return None;
        }
        let one_is_larger = one.aabb().half_area() > other.aabb().half_area();
        match (one.is_leaf(), other.is_leaf()) {
            (true, true) => return self.pair(one, other),
            (false, leaf) if leaf || one_is_larger => {
                open.extend([[one.first_index, b], [one.first_index + 1, b]]);
            }
            _ => open.extend([[a, other.first_index], [a, other.first_index + 1]]),
        }
        None
    }

    /// The numbers of two triangles, if they meet.
    fn pair(&self, one: &Bvh2Node, other: &Bvh2Node) -> Option<[u32; 2]> {
        let [one, other] =
            [one, other].map(|leaf| self.bvh.primitive_indices[leaf.first_index as usize] as usize);
        let (one, other) = (one.min(other), one.max(other));
        let triangle = corners(self.mesh, self.numbers[one])?;
        self.meets(triangle, other)
            .then(|| [self.numbers[one], self.numbers[other]])
    }

    /// The first `most` pairs, of more.
    fn first_pairs(
        &self,
        most: usize,
        cancel: &AtomicBool,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Vec<[u32; 2]> {
        let mut found = Vec::new();
        for first in (0..self.boxes.len()).step_by(BLOCK) {
            progress(first, self.boxes.len());
            let (block, left) = (
                first..self.boxes.len().min(first + BLOCK),
                most - found.len(),
            );
            let Some(pairs) = self.pairs_of(block.clone(), left, cancel) else {
                found.extend(self.first_pairs_of(block, left, cancel));
                break;
            };
            found.extend(pairs);
        }
        found
    }

    /// All pairs of these triangles with later ones, sorted; None where there are more than `most`.
    fn pairs_of(
        &self,
        of: Range<usize>,
        most: usize,
        cancel: &AtomicBool,
    ) -> Option<Vec<[u32; 2]>> {
        let count = AtomicUsize::new(0);
        let parts: Vec<Vec<[u32; 2]>> = of
            .into_par_iter()
            .fold(Vec::new, |mut pairs, one| {
                let before = pairs.len();
                if count.load(Ordering::Relaxed) <= most {
                    self.find(one, most, cancel, &mut pairs);
                }
                count.fetch_add(pairs.len() - before, Ordering::Relaxed);
                pairs
            })
            .collect();
        if count.into_inner() > most {
            return None;
        }
        Some(parts.concat())
    }

    /// The first `most` pairs of these triangles with later ones.
    fn first_pairs_of(&self, of: Range<usize>, most: usize, cancel: &AtomicBool) -> Vec<[u32; 2]> {
        let mut pairs = Vec::new();
        for one in of {
            self.find(one, usize::MAX, cancel, &mut pairs);
            if pairs.len() >= most {
                break;
            }
        }
        pairs.truncate(most);
        pairs
    }

    /// Adds the pairs of a triangle with later ones, sorted, and ends when it has added more than `most`.
    fn find(&self, one: usize, most: usize, cancel: &AtomicBool, pairs: &mut Vec<[u32; 2]>) {
        let number = self.numbers[one];
        let Some(triangle) = corners(self.mesh, number) else {
            return;
        };
        let before = pairs.len();
        self.bvh.aabb_traverse(self.boxes[one], |bvh, node| {
            let node = &bvh.nodes[node as usize];
            let leaf = node.first_index as usize..(node.first_index + node.prim_count) as usize;
            for other in bvh.primitive_indices[leaf]
                .iter()
                .map(|other| *other as usize)
            {
                if other > one && self.meets(triangle, other) {
                    pairs.push([number, self.numbers[other]]);
                }
            }
            pairs.len() - before <= most && !cancel.load(Ordering::Relaxed)
        });
        pairs[before..].sort_unstable();
    }

    fn meets(&self, triangle: [Vec3; 3], other: usize) -> bool {
        corners(self.mesh, self.numbers[other]).is_some_and(|other| {
            let neighbours = triangle.iter().any(|corner| other.contains(corner));
            !neighbours && meet(triangle, other)
        })
    }
}

/// Where the corners of a triangle are, if all are somewhere.
fn corners(mesh: &Mesh, triangle: u32) -> Option<[Vec3; 3]> {
    let [a, b, c] = *mesh.triangles.get(triangle as usize)?;
    let corner = |vertex: u32| mesh.positions.get(vertex as usize).copied();
    let corners = [corner(a)?, corner(b)?, corner(c)?];
    corners
        .iter()
        .all(|corner| corner.is_finite())
        .then_some(corners)
}

fn around([a, b, c]: [Vec3; 3]) -> Aabb {
    Aabb::new(a.min(b).min(c).to_vec3a(), a.max(b).max(c).to_vec3a())
}

#[cfg(test)]
mod tests;
