//! What the XML says: which pieces there are, and where their arrays stand. No array is looked into.
//!
//! Elements of no interest are passed over however deep they nest; the stack of open ones is the parser's, and as long as the file at
//! most. Document types and entities are refused: no writer of these files has them, and they are what XML bombs are made of.

use std::ops::Range;

use quick_xml::errors::Error;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::super::super::{Stop, Task};
use super::kind_named;
use crate::mesh::read::vtk::number::Kind;

/// Events between two looks at whether to go on.
const EVENTS: usize = 1 << 10;

/// Pieces that are read at most: writers make one for each processor.
const MOST_PIECES: usize = 1 << 16;

/// How the blocks of arrays are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compressor {
    Zlib,
    Lz4,
}

/// A whole file, without the numbers.
#[derive(Debug, Default)]
pub(super) struct Document {
    pub(super) is_big: bool,
    /// Whether lengths before arrays take eight bytes, not four.
    pub(super) has_long_headers: bool,
    pub(super) compressor: Option<Compressor>,
    pub(super) pieces: Vec<Piece>,
    pub(super) appended: Option<Appended>,
}

/// Arrays that stand behind the XML.
#[derive(Clone, Copy, Debug)]
pub(super) struct Appended {
    /// Where the first begins.
    pub(super) at: usize,
    pub(super) is_base64: bool,
}

/// A part of the surface that has points of its own.
#[derive(Debug, Default)]
pub(super) struct Piece {
    pub(super) at: usize,
    pub(super) point_count: usize,
    pub(super) points: Option<Array>,
    pub(super) polygons: Cells,
    pub(super) strips: Cells,
    pub(super) lines: Cells,
    /// How many cells there are that are points.
    pub(super) vertices: usize,
    /// Radii of points, by the name that is taken first.
    pub(super) radii: Option<(usize, Array)>,
    /// Which line each cell is a part of, and which part of it, where lines are cut: VMTK's `CenterlineIds` and `TractIds`.
    pub(super) parts: [Option<Array>; 2],
}

/// Names that arrays of radii have: VMTK's, then those of others.
const RADII: [&str; 3] = ["MaximumInscribedSphereRadius", "Radius", "radius"];

/// Cells of one shape.
#[derive(Debug, Default)]
pub(super) struct Cells {
    pub(super) at: usize,
    pub(super) count: usize,
    /// Points of all cells.
    pub(super) points: Option<Array>,
    /// Where each cell ends in them.
    pub(super) ends: Option<Array>,
}

/// An array, not looked into.
#[derive(Clone, Copy, Debug)]
pub(super) struct Array {
    /// Where its element begins.
    pub(super) at: usize,
    pub(super) kind: Kind,
    pub(super) components: usize,
    pub(super) place: Place,
}

/// Where the numbers of an array stand.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    /// As text, between two bytes of the file.
    Text(usize, usize),
    /// As base64, between two bytes of the file.
    Base64(usize, usize),
    /// So many bytes behind the start of what is appended.
    Appended(usize),
}

/// Which arrays are looked for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Section {
    Points,
    Polygons,
    Strips,
    Lines,
    OfPoints,
    OfCells,
}

/// Reads what the XML says.
pub(super) fn read(bytes: &[u8], task: &Task<'_>) -> Result<Document, Stop> {
    let mut walk = Walk {
        bytes,
        reader: Reader::from_reader(bytes),
        document: Document::default(),
        depth: 0,
        is_polydata: false,
        section: None,
        events: 0,
        task,
    };
    while walk.event()? != Seen::End {}
    Ok(walk.document)
}

/// What was met.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Seen {
    Text,
    Other,
    /// Nothing of interest follows.
    End,
}

/// Goes through the file element by element.
struct Walk<'a> {
    bytes: &'a [u8],
    reader: Reader<&'a [u8]>,
    document: Document,
    /// Elements that are open.
    depth: usize,
    is_polydata: bool,
    section: Option<(Section, usize)>,
    events: usize,
    task: &'a Task<'a>,
}

