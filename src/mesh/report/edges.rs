//! Which triangles meet at which edge.
//!
//! Half-edge `3 t + k` of triangle `t` leads from its corner `k` to the next one. Half-edges are put into one bucket for each smaller end
//! (a counting sort), and each bucket, half a dozen entries, is sorted by the larger end: equal entries in a row are one edge. Eight bytes
//! for a half-edge, no table of edges, and buckets are sorted and read by all threads. Hash maps of edges take five times the memory and
//! more than that in time; sorting all half-edges at once takes twice the time.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use super::{Face, NONE, is_left_out};

/// Vertices of one piece of work.
const CHUNK: usize = 1 << 13;

/// Half-edges by their smaller end, then by their larger one.
pub(in crate::mesh) struct Edges<'a> {
    faces: &'a [Face],
    /// Where each vertex's bucket begins, and the end of the last.
    starts: Vec<u32>,
    /// The larger end in the upper half, the half-edge in the lower.
    entries: Vec<u64>,
}

/// What the edges are like.
#[derive(Default)]
pub(in crate::mesh) struct Kinds {
    /// The other half-edge where an edge has two, else [`NONE`].
    pub(in crate::mesh) twins: Vec<u32>,
    /// Half-edges without another.
    pub(in crate::mesh) boundary: Vec<u32>,
    /// One half-edge of each edge with more than two, and how many it has.
    pub(in crate::mesh) non_manifold: Vec<(u32, u32)>,
    /// One half-edge of each edge that its two triangles run through in the same direction.
    pub(in crate::mesh) inconsistent: Vec<u32>,
}

/// The end of a half-edge that is nearer to its name: the smaller and the larger vertex.
fn ends(face: &Face, corner: usize) -> (u32, u32) {
    let (from, to) = (face[corner], face[(corner + 1) % 3]);
    (from.min(to), from.max(to))
}

/// From where to where a half-edge leads.
pub(in crate::mesh) fn from_to(faces: &[Face], half_edge: u32) -> [u32; 2] {
    let face = &faces[half_edge as usize / 3];
    let corner = half_edge as usize % 3;
    [face[corner], face[(corner + 1) % 3]]
}

fn larger_end(entry: u64) -> u64 {
    entry >> 32
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "the low half is what is asked for"
)]
fn half_edge(entry: &u64) -> u32 {
    *entry as u32
}

impl<'a> Edges<'a> {
    /// Sorts the half-edges of all faces that are not left out; every vertex is below `vertices`.
    pub(in crate::mesh) fn new(faces: &'a [Face], vertices: usize) -> Self {
        let mut starts = vec![0_u32; vertices + 1];
        for face in faces.iter().filter(|face| !is_left_out(face)) {
            for corner in 0..3 {
                starts[ends(face, corner).0 as usize] += 1;
            }
        }
        // Each start becomes the end of its bucket, and moves to the front again while the bucket is filled.
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut entries = vec![0_u64; sum as usize];
        for (triangle, face) in (0_u32..).zip(faces) {
            if is_left_out(face) {
                continue;
            }
            for (corner, half_edge) in (3 * triangle..).take(3).enumerate() {
                let (smaller, larger) = ends(face, corner);
                let place = &mut starts[smaller as usize];
                *place -= 1;
                entries[*place as usize] = u64::from(larger) << 32 | u64::from(half_edge);
            }
        }
        let mut edges = Self {
            faces,
            starts,
            entries,
        };
        edges.sort_buckets();
        edges
    }

