//! A surface to walk on: triangles by joined vertices, each with its neighbours, and the picker over them.
//!
//! Vertices of exactly equal coordinates are one, as in the [report](super::report), so surfaces of files that part vertices at seams hang together.

pub(crate) mod graph;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use glam::{DVec3, Vec3};

use self::graph::Graph;
use super::Mesh;
use super::pick::Picker;
use super::report::{NONE, Neighbours, neighbours};

/// A mesh with what is needed to walk on it.
#[derive(Clone, Debug)]
pub struct Surface {
    picker: Picker,
    /// Half-edges are numbered three a triangle, from corner to corner.
    neighbours: Neighbours,
    graph: OnceLock<Graph>,
}

impl Surface {
    /// Finds the neighbours. None when `cancel` was set, or for more triangles than can be numbered.
    pub fn new(picker: Picker, cancel: &AtomicBool) -> Option<Self> {
        let neighbours = neighbours(picker.mesh(), cancel)?;
        (!cancel.load(Ordering::Relaxed)).then_some(Self {
            picker,
            neighbours,
            graph: OnceLock::new(),
        })
    }

    /// The picker over it.
    pub fn picker(&self) -> &Picker {
        &self.picker
    }

    /// The mesh that it is of.
    pub fn mesh(&self) -> &Arc<Mesh> {
        self.picker.mesh()
    }

    /// Triangles by joined vertices.
    pub(crate) fn faces(&self) -> &[[u32; 3]] {
        &self.neighbours.faces
    }

    /// Those of them that the surface has, with their numbers.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = (u32, [u32; 3])> {
        (0_u32..)
            .zip(&self.neighbours.faces)
            .filter(|(_, face)| face[0] != NONE)
            .map(|(triangle, face)| (triangle, *face))
    }

    /// Which vertices have an edge to which; made when it is first asked for.
    pub(crate) fn graph(&self) -> &Graph {
        self.graph.get_or_init(|| Graph::new(self))
    }

    /// A third of the area of the triangles at each vertex.
    pub(crate) fn vertex_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.mesh().positions.len()];
        for (_, face) in self.triangles() {
            let [a, b, c] = face.map(|vertex| self.position(vertex));
            let third = (b - a).cross(c - a).length() / 6.0;
            face.iter()
                .for_each(|vertex| areas[*vertex as usize] += third);
        }
        areas
    }

    /// Vertices of each open end.
    pub(crate) fn open_ends(&self) -> &[Vec<u32>] {
        &self.neighbours.loops
    }

    /// The half-edge on the other side of one.
    pub(crate) fn twin(&self, half_edge: u32) -> Option<u32> {
        let twin = self.neighbours.twins.get(half_edge as usize).copied();
        twin.filter(|twin| *twin != NONE)
    }

    /// Where a vertex is.
    pub(crate) fn position(&self, vertex: u32) -> DVec3 {
        let position = self.mesh().positions.get(vertex as usize);
        position.copied().unwrap_or(Vec3::ZERO).as_dvec3()
    }

    /// From where to where a half-edge leads; None where its triangle is none of the surface.
    pub(crate) fn ends(&self, half_edge: u32) -> Option<[u32; 2]> {
        let face = self.neighbours.faces.get(half_edge as usize / 3)?;
        let corner = half_edge as usize % 3;
        (face[0] != NONE).then_some([face[corner], face[(corner + 1) % 3]])
    }

    /// Sums of the cross products of the triangles at each vertex: normals that are not of length 1, weighted by area.
    pub(crate) fn vertex_normals(&self) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; self.mesh().positions.len()];
        for (_, face) in self.triangles() {
            let [a, b, c] = face.map(|vertex| self.position(vertex));
            let cross = (b - a).cross(c - a);
            face.iter()
                .for_each(|vertex| sums[*vertex as usize] += cross);
        }
        sums
    }
}

/// The half-edge behind one in its triangle.
pub(super) fn next(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 {
        half_edge - 2
    } else {
        half_edge + 1
    }
}

/// The half-edge before one in its triangle.
pub(super) fn previous(half_edge: u32) -> u32 {
    next(next(half_edge))
}
