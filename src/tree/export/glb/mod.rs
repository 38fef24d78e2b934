//! glTF 2.0 in its binary form: a node named as the tree, below it one with a mesh for each thing that it is made of: wood with bark (normals,
//! texture coordinates), leaves, blossom and the like (normals, colours at the vertices). A grove has a node for each tree in between.
//!
//! ```text
//! Stand ─▶ surfaces (what there is of each group) ─▶ Document: JSON, and which pieces follow ─▶ pieces written one by one
//! ```
//!
//! Leaves may be instances ([`placed`]), vertices may have numbers for the wind ([`super::wind`]) and places of earlier steps ([`growth`]).
//!
//! Metres, Y up, right-handed: glTF's own convention and ours, so nothing is turned. Textures are embedded; trees of a grove share them, and materials.
//! Specification: <https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html> (§4.4 for the chunks).

use std::io::{self, Write};

use bytemuck::{Pod, cast_slice};

use super::surface::{Costs, Matter, Standing, Surface, fits, most_bytes, standing};
use super::{ExportParams, Stand, TREE, unfold, wind};
use crate::tree::organs::{Colour, Numbers, Organs};
use crate::tree::{Tree, TreeError};

mod document;
mod growth;
mod placed;

use document::Document;
use placed::Place;

/// Position, normal, texture coordinates or colour, and (about six to each) indices.
const VERTEX_BYTES: u64 = 12 + 12 + 8 + 6 * 4;
/// What the wind takes: texture coordinates where there were none, and four short numbers.
const WIND_BYTES: u64 = 8 + 8;
/// A vertex of a morph target.
const MORPH_BYTES: u64 = 12;
/// Rows that are made at a time.
const AT_ONCE: usize = 4096;

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
    /// Of what stands as instances: a run of the tree of a number.
    Run {
        tree: usize,
        run: usize,
        what: Place,
    },
    /// What is small.
    Bytes(Vec<u8>),
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
    /// Texture coordinates of what has colours.
    LeafCoordinates,
    /// Sway and phase.
    Trunk,
    /// Branch and flutter.
    Branch,
    /// How far the growth of a step moves vertices, backwards.
    Moved(u32),
}

/// Memory that is used for one piece after the other: given back each time, its pages would be asked for anew, which took a third of the time.
#[derive(Default)]
struct Scratch {
    indices: Vec<u32>,
    colours: Vec<[u16; 4]>,
}

/// A GLB file that is checked and not written yet.
#[derive(Debug)]
pub struct Glb<'a> {
    /// All before the binary chunk's contents.
    head: Vec<u8>,
    trees: Vec<Standing<'a>>,
    pieces: Vec<Piece>,
    /// Of all of it.
    bytes: u64,
}

fn costs(stand: &Stand<'_>) -> Costs {
    let extras = &stand.extras;
    let wind = if extras.wind { WIND_BYTES } else { 0 };
    Costs {
        vertex: VERTEX_BYTES + wind + MORPH_BYTES * u64::from(extras.morphs),
        instance: Place::BYTES,
        once: true,
    }
}