    fn chunks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let vertices = self.starts.len() - 1;
        (0..vertices)
            .step_by(CHUNK)
            .map(move |first| first..(first + CHUNK).min(vertices))
    }

    fn sort_buckets(&mut self) {
        let mut rest = self.entries.as_mut_slice();
        let mut pieces = Vec::new();
        let vertices = self.starts.len() - 1;
        for first in (0..vertices).step_by(CHUNK) {
            let starts = &self.starts[first..=(first + CHUNK).min(vertices)];
            let (piece, behind) =
                rest.split_at_mut((starts[starts.len() - 1] - starts[0]) as usize);
            rest = behind;
            pieces.push((starts, piece));
        }
        pieces.into_par_iter().for_each(|(starts, piece)| {
            for bucket in starts.windows(2) {
                let [from, to] = [bucket[0], bucket[1]].map(|place| (place - starts[0]) as usize);
                piece[from..to].sort_unstable();
            }
        });
    }

    /// The edges of the buckets, each as its entries.
    fn of_buckets(&self, buckets: Range<usize>) -> impl Iterator<Item = &[u64]> {
        self.starts[buckets.start..=buckets.end]
            .windows(2)
            .flat_map(|bucket| {
                self.entries[bucket[0] as usize..bucket[1] as usize]
                    .chunk_by(|a, b| larger_end(*a) == larger_end(*b))
            })
    }

    /// Triangles with the same vertices as one before them, in any order of the vertices; sorted.
    pub(in crate::mesh) fn duplicates(&self) -> Vec<u32> {
        let chunks: Vec<_> = self.chunks().collect();
        let mut found: Vec<u32> = chunks
            .into_par_iter()
            .flat_map_iter(|chunk| {
                self.of_buckets(chunk)
                    .filter(|edge| edge.len() > 1)
                    .flat_map(|edge| self.duplicates_at(edge))
            })
            .collect();
        found.par_sort_unstable();
        found
    }

    /// Each triangle is looked at once: at the edge between its two smallest vertices.
    fn duplicates_at(&self, edge: &[u64]) -> Vec<u32> {
        let mut here: Vec<(u32, u32)> = edge
            .iter()
            .map(|entry| {
                let half_edge = half_edge(entry);
                let face = &self.faces[half_edge as usize / 3];
                (face[(half_edge as usize + 2) % 3], half_edge / 3)
            })
            .filter(|(third, _)| u64::from(*third) > larger_end(edge[0]))
            .collect();
        here.sort_unstable();
        here.windows(2)
            .filter(|pair| pair[0].0 == pair[1].0)
            .map(|pair| pair[1].1)
            .collect()
    }

    /// Pairs half-edges and sorts out those that cannot be paired.
    pub(in crate::mesh) fn kinds(&self) -> Kinds {
        let twins: Vec<AtomicU32> = (0..3 * self.faces.len())
            .into_par_iter()
            .map(|_| AtomicU32::new(NONE))
            .collect();
        let chunks: Vec<_> = self.chunks().collect();
        let parts: Vec<Kinds> = chunks
            .into_par_iter()
            .map(|chunk| {
                let mut part = Kinds::default();
                for edge in self.of_buckets(chunk) {
                    self.sort_out(edge, &twins, &mut part);
                }
                part
            })
            .collect();
        let mut all = Kinds {
            twins: twins.into_iter().map(AtomicU32::into_inner).collect(),
            ..Kinds::default()
        };
        for part in parts {
            all.boundary.extend(part.boundary);
            all.non_manifold.extend(part.non_manifold);
            all.inconsistent.extend(part.inconsistent);
        }
        all
    }

    fn sort_out(&self, edge: &[u64], twins: &[AtomicU32], part: &mut Kinds) {
        match edge {
            [one] => part.boundary.push(half_edge(one)),
            [one, other] => {
                let (one, other) = (half_edge(one), half_edge(other));
                // Nobody else writes these two, and they are read when all are written.
                twins[one as usize].store(other, Ordering::Relaxed);
                twins[other as usize].store(one, Ordering::Relaxed);
                if from_to(self.faces, one) == from_to(self.faces, other) {
                    part.inconsistent.push(one);
                }
            }
            many => {
                let count = u32::try_from(many.len()).unwrap_or(u32::MAX);
                part.non_manifold
                    .extend(many.first().map(|one| (half_edge(one), count)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::*;

    fn faces() -> impl Strategy<Value = Vec<Face>> {
        let face = (0_u32..8, 1_u32..7, 1_u32..6).prop_map(|(a, b, c)| {
            let b = (a + b) % 8;
            let c = (0..8)
                .filter(|v| *v != a && *v != b)
                .nth(c as usize)
                .unwrap_or(NONE);
            if a == 7 { [NONE; 3] } else { [a, b, c] }
        });
        prop::collection::vec(face, 0..40)
    }

    proptest! {
        #[test]
        fn edges_are_those_of_a_map(faces in faces()) {
            let mut map: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
            for (triangle, face) in (0_u32..).zip(&faces).filter(|(_, face)| !is_left_out(face)) {
                for corner in 0..3 {
                    map.entry(ends(face, corner as usize)).or_default().push(3 * triangle + corner);
                }
            }
            let kinds = Edges::new(&faces, 8).kinds();
            let of = |len: usize| map.values().filter(move |edge| edge.len() == len);
            prop_assert_eq!(&kinds.boundary, &of(1).map(|edge| edge[0]).collect::<Vec<_>>());
            for edge in of(2) {
                prop_assert_eq!(kinds.twins[edge[0] as usize], edge[1]);
                prop_assert_eq!(kinds.twins[edge[1] as usize], edge[0]);
            }
            let paired = kinds.twins.iter().filter(|twin| **twin != NONE).count();
            prop_assert_eq!(paired, 2 * of(2).count());
            let more: Vec<_> = map.values().filter(|edge| edge.len() > 2).map(|edge| (edge[0], edge.len())).collect();
            prop_assert_eq!(kinds.non_manifold.iter().map(|(h, n)| (*h, *n as usize)).collect::<Vec<_>>(), more);
        }

        #[test]
        fn duplicates_are_those_of_a_map(faces in faces()) {
            let mut seen = std::collections::BTreeSet::new();
            let expected: Vec<u32> = (0_u32..)
                .zip(&faces)
                .filter(|(_, face)| !is_left_out(face))
                .filter(|(_, face)| {
                    let mut sorted = **face;
                    sorted.sort_unstable();
                    !seen.insert(sorted)
                })
                .map(|(triangle, _)| triangle)
                .collect();
            prop_assert_eq!(Edges::new(&faces, 8).duplicates(), expected);
        }
    }
}
