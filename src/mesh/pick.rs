//! What a ray hits and what is nearest to a point, at once for millions of triangles.
//!
//! ```text
//! triangles ─▶ boxes ─▶ clusters (obvhs) ─▶ nodes of four ─▶ ray, nearest
//!                                              └─▶ cache file ─▶ checked ─▶ fitted anew
//! ```
//!
//! obvhs builds the hierarchy and Ramus walks it. obvhs's own walks were tried: its compressed eight-wide hierarchy skips whatever is nearer
//! to the ray's origin than 0.0001, in whatever unit the model is, and misses boxes that a ray along an axis only touches; it has no search
//! for the nearest point. Nodes of four boxes in single precision serve rays and points alike, as fast as obvhs's binary hierarchy does rays.
//! Corners are copied into the order of the nodes: a fifth of the time of random queries, which wait for memory, for 36 bytes a triangle.
//! Triangles are decided by a watertight test (`triangle`), so a ray never slips through a closed surface. What is found does
//! not depend on how the hierarchy was built: of what is equally near, the smallest triangle number is given.
//!
//! Coordinates and distances are those of [`Mesh::positions`]: in the file's unit, from [`Mesh::origin`].

mod build;
mod cache;
mod node;
mod triangle;
mod walk;
mod winding;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec3, Vec3};

pub use self::cache::Cache;
use self::node::Node;
pub use self::triangle::Facet;
use self::triangle::Sheared;
pub use self::winding::Winding;
use super::Mesh;

/// Levels of nodes at most; the stacks of walks have room for them.
const DEPTH_MOST: usize = 60;

/// Boxes over triangles.
#[derive(Clone, Debug, Default)]
struct Hierarchy {
    /// The first is the root; each stands behind its parent.
    nodes: Vec<Node>,
    /// Numbers of the triangles, as the runs of nodes have them.
    order: Vec<u32>,
    /// Their corners: rays and points ask for them where they lie together.
    corners: Vec<[Vec3; 3]>,
}

/// Finds what rays hit and what is near, on one mesh.
#[derive(Clone, Debug)]
pub struct Picker {
    mesh: Arc<Mesh>,
    hierarchy: Hierarchy,
    inside_out: bool,
}

/// Which sides of triangles a ray sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    /// All triangles.
    #[default]
    Both,
    /// Those whose corners run counter-clockwise as seen from where the ray comes: it enters a solid there.
    Fronts,
    /// Those seen from behind: a ray inside leaves the solid there.
    Backs,
}

/// A place on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The triangle's number.
    pub triangle: u32,
    /// How far it is from where was asked.
    pub distance: f32,
    /// Where it is.
    pub point: Vec3,
    /// How much of each of the triangle's corners makes up the point; the sum is 1.
    pub barycentric: Vec3,
    /// What stands on the triangle, of length 1, towards where its corners run counter-clockwise; zero where it has no area.
    pub normal: Vec3,
}

