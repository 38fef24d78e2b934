//! Wavefront OBJ: positions, texture coordinates, normals, triangles.
//!
//! No material: an OBJ would need a second file (`.mtl`) and a third (the picture) beside it, and a reader that finds a
//! material named but not its file warns or fails. Who wants bark takes the GLB; the texture coordinates are here too.

use std::io::{self, Write};

use super::{ExportParams, Surface};
use crate::tree::{Tree, TreeError};

/// What the text of one vertex with its share of the faces takes at most, roughly.
const VERTEX_BYTES: u64 = 40 + 40 + 30 + 2 * 60;

/// The tree as an OBJ file, in metres, Y up.
///
/// # Errors
/// As [`Obj::new`].
pub fn obj(tree: &Tree, params: &ExportParams) -> Result<Vec<u8>, TreeError> {
    let file = Obj::new(tree, params)?;
    let mut text = Vec::new();
    let _ = file.write(&mut text); // Writing into a vector cannot fail.
    Ok(text)
}

/// An OBJ file that is checked and not written yet.
#[derive(Debug)]
pub struct Obj {
    surface: Surface,
    segments: usize,
}

impl Obj {
    /// Checks a tree.
    ///
    /// # Errors
    /// A tree that breaks an invariant, has no segment or is too large; sides outside 3 to 64.
    pub fn new(tree: &Tree, params: &ExportParams) -> Result<Self, TreeError> {
        Ok(Self {
            surface: Surface::new(tree, params, "OBJ", VERTEX_BYTES)?,
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
        surface.each(|mesh, _| {
            let mut lines = mesh.positions.iter();
            lines.try_for_each(|[x, y, z]| writeln!(out, "v {x} {y} {z}"))
        })?;
        surface.each(|mesh, _| {
            let mut lines = mesh.uvs.iter();
            lines.try_for_each(|[u, v]| writeln!(out, "vt {u} {v}"))
        })?;
        // Five digits are finer than any shading shows and halve the file.
        surface.each(|mesh, _| {
            let mut lines = mesh.normals.iter();
            lines.try_for_each(|[x, y, z]| writeln!(out, "vn {x:.5} {y:.5} {z:.5}"))
        })?;
        surface.each(|mesh, before| {
            mesh.indices.chunks_exact(3).try_for_each(|triangle| {
                let [a, b, c] = [triangle[0], triangle[1], triangle[2]]
                    .map(|index| u64::from(index) + u64::from(before) + 1);
                writeln!(out, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")
            })
        })
    }
}
