//! Polygons and spheres of a tree on their way to the device: triangles in chunks, as the tree's segments go.
//!
//! Every vertex is written out where it stands: polygons have none in common, and spheres are few. Placed surfaces go as instances, in
//! `leaf_upload`.

use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use gpu_allocator::MemoryLocation;

use super::{
    error::RenderError,
    gpu::Gpu,
    memory::Buffer,
    staging::{Part, Staging},
    tree_upload::CHUNK_BYTES,
};
use crate::{
    mesh::display::octahedral,
    tree::{
        growth,
        organs::{LookTable, Organ, OrganMesh, Organist},
    },
    world::scene::PlacedTree,
};

/// `Vertex` of shaders/organ.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct Vertex {
    place: [f32; 3],
    /// The look's number and [`THIN`].
    look: u32,
    base: [f32; 3],
    /// Octahedral, two snorm16.
    normal: u32,
}

/// The highest bit of a vertex's look: a sheet with two sides.
const THIN: u32 = 1 << 31;

/// Bytes of an organ's vertex.
pub(crate) const VERTEX_BYTES: usize = size_of::<Vertex>();

const _: () = assert!(VERTEX_BYTES == 32, "shaders/organ.wgsl reads 32 bytes");

/// Organs that one draw shows.
pub(crate) struct OrganChunk {
    pub(crate) vertices: Buffer,
    pub(crate) indices: Buffer,
    /// Number of indices.
    pub(crate) count: u32,
    /// Vertices, then indices.
    staging: Staging,
    pub(crate) set: vk::DescriptorSet,
}

impl OrganChunk {
    /// All polygons and spheres of a placed tree; any thread.
    pub(crate) fn all(
        gpu: &Gpu,
        placed: &PlacedTree,
        looks: &mut LookTable,
    ) -> Result<Vec<Self>, RenderError> {
        let range = CHUNK_BYTES.min(u64::from(gpu.limits.max_storage_buffer_range));
        let most = usize::try_from(range).unwrap_or(usize::MAX) / VERTEX_BYTES;
        let mut maker = Maker {
            placed,
            looks,
            bases: growth::bases(&placed.tree, placed.newest),
            mesh: OrganMesh::default(),
            vertices: Vec::new(),
        };
        let mut organist = Organist::new(&placed.organs);
        let mut chunks = Vec::new();
        for index in 0..placed.organs.polygons.len() + placed.organs.spheres.len() {
            let (more, _) = organist.size(index);
            if !maker.vertices.is_empty() && maker.vertices.len() + more > most {
                chunks.extend(maker.chunk(gpu)?);
            }
            if let Some(organ) = organist.organ(index) {
                organist.add(index, &mut maker.mesh);
                maker.take(organ);
            }
        }
        chunks.extend(maker.chunk(gpu)?);
        Ok(chunks)
    }

    fn new(gpu: &Gpu, vertices: &[Vertex], indices: &[u32]) -> Result<Self, RenderError> {
        let [vertex_bytes, index_bytes] =
            [size_of_val(vertices), size_of_val(indices)].map(|n| n as u64);
        let bytes = vertex_bytes + index_bytes;
        let mut staging = Staging::new(gpu, "the organs on their way", bytes)?;
        staging.write(0, vertices);
        staging.write(vertex_bytes, indices);
        let there = |name, size, usage| {
            let usage = usage | vk::BufferUsageFlags::TRANSFER_DST;
            Buffer::new(gpu, name, size, usage, MemoryLocation::GpuOnly)
        };
        Ok(Self {
            vertices: there(
                "the organs' vertices",
                vertex_bytes,
                vk::BufferUsageFlags::STORAGE_BUFFER,
            )?,
            indices: there(
                "the organs' indices",
                index_bytes,
                vk::BufferUsageFlags::INDEX_BUFFER,
            )?,
            count: u32::try_from(indices.len()).unwrap_or(u32::MAX),
            staging,
            set: vk::DescriptorSet::null(),
        })
    }

    /// Copies up to `budget` bytes more; true when all is there.
    pub(crate) fn copy(
        &mut self,
        gpu: &Gpu,
        commands: vk::CommandBuffer,
        budget: &mut u64,
    ) -> bool {
        let indices = u64::from(self.count) * size_of::<u32>() as u64;
        let parts = [
            Part::staged(&self.vertices, self.vertices.size),
            Part::staged(&self.indices, indices),
        ];
        self.staging.copy(gpu, commands, &parts, budget)
    }

    pub(crate) fn take_staging(&mut self) -> Option<Buffer> {
        self.staging.take()
    }
}

/// Gathers organs until a chunk is full.
struct Maker<'a> {
    placed: &'a PlacedTree,
    looks: &'a mut LookTable,
    /// By node: the nearest whole one.
    bases: Vec<u32>,
    mesh: OrganMesh,
    vertices: Vec<Vertex>,
}

impl Maker<'_> {
    /// Takes over the vertices that an organ has just added to the mesh.
    fn take(&mut self, organ: Organ) {
        let first = self.vertices.len();
        let base = self.base(&organ, first);
        let thin = if organ.thin { THIN } else { 0 };
        let palette = &self.placed.organs.palette;
        let mut last: Option<([f32; 3], u32)> = None;
        let mesh = &self.mesh;
        let new = mesh.positions.iter().zip(&mesh.normals).zip(&mesh.colours);
        for ((place, normal), colour) in new.skip(first) {
            let look = match last {
                Some((same, look)) if same == *colour => look,
                _ => self.looks.number(*colour, palette, organ.paint.material),
            };
            last = Some((*colour, look));
            self.vertices.push(Vertex {
                place: *place,
                look: look | thin,
                base: base.unwrap_or(*place),
                normal: octahedral(Vec3::from(*normal)),
            });
        }
    }

    /// Where an organ unfolds from while the newest step grows; `None` where it is whole.
    fn base(&self, organ: &Organ, first: usize) -> Option<[f32; 3]> {
        let placed = self.placed;
        let Some(base) = self.bases.get(organ.node as usize) else {
            // It hangs on nothing: it grows from its own first vertex.
            let foot = self.mesh.positions.get(first).copied()?;
            return (organ.birth >= placed.newest).then_some(foot);
        };
        let whole = organ.birth < placed.newest && *base == organ.node;
        let foot = placed.tree.position.get(*base as usize)?;
        (!whole).then_some(foot.to_array())
    }

    /// The chunk of what was gathered; none where that is nothing.
    fn chunk(&mut self, gpu: &Gpu) -> Result<Option<OrganChunk>, RenderError> {
        let made = if self.mesh.indices.is_empty() {
            None
        } else {
            Some(OrganChunk::new(gpu, &self.vertices, &self.mesh.indices)?)
        };
        self.vertices.clear();
        self.mesh.clear();
        Ok(made)
    }
}
