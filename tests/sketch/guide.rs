//! The guide's examples are what the program makes.

use super::super::*;

#[test]
fn the_guide_shows_what_is_written() {
    let sketch = Sketch {
        self_similar_branches: false,
        ..Sketch::default()
    };
    let (sketch, _) = sketch
        .add_segments(
            NodeRef::ROOT,
            &[
                Vec3::Y * 0.15,
                Vec3::Y * 0.3,
                Vec3::new(0.02, 0.45, 0.0),
                Vec3::new(0.06, 0.6, 0.0),
            ],
        )
        .unwrap();
    let (sketch, _) = sketch
        .add_segments(
            NodeRef::new(Letter::TRUNK, 2),
            &[Vec3::new(0.1, 0.4, 0.0), Vec3::new(0.2, 0.45, 0.0)],
        )
        .unwrap();
    let (sketch, _) = sketch
        .add_segment(NodeRef::new(Letter::TRUNK, 3), Vec3::new(-0.08, 0.5, 0.05))
        .unwrap();
    let own = Some(SelfSimilar {
        rate: 2,
        depth_limit: Some(1),
    });
    let sketch = sketch.with_self_similar(letter(1), own).unwrap();
    let text = sketch.grammar_text();
    let guide = include_str!("../../docs/src/sketch.md");
    assert!(
        guide.contains(&text),
        "docs/src/sketch.md must show this grammar:\n{text}"
    );
    let string = without_rolls(&grown(&sketch, 7).string);
    assert!(
        guide.contains(&string),
        "docs/src/sketch.md must show this string:\n{string}"
    );

    // The same sketch as a project, and how it was drawn as a journal.
    let (history, journal) = guide_session();
    let page = include_str!("../../docs/src/project-file.md");
    let project = String::from_utf8(project::to_bytes(history.committed())).unwrap();
    assert!(
        page.contains(&project),
        "docs/src/project-file.md must show this project:\n{project}"
    );
    assert!(
        page.contains(&journal),
        "docs/src/project-file.md must show this journal:\n{journal}"
    );
}

/// A trunk and a branch, drawn as a person draws them.
fn guide_session() -> (History, String) {
    let mut history = History::default();
    let (mut journal, mut text) = Journal::begin(history.committed());
    let edits = [
        Edit::AddStroke {
            to: vec![Vec3::Y * 0.15, Vec3::Y * 0.3],
        },
        Edit::Select {
            at: NodeRef::new(Letter::TRUNK, 1),
        },
        Edit::AddSegment {
            to: Vec3::new(0.1, 0.25, 0.0),
        },
        Edit::SetStep { step: 5 },
        Edit::SetDivergence { degrees: 90.0 },
    ];
    for edit in edits {
        history.apply(edit).unwrap();
    }
    history.undo();
    for action in history.take_log() {
        text.push_str(&journal.line(&action));
    }
    (history, text)
}
