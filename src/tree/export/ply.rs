//! Stanford PLY, binary: one mesh with normals, texture coordinates and colours at its vertices.
//!
//! Texture coordinates are `s` and `t`, as Blender and MeshLab name them, and 0 where something has none; colours are sRGB in bytes. What is painted has its
//! own colour, bark that of bark. (Turk 1994, "The PLY Polygon File Format".)

use std::io::{self, Write};

use bytemuck::{Pod, Zeroable, cast_slice};

use super::surface::{Costs, Standing, everywhere, fits, standing};
use super::{ExportParams, Stand, TREE};
use crate::tree::organs::{Colour, Numbers, Organs, bark_colour, srgb};
use crate::tree::{Tree, TreeError};

/// Records that are made at a time.
const AT_ONCE: usize = 1024;

/// A vertex as the file holds it, little-endian.
#[repr(C, packed)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Vertex {
    position: [[u8; 4]; 3],
    normal: [[u8; 4]; 3],
    uv: [[u8; 4]; 2],
    colour: [u8; 3],
}

/// A triangle as the file holds it.
#[repr(C, packed)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Face {
    corners: u8,
    vertices: [[u8; 4]; 3],
}

/// A PLY file that is checked and not written yet.
#[derive(Debug)]
pub struct Ply<'a> {
    trees: Vec<Standing<'a>>,
}

/// About two triangles to each vertex.
const COSTS: Costs = Costs {
    vertex: (size_of::<Vertex>() + 2 * size_of::<Face>()) as u64,
    instance: 0,
    once: false,
};

impl<'a> Ply<'a> {
    /// Checks a tree and what it carries.
    ///
    /// # Errors
    /// A tree that breaks an invariant, has nothing to draw or is too large; sides outside 3 to 64.
    pub fn new(
        tree: &'a Tree,
        organs: &'a Organs,
        params: &ExportParams,
    ) -> Result<Self, TreeError> {
        Self::of(&Stand::of(TREE, tree, organs, params))
    }

    /// Whether there is room in such a file for all that stands in it, before any surface is made.
    ///
    /// # Errors
    /// [`TreeError::TooLarge`].
    pub fn check(stand: &Stand<'_>) -> Result<(), TreeError> {
        fits(stand, "PLY", COSTS)
    }

    /// The same of all that stands in a file, as one mesh.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(stand: &Stand<'a>) -> Result<Self, TreeError> {
        Ok(Self {
            trees: standing(stand, "PLY", COSTS)?,
        })
    }

    /// Writes the file, part by part.
    ///
    /// # Errors
    /// What `out` fails in.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let groups = || {
            let trees = everywhere(&self.trees);
            trees.flat_map(|(one, place)| {
                let groups = one.surface.groups.iter();
                groups.map(move |group| (one, place, group))
            })
        };
        let vertices: usize = groups().map(|(_, _, group)| group.vertices).sum();
        let indices: usize = groups().map(|(_, _, group)| group.indices).sum();
        write!(
            out,
            "ply\nformat binary_little_endian 1.0\ncomment Ramus {}: metres, Y up\nelement vertex {vertices}\n",
            env!("CARGO_PKG_VERSION")
        )?;
        for name in ["x", "y", "z", "nx", "ny", "nz", "s", "t"] {
            writeln!(out, "property float {name}")?;
        }
        for name in ["red", "green", "blue"] {
            writeln!(out, "property uchar {name}")?;
        }
        let faces = indices / 3;
        write!(
            out,
            "element face {faces}\nproperty list uchar uint vertex_indices\nend_header\n"
        )?;
        let bark = eight_bits(bark_colour());
        let mut made: Vec<Vertex> = Vec::with_capacity(AT_ONCE);
        for (one, place, group) in groups() {
            one.surface
                .each(group.matter, Numbers::VERTICES, |part, _| {
                    let vertex = |at: usize| Vertex {
                        position: place.placed(part.positions[at]).map(f32::to_le_bytes),
                        normal: place.turned(part.normals[at]).map(f32::to_le_bytes),
                        uv: part
                            .uvs
                            .get(at)
                            .copied()
                            .unwrap_or_default()
                            .map(f32::to_le_bytes),
                        colour: part
                            .colours
                            .get(at)
                            .map_or(bark, |colour| eight_bits(*colour)),
                    };
                    in_pieces(part.vertices, &mut made, vertex, out)
                })?;
        }
        let mut made: Vec<Face> = Vec::with_capacity(AT_ONCE);
        let mut first = 0;
        for (one, _, group) in groups() {
            one.surface
                .each(group.matter, Numbers::INDICES, |part, before| {
                    let (triangles, _) = part.indices.as_chunks::<3>();
                    let face = |at: usize| Face {
                        corners: 3,
                        vertices: triangles[at].map(|index| (index + before + first).to_le_bytes()),
                    };
                    in_pieces(triangles.len(), &mut made, face, out)
                })?;
            // `Surface::new` refuses more vertices than fit.
            first += u32::try_from(group.vertices).unwrap_or(u32::MAX);
        }
        Ok(())
    }
}

/// Writes so many records, some at a time.
fn in_pieces<T: Pod>(
    count: usize,
    made: &mut Vec<T>,
    record: impl Fn(usize) -> T,
    out: &mut dyn Write,
) -> io::Result<()> {
    for first in (0..count).step_by(AT_ONCE) {
        made.clear();
        made.extend((first..count.min(first + AT_ONCE)).map(&record));
        out.write_all(cast_slice(made))?;
    }
    Ok(())
}

/// A linear colour in sRGB bytes.
pub(super) fn eight_bits(colour: Colour) -> [u8; 3] {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 255, and `as` saturates"
    )]
    colour.map(|part| (srgb(part) * 255.0).round() as u8)
}
