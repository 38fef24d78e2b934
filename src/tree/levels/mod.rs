//! Levels of detail of a tree as it is drawn: clusters of tube segments, or of leaves, halved and halved again until one is left.
//!
//! ```text
//! finest     ▣ ▣ ▣ ▣ ▣ ▣ ▣ ▣     64 records each, neighbours along the axes
//!             ╲╱  ╲╱  ╲╱  ╲╱
//! coarser      ▣   ▣   ▣   ▣      of two neighbours' 128 records the 64 that miss least
//!               ╲ ╱     ╲ ╱
//! ...            ▣       ▣
//!                 ╲     ╱
//! coarsest            ▣           the whole tree in 64 records
//! ```
//!
//! Where pairs begin depends on what stands there and not on how many came before (`runs`), so an edit leaves most clusters as they were.
//!
//! Each cluster has one parent, so a cut through this tree of clusters shows every part of the plant once: a cluster is drawn where its own error is
//! small enough on the screen and its parent's is not ([`cut`]). A mesh needs more than that ([`crate::mesh::levels`](../../mesh/levels/index.html)),
//! since its levels must agree along their borders. Tubes need not: whatever a level leaves out, the rings at both ends of what it keeps stay where they
//! are, so pieces of all levels meet in the same rings.
//!
//! What a step towards the coarse does is said by [`Record`]: of tubes, neighbours along an axis become one, and thin ones go while others grow wider
//! ([`branches`]); of leaves, every second one goes while others grow larger ([`leaves`]). Errors grow from level to level and spheres hold those below.
//!
//! Sources: Karis, Stubbe and Wihlidal 2021, "A Deep Dive into Nanite Virtualized Geometry" (the question that a cluster is asked); Cook, Halstead, Planck
//! and Ryu 2007, "Stochastic Simplification of Aggregate Detail" (fewer and larger).

pub mod branches;
pub mod cut;
pub mod kinds;
pub mod leaves;
mod order;
mod runs;
#[cfg(test)]
mod tests;

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::cells::Cells;

pub use self::leaves::{Leaf, LeafLevels};
pub use self::order::along_axes;
use self::runs::stirred;

/// Records of a cluster at most.
pub const MOST: usize = 64;
/// Records that are drawn by one instance; a cluster has whole ones of them.
pub const BATCH: usize = 8;
/// So many records have one level: to draw them whole costs less than to choose.
const SMALL: usize = 512;
/// Up to so many records are worked on by the thread that asks: a frame may wait for them, and must not wait for what other threads have taken on.
const ALONE: usize = 1 << 17;

/// A record that clusters are made of: a segment or a leaf.
pub trait Record: Pod + Default + Send + Sync {
    /// The corners of a box around it, at any growth.
    fn corners(&self) -> [Vec3; 2];

    /// What its number of triangles depends on: how wide a tube is or how long a leaf, metres.
    fn size(&self) -> f32;

    /// Whether it has an end that is drawn by itself; a cluster's first records are those that have.
    fn ends(&self) -> bool;

    /// Where it stands, as a number: different for most.
    fn mark(&self) -> u64;

    /// What is noted of a record of the finest level: what [`Self::halve`] needs to know of it, level by level.
    const NOTE: f32;

    /// Leaves at most `most` of a run of neighbours, and says what is off by that, metres. Each has its note.
    fn halve(run: &mut Vec<(Self, f32)>, most: usize) -> f32;
}

/// Records that are drawn together or not at all: `Cluster` of shaders/crown.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Cluster {
    /// A sphere around its records: middle and radius, in the tree's frame.
    pub sphere: Vec4,
    /// The sphere that its own error counts from.
    pub own: Vec4,
    /// The sphere that its parent's error counts from; holds `own`.
    pub parent: Vec4,
    /// How far what it shows is from the tree, metres; 0 where it is the tree.
    pub own_error: f32,
    /// The error of what replaces it; −1: nothing does.
    pub parent_error: f32,
    /// The largest [`Record::size`] of its records.
    pub size: f32,
    /// Nothing: shaders read 16 bytes at a time.
    pub pad: u32,
    /// Its first batch of [`BATCH`] records.
    pub first: u32,
    /// How many batches it has.
    pub batches: u32,
    /// In how many of these, from the first one on, something [`Record::ends`].
    pub ends: u32,
    /// Nothing.
    pub pad_end: u32,
}

