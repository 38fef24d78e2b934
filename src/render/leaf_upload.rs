//! Placed surfaces of a tree on their way to the device: each surface once, and for each place where it stands 48 bytes.
//!
//! A draw shows [`BATCH`] leaves an instance (an instance of a handful of triangles is slow everywhere): the index buffer holds the surface's triangles so
//! often, and the vertex shader finds the leaf from the vertex's number.

use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};
use gpu_allocator::MemoryLocation;

use super::{
    error::RenderError, gpu::Gpu, memory::Buffer, meshes::BATCH, staging::Staging,
    tree_upload::CHUNK_BYTES,
};
use crate::{
    mesh::display::octahedral,
    tree::{
        growth,
        organs::{LookTable, Placed, Surface},
    },
    world::scene::PlacedTree,
};

/// `Leaf` of shaders/leaf.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct Leaf {
    place: [f32; 3],
    scale: f32,
    /// Where it unfolds from while it grows; `place` itself where it is whole.
    base: [f32; 3],
    look: u32,
    /// A quaternion, four snorm16.
    orientation: [i16; 4],
    /// Of the sky's light.
    light: f32,
    /// Bit 0: it grows.
    flags: u32,
}

/// `Corner` of shaders/leaf.wgsl. The first one is no corner: the crown's middle, how round its normals are, and how many corners follow.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct Corner {
    place: [f32; 3],
    normal: u32,
    /// 0: the leaf's look, else a look's number and 1. Of the first one: the number of corners.
    look: u32,
    /// 1: a sheet with two sides.
    thin: u32,
    pad: [u32; 2],
}

const _: () = assert!(
    size_of::<Leaf>() == 48 && size_of::<Corner>() == 32,
    "shaders/leaf.wgsl reads 48 and 32 bytes"
);

/// Leaves of one surface that one draw shows.
pub(crate) struct LeafChunk {
    pub(crate) leaves: Buffer,
    pub(crate) corners: Buffer,
    pub(crate) indices: Buffer,
    /// Indices of a batch.
    pub(crate) count: u32,
    pub(crate) batches: u32,
    /// Leaves, corners, then indices.
    staging: Staging,
    pub(crate) set: vk::DescriptorSet,
}

impl LeafChunk {
    /// All placed surfaces of a tree; any thread.
    pub(crate) fn all(
        gpu: &Gpu,
        placed: &PlacedTree,
        looks: &mut LookTable,
    ) -> Result<Vec<Self>, RenderError> {
        let organs = &placed.organs;
        let range = CHUNK_BYTES.min(u64::from(gpu.limits.max_storage_buffer_range));
        let most = usize::try_from(range).unwrap_or(usize::MAX) / size_of::<Leaf>();
        let bases = growth::bases(&placed.tree, placed.newest);
        let mut by_surface: Vec<Vec<Leaf>> = vec![Vec::new(); organs.surfaces.len()];
        for one in &organs.placed {
            if let Some(of) = by_surface.get_mut(usize::from(one.surface)) {
                of.push(leaf(placed, &bases, one, looks));
            }
        }
        let mut chunks = Vec::new();
        for (surface, leaves) in organs.surfaces.iter().zip(&by_surface) {
            let corners = corners(surface, organs.crown, placed, looks);
            for part in leaves.chunks((most / BATCH as usize).max(1) * BATCH as usize) {
                chunks.push(Self::new(gpu, part, &corners, &surface.indices)?);
            }
        }
        Ok(chunks)
    }

