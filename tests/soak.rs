//! A long session of random but plausible hands on the simulated headset, at full speed.
//!
//! `make soak` plays an hour of it (324,000 frames at 90 a second); `make test` a minute. Nothing panics, memory grows by no more than the
//! edits that can be undone, and undoing them all gives back the very document that was there.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that fails shows the line"
)]

use ash::vk::Extent2D;
use glam::{Quat, Vec2, Vec3};
use ramus::app::session::{self, Nobody, Watcher};
use ramus::app::workshop::Workshop;
use ramus::world::World;
use ramus::world::document::Document;
use ramus::world::history::History;
use ramus_xr::simulated::Simulated;
use ramus_xr::{Frame, Hand, Headset, Pose};

/// Frames of the short session.
const SHORT: usize = 5_400;

/// Bytes by which the session may grow for each edit that can be undone (a stroke with its points, at most some hundred of
/// them), and once for all: strings, trees and fonts that are kept.
const BYTES_PER_EDIT: u64 = 8 << 10;
const BYTES_KEPT: u64 = 400 << 20;

/// SplitMix64 (Steele, Lea and Flood 2014): the same session each time.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below one that is small.
    fn below(&mut self, most: u32) -> u32 {
        u32::try_from(self.roll() % u64::from(most)).unwrap()
    }

    /// 0 to 1.
    fn part(&mut self) -> f32 {
        (self.below(10_001) as f32) / 10_000.0
    }

    fn near(&mut self, at: Vec3, spread: f32) -> Vec3 {
        let mut aside = || (self.part() * 2.0 - 1.0) * spread;
        at + Vec3::new(aside(), aside(), aside())
    }
}

/// What a hand is about to do.
#[derive(Clone, Copy)]
struct Plan {
    from: Vec3,
    to: Vec3,
    /// Where it points when it is there.
    looks: Vec3,
    frames: u32,
    done: u32,
    /// What is pressed on the way, and at the end.
    trigger: [bool; 2],
    squeeze: [bool; 2],
    lower: bool,
    upper: bool,
    stick: Vec2,
    tracked: bool,
}

const PLATFORM: Vec3 = Vec3::new(0.0, 0.95, -0.55);
const BENCH: Vec3 = Vec3::new(-0.72, 1.05, -0.52);

fn plan(dice: &mut Dice, from: Vec3) -> Plan {
    let mut plan = Plan {
        from,
        to: dice.near(PLATFORM + Vec3::Y * 0.12, 0.16),
        looks: Vec3::NEG_Z,
        frames: 4 + dice.below(30),
        done: 0,
        trigger: [false; 2],
        squeeze: [false; 2],
        lower: false,
        upper: false,
        stick: Vec2::ZERO,
        tracked: true,
    };
    match dice.below(24) {
        // Draws a piece, or a free-hand stroke on the way.
        0..=5 => plan.trigger = [false, true],
        6..=7 => plan.trigger = [true, true],
        // Takes something and brings it somewhere, perhaps deleting it.
        8..=10 => plan.squeeze = [true, dice.below(2) == 0],
        11 => (plan.squeeze, plan.trigger) = ([true; 2], [false, true]),
        12 => plan.lower = true,
        13 => plan.upper = true,
        14..=15 => plan.stick.x = if dice.below(3) == 0 { 1.0 } else { -1.0 },
        // At the bench, with its tabs, sliders and buttons, or scrolling there.
        16..=19 => {
            let at = dice.near(BENCH, 0.28);
            plan.to = BENCH + Vec3::new(0.5, 0.2, 0.4);
            plan.looks = (at - plan.to).normalize();
            plan.trigger = [dice.below(3) == 0, true];
            plan.stick.y = if dice.below(4) == 0 {
                dice.part() * 2.0 - 1.0
            } else {
                0.0
            };
        }
        // At the lever, the wheel or the stump.
        20..=22 => {
            let x = f32::from(i8::try_from(dice.below(3)).unwrap() - 1) * 0.24;
            plan.to = dice.near(Vec3::new(x, 0.86, -0.25), 0.06);
            plan.squeeze = [dice.below(2) == 0, true];
            plan.trigger = [false, dice.below(2) == 0];
        }
        _ => plan.tracked = false,
    }
    plan
}

