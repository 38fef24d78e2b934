//! Wavefront OBJ: positions, texture coordinates, normals, triangles.
//!
//! No material: an OBJ would need a second file (`.mtl`) and a third (the picture) beside it, and a reader that finds a
//! material named but not its file warns or fails. Who wants bark takes the GLB; the texture coordinates are here too.

use std::io::Write as _;

use super::{ExportParams, surface};
use crate::tree::{Tree, TreeError};

/// What the text of one vertex with its share of the faces takes at most, roughly.
const VERTEX_BYTES: u64 = 40 + 40 + 30 + 2 * 60;

/// The tree as an OBJ file, in metres, Y up.
///
/// # Errors
/// A tree that breaks an invariant, has no segment or is too large; sides outside 3 to 64.
pub fn obj(tree: &Tree, params: &ExportParams) -> Result<Vec<u8>, TreeError> {
    let mesh = surface(tree, params, "OBJ", VERTEX_BYTES)?;
    let mut text = Vec::with_capacity(mesh.positions.len() * 120);
    write_lines(&mut text, &mesh, tree.segment_count());
    Ok(text)
}

fn write_lines(text: &mut Vec<u8>, mesh: &crate::tree::mesh::TubeMesh, segments: usize) {
    // Writing into a vector cannot fail, so results are dropped.
    let _ = writeln!(
        text,
        "# Ramus {}: a tree of {segments} segments; metres, Y up",
        env!("CARGO_PKG_VERSION")
    );
    let _ = writeln!(text, "o tree");
    for [x, y, z] in &mesh.positions {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [u, v] in &mesh.uvs {
        let _ = writeln!(text, "vt {u} {v}");
    }
    // Five digits are finer than any shading shows and halve the file.
    for [x, y, z] in &mesh.normals {
        let _ = writeln!(text, "vn {x:.5} {y:.5} {z:.5}");
    }
    for triangle in mesh.indices.chunks_exact(3) {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(|index| u64::from(index) + 1);
        let _ = writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}");
    }
}
