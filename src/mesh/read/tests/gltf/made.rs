//! A writer of small glTF files, good and bad.

use base64::Engine as _;
use serde_json::{Value, json};

use super::super::*;

/// glTF's numbers of types.
pub(in super::super) const BYTE: u32 = 5120;
pub(in super::super) const UNSIGNED_BYTE: u32 = 5121;
pub(in super::super) const SHORT: u32 = 5122;
pub(in super::super) const UNSIGNED_SHORT: u32 = 5123;
pub(in super::super) const UNSIGNED_INT: u32 = 5125;
pub(in super::super) const FLOAT: u32 = 5126;

/// A file that is put together.
#[derive(Clone)]
pub(in super::super) struct Made {
    pub(in super::super) json: Value,
    pub(in super::super) binary: Vec<u8>,
}

impl Made {
    /// Without anything but a list for everything.
    pub(in super::super) fn new() -> Self {
        Self {
            json: json!({
                "asset": { "version": "2.0" },
                "buffers": [], "bufferViews": [], "accessors": [], "meshes": [], "nodes": [],
                "materials": [], "textures": [], "images": [], "samplers": [],
            }),
            binary: Vec::new(),
        }
    }

    /// Adds to a list and returns the number there.
    pub(in super::super) fn add(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub(in super::super) fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let at = self.binary.len();
        self.binary.extend(bytes);
        let view = json!({ "buffer": 0, "byteOffset": at, "byteLength": bytes.len() });
        self.add("bufferViews", view)
    }

    /// An accessor of a view of its own, of numbers written as their type has them.
    pub(in super::super) fn accessor(&mut self, kind: u32, shape: &str, values: &[f64]) -> usize {
        let columns = ["SCALAR", "VEC2", "VEC3", "VEC4", "MAT4"];
        let columns = columns.iter().position(|name| *name == shape).unwrap();
        let columns = [1, 2, 3, 4, 16][columns];
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| written(*value, kind))
            .collect();
        let view = self.view(&bytes);
        let count = values.len() / columns;
        let accessor =
            json!({ "bufferView": view, "componentType": kind, "type": shape, "count": count });
        self.add("accessors", accessor)
    }

    /// The pyramid's positions.
    pub(in super::super) fn points(&mut self) -> usize {
        let values: Vec<f64> = POINTS
            .as_flattened()
            .iter()
            .map(|&value| value.into())
            .collect();
        self.accessor(FLOAT, "VEC3", &values)
    }

    /// The pyramid's triangles.
    pub(in super::super) fn indices(&mut self, kind: u32) -> usize {
        let values: Vec<f64> = TRIANGLES
            .as_flattened()
            .iter()
            .map(|&value| value.into())
            .collect();
        self.accessor(kind, "SCALAR", &values)
    }

    /// The pyramid in a mesh.
    pub(in super::super) fn pyramid(&mut self) -> usize {
        let (points, indices) = (self.points(), self.indices(UNSIGNED_SHORT));
        let primitive = json!({ "attributes": { "POSITION": points }, "indices": indices });
        self.add("meshes", json!({ "primitives": [primitive] }))
    }

    /// The pyramid in a node.
    pub(in super::super) fn with_pyramid() -> Self {
        let mut made = Self::new();
        let mesh = made.pyramid();
        made.add("nodes", json!({ "mesh": mesh }));
        made
    }

    fn with_buffer(&self, uri: Option<&str>) -> Value {
        let mut json = self.json.clone();
        if !self.binary.is_empty() {
            let buffer = &mut json["buffers"][0];
            *buffer = json!({ "byteLength": self.binary.len() });
            if let Some(uri) = uri {
                buffer["uri"] = json!(uri);
            }
        }
        json
    }

    pub(in super::super) fn glb(&self) -> Vec<u8> {
        let mut json = self.clone();
        json.json["buffers"] = json!([null]);
        container(&json.with_buffer(None).to_string(), &self.binary)
    }

    /// As text, with the bytes within it.
    pub(in super::super) fn gltf(&self) -> Vec<u8> {
        let binary = base64::engine::general_purpose::STANDARD.encode(&self.binary);
        self.gltf_beside(&format!("data:application/octet-stream;base64,{binary}"))
    }

    /// As text, with the bytes in a file.
    pub(in super::super) fn gltf_beside(&self, uri: &str) -> Vec<u8> {
        let mut json = self.clone();
        json.json["buffers"] = json!([null]);
        let json = json.with_buffer(Some(uri));
        serde_json::to_string_pretty(&json).unwrap().into_bytes()
    }

    pub(in super::super) fn read(&self) -> Model {
        let model = read(&self.glb()).unwrap();
        let text = read(&self.gltf()).unwrap();
        assert_eq!((model.format, text.format), (Format::Glb, Format::Gltf));
        assert_eq!(model.mesh, text.mesh);
        assert_eq!(model.paint, text.paint);
        model
    }

    /// How it is refused, in either form.
    pub(in super::super) fn fault(&self) -> String {
        let told = fault(&self.glb());
        let text = fault(&self.gltf());
        // In text a place is a line.
        if !told.starts_with("byte") {
            assert_eq!(told.replace("GLB", "glTF"), text);
        }
        told
    }
}

/// A number as it stands in a buffer.
pub(in super::super) fn written(value: f64, kind: u32) -> Vec<u8> {
    match kind {
        BYTE => (value as i8).to_le_bytes().to_vec(),
        UNSIGNED_BYTE => (value as u8).to_le_bytes().to_vec(),
        SHORT => (value as i16).to_le_bytes().to_vec(),
        UNSIGNED_SHORT => (value as u16).to_le_bytes().to_vec(),
        UNSIGNED_INT => (value as u32).to_le_bytes().to_vec(),
        _ => (value as f32).to_le_bytes().to_vec(),
    }
}

/// A binary container.
pub(in super::super) fn container(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((total as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}
