//! A file's colours on what was made of its mesh by mending: joined, cut, closed, coarser.
//!
//! Each new triangle takes the material of the old one that is nearest to its middle, and each of its corners that triangle's place in images: exactly
//! where the corner is one of the old triangle's, so that what was not mended looks as before, else what lies nearest to it, where that goes on from the
//! triangle as the image does. Across a seam it does not; there the triangle's own part of the image is continued. Corners of one vertex that
//! come to lie at several places of an image make it several vertices, as files have them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::MOST_LOOKS;
use crate::mesh::Mesh;
use crate::mesh::paint::{Paint, VertexColour, WHITE};
use crate::mesh::pick::{Hit, Picker};
use crate::mesh::report::NONE;

/// How far a place in an image may be from where the triangle's own part of it would go on, in parts of that part's size.
const GOES_ON: f32 = 0.5;

/// What a corner looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Look {
    at: Vec2,
    colour: VertexColour,
}

/// The mesh that was made of another by mending, its vertices parted where images have seams, with the other one's paint. `None` when somebody
/// asked to stop.
pub fn moved(
    paint: &Paint,
    from: Mesh,
    mended: &Mesh,
    cancel: &AtomicBool,
) -> Option<(Mesh, Paint)> {
    let picker = Picker::new(Arc::new(from), cancel, &mut |_, _| ())?;
    let old = Old {
        paint,
        mesh: picker.mesh(),
    };
    let shift = (mended.origin - old.mesh.origin).as_vec3();
    let nearest = |at: Vec3| {
        (!cancel.load(Ordering::Relaxed)).then(|| picker.nearest(at + shift, f32::INFINITY))
    };
    let positions = mended.positions.par_iter();
    let vertices: Vec<Option<Hit>> = positions.map(|at| nearest(*at)).collect::<Option<_>>()?;
    let middle = |triangle: &[u32; 3]| {
        let corners = triangle.map(|vertex| position(mended, vertex) / 3.0);
        corners.into_iter().sum::<Vec3>()
    };
    let triangles = mended.triangles.par_iter();
    let sources: Vec<Option<Hit>> = triangles
        .map(|triangle| nearest(middle(triangle)))
        .collect::<Option<_>>()?;
    let mut parted = Parted::new(mended);
    let mut materials = Vec::new();
    for (triangle, source) in mended.triangles.iter().zip(&sources) {
        let source = source.as_ref().map_or(0, |hit| hit.triangle);
        let looks = triangle.map(|vertex| {
            let hit = vertices.get(vertex as usize).and_then(Option::as_ref);
            old.look(source, position(mended, vertex) + shift, hit)
        });
        parted.add(*triangle, looks);
        if !paint.triangle_materials.is_empty() {
            let number = paint.triangle_materials.get(source as usize);
            materials.push(number.copied().unwrap_or_default());
        }
    }
    Some(parted.with(paint, materials))
}

fn position(mesh: &Mesh, vertex: u32) -> Vec3 {
    let position = mesh.positions.get(vertex as usize);
    position.copied().unwrap_or_default()
}

/// A painted mesh.
struct Old<'a> {
    paint: &'a Paint,
    mesh: &'a Mesh,
}

