//! What a file is, by its content: names of files lie, and programs hand models on without any.

use super::Format;
use super::cursor::Cursor;
use super::vtk::legacy;
use crate::mesh::MeshError;

/// Bytes that are looked at for whether a file is text, and for its first lines.
const LOOK: usize = 64 << 10;

/// What some programs mark text with.
const BOM: &[u8] = b"\xEF\xBB\xBF";

/// Bytes of a binary STL file before its triangles: a header that says nothing, and their number.
pub(super) const STL_HEADER: usize = 84;
/// Bytes of a triangle in a binary STL file.
pub(super) const STL_TRIANGLE: usize = 50;

/// How formats begin that are known and not read.
const OTHERS: &[(&[u8], &str)] = &[
    (b"#VRML", "a VRML file"),
    (b"OFF", "an OFF file"),
    (b"COFF", "an OFF file"),
    (b"ISO-10303-21", "a STEP file"),
    (b"Kaydara FBX Binary", "an FBX file"),
    (b"BLENDER", "a Blender file"),
    (b"\x93NUMPY", "a NumPy array"),
    (b"NRRD", "an NRRD volume"),
    (b"\x89HDF", "an HDF5 file"),
    (b"PK\x03\x04", "a zip archive (3MF files are such)"),
    (b"\x1f\x8b", "a gzip archive"),
];

/// Words that OBJ files begin lines with.
const OBJ_WORDS: &[&[u8]] = &[
    b"v", b"vt", b"vn", b"vp", b"f", b"o", b"g", b"s", b"l", b"p", b"mtllib", b"usemtl", b"mg",
    b"cstype", b"deg", b"usemap", b"maplib",
];

/// What these bytes are.
///
/// # Errors
/// What it is by its name where it is not read, else that nothing is known.
pub(super) fn of(bytes: &[u8]) -> Result<Format, MeshError> {
    if bytes.is_empty() {
        return Err(MeshError::Empty);
    }
    if let Some(format) = ply(bytes) {
        return Ok(format);
    }
    // Before text is thought of: many binary files begin with "solid", too.
    if stl_triangles(bytes).is_some_and(|count| stl_length(count) == bytes.len() as u64) {
        return Ok(Format::BinaryStl);
    }
    if bytes.starts_with(b"glTF") {
        return Ok(Format::Glb);
    }
    if let Some((_, name)) = OTHERS.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Err(MeshError::Unsupported(name));
    }
    // Bytes may follow their first lines.
    if bytes.starts_with(legacy::MAGIC) {
        return Ok(Format::Vtk);
    }
    let head = &bytes[..bytes.len().min(LOOK)];
    if is_vtk_xml(head) {
        return Ok(Format::Vtp);
    }
    if head.iter().copied().all(is_text) {
        text(bytes, head)
    } else if stl_triangles(bytes).is_some() && is_stl_header(bytes) {
        // Cut short or added to: the reader says by how much.
        Ok(Format::BinaryStl)
    } else {
        Err(MeshError::Unknown)
    }
}

fn ply(bytes: &[u8]) -> Option<Format> {
    let rest = bytes.strip_prefix(b"ply")?;
    if !matches!(rest.first(), None | Some(b'\r' | b'\n' | b' ' | b'\t')) {
        return None;
    }
    // Which it is stands on the line `format`; the reader says what is wrong with that line.
    let head = &rest[..rest.len().min(LOOK)];
    let mut lines = head.split(|byte| matches!(byte, b'\r' | b'\n'));
    let format = lines.find(|line| line.starts_with(b"format"));
    let is_binary = format.is_some_and(|line| line.windows(6).any(|part| part == b"binary"));
    Some(if is_binary {
        Format::BinaryPly
    } else {
        Format::AsciiPly
    })
}

/// The number of triangles that a binary STL file would have.
pub(super) fn stl_triangles(bytes: &[u8]) -> Option<u32> {
    let count = bytes.get(STL_HEADER - 4..STL_HEADER)?;
    Some(u32::from_le_bytes(count.try_into().ok()?))
}

/// The length of a binary STL file of so many triangles, in bytes.
pub(super) fn stl_length(triangles: u32) -> u64 {
    STL_HEADER as u64 + STL_TRIANGLE as u64 * u64::from(triangles)
}

/// Whether the first bytes may be an STL header: words, blanks and zeros.
fn is_stl_header(bytes: &[u8]) -> bool {
    let header = &bytes[..STL_HEADER - 4];
    header.iter().all(|&byte| byte == 0 || is_text(byte))
}

/// Whether a byte may stand in text of any encoding that keeps ASCII.
pub(super) fn is_text(byte: u8) -> bool {
    byte >= b' ' || byte.is_ascii_whitespace() || byte == 0x0b
}

/// Whether this is XML that begins a VTK file of any kind, before which comments may stand.
pub(super) fn is_vtk_xml(head: &[u8]) -> bool {
    const ROOT: &[u8] = b"<VTKFile";
    let head = head.strip_prefix(BOM).unwrap_or(head).trim_ascii_start();
    let root = head.windows(ROOT.len()).position(|part| part == ROOT);
    head.starts_with(b"<") && root.is_some_and(|root| head[..root].iter().copied().all(is_text))
}

