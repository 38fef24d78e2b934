//! The choice of trees' clusters, branches and leaves: what shaders/crown.wgsl needs, and the draws that it makes.
//!
//! The same choice serves two passes: of what the eyes see, and of what the sun sees while the shadow map is drawn.

use std::ops::Range;

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::{
    GROUP, SLACK, buffer, choice_layout, number,
    standings::{ItemData, StandingData},
    write_uniform,
};
use crate::render::{
    crown_upload::CrownChunk,
    error::RenderError,
    frame::{Pool, SLOTS, full_barrier},
    gpu::Gpu,
    memory::Buffer,
    model_upload::write_set,
    pipelines::{Layout, Pipeline},
    shaders::crown,
};
use crate::tree::levels::{
    cut::{Standing, Views},
    kinds::{ENDS, KINDS, NONE, kind_of},
};

/// Words and bytes of an indexed draw.
const WORDS: usize = 5;
const DRAW_BYTES: u64 = size_of::<vk::DrawIndexedIndirectCommand>() as u64;

/// Triangles that a batch has at least: what bounds the list. A leaf may be one.
const FEWEST: u32 = 8;

/// Who a choice is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum For {
    Eyes,
    Sun,
}

/// A chunk of a tree that is drawn in this frame.
struct Item {
    set: vk::DescriptorSet,
    data: ItemData,
    /// Kinds that any of its clusters can be of, as the eyes see it.
    kinds: Range<u32>,
    /// Those of the sun.
    all: Range<u32>,
    /// Whether ends have kinds of their own.
    has_ends: bool,
}

/// What grows with the trees.
struct Room {
    groups: u32,
    items: u32,
    _marks: Buffer,
    _sums: Buffer,
    draws: Buffer,
    /// By slot: the draws, where the processor sees them.
    told: [Buffer; SLOTS],
    /// By slot, for the eyes and for the sun.
    sets: [[vk::DescriptorSet; 2]; SLOTS],
    _pool: Pool,
}

