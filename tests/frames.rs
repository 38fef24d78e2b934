//! The frame loop: an edit shows in the next frame, large trees never hold it up, and once warm it
//! allocates nothing and makes no pipeline.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

mod counting;
mod workshops;

use std::time::Duration;

use counting::allocations;
use glam::Vec3;
use ramus::app::picture::Picture;
use ramus::app::portrait;
use ramus::app::session::{self, Nobody, Watcher};
use ramus::app::workshop::Workshop;
use ramus::render::Gpu;
use ramus_xr::simulated::Simulated;
use ramus_xr::{Frame, Headset, HeadsetError};
use workshops::{bushy, tall};

fn segments(workshop: &mut Workshop) -> usize {
    workshop
        .scene()
        .tree
        .as_ref()
        .map_or(0, |placed| placed.tree.segment_count())
}

/// Shows the right hand at rest for a frame, then presses its lower button.
fn press(workshop: &mut Workshop, mut frame: Frame) {
    frame.focused = true;
    frame.hands[1].tracked = true;
    workshop.update(&frame);
    frame.hands[1].lower = true;
    workshop.update(&frame);
}

#[test]
fn an_edit_of_75000_segments_shows_in_the_same_frame() {
    let mut workshop = bushy(22);
    let mut frame = Frame::start();
    workshop.update(&frame);
    assert_eq!(segments(&mut workshop), 46_367);
    frame.time += 0.011;
    press(&mut workshop, frame);
    // The step shrinks or grows on the eye; the tree itself is there at once.
    assert_eq!(workshop.document().step, 23);
    assert_eq!(segments(&mut workshop), 75_024);
    assert!(!workshop.is_busy());
}

/// The string of such a tree took hundreds of rewrites; an edit of its rules derives it from the axiom.
#[test]
fn an_edit_of_a_tall_tree_shows_in_the_same_frame() {
    let mut workshop = tall(2, 366);
    let mut frame = Frame::start();
    workshop.update(&frame);
    let with_both = segments(&mut workshop);
    assert_eq!(with_both, 99_920);
    for (stick, expected) in [(-1.0, 66_796), (1.0, with_both)] {
        frame.time += 0.1;
        frame.focused = true;
        frame.hands[1].tracked = true;
        frame.hands[1].stick.x = 0.0;
        workshop.update(&frame);
        frame.hands[1].stick.x = stick;
        workshop.update(&frame);
        assert_eq!(segments(&mut workshop), expected, "undone, then redone");
        assert!(!workshop.is_busy());
    }
}

#[test]
fn a_larger_tree_grows_on_the_worker_while_frames_go_on() {
    let mut workshop = bushy(23);
    let mut frame = Frame::start();
    workshop.update(&frame);
    assert_eq!(segments(&mut workshop), 75_024);
    press(&mut workshop, frame);
    assert_eq!(workshop.document().step, 24);
    assert!(
        workshop.is_busy(),
        "121,392 segments are beyond what grows within a frame"
    );
    assert_eq!(
        segments(&mut workshop),
        75_024,
        "the old tree stays in view"
    );
    let mut frames = 0;
    while segments(&mut workshop) != 121_392 {
        frame.time += 0.001;
        workshop.update(&frame);
        frames += 1;
    }
    assert!(frames > 1, "the loop went on meanwhile");
    assert!(!workshop.is_busy());
}

/// A runtime that blocks in `xrEndFrame` until the display has shown the frame, as some do.
struct Blocking {
    inner: Simulated,
}

impl Headset for Blocking {
    ramus_xr::forward_headset!(inner: describe, extent, swapchain, wait, begin, views, vibrate, device, request_exit);

    fn end(&mut self, rendered: bool) -> Result<(), HeadsetError> {
        std::thread::sleep(Duration::from_millis(200));
        self.inner.end(rendered)
    }
}

/// While the loop stands in the end of a frame, what is large goes on growing, and is there a few frames later.
#[test]
fn a_runtime_that_blocks_at_the_end_of_frames_holds_up_no_growing_tree() {
    const FRAMES: usize = 20;
    let mut workshop = bushy(23);
    let mut frame = Frame::start();
    frame.hands[1].tracked = true;
    let frames: Vec<Frame> = (0..FRAMES)
        .map(|at| {
            frame.time += 0.011;
            frame.hands[1].lower = at == 1;
            frame
        })
        .collect();
    let extent = ash::vk::Extent2D {
        width: 8,
        height: 8,
    };
    let mut headset = Blocking {
        inner: Simulated::new(frames, extent),
    };
    session::run(&mut headset, &mut workshop, None, &mut Nobody).unwrap();
    assert_eq!(workshop.document().step, 24);
    assert_eq!(segments(&mut workshop), 121_392);
    assert_eq!(headset.inner.waited(), FRAMES);
}

/// Notes the allocations and the pipelines made so far after each frame.
struct Meter<'a> {
    gpu: &'a Gpu,
    counts: Vec<(u64, u64)>,
}

impl Watcher for Meter<'_> {
    fn ended(&mut self, _headset: &mut dyn Headset) {
        // Has its room from the start: noting allocates nothing.
        self.counts.push((allocations(), self.gpu.pipelines_made()));
    }
}

#[test]
fn the_whole_warm_loop_allocates_nothing_and_makes_no_pipeline() {
    let gpu = match portrait::open_gpu() {
        Ok(gpu) => gpu,
        Err(error) => {
            assert!(
                std::env::var("CI").is_err(),
                "CI needs a Vulkan device: {error}"
            );
            println!("skipped: {error}");
            return;
        }
    };
    const WARM: usize = 120;
    const FRAMES: usize = 200;
    let mut workshop = bushy(12);
    let mut picture = Picture::offscreen(&gpu, 64, 64).unwrap();
    let mut frame = Frame::start();
    let frames: Vec<Frame> = (0..FRAMES)
        .map(|_| {
            frame.time += 0.011;
            frame.focused = true;
            for hand in &mut frame.hands {
                hand.tracked = true;
                hand.aim.position += Vec3::new(0.0005, 0.0002, -0.0003);
                hand.grip.position = hand.aim.position;
            }
            frame
        })
        .collect();
    let mut headset = Simulated::new(
        frames,
        ash::vk::Extent2D {
            width: 64,
            height: 64,
        },
    );
    let mut meter = Meter {
        gpu: &gpu,
        counts: Vec::with_capacity(FRAMES),
    };
    session::run(&mut headset, &mut workshop, Some(&mut picture), &mut meter).unwrap();
    assert_eq!(headset.rendered(), FRAMES);
    let warm = &meter.counts[WARM..];
    let last = warm.last().unwrap();
    assert_eq!(
        (last.0 - warm[0].0, last.1 - warm[0].1),
        (0, 0),
        "allocations and pipelines in {} warm frames",
        warm.len() - 1
    );
    assert!(last.1 > 0, "the pipelines of the start were counted");
}
