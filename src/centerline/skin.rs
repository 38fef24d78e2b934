//! The wall of a solid that balls are measured against: a surface, its vertices' outward normals and areas.

use std::borrow::Cow;

use glam::{DVec3, Vec3};

use crate::mesh;
use crate::mesh::measure::{inscribed, inscribed_at};
use crate::mesh::report::NONE;
use crate::mesh::surface::Surface;

/// Leans are not counted beyond this cosine: that of the edge of a three-sided tube.
const LEAN_LEAST: f64 = 0.5;

/// A ball inside; coordinates are from the mesh's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ball {
    pub(super) centre: DVec3,
    pub(super) radius: f64,
    /// The solid that it is in, by its place among them.
    pub(super) part: u32,
}

/// A surface whose inside is known.
#[derive(Clone, Debug)]
pub(super) struct Skin<'a> {
    pub(super) surface: Cow<'a, Surface>,
    /// Its place among the model's parts.
    pub(super) part: u32,
    /// The box around it.
    pub(super) bounds: [DVec3; 2],
    /// 1 where triangles show their fronts to the outside, else −1.
    outward: f64,
    /// Outward, of length 1; zero where there is none.
    pub(super) normals: Vec<DVec3>,
    pub(super) areas: Vec<f64>,
    /// How much the triangle at each vertex that leans most from its normal does, as a cosine: a ball that touches the triangles beside an edge
    /// of the solid is so much smaller than the way to the edge is long.
    pub(super) leans: Vec<f64>,
    /// The triangle that a vertex is looked up by.
    by_triangle: Vec<u32>,
}

/// A vertex of the wall, or the middle of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallPoint {
    pub(super) position: DVec3,
    pub(super) normal: DVec3,
    pub(super) area: f64,
    /// Its place among vertices or triangles.
    pub(super) number: u32,
    /// Whether it is the middle of a triangle.
    pub(super) is_middle: bool,
}

impl<'a> Skin<'a> {
    pub(super) fn new(surface: Cow<'a, Surface>, part: u32) -> Self {
        let inside_out = surface.picker().is_inside_out();
        let outward = if inside_out { -1.0 } else { 1.0 };
        let sums = surface.vertex_normals().into_iter();
        let normals: Vec<DVec3> = sums.map(|sum| outward * sum.normalize_or_zero()).collect();
        let mut by_triangle = vec![NONE; surface.mesh().positions.len()];
        let mut leans = vec![1.0_f64; surface.mesh().positions.len()];
        for (triangle, face) in surface.triangles() {
            let [a, b, c] = face.map(|vertex| surface.position(vertex));
            let across = outward * (b - a).cross(c - a).normalize_or_zero();
            for vertex in face {
                let lean = &mut leans[vertex as usize];
                *lean = lean
                    .min(across.dot(normals[vertex as usize]))
                    .max(LEAN_LEAST);
                let first = &mut by_triangle[vertex as usize];
                *first = (*first).min(triangle);
            }
        }
        let corners = surface.triangles().flat_map(|(_, face)| face);
        let corners = corners.map(|vertex| surface.position(vertex));
        let bounds = corners.fold(
            [DVec3::INFINITY, DVec3::NEG_INFINITY],
            |[min, max], corner| [min.min(corner), max.max(corner)],
        );
        Self {
            part,
            bounds,
            outward,
            areas: surface.vertex_areas(),
            normals,
            leans,
            by_triangle,
            surface,
        }
    }

    /// The largest ball that touches the wall at a point of it; None where nothing is opposite.
    pub(super) fn ball(&self, point: Vec3, outward: DVec3) -> Option<Ball> {
        let of_triangles = self.outward * outward;
        let ball = inscribed(self.surface.picker(), point, of_triangles.as_vec3())?;
        Some(self.of_ball(ball))
    }

    /// The ball, if there is one, at the place of the wall that is nearest to a point, the vertices of the triangle there, and how far it is.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the mesh is in single precision"
    )]
    pub(super) fn ball_near(&self, point: DVec3) -> Option<(Option<Ball>, [u32; 3], f64)> {
        let hit = self
            .surface
            .picker()
            .nearest(point.as_vec3(), f32::INFINITY)?;
        let face = *self.surface.faces().get(hit.triangle as usize)?;
        let of_corner =
            |(vertex, weight): (&u32, f32)| self.normals[*vertex as usize] * f64::from(weight);
        let normal: DVec3 = face
            .iter()
            .zip(hit.barycentric.to_array())
            .map(of_corner)
            .sum();
        let ball = normal
            .try_normalize()
            .and_then(|normal| self.ball(hit.point, normal));
        Some((ball, face, f64::from(hit.distance)))
    }

    /// The same at a vertex, or beside it where it is on an edge.
    pub(super) fn ball_at(&self, vertex: u32) -> Option<Ball> {
        let ball = inscribed_at(
            &self.surface,
            vertex,
            self.outward * self.normals[vertex as usize],
        )?;
        Some(self.of_ball(ball))
    }

    fn of_ball(&self, ball: mesh::measure::Ball) -> Ball {
        Ball {
            centre: ball.centre.as_dvec3(),
            radius: f64::from(ball.radius),
            part: self.part,
        }
    }

    /// Whether the box around it holds a point.
    pub(super) fn holds(&self, point: DVec3) -> bool {
        self.distance_of_bounds(point) == 0.0
    }

    /// How far the box around it is from a point.
    pub(super) fn distance_of_bounds(&self, point: DVec3) -> f64 {
        let [min, max] = self.bounds;
        point.distance(point.clamp(min, max))
    }

    /// How far a point is from the wall.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the mesh is in single precision"
    )]
    pub(super) fn distance(&self, point: DVec3) -> f64 {
        let near = self
            .surface
            .picker()
            .nearest(point.as_vec3(), f32::INFINITY);
        near.map_or(0.0, |near| near.point.as_dvec3().distance(point))
    }

    /// Vertices within a distance or a little more; with `middles` those of triangles, too, each for a part of its triangle's area.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the mesh is in single precision"
    )]
    pub(super) fn points_within(
        &self,
        point: DVec3,
        most: f64,
        middles: Option<f64>,
        into: &mut Vec<WallPoint>,
    ) {
        into.clear();
        let faces = self.surface.faces();
        self.surface
            .picker()
            .within(point.as_vec3(), most as f32, |triangle, corners| {
                let Some(face) = faces.get(triangle as usize) else {
                    return;
                };
                into.extend(middles.and_then(|part| self.middle(triangle, corners, part)));
                for (vertex, corner) in face.iter().zip(corners) {
                    if *vertex != NONE && self.by_triangle[*vertex as usize] == triangle {
                        into.push(WallPoint {
                            position: corner.as_dvec3(),
                            normal: self.normals[*vertex as usize],
                            area: self.areas[*vertex as usize],
                            number: *vertex,
                            is_middle: false,
                        });
                    }
                }
            });
    }

    /// The middle of a triangle that has an area.
    fn middle(&self, triangle: u32, corners: [Vec3; 3], part: f64) -> Option<WallPoint> {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let across = self.outward * (b - a).cross(c - a);
        Some(WallPoint {
            position: (a + b + c) / 3.0,
            normal: across.try_normalize()?,
            area: part * across.length() / 2.0,
            number: triangle,
            is_middle: true,
        })
    }
}
