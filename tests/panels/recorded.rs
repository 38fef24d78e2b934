//! A recorded session for each tool: played on the simulated headset it makes the project that lies beside it.
//!
//! `UPDATE_SESSIONS=1` records them anew with the hands of `lessons.rs`; look at what changed.

use std::path::PathBuf;

use ash::vk::Extent2D;
use glam::Vec3;
use ramus::app::session::{self, Nobody};
use ramus::app::workshop::Workshop;
use ramus::world::document::Document;
use ramus::world::lesson::Lesson;
use ramus::world::panels::PanelId;
use ramus::world::{World, history::History, project};
use ramus_xr::session as recorded;
use ramus_xr::simulated::Simulated;

use super::lessons::{does, draw, rest};
use super::visitor::{LEFT, RIGHT, Visitor};

/// What must be done before a tool can be used.
fn before(lesson: Lesson) -> &'static [Lesson] {
    match lesson {
        Lesson::Draw => &[],
        Lesson::DrawOn => &[Lesson::Draw],
        Lesson::Back => &[Lesson::Draw, Lesson::DrawOn, Lesson::Grow],
        Lesson::Delete => &[Lesson::Draw, Lesson::DrawOn, Lesson::Move],
        Lesson::Redo => &[Lesson::Draw, Lesson::DrawOn, Lesson::Undo],
        _ => &[Lesson::Draw, Lesson::DrawOn],
    }
}

fn file(lesson: Lesson, ending: &str) -> PathBuf {
    named(&format!("{lesson:?}").to_lowercase(), ending)
}

fn named(name: &str, ending: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("assets/sessions/tools")
        .join(format!("{name}.{ending}"))
}

fn record(lesson: Lesson) {
    let mut visitor = Visitor::new();
    for earlier in before(lesson).iter().chain([&lesson]) {
        does(&mut visitor, *earlier);
        rest(&mut visitor);
    }
    let bytes = recorded::to_bytes(&visitor.frames).unwrap();
    std::fs::create_dir_all(file(lesson, "session").parent().unwrap()).unwrap();
    std::fs::write(file(lesson, "session"), bytes).unwrap();
}

#[test]
fn each_tool_does_what_it_did_when_it_was_recorded() {
    let update = std::env::var_os("UPDATE_SESSIONS").is_some();
    for (number, lesson) in Lesson::ALL.into_iter().enumerate() {
        if update {
            record(lesson);
        }
        let frames = recorded::read_file(&file(lesson, "session")).unwrap();
        assert!(frames.len() > 6, "{lesson:?}");
        let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
        workshop.teach(number);
        let extent = Extent2D {
            width: 64,
            height: 64,
        };
        let mut headset = Simulated::new(frames, extent);
        session::run(&mut headset, &mut workshop, None, &mut Nobody).unwrap();
        let at = workshop
            .world()
            .lesson()
            .map_or(Lesson::ALL.len(), |(at, _)| at);
        assert!(
            at > number,
            "{lesson:?} was not learnt from its own session"
        );
        let made = project::to_bytes(workshop.document());
        if update {
            std::fs::write(file(lesson, "ramus"), &made).unwrap();
        }
        let expected = std::fs::read(file(lesson, "ramus")).unwrap();
        assert_eq!(
            String::from_utf8_lossy(&made),
            String::from_utf8_lossy(&expected),
            "{lesson:?}"
        );
    }
}

/// Sets something in the bench's tab, as a person does.
fn sets(visitor: &mut Visitor, tab: &str, what: &str) {
    visitor.click(LEFT, PanelId::Bench, tab);
    visitor.click(LEFT, PanelId::Bench, what);
}

fn erases(visitor: &mut Visitor) {
    sets(visitor, "Draw", "Eraser");
    draw(visitor, Vec3::Y * 0.16);
}

fn snaps(visitor: &mut Visitor) {
    sets(visitor, "Draw", "snap to angles");
    draw(visitor, Vec3::new(0.004, 0.26, 0.0));
}

