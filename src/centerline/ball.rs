//! A point moved to where the ball about it is largest, across a direction.

use glam::{DVec3, Vec3};

use super::skin::{Ball, Skin};
use crate::mesh::pick::Facet;

/// How a ball is looked for.
pub(super) struct Look {
    /// Walls so much farther than the nearest, in its distance, hardly push any more: the ball's place is a mean over walls that are as near
    /// as that, and not one that three bumps hold.
    soft: f64,
    /// A step, in radii, that is none.
    still: f64,
    /// Rounds at most.
    rounds: usize,
}
/// The first time, in longer steps; then closer, from where that led.
pub(super) const FIRST: Look = Look {
    soft: 0.06,
    still: 0.0,
    rounds: 5,
};
pub(super) const AGAIN: Look = Look {
    soft: 0.02,
    still: 1e-3,
    rounds: 40,
};
/// What is farther than so many of that does not push at all.
const PUSHES: f64 = 4.0;
/// Walls are gathered so much farther than they are needed, so that they serve some rounds.
const SLACK: f64 = 1.1;

/// More than what rounding takes from a length.
const ROUNDING: f64 = 1.0 + 1e-9;

/// A triangle of the wall.
struct Wall {
    facet: Facet,
    /// It is not nearer than this to where the ball is.
    at_least: f64,
    area: f64,
}

impl Wall {
    fn new(corners: [Vec3; 3], point: DVec3) -> Self {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let centre = (a + b + c) / 3.0;
        let to = |corner: DVec3| corner.distance_squared(centre);
        Self {
            facet: Facet::new(corners),
            at_least: centre.distance(point) - to(a).max(to(b)).max(to(c)).sqrt(),
            area: (b - a).cross(c - a).length(),
        }
    }
}

/// The way from the nearest point of a wall, its length and the wall's area.
type Near = (DVec3, f64, f64);

/// Moves a point across a direction to the largest ball near it, of about the radius `about`, and not farther than that. None where it does not stay inside.
#[allow(
    clippy::cast_possible_truncation,
    reason = "the mesh is in single precision"
)]
pub(super) fn largest(
    skin: &Skin<'_>,
    start: DVec3,
    across: DVec3,
    about: f64,
    look: &Look,
) -> Option<Ball> {
    let mut ball = Ball {
        centre: start,
        radius: about,
        part: skin.part,
    };
    let mut walls: Vec<Wall> = Vec::new();
    let mut near: Vec<Near> = Vec::new();
    let mut known = (start, 0.0);
    let (mut moved, mut most) = (0.0, f64::INFINITY);
    let Look {
        soft,
        still,
        rounds,
    } = *look;
    for _ in 0..rounds {
        // Walls are gathered anew where the point has left the middle of those that are known.
        let needed = ball.radius * (1.0 + PUSHES * soft);
        if ball.centre.distance(known.0) + needed > known.1 {
            known = (ball.centre, SLACK * needed);
            walls.clear();
            let picker = skin.surface.picker();
            picker.within(known.0.as_vec3(), known.1 as f32, |_, corners| {
                walls.push(Wall::new(corners, ball.centre));
            });
            moved = 0.0;
        }
        walls.iter_mut().for_each(|wall| wall.at_least -= moved);
        ball.radius = nearest(&mut walls, ball.centre, most, PUSHES * soft, &mut near);
        if ball.radius > known.1 {
            // None of the walls that are known is the nearest.
            ball.radius = skin.distance(ball.centre);
            continue;
        }
        if !(ball.radius > 0.0 && ball.radius.is_finite()) {
            return None;
        }
        let push = push(&near, ball.radius, soft * ball.radius);
        let step = soft * ball.radius * (push - push.dot(across) * across);
        if step.length() < still * ball.radius {
            break;
        }
        ball.centre += step;
        moved = ROUNDING * step.length();
        most = ROUNDING * (ball.radius + moved);
        if ball.centre.distance(start) > about {
            return None;
        }
    }
    Some(ball)
}

/// How far the nearest wall is, which is not farther than `most`; into `near` go those that are not farther by more than a part of that, and some that are.
fn nearest(walls: &mut [Wall], point: DVec3, most: f64, part: f64, near: &mut Vec<Near>) -> f64 {
    near.clear();
    let mut least = f64::INFINITY;
    for wall in walls {
        if wall.at_least > least.min(most) * (1.0 + part) {
            continue;
        }
        let from = wall.facet.way_to(point);
        let length = from.length();
        wall.at_least = length;
        least = least.min(length);
        near.push((from, length, wall.area));
    }
    least
}

/// Where walls push: those that are nearest most.
fn push(near: &[Near], nearest: f64, soft: f64) -> DVec3 {
    let (mut push, mut weights) = (DVec3::ZERO, 0.0);
    for (from, length, area) in near {
        let weight = area * ((nearest - length) / soft).exp();
        push += weight / length * *from;
        weights += weight;
    }
    push / weights
}
