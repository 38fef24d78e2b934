//! Which triangles of models and which clusters of trees are drawn in a frame: worked out on the device by shaders/select.wgsl and crown.wgsl, before the
//! stage is drawn, at one threshold for all.
//!
//! Everything stays on the device: a list of triangles, and for each chunk of a model a draw that says which part of the list is its own. Models of one
//! mesh and one look that follow each other, a wood's trees, are a run: one dispatch a step, and one draw, whose entries of the list say which of them
//! a triangle is of. The processor hands over where each model stands and a few numbers a chunk, and asks nothing back; what was chosen is told two
//! frames later, when the slot's fence says that it is there anyway.

mod crowns;
mod room;
mod standings;

use std::ops::Range;

use ash::vk;
use glam::{Vec3, Vec4};
use gpu_allocator::MemoryLocation;

use self::{
    room::{Room, Shared, Size},
    standings::{ItemData, StandingData},
};
use super::{
    error::RenderError,
    eye::{Eye, NEAR},
    frame::{SLOTS, full_barrier, run_now},
    gpu::Gpu,
    memory::Buffer,
    model_upload::{Geometry, cut_of},
    pipelines::{Layout, Pipeline},
    shaders::select,
};
use crate::mesh::display::Display;
use crate::tree::levels::cut::{BINS, Standing, Views, pixels, side};
use crate::world::scene::{ModelLook, PlacedModel};

pub(crate) use self::crowns::{Crowns, For, OldCrowns};

/// Clusters that a workgroup looks at.
const GROUP: u32 = 64;

/// By how much more than the processor finds something may be seen by the device, which rounds otherwise.
const SLACK: f32 = 1.001;

/// An entry of the list has a triangle's number in its lower bits, and above them whose of the draw's models it is: `MODEL_SHIFT` of
/// shaders/shared/standing.wgsl.
const MODEL_SHIFT: u32 = 24;
/// Models that one draw shows.
pub(crate) const MODELS_MOST: usize = 1 << (u32::BITS - MODEL_SHIFT);
/// Triangles that a chunk of a model may have, in all levels.
pub(crate) const TRIANGLES_MOST: usize = 1 << MODEL_SHIFT;

/// Whose of a draw's models an entry of the list is, and its triangle in the chunk.
pub(crate) fn entry_parts(entry: u32) -> (usize, u32) {
    (
        (entry >> MODEL_SHIFT) as usize,
        entry & ((1 << MODEL_SHIFT) - 1),
    )
}

/// Bytes of `State` of shaders/shared/choice.wgsl.
const STATE_BYTES: u64 = BINS as u64 * 4 + 4;
/// Bytes of a draw.
pub(crate) const DRAW_BYTES: u64 = size_of::<vk::DrawIndirectCommand>() as u64;

/// What the device chose of all models and trees in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Chosen {
    /// Triangles, each counted once for both eyes.
    pub triangles: u64,
    /// What they may be off by, pixels: 1 where everything fits the frame.
    pub error_px: f32,
}

/// Models of one mesh and one look that are drawn as one.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// Their numbers among all that stand.
    pub(crate) standings: Range<usize>,
    /// Their chunks among the items.
    pub(crate) items: Range<usize>,
}

/// A chunk of a run's mesh.
#[derive(Clone, Copy)]
pub(crate) struct Item {
    /// Its number in the mesh.
    pub(crate) chunk: usize,
    set: vk::DescriptorSet,
    data: ItemData,
    /// Whether it is in the sun's map.
    shadow: bool,
}

/// A draw of a frame, as it was told: whose it is, and its part of the list.
pub(crate) struct Listed {
    /// By the models that it draws: their numbers in the scene.
    pub(crate) models: Vec<usize>,
    pub(crate) chunk: usize,
    pub(crate) entries: Vec<u32>,
}

