//! Coordinates as files have them, in single or double precision, and the mesh that they make.

use bytemuck::Zeroable;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::join::Pages;
use super::numerals::Value;
use super::{Stop, with_room};
use crate::mesh::Mesh;

/// Largest coordinate: beyond it squares of distances leave f32.
pub(super) const LARGEST: f64 = 1e15;

/// A model that stands so many times its size from zero is counted from an origin of its own.
const FAR: f64 = 8.0;

/// One coordinate in a file's precision.
pub(super) trait Coordinate: Value + Into<f64> + PartialOrd + Zeroable {
    /// The nearest to a value.
    fn nearest(value: f64) -> Self;
    /// Bits that are equal where the coordinates are.
    fn bits(self) -> u64;
    /// Points as they are, where positions are the same bytes.
    fn positions(points: Vec<[Self; 3]>) -> Result<Vec<Vec3>, Vec<[Self; 3]>>;
}

impl Coordinate for f32 {
    fn nearest(value: f64) -> Self {
        narrow(value)
    }

    fn bits(self) -> u64 {
        // −0 + 0 is 0.
        u64::from((self + 0.0).to_bits())
    }

    fn positions(points: Vec<[Self; 3]>) -> Result<Vec<Vec3>, Vec<[Self; 3]>> {
        bytemuck::allocation::try_cast_vec(points).map_err(|(_, points)| points)
    }
}

impl Coordinate for f64 {
    fn nearest(value: f64) -> Self {
        value
    }

    fn bits(self) -> u64 {
        (self + 0.0).to_bits()
    }

    fn positions(points: Vec<[Self; 3]>) -> Result<Vec<Vec3>, Vec<[Self; 3]>> {
        Err(points)
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
    let [least, most] = bounds(&points);
    let origin = origin_of(least, most);
    let positions = match origin == DVec3::ZERO {
        true => C::positions(points),
        false => Err(points),
    };
    Mesh {
        origin,
        // In place where the file has single precision.
        positions: positions.unwrap_or_else(|points| {
            let positions = points.into_iter().map(|point| position(point, origin));
            positions.collect()
        }),
        triangles,
    }
}

/// The corners between which all points lie, looked for by all threads.
fn bounds<C: Coordinate>(points: &[[C; 3]]) -> [DVec3; 2] {
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    points
        .par_chunks(POINTS)
        .map(|points| {
            let Some(first) = points.first() else {
                return none;
            };
            let [mut least, mut most] = [[*first; TOGETHER]; 2];
            // Points that stand one behind the other, and none of which waits for the last: several are compared at once.
            let (some, rest) = points.as_chunks::<TOGETHER>();
            for points in some {
                widen(least.as_flattened_mut(), most.as_flattened_mut(), points);
            }
            for point in rest {
                widen(least[0].as_mut_slice(), most[0].as_mut_slice(), &[*point]);
            }
            let corner = |point: [C; 3]| DVec3::from_array(point.map(Into::into));
            [
                least.map(corner).into_iter().fold(none[0], DVec3::min),
                most.map(corner).into_iter().fold(none[1], DVec3::max),
            ]
        })
        .reduce(|| none, |a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

/// Points that a thread takes at once.
const POINTS: usize = 1 << 14;
/// Points that are compared at once: coordinates of so many fill whole registers.
const TOGETHER: usize = 4;

#[inline]
fn widen<C: Coordinate>(least: &mut [C], most: &mut [C], points: &[[C; 3]]) {
    for ((least, most), value) in least.iter_mut().zip(most).zip(points.as_flattened()) {
        *least = if *value < *least { *value } else { *least };
        *most = if *value > *most { *value } else { *most };
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
