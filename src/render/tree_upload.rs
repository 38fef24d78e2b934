//! The tree's segments on their way to the device.
//!
//! [`TreeUpload::new`] does everything that takes long (building the segments, copying them to
//! staging memory) and may run on any thread; the renderer then copies at most
//! [`COPY_BYTES`] a frame to the device and swaps the tree in when all of it is there.
//! A storage buffer may be limited to 128 MiB, so large trees are cut into chunks of
//! whole clusters, each with its own buffers and descriptor set.

use std::sync::Arc;

use ash::vk;
use glam::Vec3;
use gpu_allocator::MemoryLocation;

use super::{
    crown_upload::{CrownChunk, Making},
    error::RenderError,
    frame::Pool,
    gpu::Gpu,
    leaf_upload::LeafChunk,
    memory::Buffer,
    organ_upload::OrganChunk,
    resident::Resident,
    texture::Texture,
};
use crate::{
    tree::{
        bark::Bark,
        levels::{Levels, Record, along_axes, kinds::of_tubes},
        organs::{LookTable, paint_segments, refined},
        tubes::{self, SegmentBuilder, TubeSegment},
    },
    world::scene::PlacedTree,
};

/// A frame copies at most so much of a new tree, so that no frame is late for it.
pub(crate) const COPY_BYTES: u64 = 32 << 20;

/// A chunk is never larger than this, whatever the device allows.
pub(crate) const CHUNK_BYTES: u64 = 256 << 20;

/// A sphere around the whole tree, the radius at its foot, and where that is, in the tree's own frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
    pub(crate) foot: f32,
    pub(crate) root: Vec3,
}

impl Bounds {
    /// Makes the sphere large enough for a box, too.
    fn include(&mut self, corners: Option<(Vec3, Vec3)>) {
        let Some((low, high)) = corners else { return };
        let (low, high) = if self.radius > 0.0 {
            let own = [self.center - self.radius, self.center + self.radius];
            (low.min(own[0]), high.max(own[1]))
        } else {
            (low, high)
        };
        self.center = (low + high) / 2.0;
        self.radius = low.distance(high) / 2.0;
    }
}

/// A tree that is ready to be copied to the device.
pub struct TreeUpload {
    pub(crate) revision: u64,
    pub(crate) segments: u32,
    pub(crate) bounds: Bounds,
    /// Branches.
    pub(crate) chunks: Vec<CrownChunk>,
    /// Polygons and spheres.
    pub(crate) organs: Vec<OrganChunk>,
    /// Surfaces.
    pub(crate) leaves: Vec<LeafChunk>,
    /// Whether there are coarser levels.
    pub(crate) detail: Detail,
    /// What the device has of it for the next tree,
    pub(crate) resident: Arc<Resident>,
    /// and what it is copied from itself, until it has been.
    before: Option<Arc<Resident>>,
    /// What plain segments are covered by, and its picture, once the renderer has taken the upload.
    pub(crate) bark: Bark,
    pub(crate) picture: Option<Arc<Texture>>,
    /// Colours and materials.
    pub(crate) looks: Buffer,
    /// The chunks' sets, once the renderer has taken the upload.
    pub(crate) pool: Option<Pool>,
}

/// How much is made of a tree before it is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Detail {
    /// All levels.
    Levels,
    /// The finest one, where a frame waits for it.
    Finest,
}

impl Detail {
    /// So many records, each by its place.
    pub(crate) fn of<R: Record>(
        self,
        count: usize,
        record: impl Fn(usize) -> R + Sync,
    ) -> Levels<R> {
        match self {
            Self::Levels => Levels::of(count, record),
            Self::Finest => Levels::finest(count, record),
        }
    }
}

/// Scratch memory that small uploads on the frame's thread reuse.
#[derive(Default)]
pub(crate) struct Scratch {
    builder: SegmentBuilder,
    segments: Vec<TubeSegment>,
}