const _: () = assert!(
    size_of::<Cluster>() == 80,
    "shaders/crown.wgsl reads 80 bytes"
);

impl Cluster {
    /// The bins of its own error and of its parent's as the eyes see them; none where neither does.
    #[must_use]
    pub fn bins(&self, standing: &cut::Standing, views: &cut::Views) -> Option<[u32; 2]> {
        let parent = (self.parent_error >= 0.0).then_some((self.parent, self.parent_error));
        standing.bins(self.sphere, (self.own, self.own_error), parent, views)
    }
}

/// Records in all levels of detail.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels<R: Record> {
    /// Of all levels, cluster by cluster, each one's last filled up with records of no size.
    pub batches: Cells<[R; BATCH]>,
    /// Clusters, finest level first.
    pub clusters: Vec<Cluster>,
    /// So many of these are the tree itself.
    pub finest: usize,
}

impl<R: Record> Default for Levels<R> {
    fn default() -> Self {
        Self {
            batches: Cells::default(),
            clusters: Vec::new(),
            finest: 0,
        }
    }
}

/// A cluster of the level that is being built.
struct Made<R> {
    /// In the order of neighbours, each with its note.
    run: Vec<(R, f32)>,
    /// The numbers of its records in the order in which they are drawn: first those that have ends.
    drawn: Vec<u16>,
    /// How many of these have.
    ends: usize,
    /// A sphere around what it shows,
    sphere: Vec4,
    /// and one around all that it stands for.
    own: Vec4,
    /// The largest [`Record::size`].
    size: f32,
    error: f32,
    /// Where it stands among all clusters.
    number: usize,
}

impl<R: Record> Levels<R> {
    /// Builds all levels of records that lie beside their neighbours. The same for any number of threads.
    #[must_use]
    pub fn new(records: &[R]) -> Self {
        Self::of(records.len(), |at| {
            records.get(at).copied().unwrap_or_default()
        })
    }

    /// The same of so many records, each by its place in the order of neighbours.
    #[must_use]
    pub fn of(count: usize, record: impl Fn(usize) -> R + Sync) -> Self {
        let mut levels = Self::with_room(count, if count > SMALL { 2 } else { 1 });
        let (mut level, mut runs) = levels.begin(count, record);
        for round in 1.. {
            if level.len() <= 1 || count <= SMALL {
                break;
            }
            let pairs_of = pairs(&level, &runs);
            let pair = |at: usize| Made::of(pairs_of.get(at).copied().unwrap_or_default());
            let mut next = made(pairs_of.len(), count, pair);
            levels.add(&mut next);
            for (made, pair) in next.iter().zip(pairs_of) {
                levels.replace(pair, made);
            }
            level = next;
            if round % runs::ROUNDS == 0 {
                let mark = |at: usize| level.get(at).map_or(0, Made::mark);
                runs = runs::lengths(level.len(), 1, |at| stirred(mark(at), round));
            } else {
                runs.iter_mut().for_each(|run| *run = (*run / 2).max(1));
            }
        }
        levels.batches.truncate(levels.used());
        levels
    }

    /// The tree itself in clusters, and nothing coarser: a fourth of the time. As [`Self::of`].
    #[must_use]
    pub fn finest(count: usize, record: impl Fn(usize) -> R + Sync) -> Self {
        let mut levels = Self::with_room(count, 1);
        levels.begin(count, record);
        levels.batches.truncate(levels.used());
        levels
    }

    fn with_room(count: usize, times: usize) -> Self {
        // Each run's last cluster may be small.
        let clusters = times * count.div_ceil(MOST) * 9 / 8 + 1;
        Self {
            batches: room(clusters * (MOST / BATCH)),
            clusters: Vec::with_capacity(clusters),
            finest: 0,
        }
    }

