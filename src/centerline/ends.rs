//! Endpoints become balls of the cover, and what cannot be reached gets a reason.

use glam::DVec3;

use super::cover::Cover;
use super::skin::{Ball, Skin};
use super::{CenterlineError, Unreached};
use crate::mesh::endpoints::Endpoint;
use crate::mesh::pick::Winding;
use crate::mesh::report::NONE;

/// An endpoint farther outside than so many radii of the ball there is off the surface.
const OFF: f64 = 0.5;
/// A target whose ball is nearer to the source's than this part of its radius is the source.
const SAME: f64 = 0.05;

/// The ball of an endpoint, added to a cover; `origin` is where its coordinates are counted from.
pub(super) fn ball_of(
    cover: &mut Cover,
    skin: &Skin<'_>,
    winding: &Winding<'_>,
    endpoint: &Endpoint,
    origin: DVec3,
) -> Result<u32, CenterlineError> {
    let point = endpoint.point - origin;
    if !point.is_finite() {
        return Err(CenterlineError::NotFinite(endpoint.name.clone()));
    }
    let (ball, face, distance) = skin.ball_near(point).ok_or(CenterlineError::NoInside)?;
    // Where the wall is rough the ball there is small, but those around are not.
    let of_face = face
        .iter()
        .map(|vertex| cover.of_vertex[*vertex as usize])
        .filter(|ball| *ball != NONE);
    let around = of_face
        .flat_map(|ball| std::iter::once(ball).chain(cover.links[ball as usize].iter().copied()));
    let radii = around.map(|ball| cover.balls[ball as usize].radius);
    let radius = radii.fold(ball.radius, f64::max);
    if distance > OFF * radius && !winding.is_inside(point) {
        return Err(CenterlineError::OffSurface {
            name: endpoint.name.clone(),
            point: endpoint.point,
            distance,
        });
    }
    if !winding.is_inside(ball.centre) {
        return Err(CenterlineError::NoInside);
    }
    let number = cover.push(ball);
    for vertex in face {
        let other = cover.of_vertex[vertex as usize];
        if other != NONE {
            cover.link(number, other);
        }
    }
    Ok(number)
}

/// Whether two balls are in one place.
pub(super) fn are_one(one: Ball, other: Ball) -> bool {
    one.centre.distance(other.centre) < SAME * one.radius.min(other.radius)
}

/// Why a target cannot be reached: the narrowest gap between its balls and the source's.
pub(super) fn unreached(
    cover: &Cover,
    sets: &[u32],
    (source, target): (u32, u32),
    index: usize,
    endpoint: &Endpoint,
    origin: DVec3,
) -> Unreached {
    let [from, to] = [source, target].map(|ball| sets[ball as usize]);
    let of_set = |set: u32| {
        let balls = sets.iter().zip(&cover.balls);
        balls
            .filter(move |(one, _)| **one == set)
            .map(|(_, ball)| *ball)
    };
    let theirs: Vec<Ball> = of_set(to).collect();
    let gap_of =
        |one: &Ball, other: &Ball| one.centre.distance(other.centre) - one.radius - other.radius;
    let mut narrowest: Option<(f64, DVec3)> = None;
    for ours in of_set(from) {
        for ball in &theirs {
            let gap = gap_of(&ours, ball);
            if narrowest.is_none_or(|(least, _)| gap < least) {
                let way = (ball.centre - ours.centre).normalize_or_zero();
                let middle =
                    (ours.centre + ours.radius * way).midpoint(ball.centre - ball.radius * way);
                narrowest = Some((gap, middle + origin));
            }
        }
    }
    let (gap, near) = narrowest.unwrap_or((f64::INFINITY, endpoint.point));
    Unreached {
        index,
        name: endpoint.name.clone(),
        point: endpoint.point,
        gap: gap.max(0.0),
        near,
    }
}
