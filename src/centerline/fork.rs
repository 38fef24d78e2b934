//! Where tubes meet: forks are where their axes would meet, and not where balls grow.
//!
//! Inside a fork the largest balls leave the tubes' axes: they move out to where there is most room. So tubes are
//! [followed](super::tube::follow) into the fork as far as there is wall, what balls say counts the less the nearer it is, and
//! each line goes on as [smoothly](super::spline) as it came. The fork is the point that is nearest to all of them by least squares, and the
//! lines are led there. Forks that come out nearer to each other than their radius are one, of more branches.

use glam::{DMat3, DVec3};

use super::line::Sample;
use super::skin::Ball;
use super::solids::Solids;
use super::spline::{Knot, Smooth, smooth};
use super::tube::{Tube, Wall};

/// A line between two forks or from a fork to an end.
#[derive(Clone, Debug)]
pub(super) struct Line {
    /// Forks, by number, where it begins and ends; the source and ends are some, too.
    pub(super) from: u32,
    pub(super) to: u32,
    pub(super) samples: Vec<Sample>,
}

/// Where lines meet, or one ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fork {
    pub(super) ball: Ball,
    /// Lines that meet here.
    pub(super) lines: usize,
}

/// How far off the axis balls may be for what they are larger than the tube: where the fork is looked for, and where lines are led to it.
const GROWN: f64 = 0.5;
const GROWN_LED: f64 = 0.5;
/// How lines bend where the fork is looked for (as evenly as they came: it is outside of what is known), and where they are led to it.
const FREE_JERK: f64 = 0.04;
const LED_JERK: f64 = 0.3;
/// How far, in radii of its ball, a fork reaches at most.
const REACH: f64 = 3.0;
/// A ball smaller than this part of the next is not in the middle of the tube that begins there.
const ASIDE: f64 = 0.8;
/// Points nearer than so many radii to a sibling's line are not a line's own.
const OWN: f64 = 0.5;
/// Lines that have so many points in common run in one tube.
const ONE_TUBE: usize = 6;
/// Points of a sibling that are looked at.
const NEAR: usize = 80;
/// Nearer than so many radii, two forks are one.
const ONE: f64 = 0.6;
/// Steps of following at most.
const FOLLOWED_MOST: usize = 40;
/// A tube that is followed does not get so much wider or narrower.
const WIDER: f64 = 0.05;
/// An end's ball on the axis of the tube before it that is smaller than this part of the one on the line is aside.
const ASIDE_END: f64 = 0.9;
/// Distance between balls that are compared at an end, in radii.
const END_STEP: f64 = 0.1;
/// So far beyond the ball at the tip they are compared, in radii.
const BEYOND: f64 = 0.1;
/// Between two of them, it is looked at so many more where the last ball is.
const CLOSER: u32 = 8;
const CLOSER_ROUNDS: usize = 4;
/// How near a tube must be to an end for its axis to lead there, in radii, or which of the last points it must be.
const END_NEAR: f64 = 2.5;
const END_LAST: usize = 3;
/// Places of a line that are looked at for its end at most.
const COURSE_MOST: usize = 4096;
/// Distance between points, in radii.
const SPACING: f64 = 0.25;
/// How far off the first guess of a fork is, in radii.
const PRIOR: f64 = 2.0;
/// Samples of a line of which it is looked at how far triangles sag.
const SAGS: usize = 32;
/// Rounds in which forks and lines are fitted to each other.
const ROUNDS: usize = 5;

/// Lines with the forks that they meet in.
#[derive(Clone, Debug, Default)]
pub(super) struct Network {
    pub(super) forks: Vec<Fork>,
    pub(super) lines: Vec<Line>,
}

impl Network {
    /// How many points of each line, from where it begins, are a sibling's as well.
    fn shared(&self) -> Vec<usize> {
        let mut of_fork: Vec<Vec<usize>> = vec![Vec::new(); self.forks.len()];
        for (number, line) in self.lines.iter().enumerate() {
            of_fork[line.from as usize].push(number);
        }
        let shared = |(number, line): (usize, &Line)| {
            let siblings = of_fork[line.from as usize].iter();
            let siblings: Vec<usize> = siblings.copied().filter(|other| *other != number).collect();
            let mut shared = 0;
            for (place, sample) in line.samples.iter().enumerate() {
                let is_near = siblings.iter().any(|sibling| {
                    let near = self.lines[*sibling].samples.iter().take(NEAR);
                    near.map(|other| other.point.distance(sample.point))
                        .fold(f64::INFINITY, f64::min)
                        < OWN * sample.radius
                });
                if is_near {
                    shared = place + 1;
                } else if place > shared + 8 {
                    break;
                }
            }
            shared
        };
        self.lines.iter().enumerate().map(shared).collect()
    }