impl Plan {
    /// The hand in the next frame; none when the plan is over.
    fn next(&mut self) -> Option<Hand> {
        if self.done == self.frames {
            return None;
        }
        self.done += 1;
        let part = self.done as f32 / self.frames as f32;
        let phase = usize::from(part > 0.5);
        let on = |pressed: [bool; 2]| if pressed[phase] { 1.0 } else { 0.0 };
        let aim = Pose {
            orientation: Quat::from_rotation_arc(Vec3::NEG_Z, self.looks),
            position: self.from.lerp(self.to, part) - self.looks * 0.06,
        };
        let last = self.done == self.frames;
        Some(Hand {
            tracked: self.tracked,
            aim,
            grip: aim,
            trigger: if last { 0.0 } else { on(self.trigger) },
            squeeze: if last { 0.0 } else { on(self.squeeze) },
            stick: if last { Vec2::ZERO } else { self.stick },
            lower: self.lower && phase == 0,
            upper: self.upper && phase == 0,
        })
    }
}

/// So many frames of somebody's hands.
fn session(frames: usize, seed: u64) -> impl Iterator<Item = Frame> {
    let mut dice = Dice(seed);
    let mut plans = [PLATFORM; 2].map(|from| plan(&mut dice, from));
    (0..frames).map(move |number| {
        let mut frame = Frame::start();
        frame.time = number as f64 / 90.0;
        // Now and then another application has the input.
        frame.focused = dice.below(2_000) != 0;
        for (hand, going) in frame.hands.iter_mut().zip(&mut plans) {
            *hand = loop {
                if let Some(next) = going.next() {
                    break next;
                }
                *going = plan(&mut dice, going.to);
            };
        }
        frame
    })
}

/// Resident memory of this process, bytes.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/statm").unwrap();
    status.split(' ').nth(1).unwrap().parse::<u64>().unwrap() * 4096
}

/// Looks at memory now and then.
struct Looks {
    frames: usize,
    first: u64,
    most: u64,
}

impl Watcher for Looks {
    fn ended(&mut self, _headset: &mut dyn Headset) {
        self.frames += 1;
        if self.frames == 1_000 {
            self.first = resident();
        }
        if self.frames.is_multiple_of(1_000) {
            self.most = self.most.max(resident());
        }
    }
}

#[test]
fn hours_of_hands_break_nothing() {
    let asked = std::env::var("RAMUS_SOAK_FRAMES").ok();
    let frames = asked.map_or(SHORT, |frames| frames.parse().unwrap());
    let mut headset = Simulated::new(
        session(frames, 7),
        Extent2D {
            width: 64,
            height: 64,
        },
    );
    let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
    let mut looks = Looks {
        frames: 0,
        first: 0,
        most: 0,
    };
    session::run(&mut headset, &mut workshop, None, &mut looks).unwrap();
    workshop.finish_tree();
    assert_eq!(looks.frames, frames);
    let edits = workshop.edits();
    let grown = looks.most.saturating_sub(looks.first);
    eprintln!(
        "{frames} frames, {edits} edits, resident {} MiB after 1,000 frames, at most {} MiB",
        looks.first >> 20,
        looks.most >> 20
    );
    assert!(edits > frames as u64 / 200, "hands did something: {edits}");
    assert!(
        grown <= BYTES_KEPT + edits * BYTES_PER_EDIT,
        "grew by {grown} bytes"
    );

    let mut world = workshop.close().unwrap();
    world.document().validate().unwrap();
    while world.undo() {}
    assert_eq!(
        *world.document(),
        Document::default(),
        "undone to the start"
    );
}

#[test]
fn the_same_hands_make_the_same_document() {
    let made = || {
        let mut headset = Simulated::new(
            session(1_500, 3),
            Extent2D {
                width: 64,
                height: 64,
            },
        );
        let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
        session::run(&mut headset, &mut workshop, None, &mut Nobody).unwrap();
        workshop.document().clone()
    };
    assert_eq!(made(), made());
}
