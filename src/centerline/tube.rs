//! The tube that a stretch of wall is, by least squares.
//!
//! About a guess, wall vertices within a window along the axis are fitted by a tube whose axis bends as a parabola and whose radius grows or
//! shrinks evenly: 8 numbers by Gauss's and Newton's method, each vertex measured from the nearest point of the axis. Vertices lie on the
//! surface that a mesh stands for and triangles within it, so this is exact where balls between triangles are too small by the sagitta; and
//! a fit over hundreds of vertices is quieter than one ball that four of them hold. What deviates by more than some times the median does not
//! count (Tukey's biweight): other tubes' walls, and where a fork begins to be rounded. How much of the wall fits, how well and how far around
//! tells whether it is one tube at all.
//!
//! In forks half of the wall is missing, and what is left fits many tubes. There the next tube is [followed](follow): it is expected to go
//! on as the last one, and the wall that is left says how it differs.

mod wall;

use glam::DVec3;

pub(super) use self::wall::Wall;
use self::wall::{Counted, Look, SECTORS};
use super::skin::{Skin, WallPoint};
use crate::tree::solve::solve;

/// A tube about a point of its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tube {
    /// On the axis.
    pub(super) point: DVec3,
    /// Along the axis, of length 1.
    pub(super) tangent: DVec3,
    /// The axis' second derivative by its length.
    pub(super) bend: DVec3,
    /// Across the axis.
    pub(super) radius: f64,
    /// Growth of the radius along the axis.
    pub(super) taper: f64,
    /// Deviation of what fits, in radii.
    pub(super) deviation: f64,
    /// Part of the wall's area that fits.
    pub(super) fits: f64,
    /// Widest angle without wall, radians.
    pub(super) gap: f64,
    /// How far along the axis what fits is spread (standard deviation), in radii.
    pub(super) along: f64,
}

/// Rounds of a fit, each with the deviation, in radii, beyond which a vertex does not count at most; those that are left where a guess is a fit already.
const ROUNDS: [f64; 3] = [0.3, 0.12, 0.08];
const AGAIN: [f64; 4] = [0.1, 0.08, 0.08, 0.08];
/// The same of following.
const FOLLOWED: [f64; 5] = [0.12, 0.08, 0.06, 0.06, 0.06];
/// That deviation is so many medians of all that count, but not less than this.
const MEDIANS: f64 = 6.0;
/// The radius is that of what deviates by fewer medians: fork walls that widen the tube a little move its axis hardly, but make it thicker.
const MEDIANS_OF_RADIUS: f64 = 2.0;
const ROUNDS_OF_RADIUS: usize = 3;
/// It is found when a round changes it by less than this part.
const SETTLED: f64 = 1e-4;
const LEAST: f64 = 0.012;
const LEAST_OF_MIDDLES: f64 = 0.05;
/// Half the length of a fit's window, in radii; following looks ahead less far. What is around it by this is gathered, too: fits move.
const WINDOW: f64 = 0.65;
const AHEAD: f64 = 0.4;
const AROUND: f64 = 0.25;
/// The same of a shorter window, which is looked into as well: beside a fork it has less of the fork's wall. Its tube is the better one where it
/// deviates by less than this part of the other's.
const SHORT: f64 = 0.25;
const BETTER: f64 = 0.8;
/// And where its wall is spread by more than this part of its length: one ring of vertices does not say where the axis leads. Windows with less than
/// that are made twice as long, and once more.
const SPREAD: f64 = 0.4;
const WINDOW_MOST: f64 = 2.0;
/// How far off what is followed may be from what is expected, in radii: place, direction, bend, radius and taper.
const EXPECTED: [f64; 8] = [0.03, 0.03, 0.1, 0.1, 0.2, 0.2, 0.004, 0.01];
/// How much a tube resists bending where its wall does not say so, as a part of the wall's weight.
const STRAIGHT: f64 = 1e-6;
/// How far off walls are, in radii, to be weighed against what is expected.
const NOISE: f64 = 0.01;
/// Fewest sectors with wall, and least part of the wall, to follow.
const SECTORS_FEWEST: usize = 10;
const FITS_LEAST: f64 = 0.45;
/// Fewest vertices of a fit.
const FEWEST: usize = 20;
/// Fewer vertices to a radius of a window are few: there the middles of triangles count, too, for half as much as vertices. (Where a mesh was made coarse
/// by quadric errors, its vertices are outside of what it stands for by half as much as its triangles' middles are inside.)
const DENSE: f64 = 18.0;
const MIDDLES: f64 = 0.5;
/// Points that are enough.
const ENOUGH: usize = 256;

