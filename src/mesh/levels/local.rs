//! A few triangles with vertices numbered anew from 0, as the clusterizer and the simplifier take them: both look at all vertices that they are given.

use glam::{Vec3, Vec4};
use hashbrown::HashMap;
use meshopt::VertexDataAdapter;

use super::split::split;
use super::{MOST_TRIANGLES, around};
use crate::mesh::Mesh;

/// Triangles by vertices of their own.
pub(super) struct Local {
    /// The mesh's vertices, as they first come.
    pub(super) vertices: Vec<u32>,
    pub(super) positions: Vec<Vec3>,
    /// Three a triangle.
    pub(super) indices: Vec<u32>,
}

/// Clusters of triangles.
#[derive(Default)]
pub(super) struct Clustered {
    /// By the mesh's vertices, cluster after cluster.
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each the mesh's that it stands for.
    pub(super) stands_for: Vec<u32>,
    /// Of each cluster the triangles and the sphere around them.
    pub(super) clusters: Vec<(usize, Vec4)>,
}

impl Local {
    /// Of triangles whose vertices the mesh has.
    pub(super) fn new(mesh: &Mesh, triangles: &[[u32; 3]]) -> Self {
        let corners = triangles.as_flattened();
        let mut vertices = Vec::with_capacity(corners.len() / 5);
        let mut numbers = HashMap::with_capacity(corners.len() / 5);
        let number = |vertex: &u32| {
            *numbers.entry(*vertex).or_insert_with(|| {
                vertices.push(*vertex);
                u32::try_from(vertices.len() - 1).unwrap_or(u32::MAX)
            })
        };
        let indices = corners.iter().map(number).collect();
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

    /// Cuts triangles of these vertices into clusters; `stands_for` has for each the mesh's.
    pub(super) fn clusters(&self, indices: &[u32], stands_for: &[u32]) -> Clustered {
        let (triangles, _) = indices.as_chunks::<3>();
        let mut made = Clustered {
            triangles: Vec::with_capacity(triangles.len()),
            stands_for: Vec::with_capacity(triangles.len()),
            clusters: Vec::with_capacity(triangles.len() / MOST_TRIANGLES + 1),
        };
        for cluster in split(self, triangles) {
            let all = || {
                cluster
                    .iter()
                    .filter_map(|number| triangles.get(*number as usize))
            };
            let corners = all().flatten().map(|vertex| self.position(*vertex));
            made.clusters.push((cluster.len(), around(corners)));
            made.triangles
                .extend(all().map(|triangle| self.globally(*triangle)));
            let original = |number: &u32| stands_for.get(*number as usize).copied().unwrap_or(0);
            made.stands_for.extend(cluster.iter().map(original));
        }
        made
    }
}

/// Positions as the library reads them; none of no vertices.
pub(super) fn adapter(positions: &[Vec3]) -> Option<VertexDataAdapter<'_>> {
    let bytes = bytemuck::cast_slice(positions);
    VertexDataAdapter::new(bytes, size_of::<Vec3>(), 0)
        .ok()
        .filter(|adapter| adapter.vertex_count > 0)
}