    /// Moves forks of two lines that run on as one tube to where they part, and leaves out points that are a sibling's as well.
    fn keep_own(&mut self) {
        let shared = self.shared();
        for fork in 0..self.forks.len() {
            // One line comes and two go.
            if self.forks[fork].lines != 3 {
                continue;
            }
            let of = |is_so: &dyn Fn(&Line) -> bool| {
                let lines = self
                    .lines
                    .iter()
                    .enumerate()
                    .filter(|(_, line)| is_so(line));
                lines.map(|(number, _)| number).collect::<Vec<usize>>()
            };
            let leaving = of(&|line| line.from as usize == fork);
            let arriving = of(&|line| line.to as usize == fork);
            let ([one, other], [parent]) = (leaving.as_slice(), arriving.as_slice()) else {
                continue;
            };
            let count = shared[*one];
            if count.min(shared[*other]) < ONE_TUBE || count >= self.lines[*one].samples.len() {
                continue;
            }
            let along = self.lines[*one].samples[..count].to_vec();
            let last = along[count - 1];
            self.lines[*parent].samples.extend(along);
            self.forks[fork].ball = Ball {
                centre: last.point,
                radius: last.radius,
                part: last.part,
            };
        }
        for (line, shared) in self.lines.iter_mut().zip(shared) {
            let shared = &mut line.samples[..shared];
            shared
                .iter_mut()
                .for_each(|sample| sample.spread = f64::INFINITY);
        }
    }

    /// Changes the samples of each line towards each of its forks, which is behind the last of them then.
    fn towards_forks(&mut self, mut change: impl FnMut(&mut Vec<Sample>, Ball)) {
        for Line { from, to, samples } in &mut self.lines {
            for (fork, at_end) in [(*from, false), (*to, true)] {
                let Fork { ball, lines } = self.forks[fork as usize];
                if lines <= 2 {
                    continue;
                }
                if !at_end {
                    samples.reverse();
                }
                change(samples, ball);
                if !at_end {
                    samples.reverse();
                }
            }
        }
    }

    fn is_fork(&self, fork: u32) -> bool {
        self.forks[fork as usize].lines > 2
    }

    /// Moves ends to where on their tubes' axes balls begin to lie within each other.
    fn end(&mut self, solids: &Solids<'_>) {
        for number in 0..self.lines.len() {
            let Line { from, to, .. } = self.lines[number];
            for (fork, at_end) in [(from, false), (to, true)] {
                if self.forks[fork as usize].lines == 1 {
                    let samples = &mut self.lines[number].samples;
                    if !at_end {
                        samples.reverse();
                    }
                    let tip = self.forks[fork as usize].ball;
                    if let Some(ball) = end(solids, samples, tip) {
                        self.forks[fork as usize].ball = ball;
                    }
                    if !at_end {
                        samples.reverse();
                    }
                }
            }
        }
    }

    /// The knots of a line between its forks; with the forks themselves known where `pinned`.
    fn knots(&self, number: usize, pinned: bool) -> Vec<Knot> {
        let Line { from, to, samples } = &self.lines[number];
        let [start, end] = [*from, *to].map(|fork| self.forks[fork as usize]);
        let of_fork = |fork: &Fork| Knot {
            known: fork.ball.centre,
            spread: match (pinned, fork.lines > 2) {
                (true, true) => 1e-4 * fork.ball.radius,
                (false, true) => f64::INFINITY,
                (_, false) => 0.03 * fork.ball.radius,
            },
            radius: fork.ball.radius,
        };
        let own = samples.iter().filter(|sample| sample.spread.is_finite());
        let own: Vec<Sample> = own.copied().collect();
        let inner = between(&own, start.ball.centre, end.ball.centre);
        // In a fork balls grow, and so much they may be off the axis of the tube that the line has beside them.
        let beside = tubes_beside(inner);
        let grown = if pinned { GROWN_LED } else { GROWN };
        let drift = |place: usize| match (inner[place].tube, beside[place]) {
            (None, Some(radius)) => grown * (inner[place].radius - radius).max(0.0),
            _ => 0.0,
        };
        let inner = inner.iter().enumerate().map(|(place, sample)| Knot {
            known: sample.point,
            spread: sample.spread * sample.radius + drift(place),
            radius: sample.radius,
        });
        let mut knots = vec![of_fork(&start)];
        knots.extend(inner);
        knots.push(of_fork(&end));
        knots
    }

