//! The shortest way along the surface between two places.
//!
//! ```text
//! places ─▶ shortest way along edges (A*) ─▶ strip of triangles ─▶ unfolded, straightened (funnel) ─▶ length
//!                                                   ▲                     │
//!                                                   └── turned around vertices where the other side is nearer
//! ```
//!
//! Within a strip of triangles that is laid flat the shortest way is found exactly. Where it bends around a vertex of the strip's edge, and the
//! angle on the other side is less than 180°, the strip is led around the other side and the way gets shorter (Xin and Wang 2007; the same end as by the
//! edge flips of Sharp and Crane 2020, without their second triangulation). When no bend is left the way is a geodesic: exact on the triangles, and
//! the shortest of its neighbourhood. It need not be the shortest of all, as around the other side of a tube; but it starts from the shortest way
//! along edges. Fast marching was not taken: it is off by the size of the triangles and fails on obtuse ones.

mod funnel;

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, Vec3};

use self::funnel::{Bend, Portal, straighten};
use crate::mesh::pick::Hit;
use crate::mesh::report::NONE;
use crate::mesh::surface::graph::way;
use crate::mesh::surface::{Surface, next, previous};

/// Rounds of straightening at most; a few dozen are needed for ways of a thousand triangles.
const ROUNDS: usize = 1000;

/// A way along a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Along {
    /// How long it is.
    pub length: f64,
    /// Where it begins, each edge that it crosses, and where it ends.
    pub points: Vec<Vec3>,
}

/// The shortest way along the surface between two places on it. `Ok(None)` where they are on parts that do not hang together.
///
/// # Errors
/// [`Cancelled`] when `cancel` was set.
pub fn along(
    surface: &Surface,
    from: &Hit,
    to: &Hit,
    cancel: &AtomicBool,
) -> Result<Option<Along>, Cancelled> {
    let (Some(first), Some(last)) = (corners(surface, from), corners(surface, to)) else {
        return Ok(None);
    };
    if from.triangle == to.triangle {
        return Ok(Some(along_points(vec![from.point, to.point])));
    }
    let from_start = first.map(|vertex| (vertex, reach(surface, vertex, from)));
    let to_goal = last.map(|vertex| (vertex, reach(surface, vertex, to)));
    let found = way(surface, surface.graph(), &from_start, &to_goal, cancel).ok_or(Cancelled)?;
    let Some(vertices) = found else {
        return Ok(None);
    };
    let Some(mut strip) = strip(surface, from.triangle, &vertices, to.triangle) else {
        // Around a vertex where more than two triangles meet at an edge there is no strip; the way along edges is told.
        let middle = vertices
            .iter()
            .map(|vertex| surface.position(*vertex).as_vec3());
        let points = std::iter::once(from.point).chain(middle);
        return Ok(Some(along_points(points.chain([to.point]).collect())));
    };
    let mut best: Option<Along> = None;
    for _ in 0..ROUNDS {
        if cancel.load(Ordering::Relaxed) {
            return Err(Cancelled);
        }
        let Some(portals) = portals(surface, &strip) else {
            break;
        };
        let straight = straighten(from.point.as_dvec3(), to.point.as_dvec3(), &portals);
        let shorter = best
            .as_ref()
            .is_none_or(|best| straight.length < best.length * (1.0 - 1e-12));
        if !shorter {
            break;
        }
        best = Some(Along {
            length: straight.length,
            points: straight
                .points
                .iter()
                .map(|point| point.as_vec3())
                .collect(),
        });
        if !turn_around(surface, &mut strip, &portals, &straight.bends) {
            break;
        }
    }
    Ok(best)
}

/// Somebody asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("measuring along the surface was cancelled")]
pub struct Cancelled;

fn corners(surface: &Surface, place: &Hit) -> Option<[u32; 3]> {
    let face = *surface.faces().get(place.triangle as usize)?;
    (face[0] != NONE).then_some(face)
}

fn reach(surface: &Surface, vertex: u32, place: &Hit) -> f64 {
    surface.position(vertex).distance(place.point.as_dvec3())
}

fn along_points(points: Vec<Vec3>) -> Along {
    let length = points
        .windows(2)
        .map(|pair| super::distance(pair[0], pair[1]));
    Along {
        length: length.sum(),
        points,
    }
}

/// Half-edges by which a strip leaves its triangles, from one triangle along vertices to another.
fn strip(surface: &Surface, first: u32, vertices: &[u32], last: u32) -> Option<Vec<u32>> {
    let (mut strip, mut triangle) = (Vec::new(), first);
    for (place, vertex) in vertices.iter().enumerate() {
        // Until there is a triangle that also has the next vertex, or until the last triangle.
        let is_there = |at: u32| match vertices.get(place + 1) {
            Some(next) => surface.faces()[at as usize].contains(next),
            None => at == last,
        };
        let [one, other] =
            [false, true].map(|right| around(surface, triangle, *vertex, right, &is_there));
        let shorter = match (one, other) {
            (Some(one), Some(other)) if other.len() < one.len() => other,
            (Some(one), _) => one,
            (None, other) => other?,
        };
        triangle = shorter.last().map_or(Some(triangle), |exit| {
            surface.twin(*exit).map(|twin| twin / 3)
        })?;
        strip.extend(shorter);
    }
    without_returns(surface, first, strip).filter(|_| triangle == last)
}

