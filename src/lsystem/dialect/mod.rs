//! Grammars of cpfg, L-Py and Houdini, brought over into our notation.
//!
//! A file whose first line is `dialect cpfg` (or `lpy`, `houdini`) is read through a translator: foreign text → `Model` (names,
//! rules, strings of modules with their symbols as the program calls them) → text in our notation, in which every word knows
//! its place in the foreign text. The text is then parsed like any other, so that there is one parser and one engine, and its
//! faults are told at the foreign file, line and column. `ramus import` writes the same text to a file.
//!
//! What our turtle does otherwise is said with other symbols (`meaning`): cpfg rolls the other way, Houdini turns the other way, L-Py's widths are
//! radii. Symbols with no counterpart stay in the string as declared modules, so that it is the same string, and are named as *not
//! carried over*. What would change the string is a fault.
//!
//! Tried and rejected: a parser of its own for each program (three languages to keep true), and running the foreign text's code.

mod cpfg;
mod emit;
mod expression;
mod functions;
mod houdini;
mod lpy;
mod meaning;
mod model;
mod preprocess;
mod python;

mod reader;
mod statements;
mod text;
mod words;

use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

use super::error::{GrammarError, GrammarErrors};
use super::include::folder_of;
use super::parse;
use super::source::Source;
use model::Model;
pub(crate) use text::Origin;
use text::{Foreign, MAX_FOREIGN_BYTES};

/// A program whose grammars can be brought over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    /// cpfg of the Virtual Laboratory (VLAB, L-studio).
    Cpfg,
    /// L-Py of OpenAlea.
    Lpy,
    /// The L-System node of Houdini: its rules and parameters as text.
    Houdini,
}

impl Dialect {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Cpfg, Self::Lpy, Self::Houdini];

    /// The word after `dialect`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Cpfg => "cpfg",
            Self::Lpy => "lpy",
            Self::Houdini => "houdini",
        }
    }

    /// The dialect that a file's ending tells: `.l` is cpfg's, `.lpy` L-Py's.
    #[must_use]
    pub fn of_ending(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()? {
            "l" => Some(Self::Cpfg),
            "lpy" => Some(Self::Lpy),
            _ => None,
        }
    }
}

impl fmt::Display for Dialect {
    /// The program's name.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cpfg => "cpfg",
            Self::Lpy => "L-Py",
            Self::Houdini => "Houdini",
        })
    }
}

impl FromStr for Dialect {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|d| d.word() == word);
        found.ok_or_else(|| format!("`{word}` is no dialect; expected `cpfg`, `lpy` or `houdini`"))
    }
}

/// Something that a grammar says and that has no counterpart here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is not carried over, and what that means for the drawing.
    pub message: String,
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            file,
            line,
            column,
            message,
        } = self;
        write!(f, "{file}:{line}:{column}: not carried over: {message}")
    }
}

/// A grammar of another program in our notation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Imported {
    /// A grammar file.
    pub text: String,
    /// What could not be carried over and does not change the string.
    pub remarks: Vec<Remark>,
}

/// Brings a grammar over. `file` is the name for messages and, where it is a file, the folder of its includes.
///
/// # Errors
/// Faults in the text, and what cannot be carried over and would change the string, at their places in the foreign text.
pub fn import(text: &str, file: &str, dialect: Dialect) -> Result<Imported, GrammarErrors> {
    let source = Source::new(file.to_owned(), text.to_owned());
    let (source, remarks) = translate(source, dialect)?;
    let written = source.text.clone();
    parse::of_source(source, Vec::new())?;
    Ok(Imported {
        text: written,
        remarks,
    })
}

/// The dialect of another program that a text's first statement names.
#[must_use]
pub fn named(text: &str) -> Option<Dialect> {
    told(text).map(|told| told.0)
}

/// The same with that line.
fn told(text: &str) -> Option<(Dialect, Range<usize>)> {
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let start = at;
        at += line.len();
        let code = line
            .trim_start_matches('\u{feff}')
            .split('#')
            .next()
            .unwrap_or("")
            .trim();
        if code.is_empty() {
            continue;
        }
        let word = code.strip_prefix("dialect")?;
        let dialect = word
            .strip_prefix(char::is_whitespace)?
            .trim()
            .parse()
            .ok()?;
        return Some((dialect, start..start + line.trim_end().len()));
    }
    None
}

/// The text with blanks in place of the line that tells the dialect, so that all else stands where it stood.
fn without_dialect(text: &str) -> String {
    let Some((_, line)) = told(text) else {
        return text.to_owned();
    };
    let before = text.get(..line.start).unwrap_or("");
    let after = text.get(line.end..).unwrap_or("");
    format!("{before}{}{after}", " ".repeat(line.len()))
}

/// A file as the parser takes it: in our notation, whatever dialect it names.
///
/// # Errors
/// What [`import`] says.
pub(crate) fn opened(source: Source) -> Result<(Source, Vec<Remark>), GrammarErrors> {
    match told(&source.text) {
        None => Ok((source, Vec::new())),
        Some((dialect, _)) => translate(source, dialect),
    }
}

fn translate(source: Source, dialect: Dialect) -> Result<(Source, Vec<Remark>), GrammarErrors> {
    let mut faults = GrammarErrors::default();
    let name = source.name.clone();
    if source.text.len() > MAX_FOREIGN_BYTES {
        let message = format!(
            "this file has {} bytes of text; at most {MAX_FOREIGN_BYTES} are read of {dialect}'s",
            source.text.len()
        );
        faults.push(source.error(0, message));
        return Err(faults);
    }
    let folder = folder_of(&name);
    let text = without_dialect(&source.text);
    let foreign = match dialect {
        Dialect::Cpfg => preprocess::preprocess(source, &text, folder.as_deref(), &mut faults),
        Dialect::Lpy | Dialect::Houdini => Foreign::of(source, &text),
    };
    let mut model = Model::new(dialect);
    match dialect {
        Dialect::Cpfg => cpfg::read(&foreign.text, &mut model),
        Dialect::Lpy => lpy::read(&foreign.text, &mut model),
        Dialect::Houdini => houdini::read(&foreign.text, &mut model),
    }
    let written = emit::written(&mut model);
    // Where a fault stands is worked out for those that are shown.
    model.faults.sort_by_key(|fault| fault.at);
    for fault in model.faults {
        if faults.is_full() {
            faults.more += 1;
        } else {
            faults.push(foreign.error(fault.at, fault.message));
        }
    }
    if !faults.errors.is_empty() {
        return Err(faults);
    }
    let remarks = model
        .remarks
        .into_iter()
        .map(|fault| {
            let place: GrammarError = foreign.error(fault.at, fault.message);
            Remark {
                file: place.file,
                line: place.line,
                column: place.column,
                message: place.message,
            }
        })
        .collect();
    let (text, origin) = written.finish(foreign);
    Ok((Source::translated(name, text, origin), remarks))
}
