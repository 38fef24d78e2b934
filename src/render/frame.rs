//! Frames in flight: command buffers, fences, the buffers that each frame rewrites, and what may be freed when.
//!
//! Two slots take turns. A slot's fence says that the device has finished the slot's last
//! frame, so its buffers may be rewritten. Fences rather than a timeline semaphore: they are Vulkan 1.0, and an
//! OpenXR runtime that makes the device may add its own timeline feature structure.

use std::time::Duration;

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::{
    clock::Clock,
    data::{FrameData, RodData, SolidData},
    error::{RenderError, Trying as _},
    gpu::Gpu,
    memory::Buffer,
};

/// Frames that may be under way at once.
pub(crate) const SLOTS: usize = 2;

/// Longest wait for a frame in nanoseconds. Only a guard against hanging for ever: drawing a million
/// segments by the processor takes many seconds.
const LONGEST_WAIT: u64 = 300_000_000_000;

/// Room at start; it doubles when a scene needs more.
const FIRST_RODS: usize = 2048;
const FIRST_SOLIDS: usize = 64;

/// A command buffer with its own pool and fence.
pub(crate) struct Commands {
    pub(crate) buffer: vk::CommandBuffer,
    pool: vk::CommandPool,
    fence: vk::Fence,
    gpu: Gpu,
}

impl Commands {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let mut commands = Self {
            buffer: vk::CommandBuffer::null(),
            pool: vk::CommandPool::null(),
            fence: vk::Fence::null(),
            gpu: gpu.clone(),
        };
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(gpu.family);
        let fence = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
        // SAFETY: plain objects of this device; `Drop` frees what was made.
        unsafe {
            commands.pool = gpu
                .device
                .create_command_pool(&pool, None)
                .trying("making a command pool")?;
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(commands.pool)
                .command_buffer_count(1);
            commands.buffer = gpu
                .device
                .allocate_command_buffers(&info)
                .trying("making a command buffer")?
                .first()
                .copied()
                .unwrap_or_default();
            commands.fence = gpu
                .device
                .create_fence(&fence, None)
                .trying("making a fence")?;
        }
        Ok(commands)
    }

    /// Waits until the last submission is done.
    pub(crate) fn wait(&self) -> Result<(), RenderError> {
        // SAFETY: the fence is ours.
        unsafe {
            self.gpu
                .device
                .wait_for_fences(&[self.fence], true, LONGEST_WAIT)
        }
        .trying("waiting for a frame")
    }

    /// Waits, then begins to record.
    pub(crate) fn begin(&self) -> Result<vk::CommandBuffer, RenderError> {
        self.wait()?;
        let info = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the fence says that the device is done with the pool.
        unsafe {
            self.gpu
                .device
                .reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())
                .trying("resetting a command pool")?;
            self.gpu
                .device
                .begin_command_buffer(self.buffer, &info)
                .trying("beginning a frame")?;
        }
        Ok(self.buffer)
    }

    /// Ends recording and submits.
    pub(crate) fn submit(&self) -> Result<(), RenderError> {
        self.submit_between(None, None)
    }

    /// Ends recording and submits: after the first semaphore, before the second.
    pub(crate) fn submit_between(
        &self,
        wait: Option<vk::Semaphore>,
        signal: Option<vk::Semaphore>,
    ) -> Result<(), RenderError> {
        // SAFETY: recording was begun; the fence is not in use (see `begin`).
        unsafe {
            self.gpu
                .device
                .end_command_buffer(self.buffer)
                .trying("ending a frame")?;
            self.gpu
                .device
                .reset_fences(&[self.fence])
                .trying("resetting a fence")?;
        }
        self.gpu.submit(self.buffer, self.fence, [wait, signal])
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        // A fence that was reset but never submitted would wait for ever: `submit` fails only with the device.
        // SAFETY: the queue has nothing of ours after the wait; null handles are ignored.
        unsafe {
            let _ = self.gpu.wait_idle();
            self.gpu.device.destroy_fence(self.fence, None);
            self.gpu.device.destroy_command_pool(self.pool, None);
        }
    }
}

