//! Instances in a GLB: `EXT_mesh_gpu_instancing`, a node for each look with a small mesh and three rows of numbers.
//!
//! The extension is required, since a program that passes it over would show one leaf at the foot of the tree and say nothing. Looks that trees of a grove have in
//! common are one mesh, and all looks of one surface share its positions, normals and triangles.
//! Specification: <https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Vendor/EXT_mesh_gpu_instancing>.

use std::collections::HashMap;
use std::io::{self, Write};

use bytemuck::cast_slice;
use serde_json::{Value, json};

use super::super::instances::Run;
use super::super::names::{name, unlike};
use super::super::surface::{Matter, Standing, Surface};
use super::super::wind;
use super::document::{
    ARRAY_BUFFER, Document, ELEMENT_ARRAY_BUFFER, FLOAT, UNSIGNED_INT, UNSIGNED_SHORT, add,
};
use super::{Piece, gathered, short, shorts};
use crate::tree::organs::{self, Placed};

/// What is required.
pub(super) const EXTENSION: &str = "EXT_mesh_gpu_instancing";
/// glTF's number for i16.
const SHORT: u32 = 5122;

/// A row of numbers for each instance.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    Translation,
    Rotation,
    Scale,
    /// Sway, phase and branch of the place that holds it, and 1.
    Wind,
}

impl Place {
    /// What an instance takes at most.
    pub(super) const BYTES: u64 = 12 + 8 + 12 + 8;

    fn name(self) -> &'static str {
        match self {
            Self::Translation => "TRANSLATION",
            Self::Rotation => "ROTATION",
            Self::Scale => "SCALE",
            Self::Wind => "_WIND",
        }
    }

    /// Bytes a row, and the accessor.
    fn column(self, count: usize) -> (usize, Value) {
        match self {
            Self::Translation | Self::Scale => (
                12,
                json!({ "componentType": FLOAT, "count": count, "type": "VEC3" }),
            ),
            Self::Rotation => (
                8,
                json!({ "componentType": SHORT, "normalized": true, "count": count, "type": "VEC4" }),
            ),
            Self::Wind => (
                8,
                json!({ "componentType": UNSIGNED_SHORT, "normalized": true, "count": count, "type": "VEC4" }),
            ),
        }
    }

    /// Writes the rows of a run.
    pub(super) fn write(
        self,
        surface: &Surface<'_>,
        run: &Run,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let placed = &surface.organs.placed;
        let all = run.placed.iter().filter_map(|at| placed.get(*at as usize));
        match self {
            Self::Translation => gathered(out, |take| {
                all.for_each(|one| take(one.position.to_array()));
            }),
            Self::Rotation => gathered(out, |take| all.for_each(|one| take(rotation(one)))),
            // Below 0 it turns a surface inside out, here as in a mesh.
            Self::Scale => gathered(out, |take| all.for_each(|one| take([one.scale; 3]))),
            Self::Wind => gathered(out, |take| {
                for one in all {
                    let held = surface.bending.as_ref();
                    let held = held.map(|wind| wind.at(surface.tree, one.node, one.position));
                    let [sway, phase, branch] = held.unwrap_or_default();
                    take(shorts([sway, phase, branch, 1.0]));
                }
            }),
        }
    }
}

/// A quaternion as parts of 32767.
fn rotation(one: &Placed) -> [i16; 4] {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "within ±32767, and `as` saturates"
    )]
    one.orientation
        .normalize()
        .to_array()
        .map(|part| (part * f32::from(i16::MAX)).round() as i16)
}

/// What is written once and stands in many places.
#[derive(Default)]
pub(super) struct Shared {
    shapes: Vec<Shape>,
    /// Numbers of shapes by what makes one.
    known: HashMap<Vec<u32>, usize>,
    /// Numbers of meshes.
    looks: HashMap<Look, usize>,
}

/// What makes a look: shape, material and colours.
type Look = (usize, usize, Vec<[u16; 4]>);

/// Numbers of accessors.
struct Shape {
    attributes: Value,
    indices: usize,
}

impl Document {
    /// A node for each material that is placed, below it one for each look; `names` are taken.
    pub(super) fn placed(
        &mut self,
        number: usize,
        standing: &Standing<'_>,
        names: &mut Vec<String>,
    ) -> Vec<usize> {
        let surface = &standing.surface;
        let mut nodes = Vec::new();
        let runs: Vec<(usize, &Run)> = surface.runs.iter().enumerate().collect();
        for of_material in runs.chunk_by(|(_, a), (_, b)| a.paint.material == b.paint.material) {
            let Some((_, first)) = of_material.first() else {
                continue;
            };
            let matter = Matter::Painted(first.paint.material);
            let name = unlike(names, name(surface, matter));
            names.push(name.clone());
            let looks = (1..).zip(of_material);
            let looks: Vec<usize> = looks
                .map(|(look, (run, one))| {
                    let mesh = self.look(surface, one, matter, &name);
                    let name = format!("{name}-look-{look}");
                    self.instances(number, *run, surface, json!({ "name": name, "mesh": mesh }))
                })
                .collect();
            let node = json!({ "name": name, "children": looks });
            nodes.push(add(&mut self.nodes, node));
        }
        nodes
    }

