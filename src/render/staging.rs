//! Bytes on their way to the device: written once into memory that both see, and copied from there to where they belong, so many a frame.

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::{error::RenderError, gpu::Gpu, memory::Buffer};

/// Parts one after the other in one buffer, and how much of them has been copied.
pub(crate) struct Staging {
    /// Until all is copied.
    buffer: Option<Buffer>,
    copied: u64,
}

impl Staging {
    /// Room for so many bytes; [`Self::write`] fills it.
    pub(crate) fn new(gpu: &Gpu, name: &'static str, bytes: u64) -> Result<Self, RenderError> {
        let buffer = Buffer::new(
            gpu,
            name,
            bytes,
            vk::BufferUsageFlags::TRANSFER_SRC,
            MemoryLocation::CpuToGpu,
        )?;
        Ok(Self {
            buffer: Some(buffer),
            copied: 0,
        })
    }

    /// Writes at an offset.
    pub(crate) fn write<T: bytemuck::NoUninit>(&mut self, offset: u64, data: &[T]) {
        if let Some(buffer) = &mut self.buffer {
            buffer.write(offset, data);
        }
    }

    /// Copies up to `budget` bytes more into the parts' own buffers, each with its length; true when all is there.
    pub(crate) fn copy(
        &mut self,
        gpu: &Gpu,
        commands: vk::CommandBuffer,
        parts: &[(vk::Buffer, u64)],
        budget: &mut u64,
    ) -> bool {
        let Some(staging) = &self.buffer else {
            return true;
        };
        let mut first = 0;
        for &(buffer, size) in parts {
            let done = self.copied.clamp(first, first + size) - first;
            let now = (size - done).min(*budget);
            if now > 0 {
                let region = [vk::BufferCopy {
                    src_offset: first + done,
                    dst_offset: done,
                    size: now,
                }];
                // SAFETY: both buffers have these ranges and live until the frame is done.
                unsafe {
                    gpu.device
                        .cmd_copy_buffer(commands, staging.handle, buffer, &region)
                };
                *budget -= now;
                self.copied += now;
            }
            first += size;
        }
        self.copied >= first
    }

    /// The memory, which is not needed any more; the caller frees it when the device is done.
    pub(crate) fn take(&mut self) -> Option<Buffer> {
        self.buffer.take()
    }
}