    /// Adds the finest level, and returns it, with how many clusters each run has.
    fn begin(
        &mut self,
        count: usize,
        record: impl Fn(usize) -> R + Sync,
    ) -> (Vec<Made<R>>, Vec<usize>) {
        let mark = |at: usize| stirred(record(at).mark(), 0);
        let mut runs = runs::lengths(count, MOST, mark);
        let mut clusters = Vec::with_capacity(count.div_ceil(MOST) * 9 / 8 + 1);
        let mut first = 0;
        for run in &mut runs {
            let end = first + *run;
            clusters.extend((first..end).step_by(MOST).map(|at| at..end.min(at + MOST)));
            (first, *run) = (end, run.div_ceil(MOST));
        }
        let finest = |cluster: usize| {
            let range = clusters.get(cluster).cloned().unwrap_or_default();
            Made::finest(range.map(&record))
        };
        let mut level = made(clusters.len(), count, finest);
        self.add(&mut level);
        self.finest = self.clusters.len();
        (level, runs)
    }

    /// The records of clusters that follow each other.
    #[must_use]
    pub fn records_of(&self, clusters: &[Cluster]) -> &[R] {
        let first = clusters.first().map_or(0, |cluster| cluster.first);
        let end = clusters
            .last()
            .map_or(0, |cluster| cluster.first + cluster.batches);
        let own = self.batches.get(first as usize..end as usize);
        own.unwrap_or_default().as_flattened()
    }

    /// The same as the device has them.
    #[must_use]
    pub fn bytes_of(&self, clusters: &[Cluster]) -> &[u8] {
        bytemuck::cast_slice(self.records_of(clusters))
    }

    /// Batches of the clusters that were added.
    fn used(&self) -> usize {
        let last = self.clusters.last();
        last.map_or(0, |last| (last.first + last.batches) as usize)
    }

    /// Adds a level's clusters.
    fn add(&mut self, level: &mut [Made<R>]) {
        let used = self.used();
        // Which cluster each batch is of, and which of that one's it is.
        let mut places = Vec::with_capacity(level.len() * (MOST / BATCH));
        for (at, made) in level.iter_mut().enumerate() {
            made.number = self.clusters.len();
            self.clusters.push(made.cluster(used + places.len()));
            places.extend((0..made.run.len().div_ceil(BATCH)).map(|batch| (at, batch)));
        }
        let end = used + places.len();
        if self.batches.len() < end {
            let mut larger = room(2 * end);
            larger[..used].copy_from_slice(&self.batches[..used]);
            self.batches = larger;
        }
        let level = &*level;
        let write = |(into, place): (&mut [R; BATCH], &(usize, usize))| {
            *into = level[place.0].batch(place.1);
        };
        let into = &mut self.batches[used..end];
        if into.len() * BATCH > ALONE {
            // Memory that is touched for the first time takes longer than what is written there.
            into.par_iter_mut().zip(&places).for_each(write);
        } else {
            into.iter_mut().zip(&places).for_each(write);
        }
    }

    /// Tells clusters what replaces them.
    fn replace(&mut self, children: &[Made<R>], parent: &Made<R>) {
        for child in children {
            if let Some(cluster) = self.clusters.get_mut(child.number) {
                cluster.parent = parent.own;
                cluster.parent_error = parent.error;
            }
        }
    }
}

/// So many batches that will be written. Memory that is not there ends the program, as with a vector.
fn room<R: Record>(batches: usize) -> Cells<[R; BATCH]> {
    let cells = Cells::unwritten(batches);
    cells.unwrap_or_else(|| vec![[R::default(); BATCH]; batches].into())
}

/// So many clusters, of a tree of so many records.
fn made<R: Record>(
    clusters: usize,
    records: usize,
    make: impl Fn(usize) -> Made<R> + Send + Sync,
) -> Vec<Made<R>> {
    if records > ALONE {
        (0..clusters).into_par_iter().map(make).collect()
    } else {
        (0..clusters).map(make).collect()
    }
}

/// Neighbours in runs of such lengths that become one: two each, of an odd number the last three.
fn pairs<'a, R>(level: &'a [Made<R>], runs: &[usize]) -> Vec<&'a [Made<R>]> {
    let mut pairs = Vec::with_capacity(level.len() / 2 + 1);
    let mut rest = level;
    for length in runs {
        let (mut run, after) = rest.split_at((*length).min(rest.len()));
        while !run.is_empty() {
            let pair;
            (pair, run) = run.split_at(if run.len() > 3 { 2 } else { run.len() });
            pairs.push(pair);
        }
        rest = after;
    }
    pairs
}

