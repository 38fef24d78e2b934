//! Why a mesh is not mended, in a sentence each.

use super::Mend;
use crate::mesh::report::ReportError;

/// Why a mesh is not mended.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MendError {
    /// Somebody asked to stop.
    #[error("mending the model was cancelled")]
    Cancelled,
    /// More triangles or vertices than can be mended.
    #[error(
        "the model has {triangles} triangles and {vertices} vertices, and {most} of each can be mended: cut it into parts"
    )]
    TooLarge {
        /// Triangles of the mesh.
        triangles: usize,
        /// Vertices of the mesh.
        vertices: usize,
        /// How many there may be.
        most: u64,
    },
    /// The machine did not give the memory.
    #[error(
        "the machine does not give the memory to mend this model ({0} bytes at once): close other programs, or simplify it"
    )]
    Memory(usize),
    /// There is no triangle with three different vertices.
    #[error("the model has no triangle with three different vertices, so there is nothing to mend")]
    Nothing,
    /// The mend would leave no triangle.
    #[error("`{0}` would leave no triangle of the model: give it a smaller value")]
    NothingLeft(Mend),
    /// Edges so short that there would be too many triangles.
    #[error(
        "`{mend}` would make about {triangles:.1e} triangles, and {most} can be made: ask for edges of {least:.3} or longer, or for fewer parts first (largest, debris)"
    )]
    TooFine {
        /// The mend.
        mend: Mend,
        /// About how many triangles.
        triangles: f64,
        /// How many are made at most.
        most: usize,
        /// The shortest edge that can be asked for, in the file's unit.
        least: f64,
    },
    /// The surface has no area to be cut into triangles of a size.
    #[error(
        "`{0}` asks for edges of no length, since the model has no size: give the length in the file's unit"
    )]
    NoLength(Mend),
}

impl From<ReportError> for MendError {
    fn from(error: ReportError) -> Self {
        match error {
            ReportError::Cancelled => Self::Cancelled,
            ReportError::TooLarge {
                triangles,
                vertices,
            } => Self::TooLarge {
                triangles,
                vertices,
                most: crate::mesh::report::TRIANGLES_MOST as u64,
            },
        }
    }
}