fn mirrors(visitor: &mut Visitor) {
    sets(visitor, "Draw", "draw branches with their mirror image");
    draw(visitor, Vec3::Y * 0.08);
    draw(visitor, Vec3::new(0.08, 0.12, 0.02));
}

/// Turns by a snap, then goes where the ball falls.
fn turns(visitor: &mut Visitor) {
    sets(visitor, "Room", "turn and teleport by the stick");
    // Away from the panels, which the stick would scroll.
    let ahead = Vec3::new(-0.22, 0.1, -1.0).normalize();
    visitor.tip_to_along(LEFT, Vec3::new(-0.25, 1.25, -0.35), ahead);
    for [x, y] in [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [0.0, 0.0]] {
        visitor.frame.hands[LEFT].stick = glam::Vec2::new(x, y);
        visitor.frame();
    }
}

/// Grows the tree, plants a row and a single one, and uproots that.
fn plants(visitor: &mut Visitor) {
    for lower in [true, false, true, false] {
        visitor.frame.hands[RIGHT].lower = lower;
        visitor.frame();
    }
    sets(visitor, "Draw", "Plant");
    let at = |visitor: &mut Visitor, x: f32, z: f32| {
        let from = Vec3::new(0.3, 1.3, -0.2);
        let ahead = (Vec3::new(x, 0.0, z) - from).normalize();
        visitor.tip_to_along(RIGHT, from + ahead * 0.1, ahead);
    };
    at(visitor, 1.5, -4.0);
    visitor.pull(RIGHT, true);
    for n in 0..=20_u8 {
        at(visitor, 1.5 + 0.3 * f32::from(n), -4.0 - 0.3 * f32::from(n));
    }
    visitor.pull(RIGHT, false);
    at(visitor, -2.0, -5.0);
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    visitor.grip(RIGHT, true);
    visitor.grip(RIGHT, false);
}

/// What a person does with it.
type Hands = fn(&mut Visitor);

/// What a tool has made of a trunk of two pieces.
type Made = fn(&Document, &Workshop) -> bool;

/// Tools that no lesson teaches: name, hands, and what they make.
const OTHERS: [(&str, Hands, Made); 5] = [
    ("eraser", erases, |made, _| {
        made.sketch.strokes[0].points.len() == 1
    }),
    ("snap", snaps, |made, _| {
        let trunk = &made.sketch.strokes[0].points;
        trunk.len() == 3 && trunk[2].x == trunk[1].x
    }),
    ("mirror", mirrors, |made, _| made.sketch.strokes.len() == 3),
    ("planting", plants, |made, _| made.grove.plants.len() == 3),
    ("turning", turns, |_, workshop| {
        let room = workshop.world().stage_from_room();
        let (_, turn, place) = room.to_scale_rotation_translation();
        turn.to_axis_angle().1 > 0.3 && place.length() > 0.3
    }),
];

#[test]
fn tools_of_the_bench_do_what_they_did_when_they_were_recorded() {
    let update = std::env::var_os("UPDATE_SESSIONS").is_some();
    for (name, hands, made) in OTHERS {
        if update {
            let mut visitor = Visitor::new();
            for earlier in [Lesson::Draw, Lesson::DrawOn] {
                does(&mut visitor, earlier);
                rest(&mut visitor);
            }
            hands(&mut visitor);
            rest(&mut visitor);
            let bytes = recorded::to_bytes(&visitor.frames).unwrap();
            std::fs::write(named(name, "session"), bytes).unwrap();
        }
        let frames = recorded::read_file(&named(name, "session")).unwrap();
        let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
        let extent = Extent2D {
            width: 64,
            height: 64,
        };
        let mut headset = Simulated::new(frames, extent);
        session::run(&mut headset, &mut workshop, None, &mut Nobody).unwrap();
        assert!(
            made(workshop.document(), &workshop),
            "{name}: {:?}",
            workshop.world().stage_from_room()
        );
        let bytes = project::to_bytes(workshop.document());
        if update {
            std::fs::write(named(name, "ramus"), &bytes).unwrap();
        }
        let expected = std::fs::read(named(name, "ramus")).unwrap();
        assert!(bytes == expected, "{name} makes another project");
    }
}
