//! Placed surfaces of a tree on their way to the device: each surface once, and for each place where it stands 48 bytes.
//!
//! A draw shows [`BATCH`] leaves an instance (an instance of a handful of triangles is slow everywhere): the index buffer holds the surface's triangles so
//! often, and the vertex shader finds the leaf from the vertex's number.

use std::sync::Arc;

use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};

use super::{
    crown_upload::{CrownChunk, Making},
    error::RenderError,
    gpu::Gpu,
    memory::Buffer,
    meshes::filled,
    tree_upload::Detail,
};
use crate::{
    mesh::display::octahedral,
    tree::{
        NO_PARENT,
        axes::axis_children,
        foliage::two_triangles,
        growth,
        levels::{
            BATCH, Leaf, along_axes,
            kinds::{KINDS, Kind, LEAVES_BELOW, NONE},
        },
        organs::{LookTable, Placed, Surface},
    },
    world::scene::PlacedTree,
};

/// `Corner` of shaders/leaf.wgsl. The first one is no corner: the crown's middle, how round its normals are, and how many corners follow.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct Corner {
    place: [f32; 3],
    normal: u32,
    /// 0: the leaf's look, else a look's number and 1. Of the first one: the number of corners.
    look: u32,
    /// 1: a sheet with two sides.
    thin: u32,
    pad: [u32; 2],
}

const _: () = assert!(
    size_of::<Corner>() == 32,
    "shaders/leaf.wgsl reads 32 bytes"
);

/// Leaves of one surface that one descriptor set shows.
pub(crate) struct LeafChunk {
    pub(crate) crown: CrownChunk,
    /// The surface's corners and the triangles of a batch of leaves, as each kind: few bytes, which stay where the processor wrote them.
    pub(crate) corners: Arc<Buffer>,
    pub(crate) indices: Arc<Buffer>,
}

impl LeafChunk {
    /// All placed surfaces of a tree; any thread.
    pub(crate) fn all(
        making: &mut Making<'_>,
        placed: &PlacedTree,
        looks: &mut LookTable,
        detail: Detail,
    ) -> Result<Vec<Self>, RenderError> {
        let gpu = making.gpu;
        let organs = &placed.organs;
        if organs.placed.is_empty() {
            return Ok(Vec::new());
        }
        let bases = growth::bases(&placed.tree, placed.newest);
        let mut by_surface: Vec<Vec<Leaf>> = vec![Vec::new(); organs.surfaces.len()];
        for one in neighbours(placed) {
            if let Some(of) = by_surface.get_mut(usize::from(one.surface)) {
                of.push(leaf(placed, &bases, one, looks));
            }
        }
        let mut chunks = Vec::new();
        for (surface, leaves) in organs.surfaces.iter().zip(&by_surface) {
            let shapes = Shapes::new(surface, organs.crown, placed, looks);
            let corners = Arc::new(shapes.corner_buffer(gpu)?);
            let indices = Arc::new(shapes.index_buffer(gpu)?);
            let leaf = |at: usize| leaves.get(at).copied().unwrap_or_default();
            let levels = detail.of(leaves.len(), leaf);
            for crown in CrownChunk::all(making, &levels, shapes.kinds)? {
                chunks.push(Self {
                    crown,
                    corners: Arc::clone(&corners),
                    indices: Arc::clone(&indices),
                });
            }
        }
        Ok(chunks)
    }
}

/// Leaves beside those that hang near them: those that are whole, then those that grow, each along the tree's axes.
fn neighbours(placed: &PlacedTree) -> Vec<&Placed> {
    let tree = &placed.tree;
    let mut rank = vec![0_u32; tree.len()];
    let nodes: Vec<u32> = (0..)
        .zip(&tree.parent)
        .filter(|(_, parent)| **parent != NO_PARENT)
        .map(|(node, _)| node)
        .collect();
    let order = along_axes(tree, &axis_children(tree));
    for (at, record) in (0..).zip(order) {
        let node = nodes.get(record as usize).copied().unwrap_or(0);
        if let Some(rank) = rank.get_mut(node as usize) {
            *rank = at;
        }
    }
    let mut all: Vec<&Placed> = placed.organs.placed.iter().collect();
    let place = |one: &&Placed| rank.get(one.node as usize).copied().unwrap_or(0);
    all.sort_by_cached_key(|one| (one.birth >= placed.newest, place(one)));
    all
}

/// A surface as the device has it: as it is, and as a kite where it is a leaf of a crown.
struct Shapes {
    corners: Vec<Corner>,
    indices: Vec<u32>,
    kinds: [Kind; KINDS],
}

