//! A cap's inner vertices placed so that the surface bends as little as it can: the thin plate (Liepa 2003 section 4, after Kobbelt, Campagna,
//! Vorsatz and Seidel 1998).
//!
//! Least squares of the umbrella vectors (the mean of a vertex's neighbours less the vertex) at all vertices of the cap and of its loop; those
//! of the loop reach into the surface around, which is how the cap goes on as that comes. The conjugate gradient method solves the normal
//! equations without making them; a few thousand unknowns take some hundred rounds. Should it end early, what is found then is a cap, too.

use glam::DVec3;

use crate::mesh::mend::surface::Surface;
use crate::mesh::mend::{MendError, Work};

/// Rounds at most.
const ROUNDS: usize = 1000;

/// How much smaller the gradient is made.
const PRECISION: f64 = 1e-7;

/// Moves the vertices from `start` on.
pub(super) fn fair(
    surface: &mut Surface,
    around: &[u32],
    start: usize,
    work: &Work,
) -> Result<(), MendError> {
    if surface.points.len() <= start {
        return Ok(());
    }
    let plate = Plate::new(surface, around, start);
    let middle = plate.middle(surface, around);
    // Of vertices that stay only those next to the cap are asked for, so small caps on large surfaces cost little.
    let moving = surface.points[start..].iter();
    let mut points: Vec<DVec3> = moving.map(|point| *point - middle).collect();
    let still = |vertex: u32| surface.points[vertex as usize] - middle;
    plate.solve(still, &mut points, work)?;
    if points.iter().all(|point| point.is_finite()) {
        for (place, point) in surface.points[start..].iter_mut().zip(points) {
            *place = (middle + point).as_vec3().as_dvec3();
        }
    }
    Ok(())
}

/// The umbrellas of a cap.
struct Plate {
    start: usize,
    /// A vertex and its neighbours, one row after the other.
    rows: Vec<Vec<u32>>,
    /// What each umbrella vector weighs: by the square of the edges' length it is a curvature, whatever the size of the triangles.
    weights: Vec<f64>,
}

impl Plate {
    fn new(surface: &Surface, around: &[u32], start: usize) -> Self {
        let mut ring = Vec::new();
        let inner = (0_u32..).take(surface.points.len()).skip(start);
        let rows = around.iter().copied().chain(inner).map(|vertex| {
            surface.ring(vertex, &mut ring);
            let neighbours = ring.iter().map(|(other, _)| *other);
            std::iter::once(vertex).chain(neighbours).collect()
        });
        let rows: Vec<Vec<u32>> = rows.collect();
        let squares: Vec<f64> = rows.iter().map(|row| mean_square(surface, row)).collect();
        let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
        // Edges next to nothing must not outweigh all others.
        let weight = |square: f64| {
            let weight = mean / square.max(1e-4 * mean);
            if weight.is_finite() { weight } else { 1.0 }
        };
        Self {
            start,
            rows,
            weights: squares.into_iter().map(weight).collect(),
        }
    }

    /// Where to count from, so that what lies far from the origin loses nothing to rounding.
    fn middle(&self, surface: &Surface, around: &[u32]) -> DVec3 {
        let points = around.iter().map(|vertex| surface.points[*vertex as usize]);
        points.sum::<DVec3>() / around.len().max(1) as f64
    }

    /// Umbrella vectors, of vertices that move and of those that do not.
    fn umbrellas(&self, point: impl Fn(u32) -> DVec3) -> Vec<DVec3> {
        let umbrella = |(row, weight): (&Vec<u32>, &f64)| match row.split_first() {
            Some((vertex, ring)) if !ring.is_empty() => {
                let sum: DVec3 = ring.iter().map(|other| point(*other)).sum();
                *weight * (sum / ring.len() as f64 - point(*vertex))
            }
            _ => DVec3::ZERO,
        };
        self.rows.iter().zip(&self.weights).map(umbrella).collect()
    }

    /// What umbrella vectors pull at each vertex that moves.
    fn pulls(&self, umbrellas: &[DVec3], len: usize) -> Vec<DVec3> {
        let mut pulls = vec![DVec3::ZERO; len];
        let mut pull = |vertex: u32, by: DVec3| {
            let inner = (vertex as usize).checked_sub(self.start);
            if let Some(place) = inner.and_then(|inner| pulls.get_mut(inner)) {
                *place += by;
            }
        };
        for ((row, weight), umbrella) in self.rows.iter().zip(&self.weights).zip(umbrellas) {
            if let Some((vertex, ring)) = row.split_first() {
                let umbrella = *weight * *umbrella;
                pull(*vertex, -umbrella);
                for other in ring {
                    pull(*other, umbrella / ring.len() as f64);
                }
            }
        }
        pulls
    }

    /// The three coordinates are three systems of one matrix, solved together with a step of their own each.
    fn solve(
        &self,
        still: impl Fn(u32) -> DVec3,
        points: &mut [DVec3],
        work: &Work,
    ) -> Result<(), MendError> {
        let moving = |vertex: u32, of: &[DVec3]| {
            let inner = (vertex as usize).checked_sub(self.start);
            inner.and_then(|inner| of.get(inner).copied())
        };
        let now = self.umbrellas(|vertex| moving(vertex, points).unwrap_or_else(|| still(vertex)));
        let dots = |one: &[DVec3], other: &[DVec3]| -> DVec3 {
            one.iter().zip(other).map(|(a, b)| *a * *b).sum()
        };
        let mut residual: Vec<DVec3> = self.pulls(&now, points.len());
        residual.iter_mut().for_each(|pull| *pull = -*pull);
        let mut direction = residual.clone();
        let mut size = dots(&residual, &residual);
        let enough = size * PRECISION * PRECISION;
        for _ in 0..ROUNDS.min(20 * points.len() + 20) {
            work.go_on()?;
            if size.cmple(enough).all() {
                break;
            }
            let umbrellas = self.umbrellas(|vertex| moving(vertex, &direction).unwrap_or_default());
            let image = self.pulls(&umbrellas, points.len());
            let step = ratio(size, dots(&direction, &image));
            for (at, point) in points.iter_mut().enumerate() {
                *point += step * direction[at];
                residual[at] -= step * image[at];
            }
            let next = dots(&residual, &residual);
            let keep = ratio(next, size);
            size = next;
            for (direction, residual) in direction.iter_mut().zip(&residual) {
                *direction = *residual + keep * *direction;
            }
        }
        Ok(())
    }
}

/// The mean square of the lengths of edges from a vertex to its neighbours.
fn mean_square(surface: &Surface, row: &[u32]) -> f64 {
    let Some((vertex, ring)) = row.split_first() else {
        return 0.0;
    };
    let squares = ring
        .iter()
        .map(|other| surface.length([*vertex, *other]).powi(2));
    squares.sum::<f64>() / ring.len().max(1) as f64
}

/// One by the other, and 0 where that is none.
fn ratio(one: DVec3, other: DVec3) -> DVec3 {
    DVec3::select(other.cmpgt(DVec3::ZERO), one / other, DVec3::ZERO)
}