impl Old<'_> {
    /// The look of a corner at a place whose triangle lies where this old one does; `hit`: what is nearest to the place.
    fn look(&self, source: u32, place: Vec3, hit: Option<&Hit>) -> Look {
        let corners = self.corners(source);
        let same = corners.iter().find(|&&(_, at)| at == place);
        if let Some(&(vertex, _)) = same {
            return self.at_vertex(vertex);
        }
        let own = self.continued(corners, place);
        let Some(hit) = hit else {
            return own;
        };
        let near = self.mixed(self.corners(hit.triangle), hit.barycentric.to_array());
        let images = corners.map(|(vertex, _)| self.at_vertex(vertex).at);
        let size = images[0]
            .distance(images[1])
            .max(images[1].distance(images[2]))
            .max(images[2].distance(images[0]));
        Look {
            at: if near.at.distance(own.at) <= GOES_ON * size {
                near.at
            } else {
                own.at
            },
            colour: near.colour,
        }
    }

    fn corners(&self, triangle: u32) -> [(u32, Vec3); 3] {
        let triangle = self.mesh.triangles.get(triangle as usize);
        let corner = |vertex: u32| (vertex, position(self.mesh, vertex));
        triangle.copied().unwrap_or_default().map(corner)
    }

    fn at_vertex(&self, vertex: u32) -> Look {
        let number = vertex as usize;
        let at = self.paint.texture_coordinates.get(number);
        let colour = self.paint.colours.get(number);
        Look {
            at: at.copied().unwrap_or_default(),
            colour: colour.copied().unwrap_or(WHITE),
        }
    }

    /// What a triangle has at a place of its plane, within it or beyond.
    fn continued(&self, corners: [(u32, Vec3); 3], place: Vec3) -> Look {
        let [a, b, c] = corners.map(|(_, at)| at.as_dvec3());
        let (along, across, to) = (b - a, c - a, place.as_dvec3() - a);
        let (aa, ab, bb) = (along.dot(along), along.dot(across), across.dot(across));
        let area = aa * bb - ab * ab;
        let (ta, tb) = (to.dot(along), to.dot(across));
        let (second, third) = ((bb * ta - ab * tb) / area, (aa * tb - ab * ta) / area);
        if !(second.is_finite() && third.is_finite()) {
            return self.at_vertex(corners[0].0);
        }
        #[expect(clippy::cast_possible_truncation, reason = "shares of a triangle")]
        let weights = [1.0 - second - third, second, third].map(|share| share as f32);
        self.mixed(corners, weights)
    }

    fn mixed(&self, corners: [(u32, Vec3); 3], weights: [f32; 3]) -> Look {
        let looks = corners.map(|(vertex, _)| self.at_vertex(vertex));
        let mut at = Vec2::ZERO;
        let mut colour = [0.0; 4];
        for (look, weight) in looks.iter().zip(weights) {
            at += look.at * weight;
            for (sum, part) in colour.iter_mut().zip(look.colour) {
                *sum += f32::from(part) * weight;
            }
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "`as` saturates"
        )]
        let colour = colour.map(|part: f32| part.round() as u16);
        Look { at, colour }
    }
}

/// A mesh whose vertices are parted by their looks.
struct Parted<'a> {
    of: &'a Mesh,
    mesh: Mesh,
    looks: Vec<Look>,
    /// By vertex of the mesh that it is of: the newest that was made of it, and for each of those the one before.
    newest: Vec<u32>,
    older: Vec<u32>,
}

impl<'a> Parted<'a> {
    fn new(of: &'a Mesh) -> Self {
        Self {
            mesh: Mesh {
                origin: of.origin,
                positions: Vec::with_capacity(of.positions.len()),
                triangles: Vec::with_capacity(of.triangles.len()),
            },
            looks: Vec::with_capacity(of.positions.len()),
            newest: vec![NONE; of.positions.len()],
            older: Vec::with_capacity(of.positions.len()),
            of,
        }
    }

    fn add(&mut self, triangle: [u32; 3], looks: [Look; 3]) {
        let [a, b, c] = triangle;
        let [of_a, of_b, of_c] = looks;
        let triangle = [
            self.vertex(a, of_a),
            self.vertex(b, of_b),
            self.vertex(c, of_c),
        ];
        self.mesh.triangles.push(triangle);
    }

    fn vertex(&mut self, vertex: u32, look: Look) -> u32 {
        let start = self.newest.get(vertex as usize).copied().unwrap_or(NONE);
        let known = std::iter::successors(Some(start), |at| self.older.get(*at as usize).copied());
        let mut known = known.take_while(|at| *at != NONE).take(MOST_LOOKS);
        let same = |at: &u32| self.looks.get(*at as usize) == Some(&look);
        if let Some(same) = known.find(same) {
            return same;
        }
        let new = u32::try_from(self.looks.len()).unwrap_or(NONE);
        self.looks.push(look);
        self.older.push(start);
        self.mesh.positions.push(position(self.of, vertex));
        if let Some(newest) = self.newest.get_mut(vertex as usize) {
            *newest = new;
        }
        new
    }

    fn with(self, paint: &Paint, triangle_materials: Vec<u16>) -> (Mesh, Paint) {
        let looks = || self.looks.iter();
        let paint = Paint {
            texture_coordinates: if paint.texture_coordinates.is_empty() {
                Vec::new()
            } else {
                looks().map(|look| look.at).collect()
            },
            colours: if paint.colours.is_empty() {
                Vec::new()
            } else {
                looks().map(|look| look.colour).collect()
            },
            triangle_materials,
            materials: paint.materials.clone(),
            images: paint.images.clone(),
        };
        (self.mesh, paint)
    }
}
