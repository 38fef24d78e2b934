//! Scanned models on their way to the device and there: triangles in chunks, each with its own vertices.
//!
//! A storage buffer may be limited to 128 MiB, so a large model is cut into runs of triangles, each with the vertices that it has, in the order in
//! which its triangles meet them: neighbours in a file are mostly neighbours in space, and few vertices stand in two chunks.
//! A vertex takes 16 bytes, a triangle 12, and 4 more where triangles have colours of their own.

use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec4};
use gpu_allocator::MemoryLocation;

use super::{
    data::rows, error::RenderError, frame::Pool, gpu::Gpu, memory::Buffer, staging::Staging,
    tree_upload::CHUNK_BYTES,
};
use crate::{
    mesh::display::Display,
    world::scene::{ModelLook, PlacedModel, SurfaceLook},
};

/// `Vertex` of shaders/model.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct Vertex {
    place: [f32; 3],
    normal: u32,
}

const _: () = assert!(
    size_of::<Vertex>() == 16,
    "shaders/model.wgsl reads 16 bytes"
);

/// `Model` of shaders/model.wgsl: a draw's immediates.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct ModelData {
    rows: [Vec4; 3],
    color: [f32; 4],
    cut: Vec4,
    lamp: Vec4,
    flags: u32,
    stride: u32,
    pad: [u32; 2],
}

/// Every device takes 128 bytes of immediates.
const _: () = assert!(
    size_of::<ModelData>() == 112,
    "shaders/model.wgsl reads 112 bytes"
);

const MATTE: u32 = 1;
const WIRE: u32 = 2;
const COLOURED: u32 = 4;
const FLAT: u32 = 8;

/// How bright a lamp in a hand is: as the sun at this distance squared, square metres.
const LAMP: f32 = 0.12;

/// A frame shows so many vertices as points, of larger models each second, third and so on.
const MOST_POINTS: u32 = 250_000;

impl ModelData {
    /// What the shader is told of a model; `vertices`: of all its chunks.
    pub(crate) fn new(
        world_from_model: &Affine3A,
        look: &ModelLook,
        coloured: bool,
        vertices: u32,
    ) -> Self {
        let flag = |on: bool, bit: u32| if on { bit } else { 0 };
        Self {
            rows: rows(world_from_model),
            color: look.color,
            cut: look.cut.filter(|cut| cut.is_finite()).unwrap_or(Vec4::ZERO),
            lamp: look
                .lamp
                .filter(|at| at.is_finite())
                .map_or(Vec4::ZERO, |at| at.extend(LAMP)),
            flags: flag(look.surface == Some(SurfaceLook::Matte), MATTE)
                | flag(look.wireframe, WIRE)
                | flag(coloured, COLOURED)
                | flag(look.flat, FLAT),
            stride: vertices.div_ceil(MOST_POINTS).max(1),
            pad: [0; 2],
        }
    }

    /// Points that are drawn of so many vertices.
    pub(crate) fn points(&self, vertices: u32) -> u32 {
        vertices / self.stride.max(1)
    }
}

/// Triangles that one draw shows.
pub(crate) struct ModelChunk {
    parts: [Buffer; 3],
    pub(crate) triangles: u32,
    pub(crate) vertices: u32,
    /// Bytes of each part.
    sizes: [u64; 3],
    staging: Staging,
    pub(crate) set: vk::DescriptorSet,
}

/// A model that is ready to be copied to the device, or there.
pub struct ModelUpload {
    pub(crate) revision: u64,
    pub(crate) chunks: Vec<ModelChunk>,
    pub(crate) coloured: bool,
    pub(crate) vertices: u32,
    /// The chunks' sets, once all is there.
    pool: Option<Pool>,
}

impl ModelUpload {
    /// Cuts a model into chunks and fills staging memory. Any thread.
    ///
    /// # Errors
    /// [`RenderError::OutOfMemory`].
    pub fn new(gpu: &Gpu, placed: &PlacedModel) -> Result<Self, RenderError> {
        Self::in_chunks(gpu, placed, CHUNK_BYTES)
    }

    /// The same in chunks of at most so many bytes a buffer (and no more than the device allows).
    ///
    /// # Errors
    /// [`RenderError::OutOfMemory`].
    pub fn in_chunks(
        gpu: &Gpu,
        placed: &PlacedModel,
        chunk_bytes: u64,
    ) -> Result<Self, RenderError> {
        let display = &*placed.display;
        let range = chunk_bytes.min(u64::from(gpu.limits.max_storage_buffer_range));
        // No more vertices than three a triangle.
        let most = usize::try_from(range / (3 * size_of::<Vertex>() as u64)).unwrap_or(usize::MAX);
        let mut cutter = Cutter::new(display);
        let mut chunks = Vec::new();
        let mut first = 0;
        for part in display.mesh.triangles.chunks(most.max(1)) {
            cutter.cut(part);
            let colours = display.colours.get(first..first + part.len());
            chunks.push(ModelChunk::new(gpu, &cutter, colours.unwrap_or_default())?);
            first += part.len();
        }
        Ok(Self {
            revision: placed.revision,
            vertices: chunks.iter().map(|chunk| chunk.vertices).sum(),
            coloured: !display.colours.is_empty(),
            chunks,
            pool: None,
        })
    }

