//! What a tree carries besides its skeleton: polygons, spheres, placed surfaces, colours and materials, generalized cylinders.
//!
//! ```text
//! turtle ─▶ Drawing { tree, organs } ─┬─▶ cylinder::refined ─▶ tubes (a finer tree where cylinders are)
//!                                     └─▶ OrganMesh (triangles of everything else) ─▶ picture, GLB, OBJ
//! ```
//!
//! Flat arrays as the [`Tree`]'s; a plain tree has none of them and pays nothing. Each organ hangs on a node, with which it
//! unfolds while a step grows. Colours are indices until they are drawn ([`Palette`]).

use glam::{Quat, Vec3};

use super::bark::Bark;
use super::foliage::Bare;
use super::{NO_PARENT, Tree};

mod collar;
mod cylinder;
mod knot;
mod leaves;
mod look;
mod mesh;
mod paint;
mod polygon;
mod surface;

pub use cylinder::{Refined, refined, refined_len};
pub use look::{
    Colour, LookTable, Material, Paint, Palette, bark_colour, from_bytes, linear, srgb,
};
pub use mesh::{Numbers, Organ, OrganMesh, Organist};
pub use paint::{look_of, paint_segments};
pub use polygon::{MOST_CORNERS, Triangulator};
pub use surface::{BUILT_IN, Surface, Tone};

/// A polygon: the corners from `first` on, up to the next polygon's first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Polygon {
    /// Index into [`Organs::corners`].
    pub first: u32,
    /// Colour and material.
    pub paint: Paint,
    /// The step in which it appeared.
    pub birth: u32,
    /// The node it hangs on, or [`NO_PARENT`].
    pub node: u32,
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Metres.
    pub center: Vec3,
    /// Metres.
    pub radius: f32,
    /// Colour and material.
    pub paint: Paint,
    /// The step in which it appeared.
    pub birth: u32,
    /// The node it hangs on, or [`NO_PARENT`].
    pub node: u32,
}

/// A surface where the turtle placed it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Index into [`Organs::surfaces`].
    pub surface: u16,
    /// Colour and material.
    pub paint: Paint,
    /// The turtle's position, metres.
    pub position: Vec3,
    /// The stage from the turtle's axes, a unit quaternion.
    pub orientation: Quat,
    /// Metres that 1 of the surface takes.
    pub scale: f32,
    /// The step in which it appeared.
    pub birth: u32,
    /// The node it hangs on, or [`NO_PARENT`].
    pub node: u32,
    /// Parts of the sky's light that reach it, 0 to 1.
    pub light: f32,
}

/// A segment that is part of a generalized cylinder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Smooth {
    /// The node at the segment's end.
    pub node: u32,
    /// The node at the end of the cylinder's first segment: segments of one cylinder have the same.
    pub cylinder: u32,
}

/// Everything besides the skeleton.
///
/// Invariants (checked by [`Organs::validate`]): nodes exist in the tree, numbers are finite, scales and radii fit, `smooth` runs up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Organs {
    /// What plain segments are covered by.
    pub bark: Bark,
    /// How much thicker the trunk is at the ground, and branches where they leave their parent, in parts of their radius; 0: not at all.
    pub flare: f32,
    /// What the indices of colours and materials mean.
    pub palette: Palette,
    /// The middle of the crown: normals of leaves point away from it.
    pub crown: Vec3,
    /// Surfaces that are placed.
    pub surfaces: Vec<Surface>,
    /// Colour and material of each node's segment; empty, or shorter than the tree, where all the rest is plain.
    pub paints: Vec<Paint>,
    /// Polygons.
    pub polygons: Vec<Polygon>,
    /// Corners of all polygons, metres.
    pub corners: Vec<Vec3>,
    /// Spheres.
    pub spheres: Vec<Sphere>,
    /// Surfaces where they stand.
    pub placed: Vec<Placed>,
    /// Kinds of which none stands anywhere though the tree bears them.
    pub bare: Vec<Bare>,
    /// Segments of generalized cylinders, in order of node.
    pub smooth: Vec<Smooth>,
}

/// A tree with its organs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// The skeleton.
    pub tree: Tree,
    /// What it carries.
    pub organs: Organs,
}

/// Why organs do not fit their tree.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OrganError {
    /// A node that is not there.
    #[error(
        "{kind} {index} hangs on node {node} of a tree of {nodes}: name one of its nodes, or none"
    )]
    Node {
        /// What hangs there.
        kind: &'static str,
        /// Its index among its kind.
        index: usize,
        /// The node.
        node: u32,
        /// Nodes of the tree.
        nodes: usize,
    },
    /// A number that cannot be drawn.
    #[error(
        "{kind} {index} has a position or size that is not finite: check the numbers it was made from"
    )]
    Number {
        /// What it is.
        kind: &'static str,
        /// Its index among its kind.
        index: usize,
    },
    /// A polygon's corners.
    #[error("polygon {index} has {corners} corners: it must have from 3 to {MOST_CORNERS}")]
    Corners {
        /// The polygon.
        index: usize,
        /// Its corners.
        corners: usize,
    },
    /// A surface that is not there.
    #[error("placed surface {index} is number {surface} of {surfaces}: add the surface first")]
    Surface {
        /// The placed one.
        index: usize,
        /// Its surface.
        surface: u16,
        /// Surfaces there are.
        surfaces: usize,
    },
    /// Cylinders' segments out of order.
    #[error("entry {0} of the generalized cylinders is out of order: sort them by node")]
    Order(usize),
}

impl Organs {
    /// Whether there is nothing to draw besides the skeleton (which may have colours).
    #[must_use]
    pub fn is_bare(&self) -> bool {
        self.polygons.is_empty() && self.spheres.is_empty() && self.placed.is_empty()
    }

