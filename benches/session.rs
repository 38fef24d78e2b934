//! What our own part of a whole frame costs the process: `cargo bench --bench session`.
//!
//! The frame loop as a headset runs it: input to the world, edits, tree, scene, recording and handing over, with a tree of
//! 100,001 segments. Measured is the CPU time of all threads of the process but the driver's (on the software device
//! those do the drawing). The picture is 16 pixels wide.
#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark")]

#[path = "../tests/workshops/mod.rs"]
mod workshops;

use std::collections::HashSet;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::time::Duration;

use cpu_time::ThreadTime;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::{Quat, Vec2, Vec3};
use ramus::app::picture::Picture;
use ramus::app::portrait;
use ramus::app::workshop::Workshop;
use ramus::render::Gpu;
use ramus::world::panels::PanelId;
use ramus_xr::{Frame, Hand};
use workshops::tall;

/// How the threads of Mesa's software device begin their names, those of them that have one.
const DRIVER_THREADS: [&str; 3] = ["llvmpipe", "lvp", "vk"];

/// The threads of this process that began with the device: its queue's has no name of its own. They do what a graphics
/// card would do.
static OF_DEVICE: OnceLock<HashSet<OsString>> = OnceLock::new();

/// Where the system tells of our threads; nothing where it does not (it is Linux that does).
fn threads() -> impl Iterator<Item = PathBuf> {
    let threads = fs::read_dir("/proc/self/task").into_iter().flatten();
    threads.filter_map(|thread| Some(thread.ok()?.path()))
}

/// CPU time of the other threads that are ours: the worker's and those of parallel loops.
fn other_threads() -> Duration {
    let own = fs::read_link("/proc/thread-self").unwrap_or_default();
    let of_device = |number: &OsStr| OF_DEVICE.get().is_some_and(|all| all.contains(number));
    let of_thread = |folder: PathBuf| {
        let number = folder.file_name()?;
        let name = fs::read_to_string(folder.join("comm")).ok()?;
        let is_driver = DRIVER_THREADS.iter().any(|start| name.starts_with(start));
        if is_driver || of_device(number) || own.file_name() == Some(number) {
            return None;
        }
        let spent = fs::read_to_string(folder.join("schedstat")).ok()?;
        let nanoseconds = spent.split_whitespace().next()?.parse().ok()?;
        Some(Duration::from_nanos(nanoseconds))
    };
    threads().filter_map(of_thread).sum()
}

/// A workshop with its picture, and the frame it is at.
struct Loop<'a> {
    gpu: &'a Gpu,
    workshop: Workshop,
    picture: Picture,
    frame: Frame,
    /// Turns over with each measurement: there, then back again.
    turn: bool,
}

impl<'a> Loop<'a> {
    fn new(gpu: &'a Gpu, mut workshop: Workshop) -> Self {
        let mut frame = Frame::start();
        frame.focused = true;
        for hand in &mut frame.hands {
            hand.tracked = true;
        }
        workshop.update(&frame);
        workshop.finish_tree();
        let mut warm = Self {
            gpu,
            workshop,
            picture: Picture::offscreen(gpu, 16, 16).unwrap(),
            frame,
            turn: false,
        };
        for _ in 0..20 {
            warm.next(0.1);
        }
        warm
    }

    /// Goes through one frame; gives the process' own time.
    fn next(&mut self, seconds: f64) -> Duration {
        self.frame.time += seconds;
        self.gpu.wait_idle().unwrap();
        let (others, start) = (other_threads(), ThreadTime::now());
        self.workshop.update(&self.frame);
        for (slot, painted) in self.workshop.take_painted() {
            self.picture.paint(slot, painted).unwrap();
        }
        let scene = self.workshop.scene();
        self.picture.draw(scene, &self.frame.views, None).unwrap();
        let own = start.elapsed();
        own + other_threads().saturating_sub(others)
    }

    /// Where a place of the bench is (metres right of and below its upper left corner).
    fn on_bench(&mut self, at: Vec2) -> Vec3 {
        let panels = &self.workshop.scene().panels;
        let slot = PanelId::Bench.slot();
        let bench = panels.iter().find(|panel| panel.slot == slot).unwrap();
        let from_middle = at - Vec2::from(bench.size) * 0.5;
        let at = Vec3::new(from_middle.x, -from_middle.y, 0.0);
        bench.world_from_panel.transform_point3(at)
    }

