//! How the workshop stands when a recording begins: the recording says it in comments, and replaying begins there.
//!
//! Panels lie differently in another language and another room, so the first comment says the settings. The others hold the project
//! that the session began with, as the text of its file, so that a recording needs no other file beside it. A project
//! that is too large for that is named by its length alone, and such a recording is not replayed.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::app::workshop::Workshop;
use crate::ui::Settings;
use crate::world::document::Document;
use crate::world::project::{self, ProjectError};
use crate::world::study::flow::{Plan, Progress, Study};

/// How the comment begins that says the settings.
const SETTINGS: &str = "ramus: ";
/// What a piece of the project stands between: comments are trimmed.
const PIECE: [&str; 2] = ["project |", "|"];
/// And a piece of the sitting.
const STUDY_PIECE: [&str; 2] = ["study |", "|"];
/// Longest piece, bytes: with its sign and the ends it fits into a line of a session.
const PIECE_BYTES: usize = 480;
/// Longest project that a recording holds, bytes: some 30,000 nodes.
const MOST_BYTES: usize = 1 << 20;

/// Why a recording does not say what it began with.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum OpeningError {
    /// The project was too large, or somebody took pieces out.
    #[error(
        "it began with a project of {said} bytes and holds {held} of them (a recording holds at most {MOST_BYTES}): it cannot be replayed"
    )]
    Missing {
        /// Length of the project.
        said: usize,
        /// How much of it is there.
        held: usize,
    },
    /// All of it is there and is no project.
    #[error("the project that it began with cannot be read: {0}")]
    Project(#[from] ProjectError),
    /// It was the sitting of a study, and somebody took pieces of that out.
    #[error(
        "it was the sitting of a study, and does not say all of what that began with: it cannot be replayed"
    )]
    Study,
}

/// The settings, and how much there is of the project.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Said {
    settings: Settings,
    /// The lesson that is going on.
    teaching: Option<usize>,
    /// Bytes of the project, where it is not the empty one. Recordings before version 0.1.0 was out do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    project: Option<usize>,
    /// Bytes of the sitting of a study, where it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    study: Option<usize>,
}

/// See the module.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Opening {
    said: Option<Said>,
    document: Document,
    /// The sitting of a study, where it is one.
    study: Option<(Plan, Progress)>,
}

impl Opening {
    /// As a workshop stands now.
    #[must_use]
    pub fn of(workshop: &Workshop) -> Self {
        let document = workshop.document().clone();
        let study = workshop.world().study();
        let study = study.map(|study| (study.plan().clone(), study.progress().clone()));
        let said = Said {
            settings: workshop.settings(),
            teaching: workshop.world().lesson().map(|(number, _)| number),
            project: (document != Document::default()).then(|| text(&document).len()),
            study: study.as_ref().map(|study| study_text(study).len()),
        };
        Self {
            said: Some(said),
            document,
            study,
        }
    }

    /// Of a recorded session; one that says nothing began with nothing.
    ///
    /// # Errors
    /// [`OpeningError`] where it began with a project that it does not hold whole.
    pub fn of_session(session: &Path) -> Result<Self, OpeningError> {
        Self::of_comments(&ramus_xr::session::first_comments(session))
    }

    fn of_comments(comments: &[String]) -> Result<Self, OpeningError> {
        let said: Option<Said> = comments
            .iter()
            .find_map(|comment| serde_json::from_str(comment.strip_prefix(SETTINGS)?).ok());
        let read = |length: usize| {
            let text = joined(comments, STUDY_PIECE);
            let whole = (text.len() == length).then(|| serde_json::from_str(&text).ok());
            whole.flatten().ok_or(OpeningError::Study)
        };
        let study = said.and_then(|said| said.study).map(read).transpose()?;
        let Some(length) = said.and_then(|said| said.project) else {
            return Ok(Self {
                said,
                study,
                ..Self::default()
            });
        };
        let text = joined(comments, PIECE);
        if text.len() != length {
            return Err(OpeningError::Missing {
                said: length,
                held: text.len(),
            });
        }
        let document = project::from_bytes(text.as_bytes())?;
        Ok(Self {
            said,
            document,
            study,
        })
    }

