//! Branches or leaves in levels of detail on their way to the device: records, clusters, and as what these are drawn.

use ash::vk;
use bytemuck::Pod;
use glam::{Vec3, Vec4};
use gpu_allocator::MemoryLocation;

use super::{error::RenderError, gpu::Gpu, memory::Buffer, staging::Staging};
use crate::tree::levels::{
    BATCH, Cluster, Levels, Record,
    kinds::{KINDS, Kind},
};

/// Clusters that one descriptor set shows.
pub(crate) struct CrownChunk {
    pub(crate) records: Buffer,
    pub(crate) clusters: Buffer,
    /// By kind how a batch is drawn: few bytes, which stay where the processor wrote them.
    pub(crate) kinds: Buffer,
    /// The same where the processor reads it.
    pub(crate) table: [Kind; KINDS],
    /// How many clusters.
    pub(crate) count: u32,
    /// Around all of them, in the tree's frame, and the largest [`Cluster::size`].
    pub(crate) sphere: Vec4,
    pub(crate) size: f32,
    /// Records, then clusters.
    staging: Staging,
    /// What the drawing of it reads, and what the choice does; once the renderer has taken it.
    pub(crate) set: vk::DescriptorSet,
    pub(crate) choice: vk::DescriptorSet,
}

impl CrownChunk {
    /// All levels in chunks of at most so many bytes, but of one cluster at least; any thread.
    pub(crate) fn all<R: Record + Pod>(
        gpu: &Gpu,
        levels: &Levels<R>,
        table: [Kind; KINDS],
        chunk_bytes: u64,
    ) -> Result<Vec<Self>, RenderError> {
        let range = chunk_bytes.min(u64::from(gpu.limits.max_storage_buffer_range));
        let batch_bytes = (BATCH * size_of::<R>()) as u64;
        let most = u32::try_from(range / batch_bytes).unwrap_or(u32::MAX);
        let mut chunks = Vec::new();
        let mut rest = levels.clusters.as_slice();
        while let Some(first) = rest.first() {
            let fits = |cluster: &Cluster| cluster.first + cluster.batches - first.first <= most;
            let count = rest.partition_point(fits).max(1);
            let (part, after) = rest.split_at(count);
            chunks.push(Self::new(gpu, levels, part, table)?);
            rest = after;
        }
        Ok(chunks)
    }

    fn new<R: Record + Pod>(
        gpu: &Gpu,
        levels: &Levels<R>,
        part: &[Cluster],
        table: [Kind; KINDS],
    ) -> Result<Self, RenderError> {
        let first = part.first().map_or(0, |cluster| cluster.first);
        let end = part.last().map_or(0, |last| last.first + last.batches);
        let run = first as usize * BATCH..end as usize * BATCH;
        let records = levels.records.get(run).unwrap_or_default();
        let clusters: Vec<Cluster> = part
            .iter()
            .map(|cluster| Cluster {
                first: cluster.first - first,
                ..*cluster
            })
            .collect();
        let sizes = [size_of_val(records), size_of_val(clusters.as_slice())].map(|n| n as u64);
        let mut staging = Staging::new(gpu, "a crown on its way", sizes.iter().sum())?;
        staging.write(0, records);
        staging.write(sizes[0], &clusters);
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let there = |name, size| {
            let usage = storage | vk::BufferUsageFlags::TRANSFER_DST;
            Buffer::new(gpu, name, size, usage, MemoryLocation::GpuOnly)
        };
        let bytes = size_of_val(&table) as u64;
        let seen = MemoryLocation::CpuToGpu;
        let mut kinds = Buffer::new(gpu, "a crown's kinds", bytes, storage, seen)?;
        kinds.write(0, &table);
        let sizes_of = part.iter().map(|cluster| cluster.size);
        Ok(Self {
            records: there("a crown's records", sizes[0])?,
            clusters: there("a crown's clusters", sizes[1])?,
            kinds,
            table,
            count: u32::try_from(part.len()).unwrap_or(u32::MAX),
            sphere: around(part),
            size: sizes_of.fold(0.0, f32::max),
            staging,
            set: vk::DescriptorSet::null(),
            choice: vk::DescriptorSet::null(),
        })
    }

    /// Copies up to `budget` bytes more; true when all is there.
    pub(crate) fn copy(
        &mut self,
        gpu: &Gpu,
        commands: vk::CommandBuffer,
        budget: &mut u64,
    ) -> bool {
        let parts = [&self.records, &self.clusters].map(|buffer| (buffer.handle, buffer.size));
        self.staging.copy(gpu, commands, &parts, budget)
    }

    pub(crate) fn take_staging(&mut self) -> Option<Buffer> {
        self.staging.take()
    }
}

/// A sphere around clusters.
fn around(clusters: &[Cluster]) -> Vec4 {
    let spheres = || clusters.iter().map(|cluster| cluster.sphere);
    let nowhere = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = spheres().fold(nowhere, |(low, high), sphere| {
        let middle = sphere.truncate();
        (low.min(middle - sphere.w), high.max(middle + sphere.w))
    });
    let middle = (low + high) / 2.0;
    let reach = |sphere: Vec4| sphere.truncate().distance(middle) + sphere.w;
    middle.extend(spheres().map(reach).fold(0.0, f32::max) * 1.000_01)
}
