//! Organs as triangles: one way for pictures and files.

use glam::Vec3;

use super::look::{BROWN, Colour, Paint, Palette, from_bytes};
use super::polygon::Triangulator;
use super::surface::{GREEN, sphere_indices, unit_sphere};
use super::{Organs, Surface};

/// Sides and rows of a sphere.
const BALL: (u32, u32) = (16, 8);

/// Triangles with normals and colours; all vertex arrays have one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OrganMesh {
    /// Metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit vectors.
    pub normals: Vec<[f32; 3]>,
    /// Linear red, green and blue.
    pub colours: Vec<Colour>,
    /// Three a triangle, counter-clockwise seen against the normals.
    pub indices: Vec<u32>,
}

impl OrganMesh {
    /// Empties it and keeps its memory.
    pub fn clear(&mut self) {
        self.positions.clear();
        self.normals.clear();
        self.colours.clear();
        self.indices.clear();
    }
}

/// What all vertices of one organ have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Organ {
    /// Colour and material.
    pub paint: Paint,
    /// The node it hangs on, or `NO_PARENT`.
    pub node: u32,
    /// The step in which it appeared.
    pub birth: u32,
    /// A sheet with two sides.
    pub thin: bool,
}

/// Makes triangles, keeping its scratch memory.
pub struct Organist<'a> {
    organs: &'a Organs,
    triangulator: Triangulator,
    ball: Vec<Vec3>,
    ball_indices: Vec<u32>,
    cut: Vec<u32>,
}

impl<'a> Organist<'a> {
    /// For valid organs.
    #[must_use]
    pub fn new(organs: &'a Organs) -> Self {
        let (sides, rows) = BALL;
        Self {
            organs,
            triangulator: Triangulator::default(),
            ball: unit_sphere(sides, rows).map(|(point, _)| point).collect(),
            ball_indices: sphere_indices(sides, rows).collect(),
            cut: Vec::new(),
        }
    }

    /// The organ of an index: first the polygons, then the spheres, then the placed surfaces.
    #[must_use]
    pub fn organ(&self, index: usize) -> Option<Organ> {
        let organs = self.organs;
        if let Some(polygon) = organs.polygons.get(index) {
            return Some(Organ {
                paint: polygon.paint,
                node: polygon.node,
                birth: polygon.birth,
                thin: true,
            });
        }
        let index = index - organs.polygons.len();
        if let Some(sphere) = organs.spheres.get(index) {
            return Some(Organ {
                paint: sphere.paint,
                node: sphere.node,
                birth: sphere.birth,
                thin: false,
            });
        }
        let placed = organs.placed.get(index - organs.spheres.len())?;
        let surface = organs.surfaces.get(usize::from(placed.surface))?;
        Some(Organ {
            paint: placed.paint,
            node: placed.node,
            birth: placed.birth,
            thin: surface.thin,
        })
    }

    /// Most vertices and indices that an organ takes.
    #[must_use]
    pub fn size(&self, index: usize) -> (usize, usize) {
        let organs = self.organs;
        if index < organs.polygons.len() {
            let corners = organs.corners_of(index).len();
            return (corners, 3 * corners.saturating_sub(2));
        }
        let index = index - organs.polygons.len();
        if index < organs.spheres.len() {
            return (self.ball.len(), self.ball_indices.len());
        }
        let placed = organs.placed.get(index - organs.spheres.len());
        let surface = placed.and_then(|p| organs.surfaces.get(usize::from(p.surface)));
        surface.map_or((0, 0), |s| (s.positions.len(), s.indices.len()))
    }

    /// Adds the triangles of an organ.
    pub fn add(&mut self, index: usize, into: &mut OrganMesh) {
        let organs = self.organs;
        if let Some(polygon) = organs.polygons.get(index) {
            return self.add_polygon(index, polygon.paint, into);
        }
        let index = index - organs.polygons.len();
        if let Some(sphere) = organs.spheres.get(index) {
            let own = from_bytes(BROWN);
            let colour = organs.palette.colour(sphere.paint.colour).unwrap_or(own);
            let first = next(into);
            for unit in &self.ball {
                let at = sphere.center + *unit * sphere.radius;
                vertex(into, at, *unit, colour);
            }
            into.indices
                .extend(self.ball_indices.iter().map(|i| first + i));
            return;
        }
        if let Some(placed) = organs.placed.get(index - organs.spheres.len())
            && let Some(surface) = organs.surfaces.get(usize::from(placed.surface))
        {
            let first = next(into);
            // A negative scale turns a surface inside out.
            let mirrored = placed.scale < 0.0;
            for (at, position) in surface.positions.iter().enumerate() {
                let normal = surface.normals.get(at).copied().unwrap_or(Vec3::Z);
                let colour = surface.colour(at, &organs.palette, placed.paint.colour);
                let own = placed.orientation * if mirrored { -normal } else { normal };
                vertex(
                    into,
                    placed.position + placed.orientation * (*position * placed.scale),
                    rounded(own, placed.position - organs.crown, surface.rounded),
                    colour,
                );
            }
            for triangle in surface.indices.chunks_exact(3) {
                let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(|i| first + i);
                // Three axes turned over turn a triangle over, and its normal with it.
                into.indices
                    .extend(if mirrored { [a, c, b] } else { [a, b, c] });
            }
        }
    }

    fn add_polygon(&mut self, index: usize, paint: Paint, into: &mut OrganMesh) {
        let corners = self.organs.corners_of(index);
        self.cut.clear();
        let Some(normal) = self.triangulator.add(corners, &mut self.cut) else {
            return;
        };
        let own = from_bytes(GREEN);
        let colour = self.organs.palette.colour(paint.colour).unwrap_or(own);
        let first = next(into);
        for corner in corners {
            vertex(into, *corner, normal, colour);
        }
        into.indices.extend(self.cut.iter().map(|i| first + i));
    }
}

impl Surface {
    /// The colour of a vertex for the turtle's colour index.
    #[must_use]
    pub fn colour(&self, vertex: usize, palette: &Palette, index: u16) -> Colour {
        let tone = self.tone.get(vertex).copied().unwrap_or(0);
        let Some(tone) = self.tones.get(usize::from(tone)) else {
            return from_bytes(GREEN);
        };
        match palette.colour(index) {
            Some(colour) if !tone.fixed => colour,
            _ => tone.colour,
        }
    }
}

/// A leaf's normal with as much of its crown's in it; on the side that it is on.
fn rounded(own: Vec3, outward: Vec3, share: f32) -> Vec3 {
    match outward.try_normalize() {
        Some(outward) if share > 0.0 => {
            let outward = if own.dot(outward) < 0.0 {
                -outward
            } else {
                outward
            };
            own.lerp(outward, share).normalize_or(own)
        }
        _ => own,
    }
}

fn next(mesh: &OrganMesh) -> u32 {
    // Callers cut meshes long before 2^32 vertices.
    u32::try_from(mesh.positions.len()).unwrap_or(u32::MAX)
}

fn vertex(mesh: &mut OrganMesh, position: Vec3, normal: Vec3, colour: Colour) {
    mesh.positions.push(position.to_array());
    mesh.normals.push(normal.to_array());
    mesh.colours.push(colour);
}
