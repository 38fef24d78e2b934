//! Hollows: a component that is inside out and lies inside the largest one is a wall as it should be, as of a bubble or a lumen.
//!
//! Inside is where the largest component winds around a point more than half a time (Jacobson, Kavan and Sorkine-Hornung 2013): that needs
//! no closed surface, so that a small hole does not turn all hollows of a scan into faults, and is below zero in one that is itself
//! inside out. The way round is a sum over its triangles, so what lies outside its box is not asked, and only the first
//! [`SUMMED_MOST`] triangles are summed; of the hollows beyond that the box decides.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::components::{Component, corners};
use crate::mesh::Mesh;

/// Triangles summed at most in one report: about two seconds.
const SUMMED_MOST: usize = 1 << 27;

/// Marks the hollows; the first component is the largest.
pub(super) fn mark(mesh: &Mesh, of_triangle: &[u32], all: &mut [Component]) {
    let Some((largest, others)) = all.split_first_mut() else {
        return;
    };
    let mut inside: Vec<&mut Component> = others
        .iter_mut()
        .filter(|other| other.is_inside_out() && largest.surrounds(other))
        .collect();
    if inside.is_empty() {
        return;
    }
    let triangles: Vec<usize> = (0..of_triangle.len())
        .filter(|triangle| of_triangle[*triangle] == 0)
        .collect();
    let asked = SUMMED_MOST / triangles.len().max(1);
    inside.par_iter_mut().enumerate().for_each(|(at, other)| {
        let [point, ..] = corners(mesh, other.first_triangle as usize);
        other.hollow = at >= asked || winding(mesh, &triangles, point) > 0.5;
    });
}

/// How many times triangles wind around a point.
fn winding(mesh: &Mesh, triangles: &[usize], point: Vec3) -> f64 {
    let point = point.as_dvec3();
    let angles = triangles.iter().map(|triangle| {
        solid_angle(corners(mesh, *triangle).map(|corner| corner.as_dvec3() - point))
    });
    angles.sum::<f64>() / (4.0 * PI)
}

/// The solid angle of a triangle seen from zero, above zero where its back is seen (Van Oosterom and Strackee 1983).
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (x, y, z) = (a.length(), b.length(), c.length());
    let volume = a.dot(b.cross(c));
    let across = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
    2.0 * volume.atan2(across)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;
    use crate::mesh::made;

    #[test]
    fn surfaces_wind_around_what_is_inside() {
        let cube = made::cube();
        let torus = made::torus(30, 20);
        let inverted = made::turned(made::cube(), |_| true);
        let table = [
            (&cube, Vec3::splat(0.5), 1.0),
            (&cube, Vec3::new(0.1, 0.9, 0.01), 1.0),
            (&cube, Vec3::splat(1.5), 0.0),
            (&inverted, Vec3::splat(0.5), -1.0),
            (&torus, Vec3::ZERO, 0.0),
            (&torus, 2.0 * Vec3::X, 1.0),
        ];
        for (mesh, point, expected) in table {
            let all: Vec<usize> = (0..mesh.triangles.len()).collect();
            assert!(
                (winding(mesh, &all, point) - expected).abs() < 1e-9,
                "{point}"
            );
        }
    }
}