impl Picker {
    /// Builds the hierarchy with all threads. `progress` gets how many stages of how many are done; between stages `cancel` is looked at, and
    /// there is none when it was set. Triangles with vertices that are not there or not finite are never hit. Takes about 65 bytes
    /// a triangle, and 200 while it works.
    pub fn new(
        mesh: Arc<Mesh>,
        cancel: &AtomicBool,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Option<Self> {
        let hierarchy = Hierarchy::new(&mesh, cancel, progress)?;
        Some(Self::of(mesh, hierarchy))
    }

    fn of(mesh: Arc<Mesh>, hierarchy: Hierarchy) -> Self {
        Self {
            inside_out: hierarchy.is_inside_out(),
            mesh,
            hierarchy,
        }
    }

    /// Triangles as a whole show their backs to the outside: what they enclose, seen from the middle of the box, is below zero. Open surfaces count too.
    pub fn is_inside_out(&self) -> bool {
        self.inside_out
    }

    /// The side of triangles that a ray out of the solid sees.
    pub(crate) fn inner_sides(&self) -> Sides {
        match self.inside_out {
            true => Sides::Fronts,
            false => Sides::Backs,
        }
    }

    /// Into the solid, from a normal of its triangles.
    pub(crate) fn inwards(&self, normal: Vec3) -> Vec3 {
        if self.inside_out { normal } else { -normal }
    }

    /// The mesh that it is of.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// The first that a ray hits, not farther than `most`, from either side. The direction may have any length; a ray without one, or with a
    /// number that is not finite, hits nothing. Triangles seen exactly from the edge are not hit, but their neighbours are.
    pub fn ray(&self, origin: Vec3, direction: Vec3, most: f32) -> Option<Hit> {
        self.ray_to(origin, direction, most, Sides::Both)
    }

    /// The same, of triangles that show a side.
    pub fn ray_to(&self, origin: Vec3, direction: Vec3, most: f32, sides: Sides) -> Option<Hit> {
        let direction = direction.as_dvec3().try_normalize()?;
        if !origin.is_finite() || most.is_nan() {
            return None;
        }
        let sheared = Sheared::new(origin, direction);
        let mut best: Option<(u32, triangle::Met)> = None;
        let mut limit = f64::from(most);
        self.along(origin, direction, most, |number, corners| {
            let Some(met) = sheared.meet(corners) else {
                return limit;
            };
            let seen = match sides {
                Sides::Both => true,
                Sides::Fronts => met.front,
                Sides::Backs => !met.front,
            };
            let earlier = best.is_none_or(|(other, _)| number < other);
            if seen && (met.distance < limit || met.distance == limit && earlier) {
                limit = met.distance;
                best = Some((number, met));
            }
            limit
        });
        let (number, met) = best?;
        Some(self.place(number, met.weights, met.distance))
    }

    /// The place on the surface nearest to a point, not farther than `most`.
    pub fn nearest(&self, point: Vec3, most: f32) -> Option<Hit> {
        if !point.is_finite() || most.is_nan() || most < 0.0 {
            return None;
        }
        let mut best: Option<(u32, DVec3)> = None;
        let mut limit = f64::from(most) * f64::from(most);
        let exact = point.as_dvec3();
        self.around(point, limit, |number, corners| {
            // From the middle of a tube all of its wall is about as near: its planes tell that sooner than its triangles do.
            if triangle::is_beyond(corners, exact, limit) {
                return limit;
            }
            let (weights, squared) = triangle::nearest(corners, exact);
            let earlier = best.is_none_or(|(other, _)| number < other);
            if squared < limit || squared == limit && earlier {
                limit = squared;
                best = Some((number, weights));
            }
            limit
        });
        let (number, weights) = best?;
        Some(self.place(number, weights, limit.sqrt()))
    }

    /// Calls `visit` with the triangles whose boxes come as near to a point as `most`, in the order of the hierarchy: each by its number and its
    /// corners.
    pub fn within(&self, point: Vec3, most: f32, mut visit: impl FnMut(u32, [Vec3; 3])) {
        let limit = f64::from(most) * f64::from(most);
        if point.is_finite() && limit.is_finite() {
            self.around(point, limit, |number, corners| {
                visit(number, corners);
                limit
            });
        }
    }

    /// Corners of a triangle, from the mesh's origin; None where it cannot be picked.
    pub fn corners(&self, triangle: u32) -> Option<[Vec3; 3]> {
        build::usable(&self.mesh, *self.mesh.triangles.get(triangle as usize)?)
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "told in single precision, as the mesh is"
    )]
    fn place(&self, number: u32, weights: DVec3, distance: f64) -> Hit {
        let corners = self.corners(number).unwrap_or_default();
        Hit {
            triangle: number,
            distance: distance as f32,
            point: triangle::at(corners.map(Vec3::as_dvec3), weights).as_vec3(),
            barycentric: weights.as_vec3(),
            normal: triangle::normal(corners).as_vec3(),
        }
    }
}

#[cfg(test)]
mod tests;
