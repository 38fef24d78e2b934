//! Bytes on their way to the device: written once into memory that both see, and copied from there to where they belong, so many a frame. What the device
//! has already is copied from where that is.

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::{error::RenderError, gpu::Gpu, memory::Buffer};

/// A copy takes as much of a frame's budget as so many bytes do, at least.
const LEAST: u64 = 64 << 10;

/// Bytes that belong together, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    pub(crate) from: Source,
    pub(crate) to: vk::Buffer,
    /// Where they begin there.
    pub(crate) at: u64,
    pub(crate) size: u64,
}

/// Where bytes come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// Staging memory, behind those of the part before.
    Staged,
    /// A buffer on the device, from this byte on; it lives until the copy is done.
    Device(vk::Buffer, u64),
}

impl Part {
    /// A buffer's first bytes, staged.
    pub(crate) fn staged(to: &Buffer, size: u64) -> Self {
        Self {
            from: Source::Staged,
            to: to.handle,
            at: 0,
            size,
        }
    }
}

/// Parts one after the other, and how much of them has been copied.
pub(crate) struct Staging {
    /// Until all is copied.
    buffer: Option<Buffer>,
    /// The part that is being copied, how much of it has been, and how much of the staging memory.
    part: usize,
    copied: u64,
    read: u64,
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
            part: 0,
            copied: 0,
            read: 0,
        })
    }

    /// Writes at an offset.
    pub(crate) fn write<T: bytemuck::NoUninit>(&mut self, offset: u64, data: &[T]) {
        if let Some(buffer) = &mut self.buffer {
            buffer.write(offset, data);
        }
    }

    /// Copies up to `budget` bytes more of the parts, which are the same each time; true when all is there.
    pub(crate) fn copy(
        &mut self,
        gpu: &Gpu,
        commands: vk::CommandBuffer,
        parts: &[Part],
        budget: &mut u64,
    ) -> bool {
        let Some(staging) = &self.buffer else {
            return true;
        };
        while let Some(part) = parts.get(self.part) {
            let now = (part.size - self.copied).min(*budget);
            if now == 0 && self.copied < part.size {
                return false;
            }
            let (source, first) = match part.from {
                Source::Staged => (staging.handle, self.read),
                Source::Device(buffer, first) => (buffer, first + self.copied),
            };
            if now > 0 {
                let region = [vk::BufferCopy {
                    src_offset: first,
                    dst_offset: part.at + self.copied,
                    size: now,
                }];
                // SAFETY: both buffers have these ranges and live until the frame is done.
                unsafe {
                    gpu.device
                        .cmd_copy_buffer(commands, source, part.to, &region)
                };
            }
            // A copy costs something by itself.
            *budget = budget.saturating_sub(now.max(LEAST));
            self.copied += now;
            if part.from == Source::Staged {
                self.read += now;
            }
            if self.copied < part.size {
                return false;
            }
            self.part += 1;
            self.copied = 0;
        }
        true
    }

    /// The memory, which is not needed any more; the caller frees it when the device is done.
    pub(crate) fn take(&mut self) -> Option<Buffer> {
        self.buffer.take()
    }
}