/// What must live until the frames before are done.
pub(crate) struct OldCrowns(#[allow(dead_code, reason = "kept to be dropped later")] Box<Room>);

pub(crate) struct Crowns {
    /// Set 0: everything; set 1: a chunk's clusters and kinds.
    pub(crate) layout: Layout,
    /// Weigh, count, place, write.
    kernels: [Pipeline; 4],
    sun: [Buffer; SLOTS],
    /// By slot: where the tree stands.
    standings: [Buffer; SLOTS],
    list: Buffer,
    room: Room,
    /// The list for whoever draws from it.
    pub(crate) list_set: vk::DescriptorSet,
    _pool: Pool,
    items: Vec<Item>,
    /// By slot: of how many items draws were told.
    told: [usize; SLOTS],
    gpu: Gpu,
}

impl Crowns {
    /// `list_layout`: of one storage buffer, for the list; `most`: triangles of all trees.
    pub(super) fn new(
        gpu: &Gpu,
        list_layout: vk::DescriptorSetLayout,
        most: u32,
        eyes: &[Buffer; SLOTS],
        state: &Buffer,
    ) -> Result<Self, RenderError> {
        use vk::DescriptorType as Kind;
        let layout = choice_layout(gpu, &[Kind::STORAGE_BUFFER; 2])?;
        let kernel = |entry| {
            let name = "choosing levels of detail of trees";
            Pipeline::compute(gpu, &layout, name, crown::SPIRV, entry)
        };
        let kernels = [
            kernel(crown::WEIGH)?,
            kernel(crown::COUNT)?,
            kernel(crown::PLACE)?,
            kernel(crown::WRITE)?,
        ];
        let views = || {
            let bytes = size_of::<Views>() as u64;
            let usage = vk::BufferUsageFlags::UNIFORM_BUFFER;
            let place = MemoryLocation::CpuToGpu;
            Buffer::new(gpu, "where the sun is", bytes, usage, place)
        };
        let standing = || {
            let bytes = size_of::<StandingData>() as u64;
            let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
            let place = MemoryLocation::CpuToGpu;
            Buffer::new(gpu, "where the tree stands", bytes, usage, place)
        };
        let sun = [views()?, views()?];
        let standings = [standing()?, standing()?];
        let batches = u64::from(most / FEWEST).max(u64::from(GROUP));
        let list = buffer(gpu, "the batches to draw", batches * 4)?;
        let pool = Pool::new(gpu, 1, &[(Kind::STORAGE_BUFFER, 1)])?;
        let list_set = pool.set(list_layout)?;
        write_set(gpu, list_set, 0, &[&list]);
        let shared = Shared {
            layout: &layout,
            eyes,
            sun: &sun,
            standings: &standings,
            state,
            list: &list,
        };
        let room = Room::new(gpu, &shared, [64, 4])?;
        Ok(Self {
            layout,
            kernels,
            sun,
            standings,
            list,
            room,
            list_set,
            _pool: pool,
            items: Vec::with_capacity(16),
            told: [0; SLOTS],
            gpu: gpu.clone(),
        })
    }

    /// Begins a frame's list of chunks; how many triangles the slot's last frame chose, where it had a tree.
    pub(super) fn begin(&mut self, slot: usize) -> Option<u64> {
        self.items.clear();
        self.chosen(slot)
    }

    /// Triangles that the last frame in a slot chose, where it had a tree; only when that is done.
    pub(super) fn chosen(&mut self, slot: usize) -> Option<u64> {
        let count = self.told[slot] * KINDS;
        let words = self.room.told[slot].bytes().as_chunks::<4>().0;
        let draws = words.as_chunks::<WORDS>().0.iter().take(count);
        let number = |word: &[u8; 4]| u64::from(u32::from_le_bytes(*word));
        let triangles = draws.map(|draw| number(&draw[0]) / 3 * number(&draw[1]));
        (count > 0).then(|| triangles.sum())
    }

    /// The last frame's list for each item. Only when all frames are done.
    pub(crate) fn read(&mut self, slot: usize) -> Result<Vec<Vec<u32>>, RenderError> {
        let words = super::read(&self.gpu, &self.list)?;
        let told = self.room.told[slot].bytes().as_chunks::<4>().0;
        let number = |word: &[u8; 4]| u32::from_le_bytes(*word) as usize;
        let draws = told.as_chunks::<WORDS>().0.chunks(KINDS);
        let part = |draws: &[[[u8; 4]; WORDS]]| {
            let of = |[_, count, .., first]: &[[u8; 4]; WORDS]| {
                let run = number(first)..number(first) + number(count);
                words.get(run).unwrap_or_default().to_vec()
            };
            draws.iter().flat_map(of).collect()
        };
        Ok(draws.take(self.told[slot]).map(part).collect())
    }

    pub(super) fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// Adds the chunks of a tree that stands like this, seen by these eyes; the wind moves leaves by such a part of their length more than what bears them.
    pub(crate) fn add<'a>(
        &mut self,
        slot: usize,
        standing: Standing,
        views: &Views,
        chunks: impl Iterator<Item = (&'a CrownChunk, f32)>,
    ) {
        self.standings[slot].write(0, &[StandingData::from(&standing)]);
        for (chunk, flutter) in chunks {
            let sway = standing.sway + flutter * chunk.size * standing.scale;
            self.add_chunk(chunk, Standing { sway, ..standing }, views);
        }
    }

    fn add_chunk(&mut self, chunk: &CrownChunk, standing: Standing, views: &Views) {
        let all = 0..chunk.kinds_count();
        let largest = standing.pixels(chunk.sphere, chunk.size, views) * SLACK;
        let finest = kind_of(&chunk.table, largest);
        let kinds = if standing.is_seen(chunk.sphere, views) {
            finest..all.end
        } else {
            0..0
        };
        self.items.push(Item {
            set: chunk.choice,
            kinds,
            all,
            has_ends: chunk.table.iter().any(|kind| kind.ends != NONE),
            data: ItemData {
                clusters: chunk.count,
                first_group: self.groups(),
                groups: chunk.count.div_ceil(GROUP),
                models: 1,
                draw: number(self.items.len() * KINDS),
                sway: standing.sway,
                ..ItemData::default()
            },
        });
    }

    /// Makes room for what was added; what held it before, where that had to change.
    pub(super) fn make_room(
        &mut self,
        eyes: &[Buffer; SLOTS],
        state: &Buffer,
    ) -> Result<Option<OldCrowns>, RenderError> {
        let items = number(self.items.len());
        if self.groups() <= self.room.groups && items <= self.room.items {
            return Ok(None);
        }
        let wanted = [
            self.groups().max(self.room.groups).next_power_of_two(),
            items.max(self.room.items).next_power_of_two(),
        ];
        let shared = Shared {
            layout: &self.layout,
            eyes,
            sun: &self.sun,
            standings: &self.standings,
            state,
            list: &self.list,
        };
        let room = Room::new(&self.gpu, &shared, wanted)?;
        self.forget_told();
        let old = std::mem::replace(&mut self.room, room);
        Ok(Some(OldCrowns(Box::new(old))))
    }

    /// Nothing has been told that could be read.
    pub(super) fn forget_told(&mut self) {
        self.told = [0; SLOTS];
    }

    fn groups(&self) -> u32 {
        self.items.last().map_or(0, |item| item.data.end())
    }

    /// Says where the sun is.
    pub(super) fn write_sun(&mut self, slot: usize, views: Views) {
        self.sun[slot].write(0, &[views]);
    }

    /// Counts at which threshold each cluster would be drawn.
    pub(super) fn weigh(&self, commands: vk::CommandBuffer, slot: usize, whom: For) {
        if self.items.is_empty() {
            return;
        }
        self.each(commands, slot, whom, &self.kernels[0]);
    }

    /// Makes list and draws, now that the threshold is known.
    pub(super) fn list(&self, commands: vk::CommandBuffer, slot: usize, whom: For) {
        if self.items.is_empty() {
            return;
        }
        let [_, count, place, write] = &self.kernels;
        self.each(commands, slot, whom, count);
        let all = ItemData {
            groups: self.groups() * number(KINDS),
            ..ItemData::default()
        };
        self.bind(commands, slot, whom, place);
        self.run(commands, &all, 1);
        full_barrier(&self.gpu, commands, &[]);
        self.each(commands, slot, whom, write);
    }

    fn each(&self, commands: vk::CommandBuffer, slot: usize, whom: For, kernel: &Pipeline) {
        self.bind(commands, slot, whom, kernel);
        for item in &self.items {
            // SAFETY: the set's layout is the second of the pipeline layout; its buffers live until the frame is done.
            unsafe {
                self.gpu.device.cmd_bind_descriptor_sets(
                    commands,
                    vk::PipelineBindPoint::COMPUTE,
                    self.layout.handle,
                    1,
                    &[item.set],
                    &[],
                );
            }
            self.run(commands, &item.data, item.data.groups);
        }
        full_barrier(&self.gpu, commands, &[]);
    }

    fn bind(&self, commands: vk::CommandBuffer, slot: usize, whom: For, kernel: &Pipeline) {
        let compute = vk::PipelineBindPoint::COMPUTE;
        let [eyes, sun] = self.room.sets[slot];
        let set = if whom == For::Eyes { eyes } else { sun };
        // SAFETY: pipeline and set are of this layout.
        unsafe {
            let device = &self.gpu.device;
            device.cmd_bind_pipeline(commands, compute, kernel.handle);
            let layout = self.layout.handle;
            device.cmd_bind_descriptor_sets(commands, compute, layout, 0, &[set], &[]);
        }
    }

    fn run(&self, commands: vk::CommandBuffer, data: &ItemData, groups: u32) {
        super::run(&self.gpu, commands, &self.layout, data, [groups, 1]);
    }

    /// Copies the draws to where the processor sees them when the frame is done.
    pub(super) fn tell(&mut self, commands: vk::CommandBuffer, slot: usize) {
        self.told[slot] = self.items.len();
        if self.items.is_empty() {
            return;
        }
        let size = (self.items.len() * KINDS) as u64 * DRAW_BYTES;
        let region = [vk::BufferCopy::default().size(size)];
        let (draws, told) = (self.room.draws.handle, self.room.told[slot].handle);
        // SAFETY: both buffers have so many bytes and live until the frame is done.
        unsafe {
            let device = &self.gpu.device;
            device.cmd_copy_buffer(commands, draws, told, &region);
        }
    }

    /// Draws of an item: their buffer, and runs of neighbours in it, each with the byte that it begins at and how many there are.
    pub(crate) fn draws(&self, item: usize, whom: For) -> (vk::Buffer, [(u64, u32); 2]) {
        let Some(item) = self.items.get(item) else {
            return (self.room.draws.handle, [(0, 0); 2]);
        };
        let kinds = if whom == For::Eyes {
            &item.kinds
        } else {
            &item.all
        };
        let at = |kind: u32| u64::from(item.data.draw + kind) * DRAW_BYTES;
        let ends = u32::try_from(ENDS).unwrap_or(0);
        let all = u32::try_from(KINDS).unwrap_or(0);
        let caps = if item.has_ends && !kinds.is_empty() {
            (kinds.start + ends).min(all)..all
        } else {
            0..0
        };
        let run = |run: &Range<u32>| (at(run.start), run.end - run.start);
        (self.room.draws.handle, [run(kinds), run(&caps)])
    }
}

impl CrownChunk {
    /// How many kinds its clusters may be of.
    fn kinds_count(&self) -> u32 {
        let more = self.table.iter().skip(1);
        let more = more.take_while(|kind| kind.below > 0.0).count();
        1 + u32::try_from(more).unwrap_or(0)
    }
}

/// What all rooms share.
struct Shared<'a> {
    layout: &'a Layout,
    eyes: &'a [Buffer; SLOTS],
    sun: &'a [Buffer; SLOTS],
    standings: &'a [Buffer; SLOTS],
    state: &'a Buffer,
    list: &'a Buffer,
}

