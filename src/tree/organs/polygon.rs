//! Polygons cut into triangles.
//!
//! The plane is that of Newell's normal, so that a polygon that is not quite flat, concave or crosses itself has triangles all the same;
//! ears are clipped by the crate `earcut`. Its time can grow with the square of the number of corners, which is why a polygon has at
//! most [`MOST_CORNERS`].

use earcut::Earcut;
use glam::{DVec2, DVec3, Vec3};

/// Corners that one polygon may have.
pub const MOST_CORNERS: usize = 50_000;

/// Cuts polygons, keeping its scratch memory.
#[derive(Default)]
pub struct Triangulator {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    triangles: Vec<u32>,
}

impl Triangulator {
    /// Adds the triangles of a polygon (indices from 0 on, counter-clockwise seen against the normal) and returns its
    /// unit normal; `None` and no triangle where the corners span no area.
    pub fn add(&mut self, corners: &[Vec3], into: &mut Vec<u32>) -> Option<Vec3> {
        if corners.len() < 3 || corners.len() > MOST_CORNERS {
            return None;
        }
        let normal = newell(corners)?;
        if let [_, _, _] = corners {
            into.extend([0, 1, 2]);
            return Some(normal.as_vec3());
        }
        let (right, up) = normal.any_orthonormal_pair();
        // The pair is right-handed with the normal, or it is made so.
        let up = if right.cross(up).dot(normal) < 0.0 {
            -up
        } else {
            up
        };
        let origin = corners.first().copied().unwrap_or_default().as_dvec3();
        self.flat.clear();
        self.flat.extend(corners.iter().map(|corner| {
            let from = corner.as_dvec3() - origin;
            DVec2::new(from.dot(right), from.dot(up)).to_array()
        }));
        self.earcut
            .earcut_slice(&self.flat, &[], &mut self.triangles);
        for triangle in self.triangles.chunks_exact(3) {
            let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
            let place = |i: u32| {
                self.flat
                    .get(i as usize)
                    .map_or(DVec2::ZERO, |p| DVec2::from(*p))
            };
            let area = (place(b) - place(a)).perp_dot(place(c) - place(a));
            into.extend(if area < 0.0 { [a, c, b] } else { [a, b, c] });
        }
        (!self.triangles.is_empty()).then(|| normal.as_vec3())
    }
}

/// The unit normal of a polygon that need not be flat; `None` where it spans no area.
fn newell(corners: &[Vec3]) -> Option<DVec3> {
    let first = corners.first()?.as_dvec3();
    let size = corners.iter().fold(0.0_f64, |size, corner| {
        size.max((corner.as_dvec3() - first).abs().max_element())
    });
    let (mut sum, mut largest) = (DVec3::ZERO, DVec3::ZERO);
    let ends = corners.iter().skip(1).zip(corners.iter().skip(2));
    for (a, b) in ends {
        let [a, b] = [a, b].map(|p| (p.as_dvec3() - first) / size);
        let part = a.cross(b);
        sum += part;
        if part.length_squared() > largest.length_squared() {
            largest = part;
        }
    }
    // Where a polygon crosses itself its halves may cancel: then the plane of its largest part is taken.
    if sum.length_squared() < 1e-6 * largest.length_squared() {
        sum = largest;
    }
    let area = sum.length();
    (area > 1e-12 && area.is_finite()).then(|| sum / area)
}