impl Walk<'_> {
    /// The end of what was read.
    fn at(&self) -> usize {
        usize::try_from(self.reader.buffer_position()).unwrap_or(usize::MAX)
    }

    /// Reads an event.
    fn event(&mut self) -> Result<Seen, Stop> {
        if self.events.is_multiple_of(EVENTS) {
            self.task.go_on()?;
        }
        self.events += 1;
        let at = self.at();
        match self.reader.read_event().map_err(|error| {
            let at = usize::try_from(self.reader.error_position()).unwrap_or(at);
            no_xml(at, &error)
        })? {
            Event::Start(tag) => {
                self.depth += 1;
                if self.depth == 1 {
                    self.root(at, &tag)?;
                } else if self.depth == 2 && tag.name().as_ref() == "AppendedData" {
                    self.appended(at, &tag)?;
                    // What follows is no XML.
                    return Ok(Seen::End);
                } else {
                    self.element(at, &tag, false)?;
                }
            }
            Event::Empty(tag) => {
                self.depth += 1;
                self.element(at, &tag, true)?;
                self.depth -= 1;
            }
            Event::End(_) => {
                self.depth = self.depth.saturating_sub(1);
                if self.section.is_some_and(|(_, depth)| depth > self.depth) {
                    self.section = None;
                }
                if self.depth == 0 {
                    return Ok(Seen::End);
                }
            }
            Event::DocType(_) => {
                let problem = "has a document type: remove it, these files need none";
                return Err(Stop::fault(at, problem));
            }
            Event::GeneralRef(_) => {
                let problem = "has an entity: write what it stands for";
                return Err(Stop::fault(at, problem));
            }
            Event::Eof => {
                let problem = "is the end, amid the XML: the file is cut short, save it again";
                return Err(Stop::fault(at, problem));
            }
            Event::Text(_) => return Ok(Seen::Text),
            Event::CData(_) | Event::Comment(_) | Event::Decl(_) | Event::PI(_) => {}
        }
        Ok(Seen::Other)
    }

    /// The outermost element.
    fn root(&mut self, at: usize, tag: &BytesStart<'_>) -> Result<(), Stop> {
        let kind = attribute(tag, "type").unwrap_or_default();
        if tag.name().as_ref() != "VTKFile" || kind != "PolyData" {
            let problem = format!(
                "begins a VTK file of the type `{}`, and PolyData is read: extract the surface (ParaView: Extract Surface) and save it as VTP",
                shown(&kind)
            );
            return Err(Stop::fault(at, problem));
        }
        let document = &mut self.document;
        document.is_big = match attribute(tag, "byte_order").as_deref() {
            None | Some("LittleEndian") => false,
            Some("BigEndian") => true,
            Some(other) => return Err(unknown(at, "byte order", other, "LittleEndian, BigEndian")),
        };
        document.has_long_headers = match attribute(tag, "header_type").as_deref() {
            None | Some("UInt32") => false,
            Some("UInt64") => true,
            Some(other) => return Err(unknown(at, "header type", other, "UInt32, UInt64")),
        };
        document.compressor = match attribute(tag, "compressor").as_deref() {
            None | Some("") => None,
            Some("vtkZLibDataCompressor") => Some(Compressor::Zlib),
            Some("vtkLZ4DataCompressor") => Some(Compressor::Lz4),
            Some(other) => {
                let read = "vtkZLibDataCompressor, vtkLZ4DataCompressor or none";
                return Err(unknown(at, "compressor", other, read));
            }
        };
        Ok(())
    }

    /// An element within the outermost one.
    fn element(&mut self, at: usize, tag: &BytesStart<'_>, is_empty: bool) -> Result<(), Stop> {
        let name = tag.name();
        let name = name.as_ref();
        match (self.depth, name) {
            (2, "PolyData") => self.is_polydata = true,
            (2, _) => self.is_polydata = false,
            (3, "Piece") if self.is_polydata => self.piece(at, tag)?,
            (4, _) if self.is_polydata && !is_empty => self.begin_section(at, name),
            (5, "DataArray") if self.section.is_some() => self.array(at, tag, is_empty)?,
            _ => {}
        }
        Ok(())
    }

    fn piece(&mut self, at: usize, tag: &BytesStart<'_>) -> Result<(), Stop> {
        if self.document.pieces.len() >= MOST_PIECES {
            let problem = format!(
                "begins one piece more than the {MOST_PIECES} that are read: join them (ParaView: Append Geometry)"
            );
            return Err(Stop::fault(at, problem));
        }
        let count = |name| count(at, tag, name);
        let cells = |count| Cells {
            at,
            count,
            ..Cells::default()
        };
        self.document.pieces.push(Piece {
            at,
            point_count: count("NumberOfPoints")?,
            points: None,
            polygons: cells(count("NumberOfPolys")?),
            strips: cells(count("NumberOfStrips")?),
            lines: cells(count("NumberOfLines")?),
            vertices: count("NumberOfVerts")?,
            radii: None,
            parts: [None; 2],
        });
        Ok(())
    }

    fn begin_section(&mut self, at: usize, name: &str) {
        let section = match name {
            "Points" => Section::Points,
            "Polys" => Section::Polygons,
            "Strips" => Section::Strips,
            "Lines" => Section::Lines,
            "PointData" => Section::OfPoints,
            "CellData" => Section::OfCells,
            _ => return,
        };
        self.section = Some((section, self.depth));
        if let Some(piece) = self.document.pieces.last_mut() {
            match section {
                Section::Points | Section::OfPoints | Section::OfCells => {}
                Section::Lines => piece.lines.at = at,
                Section::Polygons => piece.polygons.at = at,
                Section::Strips => piece.strips.at = at,
            }
        }
    }

    /// An array of a section that is of interest.
    fn array(&mut self, at: usize, tag: &BytesStart<'_>, is_empty: bool) -> Result<(), Stop> {
        let (Some((section, _)), false) = (self.section, self.document.pieces.is_empty()) else {
            return Ok(());
        };
        let name = attribute(tag, "Name").unwrap_or_default();
        let is_wanted = match section {
            Section::Points => true,
            Section::OfPoints => RADII.contains(&name.as_str()),
            Section::OfCells => name == "CenterlineIds" || name == "TractIds",
            _ => name == "connectivity" || name == "offsets",
        };
        if !is_wanted {
            return Ok(());
        }
        let kind = attribute(tag, "type").unwrap_or_default();
        let kind = kind_named(&kind).ok_or_else(|| {
            let read = "Int8, UInt8, Int16, UInt16, Int32, UInt32, Int64, UInt64, Float32, Float64";
            unknown(at, "type of numbers", &kind, read)
        })?;
        let components = match attribute(tag, "NumberOfComponents") {
            None => 1,
            Some(_) => count(at, tag, "NumberOfComponents")?,
        };
        let place = match attribute(tag, "format").as_deref() {
            Some("appended") => Place::Appended(count(at, tag, "offset")?),
            Some("binary") => {
                let text = self.text(is_empty)?;
                Place::Base64(text.start, text.end)
            }
            None | Some("ascii") => {
                let text = self.text(is_empty)?;
                Place::Text(text.start, text.end)
            }
            Some(other) => return Err(unknown(at, "format", other, "ascii, binary, appended")),
        };
        let array = Array {
            at,
            kind,
            components,
            place,
        };
        if let Some(piece) = self.document.pieces.last_mut() {
            let to = match (section, name.as_str()) {
                (Section::OfPoints, name) => {
                    let rank = RADII.iter().position(|other| *other == name);
                    let rank = rank.unwrap_or(RADII.len());
                    if piece.radii.is_none_or(|(other, _)| rank < other) {
                        piece.radii = Some((rank, array));
                    }
                    return Ok(());
                }
                (Section::OfCells, "CenterlineIds") => &mut piece.parts[0],
                (Section::OfCells, _) => &mut piece.parts[1],
                (Section::Lines, "offsets") => &mut piece.lines.ends,
                (Section::Lines, _) => &mut piece.lines.points,
                (Section::Points, _) => &mut piece.points,
                (Section::Polygons, "offsets") => &mut piece.polygons.ends,
                (Section::Polygons, _) => &mut piece.polygons.points,
                (Section::Strips, "offsets") => &mut piece.strips.ends,
                (Section::Strips, _) => &mut piece.strips.points,
            };
            to.get_or_insert(array);
        }
        Ok(())
    }

    /// The text of an array that was begun: what stands in it first that is not blank. Other elements may stand before it.
    fn text(&mut self, is_empty: bool) -> Result<Range<usize>, Stop> {
        let depth = self.depth;
        let mut found = self.at()..self.at();
        if is_empty {
            return Ok(found);
        }
        loop {
            let from = self.at();
            let is_text = self.event()? == Seen::Text;
            if self.depth < depth {
                return Ok(found);
            }
            let text = self.bytes.get(from..self.at()).unwrap_or_default();
            let is_first = found.is_empty() && self.depth == depth;
            if is_text && is_first && !text.trim_ascii_start().is_empty() {
                found = from..from + text.len();
            }
        }
    }

    /// What is appended begins behind an underscore.
    fn appended(&mut self, at: usize, tag: &BytesStart<'_>) -> Result<(), Stop> {
        let is_base64 = match attribute(tag, "encoding").as_deref() {
            Some("raw") => false,
            None | Some("base64") => true,
            Some(other) => return Err(unknown(at, "encoding", other, "raw, base64")),
        };
        let rest = self.bytes.get(self.at()..).unwrap_or_default();
        let blanks = rest.len() - rest.trim_ascii_start().len();
        if rest.get(blanks) != Some(&b'_') {
            let problem = "is where what is appended should begin with `_`: save the file again";
            return Err(Stop::fault(self.at() + blanks, problem));
        }
        self.document.appended = Some(Appended {
            at: self.at() + blanks + 1,
            is_base64,
        });
        Ok(())
    }
}

