//! Coordinates as files have them, in single or double precision, and the mesh that they make.

use bytemuck::Zeroable;
use glam::{DVec3, Vec3};

use super::join::Pages;
use super::numerals::Value;
use super::{Stop, with_room};
use crate::mesh::Mesh;

/// Largest coordinate: beyond it squares of distances leave f32.
pub(super) const LARGEST: f64 = 1e15;

/// A model that stands so many times its size from zero is counted from an origin of its own.
const FAR: f64 = 8.0;

/// One coordinate in a file's precision.
pub(super) trait Coordinate: Value + Into<f64> + PartialEq + Zeroable {
    /// The nearest to a value.
    fn nearest(value: f64) -> Self;
    /// Bits that are equal where the coordinates are.
    fn bits(self) -> u64;
}

impl Coordinate for f32 {
    fn nearest(value: f64) -> Self {
        narrow(value)
    }

    fn bits(self) -> u64 {
        // −0 + 0 is 0.
        u64::from((self + 0.0).to_bits())
    }
}

impl Coordinate for f64 {
    fn nearest(value: f64) -> Self {
        value
    }

    fn bits(self) -> u64 {
        (self + 0.0).to_bits()
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "rounding to the nearest is what is wanted"
)]
pub(super) fn narrow(value: f64) -> f32 {
    value as f32
}

/// Whether a value may be a coordinate.
#[inline]
pub(super) fn is_coordinate(value: f64) -> bool {
    value.abs() <= LARGEST // false for NaN
}

/// The fault of a value that is none.
pub(super) fn no_coordinate(at: usize, value: f64) -> Stop {
    let value = match value.is_finite() {
        true => format!("{value:e}"),
        false => value.to_string(),
    };
    let problem = format!(
        "has the coordinate {value}: coordinates are numbers up to ±{LARGEST:e}; mend or remove the vertex"
    );
    Stop::fault(at, problem)
}

/// The mesh of these vertices and triangles.
pub(super) fn mesh<C: Coordinate>(points: Vec<[C; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    let origin = origin(points.iter().copied());
    // In place where the file has single precision.
    let positions = points.into_iter().map(|point| position(point, origin));
    Mesh {
        origin,
        positions: positions.collect(),
        triangles,
    }
}

/// The same of vertices in pages, of which each is given back when it is done with.
pub(super) fn mesh_of_pages<C: Coordinate>(
    points: Pages<C>,
    triangles: Vec<[u32; 3]>,
) -> Result<Mesh, Stop> {
    let origin = origin(points.iter());
    let count = points.len();
    // First in pages again: beside all of double precision there would be no room for all of single.
    let pages = points.into_pages().map(|page| {
        let page = page.into_iter().map(|point| position(point, origin));
        page.collect::<Box<[Vec3]>>()
    });
    let pages: Vec<_> = pages.collect();
    let mut positions = with_room(count)?;
    for page in pages {
        positions.extend_from_slice(&page);
    }
    Ok(Mesh {
        origin,
        positions,
        triangles,
    })
}

/// A vertex from an origin.
#[inline]
fn position<C: Coordinate>(point: [C; 3], origin: DVec3) -> Vec3 {
    let [x, y, z] = point.map(Into::into);
    Vec3::new(
        narrow(x - origin.x),
        narrow(y - origin.y),
        narrow(z - origin.z),
    )
}

/// Where to count these from.
pub(super) fn origin<C: Coordinate>(points: impl Iterator<Item = [C; 3]>) -> DVec3 {
    let mut least = DVec3::INFINITY;
    let mut most = DVec3::NEG_INFINITY;
    for point in points {
        let point = DVec3::from_array(point.map(Into::into));
        least = least.min(point);
        most = most.max(point);
    }
    origin_of(least, most)
}

/// Where to count from what stands between two corners: zero, but on axes where that is far from zero the middle, rounded to single
/// precision. There the differences of coordinates in single precision are exact, since none is twice another (Sterbenz).
pub(super) fn origin_of(least: DVec3, most: DVec3) -> DVec3 {
    if least.cmpgt(most).any() {
        return DVec3::ZERO; // nothing is there
    }
    let size = (most - least).max_element();
    let middle = (least + most) / 2.0;
    let far = middle.abs().cmpgt(DVec3::splat(FAR * size));
    DVec3::select(far, middle.as_vec3().as_dvec3(), DVec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_far_from_zero_have_an_origin() {
        let far = [4_500_000.25, 0.5, -700_000.75];
        let points = vec![far, far.map(|value| value + 0.001), far];
        let mesh = mesh(points.clone(), vec![[0, 1, 2]]);
        assert!(
            mesh.origin.x > 4e6 && mesh.origin.z < -7e5,
            "{}",
            mesh.origin
        );
        for (position, point) in mesh.positions.iter().zip(&points) {
            let back = mesh.origin + position.as_dvec3();
            assert!(
                back.distance(DVec3::from_array(*point)) < 1e-7,
                "{back} is not {point:?}"
            );
        }
    }

    #[test]
    fn models_near_zero_are_left_as_they_are() {
        let points = vec![[1.5_f32, -2.0, 3.25], [0.0, 4.0, -1.0]];
        let mesh = mesh(points.clone(), Vec::new());
        assert_eq!(mesh.origin, DVec3::ZERO);
        assert_eq!(
            mesh.positions,
            points
                .iter()
                .map(|&point| Vec3::from(point))
                .collect::<Vec<_>>()
        );
    }

    #[test]
    fn single_precision_far_from_zero_stays_exact() {
        let points: Vec<[f32; 3]> = (0..1000_u16)
            .map(|step| {
                [
                    100_000.0 + f32::from(step) / 128.0,
                    f32::from(step) / 512.0,
                    7.0,
                ]
            })
            .collect();
        let mesh = mesh(points.clone(), Vec::new());
        assert!(mesh.origin.x > 1e5, "counted from an origin");
        for (position, point) in mesh.positions.iter().zip(points) {
            let back = mesh.origin + position.as_dvec3();
            assert_eq!(back, Vec3::from(point).as_dvec3());
        }
    }
}
