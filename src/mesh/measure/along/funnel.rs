//! The shortest way through a strip of triangles, laid flat.
//!
//! Triangles are laid into the plane one after the other, each on the edge that it shares with the one before. The way is then pulled straight
//! by a funnel: what can be seen from its tip through all edges so far, which narrows from edge to edge, and moves its tip to a corner when the next edge
//! is out of sight (Lee and Preparata 1984; Chazelle 1982).

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

/// An edge that the way crosses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portal {
    /// Its ends, as seen along the way.
    pub(super) left: u32,
    pub(super) right: u32,
    /// Where they are.
    pub(super) at: [DVec3; 2],
    /// The third corner of the triangle behind it.
    pub(super) apex: DVec3,
}

/// Where a way bends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bend {
    /// At an end of this portal.
    pub(super) portal: usize,
    pub(super) left: bool,
    /// Between the way back and the way on, in radians.
    pub(super) angle: f64,
}

impl Bend {
    pub(super) fn vertex(&self, portals: &[Portal]) -> u32 {
        let portal = &portals[self.portal];
        if self.left { portal.left } else { portal.right }
    }
}

/// A way through a strip.
pub(super) struct Straight {
    pub(super) length: f64,
    pub(super) bends: Vec<Bend>,
    /// Where it begins, crosses each portal, and ends.
    pub(super) points: Vec<DVec3>,
}

/// The strip in the plane: where the way begins, the ends of its edges (left, right), where it ends.
struct Flat {
    start: DVec2,
    portals: Vec<[DVec2; 2]>,
    goal: DVec2,
}

/// Where a point goes that is at given distances from two points of the plane, on the side ahead: with the first to the left and the second to
/// the right.
fn placed([left, right]: [DVec2; 2], to_left: f64, to_right: f64) -> DVec2 {
    let across = right - left;
    let width = across.length();
    if width == 0.0 {
        return left + DVec2::new(0.0, to_left);
    }
    let along = across / width;
    let x = (to_left * to_left - to_right * to_right + width * width) / (2.0 * width);
    let y = (to_left * to_left - x * x).max(0.0).sqrt();
    left + x * along + y * along.perp()
}

fn laid(start: DVec3, goal: DVec3, portals: &[Portal]) -> Flat {
    let mut flat = Flat {
        start: DVec2::ZERO,
        portals: Vec::with_capacity(portals.len()),
        goal: DVec2::ZERO,
    };
    let Some(first) = portals.first() else {
        flat.goal = DVec2::new(0.0, start.distance(goal));
        return flat;
    };
    // The first edge lies across from left to right, and the start is behind it.
    let [left, right] = first.at;
    let mut edge = [DVec2::ZERO, DVec2::new(left.distance(right), 0.0)];
    let behind = placed(edge, left.distance(start), right.distance(start));
    flat.start = behind * DVec2::new(1.0, -1.0);
    flat.portals.push(edge);
    for pair in portals.windows(2) {
        let ([left, right], apex) = (pair[0].at, pair[0].apex);
        let ahead = placed(edge, left.distance(apex), right.distance(apex));
        // The next edge keeps one end.
        edge = match pair[0].left == pair[1].left {
            true => [edge[0], ahead],
            false => [ahead, edge[1]],
        };
        flat.portals.push(edge);
    }
    if let Some(last) = portals.last() {
        let [left, right] = last.at;
        flat.goal = placed(edge, left.distance(goal), right.distance(goal));
    }
    flat
}

/// Positive where `b` is to the left of the way from `from` over `a`.
fn turn(from: DVec2, a: DVec2, b: DVec2) -> f64 {
    (a - from).perp_dot(b - from)
}

/// Corners of the shortest way: portal and side.
fn corners(flat: &Flat) -> Vec<(usize, bool)> {
    let count = flat.portals.len();
    let edge = |at: usize| flat.portals.get(at).copied().unwrap_or([flat.goal; 2]);
    let mut found = Vec::new();
    let mut tip = flat.start;
    let [mut left, mut right] = [tip; 2];
    let [mut left_at, mut right_at] = [0; 2];
    let mut at = 0;
    // Each corner is behind the one before, so it ends; at a corner it goes back to the edge behind that corner.
    while at <= count {
        let [next_left, next_right] = edge(at);
        let bend = 'bend: {
            if turn(tip, right, next_right) >= 0.0 {
                if tip != left && turn(tip, left, next_right) > 0.0 {
                    break 'bend Some((left_at, true, left));
                }
                (right, right_at) = (next_right, at);
            }
            if turn(tip, left, next_left) <= 0.0 {
                if tip != right && turn(tip, right, next_left) < 0.0 {
                    break 'bend Some((right_at, false, right));
                }
                (left, left_at) = (next_left, at);
            }
            None
        };
        match bend {
            Some((portal, is_left, corner)) => {
                found.push((portal, is_left));
                (tip, left, right) = (corner, corner, corner);
                (left_at, right_at, at) = (portal, portal, portal + 1);
            }
            None => at += 1,
        }
    }
    found
}

/// Where a stretch of the way crosses an edge, as a part of it.
fn crossing([from, to]: [DVec2; 2], [left, right]: [DVec2; 2]) -> f64 {
    let edge = right - left;
    let (over, other) = (turn(from, to, left), turn(from, to, right));
    // A stretch without length, at a corner, or along the edge: then `to` is on the edge.
    let sure = 1e-12 * edge.length_squared().max(from.distance_squared(to));
    let part = match (over - other).abs() > sure {
        true => over / (over - other),
        false => (to - left).dot(edge) / edge.length_squared(),
    };
    if part.is_nan() {
        0.0
    } else {
        part.clamp(0.0, 1.0)
    }
}

/// Pulls the way through a strip straight.
pub(super) fn straighten(start: DVec3, goal: DVec3, portals: &[Portal]) -> Straight {
    let flat = laid(start, goal, portals);
    let corners = corners(&flat);
    let place = |(portal, left): (usize, bool)| flat.portals[portal][usize::from(!left)];
    let mut stops = vec![(0, flat.start)];
    stops.extend(corners.iter().map(|corner| (corner.0, place(*corner))));
    stops.push((portals.len(), flat.goal));
    let length = stops.windows(2).map(|pair| pair[0].1.distance(pair[1].1));
    let bends = corners.iter().zip(stops.windows(3)).map(|(corner, stops)| {
        let (back, on) = (stops[0].1 - stops[1].1, stops[2].1 - stops[1].1);
        Bend {
            portal: corner.0,
            left: corner.1,
            angle: back.angle_to(on).abs().min(PI),
        }
    });
    let mut points = vec![start];
    let mut part = stops.windows(2).peekable();
    for (number, portal) in portals.iter().enumerate() {
        while let Some(pair) = part.peek()
            && pair[1].0 < number
        {
            part.next();
        }
        let Some([(_, from), (_, to)]) = part.peek().map(|pair| [pair[0], pair[1]]) else {
            break;
        };
        points.push(super::on_edge(
            portal.at,
            crossing([from, to], flat.portals[number]),
        ));
    }
    points.push(goal);
    Straight {
        length: length.sum(),
        bends: bends.collect(),
        points,
    }
}
