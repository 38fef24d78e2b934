//! Scanned models on their way to the device and there: clusters of all levels in chunks, each chunk with its own vertices.
//!
//! A storage buffer may be limited to 128 MiB, so a large model is cut into runs of clusters, each with the vertices that it has, in the order in
//! which its triangles meet them. A vertex takes 16 bytes, a triangle 12 in each level, which is 24 in all, a cluster 80. Colours are apart, 4 bytes a
//! triangle or a vertex, and so are materials: the shape of a model goes up once, whatever it is coloured by. Whether two displays are of one shape is told by their levels
//! being the same in memory; a weak reference holds that place, so that nothing else can come to stand there.

mod cutter;
mod skin;

use std::sync::{Arc, Weak};

use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::Vec4;
use gpu_allocator::MemoryLocation;

use self::cutter::{Cutter, Vertex};
use self::skin::Skin;
use super::{
    error::RenderError,
    frame::Pool,
    gpu::Gpu,
    memory::Buffer,
    pipelines::IMAGE_SAMPLERS,
    staging::{Part, Staging},
    tree_upload::CHUNK_BYTES,
};
use crate::{
    mesh::{
        display::Display,
        levels::{Cluster, Levels},
    },
    world::scene::{ModelLook, PlacedModel, SurfaceLook},
};

/// `Model` of shaders/model.wgsl: a draw's immediates.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct ModelData {
    color: [f32; 4],
    cut: Vec4,
    lamp: Vec4,
    flags: u32,
    stride: u32,
    pad: [u32; 2],
}

/// Every device takes 128 bytes of immediates.
const _: () = assert!(
    size_of::<ModelData>() == 64,
    "shaders/model.wgsl reads 64 bytes"
);

const MATTE: u32 = 1;
const WIRE: u32 = 2;
const COLOURED: u32 = 4;
const FLAT: u32 = 8;
const PAINTED: u32 = 16;
const THROWS: u32 = 32;

/// How bright a lamp in a hand is: as the sun at this distance squared, square metres.
const LAMP: f32 = 0.12;

/// What has a colour of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coloured {
    Nothing,
    Triangles,
    Vertices,
    Materials,
}

impl Coloured {
    fn of(display: &Display) -> Self {
        if display.textured.is_some() {
            Self::Materials
        } else if !display.vertex_colours.is_empty() {
            Self::Vertices
        } else if display.colours.is_empty() {
            Self::Nothing
        } else {
            Self::Triangles
        }
    }
}

/// The plane before which a model is cut away; all zero: nothing is.
pub(crate) fn cut_of(look: &ModelLook) -> Vec4 {
    look.cut.filter(|cut| cut.is_finite()).unwrap_or(Vec4::ZERO)
}

impl ModelData {
    /// What the shader is told of a model; each how many vertices one is shown.
    pub(crate) fn new(look: &ModelLook, coloured: Coloured, stride: u32) -> Self {
        let flag = |on: bool, bit: u32| if on { bit } else { 0 };
        Self {
            color: look.color,
            cut: cut_of(look),
            lamp: look
                .lamp
                .filter(|at| at.is_finite())
                .map_or(Vec4::ZERO, |at| at.extend(LAMP)),
            flags: flag(look.surface == Some(SurfaceLook::Matte), MATTE)
                | flag(look.wireframe, WIRE)
                | flag(coloured == Coloured::Triangles, COLOURED)
                | flag(coloured == Coloured::Vertices, PAINTED)
                | flag(look.flat, FLAT)
                | flag(look.shadow, THROWS),
            stride,
            pad: [0; 2],
        }
    }
}

/// A buffer on the device with what is on its way there.
struct Arriving<const PARTS: usize> {
    parts: [Buffer; PARTS],
    sizes: [u64; PARTS],
    staging: Staging,
}

