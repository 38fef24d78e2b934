//! Curves in the document: as edits, in files of both versions, and in the journal.

use super::*;
use crate::sketch::Symmetry;

/// A curve from `from` through two handles.
fn curve(from: NodeRef, symmetry: Symmetry) -> Edit {
    let through = vec![Vec3::new(0.1, 0.5, 0.0), Vec3::new(0.3, 0.8, 0.1)];
    Edit::DrawCurve {
        from,
        through,
        segments: vec![3, 4],
        symmetry,
    }
}

const MIRROR: Symmetry = Symmetry {
    turns: 1,
    mirror: true,
};

fn text(document: &Document) -> String {
    String::from_utf8(project::to_bytes(document)).unwrap()
}

#[test]
fn a_curve_is_one_edit_that_starts_where_it_says() {
    let mut history = apply_all(&example());
    let (before, undo) = (history.committed().clone(), history.undo_count());
    assert_ne!(before.selected, a(3));
    history.apply(curve(a(3), MIRROR)).unwrap();
    let document = history.committed();
    document.validate().unwrap();
    let drawn = document.sketch.stroke(document.selected.letter).unwrap();
    assert_eq!(
        (drawn.attachment, &drawn.handles),
        (Some(a(3)), &vec![3, 7])
    );
    assert_eq!(
        document.sketch.strokes.len(),
        before.sketch.strokes.len() + 2
    );
    assert_eq!(history.undo_count(), undo + 1);
    history.undo();
    assert_eq!(history.committed(), &before);
}

#[test]
fn a_project_says_version_2_where_it_has_handles_and_1_elsewhere() {
    let plain = apply_all(&example());
    assert!(text(plain.committed()).contains("\"version\": 1,"));
    let mut history = plain.clone();
    history.apply(curve(a(4), Symmetry::OFF)).unwrap();
    let curved = text(history.committed());
    assert!(curved.contains("\"version\": 2,"), "{curved}");
    assert!(curved.contains("\"handles\": [1,2,3,4,7,11],"), "{curved}");
    assert_eq!(
        curved.matches("handles").count(),
        1,
        "plain strokes list none"
    );
    let read = project::from_bytes(curved.as_bytes()).unwrap();
    assert_eq!(&read, history.committed());
    assert_eq!(text(&read), curved);
    // A plain project that calls itself newer is one.
    let newer = text(plain.committed()).replacen("\"version\": 1", "\"version\": 2", 1);
    assert_eq!(
        &project::from_bytes(newer.as_bytes()).unwrap(),
        plain.committed()
    );
}

#[test]
fn radii_of_lines_that_were_taken_are_kept_forgotten_and_undone() {
    let mut history = apply_all(&example());
    let line = crate::world::taken::TakenLine {
        from: None,
        to: vec![Vec3::new(0.0, 2.0, 0.0), Vec3::new(0.0, 2.5, 0.0)],
        radii: vec![0.012_345_6, 0.01],
    };
    history.apply(Edit::Select { at: a(4) }).unwrap();
    let lines = vec![line];
    history.apply(Edit::TakeLines { lines }).unwrap();
    let thick = text(history.committed());
    assert!(thick.contains("\"version\": 4,"), "{thick}");
    assert!(
        thick.contains(",0.012346,0.01],"),
        "on a grid of a micrometre: {thick}"
    );
    let read = project::from_bytes(thick.as_bytes()).unwrap();
    assert_eq!((&read, text(&read)), (history.committed(), thick.clone()));
    // Every way in which they can be wrong has its reason.
    let radii = &thick[thick.find("\"radii\": [").unwrap()..];
    let radii = &radii[..=radii.find(']').unwrap()];
    for (replaced, reason) in [
        ("\"radii\": [0.1]", "needs one for each node"),
        (&radii.replace("0.012346", "-1")[..], "a radius"),
        (&radii.replace("0.012346", "1e9")[..], "a radius"),
        ("\"radii\": 7", "damaged"),
    ] {
        let bad = thick.replacen(radii, replaced, 1);
        assert_ne!(bad, thick);
        let said = project::from_bytes(bad.as_bytes()).unwrap_err().to_string();
        assert!(said.contains(reason), "{replaced}: {said}");
    }
    let older = thick.replacen("\"version\": 4", "\"version\": 3", 1);
    let said = project::from_bytes(older.as_bytes())
        .unwrap_err()
        .to_string();
    assert!(said.contains("version 3 has no field `radii`"), "{said}");
    let letter = Letter::TRUNK;
    history.apply(Edit::ForgetRadii { letter }).unwrap();
    assert!(text(history.committed()).contains("\"version\": 1,"));
    history.undo();
    assert_eq!(text(history.committed()), thick);
}

