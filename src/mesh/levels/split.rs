//! Triangles cut into clusters: in two where they reach farthest, and again, until each part is one.
//!
//! Parts are equal, so that clusters are full, and as long as wide, so that their borders are short.
//!
//! *Tried*: meshoptimizer's clusterizer (`meshopt_buildMeshlets`), which takes triangle after triangle beside those that a cluster has. It took a
//! third of the time of all levels, half a microsecond a triangle, and says not which triangle is which, so that each had to be looked for;
//! spheres were 4 to 8 % larger, and cuts of the same error had as many triangles or, on a smooth ring, up to four fifths more.

use glam::Vec3;

use super::local::Local;
use super::{MOST_TRIANGLES, MOST_VERTICES};

/// A triangle's middle, and its number.
type Middle = (Vec3, u32);

/// Numbers of the triangles of each cluster, ascending.
pub(super) fn split(local: &Local, triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    // Halves and thirds first: the sum of large coordinates is none.
    let middle = |triangle: &[u32; 3]| {
        let corners = triangle.map(|vertex| local.position(vertex) / 3.0);
        corners.into_iter().sum::<Vec3>()
    };
    let mut middles: Vec<Middle> = triangles.iter().map(middle).zip(0..).collect();
    let mut splitter = Splitter {
        triangles,
        seen: vec![0; local.vertices.len()],
        clusters: Vec::with_capacity(triangles.len() / MOST_TRIANGLES + 1),
    };
    splitter.split(&mut middles);
    splitter.clusters
}

struct Splitter<'a> {
    triangles: &'a [[u32; 3]],
    /// For each vertex the last part that was looked at and has it, counted from 1.
    seen: Vec<u32>,
    clusters: Vec<Vec<u32>>,
}

impl Splitter<'_> {
    fn split(&mut self, middles: &mut [Middle]) {
        let parts = middles.len().div_ceil(MOST_TRIANGLES);
        if parts == 0 {
            return;
        }
        if parts == 1 && (middles.len() == 1 || self.has_few_vertices(middles)) {
            let mut numbers: Vec<u32> = middles.iter().map(|(_, number)| *number).collect();
            numbers.sort_unstable();
            self.clusters.push(numbers);
            return;
        }
        let parts = parts.max(2);
        let left = middles.len() * (parts / 2) / parts;
        let axis = longest(middles);
        middles.select_nth_unstable_by(left, |(a, first), (b, second)| {
            a[axis].total_cmp(&b[axis]).then(first.cmp(second))
        });
        let (low, high) = middles.split_at_mut(left);
        self.split(low);
        self.split(high);
    }

    /// Whether a part that has few triangles has few enough vertices, too.
    fn has_few_vertices(&mut self, middles: &[Middle]) -> bool {
        if 3 * middles.len() <= MOST_VERTICES {
            return true;
        }
        let part = u32::try_from(self.clusters.len() + 1).unwrap_or(u32::MAX);
        let mut count = 0;
        for (_, number) in middles {
            for vertex in self.triangles.get(*number as usize).into_iter().flatten() {
                if let Some(seen) = self.seen.get_mut(*vertex as usize)
                    && *seen != part
                {
                    *seen = part;
                    count += 1;
                }
            }
        }
        count <= MOST_VERTICES
    }
}

/// The axis along which points reach farthest.
fn longest(middles: &[Middle]) -> usize {
    let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = middles
        .iter()
        .fold(start, |(low, high), (at, _)| (low.min(*at), high.max(*at)));
    // Halved first: the difference of two large coordinates is none.
    (high * 0.5 - low * 0.5).max_position()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;
    use crate::mesh::made;

    #[test]
    fn clusters_are_full_and_have_each_triangle_once() {
        let ball = made::sphere(4);
        let mut twisted = made::soup(&ball);
        twisted.positions.fill(Vec3::ONE);
        for mesh in [made::sphere(0), made::soup(&ball), twisted, ball] {
            let local = Local::new(&mesh, &mesh.triangles);
            let (triangles, _) = local.indices.as_chunks::<3>();
            let clusters = split(&local, triangles);
            let mut all = clusters.concat();
            all.sort_unstable();
            assert!(all.into_iter().eq((0..).take(triangles.len())));
            for cluster in &clusters {
                assert!((1..=MOST_TRIANGLES).contains(&cluster.len()));
                let corners = cluster.iter().flat_map(|&it| triangles[it as usize]);
                let mut vertices: Vec<u32> = corners.collect();
                vertices.sort_unstable();
                vertices.dedup();
                assert!(vertices.len() <= MOST_VERTICES);
            }
            let is_whole = local.vertices.len() < triangles.len();
            let fewest = triangles.len().div_ceil(MOST_TRIANGLES);
            assert!(!is_whole || clusters.len() == fewest);
        }
    }
}