    /// The comments that say it.
    #[must_use]
    pub fn comments(&self) -> Vec<String> {
        let Some(said) = self.said else {
            return Vec::new();
        };
        let settings = serde_json::to_string(&said).unwrap_or_default();
        let mut comments = vec![format!("{SETTINGS}{settings}")];
        let mut hold = |[before, after]: [&str; 2], text: &str| {
            comments.extend(pieces(text).map(|piece| format!("{before}{piece}{after}")));
        };
        if said.project.is_some_and(|bytes| bytes <= MOST_BYTES) {
            hold(PIECE, &text(&self.document));
        }
        if let Some(study) = &self.study {
            hold(STUDY_PIECE, &study_text(study));
        }
        comments
    }

    /// The document that it began with.
    #[must_use]
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// Gives a workshop, which has that document, the settings.
    pub fn apply(&self, workshop: &mut Workshop) {
        let Some(said) = self.said else { return };
        workshop.set(said.settings);
        if let Some(lesson) = said.teaching {
            workshop.teach(lesson);
        }
        if let Some((plan, progress)) = self.study.clone() {
            workshop.sit_unkept(Study::resume(plan, progress));
        }
    }
}

/// A sitting as text in one line.
fn study_text(study: &(Plan, Progress)) -> String {
    serde_json::to_string(study).unwrap_or_default()
}

/// What stands in pieces in comments.
fn joined(comments: &[String], [before, after]: [&str; 2]) -> String {
    let pieces = comments
        .iter()
        .filter_map(|comment| comment.strip_prefix(before)?.strip_suffix(after));
    pieces.collect()
}

/// A project's text in one line: between its lines is nothing but space, since strings have no line ends.
fn text(document: &Document) -> String {
    let bytes = project::to_bytes(document);
    let lines = String::from_utf8_lossy(&bytes);
    lines.lines().map(str::trim_start).collect()
}