    /// A node whose mesh stands where a run says.
    fn instances(
        &mut self,
        tree: usize,
        run: usize,
        surface: &Surface<'_>,
        mut node: Value,
    ) -> usize {
        let count = surface.runs.get(run).map_or(0, |run| run.placed.len());
        let mut attributes = json!({});
        let wind = surface.bending.as_ref().map(|_| Place::Wind);
        let columns = [Place::Translation, Place::Rotation, Place::Scale];
        for what in columns.into_iter().chain(wind) {
            let (row, accessor) = what.column(count);
            let piece = Piece::Run { tree, run, what };
            let column = self.column(piece, row * count, None, accessor);
            attributes[what.name()] = json!(column);
        }
        node["extensions"] = json!({ EXTENSION: { "attributes": attributes } });
        self.has_instances = true;
        add(&mut self.nodes, node)
    }

    /// The mesh of a look.
    fn look(&mut self, surface: &Surface<'_>, run: &Run, matter: Matter, name: &str) -> usize {
        let material = self.material(matter, surface);
        let colours: Vec<[u16; 4]> = run.colours(surface.organs).into_iter().map(short).collect();
        let shape = self.shape(surface, run);
        let look = (shape, material, colours);
        if let Some(mesh) = self.shared.looks.get(&look) {
            return *mesh;
        }
        let (.., colours) = &look;
        let column = json!({ "componentType": UNSIGNED_SHORT, "normalized": true, "count": colours.len(), "type": "VEC4" });
        let bytes = cast_slice(colours.as_slice()).to_vec();
        let colour = self.small(bytes, ARRAY_BUFFER, column);
        let of = self.shared.shapes.get(shape);
        let (mut attributes, indices) = match of {
            Some(shape) => (shape.attributes.clone(), shape.indices),
            None => (json!({}), 0),
        };
        attributes["COLOR_0"] = json!(colour);
        let primitive =
            json!({ "attributes": attributes, "indices": indices, "material": material });
        let name = format!("{name}-look-{}", self.shared.looks.len() + 1);
        let mesh = add(
            &mut self.meshes,
            json!({ "name": name, "primitives": [primitive] }),
        );
        self.shared.looks.insert(look, mesh);
        mesh
    }

    /// The number of a surface's shape.
    fn shape(&mut self, surface: &Surface<'_>, run: &Run) -> usize {
        let Some(leaf) = surface.organs.surfaces.get(usize::from(run.surface)) else {
            return 0;
        };
        let made_of = made_of(leaf);
        if let Some(known) = self.shared.known.get(&made_of) {
            return *known;
        }
        let floats = |columns: usize| json!({ "componentType": FLOAT, "count": leaf.positions.len(), "type": format!("VEC{columns}") });
        let rows = |rows: &[glam::Vec3]| -> Vec<u8> {
            rows.iter()
                .flat_map(|row| row.to_array())
                .flat_map(f32::to_le_bytes)
                .collect()
        };
        let mut place = floats(3);
        let (low, high) = leaf.positions.iter().fold(
            (glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY),
            |(low, high), place| (low.min(*place), high.max(*place)),
        );
        place["min"] = json!(low.to_array());
        place["max"] = json!(high.to_array());
        let place = self.small(rows(&leaf.positions), ARRAY_BUFFER, place);
        let normal = self.small(rows(&leaf.normals), ARRAY_BUFFER, floats(3));
        let mut attributes = json!({ "POSITION": place, "NORMAL": normal });
        if surface.bending.is_some() {
            let places = wind::coordinates_of(leaf);
            let places = cast_slice(&places).to_vec();
            attributes["TEXCOORD_0"] = json!(self.small(places, ARRAY_BUFFER, floats(2)));
            let flutter = wind::flutter_of(leaf);
            let flutter: Vec<[u16; 2]> = flutter
                .into_iter()
                .map(|part| shorts([0.0, part]))
                .collect();
            let none = vec![[0_u16; 2]; flutter.len()];
            for (set, column) in [("TEXCOORD_1", none), ("TEXCOORD_2", flutter)] {
                let accessor = json!({ "componentType": UNSIGNED_SHORT, "normalized": true, "count": column.len(), "type": "VEC2" });
                let bytes = cast_slice(&column).to_vec();
                attributes[set] = json!(self.small(bytes, ARRAY_BUFFER, accessor));
            }
        }
        let corners =
            json!({ "componentType": UNSIGNED_INT, "count": leaf.indices.len(), "type": "SCALAR" });
        let bytes = cast_slice(&leaf.indices).to_vec();
        let indices = self.small(bytes, ELEMENT_ARRAY_BUFFER, corners);
        let shape = Shape {
            attributes,
            indices,
        };
        let number = self.shared.shapes.len();
        self.shared.shapes.push(shape);
        self.shared.known.insert(made_of, number);
        number
    }
}

/// The numbers that a surface's shape is written from, with how many there are of each first: colours are the look's.
fn made_of(leaf: &organs::Surface) -> Vec<u32> {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "indices are u32, so there are no more vertices"
    )]
    let counts = [leaf.positions.len(), leaf.normals.len()].map(|count| count as u32);
    let rows = leaf.positions.iter().chain(&leaf.normals);
    let numbers = rows.flat_map(|row| row.to_array().map(f32::to_bits));
    let mut made: Vec<u32> = counts.into_iter().chain(numbers).collect();
    made.extend(&leaf.indices);
    made
}