/// What must live until the frames before are done.
pub(crate) struct OldRoom(#[allow(dead_code, reason = "kept to be dropped later")] Box<Room>);

/// Those of models and of trees.
pub(crate) type OldRooms = (Option<OldRoom>, Option<OldCrowns>);

pub(crate) struct Selection {
    /// Set 0: everything; set 1: a chunk's clusters.
    pub(crate) layout: Layout,
    list_layout: vk::DescriptorSetLayout,
    kernels: [Pipeline; 5],
    views: [Buffer; SLOTS],
    sun: [Buffer; SLOTS],
    state: Buffer,
    list: Buffer,
    room: Room,
    /// By standing: the model's number in the scene.
    pub(crate) models: Vec<usize>,
    standings: Vec<StandingData>,
    pub(crate) runs: Vec<Run>,
    pub(crate) items: Vec<Item>,
    /// By slot: how many draws were told of.
    told: [usize; SLOTS],
    pub(crate) crowns: Crowns,
    gpu: Gpu,
}

impl Selection {
    /// `list_layouts`: of two storage buffers, for the list and the standings of models, and of one, for the list of trees; `most`: triangles of all
    /// models and trees.
    pub(crate) fn new(
        gpu: &Gpu,
        [list_layout, crowns_layout]: [vk::DescriptorSetLayout; 2],
        most: u32,
    ) -> Result<Self, RenderError> {
        use vk::DescriptorType as Kind;
        let most = most.min(gpu.limits.max_storage_buffer_range / 4);
        let layout = choice_layout(gpu, &[Kind::STORAGE_BUFFER])?;
        let kernel = |entry| {
            Pipeline::compute(
                gpu,
                &layout,
                "choosing levels of detail",
                select::SPIRV,
                entry,
            )
        };
        let kernels = [
            kernel(select::WEIGH)?,
            kernel(select::SETTLE)?,
            kernel(select::COUNT)?,
            kernel(select::PLACE)?,
            kernel(select::WRITE)?,
        ];
        let views = || {
            Buffer::new(
                gpu,
                "where both eyes are",
                size_of::<Views>() as u64,
                vk::BufferUsageFlags::UNIFORM_BUFFER,
                MemoryLocation::CpuToGpu,
            )
        };
        let (sun, views) = ([views()?, views()?], [views()?, views()?]);
        let state = buffer(gpu, "the threshold of detail", STATE_BYTES)?;
        let list = buffer(gpu, "the triangles to draw", u64::from(most.max(1)) * 4)?;
        let shared = Shared {
            layout: &layout,
            list_layout,
            views: [&views, &sun],
            state: &state,
            list: &list,
        };
        let room = Room::new(gpu, &shared, Size::default())?;
        let crowns = Crowns::new(gpu, crowns_layout, most, &views, &state)?;
        Ok(Self {
            crowns,
            layout,
            list_layout,
            kernels,
            views,
            sun,
            state,
            list,
            room,
            models: Vec::with_capacity(16),
            standings: Vec::with_capacity(16),
            runs: Vec::with_capacity(16),
            items: Vec::with_capacity(16),
            told: [0; SLOTS],
            gpu: gpu.clone(),
        })
    }

    /// Begins a frame's list of chunks; of what the slot's last frame chose.
    pub(crate) fn begin(&mut self, slot: usize) -> Chosen {
        self.models.clear();
        self.standings.clear();
        self.runs.clear();
        self.items.clear();
        let of_trees = self.crowns.begin(slot);
        self.chosen_with(slot, of_trees)
    }

    fn chosen_with(&mut self, slot: usize, of_trees: Option<u64>) -> Chosen {
        let draws = self.told[slot];
        if draws == 0 && of_trees.is_none() {
            return Chosen::default();
        }
        let mut chosen = chosen(self.room.told[slot].bytes(), draws);
        chosen.triangles += of_trees.unwrap_or(0);
        chosen
    }

    /// Says where the models stand that are due.
    pub(crate) fn stand(&mut self, scene: &[PlacedModel], is_due: impl Fn(&PlacedModel) -> bool) {
        for (number, placed) in scene
            .iter()
            .enumerate()
            .filter(|(_, placed)| is_due(placed))
        {
            self.models.push(number);
            let standing = standing(placed);
            self.standings.push(StandingData::from(&standing));
        }
    }

    /// Those of them from a number on that are of one mesh and one look, as many as one draw shows, and the first of these.
    pub(crate) fn run_from<'a>(
        &self,
        first: usize,
        scene: &'a [PlacedModel],
    ) -> Option<(Range<usize>, &'a PlacedModel)> {
        let left = self.models.get(first..)?.iter();
        let mut left = left
            .filter_map(|number| scene.get(*number))
            .take(MODELS_MOST);
        let placed = left.next()?;
        let more = left.take_while(|other| other.is_drawn_as(placed)).count();
        Some((first..first + 1 + more, placed))
    }

    /// Adds a run that [stands](Self::run_from) like this.
    pub(crate) fn add(&mut self, run: Range<usize>, look: &ModelLook, geometry: &Geometry) {
        let first = self.items.len();
        let drawn = has_faces(look);
        for (chunk, part) in geometry.chunks.iter().enumerate().filter(|_| drawn) {
            self.items.push(Item {
                chunk,
                set: part.set,
                shadow: look.shadow,
                data: ItemData {
                    clusters: part.clusters,
                    first_group: self.groups(),
                    groups: part.clusters.div_ceil(GROUP),
                    models: number(run.len()),
                    standing: number(run.start),
                    draw: number(self.items.len()),
                    ..ItemData::default()
                },
            });
        }
        self.runs.push(Run {
            standings: run,
            items: first..self.items.len(),
        });
    }

    /// Makes room for what was added, and says where it stands; what held it before, where that had to change.
    pub(crate) fn make_room(&mut self, slot: usize) -> Result<OldRooms, RenderError> {
        let crowns = self.crowns.make_room(&self.views, &self.state)?;
        let wanted = Size {
            groups: self.groups(),
            draws: number(self.items.len()),
            standings: number(self.standings.len()),
        };
        let mut old = None;
        if let Some(size) = self.room.size.growing_to(wanted) {
            let shared = Shared {
                layout: &self.layout,
                list_layout: self.list_layout,
                views: [&self.views, &self.sun],
                state: &self.state,
                list: &self.list,
            };
            let room = Room::new(&self.gpu, &shared, size)?;
            // The threshold stands in what is new now.
            self.crowns.forget_told();
            self.told = [0; SLOTS];
            let before = std::mem::replace(&mut self.room, room);
            old = Some(OldRoom(Box::new(before)));
        }
        self.room.standings[slot].write(0, &self.standings);
        Ok((old, crowns))
    }

    /// The list of triangles and where models stand, for whoever draws them.
    pub(crate) fn list_set(&self, slot: usize) -> vk::DescriptorSet {
        self.room.list_sets[slot]
    }

    fn groups(&self) -> u32 {
        self.items.last().map_or(0, |item| item.data.end())
    }

    /// Records the choice of at most `budget` triangles as these eyes see them.
    pub(crate) fn record(
        &mut self,
        commands: vk::CommandBuffer,
        slot: usize,
        views: &Views,
        budget: u32,
    ) {
        self.told[slot] = self.items.len();
        if self.items.is_empty() && self.crowns.is_empty() {
            self.crowns.tell(commands, slot);
            return;
        }
        self.views[slot].write(0, &[*views]);
        self.begin_choice(commands);
        self.each(commands, slot, For::Eyes, &self.kernels[0]);
        self.crowns.weigh(commands, slot, For::Eyes);
        self.settle(commands, slot, budget);
        self.list(commands, slot, For::Eyes);
        self.crowns.list(commands, slot, For::Eyes);
        self.tell(commands, slot);
    }

    /// Makes list and draws of models, now that the threshold is known.
    fn list(&self, commands: vk::CommandBuffer, slot: usize, whom: For) {
        if self.items.is_empty() {
            return;
        }
        let [_, _, count, place, write] = &self.kernels;
        let all = ItemData {
            groups: self.groups(),
            ..ItemData::default()
        };
        self.each(commands, slot, whom, count);
        self.once(commands, slot, place, &all);
        self.each(commands, slot, whom, write);
    }

    /// Records the choice of models for the sun's map of them, at most `budget` triangles.
    pub(crate) fn record_wood(
        &mut self,
        commands: vk::CommandBuffer,
        slot: usize,
        views: Views,
        budget: u32,
    ) {
        self.sun[slot].write(0, &[views]);
        self.begin_choice(commands);
        self.each(commands, slot, For::Sun, &self.kernels[0]);
        self.settle(commands, slot, budget);
        self.list(commands, slot, For::Sun);
    }

    /// Records the choice of trees for the sun's map, at most `budget` triangles.
    pub(crate) fn record_sun(
        &mut self,
        commands: vk::CommandBuffer,
        slot: usize,
        views: Views,
        budget: u32,
    ) {
        self.crowns.write_sun(slot, views);
        self.begin_choice(commands);
        self.crowns.weigh(commands, slot, For::Sun);
        self.settle(commands, slot, budget);
        self.crowns.list(commands, slot, For::Sun);
    }

    /// Forgets what was counted.
    fn begin_choice(&self, commands: vk::CommandBuffer) {
        let gpu = &self.gpu;
        full_barrier(gpu, commands, &[]);
        // SAFETY: the buffer has so many bytes.
        unsafe {
            gpu.device
                .cmd_fill_buffer(commands, self.state.handle, 0, STATE_BYTES, 0);
        }
        full_barrier(gpu, commands, &[]);
    }

    fn settle(&self, commands: vk::CommandBuffer, slot: usize, budget: u32) {
        let data = ItemData {
            budget,
            ..ItemData::default()
        };
        self.once(commands, slot, &self.kernels[1], &data);
    }

    fn each(&self, commands: vk::CommandBuffer, slot: usize, whom: For, kernel: &Pipeline) {
        if self.items.is_empty() {
            return;
        }
        self.bind(commands, slot, whom, kernel);
        for item in &self.items {
            let mut data = item.data;
            data.absent = u32::from(whom == For::Sun && !item.shadow);
            // SAFETY: the set's layout is the second of the pipeline layout; its buffer lives until the frame is done.
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
            self.run(commands, &data, [data.groups, data.models]);
        }
        full_barrier(&self.gpu, commands, &[]);
    }

    fn once(&self, commands: vk::CommandBuffer, slot: usize, kernel: &Pipeline, data: &ItemData) {
        self.bind(commands, slot, For::Eyes, kernel);
        self.run(commands, data, [1, 1]);
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
            device.cmd_bind_descriptor_sets(commands, compute, self.layout.handle, 0, &[set], &[]);
        }
    }

    fn run(&self, commands: vk::CommandBuffer, data: &ItemData, groups: [u32; 2]) {
        run(&self.gpu, commands, &self.layout, data, groups);
    }

    /// Copies what was chosen to where the processor sees it when the frame is done.
    fn tell(&mut self, commands: vk::CommandBuffer, slot: usize) {
        self.crowns.tell(commands, slot);
        let told = self.room.told[slot].handle;
        let copy = |src_offset, dst_offset, size| {
            [vk::BufferCopy {
                src_offset,
                dst_offset,
                size,
            }]
        };
        let draws = self.items.len() as u64 * DRAW_BYTES;
        let memory = [vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::TRANSFER)
            .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::HOST)
            .dst_access_mask(vk::AccessFlags2::HOST_READ)];
        let info = vk::DependencyInfo::default().memory_barriers(&memory);
        // SAFETY: all buffers have these ranges and live until the frame is done.
        unsafe {
            let device = &self.gpu.device;
            let threshold = copy(STATE_BYTES - 4, 0, 4);
            device.cmd_copy_buffer(commands, self.state.handle, told, &threshold);
            if draws > 0 {
                let draws = copy(0, DRAW_BYTES, draws);
                device.cmd_copy_buffer(commands, self.room.chosen.handle, told, &draws);
            }
            (self.gpu.newer.barrier)(commands, &raw const info);
        }
    }

    /// The buffer of draws, in the order of [`Self::items`].
    pub(crate) fn draws(&self) -> vk::Buffer {
        self.room.chosen.handle
    }

    /// What the last frame in a slot chose; only when that is done.
    pub(crate) fn chosen(&mut self, slot: usize) -> Chosen {
        let of_trees = self.crowns.chosen(slot);
        self.chosen_with(slot, of_trees)
    }

    /// The last frame's draws and what each has of the list: [entries](entry_parts). Only when all frames are done.
    pub(crate) fn read(&mut self, slot: usize) -> Result<Vec<Listed>, RenderError> {
        let list = read(&self.gpu, &self.list)?;
        let told = draws(self.room.told[slot].bytes(), self.told[slot]);
        let listed = self.items.iter().zip(told);
        let part = |(item, [vertices, _, first, _]): (&Item, [u32; 4])| {
            let run = first as usize / 3..(first + vertices) as usize / 3;
            let begin = item.data.standing as usize;
            Listed {
                models: self
                    .models
                    .get(begin..begin + item.data.models as usize)
                    .unwrap_or_default()
                    .to_vec(),
                chunk: item.chunk,
                entries: list.get(run).unwrap_or_default().to_vec(),
            }
        };
        Ok(listed.map(part).collect())
    }
}

