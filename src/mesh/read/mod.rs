//! Models from other programs' files; anything at all may stand in such a file.
//!
//! ```text
//! file ─▶ bytes ─▶ kind ─▶ ply | stl | obj | vtk ─▶ points, triangles ─▶ points::mesh ─▶ Mesh
//!                      ├─▶ swc ─▶ Tree ─▶ its tubes, joined ──────────────────────────┘
//!                      └─▶ gltf, with the files that it names ─▶ Mesh, Paint
//! ```
//!
//! The file is read whole before it is understood (but for VTP files with raw arrays, of which each thread reads what it needs): mapping it would be no faster from the system's cache, and a mapped file that
//! another program shortens ends the process. All threads read it, each a piece. Its format is told by its content, since names of
//! files lie. No number in a file makes memory be taken that the rest of the file could not fill. Faults are met where they stand, as bytes from the start;
//! lines are counted only for the message.

mod cursor;
mod gltf;
mod join;
mod kind;
mod made;
mod numerals;
mod obj;
mod ply;
mod points;
mod stl;
mod stretch;
mod swc;
#[cfg(test)]
mod tests;
mod text;
mod vtk;

use std::fs::File;
use std::io::{ErrorKind, Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use bytemuck::Zeroable;
use rayon::prelude::*;

use super::paint::Paint;
use super::unit::{Scale, Unit};
use super::{Mesh, MeshError, Place};
use crate::tree::{Cells, Tree, TreeError};

/// Bytes that a thread reads at once between two looks at whether to go on.
const PIECE: usize = 1 << 20;
/// Files from so many bytes on are looked at for whether they have to be in memory.
const STARTED_FROM: u64 = 4 << 20;
/// The start of a file that is looked at for that.
const START: usize = 256 << 10;

/// How much is read of a model; more is refused.
#[derive(Clone, Copy, Debug)]
pub struct ReadLimits {
    /// Length of the file, in bytes.
    pub bytes: u64,
    /// Vertices; vertex numbers end at 4294967294.
    pub vertices: usize,
    /// Triangles that all faces make.
    pub triangles: usize,
}

impl Default for ReadLimits {
    /// Several times the largest scans that are met: 4 GiB of file, 100 million vertices and triangles.
    fn default() -> Self {
        Self {
            bytes: 4 << 30,
            vertices: 100_000_000,
            triangles: 100_000_000,
        }
    }
}

/// What a file is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// PLY, numbers as text.
    AsciiPly,
    /// PLY, numbers as bytes of either order.
    BinaryPly,
    /// STL as text.
    AsciiStl,
    /// STL as bytes.
    BinaryStl,
    /// Wavefront OBJ.
    Obj,
    /// glTF 2.0, its description as text.
    Gltf,
    /// glTF 2.0 in one binary file.
    Glb,
    /// VTK PolyData as XML.
    Vtp,
    /// VTK PolyData in the legacy format.
    Vtk,
    /// A skeleton in the form of neuron atlases.
    Swc,
}

impl Format {
    /// Whether people may read it, so that places in it are lines.
    fn is_text(self) -> bool {
        !matches!(self, Self::BinaryPly | Self::BinaryStl | Self::Glb)
    }

    /// Whether it begins as text and may go on as bytes.
    fn may_turn_binary(self) -> bool {
        matches!(self, Self::Vtp | Self::Vtk)
    }
}

impl std::fmt::Display for Format {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        to.write_str(match self {
            Self::AsciiPly => "ASCII PLY",
            Self::BinaryPly => "binary PLY",
            Self::AsciiStl => "ASCII STL",
            Self::BinaryStl => "binary STL",
            Self::Obj => "OBJ",
            Self::Gltf => "glTF",
            Self::Glb => "GLB",
            Self::Vtp => "VTP",
            Self::Vtk => "legacy VTK",
            Self::Swc => "SWC",
        })
    }
}

