//! Endpoints become balls of the cover, and what cannot be reached gets a reason.

use std::collections::BTreeMap;

use glam::DVec3;

use super::cover::Cover;
use super::skin::Ball;
use super::solids::Solids;
use super::{CenterlineError, Unreached, Why};
use crate::mesh::endpoints::{Endpoint, Kind};

/// An endpoint farther outside than so many radii of the ball there is off the surface.
const OFF: f64 = 0.5;
/// An endpoint farther inside than this part of its tube's radius is not on the outer wall. (The middle of an uneven opening is not on it either.)
const BURIED: f64 = 0.5;
/// A triangle whose vertices are all farther from a ball's place than so many of its radii is as large as the ball.
const COARSE: f64 = 0.5;
/// A target whose ball is nearer to the source's than this part of its radius is the source.
const SAME: f64 = 0.05;

/// The ball of an endpoint, added to a cover; `origin` is where its coordinates are counted from. None where there is no inside.
pub(super) fn ball_of(
    cover: &mut Cover,
    solids: &Solids<'_>,
    endpoint: &Endpoint,
    origin: DVec3,
) -> Result<Option<u32>, CenterlineError> {
    let point = endpoint.point - origin;
    if !point.is_finite() {
        return Err(CenterlineError::NotFinite(endpoint.name.clone()));
    }
    let Some(part) = solids.nearest(point) else {
        return Ok(None);
    };
    let Some((ball, face, distance)) = solids.skin(part).ball_near(point) else {
        return Ok(None);
    };
    // Where the wall is rough the ball there is small, but those around are not.
    let of_face: Vec<u32> = face
        .iter()
        .filter_map(|vertex| cover.ball_of(part, *vertex))
        .collect();
    let around = of_face
        .iter()
        .flat_map(|ball| std::iter::once(ball).chain(&cover.links[*ball as usize]));
    let radii = around.map(|ball| cover.balls[*ball as usize].radius);
    if ball.is_none() && of_face.is_empty() {
        return Ok(None);
    }
    let own = ball.map_or(0.0, |ball| ball.radius);
    let radius = radii.fold(own, f64::max);
    if distance > OFF * radius && !solids.is_inside(point) {
        return Err(CenterlineError::OffSurface {
            name: endpoint.name.clone(),
            point: endpoint.point,
            distance,
        });
    }
    let own = ball.filter(|ball| solids.is_in(part, ball.centre));
    let place = |ball: &u32| cover.balls[*ball as usize];
    let nearest = of_face.iter().map(place).min_by(|a, b| {
        a.centre
            .distance(point)
            .total_cmp(&b.centre.distance(point))
    });
    let Some(ball) = own.or(nearest) else {
        return Ok(None);
    };
    // Of a triangle that is as large as the ball, as flat caps have them, the vertices are at the rim, and balls there in its corner. What is
    // inside the ball hangs together with it, too.
    let skin = solids.skin(part);
    let is_coarse = face
        .iter()
        .all(|vertex| skin.surface.position(*vertex).distance(point) > COARSE * ball.radius);
    let within: Vec<u32> = (0_u32..)
        .zip(&cover.balls)
        .filter(|(_, other)| is_coarse && other.centre.distance(ball.centre) < ball.radius)
        .map(|(other, _)| other)
        .collect();
    let number = cover.push(ball);
    for other in within.into_iter().chain(of_face) {
        cover.link(number, other);
    }
    Ok(Some(number))
}

/// Leaves out endpoints that are inside, away from the outer wall: where a part begins within another. The first that is left is the source.
pub(super) fn leave_out_buried(
    solids: &Solids<'_>,
    endpoints: &mut Vec<Endpoint>,
    origin: DVec3,
) -> Result<(), CenterlineError> {
    endpoints.retain(|endpoint| {
        let point = endpoint.point - origin;
        let radius = endpoint.snapped.map_or(0.0, |snapped| snapped.radius);
        solids.depth(point, solids.nearest(point)) <= BURIED * radius
    });
    for (place, endpoint) in endpoints.iter_mut().enumerate() {
        endpoint.kind = if place == 0 {
            Kind::Source
        } else {
            Kind::Target
        };
    }
    match endpoints.len() {
        0 => Err(CenterlineError::NoSource),
        1 => Err(CenterlineError::NoTarget),
        _ => Ok(()),
    }
}

