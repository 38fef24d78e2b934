//! Wavefront OBJ: positions, texture coordinates, normals, triangles, and colours where something is painted.
//!
//! Colours stand behind the positions (`v x y z r g b`, sRGB as MeshLab and Blender write and read them), once one thing is painted on all
//! vertices, since readers take colours for all or none. No material: an OBJ would need a second file (`.mtl`) and a third (the
//! picture) beside it, and a reader that finds a material named but not its file warns or fails. Who wants bark and
//! materials takes the GLB; the texture coordinates are here too.

use std::io::{self, Write};

use super::ExportParams;
use super::surface::{Matter, Surface};
use crate::tree::organs::{Organs, bark_colour, srgb};
use crate::tree::{Tree, TreeError};

/// What the text of one vertex with its share of the faces takes at most, roughly.
const VERTEX_BYTES: u64 = 65 + 40 + 30 + 2 * 60;

/// The tree as an OBJ file, in metres, Y up.
///
/// # Errors
/// As [`Obj::new`].
pub fn obj(tree: &Tree, params: &ExportParams) -> Result<Vec<u8>, TreeError> {
    let organs = Organs::default();
    let file = Obj::new(tree, &organs, params)?;
    let mut text = Vec::new();
    let _ = file.write(&mut text); // Writing into a vector cannot fail.
    Ok(text)
}

/// An OBJ file that is checked and not written yet.
#[derive(Debug)]
pub struct Obj<'a> {
    surface: Surface<'a>,
    segments: usize,
}

impl<'a> Obj<'a> {
    /// Checks a tree and what it carries.
    ///
    /// # Errors
    /// A tree that breaks an invariant, has nothing to draw or is too large; sides outside 3 to 64.
    pub fn new(tree: &Tree, organs: &'a Organs, params: &ExportParams) -> Result<Self, TreeError> {
        Ok(Self {
            surface: Surface::new(tree, organs, params, "OBJ", VERTEX_BYTES)?,
            segments: tree.segment_count(),
        })
    }

    /// Writes the file, part by part.
    ///
    /// # Errors
    /// What `out` fails in.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "# Ramus {}: a tree of {} segments; metres, Y up",
            env!("CARGO_PKG_VERSION"),
            self.segments
        )?;
        writeln!(out, "o tree")?;
        let surface = &self.surface;
        let groups = &surface.groups;
        let painted = groups.iter().any(|group| group.matter != Matter::Bark);
        for group in groups {
            surface.each(group.matter, |part, _| {
                if !painted {
                    let mut lines = part.positions.iter();
                    return lines.try_for_each(|[x, y, z]| writeln!(out, "v {x} {y} {z}"));
                }
                for (at, [x, y, z]) in part.positions.iter().enumerate() {
                    let colour = part.colours.get(at).copied().unwrap_or_else(bark_colour);
                    let [r, g, b] = colour.map(srgb);
                    writeln!(out, "v {x} {y} {z} {r:.4} {g:.4} {b:.4}")?;
                }
                Ok(())
            })?;
        }
        for group in groups {
            surface.each(group.matter, |part, _| {
                let mut lines = part.uvs.iter();
                lines.try_for_each(|[u, v]| writeln!(out, "vt {u} {v}"))
            })?;
        }
        // Five digits are finer than any shading shows and halve the file.
        for group in groups {
            surface.each(group.matter, |part, _| {
                let mut lines = part.normals.iter();
                lines.try_for_each(|[x, y, z]| writeln!(out, "vn {x:.5} {y:.5} {z:.5}"))
            })?;
        }
        let mut first = 1;
        for group in groups {
            // Bark comes first, so its texture coordinates are numbered as its positions.
            let has_uvs = group.matter == Matter::Bark;
            surface.each(group.matter, |part, before| {
                part.indices.chunks_exact(3).try_for_each(|triangle| {
                    let [a, b, c] = [triangle[0], triangle[1], triangle[2]]
                        .map(|index| u64::from(index) + u64::from(before) + first);
                    if has_uvs {
                        writeln!(out, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")
                    } else {
                        writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")
                    }
                })
            })?;
            first += group.vertices as u64;
        }
        Ok(())
    }
}
