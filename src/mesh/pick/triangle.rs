//! A ray or a point and one triangle.
//!
//! Rays follow Woop, Benthin and Wald (2013, "Watertight Ray/Triangle Intersection"): corners are sheared so that the ray is an axis, and the
//! signs of three areas say on which side of each edge it passes. Two triangles with a common edge compute the same area for it with opposite
//! signs, so a ray cannot slip between them; on the edge both are hit. In double precision, which the coordinates' products nearly fit, it costs
//! no more than single precision with a second try.

use glam::{DVec3, Vec3};

/// A ray, sheared.
pub(super) struct Sheared {
    origin: DVec3,
    /// Axes across, then the one that the ray goes most along.
    axes: [usize; 3],
    shear: [f64; 2],
    scale: f64,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub(super) distance: f64,
    /// Weights of the corners.
    pub(super) weights: DVec3,
    /// The ray comes to the side from which corners run counter-clockwise.
    pub(super) front: bool,
}

impl Sheared {
    /// The direction is of length 1.
    pub(super) fn new(origin: Vec3, direction: DVec3) -> Self {
        let along = direction.abs().max_position();
        let (mut x, mut y) = ((along + 1) % 3, (along + 2) % 3);
        if direction[along] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        Self {
            origin: origin.as_dvec3(),
            axes: [x, y, along],
            shear: [
                direction[x] / direction[along],
                direction[y] / direction[along],
            ],
            scale: direction[along].recip(),
        }
    }

    fn shear(&self, corner: Vec3) -> [f64; 3] {
        let from = (corner.as_dvec3() - self.origin).to_array();
        let [x, y, z] = self.axes.map(|axis| from[axis]);
        [x - self.shear[0] * z, y - self.shear[1] * z, z * self.scale]
    }

    /// Where the ray meets a triangle, edges and corners with it; None for triangles that it sees from the edge.
    #[inline]
    pub(super) fn meet(&self, corners: [Vec3; 3]) -> Option<Met> {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = corners.map(|corner| self.shear(corner));
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let area = u + v + w;
        if area == 0.0 {
            return None;
        }
        let weights = DVec3::new(u, v, w) / area;
        let distance = weights.dot(DVec3::new(az, bz, cz));
        (distance >= 0.0).then_some(Met {
            distance,
            weights,
            front: area > 0.0,
        })
    }
}

/// Parts of the longest possible area below which a triangle is taken for lines: what rounding leaves of its inside says nothing.
const SLIVER: f64 = 1e-10;
/// What rounding may add to a height's square, as a part of it.
const ROUNDING: f64 = 1e-6;
/// What it may leave of a height of nothing, squared: a part of the height of a corner that stands on its triangle. Without it a point on an
/// edge is beyond its own triangle where only that distance, zero, is asked for.
const FLAT: f64 = 1e-29;

/// A triangle with what does not change from point to point.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    a: DVec3,
    /// Its edges from there, and their products.
    ab: DVec3,
    ac: DVec3,
    ab_ab: f64,
    ac_ac: f64,
    ab_ac: f64,
}

impl Facet {
    /// Of three corners.
    #[inline]
    pub fn new(corners: [Vec3; 3]) -> Self {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let (ab, ac) = (b - a, c - a);
        Self {
            a,
            ab,
            ac,
            ab_ab: ab.dot(ab),
            ac_ac: ac.dot(ac),
            ab_ac: ab.dot(ac),
        }
    }

    /// The way to a point from the point of the triangle that is nearest to it.
    #[inline]
    pub fn way_to(&self, point: DVec3) -> DVec3 {
        let (weights, _) = self.nearest(point);
        point - self.a - weights.y * self.ab - weights.z * self.ac
    }