impl<const PARTS: usize> Arriving<PARTS> {
    fn new(gpu: &Gpu, parts: [(&'static str, &[u8]); PARTS]) -> Result<Self, RenderError> {
        let sizes = parts.map(|(_, bytes)| bytes.len() as u64);
        let mut staging = Staging::new(gpu, "the model on its way", sizes.iter().sum())?;
        let mut at = 0;
        let mut buffers = Vec::with_capacity(PARTS);
        for (name, bytes) in parts {
            staging.write(at, bytes);
            at += bytes.len() as u64;
            let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
            let size = bytes.len() as u64;
            buffers.push(Buffer::new(
                gpu,
                name,
                size,
                usage,
                MemoryLocation::GpuOnly,
            )?);
        }
        let parts = buffers.try_into();
        Ok(Self {
            parts: parts
                .map_err(|_| RenderError::Unsupported("a model has no such parts".to_owned()))?,
            sizes,
            staging,
        })
    }

    fn copy(&mut self, gpu: &Gpu, commands: vk::CommandBuffer, budget: &mut u64) -> bool {
        let mut parts = self.parts.each_ref().map(|part| Part::staged(part, 0));
        for (part, size) in parts.iter_mut().zip(self.sizes) {
            part.size = size;
        }
        self.staging.copy(gpu, commands, &parts, budget)
    }
}

/// Clusters that one draw shows.
pub(crate) struct ModelChunk {
    /// Vertices, triangles, clusters.
    arriving: Arriving<3>,
    pub(crate) clusters: u32,
    /// Of the model's vertices those that no chunk before has; they come first.
    pub(crate) points: u32,
    /// Number of its first triangle among the model's, in all levels.
    pub(crate) first_triangle: u32,
    /// Its clusters for shaders/select.wgsl.
    pub(crate) set: vk::DescriptorSet,
}

/// A model's shape.
pub(crate) struct Geometry {
    levels: Weak<Levels>,
    pub(crate) chunks: Vec<ModelChunk>,
    /// Vertices of all chunks that are shown as points.
    pub(crate) points: u32,
    /// The chunks' sets, once all is there.
    pool: Option<Pool>,
}

/// A model's colours, and what of it is drawn together with them.
pub(crate) struct Colours {
    pub(crate) revision: u64,
    levels: Weak<Levels>,
    pub(crate) coloured: Coloured,
    /// By chunk; none where the model has no colours.
    chunks: Vec<Arriving<1>>,
    /// By chunk: vertices, triangles, colours; once all is there.
    pub(crate) sets: Vec<vk::DescriptorSet>,
    /// Where it is coloured by materials.
    skin: Option<Box<Skin>>,
    pool: Option<Pool>,
}

/// A model that is ready to be copied to the device.
pub struct ModelUpload {
    /// None where only colours changed.
    pub(crate) geometry: Option<Geometry>,
    pub(crate) colours: Colours,
}

/// Layouts of a model's sets, and what its images are sampled by.
#[derive(Clone, Copy)]
pub(crate) struct ModelLayouts {
    pub(crate) drawn: vk::DescriptorSetLayout,
    pub(crate) chosen: vk::DescriptorSetLayout,
    pub(crate) skin: vk::DescriptorSetLayout,
    pub(crate) samplers: [vk::Sampler; IMAGE_SAMPLERS],
}

impl ModelUpload {
    /// Cuts a model into chunks and fills staging memory. Any thread.
    ///
    /// # Errors
    /// [`RenderError::OutOfMemory`].
    pub fn new(gpu: &Gpu, placed: &PlacedModel) -> Result<Self, RenderError> {
        Self::in_chunks(gpu, placed, CHUNK_BYTES)
    }

    /// The same in chunks of about so many bytes a buffer (and no more than the device allows); a cluster is never cut. Colours must come in the same
    /// chunks.
    ///
    /// # Errors
    /// [`RenderError::OutOfMemory`].
    pub fn in_chunks(
        gpu: &Gpu,
        placed: &PlacedModel,
        chunk_bytes: u64,
    ) -> Result<Self, RenderError> {
        Ok(Self {
            geometry: Some(Geometry::new(gpu, &placed.display, chunk_bytes)?),
            colours: Colours::new(gpu, placed, chunk_bytes)?,
        })
    }

    /// Only a model's colours, where the device has its shape already (see `Renderer::has_shape`).
    ///
    /// # Errors
    /// [`RenderError::OutOfMemory`].
    pub fn colours(gpu: &Gpu, placed: &PlacedModel) -> Result<Self, RenderError> {
        Ok(Self {
            geometry: None,
            colours: Colours::new(gpu, placed, CHUNK_BYTES)?,
        })
    }

    /// The model's number, as its [`PlacedModel::revision`].
    pub fn revision(&self) -> u64 {
        self.colours.revision
    }
}

fn is_of(levels: &Weak<Levels>, display: &Display) -> bool {
    std::ptr::eq(levels.as_ptr(), Arc::as_ptr(&display.levels))
}

impl Geometry {
    fn new(gpu: &Gpu, display: &Display, chunk_bytes: u64) -> Result<Self, RenderError> {
        let mut cutter = Cutter::new(display, gpu, chunk_bytes);
        let mut chunks = Vec::new();
        while cutter.advance() {
            chunks.push(ModelChunk::new(gpu, &cutter)?);
        }
        Ok(Self {
            levels: Arc::downgrade(&display.levels),
            points: chunks.iter().map(|chunk| chunk.points).sum(),
            chunks,
            pool: None,
        })
    }

    pub(crate) fn is_of(&self, display: &Display) -> bool {
        is_of(&self.levels, display)
    }

    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.levels.ptr_eq(&other.levels)
    }

    pub(crate) fn is_of_same(&self, colours: &Colours) -> bool {
        self.levels.ptr_eq(&colours.levels)
    }

    pub(crate) fn is_there(&self) -> bool {
        self.pool.is_some()
    }

    /// Copies up to `budget` bytes more; when all is there the staging memory is handed out, which the caller frees when the device is done.
    pub(crate) fn copy(
        &mut self,
        gpu: &Gpu,
        commands: vk::CommandBuffer,
        layouts: ModelLayouts,
        budget: &mut u64,
    ) -> Result<Option<Vec<Buffer>>, RenderError> {
        let mut all = self.chunks.iter_mut();
        if !all.all(|chunk| chunk.arriving.copy(gpu, commands, budget)) {
            return Ok(None);
        }
        let pool = storage_pool(gpu, self.chunks.len(), 1)?;
        for chunk in &mut self.chunks {
            chunk.set = pool.set(layouts.chosen)?;
            write_set(gpu, chunk.set, 0, &[&chunk.arriving.parts[2]]);
        }
        self.pool = Some(pool);
        let staging = self.chunks.iter_mut();
        Ok(Some(
            staging
                .filter_map(|chunk| chunk.arriving.staging.take())
                .collect(),
        ))
    }
}

impl ModelChunk {
    fn new(gpu: &Gpu, run: &Cutter<'_>) -> Result<Self, RenderError> {
        let vertices: Vec<Vertex> = run.vertices().collect();
        let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        Ok(Self {
            arriving: Arriving::new(
                gpu,
                [
                    ("the model's vertices", bytemuck::cast_slice(&vertices)),
                    (
                        "the model's triangles",
                        bytemuck::cast_slice(&run.triangles),
                    ),
                    ("the model's clusters", bytemuck::cast_slice(&run.clusters)),
                ],
            )?,
            clusters: count(run.clusters.len()),
            points: count(run.fresh),
            first_triangle: count(run.first_triangle),
            set: vk::DescriptorSet::null(),
        })
    }
}

impl Colours {
    fn new(gpu: &Gpu, placed: &PlacedModel, chunk_bytes: u64) -> Result<Self, RenderError> {
        let display = &*placed.display;
        let coloured = Coloured::of(display);
        let mut chunks = Vec::new();
        let mut cutter = Cutter::new(display, gpu, chunk_bytes);
        while coloured != Coloured::Nothing && cutter.advance() {
            let colours: Vec<[u8; 4]> = match (&display.textured, coloured) {
                (Some(textured), _) => cutter.materials(textured),
                (None, Coloured::Vertices) => cutter.vertex_colours().collect(),
                (None, _) => cutter.triangle_colours().collect(),
            };
            let part = ("the model's colours", bytemuck::cast_slice(&colours));
            chunks.push(Arriving::new(gpu, [part])?);
        }
        Ok(Self {
            revision: placed.revision,
            levels: Arc::downgrade(&display.levels),
            coloured,
            chunks,
            sets: Vec::new(),
            skin: display
                .textured
                .as_ref()
                .map(|textured| Skin::new(gpu, textured).map(Box::new))
                .transpose()?,
            pool: None,
        })
    }

