//! Numbers at vertices, for colours: how a surface bends and how thick what it encloses is.
//!
//! A vertex without a value (no triangle has it, it is on an open end, nothing is opposite) has NaN, and should be shown grey. Results do not
//! depend on the number of threads.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::measure::{diameter, inscribed};
use super::report::NONE;
use super::surface::Surface;
use super::surface::graph::field;

/// Vertices between two looks at whether to stop.
const CHUNK: usize = 1 << 10;

/// Mean curvature at each vertex, in one over the file's unit: above zero where the surface bulges outwards, one over the radius on a ball and half of that on
/// a tube. From the cotangent Laplacian over the mixed
/// Voronoi area (Meyer, Desbrun, Schröder and Barr 2003). None when `cancel` was set.
pub fn curvature(surface: &Surface, cancel: &AtomicBool) -> Option<Vec<f32>> {
    let vertices = surface.mesh().positions.len();
    let normals = surface.vertex_normals();
    let mut areas = vec![0.0; vertices];
    let mut pulls = vec![DVec3::ZERO; vertices];
    let mut is_inside = vec![true; vertices];
    for (triangle, face) in surface.triangles() {
        if (triangle as usize).is_multiple_of(CHUNK) && cancel.load(Ordering::Relaxed) {
            return None;
        }
        let at = face.map(|vertex| surface.position(vertex));
        for (vertex, area) in face.iter().zip(mixed_areas(at)) {
            areas[*vertex as usize] += area;
        }
        for (corner, half_edge) in (3 * triangle..).take(3).enumerate() {
            let [from, to] = [corner, (corner + 1) % 3];
            // By the angle across from the edge.
            let pull = cotangent(at, (corner + 2) % 3) / 2.0 * (at[from] - at[to]);
            pulls[face[from] as usize] += pull;
            pulls[face[to] as usize] -= pull;
            if surface.twin(half_edge).is_none() {
                is_inside[face[from] as usize] = false;
                is_inside[face[to] as usize] = false;
            }
        }
    }
    let value = |vertex: usize| {
        let normal = normals[vertex].try_normalize()?;
        let bend = pulls[vertex].dot(normal) / (2.0 * areas[vertex]);
        (is_inside[vertex] && bend.is_finite()).then_some(bend)
    };
    let values: Vec<f32> = (0..vertices).map(|vertex| single(value(vertex))).collect();
    Some(spread(surface, values))
}

/// The cotangent of a triangle's angle, zero where it has no area.
fn cotangent(at: [DVec3; 3], corner: usize) -> f64 {
    let [one, other] = [1, 2].map(|step| at[(corner + step) % 3] - at[corner]);
    let cross = one.cross(other).length();
    if cross > 0.0 {
        one.dot(other) / cross
    } else {
        0.0
    }
}

/// How much of a triangle belongs to each corner: what is nearest to it, or a half and two quarters where an angle is obtuse.
fn mixed_areas(at: [DVec3; 3]) -> [f64; 3] {
    let area = (at[1] - at[0]).cross(at[2] - at[0]).length() / 2.0;
    let cotangents = [0, 1, 2].map(|corner| cotangent(at, corner));
    let obtuse = cotangents.iter().position(|cotangent| *cotangent < 0.0);
    [0, 1, 2].map(|corner| match obtuse {
        Some(obtuse) if obtuse == corner => area / 2.0,
        Some(_) => area / 4.0,
        None => {
            let part = |other: usize, across: usize| {
                at[corner].distance_squared(at[other]) * cotangents[across] / 8.0
            };
            let [next, last] = [(corner + 1) % 3, (corner + 2) % 3];
            part(next, last) + part(last, next)
        }
    })
}

/// The shape diameter at each vertex ([`super::measure::Thickness::diameter`]), by all threads. Where there are more than `most` vertices so many are
/// asked, evenly by number, and others have what the nearest along the surface has. None when `cancel` was set.
pub fn thickness(surface: &Surface, most: usize, cancel: &AtomicBool) -> Option<Vec<f32>> {
    asked(surface, most, cancel, |place, normal| {
        diameter(surface.picker(), place, normal)
    })
}

/// The radius of the largest ball inside that touches each vertex ([`super::measure::inscribed`]); else as [`thickness`].
pub fn radius(surface: &Surface, most: usize, cancel: &AtomicBool) -> Option<Vec<f32>> {
    asked(surface, most, cancel, |place, normal| {
        Some(inscribed(surface.picker(), place, normal)?.radius)
    })
}

