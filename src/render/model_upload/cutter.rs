//! Cuts a model into runs of clusters whose buffers a device takes, and numbers each run's vertices anew: the same way each time, so that colours find
//! their places in chunks that went up long before.

use bytemuck::{Pod, Zeroable};

use crate::mesh::display::Display;
use crate::mesh::levels::Cluster;
use crate::mesh::textured::Textured;
use crate::render::{gpu::Gpu, selection::TRIANGLES_MOST};

/// `Vertex` of shaders/model.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct Vertex {
    place: [f32; 3],
    normal: u32,
}

/// One run after the other.
pub(super) struct Cutter<'a> {
    display: &'a Display,
    /// Bytes of a buffer.
    range: usize,
    /// The first cluster that is in no run yet.
    next: usize,
    /// By the model's vertex: the run that met it last, and its number there.
    seen: Vec<(u32, u32)>,
    run: u32,
    /// The model's vertices of this run; those that no run before has come first.
    names: Vec<u32>,
    /// So many of them.
    pub(super) fresh: usize,
    /// By the run's vertices.
    pub(super) triangles: Vec<[u32; 3]>,
    /// With triangles counted from the run's first.
    pub(super) clusters: Vec<Cluster>,
    /// Its first triangle among the model's.
    pub(super) first_triangle: usize,
}

impl<'a> Cutter<'a> {
    pub(super) fn new(display: &'a Display, gpu: &Gpu, chunk_bytes: u64) -> Self {
        let range = chunk_bytes.min(u64::from(gpu.limits.max_storage_buffer_range));
        Self {
            display,
            range: usize::try_from(range).unwrap_or(usize::MAX),
            next: 0,
            seen: vec![(0, 0); display.mesh.positions.len()],
            run: 0,
            names: Vec::new(),
            fresh: 0,
            triangles: Vec::new(),
            clusters: Vec::new(),
            first_triangle: 0,
        }
    }

    /// Goes to the next run; false: there is none.
    pub(super) fn advance(&mut self) -> bool {
        self.run += 1;
        self.names.clear();
        self.triangles.clear();
        self.clusters.clear();
        let levels = &self.display.levels;
        // Vertices that runs before have, by the run's numbers in the order they were met.
        let mut old = Vec::new();
        while let Some(cluster) = levels.clusters.get(self.next) {
            if !self.has_room(cluster) {
                break;
            }
            if self.clusters.is_empty() {
                self.first_triangle = cluster.first as usize;
            }
            let first = u32::try_from(self.triangles.len()).unwrap_or(u32::MAX);
            self.clusters.push(Cluster { first, ..*cluster });
            let triangles = levels.triangles.get(cluster.triangles());
            for triangle in triangles.unwrap_or_default() {
                let numbers = triangle.map(|vertex| self.number(vertex, &mut old));
                self.triangles.push(numbers);
            }
            self.next += 1;
        }
        self.new_ones_first(&old);
        !self.clusters.is_empty()
    }

    /// Whether a cluster fits, be all its vertices new; the first one always does.
    fn has_room(&self, cluster: &Cluster) -> bool {
        let count = cluster.count as usize;
        let triangles = self.triangles.len() + count;
        if triangles > TRIANGLES_MOST {
            return self.clusters.is_empty();
        }
        let vertices = (self.names.len() + 3 * count) * size_of::<Vertex>();
        let triangles = triangles * size_of::<[u32; 3]>();
        let clusters = (self.clusters.len() + 1) * size_of::<Cluster>();
        // What shaders/textured.wgsl reads has 12 bytes a vertex and 4 a triangle: no more than both of these.
        self.clusters.is_empty() || (vertices + triangles).max(clusters) <= self.range
    }

    fn number(&mut self, vertex: u32, old: &mut Vec<bool>) -> u32 {
        let Some(seen) = self.seen.get_mut(vertex as usize) else {
            return 0;
        };
        if seen.0 != self.run {
            old.push(seen.0 != 0);
            *seen = (self.run, u32::try_from(self.names.len()).unwrap_or(0));
            self.names.push(vertex);
        }
        seen.1
    }

    fn new_ones_first(&mut self, old: &[bool]) {
        self.fresh = old.iter().filter(|old| !**old).count();
        let mut next = [0, u32::try_from(self.fresh).unwrap_or(u32::MAX)];
        let places: Vec<u32> = old
            .iter()
            .map(|old| {
                let next = &mut next[usize::from(*old)];
                *next += 1;
                *next - 1
            })
            .collect();
        let mut names = vec![0; self.names.len()];
        for (name, place) in self.names.iter().zip(&places) {
            if let Some(there) = names.get_mut(*place as usize) {
                *there = *name;
            }
        }
        self.names = names;
        for vertex in self.triangles.as_flattened_mut() {
            *vertex = places.get(*vertex as usize).copied().unwrap_or(0);
        }
    }

    pub(super) fn vertices(&self) -> impl Iterator<Item = Vertex> {
        self.names.iter().map(|name| {
            let at = *name as usize;
            let position = self.display.mesh.positions.get(at);
            Vertex {
                place: position.copied().unwrap_or_default().to_array(),
                normal: self.display.normals.get(at).copied().unwrap_or(0),
            }
        })
    }

    /// Its vertices' colours; those that have none are transparent.
    pub(super) fn vertex_colours(&self) -> impl Iterator<Item = [u8; 4]> {
        let colours = &self.display.vertex_colours;
        let colour = |name: &u32| colours.get(*name as usize).copied();
        self.names
            .iter()
            .map(move |name| colour(name).unwrap_or_default())
    }

    /// Its triangles' colours.
    pub(super) fn triangle_colours(&self) -> impl Iterator<Item = [u8; 4]> {
        let colours = &self.display.colours;
        let range = self.first_triangle..self.first_triangle + self.triangles.len();
        let originals = self.display.levels.stands_for.get(range);
        let colour = |original: &u32| colours.get(*original as usize).copied();
        let originals = originals.unwrap_or_default().iter();
        originals.map(move |original| colour(original).unwrap_or_default())
    }

    /// Where the numbers of its triangles' materials begin, its vertices' places in images and colours, and these numbers, as shaders/textured.wgsl
    /// reads them.
    pub(super) fn materials(&self, textured: &Textured) -> Vec<[u8; 4]> {
        let first = 1 + 3 * self.names.len();
        let mut words = Vec::with_capacity(first + self.triangles.len());
        words.push(u32::try_from(first).unwrap_or(u32::MAX).to_ne_bytes());
        for name in &self.names {
            let at = textured.coordinate(*name);
            words.extend([at.x, at.y].map(f32::to_ne_bytes));
            // Red is the lowest byte for the shader, on whatever machine.
            words.push(u32::from_le_bytes(textured.colour(*name)).to_ne_bytes());
        }
        let range = self.first_triangle..self.first_triangle + self.triangles.len();
        let originals = self.display.levels.stands_for.get(range);
        let numbers = originals.unwrap_or_default().iter();
        words.extend(numbers.map(|original| textured.material_of(*original).to_ne_bytes()));
        words
    }
}
