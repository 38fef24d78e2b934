//! glTF 2.0 in its binary form: one mesh with a primitive of bark (normals, texture coordinates) and one for each other material
//! (normals, colours at the vertices).
//!
//! Metres, Y up, right-handed: glTF's own convention and ours, so nothing is turned. The texture is embedded.
//! Specification: <https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html> (§4.4 for the chunks).

use std::io::{self, Write};

use bytemuck::cast_slice;
use serde_json::{Value, json};

use super::ExportParams;
use super::surface::{Group, Matter, Surface};
use crate::tree::bark::Bark;
use crate::tree::organs::{Colour, Organs};
use crate::tree::{Tree, TreeError};

/// glTF's number for f32.
const FLOAT: u32 = 5126;
/// glTF's number for u32.
const UNSIGNED_INT: u32 = 5125;
/// glTF's number for a buffer of vertices.
const ARRAY_BUFFER: u32 = 34962;
/// glTF's number for a buffer of indices.
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// glTF's number for u16.
const UNSIGNED_SHORT: u32 = 5123;
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

/// A GLB file that is checked and not written yet.
#[derive(Debug)]
pub struct Glb<'a> {
    /// All before the binary chunk's contents.
    head: Vec<u8>,
    surface: Surface<'a>,
    /// Colour, normal and roughness of bark, where there is any.
    pictures: Option<&'static [Vec<u8>; 3]>,
}

impl<'a> Glb<'a> {
    /// Checks a tree and what it carries, and lays its file out.
    ///
    /// # Errors
    /// A tree that breaks an invariant, has nothing to draw or is too large for the format; sides outside 3 to 64.
    pub fn new(tree: &Tree, organs: &'a Organs, params: &ExportParams) -> Result<Self, TreeError> {
        let surface = Surface::new(tree, organs, params, "GLB", VERTEX_BYTES)?;
        let has_bark = surface
            .groups
            .iter()
            .any(|group| group.matter == Matter::Bark);
        let pictures = has_bark.then(|| organs.bark.pngs()).transpose()?;
        let head = head(tree, organs, params, &surface, pictures)?;
        Ok(Self {
            head,
            surface,
            pictures,
        })
    }

    /// Writes the file, part by part.
    ///
    /// # Errors
    /// What `out` fails in.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(&self.head)?;
        let surface = &self.surface;
        let mut indices: Vec<u32> = Vec::new();
        let mut colours: Vec<[u16; 4]> = Vec::new();
        for group in &surface.groups {
            surface.each(group.matter, |part, _| {
                out.write_all(cast_slice(&part.positions))
            })?;
            surface.each(group.matter, |part, _| {
                out.write_all(cast_slice(&part.normals))
            })?;
            surface.each(group.matter, |part, _| {
                if group.matter == Matter::Bark {
                    return out.write_all(cast_slice(&part.uvs));
                }
                colours.clear();
                colours.extend(part.colours.iter().map(|colour| short(*colour)));
                out.write_all(cast_slice(&colours))
            })?;
            surface.each(group.matter, |part, before| {
                indices.clear();
                indices.extend(part.indices.iter().map(|index| index + before));
                out.write_all(cast_slice(&indices))
            })?;
        }
        for picture in self.pictures.into_iter().flatten() {
            out.write_all(picture)?;
            let padding = picture.len().next_multiple_of(4) - picture.len();
            out.write_all(&[0; 3][..padding])?;
        }
        Ok(())
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

/// The parts of the document that each group adds to.
#[derive(Default)]
struct Lists {
    views: Vec<Value>,
    accessors: Vec<Value>,
    primitives: Vec<Value>,
    materials: Vec<Value>,
    bytes: usize,
}

impl Lists {
    fn view(&mut self, bytes: usize, target: Option<u32>) {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes, "byteLength": bytes });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.views.push(view);
        self.bytes += bytes.next_multiple_of(4);
    }

    fn group(&mut self, group: &Group, organs: &Organs) {
        let [low, high] = group.bounds;
        let (vertices, indices) = (group.vertices, group.indices);
        let first = self.views.len();
        for bytes in [12, 12, 8] {
            self.view(bytes * vertices, Some(ARRAY_BUFFER));
        }
        self.view(4 * indices, Some(ELEMENT_ARRAY_BUFFER));
        let vertex = |view: usize, kind: &str| json!({ "bufferView": view, "componentType": FLOAT, "count": vertices, "type": kind });
        let mut place = vertex(first, "VEC3");
        place["min"] = json!(low);
        place["max"] = json!(high);
        let (name, third) = match group.matter {
            Matter::Bark => ("TEXCOORD_0", vertex(first + 2, "VEC2")),
            Matter::Painted(_) => (
                "COLOR_0",
                json!({
                    "bufferView": first + 2, "componentType": UNSIGNED_SHORT, "normalized": true,
                    "count": vertices, "type": "VEC4",
                }),
            ),
        };
        self.accessors.extend([
            place,
            vertex(first + 1, "VEC3"),
            third,
            json!({ "bufferView": first + 3, "componentType": UNSIGNED_INT, "count": indices, "type": "SCALAR" }),
        ]);
        let mut attributes = json!({ "POSITION": first, "NORMAL": first + 1 });
        attributes[name] = json!(first + 2);
        self.primitives.push(json!({
            "attributes": attributes,
            "indices": first + 3,
            "material": self.materials.len(),
        }));
        self.materials.push(material(group.matter, organs));
    }
}