impl Room {
    fn new(gpu: &Gpu, shared: &Shared<'_>, [groups, items]: [u32; 2]) -> Result<Self, RenderError> {
        let kinds = KINDS as u64;
        let marks = buffer(gpu, "the crowns' marks", u64::from(groups * GROUP) * 4)?;
        let sums = buffer(gpu, "the crowns' sums", (u64::from(groups) * kinds + 1) * 4)?;
        let bytes = u64::from(items) * kinds * DRAW_BYTES;
        let draws = buffer(gpu, "the crowns' draws", bytes)?;
        let told = || {
            let usage = vk::BufferUsageFlags::TRANSFER_DST;
            let seen = MemoryLocation::GpuToCpu;
            Buffer::new(gpu, "what was chosen of crowns", bytes, usage, seen)
        };
        let told = [told()?, told()?];
        let count = u32::try_from(2 * SLOTS).unwrap_or(4);
        let pool = Pool::new(
            gpu,
            count,
            &[
                (vk::DescriptorType::UNIFORM_BUFFER, count),
                (vk::DescriptorType::STORAGE_BUFFER, 6 * count),
            ],
        )?;
        let first = shared.layout.sets.first().copied().unwrap_or_default();
        let set = |slot: usize, views: &Buffer| {
            let set = pool.set(first)?;
            write_uniform(gpu, set, views);
            let standing = &shared.standings[slot];
            let storage = [shared.state, &marks, &sums, shared.list, standing, &draws];
            write_set(gpu, set, 1, &storage);
            Ok::<_, RenderError>(set)
        };
        let both = |slot: usize| {
            let both = [
                set(slot, &shared.eyes[slot])?,
                set(slot, &shared.sun[slot])?,
            ];
            Ok::<_, RenderError>(both)
        };
        Ok(Self {
            groups,
            items,
            sets: [both(0)?, both(1)?],
            told,
            _marks: marks,
            _sums: sums,
            draws,
            _pool: pool,
        })
    }
}

const _: () = assert!(
    NONE == u32::MAX && KINDS == 8,
    "shaders/crown.wgsl knows these"
);