/// Records and runs commands at once, waiting for their end. Only for start-up and read-back.
pub(crate) fn run_now(
    gpu: &Gpu,
    record: impl FnOnce(vk::CommandBuffer),
) -> Result<(), RenderError> {
    let commands = Commands::new(gpu)?;
    record(commands.begin()?);
    commands.submit()?;
    commands.wait()
}

/// Waits for everything before and makes it seen by everything after: for start-up, uploads and read-back, where being simple
/// matters more than overlap.
pub(crate) fn full_barrier(
    gpu: &Gpu,
    commands: vk::CommandBuffer,
    images: &[vk::ImageMemoryBarrier2<'_>],
) {
    let memory = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
    let info = vk::DependencyInfo::default()
        .memory_barriers(&memory)
        .image_memory_barriers(images);
    // SAFETY: the command buffer is recording; images are alive.
    unsafe { (gpu.newer.barrier)(commands, &raw const info) };
}

/// Makes a resolved depth image what whoever takes it over expects: written as depth. Depth is resolved in the stage
/// that writes colours, and an OpenXR runtime's own barrier at the release waits only for the stages of depth.
pub(crate) fn depth_was_resolved(gpu: &Gpu, commands: vk::CommandBuffer) {
    let memory = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT)
        .src_access_mask(vk::AccessFlags2::COLOR_ATTACHMENT_WRITE)
        .dst_stage_mask(
            vk::PipelineStageFlags2::EARLY_FRAGMENT_TESTS
                | vk::PipelineStageFlags2::LATE_FRAGMENT_TESTS,
        )
        .dst_access_mask(
            vk::AccessFlags2::DEPTH_STENCIL_ATTACHMENT_READ
                | vk::AccessFlags2::DEPTH_STENCIL_ATTACHMENT_WRITE,
        )];
    let info = vk::DependencyInfo::default().memory_barriers(&memory);
    // SAFETY: the command buffer is recording.
    unsafe { (gpu.newer.barrier)(commands, &raw const info) };
}

/// An image barrier from everything to everything.
pub(crate) fn transition(
    image: vk::Image,
    aspect: vk::ImageAspectFlags,
    from: vk::ImageLayout,
    to: vk::ImageLayout,
) -> vk::ImageMemoryBarrier2<'static> {
    vk::ImageMemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
        .old_layout(from)
        .new_layout(to)
        .image(image)
        .subresource_range(whole(aspect))
}

/// All levels and layers.
pub(crate) fn whole(aspect: vk::ImageAspectFlags) -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange {
        aspect_mask: aspect,
        base_mip_level: 0,
        level_count: vk::REMAINING_MIP_LEVELS,
        base_array_layer: 0,
        layer_count: vk::REMAINING_ARRAY_LAYERS,
    }
}

/// A descriptor pool.
pub(crate) struct Pool {
    pub(crate) handle: vk::DescriptorPool,
    gpu: Gpu,
}

impl Pool {
    /// Room for `sets` sets with so many of each type.
    pub(crate) fn new(
        gpu: &Gpu,
        sets: u32,
        sizes: &[(vk::DescriptorType, u32)],
    ) -> Result<Self, RenderError> {
        let sizes: Vec<_> = sizes
            .iter()
            .map(|(kind, count)| {
                vk::DescriptorPoolSize::default()
                    .ty(*kind)
                    .descriptor_count(*count)
            })
            .collect();
        let info = vk::DescriptorPoolCreateInfo::default()
            .max_sets(sets)
            .pool_sizes(&sizes);
        // SAFETY: a plain pool.
        let handle = unsafe { gpu.device.create_descriptor_pool(&info, None) }
            .trying("making a descriptor pool")?;
        Ok(Self {
            handle,
            gpu: gpu.clone(),
        })
    }

