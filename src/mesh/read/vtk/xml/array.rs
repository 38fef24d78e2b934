//! The numbers of an array, wherever and however they stand.
//!
//! Before binary arrays stands their length: in bytes where they are plain, else the lengths of all blocks. So it is known how many
//! numbers there are before memory is taken for them; a file that announces more than it holds is refused by then.

use std::borrow::Cow;
use std::fs::File;

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use rayon::prelude::*;

use super::super::super::numerals::{self, Value};
use super::super::super::stretch::{Stretch, Window};
use super::super::super::{Stop, Task};
use super::super::number::{self, Kind, NUMBERS, Plain};
use super::blocks::{self, Blocks};
use super::document::{Array, Document, Place};

/// Base64 as VTK writes it; the last bits of a last letter are no matter.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Letters of base64 that are looked at for ends of lines: others than VTK cut it into lines of about 76.
const LINE: usize = 4096;

/// Finds arrays in a file.
pub(super) struct Arrays<'a> {
    bytes: &'a [u8],
    /// The file that begins with these and goes on to a length; else they are all.
    file: Option<(&'a File, usize)>,
    document: &'a Document,
    task: &'a Task<'a>,
    /// Bytes of the file that the arrays so far stand in.
    taken: usize,
}

/// An array that is there whole, as far as its lengths tell.
pub(super) struct Stored<'a> {
    /// What faults are told of.
    at: usize,
    kind: Kind,
    is_big: bool,
    form: Form<'a>,
}