    /// Moves forks to where their lines meet, once.
    fn settle(&mut self) {
        let lines: Vec<Option<Smooth>> = (0..self.lines.len())
            .map(|number| smooth(&self.knots(number, false), FREE_JERK))
            .collect();
        let mut sums: Vec<(DMat3, DVec3)> = self
            .forks
            .iter()
            .map(|fork| {
                // Where it was is a weak guess.
                let prior = (PRIOR * fork.ball.radius).powi(-2);
                (
                    DMat3::from_diagonal(DVec3::splat(prior)),
                    prior * fork.ball.centre,
                )
            })
            .collect();
        for (line, smooth) in self.lines.iter().zip(&lines) {
            let Some(Smooth { points, ends }) = smooth else {
                continue;
            };
            let [first, last] = [0, points.len() - 1];
            for (fork, place, next, spread) in [
                (line.from, first, first + 1, ends[0]),
                (line.to, last, last - 1, ends[1]),
            ] {
                let Some(tangent) = (points[place] - points[next]).try_normalize() else {
                    continue;
                };
                let radius = self.forks[fork as usize].ball.radius;
                let weight = spread.max(0.003 * radius).powi(-2);
                let across = DMat3::IDENTITY
                    - DMat3::from_cols(
                        tangent * tangent.x,
                        tangent * tangent.y,
                        tangent * tangent.z,
                    );
                let (matrix, right) = &mut sums[fork as usize];
                *matrix += weight * across;
                *right += weight * (across * points[place]);
            }
        }
        for (fork, (matrix, right)) in self.forks.iter_mut().zip(sums) {
            let point = matrix.inverse() * right;
            if fork.lines > 2
                && point.is_finite()
                && point.distance(fork.ball.centre) < 2.0 * fork.ball.radius
            {
                fork.ball.centre = point;
            }
        }
    }

    /// Makes forks one that are in one place.
    fn unite(&mut self, solids: &Solids<'_>) -> bool {
        let mut united = false;
        for number in 0..self.lines.len() {
            let Line { from, to, .. } = self.lines[number];
            if from == to || !self.is_fork(to) || !self.is_fork(from) {
                continue;
            }
            let balls = [from, to].map(|fork| self.forks[fork as usize].ball);
            let [one, other] = balls.map(|ball| ball.centre);
            let radii = balls.map(|ball| solids.distance(ball.part, ball.centre));
            let radius = radii[0].min(radii[1]);
            if one.distance(other) >= ONE * radius {
                continue;
            }
            united = true;
            self.forks[from as usize].lines += self.forks[to as usize].lines - 2;
            self.forks[from as usize].ball.centre = one.midpoint(other);
            for line in &mut self.lines {
                line.from = if line.from == to { from } else { line.from };
                line.to = if line.to == to { from } else { line.to };
            }
        }
        self.lines.retain(|line| line.from != line.to);
        united
    }

    /// Leads lines to their forks.
    pub(super) fn join(&mut self, solids: &Solids<'_>) {
        for fork in self.forks.iter_mut().filter(|fork| fork.lines > 2) {
            // It may be a ball of a branch within the stem.
            let Ball { centre, part, .. } = fork.ball;
            fork.ball.radius = fork.ball.radius.max(solids.depth(centre, Some(part)));
        }
        self.towards_forks(leave_solids);
        self.keep_own();
        // Tubes are followed as far as there is wall.
        let mut wall = Wall::default();
        self.towards_forks(|samples, ball| follow(solids, samples, ball, &mut wall));
        self.end(solids);
        for _ in 0..ROUNDS {
            self.settle();
        }
        if self.unite(solids) {
            for _ in 0..ROUNDS {
                self.settle();
            }
        }
        let smoothed: Vec<Vec<Sample>> = (0..self.lines.len())
            .map(|number| self.smoothed(solids, number))
            .collect();
        for (line, samples) in self.lines.iter_mut().zip(smoothed) {
            line.samples = samples;
        }
    }