/// What bark is called in a file.
fn bark_name(bark: Bark) -> String {
    match bark {
        Bark::Plain => "bark".to_owned(),
        known => format!("bark {}", known.name()),
    }
}

fn material(matter: Matter, organs: &Organs) -> Value {
    match matter {
        Matter::Bark => json!({
            "name": bark_name(organs.bark),
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": 0 },
                "metallicRoughnessTexture": { "index": 2 },
                "metallicFactor": 0.0,
            },
            "normalTexture": { "index": 1 },
            "occlusionTexture": { "index": 2 },
        }),
        Matter::Painted(index) => {
            let material = organs.palette.material(index);
            json!({
                "name": organs.palette.name(index),
                "doubleSided": true,
                "pbrMetallicRoughness": {
                    "metallicFactor": material.metallic,
                    "roughnessFactor": material.roughness,
                },
            })
        }
    }
}

/// The header, the chunk of JSON and the header of the binary chunk.
fn head(
    tree: &Tree,
    organs: &Organs,
    params: &ExportParams,
    surface: &Surface<'_>,
    pictures: Option<&[Vec<u8>; 3]>,
) -> Result<Vec<u8>, TreeError> {
    let mut lists = Lists::default();
    for group in &surface.groups {
        lists.group(group, organs);
    }
    let mut images = Vec::new();
    for (name, picture) in ["colour", "normal", "roughness"]
        .iter()
        .zip(pictures.into_iter().flatten())
    {
        let name = format!("{} {name}", bark_name(organs.bark));
        images.push(
            json!({ "name": name, "bufferView": lists.views.len(), "mimeType": "image/png" }),
        );
        lists.view(picture.len(), None);
    }
    let mut document = json!({
        "asset": { "version": "2.0", "generator": concat!("Ramus ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "tree", "mesh": 0 }],
        "meshes": [{
            "name": "tree",
            "primitives": lists.primitives,
            "extras": { "segments": tree.segment_count(), "nodes": tree.len() },
        }],
        "materials": lists.materials,
        "accessors": lists.accessors,
        "bufferViews": lists.views,
        "buffers": [{ "byteLength": lists.bytes }],
    });
    if !images.is_empty() {
        let textures = (0..images.len()).map(|source| json!({ "sampler": 0, "source": source }));
        document["textures"] = textures.collect();
        // Linear with mipmaps, repeating.
        document["samplers"] =
            json!([{ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 }]);
        document["images"] = images.into();
    }
    let binary_length = lists.bytes;
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