impl TreeUpload {
    /// Builds the segments of a placed tree and fills staging memory with what the device does not have of it: see [`Renderer::resident`](super::Renderer::resident). Any thread.
    ///
    /// # Errors
    /// [`RenderError::OutOfMemory`].
    pub fn new(
        gpu: &Gpu,
        placed: &PlacedTree,
        before: Option<Arc<Resident>>,
    ) -> Result<Self, RenderError> {
        Self::with_scratch(gpu, placed, before, &mut Scratch::default(), Detail::Levels)
    }

    pub(crate) fn with_scratch(
        gpu: &Gpu,
        placed: &PlacedTree,
        before: Option<Arc<Resident>>,
        scratch: &mut Scratch,
        detail: Detail,
    ) -> Result<Self, RenderError> {
        let fine = refined(&placed.tree, &placed.organs, &placed.radius_before);
        let (tree, radius_before) = fine
            .as_ref()
            .map_or((&*placed.tree, placed.radius_before.as_slice()), |fine| {
                (&fine.tree, fine.radius_before.as_slice())
            });
        scratch
            .builder
            .build(tree, radius_before, placed.newest, &mut scratch.segments);
        let mut looks = LookTable::of(placed.organs.bark);
        // Painted here, where there is time.
        let _ = placed.organs.bark.maps();
        paint_segments(
            &placed.tree,
            &placed.organs,
            fine.as_ref(),
            &mut scratch.segments,
            &mut looks,
        );
        let order = along_axes(tree, scratch.builder.axis());
        let segments = &scratch.segments;
        let record = |at: usize| order.get(at).and_then(|at| segments.get(*at as usize));
        let levels = detail.of(order.len(), |at| record(at).copied().unwrap_or_default());
        let mut resident = Resident::default();
        let mut making = Making {
            gpu,
            chunk_bytes: CHUNK_BYTES,
            before: before.as_deref(),
            resident: &mut resident,
        };
        let mut upload = Self::with_levels(&mut making, &levels, segments, placed.revision)?;
        if !placed.organs.is_bare() {
            upload.organs = OrganChunk::all(gpu, placed, &mut looks)?;
            upload.leaves = LeafChunk::all(&mut making, placed, &mut looks, detail)?;
            upload.bounds.include(placed.organs.bounds());
        }
        upload.bounds.root = placed.tree.position.first().copied().unwrap_or_default();
        upload.resident = Arc::new(resident);
        upload.before = before;
        upload.bark = placed.organs.bark;
        upload.detail = detail;
        upload.looks = look_buffer(gpu, &looks)?;
        Ok(upload)
    }

    /// The same from segments made elsewhere, of which neighbours follow each other ([`along_axes`]), in chunks of at most so many bytes (and no more than
    /// the device allows).
    ///
    /// # Errors
    /// [`RenderError::OutOfMemory`].
    pub fn in_chunks(
        gpu: &Gpu,
        segments: &[TubeSegment],
        revision: u64,
        chunk_bytes: u64,
    ) -> Result<Self, RenderError> {
        let mut resident = Resident::default();
        let mut making = Making {
            gpu,
            chunk_bytes,
            before: None,
            resident: &mut resident,
        };
        let levels = Levels::new(segments);
        let mut upload = Self::with_levels(&mut making, &levels, segments, revision)?;
        upload.resident = Arc::new(resident);
        Ok(upload)
    }

    fn with_levels(
        making: &mut Making<'_>,
        levels: &Levels<TubeSegment>,
        segments: &[TubeSegment],
        revision: u64,
    ) -> Result<Self, RenderError> {
        let gpu = making.gpu;
        Ok(Self {
            revision,
            segments: u32::try_from(segments.len()).unwrap_or(u32::MAX),
            bounds: bounds(segments),
            chunks: CrownChunk::all(making, levels, of_tubes())?,
            organs: Vec::new(),
            leaves: Vec::new(),
            bark: Bark::default(),
            detail: Detail::Levels,
            resident: Arc::default(),
            before: None,
            picture: None,
            looks: look_buffer(gpu, &LookTable::default())?,
            pool: None,
        })
    }

    /// The tree's number, as its [`PlacedTree::revision`].
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Chunks of branches, then of leaves.
    pub(crate) fn crowns(&self) -> impl Iterator<Item = &CrownChunk> {
        let leaves = self.leaves.iter().map(|chunk| &chunk.crown);
        self.chunks.iter().chain(leaves)
    }

