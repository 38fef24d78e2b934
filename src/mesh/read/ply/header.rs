//! The header: which elements follow, how many, and what each row of them holds.

use super::{Stop, Task};
use crate::mesh::read::cursor::Cursor;

/// Longest header, in bytes.
const LONGEST: usize = 1 << 20;

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Length in a binary file.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Whether single precision may round its values.
    fn is_wide(self) -> bool {
        matches!(self, Self::I32 | Self::U32 | Self::F64)
    }
}

/// What a row holds at one place.
#[derive(Clone, Copy, Debug)]
pub(super) enum Property {
    Scalar(Number),
    List { count: Number, item: Number },
}

impl Property {
    /// Least length in a binary file.
    pub(super) fn least_bytes(self) -> usize {
        match self {
            Self::Scalar(number) | Self::List { count: number, .. } => number.bytes(),
        }
    }
}

/// What an element is for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Role {
    /// Which properties are x, y and z.
    Vertices([usize; 3]),
    /// Which property lists the vertices of a face.
    Faces(usize),
    Other,
}

/// Rows of one kind.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) rows: usize,
    pub(super) properties: Vec<Property>,
    pub(super) role: Role,
    names: Vec<Vec<u8>>,
    /// Where it is announced.
    at: usize,
}

impl Element {
    /// Which property has a name.
    pub(super) fn place(&self, name: &[u8]) -> Option<usize> {
        self.names.iter().position(|found| found == name)
    }
}

/// How the rows are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Body {
    Text,
    Binary { is_big: bool },
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) body: Body,
    pub(super) elements: Vec<Element>,
    /// Where the rows begin.
    pub(super) end: usize,
}

impl Header {
    /// Vertices that are announced.
    pub(super) fn vertices(&self) -> usize {
        let vertices = |element: &&Element| matches!(element.role, Role::Vertices(_));
        self.elements
            .iter()
            .find(vertices)
            .map_or(0, |element| element.rows)
    }

    /// Whether coordinates may need double precision.
    pub(super) fn has_doubles(&self) -> bool {
        self.elements.iter().any(|element| match element.role {
            Role::Vertices(axes) => axes.iter().any(|&axis| {
                matches!(element.properties.get(axis), Some(Property::Scalar(number)) if number.is_wide())
            }),
            _ => false,
        })
    }
}

/// One line, where it begins, and where the next does. Lines end as the first one does: by CR, LF or both; in a binary file the first
/// byte of a row may look like an end of line.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    end: &'static [u8],
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let first = bytes.iter().position(|byte| matches!(byte, b'\r' | b'\n'));
        let rest = &bytes[first.unwrap_or(bytes.len())..];
        let end: &[u8] = match rest {
            [b'\r', b'\n', ..] => b"\r\n",
            [b'\r', ..] => b"\r",
            _ => b"\n",
        };
        Self { bytes, at: 0, end }
    }

    fn next(&mut self) -> Option<(usize, &'a [u8])> {
        let at = self.at;
        let rest = self.bytes.get(at..).filter(|rest| !rest.is_empty())?;
        let mut ends = rest.windows(self.end.len());
        let end = ends.position(|part| part == self.end);
        let line = &rest[..end.unwrap_or(rest.len())];
        self.at = at + line.len() + end.map_or(0, |_| self.end.len());
        Some((at, line))
    }
}

/// Reads the header.
pub(super) fn read(bytes: &[u8], task: &Task<'_>) -> Result<Header, Stop> {
    let head = &bytes[..bytes.len().min(LONGEST)];
    let mut lines = Lines::new(head);
    let mut body = None;
    let mut elements: Vec<Element> = Vec::new();
    lines.next(); // `ply`
    while let Some((at, line)) = lines.next() {
        task.go_on()?;
        let words = line.split(u8::is_ascii_whitespace);
        let mut words = words.filter(|word| !word.is_empty());
        match words.next().unwrap_or_default() {
            b"" | b"comment" | b"obj_info" => {}
            b"format" => body = Some(body_named(at, words.next().unwrap_or_default())?),
            b"element" => elements.push(element(at, words.next(), words.next())?),
            b"property" => {
                let Some(element) = elements.last_mut() else {
                    return Err(Stop::fault(
                        at,
                        "is a property before any element: name the element first",
                    ));
                };
                let (name, property) = property(at, words)?;
                element.names.push(name);
                element.properties.push(property);
            }
            b"end_header" => {
                let body = body.ok_or_else(|| {
                    Stop::fault(at, "ends the header, which has no line `format`: add it")
                })?;
                give_roles(&mut elements)?;
                return Ok(Header {
                    body,
                    elements,
                    end: lines.at,
                });
            }
            _ => {
                let word = Cursor::new(line, 0).shown();
                let problem = format!(
                    "begins with {word}, but a header has lines of format, comment, element and property: remove it"
                );
                return Err(Stop::fault(at, problem));
            }
        }
    }
    let problem = "ends without `end_header`: the file is cut short, save it again";
    Err(Stop::fault(head.len(), problem))
}