impl<'a> Glb<'a> {
    /// Whether there is room in such a file for all that stands in it, before any surface is made.
    ///
    /// # Errors
    /// [`TreeError::TooLarge`].
    pub fn check(stand: &Stand<'_>) -> Result<(), TreeError> {
        fits(stand, "GLB", costs(stand))
    }

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
        let trees = standing(stand, "GLB", costs(stand))?;
        let document = Document::of(stand, &trees)?;
        let (head, pieces) = document.head().ok_or(TreeError::TooLarge {
            format: "GLB",
            bytes: most_bytes(stand, costs(stand)),
        })?;
        // The header tells the length.
        let length = head.get(8..).and_then(<[u8]>::first_chunk);
        Ok(Self {
            bytes: length.map_or(0, |length| u64::from(u32::from_le_bytes(*length))),
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
        let mut scratch = Scratch::default();
        for piece in &self.pieces {
            match piece {
                // Both of whole words throughout.
                Piece::Group { tree, matter, what } => {
                    self.write_group(*tree, *matter, *what, &mut scratch, out)?;
                }
                Piece::Run { tree, run, what } => {
                    let surface = self.trees.get(*tree).map(|one| &one.surface);
                    let run = surface.and_then(|surface| surface.runs.get(*run));
                    for (surface, run) in surface.into_iter().zip(run) {
                        what.write(surface, run, out)?;
                    }
                }
                Piece::Bytes(bytes) => padded(bytes, out)?,
                Piece::Picture(bytes) => padded(bytes, out)?,
            }
        }
        Ok(())
    }

    /// Bytes of the whole file.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    fn write_group(
        &self,
        tree: usize,
        matter: Matter,
        what: What,
        Scratch { indices, colours }: &mut Scratch,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let Some(Standing { surface, .. }) = self.trees.get(tree) else {
            return Ok(());
        };
        if let Some(written) = write_more(surface, matter, what, out) {
            return written;
        }
        let numbers = match what {
            What::Positions => Numbers::POSITIONS,
            What::Normals => Numbers::NORMALS,
            What::Colours => Numbers::COLOURS,
            What::Indices => Numbers::INDICES,
            _ => Numbers::NONE,
        };
        surface.each(matter, numbers, |part, before| match what {
            What::Positions => out.write_all(cast_slice(part.positions)),
            What::Normals => out.write_all(cast_slice(part.normals)),
            What::Coordinates => out.write_all(cast_slice(part.uvs)),
            What::Colours => {
                colours.clear();
                colours.extend(part.colours.iter().map(|colour| short(*colour)));
                out.write_all(cast_slice(colours))
            }
            What::Indices => {
                indices.clear();
                indices.extend(part.indices.iter().map(|index| index + before));
                out.write_all(cast_slice(indices))
            }
            _ => Ok(()),
        })
    }
}

/// Writes what is no part of the surface itself; `None` where it is.
fn write_more(
    surface: &Surface<'_>,
    matter: Matter,
    what: What,
    out: &mut dyn Write,
) -> Option<io::Result<()>> {
    Some(match what {
        What::LeafCoordinates => gathered(out, |take| wind::coordinates(surface, matter, take)),
        What::Trunk => gathered(out, |take| {
            wind::each(surface, matter, |[sway, phase, ..]| {
                take(shorts([sway, phase]))
            });
        }),
        What::Branch => gathered(out, |take| {
            wind::each(surface, matter, |[.., branch, flutter]| {
                take(shorts([branch, flutter]));
            });
        }),
        What::Moved(step) => gathered(out, |take| unfold::moved(surface, matter, step, take)),
        _ => return None,
    })
}

/// Writes rows as they are made, some at a time.
fn gathered<T: Pod>(out: &mut dyn Write, make: impl FnOnce(&mut dyn FnMut(T))) -> io::Result<()> {
    let mut rows: Vec<T> = Vec::with_capacity(AT_ONCE);
    let mut written = Ok(());
    make(&mut |row| {
        rows.push(row);
        if rows.len() == AT_ONCE {
            if written.is_ok() {
                written = out.write_all(cast_slice(&rows));
            }
            rows.clear();
        }
    });
    written?;
    out.write_all(cast_slice(&rows))
}

/// Writes up to a multiple of four bytes.
fn padded(bytes: &[u8], out: &mut dyn Write) -> io::Result<()> {
    out.write_all(bytes)?;
    let padding = bytes.len().next_multiple_of(4) - bytes.len();
    out.write_all(&[0; 3][..padding])
}

/// A linear colour as glTF's vertices hold it.
fn short([r, g, b]: Colour) -> [u16; 4] {
    [part_of(r), part_of(g), part_of(b), u16::MAX]
}

/// Numbers from 0 to 1 as parts of 65535.
fn shorts<const N: usize>(numbers: [f32; N]) -> [u16; N] {
    numbers.map(part_of)
}

/// The nearest part of 65535. (`round` would be a call on most processors.)
fn part_of(number: f32) -> u16 {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 65535, and `as` saturates"
    )]
    let part = (number * 65535.0 + 0.5) as u16;
    part
}
