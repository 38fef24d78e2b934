//! Where a surface passes through itself: pairs of triangles that share no vertex and yet have a point in common.
//!
//! A hierarchy of boxes (obvhs, PLOC) gives for each triangle those whose boxes touch its own; [`meet`] then decides exactly. Triangles
//! count as closed: an edge that ends on another triangle, a corner that rests on it and faces that lie on each other are all told.
//! Triangles with a common vertex (or two of equal coordinates) are neighbours and never told, even where one is folded onto the other;
//! triangles without area and those with vertices that are not there or not finite are left to the [report](super::report).
//!
//! Work is done in blocks of triangles in their order, so that what is told does not depend on the number of threads, and ends soon after
//! the bound is reached: parts pushed into each other thousands of times would have more pairs than memory.

mod meet;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;

pub use self::meet::meet;
use super::Mesh;
use super::report::is_line;

/// Triangles between two looks at the flag, and between two tellings of progress.
const BLOCK: usize = 1 << 14;

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

/// Finds the pairs. `progress` gets how many triangles of how many are done. None when `cancel` was set.
pub fn intersections(
    mesh: &Mesh,
    params: &IntersectParams,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(usize, usize),
) -> Option<Intersections> {
    let hierarchy = Hierarchy::new(mesh);
    let mut found = Intersections {
        complete: true,
        ..Intersections::default()
    };
    for (block, queries) in hierarchy.boxes.chunks(BLOCK).enumerate() {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        let first = block * BLOCK;
        progress(first, hierarchy.boxes.len());
        let most = params.pairs_most - found.pairs.len();
        let range = first..first + queries.len();
        let pairs = match hierarchy.pairs_of(range.clone(), most, cancel) {
            Some(pairs) => pairs,
            None => {
                found.complete = false;
                hierarchy.first_pairs_of(range, most, cancel)
            }
        };
        found.pairs.extend(pairs);
        if !found.complete {
            break;
        }
    }
    // A query that was cut short has not found all.
    if cancel.load(Ordering::Relaxed) {
        return None;
    }
    progress(hierarchy.boxes.len(), hierarchy.boxes.len());
    Some(found)
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

    /// All pairs of these triangles with later ones, sorted; None where there are more than `most`.
    fn pairs_of(
        &self,
        of: std::ops::Range<usize>,
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
    fn first_pairs_of(
        &self,
        of: std::ops::Range<usize>,
        most: usize,
        cancel: &AtomicBool,
    ) -> Vec<[u32; 2]> {
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
