//! What can go wrong in a grammar's text and in its derivation, each in one sentence.

use std::fmt;

use thiserror::Error;

use super::string::ModuleString;

/// Errors reported for one text; later ones are only counted.
pub(crate) const MAX_ERRORS: usize = 20;
/// Characters of a source line shown under an error, so that a million-character line stays readable.
const SHOWN_CHARS: usize = 100;

/// One fault in a grammar's text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GrammarError {
    /// Name of the file, as given to `Grammar::parse` or in an `include`.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What was found, what was expected and, for names, the nearest known one.
    pub message: String,
    /// The line (a part of it where it is long).
    pub excerpt: String,
    /// Characters of `excerpt` before the caret.
    pub caret: usize,
}

impl GrammarError {
    /// An error at the byte `at` of `text`.
    pub(crate) fn new(file: &str, text: &str, at: usize, message: String) -> Self {
        let before = text.as_bytes().get(..at).unwrap_or(text.as_bytes());
        let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
        let start = before
            .iter()
            .rposition(|&b| b == b'\n')
            .map_or(0, |i| i + 1);
        Self::on_line(file, text, at, [line, start], message)
    }

    /// The same where the line's number and its first byte are known.
    pub(crate) fn on_line(
        file: &str,
        text: &str,
        at: usize,
        [line, start]: [usize; 2],
        message: String,
    ) -> Self {
        let mut at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        let (before, after) = text.split_at(at);
        let end = after.find(['\n', '\r']).map_or(text.len(), |i| at + i);
        let column = before.get(start..).unwrap_or("").chars().count() + 1;
        let skip = if column > SHOWN_CHARS * 2 / 3 {
            column - SHOWN_CHARS / 2
        } else {
            0
        };
        let shown: String = text
            .get(start..end)
            .unwrap_or("")
            .chars()
            .skip(skip)
            .take(SHOWN_CHARS)
            .map(|c| if c.is_control() { ' ' } else { c })
            .collect();
        Self {
            file: file.to_owned(),
            line,
            column,
            message,
            excerpt: shown,
            caret: column - 1 - skip,
        }
    }
}

impl fmt::Display for GrammarError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}:{}:{}: {}",
            self.file, self.line, self.column, self.message
        )?;
        if self.excerpt.trim().is_empty() {
            return Ok(()); // what is missing stands nowhere
        }
        write!(f, "\n    {}\n", self.excerpt)?;
        write!(f, "    {:width$}^", "", width = self.caret)
    }
}

/// All faults found in a grammar's text, in the order of the text; never empty.
#[derive(Clone, Debug, Default, PartialEq, Eq, Error)]
pub struct GrammarErrors {
    /// The first twenty faults.
    pub errors: Vec<GrammarError>,
    /// How many more there were.
    pub more: usize,
}

impl GrammarErrors {
    /// Whether further faults are only counted: then nobody need work out where they are.
    pub(crate) fn is_full(&self) -> bool {
        self.errors.len() >= MAX_ERRORS
    }

    pub(crate) fn push(&mut self, error: GrammarError) {
        // A name that is unknown twice in one line is one fault.
        let same = |told: &GrammarError| {
            (told.line, &told.message, &told.file) == (error.line, &error.message, &error.file)
        };
        if self.errors.iter().any(same) {
            return;
        }
        if !self.is_full() {
            self.errors.push(error);
        } else {
            self.more += 1;
        }
    }
}

impl fmt::Display for GrammarErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, error) in self.errors.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{error}")?;
        }
        if self.more > 0 {
            write!(f, "\nand {} more", self.more)?;
        }
        Ok(())
    }
}

