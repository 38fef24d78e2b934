//! What each mesh is made of (§3.7.2), by numbers alone: nothing of a buffer is read here.
//!
//! Primitives of a mesh that take their vertices from the same accessors share them, as many programs write one accessor and a
//! list of indices for each material.

use std::collections::BTreeMap;

use ::gltf::json::accessor::ComponentType;
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Index, Root};

use super::super::{Stop, Task};
use super::document::{compressed, compression};
use super::elements::layout;
use super::scene::Placement;
use super::{Remarks, material};

/// Vertices, by the accessors that they come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Block {
    pub(super) positions: usize,
    pub(super) texture_coordinates: Option<usize>,
    pub(super) colours: Option<usize>,
    /// How many there are.
    pub(super) vertices: usize,
}

/// How corners make triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Join {
    List,
    Strip,
    Fan,
}

/// Triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Which block of the shape.
    pub(super) block: usize,
    pub(super) join: Join,
    /// The accessor of corners; else vertices are corners as they stand.
    pub(super) indices: Option<usize>,
    pub(super) triangles: usize,
    /// The material as the file numbers it.
    pub(super) material: Option<usize>,
}

/// A mesh.
#[derive(Debug, Default)]
pub(super) struct Shape {
    pub(super) blocks: Vec<Block>,
    pub(super) parts: Vec<Part>,
    /// Vertices of all blocks.
    pub(super) vertices: usize,
    /// Triangles of all parts.
    pub(super) triangles: usize,
    /// Points and lines.
    pub(super) skipped: usize,
}

/// The shapes of all meshes that are shown, by their number.
pub(super) fn of_scene(
    root: &Root,
    scene: &[Placement<'_>],
    task: &Task<'_>,
    remarks: &mut Remarks,
) -> Result<BTreeMap<usize, Shape>, Stop> {
    let mut shapes = BTreeMap::new();
    for placement in scene {
        if placement.count() == 0 || shapes.contains_key(&placement.mesh) {
            continue;
        }
        task.go_on()?;
        shapes.insert(placement.mesh, shape(root, placement.mesh, remarks)?);
    }
    Ok(shapes)
}

fn shape(root: &Root, mesh: usize, remarks: &mut Remarks) -> Result<Shape, Stop> {
    let mut shape = Shape::default();
    let mut blocks: BTreeMap<Block, usize> = BTreeMap::new();
    let primitives = root.meshes.get(mesh).map(|mesh| mesh.primitives.iter());
    for primitive in primitives.into_iter().flatten() {
        let Some((block, mut part)) = part(root, mesh, primitive, &mut shape.skipped, remarks)?
        else {
            continue;
        };
        part.block = *blocks.entry(block).or_insert_with(|| {
            shape.blocks.push(block);
            shape.vertices = shape.vertices.saturating_add(block.vertices);
            shape.blocks.len() - 1
        });
        shape.triangles = shape.triangles.saturating_add(part.triangles);
        shape.parts.push(part);
    }
    Ok(shape)
}

/// What a primitive shows; None where that is no triangle.
fn part(
    root: &Root,
    mesh: usize,
    primitive: &Primitive,
    skipped: &mut usize,
    remarks: &mut Remarks,
) -> Result<Option<(Block, Part)>, Stop> {
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic));
    let number = |semantic| attribute(semantic).map(Index::value);
    let Some(positions) = number(Semantic::Positions) else {
        return Ok(None);
    };
    let Checked::Valid(mode) = primitive.mode else {
        let problem = "has a primitive of a mode that glTF does not have: save the file again";
        return Err(Stop::item("mesh", mesh, problem));
    };
    let place = layout(root, positions)?;
    if place.columns != 3 || place.kind == ComponentType::U32 {
        let problem = "has no positions, which are three numbers each: save the file again";
        return Err(Stop::item("accessor", positions, problem));
    }
    let indices = primitive.indices.map(|indices| indices.value());
    let corners = match indices {
        Some(indices) => corners(root, indices)?,
        None => place.rows,
    };
    let triangles = match mode {
        Mode::Triangles => corners / 3,
        Mode::TriangleStrip | Mode::TriangleFan => corners.saturating_sub(2),
        Mode::Points | Mode::LineLoop => return Ok(skip(skipped, corners)),
        Mode::Lines => return Ok(skip(skipped, corners / 2)),
        Mode::LineStrip => return Ok(skip(skipped, corners.saturating_sub(1))),
    };
    if triangles == 0 {
        return Ok(None);
    }
    // Compressed ones have no bytes of their own but for programs that cannot undo it.
    let has_bytes = |accessor: usize| {
        root.accessors
            .get(accessor)
            .is_some_and(|accessor| accessor.buffer_view.is_some() || accessor.sparse.is_some())
    };
    if !has_bytes(positions) || indices.is_some_and(|indices| !has_bytes(indices)) {
        let extensions = primitive
            .extensions
            .iter()
            .flat_map(|all| all.others.keys());
        if let Some(name) = compression(extensions) {
            return Err(compressed(name));
        }
    }
    if primitive.targets.iter().flatten().next().is_some() {
        remarks.add("a mesh that changes its shape (morph targets) is shown as it is without them");
    }
    let material = primitive.material.map(|material| material.value());
    let set = material::texture_set(root, material);
    let block = Block {
        positions,
        texture_coordinates: number(Semantic::TexCoords(set)),
        colours: number(Semantic::Colors(0)),
        vertices: place.rows,
    };
    let part = Part {
        block: 0,
        join: match mode {
            Mode::TriangleStrip => Join::Strip,
            Mode::TriangleFan => Join::Fan,
            _ => Join::List,
        },
        indices,
        triangles,
        material,
    };
    Ok(Some((block, part)))
}

fn skip<T>(skipped: &mut usize, count: usize) -> Option<T> {
    *skipped = skipped.saturating_add(count);
    None
}

/// How many corners an accessor lists.
fn corners(root: &Root, indices: usize) -> Result<usize, Stop> {
    let layout = layout(root, indices)?;
    let is_whole = matches!(
        layout.kind,
        ComponentType::U8 | ComponentType::U16 | ComponentType::U32
    );
    if layout.columns != 1 || !is_whole {
        let problem = "has no indices, which are whole numbers from 0 on: save the file again";
        return Err(Stop::item("accessor", indices, problem));
    }
    Ok(layout.rows)
}