    /// A line from fork to fork.
    fn smoothed(&self, solids: &Solids<'_>, number: usize) -> Vec<Sample> {
        let knots = with_middles(&self.knots(number, true));
        let points = match smooth(&knots, LED_JERK) {
            Some(smooth) => smooth.points,
            None => knots.iter().map(|knot| knot.known).collect(),
        };
        let samples = &self.lines[number].samples;
        let sag = sag(solids, samples);
        let bits = |point: DVec3| point.to_array().map(f64::to_bits);
        let of_point: std::collections::HashMap<[u64; 3], usize> = samples
            .iter()
            .enumerate()
            .map(|(place, sample)| (bits(sample.point), place))
            .collect();
        let mut part = self.forks[self.lines[number].from as usize].ball.part;
        let of = |(point, knot): (DVec3, &Knot)| {
            let own = of_point
                .get(&bits(knot.known))
                .map(|place| &samples[*place]);
            part = own.map_or(part, |sample| sample.part);
            match own {
                Some(sample) if sample.tube.is_some() => Sample { point, ..*sample },
                _ => Sample::free(Ball {
                    centre: point,
                    radius: solids.distance(part, point) + sag,
                    part,
                }),
            }
        };
        let mut line: Vec<Sample> = points.into_iter().zip(&knots).map(of).collect();
        for place in (1..line.len().saturating_sub(1)).step_by(2) {
            if line[place - 1].tube.is_some() && line[place + 1].tube.is_some() {
                line[place].radius = f64::midpoint(line[place - 1].radius, line[place + 1].radius);
            }
        }
        line
    }
}

/// The radius of the tube that is nearest along the line to each sample.
fn tubes_beside(samples: &[Sample]) -> Vec<Option<f64>> {
    let mut beside: Vec<Option<(usize, f64)>> = vec![None; samples.len()];
    let mut last: Option<(usize, f64)> = None;
    for (place, sample) in samples.iter().enumerate() {
        last = sample.tube.map(|tube| (place, tube.radius)).or(last);
        beside[place] = last;
    }
    last = None;
    for (place, sample) in samples.iter().enumerate().rev() {
        last = sample.tube.map(|tube| (place, tube.radius)).or(last);
        let farther =
            |(one, _): (usize, f64)| last.is_some_and(|(other, _)| other - place < place - one);
        if beside[place].is_none_or(farther) {
            beside[place] = last;
        }
    }
    beside
        .into_iter()
        .map(|tube| tube.map(|(_, radius)| radius))
        .collect()
}

/// Knots with another one between any two: chords of a bent line are nearer to it that way.
fn with_middles(knots: &[Knot]) -> Vec<Knot> {
    let mut all = Vec::with_capacity(2 * knots.len());
    for pair in knots.windows(2) {
        all.push(pair[0]);
        all.push(Knot {
            known: pair[0].known.midpoint(pair[1].known),
            spread: f64::INFINITY,
            radius: f64::midpoint(pair[0].radius, pair[1].radius),
        });
    }
    all.extend(knots.last());
    all
}

/// What of a line is between the planes across it through where it begins and ends.
fn between(samples: &[Sample], start: DVec3, end: DVec3) -> &[Sample] {
    let along = |place: usize| {
        let (from, to) = (place.saturating_sub(1), (place + 1).min(samples.len() - 1));
        (samples[to].point - samples[from].point).normalize_or_zero()
    };
    let clear = |sample: &Sample| SPACING * sample.radius;
    let mut kept = 0..samples.len();
    while kept.len() > 1 {
        let sample = &samples[kept.start];
        if (sample.point - start).dot(along(kept.start)) > clear(sample) {
            break;
        }
        kept.start += 1;
    }
    while kept.len() > 1 {
        let sample = &samples[kept.end - 1];
        if (end - sample.point).dot(along(kept.end - 1)) > clear(sample) {
            break;
        }
        kept.end -= 1;
    }
    &samples[kept]
}

/// Leaves out what a line has in other solids than its own where it comes to a fork: the wall around is not its tube's.
fn leave_solids(samples: &mut Vec<Sample>, fork: Ball) {
    let near = |sample: &Sample| sample.point.distance(fork.centre) < REACH * fork.radius;
    let near = samples
        .iter()
        .rev()
        .take_while(|sample| near(sample))
        .count();
    let first = samples.len() - near;
    let Some(change) =
        (first.max(1)..samples.len()).find(|place| samples[place - 1].part != samples[*place].part)
    else {
        return;
    };
    samples.truncate(change);
    // Where it comes out from the side, balls stick out of the tube's end.
    while let [.., before, last] = samples.as_slice()
        && last.radius < ASIDE * before.radius
    {
        samples.pop();
    }
}

