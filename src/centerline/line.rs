//! A way of balls becomes a line in the middle of its tube.
//!
//! Twice: points are spread along the way, each is fitted by a [tube](super::tube), and where there is no tube, as in forks and on flat
//! parts, moved to the [largest ball](super::ball) across the way. The second time they stand closer, and start from the first.

use glam::DVec3;

use super::ball;
use super::skin::Ball;
use super::solids::Solids;
use super::tube::{Tube, Wall, fit, fit_again};

/// A point of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) point: DVec3,
    pub(super) radius: f64,
    /// How far it may be from the axis, in radii; infinite where that is not known.
    pub(super) spread: f64,
    /// The tube that the wall there is.
    pub(super) tube: Option<Tube>,
    /// The solid that it is in.
    pub(super) part: u32,
}

impl Sample {
    /// A point without a wall of its own.
    pub(super) fn free(
        Ball {
            centre,
            radius,
            part,
        }: Ball,
    ) -> Self {
        Self {
            point: centre,
            radius,
            spread: f64::INFINITY,
            tube: None,
            part,
        }
    }
}

/// Distances between points, in radii, of the two times.
const SPACING: [f64; 2] = [0.5, 0.25];
/// Half the length of a fit's window, in radii.
const WINDOW: f64 = 0.75;
/// How far off the middle of a ball may be, in radii, where there is no tube; and the best tube's.
const BALL_SPREAD: f64 = 0.07;
const TUBE_SPREAD: f64 = 0.002;
/// Part of a line's median radius that counts for how far apart points are, where it is thinner.
const THIN: f64 = 0.5;
/// Points of a line at most: so many to a ball, of which there are few where the mesh is coarse, but some on a line of few balls, and not too many in all.
const PER_BALL: usize = 2;
const FEW: usize = 64;
const MOST: usize = 1 << 12;

/// The line of a way of balls.
pub(super) fn centred(solids: &Solids<'_>, balls: &[Ball]) -> Vec<Sample> {
    let mut way = without_outliers(balls);
    let mut wall = Wall::default();
    let mut line = Vec::new();
    let most = (PER_BALL * way.len()).clamp(FEW, MOST);
    for (spacing, again) in [(SPACING[0], false), (SPACING[1], true)] {
        line = spread(&way, spacing, most)
            .into_iter()
            .map(|place| sample(solids, place, again, &mut wall))
            .collect();
        without_returns(&mut line);
        way = line
            .iter()
            .map(|sample| Ball {
                centre: sample.point,
                radius: sample.radius,
                part: sample.part,
            })
            .collect();
    }
    line
}

/// Balls that are much smaller than those around are of bumps.
fn without_outliers(balls: &[Ball]) -> Vec<Ball> {
    let kept = balls.iter().enumerate().filter(|(place, ball)| {
        let around = &balls[place.saturating_sub(2)..(place + 3).min(balls.len())];
        let mut radii: Vec<f64> = around.iter().map(|ball| ball.radius).collect();
        radii.sort_by(f64::total_cmp);
        let is_end = *place == 0 || place + 1 == balls.len();
        is_end || ball.radius > 0.6 * radii[radii.len() / 2]
    });
    kept.map(|(_, ball)| *ball).collect()
}

/// Places along a way with the tangent there, both ends too.
pub(super) fn spread(way: &[Ball], spacing: f64, most: usize) -> Vec<(Ball, DVec3)> {
    let path = Path::new(way);
    // Thin ends do not need steps that get ever smaller.
    let mut radii: Vec<f64> = way.iter().map(|ball| ball.radius).collect();
    radii.sort_by(f64::total_cmp);
    let median = radii.get(radii.len() / 2).copied().unwrap_or(0.0);
    let least = (THIN * spacing * median).max(path.length() / most as f64);
    let mut places = Vec::new();
    let mut at = 0.0;
    while at < path.length() {
        places.push(at);
        at += (spacing * path.at(at).radius).max(least);
    }
    // The last step is not a tiny one.
    if places.len() > 1
        && path.length() - places[places.len() - 1] < 0.3 * spacing * path.at(path.length()).radius
    {
        places.pop();
    }
    places.push(path.length());
    let with_tangents = places.into_iter().map(|at| {
        let ball = path.at(at);
        (ball, path.tangent(at, WINDOW * ball.radius))
    });
    with_tangents.collect()
}

/// A way by its length.
pub(super) struct Path<'a> {
    way: &'a [Ball],
    lengths: Vec<f64>,
}

impl<'a> Path<'a> {
    pub(super) fn new(way: &'a [Ball]) -> Self {
        let mut sum = 0.0;
        let steps = way.windows(2).map(|pair| {
            sum += pair[0].centre.distance(pair[1].centre);
            sum
        });
        Self {
            lengths: std::iter::once(0.0).chain(steps).collect(),
            way,
        }
    }

    pub(super) fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    pub(super) fn at(&self, length: f64) -> Ball {
        let next = self.lengths.partition_point(|one| *one <= length);
        let next = next.min(self.way.len() - 1);
        let last = next.saturating_sub(1);
        let step = self.lengths[next] - self.lengths[last];
        let part = if step > 0.0 {
            ((length - self.lengths[last]) / step).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let (from, to) = (self.way[last], self.way[next]);
        Ball {
            centre: from.centre.lerp(to.centre, part),
            radius: from.radius + part * (to.radius - from.radius),
            part: if part < 0.5 { from.part } else { to.part },
        }
    }

    pub(super) fn tangent(&self, at: f64, half: f64) -> DVec3 {
        let [from, to] =
            [(at - half).max(0.0), (at + half).min(self.length())].map(|at| self.at(at).centre);
        (to - from).normalize_or_zero()
    }
}

fn sample(
    solids: &Solids<'_>,
    (place, tangent): (Ball, DVec3),
    again: bool,
    wall: &mut Wall,
) -> Sample {
    let Ball {
        centre: point,
        radius,
        part,
    } = place;
    let skin = solids.skin(part);
    let guess = Tube::guess(point, tangent, DVec3::ZERO, radius);
    let (tube, look) = match again {
        false => (fit(skin, &guess, wall), ball::FIRST),
        true => (fit_again(skin, &guess, wall), ball::AGAIN),
    };
    if let Some(tube) = tube
        && tube.is_whole()
    {
        return Sample {
            point: tube.point,
            // The ball within a cone touches it behind its own middle.
            radius: tube.radius / (1.0 + tube.taper * tube.taper).sqrt(),
            spread: TUBE_SPREAD + 0.4 * tube.deviation,
            tube: Some(tube),
            part,
        };
    }
    let ball = ball::largest(skin, point, tangent, radius, &look).unwrap_or(Ball {
        radius: skin.distance(point),
        ..place
    });
    Sample {
        point: ball.centre,
        radius: ball.radius.max(0.5 * radius),
        spread: BALL_SPREAD,
        tube: None,
        part,
    }
}

/// Leaves out points from which the line turns back.
fn without_returns(line: &mut Vec<Sample>) {
    let mut place = 1;
    while place + 1 < line.len() {
        let [before, here, after] = [place - 1, place, place + 1].map(|at| line[at].point);
        if (here - before).dot(after - here) < 0.0 {
            line.remove(place);
            place = place.saturating_sub(1).max(1);
        } else {
            place += 1;
        }
    }
}