enum Form<'a> {
    /// Up to a byte of the file, from another on.
    Text(&'a [u8], usize),
    Plain(Bytes<'a>),
    Blocks(Bytes<'a>, Blocks),
}

/// Bytes that may stand there as base64.
pub(super) enum Bytes<'a> {
    Raw(Stretch<'a>),
    Base64 {
        text: Cow<'a, [u8]>,
        /// Bytes at the start that are passed over.
        skipped: usize,
    },
}

impl<'a> Bytes<'a> {
    /// As many bytes from one on as there are, up to a length. `window` keeps what has to be read or decoded.
    fn get<'s>(&'s self, from: usize, length: usize, window: &'s mut Window) -> Option<&'s [u8]> {
        match self {
            Bytes::Raw(bytes) => bytes.get(from, length, window),
            Bytes::Base64 { text, skipped } => {
                let from = from.checked_add(*skipped)?;
                let end = from.checked_add(length)?;
                // Four letters are three bytes.
                let letters = from / 3 * 4..end.div_ceil(3).checked_mul(4)?.min(text.len());
                let text = text.get(letters)?;
                let room = window.room(text.len().div_ceil(4) * 3);
                let decoded = BASE64.decode_slice(text, room).ok()?;
                let first = from % 3;
                room.get(..decoded)?.get(first..first + length)
            }
        }
    }

    /// What stands behind a header of so many bytes. Headers of blocks are base64 by themselves, others together with what follows (but
    /// some programs part these, too, which padding tells).
    fn behind(self, header: usize, is_apart: bool) -> Option<Self> {
        let text = match self {
            Bytes::Raw(bytes) => return bytes.behind(header).map(Bytes::Raw),
            Bytes::Base64 { text, .. } => text,
        };
        let letters = header.div_ceil(3) * 4;
        let is_padded = text.get(letters.saturating_sub(1)) == Some(&b'=');
        if !is_apart && !is_padded {
            let skipped = header;
            return Some(Bytes::Base64 { text, skipped });
        }
        let text = match text {
            Cow::Borrowed(text) => Cow::Borrowed(text.get(letters..)?),
            Cow::Owned(mut text) => {
                drop(text.drain(..letters.min(text.len())));
                Cow::Owned(text)
            }
        };
        Some(Bytes::Base64 { text, skipped: 0 })
    }

    /// Bytes that there may be at most.
    fn most(&self) -> usize {
        match self {
            Bytes::Raw(bytes) => bytes.len(),
            Bytes::Base64 { text, skipped } => {
                (text.len().div_ceil(4) * 3).saturating_sub(*skipped)
            }
        }
    }
}

impl<'a> Arrays<'a> {
    pub(super) fn new(
        bytes: &'a [u8],
        file: Option<(&'a File, usize)>,
        document: &'a Document,
        task: &'a Task<'a>,
    ) -> Self {
        Self {
            bytes,
            file,
            document,
            task,
            taken: 0,
        }
    }

    /// Finds an array that should hold so many numbers.
    pub(super) fn find(&mut self, array: &Array, count: usize) -> Result<Stored<'a>, Stop> {
        self.task.go_on()?;
        let (form, taken) = match array.place {
            _ if count == 0 => (Form::Plain(Bytes::Raw(Stretch::Read(&[]))), 0),
            Place::Text(from, end) => {
                let text = self.bytes.get(..end).unwrap_or(self.bytes);
                // A digit and a blank each.
                if count > (end - from).div_ceil(2) {
                    return Err(too_few(array.at, count, "fewer"));
                }
                (Form::Text(text, from), end - from)
            }
            _ => self.binary(array, count)?,
        };
        // Arrays that stand in the same bytes would make much of little.
        self.taken = self.taken.saturating_add(taken);
        if self.taken > self.file.map_or(self.bytes.len(), |(_, length)| length) {
            let problem = "begins an array that shares its bytes with others: save the file again";
            return Err(Stop::fault(array.at, problem));
        }
        Ok(Stored {
            at: array.at,
            kind: array.kind,
            is_big: self.document.is_big,
            form,
        })
    }

    /// Finds a binary array, and how many bytes of the file it stands in.
    fn binary(&self, array: &Array, count: usize) -> Result<(Form<'a>, usize), Stop> {
        let cut_short = || {
            let problem = "begins an array that goes on behind the end of its bytes, or is no base64: the file is cut short or damaged, save it again";
            Stop::fault(array.at, problem)
        };
        let bytes = self.bytes_of(array).ok_or_else(cut_short)?;
        let length = count.saturating_mul(array.kind.bytes());
        let Some(compressor) = self.document.compressor else {
            let header = self.words(&bytes, 1).ok_or_else(cut_short)?;
            let found = header.first().copied().unwrap_or(0);
            if found != length {
                let numbers = found / array.kind.bytes();
                return Err(too_few(array.at, count, &numbers.to_string()));
            }
            let bytes = bytes.behind(self.word(), false);
            let bytes = bytes.filter(|bytes| bytes.most() >= length);
            return Ok((Form::Plain(bytes.ok_or_else(cut_short)?), length));
        };
        let header = self.words(&bytes, 1).ok_or_else(cut_short)?;
        let blocks = header.first().copied().unwrap_or(0);
        let header = blocks.checked_add(3).ok_or_else(cut_short)?;
        let words = self.words(&bytes, header).ok_or_else(cut_short)?;
        let blocks = Blocks::new(array.at, &words, compressor, array.kind.bytes(), length)?;
        let stored = blocks.stored();
        let bytes = bytes.behind(header * self.word(), true);
        let bytes = bytes.filter(|bytes| bytes.most() >= stored);
        Ok((Form::Blocks(bytes.ok_or_else(cut_short)?, blocks), stored))
    }

    /// All that stands in the file from a binary array on.
    fn bytes_of(&self, array: &Array) -> Option<Bytes<'a>> {
        let (text, skipped) = match array.place {
            Place::Appended(offset) => {
                let appended = self.document.appended?;
                if let Some((file, length)) = self.file {
                    let from = appended.at.checked_add(offset)?;
                    let rest = length.checked_sub(from)?;
                    return Some(Bytes::Raw(Stretch::Unread(file, from as u64, rest)));
                }
                let rest = self.bytes.get(appended.at.checked_add(offset)?..)?;
                if !appended.is_base64 {
                    return Some(Bytes::Raw(Stretch::Read(rest)));
                }
                (Cow::Borrowed(rest), 0)
            }
            Place::Text(from, end) | Place::Base64(from, end) => {
                (unbroken(self.bytes.get(from..end)?.trim_ascii()), 0)
            }
        };
        Some(Bytes::Base64 { text, skipped })
    }

    /// Length of a number in headers.
    fn word(&self) -> usize {
        if self.document.has_long_headers { 8 } else { 4 }
    }

    /// So many numbers of a header.
    fn words(&self, bytes: &Bytes<'_>, count: usize) -> Option<Vec<usize>> {
        let word = self.word();
        let length = count.checked_mul(word)?;
        // Before memory is taken.
        if bytes.most() < length {
            return None;
        }
        let mut window = Window::default();
        let header = bytes.get(0, length, &mut window)?;
        let words = header.chunks_exact(word).map(|word| {
            let value = number_of(word, self.document.is_big);
            usize::try_from(value).unwrap_or(usize::MAX)
        });
        Some(words.collect())
    }
}

/// Base64 without the ends of lines that may part it.
fn unbroken(text: &[u8]) -> Cow<'_, [u8]> {
    let head = &text[..text.len().min(LINE)];
    if !head.iter().any(u8::is_ascii_whitespace) {
        return Cow::Borrowed(text);
    }
    let letters = text.iter().copied();
    Cow::Owned(
        letters
            .filter(|letter| !letter.is_ascii_whitespace())
            .collect(),
    )
}

