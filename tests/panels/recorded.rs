//! A recorded session for each tool: played on the simulated headset it makes the project that lies beside it.
//!
//! `UPDATE_SESSIONS=1` records them anew with the hands of `lessons.rs`; look at what changed.

use std::path::PathBuf;

use ash::vk::Extent2D;
use ramus::app::session::{self, Nobody};
use ramus::app::workshop::Workshop;
use ramus::world::lesson::Lesson;
use ramus::world::{World, history::History, project};
use ramus_xr::session as recorded;
use ramus_xr::simulated::Simulated;

use super::lessons::{does, rest};
use super::visitor::Visitor;

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
    let name = format!("{lesson:?}").to_lowercase();
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
