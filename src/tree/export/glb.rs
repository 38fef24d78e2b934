//! glTF 2.0 in its binary form: one mesh with normals, texture coordinates and a bark material.
//!
//! Metres, Y up, right-handed: glTF's own convention and ours, so nothing is turned. The texture is embedded.
//! Specification: <https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html> (§4.4 for the chunks).

use std::io::{self, Write};

use bytemuck::cast_slice;
use serde_json::json;

use super::{ExportParams, Surface};
use crate::tree::{Tree, TreeError, bark};

/// glTF's number for f32.
const FLOAT: u32 = 5126;
/// glTF's number for u32.
const UNSIGNED_INT: u32 = 5125;
/// glTF's number for a buffer of vertices.
const ARRAY_BUFFER: u32 = 34962;
/// glTF's number for a buffer of indices.
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// Position, normal, texture coordinates and (about six to each) indices.
const VERTEX_BYTES: u64 = 12 + 12 + 8 + 6 * 4;

/// The tree as a GLB file.
///
/// # Errors
/// As [`Glb::new`].
pub fn glb(tree: &Tree, params: &ExportParams) -> Result<Vec<u8>, TreeError> {
    let file = Glb::new(tree, params)?;
    let mut bytes = Vec::new();
    let _ = file.write(&mut bytes); // Writing into a vector cannot fail.
    Ok(bytes)
}

/// A GLB file that is checked and not written yet.
#[derive(Debug)]
pub struct Glb {
    /// All before the binary chunk's contents.
    head: Vec<u8>,
    surface: Surface,
    texture: Vec<u8>,
}

impl Glb {
    /// Checks a tree and lays its file out.
    ///
    /// # Errors
    /// A tree that breaks an invariant, has no segment or is too large for the format; sides outside 3 to 64.
    pub fn new(tree: &Tree, params: &ExportParams) -> Result<Self, TreeError> {
        let surface = Surface::new(tree, params, "GLB", VERTEX_BYTES)?;
        let texture = bark::png(&bark::BarkParams::default())?;
        let head = head(tree, params, &surface, texture.len())?;
        Ok(Self {
            head,
            surface,
            texture,
        })
    }

    /// Writes the file, part by part.
    ///
    /// # Errors
    /// What `out` fails in.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(&self.head)?;
        let surface = &self.surface;
        surface.each(|mesh, _| out.write_all(cast_slice(&mesh.positions)))?;
        surface.each(|mesh, _| out.write_all(cast_slice(&mesh.normals)))?;
        surface.each(|mesh, _| out.write_all(cast_slice(&mesh.uvs)))?;
        let mut indices: Vec<u32> = Vec::new();
        surface.each(|mesh, before| {
            indices.clear();
            indices.extend(mesh.indices.iter().map(|index| index + before));
            out.write_all(cast_slice(&indices))
        })?;
        let mut texture = self.texture.clone();
        pad(&mut texture, 0);
        out.write_all(&texture)
    }
}

/// The header, the chunk of JSON and the header of the binary chunk.
fn head(
    tree: &Tree,
    params: &ExportParams,
    surface: &Surface,
    texture: usize,
) -> Result<Vec<u8>, TreeError> {
    let [low, high] = surface.bounds;
    let (vertices, indices) = (surface.vertices, surface.indices);
    let parts: [(usize, Option<u32>); 5] = [
        (12 * vertices, Some(ARRAY_BUFFER)),
        (12 * vertices, Some(ARRAY_BUFFER)),
        (8 * vertices, Some(ARRAY_BUFFER)),
        (4 * indices, Some(ELEMENT_ARRAY_BUFFER)),
        (texture, None),
    ];
    let mut binary_length = 0;
    let mut views = Vec::new();
    for (bytes, target) in parts {
        let mut view = json!({ "buffer": 0, "byteOffset": binary_length, "byteLength": bytes });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        views.push(view);
        binary_length += bytes.next_multiple_of(4);
    }

    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("Ramus ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "tree", "mesh": 0 }],
        "meshes": [{
            "name": "tree",
            "primitives": [{
                "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 },
                "indices": 3,
                "material": 0,
            }],
            "extras": { "segments": tree.segment_count(), "nodes": tree.len() },
        }],
        "materials": [{
            "name": "bark",
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": 0 },
                "metallicFactor": 0.0,
                "roughnessFactor": 0.9,
            },
        }],
        "textures": [{ "sampler": 0, "source": 0 }],
        // Linear with mipmaps, repeating.
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 }],
        "images": [{ "name": "bark", "bufferView": 4, "mimeType": "image/png" }],
        "accessors": [
            { "bufferView": 0, "componentType": FLOAT, "count": vertices, "type": "VEC3", "min": low, "max": high },
            { "bufferView": 1, "componentType": FLOAT, "count": vertices, "type": "VEC3" },
            { "bufferView": 2, "componentType": FLOAT, "count": vertices, "type": "VEC2" },
            { "bufferView": 3, "componentType": UNSIGNED_INT, "count": indices, "type": "SCALAR" },
        ],
        "bufferViews": views,
        "buffers": [{ "byteLength": binary_length }],
    });
    let mut text = document.to_string().into_bytes();
    pad(&mut text, b' ');

    let too_large = || TreeError::TooLarge {
        format: "GLB",
        segments: tree.segment_count(),
        sides: params.sides,
    };
    let length = |bytes: usize| u32::try_from(bytes).map_err(|_| too_large());
    let total = length(12 + 8 + text.len() + 8 + binary_length)?;
    let mut file = Vec::new();
    for word in [
        u32::from_le_bytes(*b"glTF"),
        2,
        total,
        length(text.len())?,
        u32::from_le_bytes(*b"JSON"),
    ] {
        file.extend_from_slice(&word.to_le_bytes());
    }
    file.extend_from_slice(&text);
    for word in [length(binary_length)?, u32::from_le_bytes(*b"BIN\0")] {
        file.extend_from_slice(&word.to_le_bytes());
    }
    Ok(file)
}

/// Fills up to a multiple of four bytes.
fn pad(bytes: &mut Vec<u8>, filler: u8) {
    bytes.resize(bytes.len().next_multiple_of(4), filler);
}
