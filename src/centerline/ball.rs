//! A point moved to where the ball about it is largest, across a direction.

use glam::DVec3;

use super::skin::{Ball, Skin};
use crate::mesh::pick::Picker;

/// Rounds at most.
const ROUNDS: usize = 40;
/// Walls so much farther than the nearest, in its distance, hardly push any more: the ball's place is a mean over walls that are as near
/// as that, and not one that three bumps hold.
const SOFT: f64 = 0.02;
/// A step, in radii, that is none.
const STILL: f64 = 1e-4;

/// Moves a point across a direction to the largest ball near it, not farther than `most`. None where it does not stay inside.
#[allow(
    clippy::cast_possible_truncation,
    reason = "the mesh is in single precision"
)]
pub(super) fn largest(skin: &Skin<'_>, start: DVec3, across: DVec3, most: f64) -> Option<Ball> {
    let distance = skin.distance(start);
    if distance == 0.0 {
        return None;
    }
    let picker = skin.surface.picker();
    let mut walls: Vec<([glam::Vec3; 3], f64)> = Vec::new();
    let mut known = (start, 0.0);
    let mut ball = Ball {
        centre: start,
        radius: distance,
    };
    for _ in 0..ROUNDS {
        // Walls are gathered anew where the point has left the middle of those that are known.
        let needed = ball.radius * (1.0 + 6.0 * SOFT);
        if walls.is_empty() || ball.centre.distance(known.0) + needed > known.1 {
            known = (ball.centre, 1.5 * needed);
            walls.clear();
            picker.within(known.0.as_vec3(), known.1 as f32, |_, corners| {
                let [a, b, c] = corners.map(glam::Vec3::as_dvec3);
                walls.push((corners, (b - a).cross(c - a).length()));
            });
        }
        let near: Vec<(DVec3, f64, f64)> = walls
            .iter()
            .map(|(corners, area)| {
                let from = ball.centre - Picker::nearest_of(*corners, ball.centre);
                (from, from.length(), *area)
            })
            .collect();
        let nearest = near
            .iter()
            .map(|(_, length, _)| *length)
            .fold(f64::INFINITY, f64::min);
        if !(nearest > 0.0 && nearest.is_finite()) {
            return None;
        }
        ball.radius = nearest;
        let soft = SOFT * nearest;
        let (mut push, mut weights) = (DVec3::ZERO, 0.0);
        for (from, length, area) in &near {
            let weight = area * ((nearest - length) / soft).exp();
            push += weight / length * *from;
            weights += weight;
        }
        let push = push / weights;
        let step = soft * (push - push.dot(across) * across);
        if step.length() < STILL * nearest {
            break;
        }
        ball.centre += step;
        if ball.centre.distance(start) > most {
            return None;
        }
    }
    Some(ball)
}