/// Follows the tube at the end of a line, which is within a ball.
fn follow(solids: &Solids<'_>, samples: &mut Vec<Sample>, end: Ball, wall: &mut Wall) {
    let Some(first) = samples
        .iter()
        .rposition(|sample| sample.tube.is_some() && sample.spread.is_finite())
    else {
        return;
    };
    let Some(mut tube) = samples[first].tube else {
        return;
    };
    if tube.point.distance(end.centre) > REACH * end.radius {
        return;
    }
    let part = samples[first].part;
    let onwards = samples[first].point - samples[first.saturating_sub(1)].point;
    if tube.tangent.dot(onwards) < 0.0 {
        tube.tangent = -tube.tangent;
    }
    let rest = samples.split_off(first + 1);
    let radius = tube.radius;
    let mut followed = 0;
    for _ in 0..FOLLOWED_MOST {
        let s = SPACING * tube.radius;
        let guess = Tube {
            point: tube.point + s * tube.tangent + s * s / 2.0 * tube.bend,
            tangent: (tube.tangent + s * tube.bend).normalize_or_zero(),
            radius,
            taper: 0.0,
            ..tube
        };
        if (guess.point - end.centre).dot(guess.tangent) > 0.25 * end.radius {
            break;
        }
        let Some(next) = super::tube::follow(solids.skin(part), &guess, wall) else {
            break;
        };
        if (next.radius / radius - 1.0).abs() > WIDER {
            break;
        }
        tube = next;
        samples.push(Sample {
            point: tube.point,
            radius: tube.radius,
            spread: 0.005 + 0.4 * tube.deviation + 0.04 * (1.0 - tube.fits),
            tube: Some(tube),
            part,
        });
        followed += 1;
    }
    // What is left of the balls, ahead of the last tube.
    let clear = 0.5 * SPACING * tube.radius;
    let ahead =
        |sample: &Sample| followed == 0 || (sample.point - tube.point).dot(tube.tangent) > clear;
    samples.extend(rest.into_iter().filter(ahead));
}

/// The last ball of a line that ends: those behind it lie within it. Leaves out samples beyond. Balls are looked at on the axis of the last tube
/// where that is near and stays inside, else on the line.
fn end(solids: &Solids<'_>, samples: &mut Vec<Sample>, tip: Ball) -> Option<Ball> {
    let on_axis = axis(samples, tip).and_then(|places| last_ball(solids, &places, tip.part));
    let on_line = course(samples, tip).and_then(|places| last_ball(solids, &places, tip.part));
    // Where the tube bends once more before its end, its axis leads aside.
    let is_aside = |axis: &Last| {
        let radius = on_line.as_ref().map_or(0.0, |line| line.ball.radius);
        axis.ball.radius < ASIDE_END * radius
    };
    let found = on_axis.filter(|axis| !is_aside(axis)).or(on_line)?;
    let Last {
        ball,
        onwards,
        thick,
    } = found;
    let clear = SPACING / 2.0 * ball.radius;
    let near = |sample: &Sample| sample.point.distance(ball.centre) < 3.0 * thick;
    while samples.len() > 1
        && samples.last().is_some_and(|sample| {
            near(sample) && (sample.point - ball.centre).dot(onwards) > -clear
        })
    {
        samples.pop();
    }
    Some(ball)
}

/// The last ball of a line that ends.
struct Last {
    ball: Ball,
    /// Where the line leads there.
    onwards: DVec3,
    /// The radius where it was looked for first.
    thick: f64,
}