    /// The point of the triangle nearest to a point, by the weights of the corners, and the square of its distance. Triangles without area are
    /// the lines or points that they are.
    ///
    /// By the region of a corner, an edge or the inside that the point is above (Ericson 2005, "Real-Time Collision Detection", 5.1.5).
    #[inline]
    pub(super) fn nearest(&self, point: DVec3) -> (DVec3, f64) {
        let &Self {
            a,
            ab,
            ac,
            ab_ab,
            ac_ac,
            ab_ac,
        } = self;
        let ap = point - a;
        let (ab_ap, ac_ap) = (ab.dot(ap), ac.dot(ap));
        let squared_area = ab_ab * ac_ac - ab_ac * ab_ac;
        if squared_area <= SLIVER * ab_ab * ac_ac {
            return of_edges([a, a + ab, a + ac], point);
        }
        let weights = 'region: {
            if ab_ap <= 0.0 && ac_ap <= 0.0 {
                break 'region DVec3::X;
            }
            let (ab_bp, ac_bp) = (ab_ap - ab_ab, ac_ap - ab_ac);
            if ab_bp >= 0.0 && ac_bp <= ab_bp {
                break 'region DVec3::Y;
            }
            let w = ab_ap * ac_bp - ab_bp * ac_ap;
            if w <= 0.0 && ab_ap >= 0.0 && ab_bp <= 0.0 {
                let part = ab_ap / ab_ab;
                break 'region DVec3::new(1.0 - part, part, 0.0);
            }
            let (ab_cp, ac_cp) = (ab_ap - ab_ac, ac_ap - ac_ac);
            if ac_cp >= 0.0 && ab_cp <= ac_cp {
                break 'region DVec3::Z;
            }
            let v = ab_cp * ac_ap - ab_ap * ac_cp;
            if v <= 0.0 && ac_ap >= 0.0 && ac_cp <= 0.0 {
                let part = ac_ap / ac_ac;
                break 'region DVec3::new(1.0 - part, 0.0, part);
            }
            let u = ab_bp * ac_cp - ab_cp * ac_bp;
            let (from_b, from_c) = (ac_bp - ab_bp, ab_cp - ac_cp);
            if u <= 0.0 && from_b >= 0.0 && from_c >= 0.0 {
                let part = from_b / (from_b + from_c);
                break 'region DVec3::new(0.0, 1.0 - part, part);
            }
            let sum = u + v + w;
            DVec3::new(1.0 - v / sum - w / sum, v / sum, w / sum)
        };
        (
            weights,
            (weights.y * ab + weights.z * ac - ap).length_squared(),
        )
    }
}

/// The same of a triangle that is asked once.
#[inline]
pub(super) fn nearest(corners: [Vec3; 3], point: DVec3) -> (DVec3, f64) {
    Facet::new(corners).nearest(point)
}

/// Whether all of a triangle is farther from a point than a distance, by its square, as its plane is. Not where rounding might say so.
#[inline]
pub(super) fn is_beyond(corners: [Vec3; 3], point: DVec3, squared: f64) -> bool {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let across = ab.cross(ac);
    let height = across.dot(ap);
    let least = FLAT * ab.length_squared() * ac.length_squared() * ap.length_squared();
    height * height > squared * across.length_squared() * (1.0 + ROUNDING) + least
}

/// The nearest point of three edges.
#[cold]
fn of_edges(corners: [DVec3; 3], point: DVec3) -> (DVec3, f64) {
    let mut best = (DVec3::X, f64::INFINITY);
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        let along = corners[to] - corners[from];
        let length = along.length_squared();
        let part = match length > 0.0 {
            true => ((point - corners[from]).dot(along) / length).clamp(0.0, 1.0),
            false => 0.0,
        };
        let distance = (corners[from] + part * along).distance_squared(point);
        if distance < best.1 {
            let mut weights = DVec3::ZERO;
            weights[from] = 1.0 - part;
            weights[to] = part;
            best = (weights, distance);
        }
    }
    best
}

/// The point with these weights.
pub(super) fn at([a, b, c]: [DVec3; 3], weights: DVec3) -> DVec3 {
    weights.x * a + weights.y * b + weights.z * c
}

/// The unit vector that stands on a triangle, zero where it has no area.
pub(super) fn normal(corners: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a).normalize_or_zero()
}
