//! Recorded sessions: what a headset said in each frame, as text that a person can read and edit.
//!
//! A `.session` file is a header line and then, for each frame, a line `frame TIME` followed by one
//! line for each part that differs from the frame before. So a still hand costs nothing, a diff of two
//! sessions shows what a person did differently, and a test can be written by hand. The whole format
//! is described in `docs/src/session-format.md`.
//!
//! Numbers are printed as the shortest text that reads back to the same bits, so writing and reading
//! is exact, and the same frames always give the same bytes. (Quaternions are made unit as they are read: a
//! person may write four decimals, and nobody behind the reader need care.) Binary was rejected: a minute of a real
//! session is a few megabytes of text, and text is what makes recorded sessions worth keeping in a
//! repository.
//!
//! The reader streams ([`SessionReader`] is an iterator over frames) and is bounded everywhere: length of a
//! line, number of frames, range of every value. A file from anywhere ends in an error, never in a crash.

mod reader;
mod writer;

use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};

pub use reader::SessionReader;
pub use writer::SessionWriter;

use crate::frame::{Frame, FrameFault, LONGEST_STEP, Pose, View};

/// First word of every session file.
const MAGIC: &str = "ramus-session";

/// The version of the format that is written, and the only one that is read.
pub const VERSION: u32 = 1;

/// Most frames of one session: an hour and a half at 90 a second.
pub const MAX_FRAMES: usize = 500_000;

/// Longest line in bytes; the longest that is ever written has about 200.
pub const MAX_LINE: usize = 512;

/// Slack of the longest step in seconds, for times that were computed as `n * 0.1`.
const STEP_SLACK: f64 = 1e-6;

/// Left and right as the files write them.
const SIDES: [&str; 2] = ["left", "right"];

/// A session could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The file could not be opened.
    #[error("cannot open the session {path}: {source}", path = path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Reading or writing failed.
    #[error("cannot read or write the session: {0}")]
    Io(#[from] io::Error),
    /// The text is not a session.
    #[error("session line {line}, column {column}: {message}")]
    Syntax {
        /// Counted from 1.
        line: u64,
        /// Byte of the line, counted from 1.
        column: usize,
        /// What is wrong and what would be right.
        message: String,
    },
    /// A frame that no headset can mean was to be written.
    #[error("frame {frame} of the session cannot be written: {fault}")]
    Fault {
        /// Counted from 1.
        frame: usize,
        /// What is wrong with it.
        fault: FrameFault,
    },
    /// A frame came before its predecessor or too long after it.
    #[error(
        "frame {frame} of the session cannot be written: its time must follow the one before by 0 to 0.1 s"
    )]
    Time {
        /// Counted from 1.
        frame: usize,
    },
    /// The session would have more than [`MAX_FRAMES`].
    #[error("the session is longer than {MAX_FRAMES} frames: record it in parts")]
    TooLong,
}

/// Reads a whole session file.
///
/// # Errors
/// [`SessionError`] where the file cannot be opened or is not a session.
pub fn read_file(path: &Path) -> Result<Vec<Frame>, SessionError> {
    let file = File::open(path).map_err(|source| SessionError::Open {
        path: path.to_owned(),
        source,
    })?;
    SessionReader::new(BufReader::new(file))?.collect()
}

/// The comments of a session file before its first frame, 4096 lines of it at most, without their sign; what cannot be read
/// ends them.
#[must_use]
pub fn first_comments(path: &Path) -> Vec<String> {
    const MOST: usize = 4096;
    let Ok(file) = File::open(path) else {
        return Vec::new();
    };
    let bytes = (MOST * MAX_LINE) as u64;
    let lines = BufReader::new(file.take(bytes)).lines().skip(1).take(MOST);
    lines
        .map_while(Result::ok)
        .take_while(|line| !line.starts_with("frame"))
        .filter_map(|line| Some(line.strip_prefix('#')?.trim().to_owned()))
        .collect()
}

/// Reads a whole session from memory.
///
/// # Errors
/// [`SessionError`] where the bytes are not a session.
pub fn from_bytes(bytes: &[u8]) -> Result<Vec<Frame>, SessionError> {
    SessionReader::new(bytes)?.collect()
}

/// Writes a whole session.
///
/// # Errors
/// [`SessionError`] where a frame is not sane or times do not follow each other.
pub fn to_bytes(frames: &[Frame]) -> Result<Vec<u8>, SessionError> {
    let mut writer = SessionWriter::new(Vec::new())?;
    for frame in frames {
        writer.write(frame)?;
    }
    writer.finish()
}

/// Whether a frame at `time` may follow one at `before`.
fn follows(before: f64, time: f64) -> bool {
    time >= before && time - before <= LONGEST_STEP + STEP_SLACK
}

/// How a session says where an eye is.
#[derive(Clone, Copy, Debug)]
enum Eye {
    /// Fixed to the head.
    Relative(View),
    /// In the stage's frame.
    Absolute(View),
}

impl Eye {
    /// The view that this means while the head is at `head`.
    fn view(self, head: Pose) -> View {
        match self {
            Self::Relative(eye) => View {
                pose: head * eye.pose,
                fov: eye.fov,
            },
            Self::Absolute(view) => view,
        }
    }
}

#[cfg(test)]
mod tests;