    /// A set from the pool.
    pub(crate) fn set(
        &self,
        layout: vk::DescriptorSetLayout,
    ) -> Result<vk::DescriptorSet, RenderError> {
        let layouts = [layout];
        let info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(self.handle)
            .set_layouts(&layouts);
        // SAFETY: pool and layout are alive.
        let sets = unsafe { self.gpu.device.allocate_descriptor_sets(&info) }
            .trying("making a descriptor set")?;
        Ok(sets.first().copied().unwrap_or_default())
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        // SAFETY: owners drop pools only after the frames that use their sets.
        unsafe { self.gpu.device.destroy_descriptor_pool(self.handle, None) };
    }
}

/// What one frame rewrites.
pub(crate) struct Slot {
    pub(crate) commands: Commands,
    /// Two blocks of `FrameData`: the second has the eyes swapped, for the right eye's own pass.
    pub(crate) frame: Buffer,
    pub(crate) rods: Buffer,
    pub(crate) solids: Buffer,
    pub(crate) set: vk::DescriptorSet,
    /// Where the device tells the time.
    pub(crate) clock: Option<Clock>,
}

impl Slot {
    pub(crate) fn new(gpu: &Gpu, set: vk::DescriptorSet) -> Result<Self, RenderError> {
        Ok(Self {
            commands: Commands::new(gpu)?,
            frame: Buffer::new(
                gpu,
                "the frame's numbers",
                2 * block_stride(gpu),
                vk::BufferUsageFlags::UNIFORM_BUFFER,
                MemoryLocation::CpuToGpu,
            )?,
            rods: instances::<RodData>(gpu, "the rods", FIRST_RODS)?,
            solids: instances::<SolidData>(gpu, "the plates and controllers", FIRST_SOLIDS)?,
            set,
            clock: Clock::new(gpu)?,
        })
    }

    /// Begins the next frame, when the last one is done; and how long the device worked on that one.
    pub(crate) fn begin(&mut self) -> Result<(vk::CommandBuffer, Option<Duration>), RenderError> {
        let commands = self.commands.begin()?;
        let worked = self.clock.as_mut().and_then(Clock::read);
        if let Some(clock) = &self.clock {
            clock.start(commands);
        }
        Ok((commands, worked))
    }

    /// Hands the frame over.
    pub(crate) fn submit(&mut self) -> Result<(), RenderError> {
        if let Some(clock) = &self.clock {
            clock.stop(self.commands.buffer);
        }
        self.commands.submit()?;
        if let Some(clock) = &mut self.clock {
            clock.runs();
        }
        Ok(())
    }

    /// Makes room for so many rods and solids; true when buffers changed and the set must be written anew.
    pub(crate) fn make_room(
        &mut self,
        gpu: &Gpu,
        rods: usize,
        solids: usize,
    ) -> Result<bool, RenderError> {
        let mut changed = false;
        if (rods * size_of::<RodData>()) as u64 > self.rods.size {
            self.rods = instances::<RodData>(gpu, "the rods", rods.next_power_of_two())?;
            changed = true;
        }
        if (solids * size_of::<SolidData>()) as u64 > self.solids.size {
            self.solids = instances::<SolidData>(
                gpu,
                "the plates and controllers",
                solids.next_power_of_two(),
            )?;
            changed = true;
        }
        Ok(changed)
    }
}

fn instances<T>(gpu: &Gpu, name: &'static str, count: usize) -> Result<Buffer, RenderError> {
    Buffer::new(
        gpu,
        name,
        (count * size_of::<T>()) as u64,
        vk::BufferUsageFlags::STORAGE_BUFFER,
        MemoryLocation::CpuToGpu,
    )
}

/// Bytes from one block of `FrameData` to the next.
pub(crate) fn block_stride(gpu: &Gpu) -> u64 {
    (size_of::<FrameData>() as u64)
        .next_multiple_of(gpu.limits.min_uniform_buffer_offset_alignment.max(16))
}