/// Refuses targets that are where the source is.
pub(super) fn apart(
    cover: &Cover,
    start: u32,
    targets: &[Endpoint],
    balls: &[Option<u32>],
) -> Result<(), CenterlineError> {
    let source = cover.balls[start as usize];
    let is_there = |ball: u32| {
        let ball = cover.balls[ball as usize];
        source.centre.distance(ball.centre) < SAME * source.radius.min(ball.radius)
    };
    let mut there = targets.iter().zip(balls);
    match there.find(|(_, ball)| ball.is_some_and(is_there)) {
        Some((target, _)) => Err(CenterlineError::SourceIsTarget(target.name.clone())),
        None => Ok(()),
    }
}

/// Lets the first endpoint of those of which most hang together be the source, which stands first.
pub(super) fn choose_source(cover: &Cover, endpoints: &mut [Endpoint], balls: &mut [Option<u32>]) {
    let sets = cover.sets();
    let set = |ball: &Option<u32>| ball.map(|ball| sets[ball as usize]);
    let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
    balls
        .iter()
        .filter_map(set)
        .for_each(|set| *counts.entry(set).or_default() += 1);
    let count = |ball: &Option<u32>| set(ball).map_or(0, |set| counts[&set]);
    let most = counts.values().copied().max().unwrap_or(0);
    let Some(first) = balls.iter().position(|ball| count(ball) == most) else {
        return;
    };
    if count(&balls[0]) < most {
        balls.swap(0, first);
        endpoints.swap(0, first);
        endpoints[0].kind = Kind::Source;
        endpoints[first].kind = Kind::Target;
    }
}

/// Targets that have no end, with the reason.
pub(super) fn unreached(
    cover: &Cover,
    start: u32,
    targets: &[Endpoint],
    balls: &[Option<u32>],
    ends: &[Option<u32>],
    origin: DVec3,
) -> Vec<Unreached> {
    if ends.iter().all(Option::is_some) {
        return Vec::new();
    }
    let sets = cover.sets();
    let mut gaps: BTreeMap<u32, Why> = BTreeMap::new();
    let lost = ends.iter().enumerate().filter(|(_, end)| end.is_none());
    lost.map(|(index, _)| Unreached {
        index,
        name: targets[index].name.clone(),
        point: targets[index].point,
        why: match balls[index] {
            Some(ball) => *gaps
                .entry(sets[ball as usize])
                .or_insert_with(|| gap(cover, &sets, (start, ball), origin)),
            None => Why::NoInside,
        },
    })
    .collect()
}

/// The narrowest gap between the balls that hang together with one and those that do with another.
fn gap(cover: &Cover, sets: &[u32], (source, target): (u32, u32), origin: DVec3) -> Why {
    let [from, to] = [source, target].map(|ball| sets[ball as usize]);
    let of_set = |set: u32| {
        let balls = sets.iter().zip(&cover.balls);
        balls
            .filter(move |(one, _)| **one == set)
            .map(|(_, ball)| *ball)
    };
    let theirs: Vec<Ball> = of_set(to).collect();
    let mut narrowest = (f64::INFINITY, DVec3::ZERO);
    for ours in of_set(from) {
        for ball in &theirs {
            let gap = ours.centre.distance(ball.centre) - ours.radius - ball.radius;
            if gap < narrowest.0 {
                let way = (ball.centre - ours.centre).normalize_or_zero();
                let [here, there] = [
                    ours.centre + ours.radius * way,
                    ball.centre - ball.radius * way,
                ];
                narrowest = (gap, here.midpoint(there));
            }
        }
    }
    Why::Gap {
        gap: narrowest.0.max(0.0),
        near: narrowest.1 + origin,
    }
}
