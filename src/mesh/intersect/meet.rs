//! Whether two triangles have a point in common, exactly.
//!
//! As Guigue and Devillers (2003), by the signs of orientation tests alone and without computing a point: where all corners of one are on
//! one side of the other's plane they are apart. Else, unless they lie in one plane, an edge of one passes through the other, and
//! that is looked at edge by edge. It takes more tests than their order of corners does, for the few pairs that come so far, and has no cases.
//! Signs are Shewchuk's (crate `robust`): exact for all coordinates of single precision, so that what touches is told to touch.

use glam::Vec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// A point in a plane of two axes.
type Flat = Coord<f64>;

/// Whether two closed triangles with area have a point in common: touching counts. Coordinates are finite.
pub fn meet(one: [Vec3; 3], other: [Vec3; 3]) -> bool {
    let sides_of_one = one.map(|point| side(other, point));
    if is_beside(sides_of_one) {
        return false;
    }
    let sides_of_other = other.map(|point| side(one, point));
    if is_beside(sides_of_other) {
        return false;
    }
    if sides_of_one == [0; 3] {
        return meet_in_plane(one, other);
    }
    edges_pass(one, sides_of_one, other) || edges_pass(other, sides_of_other, one)
}

fn sign(value: f64) -> i8 {
    i8::from(value > 0.0) - i8::from(value < 0.0)
}

/// On which side of a plane a point is.
fn side([a, b, c]: [Vec3; 3], point: Vec3) -> i8 {
    let [a, b, c, d] = [a, b, c, point].map(|point| Coord3D {
        x: f64::from(point.x),
        y: f64::from(point.y),
        z: f64::from(point.z),
    });
    sign(orient3d(a, b, c, d))
}

/// All on one side and none on the plane.
fn is_beside([a, b, c]: [i8; 3]) -> bool {
    a != 0 && a == b && b == c
}

/// Whether an edge of a triangle passes through another, which is not in the same plane; `sides` is where its corners are.
fn edges_pass(triangle: [Vec3; 3], sides: [i8; 3], through: [Vec3; 3]) -> bool {
    (0..3).any(|from| {
        let to = (from + 1) % 3;
        let edge = [triangle[from], triangle[to]];
        match (sides[from], sides[to]) {
            (0, 0) => edge_meets_in_plane(edge, through),
            (one, other) => one * other <= 0 && line_passes(edge, through),
        }
    })
}

/// Whether the line through two points, which is not in the triangle's plane, passes through the triangle.
fn line_passes([from, to]: [Vec3; 2], [a, b, c]: [Vec3; 3]) -> bool {
    let turns = [[a, b], [b, c], [c, a]].map(|[start, end]| side([from, to, start], end));
    turns.iter().all(|turn| *turn >= 0) || turns.iter().all(|turn| *turn <= 0)
}

/// Two axes along which the triangle does not look like a line.
fn axes([a, b, c]: [Vec3; 3]) -> [usize; 2] {
    let views = [[0, 1], [1, 2], [2, 0]];
    views
        .into_iter()
        .find(|axes| {
            let [a, b, c] = [a, b, c].map(|point| flat(point, *axes));
            orient2d(a, b, c) != 0.0
        })
        .unwrap_or(views[0])
}

fn flat(point: Vec3, [x, y]: [usize; 2]) -> Flat {
    Coord {
        x: f64::from(point[x]),
        y: f64::from(point[y]),
    }
}

fn meet_in_plane(one: [Vec3; 3], other: [Vec3; 3]) -> bool {
    let axes = axes(one);
    let [one, other] = [one, other].map(|triangle| triangle.map(|point| flat(point, axes)));
    let edges = |[a, b, c]: [Flat; 3]| [[a, b], [b, c], [c, a]];
    edges(one)
        .iter()
        .any(|edge| edges(other).iter().any(|across| cross(*edge, *across)))
        || is_inside(one[0], other)
        || is_inside(other[0], one)
}

fn edge_meets_in_plane(edge: [Vec3; 2], triangle: [Vec3; 3]) -> bool {
    let axes = axes(triangle);
    let edge = edge.map(|point| flat(point, axes));
    let [a, b, c] = triangle.map(|point| flat(point, axes));
    is_inside(edge[0], [a, b, c])
        || [[a, b], [b, c], [c, a]]
            .iter()
            .any(|side| cross(edge, *side))
}

fn turn([from, to]: [Flat; 2], point: Flat) -> i8 {
    sign(orient2d(from, to, point))
}

fn is_inside(point: Flat, [a, b, c]: [Flat; 3]) -> bool {
    let turns = [[a, b], [b, c], [c, a]].map(|edge| turn(edge, point));
    turns.iter().all(|turn| *turn >= 0) || turns.iter().all(|turn| *turn <= 0)
}

/// Whether two closed edges have a point in common.
fn cross(one: [Flat; 2], other: [Flat; 2]) -> bool {
    let turns_of_other = other.map(|point| turn(one, point));
    let turns_of_one = one.map(|point| turn(other, point));
    if turns_of_other == [0, 0] {
        return overlap(one.map(|p| p.x), other.map(|p| p.x))
            && overlap(one.map(|p| p.y), other.map(|p| p.y));
    }
    turns_of_other[0] * turns_of_other[1] <= 0 && turns_of_one[0] * turns_of_one[1] <= 0
}

fn overlap([a, b]: [f64; 2], [c, d]: [f64; 2]) -> bool {
    a.min(b) <= c.max(d) && c.min(d) <= a.max(b)
}
