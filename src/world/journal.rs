//! The journal: every action as one line of text, so that a killed session can be repeated.
//!
//! The app appends a line after each action; this module only turns actions into lines and lines
//! into actions. A line carries its number and a checksum over itself and all lines before it, and
//! the header holds the whole project that the actions start from, and its hash. So a line that was
//! half written when the power went is dropped, damage in the middle ends the reading there, and
//! lines of another project are never replayed on this one.
//!
//! The header holds the project, not only its name, because the actions of a session may go back
//! behind the last save: *undo* after a save undoes what was done before it. So one journal goes on
//! from the start of a session to its end, over all saves, and [`recover`] needs nothing else.
//!
//! ```text
//! {"format":"ramus-journal","version":1,"base":"8f1c…","project":{…}}
//! {"n":1,"check":"03ab…","do":{"edit":{"add-segment":{"to":[0.0,0.2,0.0]}}}}
//! {"n":2,"check":"77e0…","do":"undo"}
//! ```
//!
//! The checksum is FNV-1a: it is against accidents, not against forgery.

use serde::Deserialize;

use super::{
    document::Document,
    history::{Action, History},
    project,
};

const FORMAT: &str = "ramus-journal";
const VERSION: u64 = 1;
/// Largest journal read, bytes.
const MAX_BYTES: usize = 256 << 20;

/// Why a journal cannot be used at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JournalError {
    /// Larger than any journal.
    #[error(
        "this journal is {0} bytes long, and none is read beyond {MAX_BYTES}: move it away to go on without it"
    )]
    TooLarge(usize),
    /// Nothing in it yet: the header was not finished.
    #[error("this journal holds no finished line, so there is nothing to recover")]
    Empty,
    /// Some other file.
    #[error(
        "this is no Ramus journal, or its first line is damaged: nothing can be recovered from it"
    )]
    NotAJournal,
    /// Of a later program.
    #[error("this journal has format version {0}, and Ramus {ours} reads version {VERSION}: recover it with the program that wrote it", ours = env!("CARGO_PKG_VERSION"))]
    Version(u64),
}

/// What every version's header has.
#[derive(Deserialize)]
struct Head {
    format: String,
    version: u64,
}

#[derive(Deserialize)]
struct HeaderV1 {
    project: serde_json::Value,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    #[serde(rename = "n")]
    _number: u64,
    #[serde(rename = "check")]
    _check: String,
    r#do: Action,
}

/// Writes lines in order. Begin one when a session begins and go on with it until the session ends:
/// saving the project does not end it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Journal {
    /// The number of the next line, from 1.
    next: u64,
    /// Checksum over the header and all lines so far.
    chain: u64,
}

impl Journal {
    /// A journal that starts from `base`, the first document of the history whose actions follow,
    /// and its header line with the line end.
    #[must_use]
    pub fn begin(base: &Document) -> (Self, String) {
        let bytes = project::to_bytes(base);
        // No string of a project holds a line end, so taking the indents off leaves the same JSON.
        let text = String::from_utf8_lossy(&bytes);
        let project: String = text.lines().map(str::trim_start).collect();
        let base = fnv1a64(FNV_OFFSET, &bytes);
        let header = format!(
            "{{\"format\":\"{FORMAT}\",\"version\":{VERSION},\"base\":\"{base:016x}\",\"project\":{project}}}\n"
        );
        (
            Self {
                next: 1,
                chain: base,
            },
            header,
        )
    }

    /// The line of one action, with its line end. Write it as a whole, in this order.
    pub fn line(&mut self, action: &Action) -> String {
        let json = serde_json::to_string(action).unwrap_or_default();
        let (number, check) = (self.next, self.check(&json));
        self.next += 1;
        self.chain = check;
        format!("{{\"n\":{number},\"check\":\"{check:016x}\",\"do\":{json}}}\n")
    }

    fn check(&self, json: &str) -> u64 {
        let hash = fnv1a64(self.chain, &self.next.to_le_bytes());
        fnv1a64(hash, json.as_bytes())
    }
}

/// A journal that was read as far as it is whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Decoded {
    /// The project that the actions start from.
    pub project: Document,
    /// The actions, in order.
    pub actions: Vec<Action>,
    /// How many bytes of the file are whole: cut it here before going on with `journal`.
    pub whole_bytes: usize,
    /// The writer that goes on after the last whole line.
    pub journal: Journal,
    /// Where and how the reading ended early.
    pub damage: Option<Damage>,
}