    /// Bytes that go to the device; the rest of it is there already.
    #[must_use]
    pub fn sent(&self) -> u64 {
        let organs = self
            .organs
            .iter()
            .map(|chunk| chunk.vertices.size + chunk.indices.size);
        self.crowns().map(|chunk| chunk.sent).chain(organs).sum()
    }

    /// Bytes that it takes on the device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let crowns = self
            .crowns()
            .map(|chunk| chunk.records.size + chunk.clusters.size);
        let organs = self
            .organs
            .iter()
            .map(|chunk| chunk.vertices.size + chunk.indices.size);
        crowns.chain(organs).sum()
    }

    /// Copies up to `budget` bytes more; true when all is there.
    pub(crate) fn copy(&mut self, gpu: &Gpu, commands: vk::CommandBuffer, mut budget: u64) -> bool {
        let crowns = self.chunks.iter_mut();
        let leaves = self.leaves.iter_mut().map(|chunk| &mut chunk.crown);
        crowns
            .chain(leaves)
            .all(|chunk| chunk.copy(gpu, commands, &mut budget))
            && self
                .organs
                .iter_mut()
                .all(|chunk| chunk.copy(gpu, commands, &mut budget))
    }

    /// What it was copied from; the caller lets go of it when the device is done.
    pub(crate) fn take_before(&mut self) -> Option<Arc<Resident>> {
        self.before.take()
    }

    /// Staging memory that is not needed any more; the caller frees it when the device is done.
    pub(crate) fn take_staging(&mut self) -> impl Iterator<Item = Buffer> {
        let organs = self.organs.iter_mut().map(OrganChunk::take_staging);
        let leaves = self.leaves.iter_mut().map(|chunk| &mut chunk.crown);
        let crowns = self.chunks.iter_mut().chain(leaves);
        let crowns = crowns.map(CrownChunk::take_staging);
        crowns.chain(organs).flatten()
    }
}

/// A sphere about the box of the finite points.
fn bounds(segments: &[TubeSegment]) -> Bounds {
    let mut low = Vec3::INFINITY;
    let mut high = Vec3::NEG_INFINITY;
    for segment in segments {
        for (point, radius) in [
            (segment.from, segment.radii[1]),
            (segment.to, segment.radii[3]),
        ] {
            let point = Vec3::from(point);
            if point.is_finite() && radius.is_finite() {
                low = low.min(point - radius);
                high = high.max(point + radius);
            }
        }
    }
    if low.cmple(high).all() {
        let foot = segments.first().map_or(0.0, |segment| segment.radii[1]);
        Bounds {
            center: (low + high) / 2.0,
            radius: low.distance(high) / 2.0,
            foot,
            root: Vec3::ZERO,
        }
    } else {
        Bounds::default()
    }
}

/// The looks as shaders read them; few, so they stay where the processor wrote them.
fn look_buffer(gpu: &Gpu, looks: &LookTable) -> Result<Buffer, RenderError> {
    let rows = looks.rows();
    let mut buffer = Buffer::new(
        gpu,
        "the looks",
        size_of_val(rows) as u64,
        vk::BufferUsageFlags::STORAGE_BUFFER,
        MemoryLocation::CpuToGpu,
    )?;
    buffer.write(0, rows);
    Ok(buffer)
}

/// What a tree's upload amounts to, in segments, without building it.
pub(crate) fn upload_size(placed: &PlacedTree) -> usize {
    // An organ has a few dozen vertices of 32 bytes, a corner one, a segment 80 bytes.
    let organs = &placed.organs;
    let bent = organs.smooth.len() * 8;
    placed.tree.segment_count() + 10 * organs.len() + organs.corners.len() / 2 + bent
}

const _: () = assert!(
    tubes::GROWING == 1
        && tubes::CAPPED == 2
        && tubes::PAINTED == 8
        && tubes::WIDER_SHIFT == 4
        && tubes::LETTER_SHIFT == 16,
    "shaders/tree.wgsl knows these bits"
);
