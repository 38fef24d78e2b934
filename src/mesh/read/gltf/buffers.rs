//! Buffers (§3.6.1): the binary chunk, text in base64, or a file, each had when it is first asked for.
//!
//! Base64 is decoded in place, within the text that JSON gave, so that the text and its bytes never stand in memory both.

use std::cell::{Cell, OnceCell};
use std::sync::Arc;

use base64::Engine as _;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use ::gltf::json::Root;

use super::super::Stop;
use super::folder::{Folder, Refusal};
use crate::tree::Cells;

/// Of the usual alphabet; the last `=` are often forgotten.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);
/// Letters that are decoded at once, a multiple of four.
const LETTERS: usize = 4096;

/// All buffers of a file.
pub(super) struct Buffers<'a> {
    buffers: Vec<Buffer<'a>>,
    folder: &'a Folder<'a>,
    /// Length of the model's own file.
    pub(super) file_bytes: usize,
}

struct Buffer<'a> {
    /// The binary chunk, if it is that.
    chunk: Option<&'a [u8]>,
    uri: Cell<Option<String>>,
    announced: u64,
    bytes: OnceCell<Had<'a>>,
}

/// Bytes that are there.
enum Had<'a> {
    Chunk(&'a [u8]),
    Decoded(Vec<u8>),
    File(Arc<Cells<u8>>),
}

impl<'a> Buffers<'a> {
    /// Takes the buffers' addresses out of the document.
    pub(super) fn new(
        root: &mut Root,
        binary: Option<&'a [u8]>,
        folder: &'a Folder<'a>,
        file_bytes: usize,
    ) -> Self {
        let buffers = root.buffers.iter_mut().enumerate();
        let buffers = buffers.map(|(number, buffer)| Buffer {
            chunk: binary.filter(|_| number == 0 && buffer.uri.is_none()),
            uri: Cell::new(buffer.uri.take()),
            announced: buffer.byte_length.0,
            bytes: OnceCell::new(),
        });
        Self {
            buffers: buffers.collect(),
            folder,
            file_bytes,
        }
    }

    /// The bytes of a buffer, as many as it announces.
    pub(super) fn bytes(&self, number: usize) -> Result<&[u8], Stop> {
        let fault = |problem: String| Stop::item("buffer", number, problem);
        let Some(buffer) = self.buffers.get(number) else {
            let problem = format!(
                "is not there, there are {}: save the file again",
                self.buffers.len()
            );
            return Err(fault(problem));
        };
        if buffer.bytes.get().is_none() {
            let had = self.have(buffer).map_err(|refusal| match refusal {
                Refusal::Cancelled => Stop::Cancelled,
                Refusal::Problem(problem) => fault(problem),
            })?;
            // It is empty, since nobody else writes to it.
            let _ = buffer.bytes.set(had);
        }
        let bytes = match buffer.bytes.get() {
            Some(Had::Chunk(bytes)) => bytes,
            Some(Had::Decoded(bytes)) => bytes.as_slice(),
            Some(Had::File(bytes)) => bytes,
            None => &[],
        };
        let announced = usize::try_from(buffer.announced).unwrap_or(usize::MAX);
        bytes.get(..announced).ok_or_else(|| {
            fault(format!(
                "announces {announced} bytes, but has {}: it is cut short, save the model again",
                bytes.len()
            ))
        })
    }

    /// Bytes of all buffers that were asked for.
    pub(super) fn length(&self) -> usize {
        let had = self.buffers.iter().filter_map(|buffer| buffer.bytes.get());
        let lengths = had.map(|had| match had {
            Had::Chunk(bytes) => bytes.len(),
            Had::Decoded(bytes) => bytes.len(),
            Had::File(bytes) => bytes.len(),
        });
        lengths.sum()
    }

    fn have(&self, buffer: &Buffer<'a>) -> Result<Had<'a>, Refusal> {
        if let Some(chunk) = buffer.chunk {
            return Ok(Had::Chunk(chunk));
        }
        let Some(uri) = buffer.uri.take() else {
            return Err(Refusal::Problem(
                "has no bytes in the file: save it again, without compression".into(),
            ));
        };
        if is_data(&uri) {
            return decoded(uri).map(Had::Decoded).map_err(Refusal::Problem);
        }
        self.folder.file(&uri).map(Had::File)
    }
}

/// Whether a URI is its own content.
pub(super) fn is_data(uri: &str) -> bool {
    uri.as_bytes()
        .get(..5)
        .is_some_and(|start| start.eq_ignore_ascii_case(b"data:"))
}

/// The content of a URI that is its own.
pub(super) fn decoded(uri: String) -> Result<Vec<u8>, String> {
    let start = uri.find(',').filter(|&at| uri[..at].ends_with(";base64"));
    let Some(start) = start else {
        return Err("is data that is not written in base64: save the model as GLB".into());
    };
    let mut bytes = uri.into_bytes();
    let (mut from, mut to) = (start + 1, 0);
    let mut piece = [0; LETTERS / 4 * 3];
    while from < bytes.len() {
        let end = bytes.len().min(from + LETTERS);
        let count = BASE64.decode_slice(&bytes[from..end], &mut piece);
        let count = count.map_err(|error| {
            format!("is data with a fault in its base64 ({error}, near byte {from} of it): save the model again")
        })?;
        // What was decoded is behind what is decoded: three bytes are made of four.
        bytes[to..to + count].copy_from_slice(&piece[..count]);
        (from, to) = (end, to + count);
    }
    bytes.truncate(to);
    Ok(bytes)
}
