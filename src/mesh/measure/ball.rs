//! The largest ball inside a solid that touches its surface at a place.
//!
//! Shrinking balls (Ma, Bae and Choi 2012, "3D medial axis point approximation using nearest neighbors and the normal field"): a ball
//! that touches the place and is too large is shrunk until it touches the nearest of what is in it, and again, until nothing is. A scan's surface is
//! rough, and what is nearest may be a bump next to the place, which would shrink the ball to nothing; so what is seen from the ball's centre within
//! 30° of the place does not count (as in Peters and Ledoux 2016). (Letting it shrink the ball by a third, and no more, was tried: on the stairs
//! of voxels that is a third too much.) Where the surface bends more sharply than the ball anywhere else, as at the ends of an ellipsoid, the ball
//! is an eighth too large for it.
//!
//! *Tried*: gathering the triangles in the ball once steps are small, and searching those; that is as dear as the last searches are. Going through the
//! hierarchy once, with a ball that shrinks on the way: what is met first is not what is nearest, and bumps that end the
//! shrinking then let it go on (an ash's tubes fell into pieces).

use glam::{DVec3, Vec3};

use super::thickness::inside;
use crate::mesh::pick::Picker;
use crate::mesh::surface::Surface;

/// Cosine of the angle within which what touches is the place itself.
const SAME_PLACE: f32 = 0.866;

/// Where a triangle leans more from a vertex's normal than by this cosine, 20 degrees, the vertex is on an edge of the solid.
const FLAT: f64 = 0.94;

/// So many triangles at such an edge are looked at.
const BESIDE: usize = 3;

/// Steps at most; a dozen are common.
const STEPS: usize = 40;

/// A ball inside a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its centre.
    pub centre: Vec3,
    /// Its radius.
    pub radius: f32,
}

/// The largest ball inside that touches the surface at a point, of which `normal` is that of the triangles. None where nothing is
/// opposite.
pub fn inscribed(picker: &Picker, point: Vec3, normal: Vec3) -> Option<Ball> {
    let inwards = picker.inwards(normal).try_normalize()?;
    let mut radius = inside(picker, point, inwards)? / 2.0;
    for _ in 0..STEPS {
        let centre = point + radius * inwards;
        let Some(near) = picker.nearest(centre, radius * 0.999) else {
            break;
        };
        let seen = (near.point - centre).normalize_or_zero();
        if seen.dot(-inwards) > SAME_PLACE {
            break;
        }
        // The ball through both with its centre on the normal.
        let to = near.point - point;
        let smaller = to.length_squared() / (2.0 * inwards.dot(to));
        if !(smaller > 0.0 && smaller < radius) {
            break;
        }
        radius = smaller;
    }
    let ball = Ball {
        centre: point + radius * inwards,
        radius,
    };
    (radius > 0.0 && ball.centre.is_finite()).then_some(ball)
}

/// The largest ball inside at a vertex, of which `normal` is that of the triangles. On an edge of the solid, as where few triangles go round a tube, no
/// ball touches the vertex: there it is the largest of those at the middles of its largest triangles.
pub(crate) fn inscribed_at(surface: &Surface, vertex: u32, normal: DVec3) -> Option<Ball> {
    let place = surface.position(vertex);
    let normal = normal.try_normalize()?;
    let mut is_edge = false;
    let mut of_triangles: Vec<(f64, DVec3, DVec3)> = Vec::new();
    for pair in surface.graph().neighbours(vertex).chunks_exact(2) {
        let [one, other] = [pair[0], pair[1]].map(|vertex| surface.position(vertex));
        let cross = (one - place).cross(other - place);
        let Some(across) = cross.try_normalize() else {
            continue;
        };
        is_edge |= across.dot(normal) < FLAT;
        of_triangles.push((cross.length(), (place + one + other) / 3.0, across));
    }
    let ball = |place: DVec3, normal: DVec3| {
        inscribed(surface.picker(), place.as_vec3(), normal.as_vec3())
    };
    let own = ball(place, normal);
    if !is_edge {
        return own;
    }
    of_triangles.sort_by(|a, b| b.0.total_cmp(&a.0));
    let beside = of_triangles
        .into_iter()
        .take(BESIDE)
        .filter_map(|(_, middle, across)| ball(middle, across));
    let larger = |one: Ball, other: Ball| {
        if other.radius > one.radius {
            other
        } else {
            one
        }
    };
    own.into_iter().chain(beside).reduce(larger)
}
