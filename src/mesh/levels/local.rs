//! A few triangles with vertices numbered anew from 0, as the clusterizer and the simplifier take them: both look at all vertices that they are given.

use glam::Vec3;
use meshopt::VertexDataAdapter;

use super::{MOST_TRIANGLES, MOST_VERTICES};
use crate::mesh::Mesh;

/// Triangles by vertices of their own.
pub(super) struct Local {
    /// The mesh's vertices, ascending.
    pub(super) vertices: Vec<u32>,
    pub(super) positions: Vec<Vec3>,
    /// Three a triangle.
    pub(super) indices: Vec<u32>,
}

/// Which of the triangles that were given, in clusters.
pub(super) struct Clustered {
    /// Three local vertices each, cluster after cluster.
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each its number among those given.
    pub(super) numbers: Vec<u32>,
    /// Triangles of each cluster.
    pub(super) counts: Vec<usize>,
}

impl Local {
    /// Of triangles whose vertices the mesh has.
    pub(super) fn new(mesh: &Mesh, triangles: &[[u32; 3]]) -> Self {
        let corners = triangles.as_flattened();
        let mut vertices = corners.to_vec();
        vertices.sort_unstable();
        vertices.dedup();
        let number = |vertex: &u32| u32::try_from(vertices.binary_search(vertex).unwrap_or(0));
        let indices = corners
            .iter()
            .map(|vertex| number(vertex).unwrap_or(0))
            .collect();
        let position = |vertex: &u32| mesh.positions.get(*vertex as usize).copied();
        let positions = vertices
            .iter()
            .map(|vertex| position(vertex).unwrap_or_default())
            .collect();
        Self {
            vertices,
            positions,
            indices,
        }
    }

    /// The vertices as the library reads them; none of no vertices.
    pub(super) fn adapter(&self) -> Option<VertexDataAdapter<'_>> {
        adapter(&self.positions)
    }

    pub(super) fn position(&self, vertex: u32) -> Vec3 {
        self.positions
            .get(vertex as usize)
            .copied()
            .unwrap_or_default()
    }

    /// By the mesh's vertices.
    pub(super) fn globally(&self, triangle: [u32; 3]) -> [u32; 3] {
        triangle.map(|vertex| self.vertices.get(vertex as usize).copied().unwrap_or(0))
    }

    /// Cuts triangles of these vertices into clusters.
    pub(super) fn clusters(&self, indices: &[u32]) -> Clustered {
        let mut found = Clustered {
            triangles: Vec::with_capacity(indices.len() / 3),
            numbers: Vec::with_capacity(indices.len() / 3),
            counts: Vec::new(),
        };
        // The clusterizer squares distances, which of very large coordinates are none, and loses triangles then.
        let most = self.positions.iter().map(|at| at.abs().max_element());
        let most = most.fold(f32::MIN_POSITIVE, f32::max);
        let scaled: Vec<Vec3> = self.positions.iter().map(|at| *at / most).collect();
        let Some(adapter) = adapter(&scaled) else {
            return found;
        };
        let (triangles, _) = indices.as_chunks::<3>();
        let mut numbers = Numbers::new(triangles);
        let made = meshopt::build_meshlets(indices, &adapter, MOST_VERTICES, MOST_TRIANGLES, 0.0);
        for cluster in made.iter() {
            let (corners, _) = cluster.triangles.as_chunks::<3>();
            for corners in corners {
                let vertex = |corner: u8| cluster.vertices.get(usize::from(corner)).copied();
                let triangle = corners.map(|corner| vertex(corner).unwrap_or(0));
                found.triangles.push(triangle);
                found.numbers.push(numbers.take(triangle));
            }
            found.counts.push(corners.len());
        }
        found
    }
}

/// Positions as the library reads them; none of no vertices.
pub(super) fn adapter(positions: &[Vec3]) -> Option<VertexDataAdapter<'_>> {
    let bytes = bytemuck::cast_slice(positions);
    VertexDataAdapter::new(bytes, size_of::<Vec3>(), 0)
        .ok()
        .filter(|adapter| adapter.vertex_count > 0)
}

/// Finds triangles again whose corners were turned round: the clusterizer says no numbers.
struct Numbers {
    /// Ascending corners with numbers, sorted.
    sorted: Vec<([u32; 3], u32)>,
    /// Of the first of equal ones, how many were taken.
    taken: Vec<u32>,
}

impl Numbers {
    fn new(triangles: &[[u32; 3]]) -> Self {
        let key = |triangle: &[u32; 3]| ascending(*triangle);
        let mut sorted: Vec<_> = triangles.iter().map(key).zip(0..).collect();
        sorted.sort_unstable();
        Self {
            taken: vec![0; sorted.len()],
            sorted,
        }
    }

    /// The number of a triangle; of equal ones each once.
    fn take(&mut self, triangle: [u32; 3]) -> u32 {
        let key = ascending(triangle);
        let first = self.sorted.partition_point(|(other, _)| *other < key);
        let Some(taken) = self.taken.get_mut(first) else {
            return 0;
        };
        let found = self.sorted.get(first + *taken as usize);
        *taken += 1;
        found.map_or(0, |(_, number)| *number)
    }
}

fn ascending(mut triangle: [u32; 3]) -> [u32; 3] {
    triangle.sort_unstable();
    triangle
}
