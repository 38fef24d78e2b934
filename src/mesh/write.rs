//! Meshes written for other programs: GLB, binary PLY, binary STL, OBJ, by the ending of the name.
//!
//! Coordinates are the file's own, in the file's own unit and axes; only glTF says that a number is a metre, so a model in millimetres is a thousand
//! times as large for a reader of GLB as it is. Where the mesh has an origin of its own, PLY and OBJ have it added in double precision and GLB
//! as the node's place, so nothing is lost; STL knows single precision only.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use bytemuck::cast_slice;
use glam::{DVec3, Vec3};
use serde_json::json;

use super::Mesh;

/// Bytes of the longest file that GLB's header can tell, less those of the header.
const GLB_MOST: u64 = (u32::MAX as u64) - (1 << 16);

/// What a mesh is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteFormat {
    /// glTF 2.0 as one file.
    Glb,
    /// Binary PLY, little-endian.
    Ply,
    /// Binary STL.
    Stl,
    /// Wavefront OBJ.
    Obj,
}

/// Why a mesh cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WriteError {
    /// An ending that tells no format.
    #[error("the ending of {0} tells no format for a model: give it .glb, .ply, .stl or .obj")]
    Ending(String),
    /// More than the format can hold.
    #[error("the mesh is too large for a GLB file, which has 4 GiB at most: write it as PLY")]
    TooLarge,
}

impl WriteFormat {
    /// By the ending of a name, whatever its case.
    ///
    /// # Errors
    /// [`WriteError::Ending`].
    pub fn of(path: &Path) -> Result<Self, WriteError> {
        let ending = path.extension().and_then(|ending| ending.to_str());
        match ending.map(str::to_lowercase).as_deref() {
            Some("glb") => Ok(Self::Glb),
            Some("ply") => Ok(Self::Ply),
            Some("stl") => Ok(Self::Stl),
            Some("obj") => Ok(Self::Obj),
            _ => Err(WriteError::Ending(path.display().to_string())),
        }
    }

    /// Whether the format can hold a mesh.
    ///
    /// # Errors
    /// [`WriteError::TooLarge`].
    pub fn check(self, mesh: &Mesh) -> Result<(), WriteError> {
        let bytes = 12 * (mesh.positions.len() as u64 + mesh.triangles.len() as u64);
        match self == Self::Glb && bytes > GLB_MOST {
            true => Err(WriteError::TooLarge),
            false => Ok(()),
        }
    }

    /// Writes a mesh, part by part; all its vertex numbers are in range.
    ///
    /// # Errors
    /// What `out` fails in.
    pub fn write(self, mesh: &Mesh, out: &mut dyn Write) -> io::Result<()> {
        let mut out = BufWriter::with_capacity(1 << 16, out);
        match self {
            Self::Glb => glb(mesh, &mut out),
            Self::Ply => ply(mesh, &mut out),
            Self::Stl => stl(mesh, &mut out),
            Self::Obj => obj(mesh, &mut out),
        }?;
        out.flush()
    }
}

/// A vertex in the file's coordinates.
fn place(mesh: &Mesh, position: Vec3) -> DVec3 {
    mesh.origin + position.as_dvec3()
}

fn ply(mesh: &Mesh, out: &mut dyn Write) -> io::Result<()> {
    let is_double = mesh.origin != DVec3::ZERO;
    let number = if is_double { "double" } else { "float" };
    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment Ramus")?;
    writeln!(out, "element vertex {}", mesh.positions.len())?;
    for axis in ["x", "y", "z"] {
        writeln!(out, "property {number} {axis}")?;
    }
    writeln!(out, "element face {}", mesh.triangles.len())?;
    writeln!(out, "property list uchar uint vertex_indices\nend_header")?;
    for position in &mesh.positions {
        if is_double {
            let place = place(mesh, *position).to_array();
            place
                .iter()
                .try_for_each(|c| out.write_all(&c.to_le_bytes()))?;
        } else {
            floats(*position, out)?;
        }
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        triangle
            .iter()
            .try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
    }
    Ok(())
}

fn floats(point: Vec3, out: &mut dyn Write) -> io::Result<()> {
    let mut coordinates = point.to_array().into_iter();
    coordinates.try_for_each(|c| out.write_all(&c.to_le_bytes()))
}

fn stl(mesh: &Mesh, out: &mut dyn Write) -> io::Result<()> {
    let mut header = [b' '; 80];
    for (byte, letter) in header.iter_mut().zip(b"Ramus") {
        *byte = *letter;
    }
    out.write_all(&header)?;
    let count = u32::try_from(mesh.triangles.len()).map_err(io::Error::other)?;
    out.write_all(&count.to_le_bytes())?;
    for triangle in &mesh.triangles {
        let corners = triangle.map(|vertex| mesh.positions[vertex as usize]);
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        floats((b - a).cross(c - a).normalize_or_zero().as_vec3(), out)?;
        for corner in corners {
            floats(place(mesh, corner).as_vec3(), out)?;
        }
        out.write_all(&[0, 0])?;
    }
    Ok(())
}

fn obj(mesh: &Mesh, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "# Ramus {}", env!("CARGO_PKG_VERSION"))?;
    let is_double = mesh.origin != DVec3::ZERO;
    for position in &mesh.positions {
        if is_double {
            let DVec3 { x, y, z } = place(mesh, *position);
            writeln!(out, "v {x} {y} {z}")?;
        } else {
            let Vec3 { x, y, z } = *position;
            writeln!(out, "v {x} {y} {z}")?;
        }
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| u64::from(vertex) + 1);
        writeln!(out, "f {a} {b} {c}")?;
    }
    Ok(())
}

fn glb(mesh: &Mesh, out: &mut dyn Write) -> io::Result<()> {
    let (positions, indices) = (12 * mesh.positions.len(), 12 * mesh.triangles.len());
    let bounds = |of: fn(Vec3, Vec3) -> Vec3| {
        let corner = mesh.positions.iter().copied().reduce(of);
        corner.unwrap_or_default().to_array()
    };
    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("Ramus ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "model", "mesh": 0, "translation": mesh.origin.to_array() }],
        "meshes": [{ "name": "model", "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": mesh.positions.len(), "type": "VEC3",
                "min": bounds(Vec3::min), "max": bounds(Vec3::max),
            },
            { "bufferView": 1, "componentType": 5125, "count": 3 * mesh.triangles.len(), "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": positions, "target": 34962 },
            { "buffer": 0, "byteOffset": positions, "byteLength": indices, "target": 34963 },
        ],
        "buffers": [{ "byteLength": positions + indices }],
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let word = |number: usize| u32::try_from(number).map_err(io::Error::other);
    let binary = positions + indices;
    let all = word(12 + 8 + text.len() + 8 + binary)?;
    out.write_all(b"glTF")?;
    for number in [2, all, word(text.len())?] {
        out.write_all(&number.to_le_bytes())?;
    }
    out.write_all(b"JSON")?;
    out.write_all(&text)?;
    out.write_all(&word(binary)?.to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    out.write_all(cast_slice(&mesh.positions))?;
    out.write_all(cast_slice(&mesh.triangles))
}

#[cfg(test)]
mod tests;