/// What was left out of a journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Damage {
    /// The last line was being written when the session ended.
    #[error("the last action was not finished and is left out; {recovered} were recovered")]
    Torn {
        /// Actions before it.
        recovered: usize,
    },
    /// A line in the middle is wrong.
    #[error(
        "the journal is damaged in line {line}: {recovered} actions before it were recovered, {lost} lines from there on are lost"
    )]
    Broken {
        /// Line in the file, from 1.
        line: usize,
        /// Actions before it.
        recovered: usize,
        /// Lines from the damaged one on.
        lost: usize,
    },
}

/// Reads a journal as far as it is whole.
///
/// # Errors
/// Where not even the header can be read; never a panic, whatever the bytes.
pub fn decode(bytes: &[u8]) -> Result<Decoded, JournalError> {
    if bytes.len() > MAX_BYTES {
        return Err(JournalError::TooLarge(bytes.len()));
    }
    let mut lines = bytes.split_inclusive(|&byte| byte == b'\n');
    let first = lines
        .next()
        .filter(|line| line.ends_with(b"\n"))
        .ok_or(JournalError::Empty)?;
    let (journal, project) = read_header(first)?;
    let mut decoded = Decoded {
        project,
        actions: Vec::new(),
        whole_bytes: first.len(),
        journal,
        damage: None,
    };
    while let Some(line) = lines.next() {
        let recovered = decoded.actions.len();
        let mut journal = decoded.journal.clone();
        // A line is whole when writing its action again gives the same bytes, checksum and all.
        let action = serde_json::from_slice::<Line>(line)
            .ok()
            .map(|line| line.r#do)
            .filter(|action| journal.line(action).as_bytes() == line);
        match action {
            Some(action) => decoded.actions.push(action),
            None => {
                let rest = lines.count();
                decoded.damage = Some(if rest == 0 && !line.ends_with(b"\n") {
                    Damage::Torn { recovered }
                } else {
                    Damage::Broken {
                        line: recovered + 2,
                        recovered,
                        lost: rest + 1,
                    }
                });
                break;
            }
        }
        decoded.journal = journal;
        decoded.whole_bytes += line.len();
    }
    Ok(decoded)
}

/// The project in the header, and the writer that goes on behind it.
fn read_header(line: &[u8]) -> Result<(Journal, Document), JournalError> {
    let head: Head = serde_json::from_slice(line).map_err(|_| JournalError::NotAJournal)?;
    if head.format != FORMAT {
        return Err(JournalError::NotAJournal);
    }
    if head.version != VERSION {
        return Err(JournalError::Version(head.version));
    }
    let header: HeaderV1 = serde_json::from_slice(line).map_err(|_| JournalError::NotAJournal)?;
    let project = serde_json::to_vec(&header.project).unwrap_or_default();
    let project = project::from_bytes(&project).map_err(|_| JournalError::NotAJournal)?;
    // As for every line: it is whole when writing it again gives the same bytes.
    let (journal, again) = Journal::begin(&project);
    if again.as_bytes() != line {
        return Err(JournalError::NotAJournal);
    }
    Ok((journal, project))
}

/// What a journal brought back.
#[derive(Clone, Debug)]
pub struct Recovered {
    /// The document with its undo history since the base.
    pub history: History,
    /// Actions repeated.
    pub actions: usize,
    /// What the person should be told, where not everything came back.
    pub message: Option<String>,
}

/// Repeats a journal's actions on the project it starts from. The history's log is empty afterwards:
/// what is in the journal need not be written again.
#[must_use]
pub fn recover(decoded: &Decoded) -> Recovered {
    let mut history = History::new(decoded.project.clone());
    let mut message = decoded.damage.map(|damage| damage.to_string());
    let mut actions = 0;
    for action in &decoded.actions {
        if let Err(error) = history.repeat(action.clone()) {
            let lost = decoded.actions.len() - actions;
            message = Some(format!(
                "the journal's action {} cannot be repeated ({error}): {actions} actions before it were recovered, {lost} are lost",
                actions + 1
            ));
            break;
        }
        actions += 1;
    }
    history.take_log();
    Recovered {
        history,
        actions,
        message,
    }
}

const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01b3;

fn fnv1a64(start: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(start, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(FNV_PRIME)
    })
}
