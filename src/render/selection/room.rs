//! What grows with the models of a frame: marks, sums, draws, where they stand.

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::{DRAW_BYTES, GROUP, buffer, standings::StandingData, write_uniform};
use crate::render::{
    error::RenderError,
    frame::{Pool, SLOTS},
    gpu::Gpu,
    memory::Buffer,
    model_upload::write_set,
    pipelines::Layout,
};

/// How much there is room for.
#[derive(Clone, Copy)]
pub(super) struct Size {
    pub(super) groups: u32,
    pub(super) draws: u32,
    pub(super) standings: u32,
}

impl Default for Size {
    fn default() -> Self {
        Self {
            groups: 64,
            draws: 16,
            standings: 16,
        }
    }
}

impl Size {
    /// The size to grow to; nothing where all that is wanted fits.
    pub(super) fn growing_to(self, wanted: Self) -> Option<Self> {
        let grown = |has: u32, wanted: u32| has.max(wanted.next_power_of_two());
        let fits = wanted.groups <= self.groups
            && wanted.draws <= self.draws
            && wanted.standings <= self.standings;
        (!fits).then(|| Self {
            groups: grown(self.groups, wanted.groups),
            draws: grown(self.draws, wanted.draws),
            standings: grown(self.standings, wanted.standings),
        })
    }
}

/// What all rooms share.
pub(super) struct Shared<'a> {
    pub(super) layout: &'a Layout,
    /// Of the list and the standings.
    pub(super) list_layout: vk::DescriptorSetLayout,
    /// Of the eyes and of the sun.
    pub(super) views: [&'a [Buffer; SLOTS]; 2],
    pub(super) state: &'a Buffer,
    pub(super) list: &'a Buffer,
}

/// See the module.
pub(super) struct Room {
    pub(super) size: Size,
    _marks: Buffer,
    _sums: Buffer,
    pub(super) chosen: Buffer,
    /// By slot: where the models stand.
    pub(super) standings: [Buffer; SLOTS],
    /// By slot: what was chosen, where the processor sees it.
    pub(super) told: [Buffer; SLOTS],
    /// By slot, for the eyes and for the sun.
    pub(super) sets: [[vk::DescriptorSet; 2]; SLOTS],
    /// By slot: the list and the standings, for whoever draws from them.
    pub(super) list_sets: [vk::DescriptorSet; SLOTS],
    _pool: Pool,
}

impl Room {
    pub(super) fn new(gpu: &Gpu, shared: &Shared<'_>, size: Size) -> Result<Self, RenderError> {
        let groups = u64::from(size.groups);
        let marks = buffer(gpu, "the clusters' marks", groups * u64::from(GROUP) * 4)?;
        let sums = buffer(gpu, "the groups' triangles", (groups + 1) * 4)?;
        let draws = u64::from(size.draws) * DRAW_BYTES;
        let chosen = buffer(gpu, "the models' draws", draws)?;
        let seen = |name, bytes, usage, place| Buffer::new(gpu, name, bytes, usage, place);
        let told = || {
            let usage = vk::BufferUsageFlags::TRANSFER_DST;
            let place = MemoryLocation::GpuToCpu;
            seen("what was chosen", draws + DRAW_BYTES, usage, place)
        };
        let standings = || {
            let bytes = u64::from(size.standings) * size_of::<StandingData>() as u64;
            let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
            let place = MemoryLocation::CpuToGpu;
            seen("where the models stand", bytes, usage, place)
        };
        let (told, standings) = ([told()?, told()?], [standings()?, standings()?]);
        let count = u32::try_from(SLOTS).unwrap_or(2);
        let pool = Pool::new(
            gpu,
            3 * count,
            &[
                (vk::DescriptorType::UNIFORM_BUFFER, 2 * count),
                (vk::DescriptorType::STORAGE_BUFFER, (2 * 6 + 2) * count),
            ],
        )?;
        let first = shared.layout.sets.first().copied().unwrap_or_default();
        let set = |slot: usize, views: &Buffer| {
            let set = pool.set(first)?;
            write_uniform(gpu, set, views);
            let standings = &standings[slot];
            let storage = [shared.state, &marks, &sums, shared.list, standings, &chosen];
            write_set(gpu, set, 1, &storage);
            Ok::<_, RenderError>(set)
        };
        let list = |slot: usize| {
            let set = pool.set(shared.list_layout)?;
            write_set(gpu, set, 0, &[shared.list, &standings[slot]]);
            Ok::<_, RenderError>(set)
        };
        let [eyes, sun] = shared.views;
        let both = |slot: usize| {
            let both = [set(slot, &eyes[slot])?, set(slot, &sun[slot])?];
            Ok::<_, RenderError>(both)
        };
        Ok(Self {
            size,
            sets: [both(0)?, both(1)?],
            list_sets: [list(0)?, list(1)?],
            told,
            _marks: marks,
            _sums: sums,
            chosen,
            standings,
            _pool: pool,
        })
    }
}
