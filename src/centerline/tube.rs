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

use glam::DVec3;

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
}

/// Rounds of a fit, each with the deviation, in radii, beyond which a vertex does not count at most.
const ROUNDS: [f64; 6] = [0.3, 0.15, 0.1, 0.08, 0.08, 0.08];
/// The same of following.
const FOLLOWED: [f64; 5] = [0.12, 0.08, 0.06, 0.06, 0.06];
/// That deviation is so many medians of all that count, but not less than this.
const MEDIANS: f64 = 4.8;
/// The radius is that of what deviates by fewer medians: fork walls that widen the tube a little move its axis hardly, but make it thicker.
const MEDIANS_OF_RADIUS: f64 = 2.5;
const ROUNDS_OF_RADIUS: usize = 5;
const TOLERANCE_LEAST: f64 = 0.012;
/// Half the length of a fit's window, in radii; following looks ahead less far.
const WINDOW: f64 = 0.65;
const AHEAD: f64 = 0.4;
/// How far off what is followed may be from what is expected, in radii: place, direction, bend, radius and taper.
const EXPECTED: [f64; 8] = [0.03, 0.03, 0.1, 0.1, 0.2, 0.2, 0.004, 0.01];
/// How far off walls are, in radii, to be weighed against what is expected.
const NOISE: f64 = 0.01;
/// Fewest sectors with wall, and least part of the wall, to follow.
const SECTORS_FEWEST: usize = 10;
const FITS_LEAST: f64 = 0.45;
/// Fewest vertices of a fit.
const FEWEST: usize = 20;
/// Vertices that are enough.
const ENOUGH: usize = 400;
/// Sectors in which wall is looked for.
const SECTORS: usize = 24;

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
        }
    }
}

/// Fits a tube about a guess. None where there is no such tube.
pub(super) fn fit(skin: &Skin<'_>, guess: &Tube, scratch: &mut Vec<WallPoint>) -> Option<Tube> {
    let round = Round::new(skin, guess, [WINDOW; 2], scratch);
    let mut tube = *guess;
    let mut median = f64::INFINITY;
    for most in ROUNDS {
        let tolerance = (MEDIANS * median).clamp(TOLERANCE_LEAST, most);
        median = round.improve(&mut tube, tolerance, scratch, None)?;
        let is_near = tube.point.distance(guess.point) < 1.2 * guess.radius;
        if !(is_near && tube.radius > 0.3 * guess.radius && tube.radius < 2.5 * guess.radius) {
            return None;
        }
    }
    let mut narrow = tube;
    for _ in 0..ROUNDS_OF_RADIUS {
        let tolerance = (MEDIANS_OF_RADIUS * median).clamp(TOLERANCE_LEAST, 0.08);
        median = round.improve(&mut narrow, tolerance, scratch, None)?;
    }
    tube.radius = narrow.radius;
    Some(tube)
}

/// A tube where one is expected, whose tangent leads on, by what of its wall is left.
pub(super) fn follow(
    skin: &Skin<'_>,
    expected: &Tube,
    scratch: &mut Vec<WallPoint>,
) -> Option<Tube> {
    let round = Round::new(skin, expected, [WINDOW, AHEAD], scratch);
    let mut tube = *expected;
    let mut median = f64::INFINITY;
    for most in FOLLOWED {
        let tolerance = (MEDIANS * median).clamp(TOLERANCE_LEAST, most);
        median = round.improve(&mut tube, tolerance, scratch, Some(expected))?;
    }
    (tube.fits > FITS_LEAST).then_some(tube)
}

/// What does not change from round to round.
struct Round {
    /// The window, from and to, along the axis.
    window: [f64; 2],
    /// What lengths are measured in.
    unit: f64,
}

impl Round {
    fn new(
        skin: &Skin<'_>,
        guess: &Tube,
        [behind, ahead]: [f64; 2],
        scratch: &mut Vec<WallPoint>,
    ) -> Self {
        let unit = guess.radius;
        skin.vertices_within(guess.point, 1.6_f64.hypot(behind) * unit, scratch);
        thin(scratch);
        Self {
            window: [-behind * unit, ahead * unit],
            unit,
        }
    }