    pub(crate) fn is_of(&self, display: &Display) -> bool {
        is_of(&self.levels, display)
    }

    pub(crate) fn is_there(&self) -> bool {
        self.pool.is_some()
    }

    /// The same as [`Geometry::copy`], once the shape is there.
    pub(crate) fn copy(
        &mut self,
        gpu: &Gpu,
        commands: vk::CommandBuffer,
        geometry: &Geometry,
        layouts: ModelLayouts,
        budget: &mut u64,
    ) -> Result<Option<Vec<Buffer>>, RenderError> {
        let mut all = self.chunks.iter_mut();
        if !all.all(|chunk| chunk.copy(gpu, commands, budget)) {
            return Ok(None);
        }
        if let Some(skin) = &mut self.skin
            && !skin.copy(gpu, commands, layouts.skin, &layouts.samplers, budget)?
        {
            return Ok(None);
        }
        let pool = storage_pool(gpu, geometry.chunks.len(), 3)?;
        self.sets.clear();
        for (at, chunk) in geometry.chunks.iter().enumerate() {
            let set = pool.set(layouts.drawn)?;
            let [vertices, triangles, _] = &chunk.arriving.parts;
            // Where there are no colours none are read, but something must be there.
            let colours = self.chunks.get(at).map_or(vertices, |of| &of.parts[0]);
            write_set(gpu, set, 0, &[vertices, triangles, colours]);
            self.sets.push(set);
        }
        self.pool = Some(pool);
        let staging = self.chunks.iter_mut();
        let skin = self.skin.iter_mut().flat_map(|skin| skin.take());
        Ok(Some(
            staging
                .filter_map(|chunk| chunk.staging.take())
                .chain(skin)
                .collect(),
        ))
    }