/// The number of a header.
fn number_of(word: &[u8], is_big: bool) -> u64 {
    let step = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
    match is_big {
        true => word.iter().fold(0, step),
        false => word.iter().rev().fold(0, step),
    }
}

fn too_few(at: usize, count: usize, found: &str) -> Stop {
    let problem = format!(
        "begins an array of {found} numbers where {count} are needed by what is announced: the file is damaged, save it again"
    );
    Stop::fault(at, problem)
}

impl Stored<'_> {
    /// So many numbers where they stand in the file as they are.
    pub(super) fn as_it_is(&self, count: usize) -> Option<Plain<'_>> {
        let Form::Plain(Bytes::Raw(bytes)) = &self.form else {
            return None;
        };
        let bytes = *bytes;
        (count.checked_mul(self.kind.bytes())? <= bytes.len()).then_some(())?;
        Some(Plain {
            bytes,
            kind: self.kind,
            is_big: self.is_big,
            at: self.at,
            is_placed: false,
        })
    }

    /// Reads all its numbers.
    pub(super) fn read<V: Value>(&self, to: &mut [V], task: &Task<'_>) -> Result<(), Stop> {
        match &self.form {
            Form::Text(text, from) => {
                let end = numerals::read(text, *from, to, task)?;
                let rest = text.get(end..).unwrap_or_default().trim_ascii();
                if rest.is_empty() {
                    return Ok(());
                }
                Err(too_few(self.at, to.len(), "more"))
            }
            Form::Plain(bytes) => self.plain(bytes, to, task),
            Form::Blocks(bytes, blocks) => {
                let word = self.kind.bytes();
                let scratch = blocks::Scratch::default;
                let chunks = to.par_chunks_mut(blocks.length / word).enumerate();
                chunks.try_for_each_init(scratch, |scratch, (block, to)| {
                    task.go_on()?;
                    let (from, stored) = blocks.place(block);
                    let blocks::Scratch {
                        stored: decoded,
                        whole,
                        inflate,
                    } = scratch;
                    let packed = bytes.get(from, stored, decoded);
                    let is_whole = packed.is_some_and(|packed| {
                        whole.resize(to.len() * word, 0);
                        blocks::unpack(blocks.compressor, inflate, packed, whole)
                    });
                    if !is_whole {
                        let problem = format!(
                            "begins an array of which block {block} does not hold what is announced: the file is damaged, save it again"
                        );
                        return Err(Stop::fault(self.at, problem));
                    }
                    self.fill(whole, to)
                })
            }
        }
    }

    /// Numbers that stand there as they are, or as base64.
    fn plain<V: Value>(
        &self,
        bytes: &Bytes<'_>,
        to: &mut [V],
        task: &Task<'_>,
    ) -> Result<(), Stop> {
        let word = self.kind.bytes();
        let chunks = to.par_chunks_mut(NUMBERS).enumerate();
        chunks.try_for_each_init(Window::default, |window, (chunk, to)| {
            task.go_on()?;
            let from = chunk * NUMBERS * word;
            let Some(bytes) = bytes.get(from, to.len() * word, window) else {
                let problem = "begins an array that is cut short or no base64: save the file again";
                return Err(Stop::fault(self.at, problem));
            };
            self.fill(bytes, to)
        })
    }

    fn fill<V: Value>(&self, bytes: &[u8], to: &mut [V]) -> Result<(), Stop> {
        number::fill(bytes, self.kind, self.is_big, to).map_err(|place| {
            let from = place * self.kind.bytes();
            let rest = bytes.get(from..).unwrap_or_default();
            V::refused(self.at, number::shown(rest, self.kind, self.is_big))
        })
    }
}
