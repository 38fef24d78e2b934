//! The reference system of a junction or bifurcation, and angles in it: in the plane in which it branches, and out of that.
//!
//! After VMTK (its bifurcation reference systems and vectors; Antiga and Steinman 2004, "Robust and objective decomposition and mapping of
//! bifurcating vessels"). There the normal points to whichever side the order of the lines makes of it, and so angles change their sign
//! with the order of targets. Here the thickest daughter is at the larger angle within the plane than the thinnest, always, and the normal
//! is on the side from which that turns to the left.

use glam::DVec3;

use super::vmtk::Ball;

/// Where a junction is and how it is turned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// Its middle: of the ends of what meets, by the square of the radius.
    pub origin: DVec3,
    /// Of the plane in which it branches, of length 1.
    pub normal: DVec3,
    /// The way through it, with the flow, in that plane, of length 1.
    pub up: DVec3,
}

/// Angles of a vector in a frame, radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Direction {
    /// From the way through the junction, within the plane, −π to π.
    pub in_plane: f64,
    /// Out of the plane, above zero on the normal's side.
    pub out_of_plane: f64,
}

/// What a daughter is like, by which the normal's side is chosen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Daughter {
    /// With the flow.
    pub(super) vector: DVec3,
    pub(super) radius: f64,
    pub(super) tips: u32,
    pub(super) length: f64,
}

impl Frame {
    /// Of the ways through a junction, each from a ball upstream to one downstream. None without any that goes somewhere.
    pub(super) fn new(ways: &[[Ball; 2]]) -> Option<Self> {
        let mut ways = ways.to_vec();
        // The same order whatever theirs.
        ways.sort_by(|a, b| {
            let [one, other] = [a, b].map(|way| way[1].centre.to_array());
            let by_radius = b[1].radius.total_cmp(&a[1].radius);
            let mut by_place = one.iter().zip(&other).map(|(a, b)| a.total_cmp(b));
            by_radius.then(by_place.find(|order| order.is_ne()).unwrap_or(by_radius))
        });
        let origin = middle(ways.as_flattened());
        let mut normal = DVec3::ZERO;
        for (place, one) in ways.iter().enumerate() {
            for other in &ways[place + 1..] {
                let found = normal_of(*one, *other, origin);
                normal += if normal.dot(found) < 0.0 {
                    -found
                } else {
                    found
                };
            }
        }
        let forward = |[from, to]: &[Ball; 2]| to.centre - from.centre;
        if normal.length_squared() == 0.0 {
            let way = ways.iter().map(forward).sum::<DVec3>();
            normal = way.try_normalize()?.any_orthonormal_vector();
        }
        let normal = normal.try_normalize()?;
        let in_plane = ways.iter().map(|way| {
            let flat = forward(way).reject_from_normalized(normal);
            flat.normalize_or_zero() * way[1].radius.powi(2)
        });
        let up = in_plane.sum::<DVec3>();
        // Without radii, or of ways that are each other's opposite.
        let plainly = || ways.iter().map(forward).sum::<DVec3>();
        let up = up
            .try_normalize()
            .or_else(|| plainly().reject_from_normalized(normal).try_normalize())
            .unwrap_or_else(|| normal.any_orthonormal_vector());
        Some(Self { origin, normal, up })
    }

    /// The same with the normal on the side that daughters choose: the thickest (then of the most tips, then the longest) is at a larger angle in the plane
    /// than the last.
    pub(super) fn turned(self, daughters: &[Daughter]) -> Self {
        let order = |a: &&Daughter, b: &&Daughter| {
            let alike = (a.radius - b.radius).abs() <= ALIKE * a.radius.max(b.radius);
            let by_radius = match alike {
                true => std::cmp::Ordering::Equal,
                false => a.radius.total_cmp(&b.radius),
            };
            by_radius
                .then(a.tips.cmp(&b.tips))
                .then(a.length.total_cmp(&b.length))
                .then(a.vector.x.total_cmp(&b.vector.x))
                .then(a.vector.y.total_cmp(&b.vector.y))
                .then(a.vector.z.total_cmp(&b.vector.z))
        };
        // Not `max_by`: what is alike within a tolerance is not in any order as a whole.
        let pick = |wanted: std::cmp::Ordering| {
            daughters
                .iter()
                .reduce(|best, one| match order(&one, &best) {
                    found if found == wanted => one,
                    _ => best,
                })
        };
        let ends = pick(std::cmp::Ordering::Greater).zip(pick(std::cmp::Ordering::Less));
        let turn = ends.map_or(0.0, |(most, least)| {
            most.vector.cross(least.vector).dot(self.normal)
        });
        match turn < 0.0 {
            true => Self {
                normal: -self.normal,
                ..self
            },
            false => self,
        }
    }

    /// The angles of a vector; none of one that has no direction.
    pub fn direction(&self, vector: DVec3) -> Option<Direction> {
        let vector = vector.try_normalize()?;
        let flat = vector.reject_from_normalized(self.normal);
        let across = flat.cross(self.up);
        let turned = across.length().atan2(flat.dot(self.up));
        let is_left = across.dot(self.normal) >= 0.0;
        Some(Direction {
            in_plane: if is_left { turned } else { -turned },
            out_of_plane: vector.dot(self.normal).atan2(flat.length()),
        })
    }
}

/// How far two directions are apart in the plane, 0 to π.
pub(super) fn apart((one, other): (Direction, Direction)) -> f64 {
    let apart = (one.in_plane - other.in_plane).abs();
    apart.min(std::f64::consts::TAU - apart)
}

/// Radii that differ by less than this part are alike.
const ALIKE: f64 = 1e-6;

/// The middle of balls, by the square of their radii.
pub(super) fn middle(balls: &[Ball]) -> DVec3 {
    let weight = |ball: &Ball| ball.radius * ball.radius;
    let total: f64 = balls.iter().map(weight).sum();
    let count = balls.len().max(1) as f64;
    let weighted = balls.iter().map(|ball| match total > 0.0 {
        true => ball.centre * (weight(ball) / total),
        false => ball.centre / count,
    });
    weighted.sum()
}

/// The normal of the polygon between two ways, of length 1 or zero: of its corners, by how they are seen from the origin.
fn normal_of(one: [Ball; 2], other: [Ball; 2], origin: DVec3) -> DVec3 {
    let mut corners = vec![
        one[0].centre,
        one[1].centre,
        other[1].centre,
        other[0].centre,
    ];
    if one[0].centre.distance(other[0].centre) <= 1e-9 * one[0].centre.distance(one[1].centre) {
        corners.pop();
    }
    let count = corners.len();
    let cotangent = |a: DVec3, b: DVec3| a.dot(b) / a.cross(b).length();
    let mut sum = DVec3::ZERO;
    let mut plain = DVec3::ZERO;
    for at in 0..count {
        let [before, corner, after] =
            [at + count - 1, at, at + 1].map(|place| corners[place % count]);
        let [back, on, out] = [before - corner, after - corner, origin - corner];
        let normal = on.cross(back).normalize_or_zero();
        let weight = (cotangent(back, out) + cotangent(out, on)) / out.length_squared();
        if weight.is_finite() {
            sum += normal * weight;
        }
        plain += (corner - origin).cross(after - origin);
    }
    sum.try_normalize()
        .or_else(|| plain.try_normalize())
        .unwrap_or_default()
}