    /// Points the right hand at a place of the bench, from before it.
    fn point(&mut self, at: Vec2) {
        let to = self.on_bench(at);
        let from = Vec3::new(-0.55, 1.2, -0.25);
        let hand = &mut self.frame.hands[1];
        hand.aim.position = from;
        hand.aim.orientation = Quat::from_rotation_arc(Vec3::NEG_Z, (to - from).normalize());
    }

    /// A loop whose right hand has the bench's slider of speed, and the slider's place.
    fn with_slider(mut self) -> (Self, Vec2) {
        /// How far a slider is below the middle of its name, metres.
        const BELOW: f32 = 0.04;
        self.workshop.keep_texts();
        self.next(0.011);
        let name = self.workshop.find_text(PanelId::Bench, "speed", 1).unwrap();
        let slider = Vec2::new(0.1, name.y + BELOW);
        self.point(slider);
        self.next(0.011);
        self.frame.hands[1].trigger = 1.0;
        self.next(0.011);
        let before = self.workshop.world().speed();
        self.point(slider + Vec2::X * 0.1);
        self.next(0.011);
        self.next(0.011);
        assert_ne!(self.workshop.world().speed(), before, "it is dragged");
        (self, slider)
    }

    /// The frame in which the right hand does something, after one in which it does nothing.
    fn act(&mut self, act: impl FnOnce(&mut Hand)) -> Duration {
        self.next(0.011);
        let resting = self.frame.hands[1];
        act(&mut self.frame.hands[1]);
        let spent = self.next(0.011);
        self.frame.hands[1] = resting;
        spent
    }

    fn segments(&mut self) -> usize {
        let tree = &self.workshop.scene().tree;
        tree.as_ref()
            .map_or(0, |placed| placed.tree.segment_count())
    }
}

fn session(criterion: &mut Criterion) {
    let gpu = match portrait::open_gpu() {
        Ok(gpu) => gpu,
        Err(error) => {
            eprintln!("skipped: {error}");
            return;
        }
    };
    let main = fs::read_link("/proc/thread-self").unwrap_or_default();
    let numbers = threads().filter_map(|folder| Some(folder.file_name()?.to_owned()));
    let of_device = numbers.filter(|number| main.file_name() != Some(number));
    OF_DEVICE.set(of_device.collect()).unwrap();
    let mut group = criterion.benchmark_group("session");
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(5));

    let mut measure =
        |what: &str, mut frames: Loop<'_>, spent: &dyn Fn(&mut Loop<'_>, bool) -> Duration| {
            let id = BenchmarkId::new(what, frames.segments());
            group.bench_function(id, |bencher| {
                bencher.iter_custom(|rounds| {
                    let mut round = |_| {
                        frames.turn = !frames.turn;
                        let turn = frames.turn;
                        spent(&mut frames, turn)
                    };
                    (0..rounds).map(&mut round).sum()
                });
            });
        };
    measure(
        "hands moving",
        Loop::new(&gpu, tall(4, 401)),
        &|frames, left| {
            frames.frame.hands[0].aim.position.x = if left { 0.3 } else { 0.31 };
            frames.next(0.011)
        },
    );
    measure(
        "a pointer moving on the bench",
        Loop::new(&gpu, tall(4, 401)),
        &|frames, left| {
            // Across its parts.
            frames.point(Vec2::new(0.2, if left { 0.2 } else { 0.25 }));
            frames.next(0.011)
        },
    );
    let (dragging, slider) = Loop::new(&gpu, tall(4, 401)).with_slider();
    measure(
        "a slider dragged on the bench",
        dragging,
        &|frames, left| {
            frames.point(slider + Vec2::X * if left { 0.05 } else { 0.1 });
            frames.next(0.011)
        },
    );
    measure(
        "a step back or forward",
        Loop::new(&gpu, tall(2, 366)),
        &|frames, back| frames.act(|hand| (hand.upper, hand.lower) = (back, !back)),
    );
    measure(
        "a branch undone or redone",
        Loop::new(&gpu, tall(2, 366)),
        &|frames, back| frames.act(|hand| hand.stick.x = if back { -1.0 } else { 1.0 }),
    );
    group.finish();
}

criterion_group!(benches, session);
criterion_main!(benches);