impl<R: Record> Made<R> {
    fn finest(records: impl Iterator<Item = R>) -> Self {
        let run = records.map(|record| (record, R::NOTE)).collect();
        Self::new(run, &[], 0.0)
    }

    /// What is drawn of a run that stands for what these spheres are around.
    fn new(run: Vec<(R, f32)>, spheres: &[Vec4], error: f32) -> Self {
        let sphere = sphere(hull(&run));
        let order = (0_u16..).zip(&run);
        let ends = |ends: bool| {
            let own = order
                .clone()
                .filter(move |(_, (record, _))| record.ends() == ends);
            own.map(|(number, _)| number)
        };
        let mut drawn = Vec::with_capacity(run.len());
        drawn.extend(ends(true));
        let count = drawn.len();
        drawn.extend(ends(false));
        let sizes = run.iter().map(|(record, _)| record.size());
        Self {
            own: spheres.iter().copied().fold(sphere, both),
            size: sizes.fold(0.0, f32::max),
            sphere,
            run,
            drawn,
            ends: count,
            error,
            number: 0,
        }
    }

    /// Where it begins, as a number.
    fn mark(&self) -> u64 {
        self.run.first().map_or(0, |(record, _)| record.mark())
    }

    /// What stands for these.
    fn of(children: &[Self]) -> Self {
        let mut run = Vec::with_capacity(children.len() * MOST);
        let mut error = 0.0_f32;
        for child in children {
            run.extend_from_slice(&child.run);
            error = error.max(child.error);
        }
        error = error.max(R::halve(&mut run, MOST));
        let spheres: Vec<Vec4> = children.iter().map(|child| child.own).collect();
        Self::new(run, &spheres, error)
    }

    /// As it is drawn, with its first batch's number.
    fn cluster(&self, first: usize) -> Cluster {
        let whole = |records: usize| number(records.div_ceil(BATCH));
        Cluster {
            sphere: self.sphere,
            own: self.own,
            own_error: self.error,
            parent_error: -1.0,
            size: self.size,
            first: number(first),
            batches: whole(self.run.len()),
            ends: whole(self.ends),
            ..Cluster::default()
        }
    }

    /// The records of one of its batches.
    fn batch(&self, batch: usize) -> [R; BATCH] {
        let mut records = [R::default(); BATCH];
        let own = self.drawn.iter().skip(batch * BATCH);
        for (record, at) in records.iter_mut().zip(own) {
            *record = self
                .run
                .get(usize::from(*at))
                .map_or(*record, |(own, _)| *own);
        }
        records
    }
}

fn number(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// A place as a number, different for most.
fn mark(place: [f32; 3]) -> u64 {
    let bits = place.map(f32::to_bits).into_iter().map(u64::from);
    bits.fold(0, |mark, bits| {
        mark.rotate_left(21) ^ bits.wrapping_mul(0x9e37_79b9_7f4a_7c15)
    })
}

const NOWHERE: [Vec3; 2] = [Vec3::INFINITY, Vec3::NEG_INFINITY];

fn around([low, high]: [Vec3; 2], [other_low, other_high]: [Vec3; 2]) -> [Vec3; 2] {
    [low.min(other_low), high.max(other_high)]
}

fn hull<R: Record>(run: &[(R, f32)]) -> [Vec3; 2] {
    let boxes = run.iter().map(|(record, _)| record.corners());
    boxes.fold(NOWHERE, around)
}

/// A sphere around a box, with room for rounding; of what is nowhere a point.
fn sphere([low, high]: [Vec3; 2]) -> Vec4 {
    if !low.cmple(high).all() {
        return Vec4::ZERO;
    }
    let middle = (low + high) / 2.0;
    middle.extend(low.distance(high) / 2.0 * 1.000_01)
}

/// The smallest sphere around two, with room for rounding.
fn both(one: Vec4, other: Vec4) -> Vec4 {
    let [from, to] = [one.truncate(), other.truncate()];
    let apart = from.distance(to);
    if apart + other.w <= one.w {
        return one;
    }
    if apart + one.w <= other.w {
        return other;
    }
    let radius = (apart + one.w + other.w) / 2.0;
    let middle = from + (to - from) * ((radius - one.w) / apart);
    middle.extend(radius * 1.000_01)
}
