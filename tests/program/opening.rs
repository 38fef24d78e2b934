//! A recording that began with a project is replayed from there, with no other file beside it.

use std::fs;

use glam::Vec3;
use ramus::app::opening::Opening;
use ramus::app::store::read_project;
use ramus::app::workshop::Workshop;
use ramus::sketch::{NodeRef, Sketch};
use ramus::world::document::Document;
use ramus::world::{World, history::History};

use super::{folder, ramus, refused, succeed};

/// A pull of the grow button.
const GROWS: &str = "frame 0\nright tracked yes\nframe 0.01\nframe 0.02\nright lower yes\nframe 0.03\nright lower no\n";

#[test]
fn a_recording_is_replayed_from_the_project_it_began_with() {
    let nodes: Vec<Vec3> = (1..200_u8).map(|n| Vec3::Y * 0.01 * f32::from(n)).collect();
    let (sketch, _) = Sketch::default()
        .add_segments(NodeRef::ROOT, &nodes)
        .unwrap();
    let began = Document {
        sketch: sketch.into(),
        step: 3,
        ..Document::default()
    };
    let workshop = Workshop::unsaved(World::new(History::new(began.clone()))).unwrap();
    let comments = Opening::of(&workshop).comments();
    assert!(comments.len() > 5, "it lies in several lines");
    let folder = folder();
    let [session, project] = ["s.session", "p.ramus"].map(|name| folder.path().join(name));
    let replay = |comments: &[String]| {
        let said: String = comments.iter().map(|it| format!("# {it}\n")).collect();
        fs::write(&session, format!("ramus-session 1\n{said}{GROWS}")).unwrap();
        let mut command = ramus();
        command.arg("replay").arg(&session);
        command.arg("--project").arg(&project);
        command
    };
    succeed(&mut replay(&comments));
    let grown = Document { step: 4, ..began };
    assert_eq!(read_project(&project).unwrap(), grown);
    // The project that is there is no part of it.
    succeed(&mut replay(&comments));
    assert_eq!(read_project(&project).unwrap(), grown);

    fs::remove_file(&project).unwrap();
    let cut = replay(&comments[..comments.len() - 1]).output().unwrap();
    refused(&cut, &["cannot play", "it began with a project of"]);
    assert!(!project.exists(), "nothing is made");
}