fn body_named(at: usize, name: &[u8]) -> Result<Body, Stop> {
    match name {
        b"ascii" => Ok(Body::Text),
        b"binary_little_endian" => Ok(Body::Binary { is_big: false }),
        b"binary_big_endian" => Ok(Body::Binary { is_big: true }),
        _ => Err(Stop::fault(
            at,
            "names no format: it is ascii, binary_little_endian or binary_big_endian",
        )),
    }
}

fn element(at: usize, name: Option<&[u8]>, count: Option<&[u8]>) -> Result<Element, Stop> {
    let rows = count.and_then(|count| str::from_utf8(count).ok()?.parse().ok());
    let (Some(name), Some(rows)) = (name, rows) else {
        return Err(Stop::fault(
            at,
            "announces no element: it is `element NAME NUMBER`",
        ));
    };
    Ok(Element {
        name: String::from_utf8_lossy(&name[..name.len().min(24)]).into_owned(),
        rows,
        properties: Vec::new(),
        role: Role::Other,
        names: Vec::new(),
        at,
    })
}

fn property<'a>(
    at: usize,
    words: impl Iterator<Item = &'a [u8]>,
) -> Result<(Vec<u8>, Property), Stop> {
    let words: Vec<&[u8]> = words.take(5).collect();
    let number = |name| {
        Number::named(name).ok_or_else(|| {
            Stop::fault(
                at,
                "names no type of numbers: they are char, uchar, short, ushort, int, uint, float and double",
            )
        })
    };
    match words[..] {
        [b"list", count, item, name] => {
            let (count, item) = (number(count)?, number(item)?);
            Ok((name.to_vec(), Property::List { count, item }))
        }
        [kind, name] => Ok((name.to_vec(), Property::Scalar(number(kind)?))),
        _ => Err(Stop::fault(
            at,
            "is no property: it is `property TYPE NAME` or `property list TYPE TYPE NAME`",
        )),
    }
}

/// Finds the vertices and the faces.
fn give_roles(elements: &mut [Element]) -> Result<(), Stop> {
    let mut seen = [false; 2];
    for element in elements {
        let which = match element.name.as_str() {
            "vertex" => 0,
            "face" => 1,
            _ => continue,
        };
        if std::mem::replace(&mut seen[which], true) {
            let problem = format!(
                "announces the element {} a second time: put all rows into one",
                element.name
            );
            return Err(Stop::fault(element.at, problem));
        }
        element.role = if which == 0 {
            vertices(element)?
        } else {
            faces(element)?
        };
    }
    Ok(())
}

fn vertices(element: &Element) -> Result<Role, Stop> {
    let mut axes = [0; 3];
    for (axis, name) in axes.iter_mut().zip([b"x", b"y", b"z"]) {
        let found = element.names.iter().position(|found| found == name);
        let scalar = |at: &usize| matches!(element.properties[*at], Property::Scalar(_));
        *axis = found.filter(scalar).ok_or_else(|| {
            let name = char::from(name[0]);
            Stop::fault(
                element.at,
                format!("announces vertices without the number {name}: they have x, y and z"),
            )
        })?;
    }
    Ok(Role::Vertices(axes))
}

fn faces(element: &Element) -> Result<Role, Stop> {
    let list = element
        .names
        .iter()
        .zip(&element.properties)
        .position(|(name, property)| {
            matches!(name.as_slice(), b"vertex_indices" | b"vertex_index")
                && matches!(property, Property::List { .. })
        });
    let problem = "announces faces without the list vertex_indices: add it";
    list.map(Role::Faces)
        .ok_or_else(|| Stop::fault(element.at, problem))
}
