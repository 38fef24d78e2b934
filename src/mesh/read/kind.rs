//! What a file is, by its content: names of files lie, and programs hand models on without any.

use super::Format;
use super::cursor::Cursor;
use crate::mesh::MeshError;

/// Bytes that are looked at for whether a file is text, and for its first lines.
const LOOK: usize = 64 << 10;

/// Bytes of a binary STL file before its triangles: a header that says nothing, and their number.
pub(super) const STL_HEADER: usize = 84;
/// Bytes of a triangle in a binary STL file.
pub(super) const STL_TRIANGLE: usize = 50;

/// How formats begin that are known and not read.
const OTHERS: &[(&[u8], &str)] = &[
    (b"# vtk DataFile", "a legacy VTK file"),
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
    let head = &bytes[..bytes.len().min(LOOK)];
    if is_text(head) {
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
    header.iter().all(|&byte| byte == 0 || is_text(&[byte]))
}

/// Whether bytes may stand in text of any encoding that keeps ASCII.
fn is_text(bytes: &[u8]) -> bool {
    let control = |byte: &u8| *byte < b' ' && !byte.is_ascii_whitespace() && *byte != 0x0b;
    !bytes.iter().any(control)
}

/// The format of a text by its first line with a word that tells one.
fn text(bytes: &[u8], head: &[u8]) -> Result<Format, MeshError> {
    let head = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
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
        return Err(other_text(head, line));
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

/// What a text is that is not read.
fn other_text(head: &[u8], line: &[u8]) -> MeshError {
    let has = |word: &[u8]| head.windows(word.len()).any(|part| part == word);
    if line.starts_with(b"<") {
        let is_vtk = has(b"<VTKFile");
        return MeshError::Unsupported(if is_vtk { "a VTK XML file" } else { "XML" });
    }
    let words = line.split(u8::is_ascii_whitespace);
    let mut words = words.filter(|word| !word.is_empty());
    // A node of a skeleton is seven numbers.
    let is_number = |word: &[u8]| Cursor::new(word, 0).number().is_some();
    if words.clone().count() >= 7 && words.all(is_number) {
        return MeshError::Unsupported("an SWC skeleton");
    }
    MeshError::Unknown
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
            (
                b"<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">",
                "VTK XML",
            ),
            (b"<svg/>", "XML"),
            (b"# vtk DataFile Version 3.0\n", "legacy VTK"),
            (b"# skeleton\n1 2 0 0 0 1.5 -1\n", "SWC"),
            (b"PK\x03\x04", "zip"),
            (b"\x1f\x8b\x08", "gzip"),
            (b"OFF\n3 1 0\n", "OFF"),
            (b"1 2 3\n", "no format"),
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