    /// The set of its materials and images, where it has some and they are there.
    pub(crate) fn skin_set(&self) -> Option<vk::DescriptorSet> {
        self.skin.as_ref()?.set()
    }

    /// Bytes that went up, or go.
    pub(crate) fn bytes(&self) -> u64 {
        let colours: u64 = self.chunks.iter().map(|chunk| chunk.sizes[0]).sum();
        colours + self.skin.as_ref().map_or(0, |skin| skin.bytes())
    }
}

fn storage_pool(gpu: &Gpu, sets: usize, each: u32) -> Result<Pool, RenderError> {
    let count = u32::try_from(sets).unwrap_or(u32::MAX).max(1);
    let sizes = [(
        vk::DescriptorType::STORAGE_BUFFER,
        count.saturating_mul(each),
    )];
    Pool::new(gpu, count, &sizes)
}

/// Binds storage buffers from a binding on.
pub(crate) fn write_set(gpu: &Gpu, set: vk::DescriptorSet, first: u32, buffers: &[&Buffer]) {
    for (binding, buffer) in (first..).zip(buffers) {
        let info = [vk::DescriptorBufferInfo::default()
            .buffer(buffer.handle)
            .range(vk::WHOLE_SIZE)];
        let write = [vk::WriteDescriptorSet::default()
            .dst_set(set)
            .dst_binding(binding)
            .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
            .buffer_info(&info)];
        // SAFETY: the set is new, the buffers live as long as it.
        unsafe { gpu.device.update_descriptor_sets(&write, &[]) };
    }
}

const _: () = assert!(
    size_of::<Vertex>() == 16 && size_of::<Cluster>() == 80,
    "shaders/model.wgsl and select.wgsl read these"
);
