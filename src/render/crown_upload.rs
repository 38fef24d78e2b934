//! Branches or leaves in levels of detail on their way to the device: records, clusters, and as what these are drawn.

use std::{slice::from_ref, sync::Arc};

use ash::vk;
use bytemuck::Pod;
use glam::{Vec3, Vec4};
use gpu_allocator::MemoryLocation;

use super::{
    error::RenderError,
    gpu::Gpu,
    memory::Buffer,
    resident::{self, Resident},
    staging::{Part, Source, Staging},
};
use crate::tree::levels::{
    BATCH, Cluster, Levels, Record,
    kinds::{KINDS, Kind},
};

/// Clusters that one descriptor set shows.
pub(crate) struct CrownChunk {
    pub(crate) records: Arc<Buffer>,
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
    /// Records, from the device or staged, then clusters.
    parts: Vec<Part>,
    staging: Staging,
    /// How many bytes are staged.
    pub(crate) sent: u64,
    /// What the drawing of it reads, and what the choice does; once the renderer has taken it.
    pub(crate) set: vk::DescriptorSet,
    pub(crate) choice: vk::DescriptorSet,
}

/// Where chunks are made.
pub(crate) struct Making<'a> {
    pub(crate) gpu: &'a Gpu,
    /// Bytes of a chunk at most.
    pub(crate) chunk_bytes: u64,
    /// What the device has already.
    pub(crate) before: Option<&'a Resident>,
    /// What it will have.
    pub(crate) resident: &'a mut Resident,
}

impl CrownChunk {
    /// All levels in chunks of at most so many bytes, but of one cluster at least; any thread.
    pub(crate) fn all<R: Record + Pod>(
        making: &mut Making<'_>,
        levels: &Levels<R>,
        table: [Kind; KINDS],
    ) -> Result<Vec<Self>, RenderError> {
        let device = u64::from(making.gpu.limits.max_storage_buffer_range);
        let range = making.chunk_bytes.min(device);
        let batch_bytes = (BATCH * size_of::<R>()) as u64;
        let most = u32::try_from(range / batch_bytes).unwrap_or(u32::MAX);
        let mut chunks = Vec::new();
        let mut rest = levels.clusters.as_slice();
        while let Some(first) = rest.first() {
            let fits = |cluster: &Cluster| cluster.first + cluster.batches - first.first <= most;
            let count = rest.partition_point(fits).max(1);
            let (part, after) = rest.split_at(count);
            chunks.push(Self::new(making, levels, part, table)?);
            rest = after;
        }
        Ok(chunks)
    }

    fn new<R: Record + Pod>(
        making: &mut Making<'_>,
        levels: &Levels<R>,
        part: &[Cluster],
        table: [Kind; KINDS],
    ) -> Result<Self, RenderError> {
        let gpu = making.gpu;
        let first = part.first().map_or(0, |cluster| cluster.first);
        let runs: Vec<&[u8]> = part
            .iter()
            .map(|cluster| levels.bytes_of(from_ref(cluster)))
            .collect();
        let clusters: Vec<Cluster> = part
            .iter()
            .map(|cluster| Cluster {
                first: cluster.first - first,
                ..*cluster
            })
            .collect();
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let there = |name, size: usize| {
            let copied = vk::BufferUsageFlags::TRANSFER_DST | vk::BufferUsageFlags::TRANSFER_SRC;
            let device = MemoryLocation::GpuOnly;
            Buffer::new(gpu, name, size as u64, storage | copied, device)
        };
        let size = levels.bytes_of(part).len();
        let records = Arc::new(there("a crown's records", size)?);
        let table_bytes = size_of_val(clusters.as_slice());
        let cluster_buffer = there("a crown's clusters", table_bytes)?;

        let hashes = resident::hashes(&runs);
        making.resident.add(&records, &runs, &hashes);
        let mut parts = resident::parts(&runs, &hashes, records.handle, making.before);
        let (staging, sent) = staged(gpu, levels.bytes_of(part), &parts, &clusters)?;
        parts.push(Part::staged(&cluster_buffer, table_bytes as u64));

        let bytes = size_of_val(&table) as u64;
        let seen = MemoryLocation::CpuToGpu;
        let mut kinds = Buffer::new(gpu, "a crown's kinds", bytes, storage, seen)?;
        kinds.write(0, &table);
        let sizes_of = part.iter().map(|cluster| cluster.size);
        Ok(Self {
            records,
            clusters: cluster_buffer,
            kinds,
            table,
            count: u32::try_from(part.len()).unwrap_or(u32::MAX),
            sphere: around(part),
            size: sizes_of.fold(0.0, f32::max),
            parts,
            staging,
            sent,
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
        self.staging.copy(gpu, commands, &self.parts, budget)
    }

    pub(crate) fn take_staging(&mut self) -> Option<Buffer> {
        self.staging.take()
    }
}

/// Staging memory with what is to be staged of records, and clusters behind it; and how much that is.
fn staged(
    gpu: &Gpu,
    records: &[u8],
    parts: &[Part],
    clusters: &[Cluster],
) -> Result<(Staging, u64), RenderError> {
    let staged = || parts.iter().filter(|part| part.from == Source::Staged);
    let new: u64 = staged().map(|part| part.size).sum();
    let sent = new + size_of_val(clusters) as u64;
    let mut staging = Staging::new(gpu, "a crown on its way", sent)?;
    let mut written = 0;
    for part in staged() {
        let own = usize::try_from(part.at)
            .ok()
            .zip(usize::try_from(part.size).ok());
        let own = own.and_then(|(at, size)| records.get(at..)?.get(..size));
        staging.write(written, own.unwrap_or_default());
        written += part.size;
    }
    staging.write(new, clusters);
    Ok((staging, sent))
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