/// The value of an attribute as it stands; those that are asked for have no entities. Names that are there twice are no matter: to look
/// for them would take the square of their number.
fn attribute(tag: &BytesStart<'_>, name: &str) -> Option<String> {
    let mut attributes = tag.attributes();
    let mut all = attributes.with_checks(false).map_while(Result::ok);
    let found = all.find(|attribute| attribute.key.as_ref() == name)?;
    Some(found.value.into_owned())
}

/// An attribute that counts something, 0 where there is none.
fn count(at: usize, tag: &BytesStart<'_>, name: &str) -> Result<usize, Stop> {
    let Some(value) = attribute(tag, name) else {
        return Ok(0);
    };
    value.trim().parse().map_err(|_| {
        let problem = format!(
            "has `{}` as {name}, which is a whole number from 0 on: save the file again",
            shown(&value)
        );
        Stop::fault(at, problem)
    })
}

fn unknown(at: usize, what: &str, name: &str, read: &str) -> Stop {
    let name = shown(name);
    let problem = format!("has the {what} `{name}`, and {read} are read: save the file with these");
    Stop::fault(at, problem)
}

/// The start of a word, fit for a message.
fn shown(text: &str) -> String {
    let plain = |c: char| if c.is_control() { '?' } else { c };
    text.chars().take(32).map(plain).collect()
}

fn no_xml(at: usize, error: &Error) -> Stop {
    let error: String = shown_error(error);
    let problem = format!("is no XML that holds together ({error}): save the file again");
    Stop::fault(at, problem)
}

/// The parser's word for a fault, not longer than a line: it may quote the file.
fn shown_error(error: &Error) -> String {
    let plain = |c: char| if c.is_control() { '?' } else { c };
    error.to_string().chars().take(120).map(plain).collect()
}
