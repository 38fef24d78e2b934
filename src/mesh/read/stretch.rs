//! A part of a file that is in memory, or is not and is read where it is needed.
//!
//! To copy a large file into memory and to take it from there again is most of the time of reading plain numbers. So where a file's start says where all else
//! stands, each thread reads what it needs, some at once, into bytes of its own, which stay in the nearer caches. *Tried*: pieces as long as
//! a block of rows ([`made`](super::made)): so many calls of the system take what is won.

use std::fs::File;
use std::sync::atomic::AtomicBool;

/// Bytes that are read at once.
const WINDOW: usize = 64 << 10;

/// What a thread has last read of a file, or decoded: most often the next bytes are among them.
#[derive(Default)]
pub(super) struct Window {
    /// Where they stand in the file; none where they are others.
    at: Option<u64>,
    bytes: Vec<u8>,
}

impl Window {
    /// Room for other bytes than the file's.
    pub(super) fn room(&mut self, length: usize) -> &mut [u8] {
        self.at = None;
        self.bytes.resize(length, 0);
        &mut self.bytes
    }

    /// Where bytes are among those that are here.
    fn place(&self, at: u64, length: usize) -> Option<usize> {
        let place = usize::try_from(at.checked_sub(self.at?)?).ok()?;
        (place.checked_add(length)? <= self.bytes.len()).then_some(place)
    }

    /// So many bytes of a file; none where they cannot be read.
    fn read(&mut self, file: &File, at: u64, length: usize) -> Option<&[u8]> {
        let place = self.place(at, length).or_else(|| {
            let never = AtomicBool::new(false);
            let room = self.room(WINDOW.max(length));
            let filled = super::fill(file, at, room, &never).ok()?;
            self.bytes.truncate(filled);
            self.at = Some(at);
            self.place(at, length)
        })?;
        self.bytes.get(place..place + length)
    }
}

/// A part of a file.
#[derive(Clone, Copy)]
pub(super) enum Stretch<'a> {
    Read(&'a [u8]),
    /// From a byte on, so many.
    Unread(&'a File, u64, usize),
}

impl<'a> Stretch<'a> {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Read(bytes) => bytes.len(),
            Self::Unread(_, _, length) => *length,
        }
    }

    /// What is behind so many bytes.
    pub(super) fn behind(self, passed: usize) -> Option<Self> {
        Some(match self {
            Self::Read(bytes) => Self::Read(bytes.get(passed..)?),
            Self::Unread(file, at, length) => {
                Self::Unread(file, at + passed as u64, length.checked_sub(passed)?)
            }
        })
    }

    /// So many bytes from one on, in `window` where they have to be read; none where they are not there, or not any more.
    pub(super) fn get<'s>(
        &self,
        from: usize,
        length: usize,
        window: &'s mut Window,
    ) -> Option<&'s [u8]>
    where
        'a: 's,
    {
        let end = from.checked_add(length)?;
        match self {
            Self::Read(bytes) => bytes.get(from..end),
            Self::Unread(file, at, most) => {
                let is_there = end <= *most;
                let at = at.checked_add(from as u64).filter(|_| is_there)?;
                window.read(file, at, length)
            }
        }
    }
}