impl Shapes {
    fn new(surface: &Surface, crown: Vec3, placed: &PlacedTree, looks: &mut LookTable) -> Self {
        let mut shapes = Self {
            corners: corners(surface, crown, placed, looks),
            indices: Vec::new(),
            kinds: [Kind::default(); KINDS],
        };
        let [whole, kite] = LEAVES_BELOW;
        shapes.add(0, &surface.indices, surface.positions.len(), whole);
        if surface.thin && surface.rounded > 0.0 {
            let (simple, part) = two_triangles(surface);
            let of = corners_of(&simple, reach(surface), placed, looks);
            shapes.corners.extend(of);
            shapes.add(1, &simple.indices, simple.positions.len(), kite * part);
        }
        shapes
    }

    /// A kind whose triangles are these, by so many corners.
    fn add(&mut self, kind: usize, triangles: &[u32], corners: usize, below: f32) {
        let first = self.indices.len();
        for copy in 0..BATCH {
            let corner = u32::try_from(copy * corners).unwrap_or(u32::MAX);
            self.indices.extend(triangles.iter().map(|at| at + corner));
        }
        let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        if let Some(kind) = self.kinds.get_mut(kind) {
            *kind = Kind {
                indices: count(self.indices.len() - first),
                first: count(first),
                below,
                ends: NONE,
            };
        }
    }

    fn corner_buffer(&self, gpu: &Gpu) -> Result<Buffer, RenderError> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        filled(gpu, "a leaf's corners", usage, &self.corners)
    }

    fn index_buffer(&self, gpu: &Gpu) -> Result<Buffer, RenderError> {
        let usage = vk::BufferUsageFlags::INDEX_BUFFER;
        filled(gpu, "a leaf's triangles", usage, &self.indices)
    }
}

fn leaf(placed: &PlacedTree, bases: &[u32], one: &Placed, looks: &mut LookTable) -> Leaf {
    let organs = &placed.organs;
    let surface = organs.surfaces.get(usize::from(one.surface));
    let own = surface.and_then(|surface| surface.tones.first());
    let colour = organs.palette.colour(one.paint.colour);
    let colour = colour.or(own.map(|tone| tone.colour)).unwrap_or_default();
    let base = base(placed, bases, one);
    #[allow(clippy::cast_possible_truncation, reason = "-1 to 1")]
    let packed = |part: f32| (part.clamp(-1.0, 1.0) * 32767.0).round() as i16;
    Leaf {
        place: one.position.to_array(),
        scale: one.scale * surface.map_or(1.0, reach),
        base: base.unwrap_or(one.position).to_array(),
        look: looks.number(colour, &organs.palette, one.paint.material),
        orientation: Quat::to_array(&one.orientation).map(packed),
        light: one.light,
        flags: u32::from(base.is_some()),
    }
}

/// Where a leaf unfolds from while the newest step grows; `None` where it is whole.
fn base(placed: &PlacedTree, bases: &[u32], one: &Placed) -> Option<Vec3> {
    let Some(base) = bases.get(one.node as usize) else {
        // It hangs on nothing: it grows where it stands.
        return (one.birth >= placed.newest).then_some(one.position);
    };
    let whole = one.birth < placed.newest && *base == one.node;
    let foot = placed.tree.position.get(*base as usize)?;
    (!whole).then_some(*foot)
}

/// How far a surface's farthest corner is from where it hangs.
fn reach(surface: &Surface) -> f32 {
    let lengths = surface.positions.iter().map(|place| place.length());
    let longest = lengths.fold(0.0, f32::max);
    if longest > 0.0 { longest } else { 1.0 }
}

/// The header and the corners of a surface.
fn corners(
    surface: &Surface,
    crown: Vec3,
    placed: &PlacedTree,
    looks: &mut LookTable,
) -> Vec<Corner> {
    let header = Corner {
        place: crown.to_array(),
        normal: surface.rounded.to_bits(),
        look: u32::try_from(surface.positions.len()).unwrap_or(0),
        thin: u32::from(surface.thin),
        pad: [0; 2],
    };
    let mut corners = vec![header];
    corners.extend(corners_of(surface, reach(surface), placed, looks));
    corners
}

/// The corners of a surface, `reach` being 1.
fn corners_of(
    surface: &Surface,
    reach: f32,
    placed: &PlacedTree,
    looks: &mut LookTable,
) -> Vec<Corner> {
    let mut corners = Vec::with_capacity(surface.positions.len());
    for (at, place) in surface.positions.iter().enumerate() {
        let tone = surface.tone.get(at).copied().unwrap_or(0);
        let fixed = surface.tones.get(usize::from(tone)).filter(|_| tone > 0);
        let look = fixed.map_or(0, |tone| {
            looks.number(tone.colour, &placed.organs.palette, 0) + 1
        });
        corners.push(Corner {
            place: (*place / reach).to_array(),
            normal: octahedral(surface.normals.get(at).copied().unwrap_or(Vec3::Z)),
            look,
            ..Corner::default()
        });
    }
    corners
}