/// A model as its file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Its surface, with one triangle at least; all vertex numbers are in range and all coordinates finite.
    pub mesh: Mesh,
    /// What it was written in.
    pub format: Format,
    /// Length of the file.
    pub file_bytes: u64,
    /// Faces of fewer than three vertices, which were left out.
    pub skipped_faces: usize,
    /// What colours the surface, where the file says.
    pub paint: Option<Paint>,
    /// What of the file is not shown, or not as it was meant, in a sentence each.
    pub remarks: Vec<String>,
    /// Lines that stand beside the surface and were left out.
    pub skipped_lines: usize,
    /// Points that stand beside the surface as cells of their own and were left out.
    pub skipped_points: usize,
    /// Bytes behind the end of what the file announces, which were not looked at.
    pub surplus_bytes: usize,
    /// The skeleton that the file holds instead of a surface, which is then that of the skeleton's tubes; positions are counted from
    /// the mesh's origin, as its vertices are, and all lengths are in the file's unit.
    pub skeleton: Option<Tree>,
}

impl Model {
    /// What the format, by its rules or by custom, says of the unit.
    pub fn scale(&self) -> Option<Scale> {
        match self.format {
            Format::Gltf | Format::Glb => Some(Scale::stated(Unit::Metres)),
            Format::Swc => Some(Scale::customary(Unit::Micrometres)),
            _ => None,
        }
    }
}

/// Reads a model; its format is told by its content.
///
/// Polygons are cut into fans from their first vertex. Coordinates are counted from an origin on each axis on which the model stands
/// farther from zero than it is large, else from zero.
///
/// # Errors
/// What is wrong first, with the line or byte, and the file.
pub fn read(path: &Path, limits: &ReadLimits, cancel: &AtomicBool) -> Result<Model, MeshError> {
    let task = Task {
        limits,
        cancel,
        folder: Some(path.parent().unwrap_or(Path::new(""))),
    };
    let model = open(path, limits).and_then(|(file, length)| {
        if let Some(model) = read_start(&file, length, &task) {
            return model;
        }
        read_model(&load(file, length, limits, cancel)?, &task)
    });
    model.map_err(|fault| match fault {
        MeshError::Cancelled => fault,
        fault => MeshError::In {
            fault: Box::new(fault),
            path: path.to_owned(),
        },
    })
}

/// Reads a model from the bytes of a file, as [`read`] does; other files that it names are not opened.
///
/// # Errors
/// What is wrong first, with the line or byte.
pub fn read_bytes(
    bytes: &[u8],
    limits: &ReadLimits,
    cancel: &AtomicBool,
) -> Result<Model, MeshError> {
    let task = Task {
        limits,
        cancel,
        folder: None,
    };
    read_model(bytes, &task)
}

/// Reads a large file of which the start says where all else stands, without ever having the whole in memory; none where it is no such file.
fn read_start(file: &File, length: u64, task: &Task<'_>) -> Option<Result<Model, MeshError>> {
    if length < STARTED_FROM {
        return None;
    }
    let mut start = vec![0; START];
    let filled = fill(file, 0, &mut start, task.cancel).ok()?;
    let start = start.get(..filled)?;
    if !kind::is_vtk_xml(start) {
        return None;
    }
    let read = vtk::xml::read_start(start, (file, usize::try_from(length).ok()?), task)?;
    Some(model(read, Format::Vtp, start, length))
}

fn read_model(bytes: &[u8], task: &Task<'_>) -> Result<Model, MeshError> {
    let file_bytes = bytes.len() as u64;
    check_length(file_bytes, task.limits)?;
    let format = kind::of(bytes)?;
    let read = match format {
        Format::AsciiPly | Format::BinaryPly => ply::read(bytes, task),
        Format::AsciiStl => stl::ascii::read(bytes, task),
        Format::BinaryStl => stl::binary::read(bytes, task),
        Format::Obj => obj::read(bytes, task),
        Format::Gltf => gltf::read(bytes, task),
        Format::Glb => gltf::read_binary(bytes, task),
        Format::Vtp => vtk::xml::read(bytes, task),
        Format::Vtk => vtk::legacy::read(bytes, task),
        Format::Swc => swc::read(bytes, task),
    };
    model(read, format, bytes, file_bytes)
}

/// What a reader made, or the fault that people are told; `bytes`: what it looked at.
fn model(
    read: Result<Surface, Stop>,
    format: Format,
    bytes: &[u8],
    file_bytes: u64,
) -> Result<Model, MeshError> {
    let Surface {
        mesh,
        skipped_faces,
        paint,
        remarks,
        skipped_lines,
        skipped_points,
        surplus_bytes,
        skeleton,
    } = read.map_err(|stop| stop.told(format, bytes))?;
    if mesh.triangles.is_empty() {
        let vertices = mesh.positions.len();
        return Err(match skipped_lines {
            0 => MeshError::NoTriangle { format, vertices },
            lines => MeshError::OnlyLines { format, lines },
        });
    }
    Ok(Model {
        mesh,
        format,
        file_bytes,
        skipped_faces,
        paint,
        remarks,
        skipped_lines,
        skipped_points,
        surplus_bytes,
        skeleton,
    })
}