/// Half-edges by which one goes around a vertex from a triangle to one that is looked for; None where an edge ends the surface before, or
/// all triangles were seen.
fn around(
    surface: &Surface,
    from: u32,
    vertex: u32,
    right: bool,
    is_there: &impl Fn(u32) -> bool,
) -> Option<Vec<u32>> {
    let mut exits = Vec::new();
    let (mut triangle, mut entry) = (from, None);
    while !is_there(triangle) {
        let mut edges = edges_at(surface, triangle, vertex)?;
        if right {
            edges.reverse();
        }
        // The edge by which it was not entered; neighbours may be turned against each other.
        let exit = edges.into_iter().find(|edge| Some(*edge) != entry)?;
        let twin = surface.twin(exit)?;
        exits.push(exit);
        (triangle, entry) = (twin / 3, Some(twin));
        if triangle == from {
            return None;
        }
    }
    Some(exits)
}

/// The two half-edges of a triangle at a vertex: the one that leaves it, and the one that comes to it.
fn edges_at(surface: &Surface, triangle: u32, vertex: u32) -> Option<[u32; 2]> {
    let face = surface.faces().get(triangle as usize)?;
    let corner = face.iter().position(|other| *other == vertex)?;
    let leaving = 3 * triangle + u32::try_from(corner).ok()?;
    Some([leaving, previous(leaving)])
}

/// Takes out where a strip goes through an edge and straight back.
fn without_returns(surface: &Surface, first: u32, exits: Vec<u32>) -> Option<Vec<u32>> {
    let mut kept: Vec<u32> = Vec::with_capacity(exits.len());
    for exit in exits {
        match kept.last().and_then(|last| surface.twin(*last)) {
            Some(back) if back == exit => {
                kept.pop();
            }
            _ => kept.push(exit),
        }
    }
    let begins = kept.first().is_none_or(|exit| exit / 3 == first);
    begins.then_some(kept)
}

/// Edges that a strip crosses, each with what the next triangle adds.
fn portals(surface: &Surface, strip: &[u32]) -> Option<Vec<Portal>> {
    let mut portals: Vec<Portal> = Vec::with_capacity(strip.len());
    for exit in strip {
        let [from, to] = surface.ends(*exit)?;
        // Leaving a triangle across one of its edges, what comes first on the edge is to the right. Where neighbours are turned against
        // each other the sides go on from the portal before.
        let (mut left, mut right) = (to, from);
        if let Some(before) = portals.last()
            && (before.left == from || before.right == to)
        {
            (left, right) = (from, to);
        }
        let apex = surface.ends(next(surface.twin(*exit)?))?;
        let apex = if apex[1] == from || apex[1] == to {
            apex[0]
        } else {
            apex[1]
        };
        portals.push(Portal {
            left,
            right,
            at: [left, right].map(|vertex| surface.position(vertex)),
            apex: surface.position(apex),
        });
    }
    Some(portals)
}

/// Leads a strip around the other side of vertices where its way bends and that side is nearer. False where there is none.
fn turn_around(
    surface: &Surface,
    strip: &mut Vec<u32>,
    portals: &[Portal],
    bends: &[Bend],
) -> bool {
    let mut turned = false;
    let mut free = strip.len();
    for bend in bends.iter().rev() {
        let vertex = bend.vertex(portals);
        let has = |portal: &Portal| portal.left == vertex || portal.right == vertex;
        let before = portals[..bend.portal]
            .iter()
            .rev()
            .take_while(|one| has(one))
            .count();
        let behind = portals[bend.portal..]
            .iter()
            .take_while(|one| has(one))
            .count();
        let run = bend.portal - before..bend.portal + behind;
        // Runs that touch are turned one after the other, in the next rounds.
        if run.end > free || !is_nearer_around(surface, strip[run.start], vertex, bend.angle) {
            continue;
        }
        let (first, exit) = (strip[run.start] / 3, strip[run.start]);
        let Some(goal) = surface.twin(strip[run.end - 1]).map(|twin| twin / 3) else {
            continue;
        };
        let right = edges_at(surface, first, vertex).is_some_and(|[leaving, _]| leaving == exit);
        if let Some(other) = around(surface, first, vertex, right, &|at| at == goal) {
            free = run.start;
            strip.splice(run, other);
            turned = true;
        }
    }
    if turned {
        let first = strip.first().map_or(NONE, |exit| exit / 3);
        let kept = without_returns(surface, first, std::mem::take(strip));
        *strip = kept.unwrap_or_default();
    }
    turned && !strip.is_empty()
}

/// Whether the angle on the other side of a vertex is less than 180°, where the way bends so that its two parts are at `angle`.
fn is_nearer_around(surface: &Surface, exit: u32, vertex: u32, angle: f64) -> bool {
    use std::f64::consts::{PI, TAU};
    let first = exit / 3;
    let (mut triangle, mut entry, mut sum) = (first, None, 0.0);
    loop {
        let Some([leaving, coming]) = edges_at(surface, triangle, vertex) else {
            return false;
        };
        let Some([one, other]) = surface.ends(next(leaving)) else {
            return false;
        };
        let at = surface.position(vertex);
        sum += (surface.position(one) - at).angle_between(surface.position(other) - at);
        let exit = if entry == Some(leaving) {
            coming
        } else {
            leaving
        };
        let Some(twin) = surface.twin(exit) else {
            return false;
        };
        (triangle, entry) = (twin / 3, Some(twin));
        if triangle == first {
            // The way's own side has the rest of a full turn in the strip laid flat.
            return sum - (TAU - angle) < PI - 1e-9;
        }
        if sum > 1e3 {
            return false;
        }
    }
}

/// A point on an edge.
fn on_edge([from, to]: [DVec3; 2], part: f64) -> DVec3 {
    from.lerp(to, part)
}