/// What `ask` says of places and their normals, at so many vertices; the others have what the nearest has.
fn asked(
    surface: &Surface,
    most: usize,
    cancel: &AtomicBool,
    ask: impl Fn(Vec3, Vec3) -> Option<f32> + Sync,
) -> Option<Vec<f32>> {
    let normals = surface.vertex_normals();
    let used: Vec<u32> = (0_u32..)
        .zip(&normals)
        .filter(|(_, normal)| **normal != DVec3::ZERO)
        .map(|(vertex, _)| vertex)
        .collect();
    let every = used.len().div_ceil(most.max(1)).max(1);
    let asked: Vec<u32> = used.iter().step_by(every).copied().collect();
    let found: Vec<Option<f32>> = asked
        .par_iter()
        .map(|vertex| {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let (place, normal) = (surface.position(*vertex), normals[*vertex as usize]);
            ask(place.as_vec3(), normal.normalize_or_zero().as_vec3())
        })
        .collect();
    if cancel.load(Ordering::Relaxed) {
        return None;
    }
    let mut values = vec![f32::NAN; normals.len()];
    let known = asked.iter().zip(&found);
    let known = known.filter_map(|(vertex, value)| Some((*vertex, (*value)?)));
    let known: Vec<(u32, f32)> = known.collect();
    if every == 1 {
        known
            .iter()
            .for_each(|(vertex, value)| values[*vertex as usize] = *value);
    } else {
        let sources: Vec<(u32, u32)> = known.iter().map(|(vertex, _)| *vertex).zip(0..).collect();
        let near = field(
            surface,
            surface.graph(),
            &sources,
            |_| f64::INFINITY,
            cancel,
        )?;
        for (value, source) in values.iter_mut().zip(&near.sources) {
            *value = known
                .get(*source as usize)
                .map_or(f32::NAN, |(_, value)| *value);
        }
    }
    Some(spread(surface, values))
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "for colours, single precision is plenty"
)]
fn single(value: Option<f64>) -> f32 {
    value.map_or(f32::NAN, |value| value as f32)
}

/// Gives vertices that were joined with one the value of that one.
fn spread(surface: &Surface, mut values: Vec<f32>) -> Vec<f32> {
    let mesh = surface.mesh();
    for (face, triangle) in surface.faces().iter().zip(&mesh.triangles) {
        for (joined, vertex) in face.iter().zip(triangle) {
            if *joined != NONE && joined != vertex {
                values[*vertex as usize] = values[*joined as usize];
            }
        }
    }
    values
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that stops says enough by stopping"
    )]
    use std::sync::Arc;

    use super::*;
    use crate::mesh::pick::Picker;
    use crate::mesh::{Mesh, made};

    fn surface(mesh: Mesh) -> Surface {
        let never = AtomicBool::new(false);
        let picker = Picker::new(Arc::new(mesh), &never, &mut |_, _| {}).unwrap();
        Surface::new(picker, &never).unwrap()
    }

    fn bent(mesh: Mesh) -> Vec<f32> {
        curvature(&surface(mesh), &AtomicBool::new(false)).unwrap()
    }

    #[test]
    fn balls_and_tubes_bend_as_their_radii_say() {
        for radius in [0.01, 1.0, 300.0] {
            let ball = made::placed(made::sphere(4), radius, Vec3::ZERO);
            assert!(
                bent(ball.clone())
                    .iter()
                    .all(|bend| (bend * radius - 1.0).abs() < 0.05)
            );
            let hollow = made::turned(ball, |_| true);
            assert!(
                bent(hollow)
                    .iter()
                    .all(|bend| (bend * radius + 1.0).abs() < 0.05)
            );
        }
        let mut tube = made::tube(64, 30);
        tube.positions
            .iter_mut()
            .for_each(|position| position.z *= 0.1);
        let values = bent(tube);
        // The first and last rows are open.
        assert!(
            values[..64]
                .iter()
                .chain(&values[64 * 29..])
                .all(|bend| bend.is_nan())
        );
        assert!(
            values[64..64 * 29]
                .iter()
                .all(|bend| (bend - 0.5).abs() < 0.01)
        );
    }

    #[test]
    fn parted_vertices_have_one_value() {
        let whole = made::torus(30, 20);
        let (one, parted) = (bent(whole.clone()), bent(made::soup(&whole)));
        for (corner, vertex) in whole.triangles.as_flattened().iter().enumerate() {
            assert_eq!(parted[corner], one[*vertex as usize]);
        }
    }

    #[test]
    fn a_tube_is_as_thick_everywhere_also_where_few_are_asked() {
        let surface = surface(made::torus(120, 40));
        let never = AtomicBool::new(false);
        let all = thickness(&surface, usize::MAX, &never).unwrap();
        let some = thickness(&surface, 300, &never).unwrap();
        assert!(
            all.iter()
                .chain(&some)
                .all(|thick| (0.9..1.4).contains(thick))
        );
        for (one, other) in all.iter().zip(&some) {
            assert!((one - other).abs() < 0.2, "{one} {other}");
        }
        let cancelled = AtomicBool::new(true);
        assert!(thickness(&surface, 300, &cancelled).is_none());
        assert!(curvature(&surface, &cancelled).is_none());
        // The largest ball in a ring's tube has the tube's radius, 0.5 here; facets make it a little less.
        let balls = radius(&surface, usize::MAX, &never).unwrap();
        let thick = thickness(&surface, usize::MAX, &never).unwrap();
        for (ball, thick) in balls.iter().zip(&thick) {
            assert!((0.4..0.56).contains(&(ball / thick)), "{ball} {thick}");
        }
        let nothing = thickness(&self::surface(Mesh::default()), 9, &never);
        assert!(nothing.unwrap().is_empty());
    }
}