fn check_length(bytes: u64, limits: &ReadLimits) -> Result<(), MeshError> {
    let most = limits.bytes;
    if bytes > most {
        return Err(MeshError::TooLong { bytes, most });
    }
    Ok(())
}

/// Opens a file, and says how long it is.
fn open(path: &Path, limits: &ReadLimits) -> Result<(File, u64), MeshError> {
    // Asked before it is opened: to open a pipe waits for its other end.
    let about = std::fs::metadata(path)?;
    if !about.is_file() {
        return Err(MeshError::NotAFile);
    }
    check_length(about.len(), limits)?;
    Ok((File::open(path)?, about.len()))
}

/// The whole file, in huge pages where the system has them: to touch fresh small ones takes as long as the copy. By all threads, since of a file in the
/// system's cache the copy is a third of what reading plain numbers takes.
fn load(
    mut file: File,
    length: u64,
    limits: &ReadLimits,
    cancel: &AtomicBool,
) -> Result<Cells<u8>, MeshError> {
    let bytes = usize::try_from(length).ok().and_then(Cells::unwritten);
    let mut bytes = bytes.ok_or(MeshError::Memory(length))?;
    let pieces = bytes.par_chunks_mut(PIECE).enumerate();
    let filled = pieces.map(|(piece, to)| fill(&file, (piece * PIECE) as u64, to, cancel));
    let filled: Vec<usize> = filled.collect::<Result<_, _>>()?;
    // What one lacks at its end, those behind it lack whole.
    let filled: usize = filled.into_iter().sum();
    if filled < bytes.len() {
        bytes.resize(filled, 0); // it has become shorter meanwhile
        return Ok(bytes);
    }
    file.seek(SeekFrom::Start(length))?;
    rest(bytes, file, limits, cancel)
}

/// Fills a piece with what stands in a file from a byte on, and says with how much.
fn fill(file: &File, from: u64, to: &mut [u8], cancel: &AtomicBool) -> Result<usize, MeshError> {
    let mut filled = 0;
    while filled < to.len() {
        if cancel.load(Ordering::Relaxed) {
            return Err(MeshError::Cancelled);
        }
        match read_at(file, &mut to[filled..], from + filled as u64) {
            Ok(0) => break,
            Ok(read) => filled += read,
            Err(fault) if fault.kind() == ErrorKind::Interrupted => {}
            Err(fault) => return Err(fault.into()),
        }
    }
    Ok(filled)
}

/// Reads from a byte on, whichever was read before.
#[cfg(unix)]
fn read_at(file: &File, to: &mut [u8], from: u64) -> std::io::Result<usize> {
    std::os::unix::fs::FileExt::read_at(file, to, from)
}

/// Reads from a byte on, whichever was read before.
#[cfg(windows)]
fn read_at(file: &File, to: &mut [u8], from: u64) -> std::io::Result<usize> {
    std::os::windows::fs::FileExt::seek_read(file, to, from)
}

/// What a file has grown by since it was asked for its length: nothing, nearly always.
fn rest(
    mut bytes: Cells<u8>,
    mut file: File,
    limits: &ReadLimits,
    cancel: &AtomicBool,
) -> Result<Cells<u8>, MeshError> {
    let mut piece = Vec::new();
    loop {
        if cancel.load(Ordering::Relaxed) {
            return Err(MeshError::Cancelled);
        }
        piece.clear();
        let read = file.by_ref().take(PIECE as u64).read_to_end(&mut piece)?;
        if read == 0 {
            return Ok(bytes);
        }
        check_length(bytes.len() as u64 + read as u64, limits)?;
        bytes.extend(piece.iter().copied());
    }
}

/// What a reader made of a file; the fields are those of [`Model`].
#[derive(Default)]
struct Surface {
    mesh: Mesh,
    skipped_faces: usize,
    paint: Option<Paint>,
    remarks: Vec<String>,
    skipped_lines: usize,
    skipped_points: usize,
    surplus_bytes: usize,
    skeleton: Option<Tree>,
}