/// The layout of a choice: set 0 is everything, set 1 what a chunk has.
fn choice_layout(gpu: &Gpu, chunk: &[vk::DescriptorType]) -> Result<Layout, RenderError> {
    let mut first = [vk::DescriptorType::STORAGE_BUFFER; 7];
    first[0] = vk::DescriptorType::UNIFORM_BUFFER;
    let immediates = u32::try_from(size_of::<ItemData>()).unwrap_or(0);
    let stage = vk::ShaderStageFlags::COMPUTE;
    Layout::staged(gpu, &[&first, chunk], immediates, stage)
}

fn number(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

/// What is in a buffer; only when all frames are done.
fn read(gpu: &Gpu, from: &Buffer) -> Result<Vec<u32>, RenderError> {
    let mut copy = Buffer::new(
        gpu,
        "reading back",
        from.size,
        vk::BufferUsageFlags::TRANSFER_DST,
        MemoryLocation::GpuToCpu,
    )?;
    run_now(gpu, |commands| {
        let region = [vk::BufferCopy::default().size(from.size)];
        // SAFETY: both buffers have this size.
        unsafe {
            gpu.device
                .cmd_copy_buffer(commands, from.handle, copy.handle, &region);
        }
        full_barrier(gpu, commands, &[]);
    })?;
    let words = copy.bytes().as_chunks::<4>().0;
    Ok(words.iter().map(|word| u32::from_le_bytes(*word)).collect())
}

/// Runs a kernel that is bound, with its set.
fn run(
    gpu: &Gpu,
    commands: vk::CommandBuffer,
    layout: &Layout,
    data: &ItemData,
    [across, down]: [u32; 2],
) {
    // SAFETY: the layout takes immediates of this size; there was room made for these groups.
    unsafe {
        gpu.device.cmd_push_constants(
            commands,
            layout.handle,
            vk::ShaderStageFlags::COMPUTE,
            0,
            bytemuck::bytes_of(data),
        );
        gpu.device.cmd_dispatch(commands, across, down, 1);
    }
}

fn buffer(gpu: &Gpu, name: &'static str, size: u64) -> Result<Buffer, RenderError> {
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER
        | vk::BufferUsageFlags::INDIRECT_BUFFER
        | vk::BufferUsageFlags::TRANSFER_SRC
        | vk::BufferUsageFlags::TRANSFER_DST;
    Buffer::new(gpu, name, size, usage, MemoryLocation::GpuOnly)
}

fn write_uniform(gpu: &Gpu, set: vk::DescriptorSet, buffer: &Buffer) {
    let info = [vk::DescriptorBufferInfo::default()
        .buffer(buffer.handle)
        .range(vk::WHOLE_SIZE)];
    let write = [vk::WriteDescriptorSet::default()
        .dst_set(set)
        .descriptor_type(vk::DescriptorType::UNIFORM_BUFFER)
        .buffer_info(&info)];
    // SAFETY: the set is new, the buffer lives as long as it.
    unsafe { gpu.device.update_descriptor_sets(&write, &[]) };
}

fn draws(told: &[u8], count: usize) -> impl Iterator<Item = [u32; 4]> {
    let words = told.as_chunks::<4>().0.as_chunks::<4>().0;
    let draw = |words: &[[u8; 4]; 4]| words.map(u32::from_le_bytes);
    words.iter().skip(1).take(count).map(draw)
}

fn chosen(told: &[u8], count: usize) -> Chosen {
    let threshold = told.first_chunk().copied().map_or(0, u32::from_le_bytes);
    Chosen {
        triangles: draws(told, count).map(|draw| u64::from(draw[0] / 3)).sum(),
        error_px: pixels(threshold),
    }
}

/// Whether a model draws triangles.
pub(crate) fn has_faces(look: &ModelLook) -> bool {
    look.surface.is_some() || look.wireframe
}

/// A model as the choice takes it.
pub(crate) fn standing(placed: &PlacedModel) -> Standing {
    let look = &placed.look;
    let by_grain = look.wireframe || look.flat || placed.display.has_colours();
    Standing::new(placed.world_from_model, cut_of(look), by_grain, NEAR)
}

/// Whether either eye can see anything of a model.
pub(crate) fn is_seen(placed: &PlacedModel, views: &Views) -> bool {
    let Display { low, high, .. } = &*placed.display;
    let radius = low.distance(*high) * 0.5 * SLACK;
    standing(placed).is_seen(low.midpoint(*high).extend(radius), views)
}

/// Both eyes as the choice takes them; pictures are so many pixels wide, and `error_px` of these count as one.
pub(crate) fn views(eyes: &[Eye; 2], width_px: u32, error_px: f32) -> Views {
    let of = |eye: &Eye| {
        let [left, right, up, down] = eye.fov.tangents();
        let pose = eye.pose();
        let axis = |v: Vec3| pose.orientation * v;
        let ahead = axis(Vec3::new((left + right) / 2.0, (up + down) / 2.0, -1.0));
        let upright = |x: f32| {
            side(
                pose.position,
                axis(Vec3::new(x, 0.0, -1.0)),
                axis(Vec3::Y),
                ahead,
            )
        };
        let level = |y: f32| {
            side(
                pose.position,
                axis(Vec3::new(0.0, y, -1.0)),
                axis(Vec3::X),
                ahead,
            )
        };
        #[allow(clippy::cast_precision_loss, reason = "widths are small")]
        let pixels = width_px.max(1) as f32 / ((right - left) * error_px);
        (
            [upright(left), upright(right), level(up), level(down)],
            pose.position.extend(pixels),
        )
    };
    let [(left, left_eye), (right, right_eye)] = eyes.each_ref().map(of);
    Views {
        planes: [left, right],
        eyes: [left_eye, right_eye],
    }
}

/// The sun as the choice takes it: so far that all is equally near, and a texel of its map, in metres, is a pixel.
pub(crate) fn sun_views(sun: Vec3, sphere: Vec4, texel: f32) -> Views {
    let far = sphere.w.max(texel) * SUN;
    let eye = (sphere.truncate() + sun * far).extend(far / texel);
    Views {
        // Nothing is outside.
        planes: [[Vec4::W; 4]; 2],
        eyes: [eye; 2],
    }
}

/// The sun's distance in radii of what it shines on.
const SUN: f32 = 1000.0;
