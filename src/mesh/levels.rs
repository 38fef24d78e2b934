//! Levels of detail of a mesh: one graph of clusters for all distances, as Karis, Stubbe and Wihlidal 2021 ("A Deep Dive into Nanite Virtualized
//! Geometry") have it and as meshoptimizer's `clusterlod.h` builds it.
//!
//! The mesh is cut into clusters of at most [`MOST_TRIANGLES`] triangles. Neighbouring clusters are put into groups; a group's triangles are simplified
//! to half, its border with other groups staying as it is, and cut into clusters anew; and so on, with other borders each time, until little is left.
//! A cluster knows the error of the step that made it (its own) and of the step that replaces it (its parents'), each with a sphere. Whoever draws asks
//! of each cluster alone, "is my own error small enough here, and my parents' not?": all clusters of a group get the same answer from the same
//! numbers, so what is drawn has no hole and no overlap, wherever finer parts meet coarser ones. For that, errors grow from level to level and spheres
//! hold those below; [`cut`](crate::tree::levels::cut) has the question.
//!
//! Simplifying keeps vertices where they are, so all levels share the mesh's vertices; only the lists of triangles grow, to about twice. Vertices of
//! equal coordinates are one here, so a file of loose triangles (STL) simplifies as a whole mesh does. Triangles that cannot be seen (with a vertex that
//! is nowhere, or twice the same) are left out.
//!
//! Where a file colours a surface, vertices of one place may differ in where they are in an image. They stay apart as long as they lie on such a seam:
//! the simplifier, which knows them by their place, moves both sides of a seam together. Where two materials meet, nothing moves.
//!
//! Two errors are kept. The *error* is how far the surface has moved, square mean, added up over the levels. The *grain* is how long edges are: where
//! each triangle has its own look (edges, flat shading, colours) a coarser level is taken only where its triangles are hardly larger than pixels, since a
//! flat wall of two triangles is the same wall, but not the same mesh.
//!
//! *Left*: the error of one step alone, not added up, as `clusterlod.h` has it by default: fewer triangles, but the promise of a pixel is then none. The
//! crate's own `clusterlod`: it cannot be cancelled, and says not which triangle stands for which.

mod group;
mod leaves;
mod local;
mod split;
#[cfg(test)]
mod tests;

use std::sync::atomic::{AtomicBool, Ordering};

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

use self::group::Source;
use super::Mesh;
use crate::tree::levels::cut::{Standing, Views};

/// Triangles of a cluster at most.
pub const MOST_TRIANGLES: usize = 128;
/// Vertices of a cluster at most: they can be counted in a byte.
const MOST_VERTICES: usize = 255;
/// Meshes of at most so many triangles have one level: to draw them whole costs less than to choose.
const SMALL: usize = 2_048;
/// What must be reached however little a mesh lends itself to it: a model's coarsest level has no more triangles, so that eight of them fit a frame.
const COARSEST: usize = 60_000;
/// Levels at most; each has at most 85 % of the one before, in the end about half.
const MOST_LEVELS: usize = 64;

/// A run of triangles that are drawn together or not at all: `Cluster` of shaders/select.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Cluster {
    /// A sphere around its triangles: middle and radius, from the mesh's origin.
    pub sphere: Vec4,
    /// The sphere that its own error counts from.
    pub own: Vec4,
    /// The sphere that its parents' error counts from; holds `own`.
    pub parent: Vec4,
    /// How far its surface may be from the mesh's, in the mesh's unit; 0 where it is the mesh.
    pub own_error: f32,
    /// The larger of that and how long its edges are; 0 where it is the mesh.
    pub own_grain: f32,
    /// The error of what replaces it; −1: nothing does.
    pub parent_error: f32,
    /// The same with edges.
    pub parent_grain: f32,
    /// Its first triangle.
    pub first: u32,
    /// Its triangles.
    pub count: u32,
    /// Nothing: shaders read 16 bytes at a time.
    pub pad: [u32; 2],
}

const _: () = assert!(
    size_of::<Cluster>() == 80,
    "shaders/select.wgsl reads 80 bytes"
);

impl Cluster {
    /// The bins of its own error and of its parents' as the eyes see them; none where neither does.
    #[must_use]
    pub fn bins(&self, standing: &Standing, views: &Views) -> Option<[u32; 2]> {
        let [own, parent] = if standing.by_grain {
            [self.own_grain, self.parent_grain]
        } else {
            [self.own_error, self.parent_error]
        };
        let parent = (parent >= 0.0).then_some((self.parent, parent));
        standing.bins(self.sphere, (self.own, own), parent, views)
    }

    /// Numbers of its triangles.
    #[must_use]
    pub fn triangles(&self) -> std::ops::Range<usize> {
        let first = self.first as usize;
        first..first + self.count as usize
    }
}