#[test]
fn hostile_handles_are_refused_with_a_reason() {
    let mut history = apply_all(&example());
    history.apply(curve(a(4), Symmetry::OFF)).unwrap();
    let good = text(history.committed());
    let handles = "[1,2,3,4,7,11]";
    for (replaced, reason) in [
        ("[1,2,3,4,7]", "rising, the last one its apex"),
        ("[1,2,3,4,7,12]", "rising, the last one its apex"),
        ("[0,2,3,4,7,11]", "rising, the last one its apex"),
        ("[1,3,2,4,7,11]", "rising, the last one its apex"),
        ("[4,4,11]", "rising, the last one its apex"),
        ("[1,2,3,4,5,6,7,8,9,10,11]", "fewer than its nodes"),
        ("[-1,11]", "damaged"),
        ("[1.5,11]", "damaged"),
        ("[4294967296]", "damaged"),
        ("7", "damaged"),
    ] {
        let bad = good.replacen(handles, replaced, 1);
        assert_ne!(bad, good);
        let message = project::from_bytes(bad.as_bytes()).unwrap_err().to_string();
        assert!(message.contains(reason), "{replaced}: {message}");
    }
    let older = good.replacen("\"version\": 2", "\"version\": 1", 1);
    let message = project::from_bytes(older.as_bytes())
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("version 1 has no field `handles`"),
        "{message}"
    );
}

#[test]
fn the_journal_keeps_a_curve_small_and_exact() {
    let mut history = History::default();
    let (mut journal, mut lines) = Journal::begin(history.committed());
    let edit = Edit::DrawCurve {
        from: a(0),
        through: vec![Vec3::new(0.100_04, 0.5, 0.0)],
        segments: vec![12],
        symmetry: Symmetry::OFF,
    };
    history.apply(edit).unwrap();
    history.apply(curve(a(6), MIRROR)).unwrap();
    let actions = history.take_log();
    let written: Vec<String> = actions.iter().map(|action| journal.line(action)).collect();
    let expected = r#"{"edit":{"draw-curve":{"from":{"letter":"A","node":0},"through":[[0.1,0.5,0.0]],"segments":[12]}}}"#;
    assert!(written[0].contains(expected), "{}", written[0]);
    assert!(
        written[1].contains(r#""symmetry":{"turns":1,"mirror":true}"#),
        "{}",
        written[1]
    );
    written.iter().for_each(|line| lines.push_str(line));
    let decoded = journal::decode(lines.as_bytes()).unwrap();
    assert_eq!((decoded.damage, &decoded.actions), (None, &actions));
    assert_eq!(
        journal::recover(&decoded).history.committed(),
        history.committed()
    );
}

#[test]
fn a_session_that_ends_in_the_middle_of_a_stroke_comes_back() {
    let mut history = apply_all(&[up(0.1), up(0.2)]);
    assert!(history.redo_count() == 0 && history.take_back());
    assert_eq!(
        (history.undo_count(), history.redo_count()),
        (1, 0),
        "what is taken back cannot be redone"
    );
    let mut again = History::default();
    for action in history.take_log() {
        again.repeat(action).unwrap();
    }
    assert_eq!(again.committed(), history.committed());
    for history in [&mut history, &mut again] {
        history.apply(curve(a(1), Symmetry::OFF)).unwrap();
        assert_eq!((history.undo_count(), history.redo_count()), (2, 0));
    }
    assert_eq!(again.committed(), history.committed());
    assert!(
        !History::default().take_back(),
        "there is nothing to take back"
    );
}