/// The last of balls at places, by length, of which none lies behind it. None where it is not inside.
fn last_ball(solids: &Solids<'_>, places: &[(f64, DVec3)], part: u32) -> Option<Last> {
    let skin = solids.skin(part);
    let ball = |(s, centre): &(f64, DVec3)| {
        let radius = skin.distance(*centre);
        let centre = *centre;
        (
            *s,
            Ball {
                centre,
                radius,
                part,
            },
        )
    };
    let balls: Vec<(f64, Ball)> = places.iter().map(ball).collect();
    let thick = balls.first()?.1.radius;
    // In a cap balls shrink as fast as they go on; in a tube hardly. Where their radius plus half their way is most, the one becomes the other.
    let inside = balls
        .iter()
        .take_while(|(_, ball)| ball.radius > 0.1 * thick);
    let reach = |(s, ball): &(f64, Ball)| s / 2.0 + ball.radius;
    let (place, _) = inside
        .enumerate()
        .max_by(|(_, a), (_, b)| reach(a).total_cmp(&reach(b)))?;
    // The same again and again, closer about it.
    let mut around = places
        .get(place.saturating_sub(1)..=(place + 1).min(places.len() - 1))?
        .to_vec();
    let mut last = balls[place];
    for _ in 0..CLOSER_ROUNDS {
        let parts = |pair: &[(f64, DVec3)]| {
            let (from, to) = (pair[0], pair[1]);
            let parts = (0..=CLOSER).map(|part| f64::from(part) / f64::from(CLOSER));
            let at = |part| (from.0 + part * (to.0 - from.0), from.1.lerp(to.1, part));
            parts.map(at).collect::<Vec<_>>()
        };
        let closer: Vec<(f64, DVec3)> = around.windows(2).flat_map(parts).collect();
        let balls: Vec<(f64, Ball)> = closer.iter().map(ball).collect();
        let (place, best) = balls
            .iter()
            .enumerate()
            .max_by(|(_, a), (_, b)| reach(a).total_cmp(&reach(b)))?;
        last = *best;
        around = closer[place.saturating_sub(1)..=(place + 1).min(closer.len() - 1)].to_vec();
    }
    let (_, ball) = last;
    // Over a radius: the last steps to a ball at a tip may lead to the side.
    let (here, at) = places[place];
    let before = places.iter().take(place);
    let before = before.rev().find(|(s, _)| *s < here - ball.radius);
    let (_, from) = before.unwrap_or(&places[0]);
    solids.is_in(part, ball.centre).then(|| Last {
        ball,
        onwards: (at - *from).normalize_or_zero(),
        thick,
    })
}

/// Places on the axis of a line's last tube, by length along it, up to where the ball at the tip is. None where the tip is far from it.
fn axis(samples: &[Sample], tip: Ball) -> Option<Vec<(f64, DVec3)>> {
    let last = samples.iter().rposition(|sample| sample.tube.is_some())?;
    let tube = samples[last].tube?;
    let onwards = samples[last].point - samples[last.saturating_sub(1)].point;
    let is_near = tube.point.distance(tip.centre) < END_NEAR * tube.radius;
    let (tangent, bend) = match is_near {
        true if tube.tangent.dot(onwards) < 0.0 => (-tube.tangent, tube.bend),
        true => (tube.tangent, tube.bend),
        // On a very long line points are far apart: straight on.
        false => (onwards.normalize_or_zero(), DVec3::ZERO),
    };
    let at = |s: f64| tube.point + s * tangent + s * s / 2.0 * bend;
    // The ball at the tip touches the surface there: the line's last ball is not behind it.
    let step = END_STEP * tube.radius;
    let far = (tip.centre - tube.point).dot(tangent) + BEYOND * tube.radius;
    if !is_near && samples.len() - last > END_LAST || at(far).distance(tip.centre) > tube.radius {
        return None;
    }
    let mut places = Vec::new();
    let mut s = -2.0 * tube.radius;
    while s < far {
        places.push((s, at(s)));
        s += step;
    }
    Some(places)
}

/// Places on the last part of a line and on to the ball at its tip, by length.
fn course(samples: &[Sample], tip: Ball) -> Option<Vec<(f64, DVec3)>> {
    let mut way = vec![tip.centre];
    let mut length = 0.0;
    for sample in samples.iter().rev() {
        length += sample.point.distance(way[way.len() - 1]);
        way.push(sample.point);
        if length > END_NEAR * sample.radius {
            break;
        }
    }
    way.reverse();
    let step = END_STEP * samples.iter().rev().nth(way.len() / 2)?.radius;
    let mut places = Vec::new();
    let mut done = 0.0;
    for pair in way.windows(2) {
        let length = pair[0].distance(pair[1]);
        let mut s = 0.0;
        while s < length && places.len() < COURSE_MOST {
            places.push((done + s, pair[0].lerp(pair[1], s / length)));
            s += step.max(length / 64.0);
        }
        done += length;
    }
    (!places.is_empty()).then_some(places)
}

/// By how much the balls of fits are larger than those between triangles: the median of some along the line.
fn sag(solids: &Solids<'_>, samples: &[Sample]) -> f64 {
    let mut sags: Vec<f64> = samples
        .iter()
        .filter(|sample| sample.tube.is_some())
        .step_by(samples.len().div_ceil(SAGS).max(1))
        .map(|sample| sample.radius - solids.skin(sample.part).distance(sample.point))
        .collect();
    sags.sort_by(f64::total_cmp);
    sags.get(sags.len() / 2).copied().unwrap_or(0.0).max(0.0)
}