/// Why a derivation or a drawing stopped.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DeriveProblem {
    /// The next string would pass a limit.
    #[error(
        "{} would make {modules} modules in {bytes} bytes, past the limit of {limit}; {}",
        at_step(*step),
        smaller(*step)
    )]
    Limit {
        /// The step that was not made.
        step: u32,
        /// Modules it would have made.
        modules: u64,
        /// Bytes it needs, the string before it included.
        bytes: u64,
        /// The limit.
        limit: Limit,
    },
    /// A string of which only the size is asked for has more modules than are counted.
    #[error(
        "step {step} would make more than 3.4e38 (2^128) modules, which are no longer counted; take fewer steps"
    )]
    Countless {
        /// The first such step.
        step: u32,
    },
    /// The machine did not give the memory.
    #[error(
        "{} needs {bytes} bytes, which this machine does not give; {}",
        at_step(*step),
        smaller(*step)
    )]
    Memory {
        /// The step that was not made.
        step: u32,
        /// Bytes asked for.
        bytes: u64,
    },
    /// The machine did not give the memory for the drawing.
    #[error(
        "the drawing needs memory for more than {nodes} segments, which this machine does not give; take fewer steps"
    )]
    DrawingMemory {
        /// Nodes that there is memory for.
        nodes: u64,
    },
    /// The caller's flag was set.
    #[error("cancelled in step {step}")]
    Cancelled {
        /// The step that was not finished.
        step: u32,
    },
    /// An expression had no usable value.
    #[error("step {step}, production `{production}` ({location}), module {position}: {problem}")]
    Value {
        /// The step that was not finished.
        step: u32,
        /// The production's text.
        production: String,
        /// Its file and line.
        location: String,
        /// Index of the rewritten module.
        position: u64,
        /// What went wrong.
        problem: ValueProblem,
    },
    /// A decomposition goes on past its depth.
    #[error(
        "step {step}: decomposition does not end within {depth} rounds, because of `{production}` ({location}); it may be cyclic, else raise its depth"
    )]
    Decomposition {
        /// The step that was not finished.
        step: u32,
        /// Rounds allowed.
        depth: u32,
        /// A production that would still apply.
        production: String,
        /// Its file and line.
        location: String,
    },
    /// A round of a decomposition would pass one of the limits.
    #[error(
        "step {step}: round {round} of the decomposition passes the limit of {limit}, because of `{production}` ({location}); it may be cyclic, else {}",
        smaller(*step)
    )]
    DecompositionLimit {
        /// The step that was not made.
        step: u32,
        /// The round, from 1.
        round: u32,
        /// The limit.
        limit: Limit,
        /// The first production that applied.
        production: String,
        /// Its file and line.
        location: String,
    },
    /// Brackets nest deeper than the turtle's stack may grow.
    #[error(
        "module {position}: brackets nest deeper than {depth}, which the turtle does not follow; nest fewer brackets"
    )]
    TooDeep {
        /// Index of the bracket.
        position: u64,
        /// The limit.
        depth: usize,
    },
    /// Polygons, spheres and surfaces beyond the memory.
    #[error(
        "module {position}: the drawing has no memory for more than {drawn} polygons, spheres and surfaces with their colours; take fewer steps"
    )]
    TooManyOrgans {
        /// Index of the module that draws the next.
        position: u64,
        /// Those that there is memory for.
        drawn: u64,
    },
    /// A polygon with more corners than can be cut into triangles in bounded time.
    #[error(
        "module {position}: this polygon has {corners} corners, and {most} are the most; draw it as several polygons"
    )]
    TooManyCorners {
        /// Index of its `}`.
        position: u64,
        /// Its corners.
        corners: usize,
        /// The limit.
        most: usize,
    },
    /// A position cannot be held in metres as f32.
    #[error(
        "module {position} (`{module}`): the turtle has left the range of numbers; make lengths smaller"
    )]
    TooFar {
        /// Index of the module.
        position: u64,
        /// Its name.
        module: String,
    },
    /// A width that cannot be held in metres as f32.
    #[error(
        "module {position} (`{module}`): its width of {width:e} m is larger than a tree can hold; make the `!` before it smaller"
    )]
    TooWide {
        /// Index of the module.
        position: u64,
        /// Its name.
        module: String,
        /// Its width in metres.
        width: f64,
    },
    /// A `}` without its `{`.
    #[error(
        "module {position}: this `}}` closes no outline; put its `{{` before it, in what the string holds after cuts (`%`)"
    )]
    NoOutline {
        /// Index of the brace.
        position: u64,
    },
    /// A `{` without its `}`.
    #[error(
        "module {position}: this `{{` begins an outline that is not closed; put its `}}` behind it, where no `%` cuts it off"
    )]
    OpenOutline {
        /// Index of the brace.
        position: u64,
    },
    /// More nodes than a `Tree` can index.
    #[error(
        "the drawing has more than the {limit} segments that the memory for it holds; take fewer steps"
    )]
    TooManyNodes {
        /// The limit.
        limit: u64,
    },
}

/// A limit of a derivation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Limit {
    /// Modules of a string.
    #[error("{0} modules")]
    Modules(u64),
    /// Bytes of strings and what goes with them.
    #[error("{0} bytes")]
    Bytes(u64),
}

/// What was being made: before the first step there are only the axiom and its decomposition.
fn at_step(step: u32) -> String {
    match step {
        0 => "step 0 (the axiom and its decomposition)".to_owned(),
        _ => format!("step {step}"),
    }
}

/// What makes it smaller: no step is left to leave out at step 0.
fn smaller(step: u32) -> &'static str {
    match step {
        0 => "shorten the axiom, let its decomposition end earlier",
        _ => "take fewer steps",
    }
}

/// Why an expression has no usable value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ValueProblem {
    /// `x / 0` or `x % 0`.
    #[error("division by zero")]
    DivisionByZero,
    /// Such as `sqrt(-1)`.
    #[error("a value is not a number (as the root of -1 would be)")]
    NotANumber,
    /// Beyond the range of f64, or `log(0)`.
    #[error("a value is larger than a number can be")]
    Overflow,
    /// A random draw with parameters that describe no distribution: the function, and what it wants.
    #[error("the draw `{0}` has impossible parameters: it wants {1}")]
    BadDraw(&'static str, &'static str),
    /// A weight below zero, or all of them zero.
    #[error("the weights of the matching productions are negative or all zero")]
    BadWeight,
}

