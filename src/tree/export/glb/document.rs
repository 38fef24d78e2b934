//! The JSON of a GLB file, and the order of what follows it.
//!
//! Each thing is added with the piece of the binary chunk that it names, so that the two cannot come apart.

use glam::Vec3;
use serde_json::{Value, json};

use super::super::names::names;
use super::super::surface::{Group, Matter, Standing, Surface};
use super::super::{Place, Stand};
use super::growth::Animated;
use super::placed::{EXTENSION, Shared};
use super::{Piece, What};
use crate::tree::TreeError;
use crate::tree::bark::Bark;

/// glTF's number for f32.
pub(super) const FLOAT: u32 = 5126;
/// glTF's number for u32.
pub(super) const UNSIGNED_INT: u32 = 5125;
/// glTF's number for u16.
pub(super) const UNSIGNED_SHORT: u32 = 5123;
/// glTF's number for a buffer of vertices.
pub(super) const ARRAY_BUFFER: u32 = 34962;
/// glTF's number for a buffer of indices.
pub(super) const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The lists of the document, which refer to each other by number.
#[derive(Default)]
pub(super) struct Document {
    pub(super) nodes: Vec<Value>,
    pub(super) meshes: Vec<Value>,
    materials: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Value>,
    accessors: Vec<Value>,
    views: Vec<Value>,
    pieces: Vec<Piece>,
    /// Of the binary chunk.
    bytes: usize,
    /// Materials of bark that are there.
    barks: Vec<(Bark, usize)>,
    /// Pixels of a picture's side at most.
    texture: Option<u32>,
    pub(super) has_instances: bool,
    pub(super) shared: Shared,
    pub(super) animated: Animated,
    pub(super) animations: Vec<Value>,
}