/// The format of a text by its first line with a word that tells one.
fn text(bytes: &[u8], head: &[u8]) -> Result<Format, MeshError> {
    let head = head.strip_prefix(BOM).unwrap_or(head);
    for line in head.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii) {
        if line.is_empty() || line.starts_with(b"#") {
            continue;
        }
        let word = line.split(u8::is_ascii_whitespace).next();
        let word = word.unwrap_or_default();
        if word.eq_ignore_ascii_case(b"solid") {
            return Ok(Format::AsciiStl);
        }
        if OBJ_WORDS.contains(&word) {
            return Ok(Format::Obj);
        }
        if line.starts_with(b"{") {
            return json(bytes);
        }
        if is_node(line) {
            return Ok(Format::Swc);
        }
        return Err(other_text(line));
    }
    Err(MeshError::Unknown)
}

/// glTF, of all that is written in JSON. Its `asset` may stand behind gigabytes of other members.
fn json(bytes: &[u8]) -> Result<Format, MeshError> {
    const ASSET: &[u8] = b"\"asset\"";
    let mut rest = bytes;
    while let Some(at) = rest.iter().position(|&byte| byte == b'"') {
        rest = &rest[at..];
        if rest.starts_with(ASSET) {
            return Ok(Format::Gltf);
        }
        rest = &rest[1..];
    }
    Err(MeshError::Unsupported(
        "JSON without the `asset` of a glTF file",
    ))
}

/// Whether a line is a node of a skeleton: seven numbers, and perhaps more behind them.
fn is_node(line: &[u8]) -> bool {
    let line = line.split(|&byte| byte == b'#').next().unwrap_or_default();
    let words = line.split(u8::is_ascii_whitespace);
    let words = words.filter(|word| !word.is_empty()).take(7);
    let is_number = |word: &[u8]| Cursor::new(word, 0).number().is_some();
    words.clone().count() == 7 && { words }.all(is_number)
}

/// What a text is that is not read.
fn other_text(line: &[u8]) -> MeshError {
    match line.first() {
        Some(b'<') => MeshError::Unsupported("XML"),
        _ => MeshError::Unknown,
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    /// A binary STL file of so many bytes that announces so many triangles.
    fn stl(name: &[u8], triangles: u32, length: usize) -> Vec<u8> {
        let mut bytes = name.to_vec();
        bytes.resize(STL_HEADER - 4, 0);
        bytes.extend(triangles.to_le_bytes());
        bytes.resize(length, 0);
        bytes
    }

    #[test]
    fn formats_are_told_by_content() {
        for (bytes, format) in [
            (&b"ply\nformat ascii 1.0\n"[..], Format::AsciiPly),
            (b"ply\r\nformat binary_little_endian 1.0", Format::BinaryPly),
            (
                b"ply\rcomment x\rformat binary_big_endian",
                Format::BinaryPly,
            ),
            (b"ply", Format::AsciiPly),
            (b"solid name\nfacet normal 0 0 0", Format::AsciiStl),
            (b"\xEF\xBB\xBF\n  SOLID", Format::AsciiStl),
            (b"# made by hand\n\nmtllib a.mtl\n", Format::Obj),
            (b"v 0 0 0", Format::Obj),
            (b"# \xE4\no caf\xE9\n", Format::Obj),
            (
                b"<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">\n_\0\x01",
                Format::Vtp,
            ),
            (b"\xEF\xBB\xBF<!-- a --> <VTKFile>", Format::Vtp),
            (b"# vtk DataFile Version 3.0\n\0", Format::Vtk),
            (b"# skeleton\n1 2 0 0 0 1.5 -1\n", Format::Swc),
            (b"7 2 0 -1e3 0 1.5 6 0.1 0.2 # tip", Format::Swc),
            (&stl(b"solid of another program", 2, 184), Format::BinaryStl),
            (&stl(b"", 0, 84), Format::BinaryStl),
            (b"glTF\x02\0\0\0", Format::Glb),
            (b"\xEF\xBB\xBF {\"asset\": {}}", Format::Gltf),
            (b"{\n\"nodes\": [], \"asset\"", Format::Gltf),
            (&stl(b"exported", 9, 184), Format::BinaryStl),
        ] {
            assert_eq!(
                of(bytes).unwrap(),
                format,
                "{}",
                String::from_utf8_lossy(bytes)
            );
        }
    }

    #[test]
    fn what_is_not_read_is_told_by_name() {
        for (bytes, told) in [
            (&b""[..], "empty"),
            (b"{\"assets\": {}}", "JSON without the `asset`"),
            (b"<svg/>", "XML"),
            (b"PK\x03\x04", "zip"),
            (b"\x1f\x8b\x08", "gzip"),
            (b"OFF\n3 1 0\n", "OFF"),
            (b"1 2 3\n", "no format"),
            (b"1 2 3 4 5 6 a\n", "no format"),
            (b"<a>\0<VTKFile>", "no format"),
            (b"Dear reader,\n", "no format"),
            (b"\0\x01\x02", "no format"),
            (b"# only a comment", "no format"),
            (b"polygons", "no format"),
            (&[0xFF; 200], "no format"),
            (&[1; 200], "no format"),
        ] {
            let fault = of(bytes).unwrap_err().to_string();
            assert!(fault.contains(told), "{fault}");
        }
    }
}
