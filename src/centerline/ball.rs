//! A point moved to where the ball about it is largest, across a direction.

use glam::{DVec3, Vec3};

use super::skin::{Ball, Skin};
use crate::mesh::pick::Picker;

/// Rounds at most.
const ROUNDS: usize = 40;
/// Walls so much farther than the nearest, in its distance, hardly push any more: the ball's place is a mean over walls that are as near
/// as that, and not one that three bumps hold. The first rounds go in longer steps.
const SOFT: [f64; 2] = [0.06, 0.02];
const FIRST: usize = 5;
/// What is farther than so many of that does not push at all.
const PUSHES: f64 = 6.0;
/// Walls are gathered so much farther than they are needed, so that they serve some rounds.
const SLACK: f64 = 1.1;
/// A step, in radii, that is none.
const STILL: f64 = 1e-3;

/// A triangle of the wall with a ball around it.
struct Wall {
    corners: [Vec3; 3],
    centre: DVec3,
    radius: f64,
    area: f64,
}

impl Wall {
    fn new(corners: [Vec3; 3]) -> Self {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let centre = (a + b + c) / 3.0;
        let to = |corner: DVec3| corner.distance_squared(centre);
        Self {
            corners,
            centre,
            radius: to(a).max(to(b)).max(to(c)).sqrt(),
            area: (b - a).cross(c - a).length(),
        }
    }
}

/// The way from the nearest point of a wall, its length and the wall's area.
type Near = (DVec3, f64, f64);

/// Moves a point across a direction to the largest ball near it, not farther than `most`. None where it does not stay inside.
#[allow(
    clippy::cast_possible_truncation,
    reason = "the mesh is in single precision"
)]
pub(super) fn largest(skin: &Skin<'_>, start: DVec3, across: DVec3, most: f64) -> Option<Ball> {
    let mut ball = Ball {
        centre: start,
        radius: skin.distance(start),
        part: skin.part,
    };
    let mut walls: Vec<Wall> = Vec::new();
    let mut near: Vec<Near> = Vec::new();
    let mut known = (start, 0.0);
    for round in 0..ROUNDS {
        let soft = SOFT[usize::from(round >= FIRST)];
        // Walls are gathered anew where the point has left the middle of those that are known.
        let needed = ball.radius * (1.0 + PUSHES * soft);
        if ball.centre.distance(known.0) + needed > known.1 {
            known = (ball.centre, SLACK * needed);
            walls.clear();
            let picker = skin.surface.picker();
            picker.within(known.0.as_vec3(), known.1 as f32, |_, corners| {
                walls.push(Wall::new(corners));
            });
        }
        ball.radius = nearest(&walls, ball.centre, PUSHES * soft, &mut near);
        if !(ball.radius > 0.0 && ball.radius.is_finite()) {
            return None;
        }
        let push = push(&near, ball.radius, soft * ball.radius);
        let step = soft * ball.radius * (push - push.dot(across) * across);
        if step.length() < STILL * ball.radius && round >= FIRST {
            break;
        }
        ball.centre += step;
        if ball.centre.distance(start) > most {
            return None;
        }
    }
    Some(ball)
}

/// How far the nearest wall is; into `near` go those that are not farther by more than a part of that, and some that are.
fn nearest(walls: &[Wall], point: DVec3, part: f64, near: &mut Vec<Near>) -> f64 {
    near.clear();
    let mut least = f64::INFINITY;
    for wall in walls {
        let at_least = wall.centre.distance(point) - wall.radius;
        if at_least > least * (1.0 + part) {
            continue;
        }
        let from = point - Picker::nearest_of(wall.corners, point);
        let length = from.length();
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
