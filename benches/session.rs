//! What our own part of a whole frame costs the loop's thread: `cargo bench --bench session`.
//!
//! The frame loop as a headset runs it: input to the world, edits, tree, scene, recording and handing over, at 75,024
//! segments (the last step of a self-similar sketch that still grows within a frame). Measured is the CPU time of the
//! loop's thread, so neither the driver's own threads (on the software device they do the drawing) nor other
//! programs count. The picture is 16 pixels wide.
#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark")]

use std::time::Duration;

use cpu_time::ThreadTime;
use criterion::{Criterion, criterion_group, criterion_main};
use glam::Vec3;
use ramus::app::picture::Picture;
use ramus::app::portrait;
use ramus::app::workshop::Workshop;
use ramus::sketch::{Letter, NodeRef};
use ramus::world::World;
use ramus::world::document::Edit;
use ramus::world::history::History;
use ramus_xr::Frame;

const STEP: u32 = 23;

fn workshop() -> Workshop {
    let mut history = History::default();
    for edit in [
        Edit::AddSegment {
            to: Vec3::new(0.0, 0.1, 0.0),
        },
        Edit::AddSegment {
            to: Vec3::new(0.0, 0.2, 0.0),
        },
        Edit::Select {
            at: NodeRef::new(Letter::TRUNK, 1),
        },
        Edit::AddSegment {
            to: Vec3::new(0.05, 0.15, 0.0),
        },
        Edit::SetStep { step: STEP },
    ] {
        history.apply(edit).unwrap();
    }
    Workshop::unsaved(World::new(history)).unwrap()
}

fn session(criterion: &mut Criterion) {
    let gpu = match portrait::open_gpu() {
        Ok(gpu) => gpu,
        Err(error) => {
            eprintln!("skipped: {error}");
            return;
        }
    };
    let mut workshop = workshop();
    let mut picture = Picture::offscreen(&gpu, 16, 16).unwrap();
    let mut frame = Frame::start();
    frame.focused = true;
    for hand in &mut frame.hands {
        hand.tracked = true;
    }
    let mut timed = |frame: &Frame| {
        gpu.wait_idle().unwrap();
        let start = ThreadTime::now();
        workshop.update(frame);
        picture.draw(workshop.scene(), &frame.views, None).unwrap();
        start.elapsed()
    };
    for _ in 0..20 {
        frame.time += 0.1;
        timed(&frame);
    }
    let mut group = criterion.benchmark_group("session");
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(5));
    group.bench_function("frame of 75,024 segments, hands moving", |bencher| {
        bencher.iter_custom(|rounds| {
            (0..rounds)
                .map(|round| {
                    frame.time += 0.011;
                    frame.hands[0].aim.position.x = if round % 2 == 0 { 0.3 } else { 0.31 };
                    timed(&frame)
                })
                .sum()
        });
    });
    group.bench_function("frame that steps back or forward", |bencher| {
        bencher.iter_custom(|rounds| {
            (0..rounds)
                .map(|round| {
                    for down in [false, true] {
                        frame.time += 0.011;
                        frame.hands[1].upper = down && round % 2 == 0;
                        frame.hands[1].lower = down && round % 2 == 1;
                        let spent = timed(&frame);
                        if down {
                            return spent;
                        }
                    }
                    Duration::ZERO
                })
                .sum()
        });
    });
    group.finish();
}

criterion_group!(benches, session);
criterion_main!(benches);