impl Document {
    /// Of all that stands in a file.
    pub(super) fn of(stand: &Stand<'_>, trees: &[Standing<'_>]) -> Result<Self, TreeError> {
        let mut document = Self {
            texture: stand.extras.texture,
            ..Self::default()
        };
        // The node on top is the first.
        document.nodes.push(json!({ "name": stand.name }));
        let mut below = Vec::new();
        for (number, standing) in trees.iter().enumerate() {
            let parts = document.parts(number, standing);
            let tree = &standing.surface.tree;
            let extras = json!({ "segments": tree.segment_count(), "nodes": tree.len() });
            if !stand.is_grove {
                document.nodes[0]["extras"] = extras;
                below.extend(parts);
                continue;
            }
            for (number, place) in standing.places.iter().enumerate() {
                // A node has one parent, so each further place has nodes of its own with the same meshes.
                let parts = match number {
                    0 => parts.clone(),
                    _ => document.again(&parts),
                };
                let mut node = json!({ "name": place.name, "extras": extras });
                // An empty list is not allowed.
                if !parts.is_empty() {
                    node["children"] = json!(parts);
                }
                stand_at(&mut node, place);
                below.push(add(&mut document.nodes, node));
            }
        }
        document.nodes[0]["children"] = json!(below);
        document.animation();
        document.pictures()?;
        Ok(document)
    }

    /// A node for each thing that a tree is made of.
    fn parts(&mut self, number: usize, standing: &Standing<'_>) -> Vec<usize> {
        let surface = &standing.surface;
        let mut parts = Vec::new();
        let mut names = names(surface);
        for (group, name) in surface.groups.iter().zip(&names) {
            let mut primitive = self.primitive(number, surface, group);
            let (targets, steps) = self.targets(number, surface, group);
            let weights = vec![0.0; targets.len()];
            let mut mesh = json!({ "name": format!("{}-{name}", standing.name()) });
            if !targets.is_empty() {
                primitive["targets"] = json!(targets);
                mesh["weights"] = json!(weights);
                // As Blender and three.js read them.
                mesh["extras"] = json!({ "targetNames": steps });
            }
            mesh["primitives"] = json!([primitive]);
            let mesh = add(&mut self.meshes, mesh);
            let node = add(&mut self.nodes, json!({ "name": name, "mesh": mesh }));
            self.animates(node, weights.len());
            parts.push(node);
        }
        parts.extend(self.placed(number, standing, &mut names));
        parts
    }

    /// The same nodes once more, and what is below them.
    fn again(&mut self, nodes: &[usize]) -> Vec<usize> {
        let mut made = Vec::with_capacity(nodes.len());
        for node in nodes {
            let Some(mut copy) = self.nodes.get(*node).cloned() else {
                continue;
            };
            let children = copy.get("children").and_then(Value::as_array);
            let children: Vec<usize> = children
                .into_iter()
                .flatten()
                .filter_map(|child| usize::try_from(child.as_u64()?).ok())
                .collect();
            if !children.is_empty() {
                copy["children"] = json!(self.again(&children));
            }
            let number = add(&mut self.nodes, copy);
            self.animates_as(*node, number);
            made.push(number);
        }
        made
    }

    /// A group's triangles.
    fn primitive(&mut self, tree: usize, surface: &Surface<'_>, group: &Group) -> Value {
        let [low, high] = group.bounds;
        let (vertices, matter) = (group.vertices, group.matter);
        let piece = |what| Piece::Group { tree, matter, what };
        let floats = |columns: usize| json!({ "componentType": FLOAT, "count": vertices, "type": format!("VEC{columns}") });
        let mut place = floats(3);
        place["min"] = json!(low);
        place["max"] = json!(high);
        let bytes = 12 * vertices;
        let place = self.column(piece(What::Positions), bytes, Some(ARRAY_BUFFER), place);
        let normal = self.column(piece(What::Normals), bytes, Some(ARRAY_BUFFER), floats(3));
        let mut attributes = json!({ "POSITION": place, "NORMAL": normal });
        let bytes = 8 * vertices;
        if matter == Matter::Bark {
            let piece = piece(What::Coordinates);
            attributes["TEXCOORD_0"] =
                json!(self.column(piece, bytes, Some(ARRAY_BUFFER), floats(2)));
        } else {
            let colours = json!({ "componentType": UNSIGNED_SHORT, "normalized": true, "count": vertices, "type": "VEC4" });
            let piece = piece(What::Colours);
            attributes["COLOR_0"] = json!(self.column(piece, bytes, Some(ARRAY_BUFFER), colours));
        }
        if surface.bending.is_some() {
            if matter != Matter::Bark {
                let piece = piece(What::LeafCoordinates);
                let column = self.column(piece, bytes, Some(ARRAY_BUFFER), floats(2));
                attributes["TEXCOORD_0"] = json!(column);
            }
            for (set, what) in [("TEXCOORD_1", What::Trunk), ("TEXCOORD_2", What::Branch)] {
                let shorts = json!({ "componentType": UNSIGNED_SHORT, "normalized": true, "count": vertices, "type": "VEC2" });
                let column = self.column(piece(what), 4 * vertices, Some(ARRAY_BUFFER), shorts);
                attributes[set] = json!(column);
            }
        }
        let corners =
            json!({ "componentType": UNSIGNED_INT, "count": group.indices, "type": "SCALAR" });
        let indices = self.column(
            piece(What::Indices),
            4 * group.indices,
            Some(ELEMENT_ARRAY_BUFFER),
            corners,
        );
        json!({
            "attributes": attributes,
            "indices": indices,
            "material": self.material(matter, surface),
        })
    }

    /// An accessor with a view of its own.
    pub(super) fn column(
        &mut self,
        piece: Piece,
        bytes: usize,
        target: Option<u32>,
        mut accessor: Value,
    ) -> usize {
        let view = self.view(piece, bytes, target);
        accessor["bufferView"] = json!(view);
        add(&mut self.accessors, accessor)
    }

    /// The same of numbers that are few.
    pub(super) fn small(&mut self, bytes: Vec<u8>, target: u32, accessor: Value) -> usize {
        let length = bytes.len();
        self.column(Piece::Bytes(bytes), length, Some(target), accessor)
    }

    fn view(&mut self, piece: Piece, bytes: usize, target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes, "byteLength": bytes });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.pieces.push(piece);
        self.bytes += bytes.next_multiple_of(4);
        add(&mut self.views, view)
    }

    /// The number of a material, which trees that look alike share.
    pub(super) fn material(&mut self, matter: Matter, surface: &Surface<'_>) -> usize {
        let organs = surface.organs;
        let Matter::Painted(index) = matter else {
            return self.bark(organs.bark);
        };
        let material = organs.palette.material(index);
        let made = json!({
            "name": organs.palette.name(index),
            "doubleSided": true,
            "pbrMetallicRoughness": {
                "metallicFactor": material.metallic,
                "roughnessFactor": material.roughness,
            },
        });
        let known = self.materials.iter().position(|known| *known == made);
        known.unwrap_or_else(|| add(&mut self.materials, made))
    }

    /// The number of a bark's material. Its pictures come three by three, in the order of the barks.
    fn bark(&mut self, bark: Bark) -> usize {
        if let Some((_, known)) = self.barks.iter().find(|(known, _)| *known == bark) {
            return *known;
        }
        let first = 3 * self.barks.len();
        let made = json!({
            "name": bark_name(bark),
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": first },
                "metallicRoughnessTexture": { "index": first + 2 },
                "metallicFactor": 0.0,
            },
            "normalTexture": { "index": first + 1 },
            "occlusionTexture": { "index": first + 2 },
        });
        let material = add(&mut self.materials, made);
        self.barks.push((bark, material));
        material
    }

    /// The pictures of all barks, at the end.
    fn pictures(&mut self) -> Result<(), TreeError> {
        let barks: Vec<Bark> = self.barks.iter().map(|(bark, _)| *bark).collect();
        for bark in barks {
            let pictures = match self.texture {
                Some(most) => bark.pngs_within(most)?,
                None => bark.pngs()?,
            };
            for (part, picture) in ["colour", "normal", "roughness"].iter().zip(pictures) {
                let view = self.view(Piece::Picture(picture), picture.len(), None);
                let name = format!("{} {part}", bark_name(bark));
                let image = json!({ "name": name, "bufferView": view, "mimeType": "image/png" });
                let source = add(&mut self.images, image);
                self.textures
                    .push(json!({ "sampler": 0, "source": source }));
            }
        }
        Ok(())
    }

    /// The header, the chunk of JSON and the header of the binary chunk, and what comes after; `None` where lengths do not fit u32.
    pub(super) fn head(self) -> Option<(Vec<u8>, Vec<Piece>)> {
        let mut document = json!({
            "asset": { "version": "2.0", "generator": concat!("Ramus ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.bytes }],
        });
        if !self.images.is_empty() {
            document["textures"] = self.textures.into();
            // Linear with mipmaps, repeating.
            document["samplers"] =
                json!([{ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 }]);
            document["images"] = self.images.into();
        }
        if self.has_instances {
            document["extensionsUsed"] = json!([EXTENSION]);
            document["extensionsRequired"] = json!([EXTENSION]);
        }
        if !self.animations.is_empty() {
            document["animations"] = self.animations.into();
        }
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = |bytes: usize| u32::try_from(bytes).ok();
        let total = length(12 + 8 + text.len() + 8 + self.bytes)?;
        let mut head = Vec::with_capacity(28 + text.len());
        for word in [
            u32::from_le_bytes(*b"glTF"),
            2,
            total,
            length(text.len())?,
            u32::from_le_bytes(*b"JSON"),
        ] {
            head.extend_from_slice(&word.to_le_bytes());
        }
        head.extend_from_slice(&text);
        for word in [length(self.bytes)?, u32::from_le_bytes(*b"BIN\0")] {
            head.extend_from_slice(&word.to_le_bytes());
        }
        Some((head, self.pieces))
    }
}

/// Adds to a list; the number of what was added.
pub(super) fn add(list: &mut Vec<Value>, value: Value) -> usize {
    list.push(value);
    list.len() - 1
}

/// Says where a node stands, where that is not where its parent does.
fn stand_at(node: &mut Value, place: &Place) {
    if place.at != Vec3::ZERO {
        node["translation"] = json!(place.at.to_array());
    }
    if place.yaw_deg != 0.0 {
        node["rotation"] = json!(place.turn().to_array());
    }
    if place.size != 1.0 {
        node["scale"] = json!([place.size, place.size, place.size]);
    }
}

/// What bark is called in a file.
fn bark_name(bark: Bark) -> String {
    match bark {
        Bark::Plain => "bark".to_owned(),
        known => format!("bark {}", known.name()),
    }
}