/// Which vertices of a mesh are taken for one.
#[derive(Clone, Copy, Debug)]
pub struct Joined<'a> {
    /// For each vertex the one that it is joined with: of the same place, and of the same look there.
    pub vertices: &'a [u32],
    /// For each vertex the one that stands for its place.
    pub places: &'a [u32],
    /// By place, where materials meet; empty: nowhere.
    pub borders: &'a [bool],
}

impl<'a> Joined<'a> {
    /// All vertices of one place are one. `places` has for each vertex the one that stands for its place.
    #[must_use]
    pub fn by_place(places: &'a [u32]) -> Self {
        Self {
            vertices: places,
            places,
            borders: &[],
        }
    }

    /// The one that stands for a vertex's place.
    fn place(&self, vertex: u32) -> u32 {
        self.places.get(vertex as usize).copied().unwrap_or(vertex)
    }

    /// Whether materials meet at a vertex.
    fn is_border(&self, vertex: u32) -> bool {
        let place = self.place(vertex) as usize;
        self.borders.get(place).copied().unwrap_or(false)
    }
}

/// A mesh in all levels of detail.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Levels {
    /// Triangles of all levels, cluster by cluster, by the mesh's vertices; of vertices that are joined the first.
    pub triangles: Vec<[u32; 3]>,
    /// For each of them a triangle of the mesh: itself, or one that lies where it does and whose colour it takes.
    pub stands_for: Vec<u32>,
    /// Clusters, finest level first.
    pub clusters: Vec<Cluster>,
    /// So many of these are the mesh itself.
    pub finest: usize,
}

impl Levels {
    /// Builds all levels. `normals` has each vertex's, packed as [`octahedral`](super::display::octahedral) does. The same for any number of threads.
    /// `None` when somebody asked to stop.
    #[must_use]
    pub fn new(
        mesh: &Mesh,
        joined: &Joined<'_>,
        normals: &[u32],
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let mut levels = Self::finest(mesh, joined, normals, cancel)?;
        if levels.triangles.len() > SMALL {
            let source = Source {
                mesh,
                joined: *joined,
                normals,
            };
            levels.climb(&source, cancel)?;
        }
        levels.triangles.shrink_to_fit();
        levels.stands_for.shrink_to_fit();
        levels.clusters.shrink_to_fit();
        Some(levels)
    }

    /// The mesh itself in clusters, and nothing coarser. As [`Self::new`].
    #[must_use]
    pub fn finest(
        mesh: &Mesh,
        joined: &Joined<'_>,
        normals: &[u32],
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let source = Source {
            mesh,
            joined: *joined,
            normals,
        };
        let mut levels = leaves::leaves(&source, cancel)?;
        levels.finest = levels.clusters.len();
        Some(levels)
    }

    /// Level after level, until it goes no further.
    fn climb(&mut self, source: &Source<'_>, cancel: &AtomicBool) -> Option<()> {
        let mut pending: Vec<u32> = (0_u32..).take(self.clusters.len()).collect();
        let mut at_any_cost = false;
        for _ in 0..MOST_LEVELS {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let before = self.count(&pending);
            let next = group::coarser(self, source, &pending, at_any_cost, cancel)?;
            let after = self.count(&next);
            let went_on = after * 20 < before * 19;
            pending = next;
            if !went_on && (at_any_cost || after <= COARSEST) {
                break;
            }
            at_any_cost = !went_on;
        }
        Some(())
    }

    fn count(&self, clusters: &[u32]) -> usize {
        let count = |cluster: &u32| self.clusters.get(*cluster as usize).map(|c| c.count);
        clusters
            .iter()
            .filter_map(count)
            .map(|count| count as usize)
            .sum()
    }
}

/// The sphere about the box of all points.
fn around(points: impl Iterator<Item = Vec3> + Clone) -> Vec4 {
    let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = points
        .clone()
        .fold(start, |(low, high), at| (low.min(at), high.max(at)));
    // Halved first: the sum of two large coordinates is none.
    let middle = low * 0.5 + high * 0.5;
    let radius = points.fold(0.0, |most: f32, at| most.max(middle.distance(at)));
    middle.extend(wider(radius))
}

/// A sphere that holds all of these.
fn holding(spheres: impl Iterator<Item = Vec4> + Clone) -> Vec4 {
    let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = spheres.clone().fold(start, |(low, high), sphere| {
        let (middle, radius) = (sphere.truncate(), sphere.w);
        (low.min(middle - radius), high.max(middle + radius))
    });
    let middle = low * 0.5 + high * 0.5;
    let radius = spheres.fold(0.0, |most: f32, sphere| {
        most.max(middle.distance(sphere.truncate()) + sphere.w)
    });
    middle.extend(wider(radius))
}

/// A little larger, so that a sphere holds another also after the rounding of whoever measures the distance to both.
fn wider(size: f32) -> f32 {
    size * (1.0 + 2e-5) + f32::MIN_POSITIVE
}