    /// One step; the median deviation of what counts, in radii.
    fn improve(
        &self,
        tube: &mut Tube,
        tolerance: f64,
        points: &[WallPoint],
        expected: Option<&Tube>,
    ) -> Option<f64> {
        let unit = self.unit;
        let tangent = tube.tangent;
        let across = tangent.any_orthonormal_vector();
        let other = tangent.cross(across);
        let mut matrix = [[0.0; 8]; 8];
        let mut right = [0.0; 8];
        let (mut area, mut fitting, mut squares, mut count) = (0.0, 0.0, 0.0, 0);
        let mut sectors = [0.0; SECTORS];
        let mut offs = Vec::with_capacity(points.len());
        for point in points {
            let from = point.position - tube.point;
            let straight = from.dot(tangent);
            // To the nearest point of the bent axis: exact enough after one step.
            let along = straight / (1.0 - tube.bend.dot(from)).max(0.3);
            let radial = from - along * tangent - along * along / 2.0 * tube.bend;
            let distance = radial.length();
            let is_wall = straight >= self.window[0]
                && straight <= self.window[1]
                && distance > 0.3 * tube.radius
                && distance < 1.7 * tube.radius
                && radial.dot(point.normal) > 0.4 * distance;
            if !is_wall {
                continue;
            }
            area += point.area;
            let off = (distance - tube.radius - tube.taper * along) / unit;
            let weight = 1.0 - (off / tolerance).powi(2);
            if weight <= 0.0 {
                continue;
            }
            offs.push((off.abs(), point.area));
            fitting += point.area * weight.sqrt();
            let weight = point.area * weight * weight;
            let (x, y) = (radial.dot(across) / distance, radial.dot(other) / distance);
            let z = along / unit;
            let half = z * z / 2.0;
            let row = [x, y, x * z, y * z, x * half, y * half, 1.0, z];
            for i in 0..8 {
                for j in 0..=i {
                    matrix[i][j] += weight * row[i] * row[j];
                }
                right[i] += weight * row[i] * off;
            }
            squares += weight * off * off;
            sectors[sector(x, y)] += weight;
            count += 1;
        }
        let total: f64 = sectors.iter().sum();
        let with_wall = sectors
            .iter()
            .filter(|sector| **sector * SECTORS as f64 > 0.1 * total);
        if count < FEWEST || expected.is_some() && with_wall.count() < SECTORS_FEWEST {
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
        let [x, y, dx, dy, bend_x, bend_y, radius, taper] = solve(matrix, right)?;
        tube.point += unit * (x * across + y * other);
        tube.tangent = (tangent + dx * across + dy * other).try_normalize()?;
        tube.bend += (bend_x * across + bend_y * other) / unit;
        tube.bend -= tube.bend.dot(tube.tangent) * tube.tangent;
        tube.radius += radius * unit;
        tube.taper += taper;
        tube.deviation = (squares / total).sqrt();
        tube.fits = fitting / area;
        tube.gap = gap(&sectors, 0.1 * total);
        Some(median(&mut offs))
    }
}

/// Leaves out vertices where there are more than enough, evenly.
fn thin(points: &mut Vec<WallPoint>) {
    let keep = u32::try_from(points.len() / ENOUGH).unwrap_or(u32::MAX);
    if keep > 1 {
        points.retain(|point| (point.vertex.wrapping_mul(0x9E37_79B9) >> 8).is_multiple_of(keep));
    }
}

/// The median of values by their weights.
fn median(values: &mut [(f64, f64)]) -> f64 {
    values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let half = values.iter().map(|(_, weight)| weight).sum::<f64>() / 2.0;
    let mut sum = 0.0;
    let middle = values.iter().find(|(_, weight)| {
        sum += weight;
        sum >= half
    });
    middle.map_or(f64::INFINITY, |(value, _)| *value)
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a number of sectors"
)]
fn sector(x: f64, y: f64) -> usize {
    let part = y.atan2(x) / std::f64::consts::TAU + 1.0;
    (part * SECTORS as f64) as usize % SECTORS
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
