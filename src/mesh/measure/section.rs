//! The section of the tube that a place of the surface is on: its centre, axis and size.
//!
//! ```text
//! place ─▶ ray inwards ─▶ a point about the middle ─▶ rays all around ─▶ normals ─▶ axis
//!                              ▲                                                  │
//!                              └── centre of its area ◀── loop ◀── plane through the place
//! ```
//!
//! The walls of a tube stand along its axis, so the axis is the direction in which the walls' normals scatter least (as in ROSA, Tagliasacchi,
//! Zhang and Cohen-Or 2009); about their mean, since the walls of a tapering tube all lean the same way. A plane
//! across it through the place cuts the surface in a loop, which is walked from triangle to triangle, and the centre of its area
//! is a better middle to look around from. It is done when the axis turns no more, mostly after three rounds.
//!
//! Near forks, tips and open ends there is no such tube: the loop is not closed, or far from round, or the axis is none. Then it is the
//! largest ball that touches the place.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::axis::{eigen, scatter, spread};
use super::ball::inscribed;
use super::thickness::inside;
use crate::mesh::pick::{Hit, Picker};
use crate::mesh::surface::{Surface, next};

/// Rays that look around.
const RAYS: u32 = 64;
/// Rounds at most.
const ROUNDS: usize = 8;
/// The axis turns no more: cosine of half a degree.
const STEADY: f64 = 0.999_96;
/// Least 4π·area/length² of a loop; a circle has 1, an ellipse twice as long as wide 0.84, thrice 0.66, two circles that touch 0.5.
const ROUND: f64 = 0.7;
/// Most that normals may scatter along the axis, relative to the next direction.
const FLAT: f64 = 0.4;

/// Where a tube is cut across.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// The middle of the tube.
    pub centre: Vec3,
    /// The radius of a circle of the same area, or of the ball.
    pub radius: f32,
    /// The tube's direction, of length 1, one of both ways, and the area of the section; None where there is no tube and it is the largest ball
    /// that touches the place.
    pub tube: Option<Tube>,
}

/// What only a section of a tube has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tube {
    /// The tube's direction, of length 1, one of both ways.
    pub axis: Vec3,
    /// The area of the section.
    pub area: f32,
}

/// The section of the tube at a place; None where the surface has no inside there.
pub fn section(surface: &Surface, place: &Hit) -> Option<Section> {
    of_tube(surface, place).or_else(|| {
        let ball = inscribed(surface.picker(), place.point, place.normal)?;
        Some(Section {
            centre: ball.centre,
            radius: ball.radius,
            tube: None,
        })
    })
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "told in single precision, as the mesh is"
)]
fn of_tube(surface: &Surface, place: &Hit) -> Option<Section> {
    let inwards = surface.picker().inwards(place.normal);
    let through = inside(surface.picker(), place.point, inwards)?;
    let mut middle = (place.point + inwards * through / 2.0).as_dvec3();
    let mut axis = axis_around(surface.picker(), middle)?;
    for _ in 0..ROUNDS {
        let cut = cut(surface, place, axis)?;
        middle = cut.centre;
        let turned = axis_around(surface.picker(), middle)?;
        let steady = turned.dot(axis).abs() >= STEADY;
        axis = turned;
        if steady {
            let is_round = 4.0 * PI * cut.area >= ROUND * cut.length * cut.length;
            return is_round.then_some(Section {
                centre: cut.centre.as_vec3(),
                radius: (cut.area / PI).sqrt() as f32,
                tube: Some(Tube {
                    axis: axis.as_vec3(),
                    area: cut.area as f32,
                }),
            });
        }
    }
    None
}

/// The direction of the tube around a point inside it.
fn axis_around(picker: &Picker, middle: DVec3) -> Option<DVec3> {
    let mut hits: Vec<Hit> = spread(RAYS, PI)
        .filter_map(|direction| {
            picker.ray_to(
                middle.as_vec3(),
                direction.as_vec3(),
                f32::INFINITY,
                picker.inner_sides(),
            )
        })
        .collect();
    hits.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    // Rays along the tube hit walls far away, which may go anywhere.
    let most = 2.0 * hits.get(hits.len() / 2)?.distance;
    let near = hits.iter().take_while(|hit| hit.distance <= most);
    let normals: Vec<DVec3> = near.map(|hit| hit.normal.as_dvec3()).collect();
    let [(least, axis), (next, _), _] = eigen(scatter(&normals));
    (normals.len() >= 8 && least < FLAT * next).then_some(axis)
}

/// A loop in which a plane cuts the surface.
struct Cut {
    centre: DVec3,
    area: f64,
    length: f64,
}

/// The loop through a place in the plane across an axis; None where it is not closed.
fn cut(surface: &Surface, place: &Hit, axis: DVec3) -> Option<Cut> {
    let (triangle, corners) = (place.triangle, surface.picker().corners(place.triangle)?);
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    // A little off the place, so that the plane does not just touch a corner or an edge that the place is on.
    let place = place.point.lerp(middle, 1e-3).as_dvec3();
    let height = |vertex: u32| (surface.position(vertex) - place).dot(axis);
    let first = (3 * triangle..).take(3).find(|half_edge| {
        surface
            .ends(*half_edge)
            .is_some_and(|[from, to]| height(from) < 0.0 && height(to) >= 0.0)
    })?;
    let mut left = 3 * surface.faces().len();
    let crossing = |[from, to]: [u32; 2]| {
        let (below, above) = (height(from), height(to));
        surface
            .position(from)
            .lerp(surface.position(to), below / (below - above))
            - place
    };
    let start = crossing(surface.ends(first)?);
    let (mut twice, mut moment, mut length) = (0.0, DVec3::ZERO, 0.0);
    let (mut half_edge, mut at) = (first, start);
    loop {
        // In the triangle on the other side, the plane leaves by one of the other two edges.
        let entry = surface.twin(half_edge)?;
        half_edge = [next(entry), next(next(entry))].into_iter().find(|other| {
            surface
                .ends(*other)
                .is_some_and(|[from, to]| (height(from) < 0.0) != (height(to) < 0.0))
        })?;
        let to = crossing(surface.ends(half_edge)?);
        let part = at.cross(to).dot(axis);
        twice += part;
        moment += part * (at + to);
        length += at.distance(to);
        at = to;
        left = left.checked_sub(1)?;
        if half_edge == first {
            break;
        }
    }
    (twice != 0.0).then(|| Cut {
        centre: place + moment / (3.0 * twice),
        area: twice.abs() / 2.0,
        length,
    })
}