impl Tube {
    /// A guess of one.
    pub(super) fn guess(point: DVec3, tangent: DVec3, bend: DVec3, radius: f64) -> Self {
        Self {
            point,
            tangent: tangent.normalize_or_zero(),
            bend,
            radius,
            taper: 0.0,
            deviation: 0.0,
            fits: 0.0,
            gap: 0.0,
            along: 0.0,
        }
    }

    /// Whether it is one well enough to stand in its middle.
    pub(super) fn is_whole(&self) -> bool {
        self.fits > 0.85 && self.gap < 1.1 && self.deviation < 0.05
    }
}

/// Fits a tube about a guess. None where there is no such tube.
pub(super) fn fit(skin: &Skin<'_>, guess: &Tube, wall: &mut Wall) -> Option<Tube> {
    fit_long(skin, guess, &ROUNDS, wall)
}

/// The same about a guess that was such a fit, and in a shorter window, too.
pub(super) fn fit_again(skin: &Skin<'_>, guess: &Tube, wall: &mut Wall) -> Option<Tube> {
    let long = fit_long(skin, guess, &AGAIN, wall)?;
    if !long.is_whole() {
        return Some(long);
    }
    let short = fit_in(skin, &long, SHORT, &AGAIN, wall);
    let is_better = |short: &Tube| {
        short.is_whole()
            && short.along > SPREAD * SHORT
            && short.deviation < BETTER * long.deviation
    };
    Some(short.filter(is_better).unwrap_or(long))
}

/// A fit in a window that is long enough.
fn fit_long(skin: &Skin<'_>, guess: &Tube, rounds: &[f64], wall: &mut Wall) -> Option<Tube> {
    let mut window = WINDOW;
    let mut tube = fit_in(skin, guess, window, rounds, wall)?;
    while tube.along < SPREAD * window && window < WINDOW_MOST {
        window *= 2.0;
        tube = fit_in(skin, guess, window, rounds, wall)?;
    }
    Some(tube)
}

fn fit_in(
    skin: &Skin<'_>,
    guess: &Tube,
    window: f64,
    rounds: &[f64],
    wall: &mut Wall,
) -> Option<Tube> {
    let round = Round::new(skin, guess, [window; 2], wall);
    let mut tube = *guess;
    let mut median = f64::INFINITY;
    for most in rounds {
        let tolerance = (MEDIANS * median).clamp(round.least.min(*most), *most);
        median = round.improve(&mut tube, tolerance, wall, None)?;
        let is_near = tube.point.distance(guess.point) < 1.2 * guess.radius;
        if !(is_near && tube.radius > 0.3 * guess.radius && tube.radius < 2.5 * guess.radius) {
            return None;
        }
    }
    let mut narrow = tube;
    for _ in 0..ROUNDS_OF_RADIUS {
        let tolerance = (MEDIANS_OF_RADIUS * median).clamp(round.least, 0.08);
        let last = narrow.radius;
        median = round.improve(&mut narrow, tolerance, wall, None)?;
        if (narrow.radius - last).abs() < SETTLED * last {
            break;
        }
    }
    tube.radius = narrow.radius;
    Some(tube)
}

/// A tube where one is expected, whose tangent leads on, by what of its wall is left.
pub(super) fn follow(skin: &Skin<'_>, expected: &Tube, wall: &mut Wall) -> Option<Tube> {
    let round = Round::new(skin, expected, [WINDOW, AHEAD], wall);
    let mut tube = *expected;
    let mut median = f64::INFINITY;
    for most in FOLLOWED {
        let tolerance = (MEDIANS * median).clamp(round.least.min(most), most);
        median = round.improve(&mut tube, tolerance, wall, Some(expected))?;
    }
    (tube.fits > FITS_LEAST).then_some(tube)
}

/// What does not change from round to round.
struct Round {
    /// The window, from and to, along the axis.
    window: [f64; 2],
    /// What lengths are measured in.
    unit: f64,
    /// The deviation up to which a point counts at least, in radii.
    least: f64,
}

