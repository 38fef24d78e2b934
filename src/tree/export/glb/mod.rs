//! glTF 2.0 in its binary form: a node named as the tree, below it one with a mesh for each thing that it is made of: wood with bark (normals,
//! texture coordinates), leaves, blossom and the like (normals, colours at the vertices). A grove has a node for each tree in between.
//!
//! ```text
//! Stand ─▶ surfaces (what there is of each group) ─▶ Document: JSON, and which pieces follow ─▶ pieces written one by one
//! ```
//!
//! Metres, Y up, right-handed: glTF's own convention and ours, so nothing is turned. Textures are embedded; trees of a grove share them, and materials.
//! Specification: <https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html> (§4.4 for the chunks).

use std::io::{self, Write};

use bytemuck::cast_slice;

use super::surface::{Matter, Standing, standing};
use super::{ExportParams, Stand, TREE};
use crate::tree::organs::{Colour, Organs};
use crate::tree::{Tree, TreeError};

mod document;

use document::Document;

/// Position, normal, texture coordinates or colour, and (about six to each) indices.
const VERTEX_BYTES: u64 = 12 + 12 + 8 + 6 * 4;

/// The tree as a GLB file.
///
/// # Errors
/// As [`Glb::new`].
pub fn glb(tree: &Tree, params: &ExportParams) -> Result<Vec<u8>, TreeError> {
    let organs = Organs::default();
    let file = Glb::new(tree, &organs, params)?;
    let mut bytes = Vec::new();
    let _ = file.write(&mut bytes); // Writing into a vector cannot fail.
    Ok(bytes)
}

/// What stands in the binary chunk, one behind the other.
#[derive(Debug)]
enum Piece {
    /// Of a group of the tree of a number.
    Group {
        tree: usize,
        matter: Matter,
        what: What,
    },
    /// A file of its own.
    Picture(&'static [u8]),
}

/// Numbers of one kind.
#[derive(Clone, Copy, Debug)]
enum What {
    Positions,
    Normals,
    Coordinates,
    Colours,
    Indices,
}

/// A GLB file that is checked and not written yet.
#[derive(Debug)]
pub struct Glb<'a> {
    /// All before the binary chunk's contents.
    head: Vec<u8>,
    trees: Vec<Standing<'a>>,
    pieces: Vec<Piece>,
}

impl<'a> Glb<'a> {
    /// Checks a tree and what it carries, and lays its file out.
    ///
    /// # Errors
    /// A tree that breaks an invariant, has nothing to draw or is too large for the format; sides outside 3 to 64.
    pub fn new(
        tree: &'a Tree,
        organs: &'a Organs,
        params: &ExportParams,
    ) -> Result<Self, TreeError> {
        Self::of(&Stand::of(TREE, tree, organs, params))
    }

    /// The same of all that stands in a file.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(stand: &Stand<'a>) -> Result<Self, TreeError> {
        let trees = standing(stand, "GLB", VERTEX_BYTES)?;
        let document = Document::of(stand, &trees)?;
        let (head, pieces) = document.head().ok_or(TreeError::TooLarge {
            format: "GLB",
            segments: stand.segments(),
            sides: stand.sides(),
        })?;
        Ok(Self {
            head,
            trees,
            pieces,
        })
    }

    /// Writes the file, part by part.
    ///
    /// # Errors
    /// What `out` fails in.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(&self.head)?;
        for piece in &self.pieces {
            match piece {
                Piece::Group { tree, matter, what } => {
                    // Of whole words throughout.
                    self.write_group(*tree, *matter, *what, out)?;
                }
                Piece::Picture(bytes) => {
                    out.write_all(bytes)?;
                    let padding = bytes.len().next_multiple_of(4) - bytes.len();
                    out.write_all(&[0; 3][..padding])?;
                }
            }
        }
        Ok(())
    }

    fn write_group(
        &self,
        tree: usize,
        matter: Matter,
        what: What,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let Some(Standing { surface, .. }) = self.trees.get(tree) else {
            return Ok(());
        };
        let mut indices: Vec<u32> = Vec::new();
        let mut colours: Vec<[u16; 4]> = Vec::new();
        surface.each(matter, |part, before| match what {
            What::Positions => out.write_all(cast_slice(&part.positions)),
            What::Normals => out.write_all(cast_slice(&part.normals)),
            What::Coordinates => out.write_all(cast_slice(&part.uvs)),
            What::Colours => {
                colours.clear();
                colours.extend(part.colours.iter().map(|colour| short(*colour)));
                out.write_all(cast_slice(&colours))
            }
            What::Indices => {
                indices.clear();
                indices.extend(part.indices.iter().map(|index| index + before));
                out.write_all(cast_slice(&indices))
            }
        })
    }
}

/// A linear colour as glTF's vertices hold it.
fn short([r, g, b]: Colour) -> [u16; 4] {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 65535, and `as` saturates"
    )]
    [r, g, b, 1.0].map(|part| (part * 65535.0).round() as u16)
}