/// A derivation's or drawing's end before its time, with what was whole by then.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{problem}")]
pub struct DeriveError {
    /// What happened.
    pub problem: Box<DeriveProblem>,
    /// The string after the last whole step, and that step.
    pub last: Option<Box<(u32, ModuleString)>>,
}

impl From<DeriveProblem> for DeriveError {
    fn from(problem: DeriveProblem) -> Self {
        Self {
            problem: Box::new(problem),
            last: None,
        }
    }
}

impl DeriveError {
    /// The last step whose string was made or is known to fit. (Of a large string that its graph counts, an earlier one is
    /// kept in `last`.)
    #[must_use]
    pub fn last_whole_step(&self) -> Option<u32> {
        let (kept, _) = self.last.as_deref()?;
        match *self.problem {
            DeriveProblem::Limit { step, .. } => step.checked_sub(1),
            _ => Some(*kept),
        }
    }

    /// True where the caller's flag ended it.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        matches!(*self.problem, DeriveProblem::Cancelled { .. })
    }
}

/// The name in `known` nearest to `name`, if any is near enough to be meant.
pub(crate) fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let wanted: Vec<char> = name.chars().take(40).collect();
    let mut best = None;
    // A name of one letter is like any other: only its capital is meant by it.
    let mut best_distance = (1 + wanted.len().div_ceil(3)).min(wanted.len());
    let lower = name.to_lowercase();
    for candidate in known.take(10_000) {
        let distance = match candidate.to_lowercase() == lower {
            true => 0,
            false => edit_distance(&wanted, candidate),
        };
        if distance < best_distance {
            best_distance = distance;
            best = Some(candidate);
        }
    }
    best
}

/// Whether two names differ by one letter (or two transposed ones) at most.
pub(crate) fn is_misspelt(name: &str, meant: &str) -> bool {
    let wanted: Vec<char> = name.chars().take(40).collect();
    edit_distance(&wanted, meant) <= 1
}

/// Edit distance in which two neighbouring letters that are transposed count once (optimal string alignment).
fn edit_distance(wanted: &[char], candidate: &str) -> usize {
    let mut before: Vec<usize> = Vec::new();
    let mut row: Vec<usize> = (0..=wanted.len()).collect();
    let mut last = None;
    for (i, c) in candidate.chars().take(40).enumerate() {
        let mut next = vec![i + 1];
        for (j, w) in wanted.iter().enumerate() {
            let at = |row: &[usize], place: usize| row.get(place).copied().unwrap_or(usize::MAX);
            let mut value = (at(&row, j) + usize::from(c != *w))
                .min(at(&next, j) + 1)
                .min(at(&row, j + 1) + 1);
            let transposed = last == Some(*w) && j > 0 && wanted.get(j - 1) == Some(&c);
            if transposed {
                value = value.min(at(&before, j - 1) + 1);
            }
            next.push(value);
        }
        before = std::mem::replace(&mut row, next);
        last = Some(c);
    }
    row.last().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests may fail by panic")]
    use super::*;

    #[test]
    fn caret_stands_under_the_fault() {
        let error = GrammarError::new(
            "a.lsys",
            "axiom A\nA -> F(é, xx)\n",
            8 + 11,
            "unknown".into(),
        );
        assert_eq!(
            (error.line, error.column, error.caret),
            (2, 11, 10),
            "byte 11 is the 11th character: é has two bytes"
        );
        assert_eq!(
            error.to_string(),
            "a.lsys:2:11: unknown\n    A -> F(é, xx)\n              ^",
            "layout"
        );
    }

    #[test]
    fn long_lines_are_cut_round_the_fault() {
        let text = "x".repeat(1_000_000);
        let error = GrammarError::new("a", &text, 500_000, String::new());
        assert!(error.excerpt.len() <= SHOWN_CHARS, "window");
        assert_eq!(error.column, 500_001, "column");
        assert!(error.caret < SHOWN_CHARS, "caret inside");
        let end = GrammarError::new("a", &text, 5_000_000, String::new());
        assert_eq!(end.column, 1_000_001, "past the end is the end");
    }

    #[test]
    fn nearest_names() {
        let known = ["axiom", "angle", "ignore", "r2"];
        for (name, expected) in [
            ("axoim", Some("axiom")),
            ("angel", Some("angle")),
            ("r3", Some("r2")),
            ("2r", Some("r2")),
            ("R2", Some("r2")),
            ("z", None),
            ("zebra", None),
        ] {
            assert_eq!(nearest(name, known.iter().copied()), expected, "{name}");
        }
    }
}
