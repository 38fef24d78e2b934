//! Files that a person asks for in the workshop: written on a worker, one after the other, told on the board.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::abstraction;
use crate::app::worker::Worker;
use crate::app::{centerlines, export, take_home};
use crate::mesh::unit::Unit;
use crate::tree::Organs;
use crate::tree::file::write_atomically;
use crate::world::document::Document;
use crate::world::likeness::Likeness;
use crate::world::lines::Lines;

/// What is written.
#[derive(Clone, Debug)]
pub(super) enum Taken {
    /// A document's tree or, as `lsys`, its grammar.
    Tree(Document),
    /// A model's centerlines or, as `csv` and `json`, what is told of them, in its unit.
    Lines(Arc<Lines>, Unit),
    /// A tree that grows on the stage or, as `lsys`, its grammar.
    Likeness(Likeness),
}

/// A file that was written and how many planted trees are in it, or why there is none.
type Written = Result<(PathBuf, usize), String>;

/// Writes what was asked for.
pub(super) struct Takeaway {
    worker: Worker<(Taken, PathBuf), Written>,
    /// Asked for and not begun: a worker would drop the older of two.
    waiting: VecDeque<(Taken, PathBuf)>,
    /// Being written.
    writing: Option<PathBuf>,
}

/// Most files that wait at a time: a person who presses on and on does not fill the memory.
const MOST_WAITING: usize = 16;

impl Takeaway {
    /// # Errors
    /// Where the system gives no thread.
    pub(super) fn start() -> std::io::Result<Self> {
        let job = |(what, path): &(Taken, PathBuf), _: &AtomicBool| write(what, path);
        Ok(Self {
            worker: Worker::start("ramus-takeaway", job)?,
            waiting: VecDeque::new(),
            writing: None,
        })
    }

    /// Asks for a file beside another one, under a name like that one's that is free. False: too many wait already.
    #[must_use]
    pub(super) fn ask(&mut self, what: Taken, name: &Path, ending: &str) -> bool {
        let room = self.waiting.len() < MOST_WAITING;
        if room {
            let path = self.free_name(name, ending);
            self.waiting.push_back((what, path));
        }
        room
    }

    /// Goes on; gives a sentence when a file was written or could not be.
    pub(super) fn poll(&mut self) -> Option<String> {
        let told = self.writing.as_ref().and_then(|_| self.worker.poll());
        if told.is_some() {
            self.writing = None;
        }
        if self.writing.is_none()
            && let Some(next) = self.waiting.pop_front()
        {
            self.writing = Some(next.1.clone());
            self.worker.ask(next);
        }
        told.map(sentence)
    }

    /// Waits until everything is written; gives what is to be told.
    pub(super) fn finish(&mut self) -> Vec<String> {
        let mut told = Vec::new();
        loop {
            if self.writing.is_some() {
                let Some(written) = self.worker.wait() else {
                    return told;
                };
                self.writing = None;
                told.push(sentence(written));
            }
            told.extend(self.poll());
            if self.writing.is_none() {
                return told;
            }
        }
    }

    /// A free name beside a project, for what waits too.
    fn free_name(&self, project: &Path, ending: &str) -> PathBuf {
        let stem = project.file_stem().unwrap_or_default().to_string_lossy();
        free_name(&project.with_file_name(&*stem), ending, |path| {
            let waiting = self.waiting.iter().map(|(_, other)| other);
            self.writing
                .iter()
                .chain(waiting)
                .any(|other| other == path)
        })
    }
}

/// `name-1.ending`, `name-2.ending`, …: the first that no file has and that is not `taken`, so that nothing is written over.
pub(crate) fn free_name(name: &Path, ending: &str, taken: impl Fn(&Path) -> bool) -> PathBuf {
    let stem = name.file_name().unwrap_or_default().to_string_lossy();
    let numbered = |n: u32| name.with_file_name(format!("{stem}-{n}.{ending}"));
    let is_free = |path: &PathBuf| path.symlink_metadata().is_err() && !taken(path);
    (1..)
        .map(numbered)
        .find(is_free)
        .unwrap_or_else(|| numbered(0))
}

/// What is told of a file.
fn sentence(written: Written) -> String {
    match written {
        Err(problem) => problem,
        Ok((path, 0)) => format!("Written: {}", path.display()),
        Ok((path, planted)) => {
            format!("Written with {planted} planted trees: {}", path.display())
        }
    }
}

fn write(what: &Taken, path: &Path) -> Written {
    let planted = match what {
        Taken::Tree(document) if take_home::holds_planted(document, path) => {
            document.grove.plants.len()
        }
        _ => 0,
    };
    let ending = path.extension().and_then(|ending| ending.to_str());
    let written = match (what, ending.unwrap_or_default()) {
        (Taken::Tree(document), "lsys") => take_home::grammar(document, path),
        (Taken::Tree(document), _) => take_home::export(document, path),
        (Taken::Lines(lines, _), "csv") => {
            centerlines::write_tables(&lines.analysis, path).map_err(Into::into)
        }
        (Taken::Lines(lines, unit), "json") => {
            centerlines::write_analysis(&lines.analysis, *unit, path).map_err(Into::into)
        }
        (Taken::Likeness(likeness), "lsys") => {
            let text = abstraction::text(&likeness.params);
            write_atomically(path, text.as_bytes()).map_err(Into::into)
        }
        (Taken::Likeness(likeness), ending) => write_likeness(likeness, ending, path),
        (Taken::Lines(lines, _), _) => {
            centerlines::write(&lines.centerline, path).map_err(Into::into)
        }
    };
    let wrong = |error: anyhow::Error| format!("{error:#}: {}", path.display());
    written.map(|()| (path.to_owned(), planted)).map_err(wrong)
}

/// Writes a tree as far as it has grown: a skeleton as it is, anything else as it is looked at.
fn write_likeness(likeness: &Likeness, ending: &str, path: &Path) -> anyhow::Result<()> {
    let never = AtomicBool::new(false);
    let tree = match ending {
        "swc" => likeness.tree(&never)?,
        _ => likeness.shown(&never)?,
    };
    Ok(export::drawing(&tree, &Organs::default(), path)?)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    #[test]
    fn two_files_asked_for_at_once_have_two_names() {
        let folder = tempfile::tempdir().unwrap();
        let project = folder.path().join("oak.ramus");
        let mut takeaway = Takeaway::start().unwrap();
        for _ in 0..3 {
            let tree = Taken::Tree(Document::default());
            assert!(takeaway.ask(tree, &project, "lsys"));
            // The first is with the worker now, and perhaps not written yet.
            takeaway.poll();
        }
        takeaway.finish();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
    }
}