/// What each reader is given beside the bytes.
struct Task<'a> {
    limits: &'a ReadLimits,
    cancel: &'a AtomicBool,
    /// Where other files are that the model may name; none of them is opened where there is no folder.
    folder: Option<&'a Path>,
}

/// Why a reader ended early.
#[derive(Debug)]
enum Stop {
    Cancelled,
    /// A fault at a byte from the start of what was read, as the rest of a sentence.
    Fault {
        at: usize,
        problem: String,
    },
    /// A fault of something that has a number, as the rest of a sentence.
    Item {
        what: &'static str,
        number: usize,
        problem: String,
    },
    Extension {
        name: String,
        mend: &'static str,
    },
    TooMany {
        what: &'static str,
        most: usize,
    },
    Memory(u64),
    /// A skeleton that is none.
    Skeleton(TreeError),
}

impl Stop {
    fn fault(at: usize, problem: impl Into<String>) -> Self {
        let problem = problem.into();
        Self::Fault { at, problem }
    }

    fn item(what: &'static str, number: usize, problem: impl Into<String>) -> Self {
        let problem = problem.into();
        Self::Item {
            what,
            number,
            problem,
        }
    }

    /// The same fault when what was read began at this byte of the file.
    fn moved(self, by: usize) -> Self {
        match self {
            Self::Fault { at, problem } => Self::Fault {
                at: at + by,
                problem,
            },
            other => other,
        }
    }

    /// As people are told it.
    fn told(self, format: Format, bytes: &[u8]) -> MeshError {
        match self {
            Self::Cancelled => MeshError::Cancelled,
            Self::TooMany { what, most } => MeshError::TooMany { what, most },
            Self::Memory(bytes) => MeshError::Memory(bytes),
            Self::Extension { name, mend } => MeshError::Extension { format, name, mend },
            Self::Item {
                what,
                number,
                problem,
            } => MeshError::Damaged {
                format,
                place: Place::Item(what, number),
                problem,
            },
            Self::Skeleton(fault) => MeshError::Skeleton(fault),
            Self::Fault { at, problem } => {
                let before = bytes.get(..at).unwrap_or(bytes);
                let has_lines = format.is_text()
                    && (!format.may_turn_binary() || before.iter().copied().all(kind::is_text));
                let place = if has_lines {
                    Place::Line(1 + before.iter().filter(|&&byte| byte == b'\n').count())
                } else {
                    Place::Byte(at)
                };
                MeshError::Damaged {
                    format,
                    place,
                    problem,
                }
            }
        }
    }
}

impl Task<'_> {
    /// Asked every few milliseconds of work.
    fn go_on(&self) -> Result<(), Stop> {
        if self.cancel.load(Ordering::Relaxed) {
            return Err(Stop::Cancelled);
        }
        Ok(())
    }

    fn check_vertices(&self, count: usize) -> Result<(), Stop> {
        within("vertices", count, self.limits.vertices.min(MOST_VERTICES))
    }

    fn check_triangles(&self, count: usize) -> Result<(), Stop> {
        within("triangles", count, self.limits.triangles)
    }
}

/// Vertices that have numbers of 32 bits, one number left over for "none".
const MOST_VERTICES: usize = u32::MAX as usize;

fn within(what: &'static str, count: usize, most: usize) -> Result<(), Stop> {
    if count > most {
        return Err(Stop::TooMany { what, most });
    }
    Ok(())
}

/// So many zeros; the caller has seen that the file can fill them. Their pages are asked for where they are first written to, which all
/// threads do at once.
fn zeroed<T: Zeroable>(count: usize) -> Result<Vec<T>, Stop> {
    let bytes = count.saturating_mul(size_of::<T>()) as u64;
    let zeros = bytemuck::allocation::try_zeroed_slice_box(count);
    zeros.map(Vec::from).map_err(|()| Stop::Memory(bytes))
}

/// An empty vector with room for so many; the caller has seen that the file can fill it.
fn with_room<T>(count: usize) -> Result<Vec<T>, Stop> {
    let mut room = Vec::new();
    let bytes = count.saturating_mul(size_of::<T>()) as u64;
    let given = room.try_reserve_exact(count);
    given.map_err(|_| Stop::Memory(bytes))?;
    Ok(room)
}
