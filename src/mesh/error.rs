//! Everything that can go wrong with models and their files, each in one sentence that says how to mend it.

use std::path::PathBuf;

use super::read::Format;
use crate::tree::TreeError;

/// An error of the room `mesh`.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// What is wrong with a file's content, and which file it is.
    #[error("{fault}: {path}", path = path.display())]
    In {
        /// What is wrong.
        fault: Box<MeshError>,
        /// The file.
        path: PathBuf,
    },
    /// The file could not be read at all.
    #[error("the model cannot be read ({0}): check that the file is there and may be read")]
    File(#[from] std::io::Error),
    /// A folder, a pipe or a device.
    #[error("a model is read from a plain file, and this is none: give the file itself")]
    NotAFile,
    /// The file is longer than is read.
    #[error("the file has {bytes} bytes, more than the {most} that are read: simplify the model")]
    TooLong {
        /// Its length.
        bytes: u64,
        /// [`super::ReadLimits::bytes`].
        most: u64,
    },
    /// More vertices or triangles than are read.
    #[error("the model has more than the {most} {what} that are read: simplify it")]
    TooMany {
        /// "vertices" or "triangles".
        what: &'static str,
        /// The limit.
        most: usize,
    },
    /// The machine did not give the memory.
    #[error(
        "the machine does not give the memory for this model ({0} bytes at once): close other programs, or simplify it"
    )]
    Memory(u64),
    /// A format that is known and not read.
    #[error("this is {0}, which is not read: save the model as PLY, STL, OBJ or VTP")]
    Unsupported(&'static str),
    /// A file that asks for what is not read.
    #[error("the {format} file needs the extension {name}, which is not read: {mend}")]
    Extension {
        /// Its format.
        format: Format,
        /// The extension.
        name: String,
        /// How to mend it.
        mend: &'static str,
    },
    /// An image of a model that cannot be shown; the model itself can.
    #[error("the image {name} cannot be shown: {problem}")]
    Image {
        /// Its name or number.
        name: String,
        /// What is wrong and how to mend it.
        problem: String,
    },
    /// A file of which the content tells nothing.
    #[error("the content is of no format that is known: save the model as PLY, STL, OBJ or VTP")]
    Unknown,
    /// A file without a single byte.
    #[error("the file is empty: save the model again")]
    Empty,
    /// A model without a surface.
    #[error(
        "the {format} file has {vertices} vertices and no triangle: save the surface, not points or lines alone"
    )]
    NoTriangle {
        /// Its format.
        format: Format,
        /// Vertices that were read.
        vertices: usize,
    },
    /// Lines, and no surface.
    #[error(
        "the {format} file has {lines} lines and no triangle, as centerlines and skeletons have, but no radii: give the surface that they were made from, or save the skeleton as SWC, or as VTP with the point array MaximumInscribedSphereRadius"
    )]
    OnlyLines {
        /// Its format.
        format: Format,
        /// Lines, each of any length.
        lines: usize,
    },
    /// A skeleton that cannot be read.
    #[error(transparent)]
    Skeleton(#[from] TreeError),
    /// A place that cannot be understood.
    #[error("{place} of the {format} file {problem}")]
    Damaged {
        /// Its format.
        format: Format,
        /// Where.
        place: Place,
        /// What is wrong and how to mend it, as the rest of the sentence.
        problem: String,
    },
    /// Somebody asked that the work end.
    #[error("reading the model was cancelled")]
    Cancelled,
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of text, from 1.
    Line(usize),
    /// A byte, from 0.
    Byte(usize),
    /// One of the things that the file lists, and its number there, from 0.
    Item(&'static str, usize),
}

impl std::fmt::Display for Place {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Line(line) => write!(to, "line {line}"),
            Self::Byte(byte) => write!(to, "byte {byte}"),
            Self::Item(what, number) => write!(to, "{what} {number}"),
        }
    }
}
