//! Arrays in compressed blocks: each is inflated by itself into as many bytes as are announced for it, and not one more.

use zlib_rs::{Inflate, InflateFlush, Status};

use super::super::super::Stop;
use super::super::super::stretch::Window;
use super::document::Compressor;

/// Bits of the window that zlib may look back in: the largest.
const WINDOW_BITS: u8 = 15;

/// How many bytes a compressed one may stand for at most, beside some for each block.
const ZLIB_MOST: usize = 1032;
const LZ4_MOST: usize = 255;
/// Bytes that a block may stand for whatever its length is.
const SPARE: usize = 64;

/// Where the blocks of an array stand.
pub(super) struct Blocks {
    pub(super) compressor: Compressor,
    /// Length of each but the last, uncompressed.
    pub(super) length: usize,
    /// Where each begins, and where the last ends.
    starts: Vec<usize>,
}

/// What a thread unpacks blocks with.
#[derive(Default)]
pub(super) struct Scratch {
    /// As they are stored.
    pub(super) stored: Window,
    pub(super) whole: Vec<u8>,
    pub(super) inflate: Option<Inflate>,
}

impl Blocks {
    /// The blocks that a header tells of, its numbers given: how many there are, their length and that of the last (0 where it is no
    /// shorter), and their compressed lengths. They are to make so many bytes.
    pub(super) fn new(
        at: usize,
        header: &[usize],
        compressor: Compressor,
        number: usize,
        bytes: usize,
    ) -> Result<Self, Stop> {
        let [count, length, last, stored @ ..] = header else {
            return Err(Stop::fault(
                at,
                "begins an array without the lengths of its blocks: save the file again",
            ));
        };
        let whole = match (*count, *last) {
            (0, _) => Some(0),
            (count, 0) => count.checked_mul(*length),
            (count, last) => (count - 1)
                .checked_mul(*length)
                .and_then(|all| all.checked_add(last)),
        };
        if whole != Some(bytes) || *last > *length {
            let problem = format!(
                "begins an array of blocks that do not make the {bytes} bytes which are needed by what is announced: the file is damaged, save it again"
            );
            return Err(Stop::fault(at, problem));
        }
        if *count > 1 && length % number != 0 {
            let problem = format!(
                "begins an array of blocks of {length} bytes, which end amid numbers: save the file again"
            );
            return Err(Stop::fault(at, problem));
        }
        let most = match compressor {
            Compressor::Zlib => ZLIB_MOST,
            Compressor::Lz4 => LZ4_MOST,
        };
        let mut starts = Vec::with_capacity(stored.len() + 1);
        let mut end = 0_usize;
        starts.push(end);
        for (block, &stored) in stored.iter().enumerate() {
            let length = if block + 1 == *count && *last > 0 {
                *last
            } else {
                *length
            };
            let next = end.checked_add(stored);
            let next = next.filter(|_| stored.saturating_mul(most).saturating_add(SPARE) >= length);
            end = next.ok_or_else(|| {
                let problem = format!(
                    "begins an array of which block {block} announces {length} bytes, more than the {stored} that it is compressed to can hold: the file is damaged, save it again"
                );
                Stop::fault(at, problem)
            })?;
            starts.push(end);
        }
        Ok(Self {
            compressor,
            // Where there is one block only, all of it.
            length: number.max(if *count <= 1 { bytes } else { *length }),
            starts,
        })
    }

    /// Bytes of all blocks, compressed.
    pub(super) fn stored(&self) -> usize {
        self.starts.last().copied().unwrap_or(0)
    }

    /// Where a block begins and how many bytes it has.
    pub(super) fn place(&self, block: usize) -> (usize, usize) {
        let start = |at: usize| self.starts.get(at).copied().unwrap_or(self.stored());
        (start(block), start(block + 1) - start(block))
    }
}

/// Unpacks a block, and says whether it made all bytes and no more.
pub(super) fn unpack(
    compressor: Compressor,
    inflate: &mut Option<Inflate>,
    packed: &[u8],
    to: &mut [u8],
) -> bool {
    match compressor {
        Compressor::Zlib => {
            let inflate = inflate.get_or_insert_with(|| Inflate::new(true, WINDOW_BITS));
            inflate.reset(true);
            let ended = inflate.decompress(packed, to, InflateFlush::Finish);
            matches!(ended, Ok(Status::StreamEnd)) && inflate.total_out() == to.len() as u64
        }
        Compressor::Lz4 => {
            let made = lz4_flex::block::decompress_into(packed, to);
            made.is_ok_and(|made| made == to.len())
        }
    }
}
