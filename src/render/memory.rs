//! Buffers, images and views: one owner for each Vulkan object, which frees it.

use ash::vk;
use gpu_allocator::{
    MemoryLocation,
    vulkan::{Allocation, AllocationCreateDesc, AllocationScheme},
};
use rayon::prelude::*;

use super::{
    error::{RenderError, Trying as _},
    gpu::Gpu,
};

/// Up to so many bytes are worked on by the thread that asks: a frame may wait for them, and must not wait for what other threads have taken on.
pub(crate) const ALONE: usize = 8 << 20;
/// Bytes that one thread copies at a time.
const PIECE: usize = 1 << 20;

/// A buffer with its memory.
pub(crate) struct Buffer {
    pub(crate) handle: vk::Buffer,
    pub(crate) size: u64,
    allocation: Option<Allocation>,
    gpu: Gpu,
}

impl Buffer {
    pub(crate) fn new(
        gpu: &Gpu,
        name: &'static str,
        size: u64,
        usage: vk::BufferUsageFlags,
        location: MemoryLocation,
    ) -> Result<Self, RenderError> {
        let info = vk::BufferCreateInfo::default()
            .size(size.max(16))
            .usage(usage);
        // SAFETY: a plain exclusive buffer.
        let handle = unsafe { gpu.device.create_buffer(&info, None) }.trying(name)?;
        let mut buffer = Self {
            handle,
            size: size.max(16),
            allocation: None,
            gpu: gpu.clone(),
        };
        // SAFETY: the buffer was just made.
        let requirements = unsafe { gpu.device.get_buffer_memory_requirements(handle) };
        let allocation = gpu
            .allocator()
            .allocate(&AllocationCreateDesc {
                name,
                requirements,
                location,
                linear: true,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .trying(name)?;
        // SAFETY: memory and offset come from the allocator for these requirements.
        let bound = unsafe {
            gpu.device
                .bind_buffer_memory(handle, allocation.memory(), allocation.offset())
        };
        buffer.allocation = Some(allocation);
        bound.trying(name)?;
        Ok(buffer)
    }

    /// The buffer's bytes, where the processor sees them (else an empty slice).
    pub(crate) fn bytes(&mut self) -> &mut [u8] {
        let size = usize::try_from(self.size).unwrap_or(0);
        self.allocation
            .as_mut()
            .and_then(Allocation::mapped_slice_mut)
            .and_then(|bytes| bytes.get_mut(..size))
            .unwrap_or_default()
    }

    /// Copies `data` to `offset`; false when it does not fit or the processor does not see the buffer.
    pub(crate) fn write<T: bytemuck::NoUninit>(&mut self, offset: u64, data: &[T]) -> bool {
        let data: &[u8] = bytemuck::cast_slice(data);
        let Ok(offset) = usize::try_from(offset) else {
            return false;
        };
        let Some(place) = self
            .bytes()
            .get_mut(offset..)
            .and_then(|bytes| bytes.get_mut(..data.len()))
        else {
            return false;
        };
        if data.len() > ALONE {
            // Most of the time goes into touching fresh memory, which two threads do in half of it.
            let from = data.par_chunks(PIECE);
            let pieces = place.par_chunks_mut(PIECE).zip(from);
            pieces.for_each(|(to, from)| to.copy_from_slice(from));
        } else {
            place.copy_from_slice(data);
        }
        true
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        if let Some(allocation) = self.allocation.take() {
            let _ = self.gpu.allocator().free(allocation);
        }
        // SAFETY: owners drop buffers only after the frames that use them (`frame::Garbage`).
        unsafe { self.gpu.device.destroy_buffer(self.handle, None) };
    }
}

/// What an image is to be.
#[derive(Clone, Copy)]
pub(crate) struct ImageDesc {
    pub(crate) name: &'static str,
    pub(crate) format: vk::Format,
    pub(crate) extent: vk::Extent2D,
    pub(crate) layers: u32,
    pub(crate) mips: u32,
    pub(crate) samples: vk::SampleCountFlags,
    pub(crate) usage: vk::ImageUsageFlags,
    /// `MUTABLE_FORMAT` where views of other formats are made.
    pub(crate) flags: vk::ImageCreateFlags,
}

impl ImageDesc {
    /// A one-sample, two-layer image.
    pub(crate) fn stereo(
        name: &'static str,
        format: vk::Format,
        extent: vk::Extent2D,
        usage: vk::ImageUsageFlags,
    ) -> Self {
        Self {
            name,
            format,
            extent,
            layers: 2,
            mips: 1,
            samples: vk::SampleCountFlags::TYPE_1,
            usage,
            flags: vk::ImageCreateFlags::empty(),
        }
    }
}

impl ImageDesc {
    /// Bytes that the image takes at least: no format that is drawn to has fewer than 4 a sample.
    fn least_bytes(&self) -> u64 {
        const SAMPLE: u64 = 4;
        let pixels = u64::from(self.extent.width) * u64::from(self.extent.height);
        let samples = u64::from(self.layers) * u64::from(self.samples.as_raw());
        pixels.saturating_mul(samples * SAMPLE)
    }
}

/// Bytes of the largest image of this kind that the device can have.
fn largest_image(gpu: &Gpu, desc: &ImageDesc) -> Result<vk::DeviceSize, RenderError> {
    // SAFETY: the instance is alive and the physical device is one of its own.
    let properties = unsafe {
        gpu.instance.get_physical_device_image_format_properties(
            gpu.physical_device,
            desc.format,
            vk::ImageType::TYPE_2D,
            vk::ImageTiling::OPTIMAL,
            desc.usage,
            desc.flags,
        )
    };
    Ok(properties.trying(desc.name)?.max_resource_size)
}

/// An image with its memory.
pub(crate) struct Image {
    pub(crate) handle: vk::Image,
    pub(crate) desc: ImageDesc,
    allocation: Option<Allocation>,
    gpu: Gpu,
}

impl Image {
    pub(crate) fn new(gpu: &Gpu, desc: ImageDesc) -> Result<Self, RenderError> {
        if desc.least_bytes() > largest_image(gpu, &desc)? {
            return Err(RenderError::OutOfMemory(desc.name));
        }
        let info = vk::ImageCreateInfo::default()
            .flags(desc.flags)
            .image_type(vk::ImageType::TYPE_2D)
            .format(desc.format)
            .extent(vk::Extent3D {
                width: desc.extent.width,
                height: desc.extent.height,
                depth: 1,
            })
            .mip_levels(desc.mips)
            .array_layers(desc.layers)
            .samples(desc.samples)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(desc.usage)
            .initial_layout(vk::ImageLayout::UNDEFINED);
        // SAFETY: a plain exclusive image.
        let handle = unsafe { gpu.device.create_image(&info, None) }.trying(desc.name)?;
        let mut image = Self {
            handle,
            desc,
            allocation: None,
            gpu: gpu.clone(),
        };
        // SAFETY: the image was just made.
        let requirements = unsafe { gpu.device.get_image_memory_requirements(handle) };
        let allocation = gpu
            .allocator()
            .allocate(&AllocationCreateDesc {
                name: desc.name,
                requirements,
                location: MemoryLocation::GpuOnly,
                linear: false,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .trying(desc.name)?;
        // SAFETY: memory and offset come from the allocator for these requirements.
        let bound = unsafe {
            gpu.device
                .bind_image_memory(handle, allocation.memory(), allocation.offset())
        };
        image.allocation = Some(allocation);
        bound.trying(desc.name)?;
        Ok(image)
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        if let Some(allocation) = self.allocation.take() {
            let _ = self.gpu.allocator().free(allocation);
        }
        // SAFETY: as for buffers.
        unsafe { self.gpu.device.destroy_image(self.handle, None) };
    }
}

/// A view of an image's layers.
pub(crate) struct View {
    pub(crate) handle: vk::ImageView,
    gpu: Gpu,
}

impl View {
    /// A view of mip level 0 (or of `mips` levels) of the layers `first .. first + count`; one layer makes a 2D view.
    pub(crate) fn new(
        gpu: &Gpu,
        image: vk::Image,
        format: vk::Format,
        aspect: vk::ImageAspectFlags,
        layers: std::ops::Range<u32>,
        mips: std::ops::Range<u32>,
    ) -> Result<Self, RenderError> {
        let kind = if layers.len() == 1 {
            vk::ImageViewType::TYPE_2D
        } else {
            vk::ImageViewType::TYPE_2D_ARRAY
        };
        Self::of_kind(gpu, image, kind, format, aspect, layers, mips)
    }

    /// A view of all of a colour image, an array even of one layer.
    pub(crate) fn array(gpu: &Gpu, image: &Image) -> Result<Self, RenderError> {
        let kind = vk::ImageViewType::TYPE_2D_ARRAY;
        let desc = &image.desc;
        let color = vk::ImageAspectFlags::COLOR;
        let (layers, mips) = (0..desc.layers, 0..desc.mips);
        Self::of_kind(gpu, image.handle, kind, desc.format, color, layers, mips)
    }

    fn of_kind(
        gpu: &Gpu,
        image: vk::Image,
        kind: vk::ImageViewType,
        format: vk::Format,
        aspect: vk::ImageAspectFlags,
        layers: std::ops::Range<u32>,
        mips: std::ops::Range<u32>,
    ) -> Result<Self, RenderError> {
        let count = layers.end - layers.start;
        let info = vk::ImageViewCreateInfo::default()
            .image(image)
            .view_type(kind)
            .format(format)
            .subresource_range(vk::ImageSubresourceRange {
                aspect_mask: aspect,
                base_mip_level: mips.start,
                level_count: mips.end - mips.start,
                base_array_layer: layers.start,
                layer_count: count,
            });
        // SAFETY: the image is alive and has these layers and levels.
        let handle =
            unsafe { gpu.device.create_image_view(&info, None) }.trying("making an image view")?;
        Ok(Self {
            handle,
            gpu: gpu.clone(),
        })
    }
}

impl Drop for View {
    fn drop(&mut self) {
        // SAFETY: owners drop views only after the frames that use them.
        unsafe { self.gpu.device.destroy_image_view(self.handle, None) };
    }
}

/// Whether a depth format has a stencil part too.
pub(crate) fn depth_aspects(format: vk::Format) -> vk::ImageAspectFlags {
    match format {
        vk::Format::D24_UNORM_S8_UINT
        | vk::Format::D32_SFLOAT_S8_UINT
        | vk::Format::D16_UNORM_S8_UINT => {
            vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL
        }
        _ => vk::ImageAspectFlags::DEPTH,
    }
}