/// A text in pieces that comments hold.
fn pieces(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let most = rest.len().min(PIECE_BYTES);
        let end = (0..=most).rev().find(|&end| rest.is_char_boundary(end))?;
        let (piece, after) = rest.split_at(end);
        rest = after;
        (!piece.is_empty()).then_some(piece)
    })
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "tests say what they expect by their names"
    )]

    use glam::Vec3;
    use proptest::prelude::*;
    use ramus_xr::record::Tape;

    use super::*;
    use crate::app::study::plan::Told;
    use crate::ui::words::Language;
    use crate::world::{World, document::Edit, history::History};

    fn workshop(document: Document) -> Workshop {
        Workshop::unsaved(World::new(History::new(document))).unwrap()
    }

    /// A line of so many nodes.
    fn drawn(nodes: u16) -> Document {
        let mut history = History::default();
        let to = (1..=nodes).map(|n| Vec3::new(0.0123, f32::from(n) * 0.001, -0.0456));
        history.apply(Edit::AddStroke { to: to.collect() }).unwrap();
        history.committed().clone()
    }

    /// A recording by that workshop, on disk.
    fn recorded(workshop: &Workshop, path: &Path) -> Vec<u8> {
        let tape = Tape::new(Vec::new());
        let comments = Opening::of(workshop).comments();
        let tape = comments.iter().fold(tape, |tape, it| tape.with_comment(it));
        let written = tape.finish().unwrap();
        std::fs::write(path, &written).unwrap();
        written
    }

    #[test]
    fn a_recording_says_how_the_workshop_stood() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.session");
        for nodes in [0, 1, 40, 1500] {
            let document = match nodes {
                0 => Document::default(),
                nodes => drawn(nodes),
            };
            let mut first = workshop(document.clone());
            let mut settings = first.settings();
            settings.language = Language::German;
            settings.room.turning = true;
            first.set(settings);
            first.teach(4);
            let written = recorded(&first, &path);
            assert!(ramus_xr::session::from_bytes(&written).unwrap().is_empty());
            let opening = Opening::of_session(&path).unwrap();
            assert_eq!(opening.document(), &document);
            let mut second = workshop(opening.document().clone());
            opening.apply(&mut second);
            assert_eq!(Opening::of(&second), Opening::of(&first));
        }
    }

    #[test]
    fn what_says_nothing_began_with_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.session");
        let older = "ramus-session 1\n# ramus: {\"settings\":{},\"teaching\":null}\n";
        for text in [
            "ramus-session 1\n",
            "",
            "ramus-session 1\n# ramus: {\n",
            "\u{0}",
            older,
        ] {
            std::fs::write(&path, text).unwrap();
            let opening = Opening::of_session(&path).unwrap();
            assert_eq!(opening.document(), &Document::default());
        }
    }

    #[test]
    fn a_sitting_is_said_or_told_to_be_missing() {
        let plan = Told::own().unwrap().plan;
        let progress = Progress {
            page: 2,
            ..Progress::default()
        };
        let mut first = workshop(Document::default());
        first.sit_unkept(Study::resume(plan, progress));
        let opening = Opening::of(&first);
        let comments = opening.comments();
        let again = Opening::of_comments(&comments).unwrap();
        assert_eq!(again, opening);
        let mut second = workshop(Document::default());
        again.apply(&mut second);
        assert_eq!(second.world().study().unwrap().place()[0], 3);
        let missing = Opening::of_comments(&comments[..comments.len() - 1]);
        assert_eq!(missing.unwrap_err(), OpeningError::Study);
    }

    #[test]
    fn a_project_that_is_not_there_whole_is_told() {
        let document = drawn(40);
        let mut comments = Opening::of(&workshop(document)).comments();
        let said = Opening::of_comments(&comments).unwrap().said.unwrap();
        let length = said.project.unwrap();
        let last = comments.pop().unwrap();
        let missing = Opening::of_comments(&comments).unwrap_err();
        let held = length - (last.len() - PIECE[0].len() - PIECE[1].len());
        assert_eq!(missing, OpeningError::Missing { said: length, held });
        comments.push(last.replace(']', "x"));
        let broken = Opening::of_comments(&comments).unwrap_err();
        assert!(matches!(broken, OpeningError::Project(_)), "{broken}");
        // One that no recording holds is said to be missing, and takes no room.
        let huge = Opening {
            said: Some(Said {
                project: Some(MOST_BYTES + 1),
                ..said
            }),
            document: Document::default(),
            study: None,
        };
        let comments = huge.comments();
        assert_eq!(comments.len(), 1);
        let missing = Opening::of_comments(&comments).unwrap_err().to_string();
        assert!(missing.contains("holds 0 of them"), "{missing}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

        #[test]
        fn pieces_are_the_text_and_fit_a_line(text in "\\PC{0,2000}") {
            let cut: Vec<&str> = pieces(&text).collect();
            prop_assert_eq!(cut.concat(), text.as_str());
            prop_assert!(cut.iter().all(|piece| piece.len() <= PIECE_BYTES));
        }

        #[test]
        fn any_comments_are_read_or_refused(
            length in any::<Option<usize>>(),
            pieces in proptest::collection::vec("\\PC{0,40}", 0..6),
        ) {
            let length = length.map_or(String::new(), |bytes| format!(",\"project\":{bytes}"));
            let mut comments = vec![format!("{SETTINGS}{{\"settings\":{{}},\"teaching\":null{length}}}")];
            comments.extend(pieces.iter().map(|piece| format!("{}{piece}{}", PIECE[0], PIECE[1])));
            comments.extend(pieces);
            let _ = Opening::of_comments(&comments);
        }
    }
}
