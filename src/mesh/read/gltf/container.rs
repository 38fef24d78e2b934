//! The binary container (§4.4): twelve bytes of header, then chunks, the first of JSON, the second of bytes.

use super::super::Stop;

/// Bytes before the first chunk.
const HEADER: usize = 12;
/// Bytes before a chunk's own: its length and what it is.
const CHUNK: usize = 8;

/// What a file holds.
pub(super) struct Parts<'a> {
    pub(super) json: &'a [u8],
    /// Where the JSON begins.
    pub(super) json_at: usize,
    pub(super) binary: Option<&'a [u8]>,
}

/// Takes a GLB file apart. Chunks of other kinds are passed over, as the specification asks.
pub(super) fn parts(bytes: &[u8]) -> Result<Parts<'_>, Stop> {
    let version = word(bytes, 4)?;
    if version != 2 {
        let problem =
            format!("says that this is version {version} of glTF: save the model as glTF 2.0");
        return Err(Stop::fault(4, problem));
    }
    let announced = length(bytes, 8)?;
    let Some(bytes) = bytes.get(..announced) else {
        let problem = format!(
            "announces a file of {announced} bytes, but it has {}: it is cut short, save it again",
            bytes.len()
        );
        return Err(Stop::fault(8, problem));
    };
    let (json, mut at) = chunk(bytes, HEADER)?;
    if json.kind != *b"JSON" {
        let problem = "begins a chunk that is no JSON, which comes first: save the file again";
        return Err(Stop::fault(HEADER, problem));
    }
    let mut binary = None;
    while binary.is_none() && at < bytes.len() {
        let (next, end) = chunk(bytes, at)?;
        binary = (next.kind == *b"BIN\0").then_some(next.bytes);
        at = end;
    }
    Ok(Parts {
        json: json.bytes,
        json_at: HEADER + CHUNK,
        binary,
    })
}

struct Chunk<'a> {
    kind: [u8; 4],
    bytes: &'a [u8],
}

/// The chunk at a place, and where the next one begins.
fn chunk(bytes: &[u8], at: usize) -> Result<(Chunk<'_>, usize), Stop> {
    let announced = length(bytes, at)?;
    let kind = word(bytes, at + 4)?.to_le_bytes();
    let rest = bytes.get(at + CHUNK..).unwrap_or_default();
    let Some(inside) = rest.get(..announced) else {
        let problem = format!(
            "announces a chunk of {announced} bytes, but {} are left: the file is cut short or damaged, save it again",
            rest.len()
        );
        return Err(Stop::fault(at, problem));
    };
    let chunk = Chunk {
        kind,
        bytes: inside,
    };
    Ok((chunk, at + CHUNK + announced))
}

fn length(bytes: &[u8], at: usize) -> Result<usize, Stop> {
    Ok(usize::try_from(word(bytes, at)?).unwrap_or(usize::MAX))
}

fn word(bytes: &[u8], at: usize) -> Result<u32, Stop> {
    let word = bytes.get(at..).and_then(<[u8]>::first_chunk);
    word.map(|word| u32::from_le_bytes(*word)).ok_or_else(|| {
        let problem = "is the end, amid the file's header or a chunk's: it is cut short";
        Stop::fault(bytes.len(), problem)
    })
}