impl Round {
    fn new(skin: &Skin<'_>, guess: &Tube, [behind, ahead]: [f64; 2], wall: &mut Wall) -> Self {
        let unit = guess.radius;
        let most = 1.6_f64.hypot(behind) * unit;
        let is_in_window = |point: &WallPoint| {
            let straight = (point.position - guess.point).dot(guess.tangent) / unit;
            straight > -behind - AROUND && straight < ahead + AROUND
        };
        // Where vertices were few a step before, they are most likely here.
        let points = &mut wall.points;
        let few = points.iter().any(|point| point.is_middle);
        for middles in [Some(MIDDLES).filter(|_| few), Some(MIDDLES)] {
            skin.points_within(guess.point, most, middles, points);
            points.retain(is_in_window);
            let vertices = points.iter().filter(|point| !point.is_middle).count();
            if vertices as f64 >= DENSE * (behind + ahead) {
                points.retain(|point| !point.is_middle);
                break;
            }
            if middles.is_some() {
                break;
            }
        }
        thin(points);
        let has_middles = points.iter().any(|point| point.is_middle);
        wall.line_up();
        Self {
            window: [-behind * unit, ahead * unit],
            unit,
            // Vertices and middles lie on two tubes, and both are to count.
            least: if has_middles { LEAST_OF_MIDDLES } else { LEAST },
        }
    }

    /// One step; the median deviation of what counts, in radii.
    fn improve(
        &self,
        tube: &mut Tube,
        tolerance: f64,
        wall: &mut Wall,
        expected: Option<&Tube>,
    ) -> Option<f64> {
        let unit = self.unit;
        let tangent = tube.tangent;
        let across = tangent.any_orthonormal_vector();
        let other = tangent.cross(across);
        let Counted {
            points,
            area,
            fitting,
            median,
            sectors,
        } = wall.weigh(&Look {
            tube,
            axes: [across, other],
            window: self.window,
            unit,
            tolerance,
        });
        let moments = wall.moments();
        let (mut matrix, mut right) = moments.equations();
        let [total, first, second] = moments.along();
        let with_wall = sectors
            .iter()
            .filter(|sector| **sector * SECTORS as f64 > 0.1 * total);
        if points < FEWEST || expected.is_some() && with_wall.count() < SECTORS_FEWEST {
            return None;
        }
        let changed = expected.map(|expected| {
            let off = (tube.point - expected.point) / unit;
            let turned = tangent - expected.tangent;
            let bent = (tube.bend - expected.bend) * unit;
            [
                off.dot(across),
                off.dot(other),
                turned.dot(across),
                turned.dot(other),
                bent.dot(across),
                bent.dot(other),
                (tube.radius - expected.radius) / unit,
                tube.taper - expected.taper,
            ]
        });
        for i in 0..8 {
            matrix[i][i] += 1e-9 * total;
            if let Some(changed) = changed {
                let weight = total * (NOISE / EXPECTED[i]).powi(2);
                matrix[i][i] += weight;
                right[i] -= weight * changed[i];
            }
        }
        // Two rings of vertices say nothing of a bend.
        for (i, axis) in [(4, across), (5, other)] {
            matrix[i][i] += STRAIGHT * total;
            right[i] -= STRAIGHT * total * unit * tube.bend.dot(axis);
        }
        let [x, y, dx, dy, bend_x, bend_y, radius, taper] = solve(matrix, right)?;
        tube.point += unit * (x * across + y * other);
        tube.tangent = (tangent + dx * across + dy * other).try_normalize()?;
        tube.bend += (bend_x * across + bend_y * other) / unit;
        tube.bend -= tube.bend.dot(tube.tangent) * tube.tangent;
        tube.radius += radius * unit;
        tube.taper += taper;
        tube.deviation = (moments.squares / total).sqrt();
        tube.fits = fitting / area;
        let (first, second) = (first / total, second / total);
        tube.along = (second - first * first).max(0.0).sqrt();
        tube.gap = gap(&sectors, 0.1 * total);
        Some(median)
    }
}

/// Leaves out vertices where there are more than enough, evenly.
fn thin(points: &mut Vec<WallPoint>) {
    let keep = u32::try_from(points.len() / ENOUGH).unwrap_or(u32::MAX);
    if keep > 1 {
        points.retain(|point| (point.number.wrapping_mul(0x9E37_79B9) >> 8).is_multiple_of(keep));
    }
}

/// The widest run of sectors with little in them.
fn gap(sectors: &[f64; SECTORS], little: f64) -> f64 {
    let (mut run, mut widest) = (0, 0);
    for sector in sectors.iter().chain(sectors) {
        run = if *sector * SECTORS as f64 <= little {
            run + 1
        } else {
            0
        };
        widest = widest.max(run);
    }
    widest.min(SECTORS) as f64 * std::f64::consts::TAU / SECTORS as f64
}
