//! Drawings as files: GLB, OBJ, PLY and USD hold the surface of tubes and organs with their colours, SWC the skeleton's nodes and radii.
//!
//! The same tree and parameters give the same bytes on every machine and at any time: nothing here reads a clock, hashes
//! by address or depends on threads. Writing to disk is [`super::file`]'s business.
//!
//! A surface takes about a kilobyte a segment, so a large one is never whole in memory: it is made in parts, once for each kind of number that a file
//! holds in a row (positions, normals …), and each part is written and forgotten. Small ones, of which many may be written, are made once and kept.

mod glb;
pub mod grove;
mod instances;
mod names;
mod obj;
pub mod painted;
mod place;
mod ply;
mod surface;
mod swc;
mod unfold;
mod usd;
mod vtp;
mod wind;

pub use glb::{Glb, glb};
pub use obj::{Obj, obj};
pub use place::Place;
pub use ply::Ply;
pub use swc::{Swc, swc};
pub use usd::Usd;
pub use vtp::Vtp;

use glam::Vec3;

use super::{Organs, Tree};

/// A tree of a file.
#[derive(Clone, Debug)]
pub struct Individual<'a> {
    /// Where it stands, each time under another name; not empty.
    pub places: Vec<Place>,
    /// The skeleton.
    pub tree: &'a Tree,
    /// What it carries.
    pub organs: &'a Organs,
    /// How its tubes are written.
    pub params: ExportParams,
}

/// What a file holds besides, or otherwise, where its format can: all of it GLB, instances USD as well.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extras {
    /// Leaves and all else that is placed stand as instances of a few small meshes.
    pub instances: bool,
    /// How each vertex moves in the wind.
    pub wind: bool,
    /// So many of the last steps are morph targets with an animation, 0 to [`Extras::MORPHS_MOST`]; instances, which have no vertices of their own, stay.
    pub morphs: u32,
    /// Pixels that a side of a picture has at most; `None` for all there are.
    pub texture: Option<u32>,
}

impl Extras {
    /// Morph targets of a file: each takes twelve bytes a vertex.
    pub const MORPHS_MOST: u32 = 32;
}

/// What one file holds: a tree, or the trees of a grove.
#[derive(Clone, Debug)]
pub struct Stand<'a> {
    /// What the node on top is called.
    pub name: String,
    /// Each has a node of its own below it; one that is no grove *is* the node on top.
    pub is_grove: bool,
    /// One, or those of the grove. One that stands in several places is once in GLB and USD, whose other places name it.
    pub trees: Vec<Individual<'a>>,
    /// What is written besides.
    pub extras: Extras,
}

impl<'a> Stand<'a> {
    /// A tree alone.
    #[must_use]
    pub fn of(name: &str, tree: &'a Tree, organs: &'a Organs, params: &ExportParams) -> Self {
        Self {
            name: name.to_owned(),
            is_grove: false,
            trees: vec![Individual {
                places: vec![Place::at(name.to_owned(), Vec3::ZERO)],
                tree,
                organs,
                params: *params,
            }],
            extras: Extras::default(),
        }
    }

    fn segments(&self) -> usize {
        let of = |one: &Individual<'_>| one.tree.segment_count() * one.places.len();
        self.trees.iter().map(of).sum()
    }
}

/// The name of a tree that has none.
const TREE: &str = "tree";

/// How tubes are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExportParams {
    /// Corners of each ring, 3 to 64.
    pub sides: u32,
}

impl Default for ExportParams {
    fn default() -> Self {
        Self { sides: 8 }
    }
}

/// Largest file that an exporter makes: lengths inside a GLB are u32.
pub(super) const MOST_BYTES: u64 = u32::MAX as u64;

/// Segments whose surface is in memory at a time.
const PART: usize = 4096;