    fn new(
        gpu: &Gpu,
        leaves: &[Leaf],
        corners: &[Corner],
        triangles: &[u32],
    ) -> Result<Self, RenderError> {
        let batch = BATCH as usize;
        let padded = leaves.len().next_multiple_of(batch);
        let each = u32::try_from(corners.len() - 1).unwrap_or(0);
        let indices: Vec<u32> = (0..BATCH)
            .flat_map(|copy| triangles.iter().map(move |at| at + copy * each))
            .collect();
        let sizes = [
            padded * size_of::<Leaf>(),
            size_of_val(corners),
            size_of_val(indices.as_slice()),
        ]
        .map(|bytes| bytes as u64);
        let mut staging = Staging::new(gpu, "the leaves on their way", sizes.iter().sum())?;
        staging.write(0, leaves);
        // Whole batches: spare leaves have no size.
        let spare = [Leaf::default(); BATCH as usize];
        let spare = spare.get(..padded - leaves.len()).unwrap_or_default();
        staging.write(size_of_val(leaves) as u64, spare);
        staging.write(sizes[0], corners);
        staging.write(sizes[0] + sizes[1], &indices);
        let there = |name, size, usage| {
            let usage = usage | vk::BufferUsageFlags::TRANSFER_DST;
            Buffer::new(gpu, name, size, usage, MemoryLocation::GpuOnly)
        };
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        Ok(Self {
            leaves: there("the leaves", sizes[0], storage)?,
            corners: there("a leaf's corners", sizes[1], storage)?,
            indices: there(
                "a leaf's triangles",
                sizes[2],
                vk::BufferUsageFlags::INDEX_BUFFER,
            )?,
            count: u32::try_from(indices.len()).unwrap_or(u32::MAX),
            batches: u32::try_from(padded / batch).unwrap_or(u32::MAX),
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
        let parts = [&self.leaves, &self.corners, &self.indices];
        let parts = parts.map(|buffer| (buffer.handle, buffer.size));
        self.staging.copy(gpu, commands, &parts, budget)
    }

    pub(crate) fn take_staging(&mut self) -> Option<Buffer> {
        self.staging.take()
    }
}

fn leaf(placed: &PlacedTree, bases: &[u32], one: &Placed, looks: &mut LookTable) -> Leaf {
    let organs = &placed.organs;
    let surface = organs.surfaces.get(usize::from(one.surface));
    let own = surface.and_then(|surface| surface.tones.first());
    let colour = organs.palette.colour(one.paint.colour);
    let colour = colour.or(own.map(|tone| tone.colour)).unwrap_or_default();
    let base = base(placed, bases, one);
    #[allow(clippy::cast_possible_truncation, reason = "-1 to 1")]
    let packed = |part: f32| (part.clamp(-1.0, 1.0) * 32767.0).round() as i16;
    Leaf {
        place: one.position.to_array(),
        scale: one.scale,
        base: base.unwrap_or(one.position).to_array(),
        look: looks.number(colour, &organs.palette, one.paint.material),
        orientation: Quat::to_array(&one.orientation).map(packed),
        light: one.light,
        flags: u32::from(base.is_some()),
    }
}

/// Where a leaf unfolds from while the newest step grows; `None` where it is whole.
fn base(placed: &PlacedTree, bases: &[u32], one: &Placed) -> Option<Vec3> {
    let Some(base) = bases.get(one.node as usize) else {
        // It hangs on nothing: it grows where it stands.
        return (one.birth >= placed.newest).then_some(one.position);
    };
    let whole = one.birth < placed.newest && *base == one.node;
    let foot = placed.tree.position.get(*base as usize)?;
    (!whole).then_some(*foot)
}

/// The header and the corners of a surface.
fn corners(
    surface: &Surface,
    crown: Vec3,
    placed: &PlacedTree,
    looks: &mut LookTable,
) -> Vec<Corner> {
    let mut corners = vec![Corner {
        place: crown.to_array(),
        normal: surface.rounded.to_bits(),
        look: u32::try_from(surface.positions.len()).unwrap_or(0),
        thin: u32::from(surface.thin),
        pad: [0; 2],
    }];
    for (at, place) in surface.positions.iter().enumerate() {
        let tone = surface.tone.get(at).copied().unwrap_or(0);
        let fixed = surface.tones.get(usize::from(tone)).filter(|_| tone > 0);
        let look = fixed.map_or(0, |tone| {
            looks.number(tone.colour, &placed.organs.palette, 0) + 1
        });
        corners.push(Corner {
            place: place.to_array(),
            normal: octahedral(surface.normals.get(at).copied().unwrap_or(Vec3::Z)),
            look,
            ..Corner::default()
        });
    }
    corners
}
