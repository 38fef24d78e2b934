//! Texts that know where they come from: what is read of another program's file, and our notation written from it.
//!
//! [`Foreign`] is the text that a dialect's reader sees. It may be put together from several files (a preprocessor includes them and
//! replaces names), so it keeps spans that lead back. [`Writer`] notes for each word that it writes the place in the foreign text that
//! the word stands for. Together, as an [`Origin`], they lead a fault in our notation back to file, line and column of what the person wrote.

use crate::lsystem::error::GrammarError;
use crate::lsystem::source::Source;

/// Bytes of a foreign text, macros and includes counted.
pub(crate) const MAX_FOREIGN_BYTES: usize = 4 << 20;
/// Bytes of our notation that may be written from it.
const MAX_WRITTEN_BYTES: usize = 64 << 20;

/// A place in the foreign text and what is the matter there.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) at: usize,
    pub(super) message: String,
}

impl Fault {
    pub(super) fn new(at: usize, message: impl Into<String>) -> Self {
        Self {
            at,
            message: message.into(),
        }
    }
}

/// Where a stretch of the foreign text comes from.
#[derive(Clone, Copy, Debug)]
struct Span {
    start: usize,
    file: usize,
    at: usize,
    /// As it stands in the file; otherwise all of it stands for the one place.
    copied: bool,
}

/// The text that a dialect's reader sees.
#[derive(Debug, Default)]
pub(crate) struct Foreign {
    pub(super) text: String,
    files: Vec<Source>,
    spans: Vec<Span>,
}

impl Foreign {
    /// One file, read as a text that is as long as the file's own.
    pub(super) fn of(source: Source, text: &str) -> Self {
        let mut foreign = Self::default();
        let file = foreign.add_file(source);
        foreign.copy(text, file, 0);
        foreign
    }

    /// Adds a file that text will be copied from.
    pub(super) fn add_file(&mut self, source: Source) -> usize {
        self.files.push(source);
        self.files.len() - 1
    }

    pub(super) fn file(&self, file: usize) -> Option<&Source> {
        self.files.get(file)
    }

    /// Copies a stretch of a file.
    pub(super) fn copy(&mut self, text: &str, file: usize, at: usize) {
        self.push(text, file, at, true);
    }

    /// Writes what stands for a place in a file.
    pub(super) fn replace(&mut self, text: &str, file: usize, at: usize) {
        self.push(text, file, at, false);
    }

    fn push(&mut self, text: &str, file: usize, at: usize, copied: bool) {
        if text.is_empty() {
            return;
        }
        self.spans.push(Span {
            start: self.text.len(),
            file,
            at,
            copied,
        });
        self.text.push_str(text);
    }

    fn place(&self, at: usize) -> Option<(&Source, usize)> {
        let after = self.spans.partition_point(|span| span.start <= at);
        let span = self.spans.get(after.saturating_sub(1))?;
        let within = if span.copied {
            at - span.start.min(at)
        } else {
            0
        };
        Some((self.files.get(span.file)?, span.at + within))
    }

    /// A fault in the file that the byte `at` comes from.
    pub(super) fn error(&self, at: usize, message: String) -> GrammarError {
        match self.place(at).or_else(|| Some((self.files.first()?, 0))) {
            Some((source, at)) => source.error(at, message),
            None => GrammarError::new("", "", 0, message),
        }
    }

    /// File and line of the byte `at`.
    pub(super) fn location(&self, at: usize) -> String {
        self.place(at)
            .map_or_else(String::new, |(source, at)| source.location(at))
    }
}

/// Our notation as it is written.
#[derive(Debug, Default)]
pub(super) struct Writer {
    pub(super) text: String,
    /// First byte of what is written, and the place in the foreign text that it stands for.
    spans: Vec<(usize, usize)>,
}

impl Writer {
    pub(super) fn put(&mut self, text: &str, at: usize) {
        if self.spans.last().is_none_or(|last| last.1 != at) {
            self.spans.push((self.text.len(), at));
        }
        self.text.push_str(text);
    }

    /// Writes what another has written.
    pub(super) fn append(&mut self, other: Self) {
        let start = self.text.len();
        let moved = other.spans.into_iter().map(|(at, from)| (start + at, from));
        self.spans.extend(moved);
        self.text.push_str(&other.text);
    }

    /// Takes a blank at the beginning away.
    pub(super) fn trim_start(&mut self) {
        if self.text.starts_with(' ') {
            self.text.remove(0);
            for span in &mut self.spans {
                span.0 = span.0.saturating_sub(1);
            }
        }
    }

    pub(super) fn is_full(&self) -> bool {
        self.text.len() > MAX_WRITTEN_BYTES
    }

    /// The text, and where it comes from.
    pub(super) fn finish(self, foreign: Foreign) -> (String, Origin) {
        let spans = self.spans;
        (self.text, Origin { foreign, spans })
    }
}

/// Where each part of a text in our notation comes from.
#[derive(Debug)]
pub(crate) struct Origin {
    foreign: Foreign,
    spans: Vec<(usize, usize)>,
}

impl Origin {
    fn foreign_at(&self, at: usize) -> usize {
        let after = self.spans.partition_point(|span| span.0 <= at);
        self.spans
            .get(after.saturating_sub(1))
            .map_or(0, |span| span.1)
    }

    /// A fault at the byte `at` of our text, in the foreign file.
    pub(crate) fn error(&self, at: usize, message: String) -> GrammarError {
        self.foreign.error(self.foreign_at(at), message)
    }

    /// File and line that the byte `at` of our text stands for.
    pub(crate) fn location(&self, at: usize) -> String {
        self.foreign.location(self.foreign_at(at))
    }
}