    /// Whether its tree wears bark or leaves of a species.
    #[must_use]
    pub fn is_dressed(&self) -> bool {
        self.flare > 0.0 || self.bark != Bark::default()
    }

    /// Number of polygons, spheres and placed surfaces.
    #[must_use]
    pub fn len(&self) -> usize {
        self.polygons.len() + self.spheres.len() + self.placed.len()
    }

    /// As [`Self::is_bare`].
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.is_bare()
    }

    /// Bytes of all that grows with the drawing.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        [
            size_of_val(self.paints.as_slice()),
            size_of_val(self.polygons.as_slice()),
            size_of_val(self.corners.as_slice()),
            size_of_val(self.spheres.as_slice()),
            size_of_val(self.placed.as_slice()),
            size_of_val(self.smooth.as_slice()),
        ]
        .iter()
        .map(|bytes| *bytes as u64)
        .sum()
    }

    /// Colour and material of the segment that ends at a node.
    #[must_use]
    pub fn paint(&self, node: usize) -> Paint {
        self.paints.get(node).copied().unwrap_or_default()
    }

    /// Sets it; plain segments after the last painted one take no memory.
    pub fn set_paint(&mut self, node: u32, paint: Paint) {
        let node = node as usize;
        if node >= self.paints.len() {
            if paint == Paint::default() {
                return;
            }
            self.paints.resize(node + 1, Paint::default());
        }
        if let Some(slot) = self.paints.get_mut(node) {
            *slot = paint;
        }
    }

    /// The corners of a polygon.
    #[must_use]
    pub fn corners_of(&self, polygon: usize) -> &[Vec3] {
        let first = |at: usize| self.polygons.get(at).map(|p| p.first as usize);
        let Some(from) = first(polygon) else {
            return &[];
        };
        let to = first(polygon + 1).unwrap_or(self.corners.len());
        self.corners.get(from..to).unwrap_or_default()
    }

    /// Smallest and largest corner of everything but the skeleton; `None` where there is nothing.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let mut bounds: Option<(Vec3, Vec3)> = None;
        let mut add = |low: Vec3, high: Vec3| {
            bounds = Some(bounds.map_or((low, high), |(l, h)| (l.min(low), h.max(high))));
        };
        for corner in &self.corners {
            add(*corner, *corner);
        }
        for sphere in &self.spheres {
            add(sphere.center - sphere.radius, sphere.center + sphere.radius);
        }
        for placed in &self.placed {
            let Some(surface) = self.surfaces.get(usize::from(placed.surface)) else {
                continue;
            };
            for position in &surface.positions {
                let at = placed.position + placed.orientation * (*position * placed.scale);
                add(at, at);
            }
        }
        bounds
    }

    /// Checks the invariants that drawing and writing rely on.
    ///
    /// # Errors
    /// The first one broken.
    pub fn validate(&self, tree: &Tree) -> Result<(), OrganError> {
        let nodes = tree.len();
        let hangs = |kind, index, node: u32| {
            if node == NO_PARENT || (node as usize) < nodes {
                Ok(())
            } else {
                Err(OrganError::Node {
                    kind,
                    index,
                    node,
                    nodes,
                })
            }
        };
        let finite = |kind, index, is_finite: bool| {
            if is_finite {
                Ok(())
            } else {
                Err(OrganError::Number { kind, index })
            }
        };
        for (index, polygon) in self.polygons.iter().enumerate() {
            hangs("polygon", index, polygon.node)?;
            let corners = self.corners_of(index);
            if !(3..=MOST_CORNERS).contains(&corners.len()) {
                let corners = corners.len();
                return Err(OrganError::Corners { index, corners });
            }
            let is_finite = corners.iter().all(|corner| corner.is_finite());
            finite("polygon", index, is_finite)?;
        }
        for (index, sphere) in self.spheres.iter().enumerate() {
            hangs("sphere", index, sphere.node)?;
            let is_finite = sphere.center.is_finite() && (0.0..f32::MAX).contains(&sphere.radius);
            finite("sphere", index, is_finite)?;
        }
        for (index, placed) in self.placed.iter().enumerate() {
            hangs("placed surface", index, placed.node)?;
            let is_finite = placed.position.is_finite()
                && placed.scale.is_finite()
                && (placed.orientation.length_squared() - 1.0).abs() < 1e-3;
            finite("placed surface", index, is_finite)?;
            let (surface, surfaces) = (placed.surface, self.surfaces.len());
            if usize::from(surface) >= surfaces {
                return Err(OrganError::Surface {
                    index,
                    surface,
                    surfaces,
                });
            }
        }
        let mut last = None;
        for (index, smooth) in self.smooth.iter().enumerate() {
            hangs("generalized cylinder", index, smooth.node)?;
            if smooth.node == NO_PARENT || last.is_some_and(|last| smooth.node <= last) {
                return Err(OrganError::Order(index));
            }
            last = Some(smooth.node);
        }
        Ok(())
    }
}

impl Drawing {
    /// Smallest and largest corner of all that is seen: of the skeleton's nodes where it has segments, and of the organs.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let skeleton = self.tree.bounds().filter(|_| self.tree.segment_count() > 0);
        match (skeleton, self.organs.bounds()) {
            (Some((l, h)), Some((low, high))) => Some((l.min(low), h.max(high))),
            (one, other) => one.or(other),
        }
    }

    /// Whether nothing at all is to be seen.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.tree.segment_count() == 0 && self.organs.is_bare()
    }
}

impl From<Tree> for Drawing {
    fn from(tree: Tree) -> Self {
        Self {
            tree,
            organs: Organs::default(),
        }
    }
}

#[cfg(test)]
mod tests;