    /// The model's number, as its [`PlacedModel::revision`].
    pub fn revision(&self) -> u64 {
        self.revision
    }

    pub(crate) fn is_there(&self) -> bool {
        self.pool.is_some()
    }

    /// Copies up to `budget` bytes more; when all is there the staging memory is handed out, which the caller frees when the device is done.
    pub(crate) fn copy(
        &mut self,
        gpu: &Gpu,
        commands: vk::CommandBuffer,
        layout: vk::DescriptorSetLayout,
        budget: &mut u64,
    ) -> Result<Option<Vec<Buffer>>, RenderError> {
        let mut all = self.chunks.iter_mut();
        if !all.all(|chunk| chunk.copy(gpu, commands, budget)) {
            return Ok(None);
        }
        let count = u32::try_from(self.chunks.len()).unwrap_or(u32::MAX).max(1);
        let pool = Pool::new(
            gpu,
            count,
            &[(vk::DescriptorType::STORAGE_BUFFER, 3 * count)],
        )?;
        for chunk in &mut self.chunks {
            chunk.set = pool.set(layout)?;
            chunk.write_set(gpu);
        }
        self.pool = Some(pool);
        let staging = self.chunks.iter_mut().map(|chunk| chunk.staging.take());
        Ok(Some(staging.flatten().collect()))
    }
}

/// Numbers a run's vertices anew.
struct Cutter<'a> {
    display: &'a Display,
    /// By the model's vertex: the run that met it last, and its number there.
    seen: Vec<(u32, u32)>,
    run: u32,
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
}

impl<'a> Cutter<'a> {
    fn new(display: &'a Display) -> Self {
        Self {
            display,
            seen: vec![(0, 0); display.mesh.positions.len()],
            run: 0,
            vertices: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// Takes a run; a triangle with a vertex that is not there becomes a point.
    fn cut(&mut self, part: &[[u32; 3]]) {
        self.run += 1;
        self.vertices.clear();
        self.triangles.clear();
        for triangle in part {
            let numbers = triangle.map(|vertex| self.number(vertex).unwrap_or(0));
            self.triangles.push(numbers);
        }
    }

    fn number(&mut self, vertex: u32) -> Option<u32> {
        let at = vertex as usize;
        let (run, number) = *self.seen.get(at)?;
        if run == self.run {
            return Some(number);
        }
        let number = u32::try_from(self.vertices.len()).ok()?;
        self.vertices.push(Vertex {
            place: self.display.mesh.positions.get(at)?.to_array(),
            normal: self.display.normals.get(at).copied().unwrap_or(0),
        });
        *self.seen.get_mut(at)? = (self.run, number);
        Some(number)
    }
}

impl ModelChunk {
    fn new(gpu: &Gpu, run: &Cutter<'_>, colours: &[[u8; 4]]) -> Result<Self, RenderError> {
        let sizes = [
            size_of_val(&*run.vertices),
            size_of_val(&*run.triangles),
            size_of_val(colours),
        ]
        .map(|size| size as u64);
        let mut staging = Staging::new(gpu, "the model on its way", sizes.iter().sum())?;
        staging.write(0, &run.vertices);
        staging.write(sizes[0], &run.triangles);
        staging.write(sizes[0] + sizes[1], colours);
        let there = |name, size| {
            let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
            Buffer::new(gpu, name, size, usage, MemoryLocation::GpuOnly)
        };
        let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        Ok(Self {
            parts: [
                there("the model's vertices", sizes[0])?,
                there("the model's triangles", sizes[1])?,
                there("the model's colours", sizes[2])?,
            ],
            triangles: count(run.triangles.len()),
            vertices: count(run.vertices.len()),
            sizes,
            staging,
            set: vk::DescriptorSet::null(),
        })
    }

    fn copy(&mut self, gpu: &Gpu, commands: vk::CommandBuffer, budget: &mut u64) -> bool {
        let [vertices, triangles, colours] = self.parts.each_ref().map(|part| part.handle);
        let [a, b, c] = self.sizes;
        let parts = [(vertices, a), (triangles, b), (colours, c)];
        self.staging.copy(gpu, commands, &parts, budget)
    }

    fn write_set(&self, gpu: &Gpu) {
        let buffers = self.parts.each_ref().map(|part| {
            vk::DescriptorBufferInfo::default()
                .buffer(part.handle)
                .range(vk::WHOLE_SIZE)
        });
        let writes = [0, 1, 2].map(|binding: u32| {
            vk::WriteDescriptorSet::default()
                .dst_set(self.set)
                .dst_binding(binding)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .buffer_info(std::slice::from_ref(&buffers[binding as usize]))
        });
        // SAFETY: the set is new, the buffers live as long as it.
        unsafe { gpu.device.update_descriptor_sets(&writes, &[]) };
    }
}
