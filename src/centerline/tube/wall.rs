//! Points of the wall about a tube, and sums over them: what a fit does most. Four points are worked out side by side, as processors do; points that do
//! not count have no weight, so that nothing asks which they are.

use glam::DVec3;

use super::Tube;
use crate::centerline::skin::WallPoint;

/// Points side by side.
const LANES: usize = 4;
type Lanes = [f64; LANES];

/// Classes in which deviations are counted for their median.
const CLASSES: usize = 128;
/// Sectors in which wall is looked for, of 15 degrees each; tangents of 15 and 30 degrees.
pub(super) const SECTORS: usize = 24;
const TANGENTS: [f64; 2] = [0.267_949_192_431_122_7, 0.577_350_269_189_625_8];

/// Points of the wall; kept from fit to fit for their memory.
#[derive(Debug, Default)]
pub(in crate::centerline) struct Wall {
    pub(super) points: Vec<WallPoint>,
    packs: Vec<Pack>,
    weighed: Vec<Weighed>,
}

/// Some points: x, y and z of place and normal, and area. What is left of the last one has no area.
#[derive(Clone, Copy, Debug, Default)]
struct Pack {
    place: [Lanes; 3],
    normal: [Lanes; 3],
    area: Lanes,
}

/// What a fit asks of points.
pub(super) struct Look<'a> {
    pub(super) tube: &'a Tube,
    /// Two directions across the tangent.
    pub(super) axes: [DVec3; 2],
    /// From and to, along the axis.
    pub(super) window: [f64; 2],
    /// What lengths are measured in.
    pub(super) unit: f64,
    /// The deviation, in units, from which on a point does not count.
    pub(super) tolerance: f64,
}

/// Points as a tube sees them.
#[derive(Clone, Copy, Debug, Default)]
struct Weighed {
    weight: Lanes,
    /// Across the axis, of length 1.
    across: [Lanes; 2],
    /// Along it, and how far from the tube, in units.
    along: Lanes,
    off: Lanes,
}

/// What was counted on the way.
pub(super) struct Counted {
    pub(super) points: usize,
    /// Area of the wall, and the part of it that fits.
    pub(super) area: f64,
    pub(super) fitting: f64,
    /// Median deviation of what counts, in units.
    pub(super) median: f64,
    /// Weight by sector about the axis.
    pub(super) sectors: [f64; SECTORS],
}

/// Sums over all points of their weight times what is named, and that times powers of z, how far along the axis they are, from the first power on.
/// x and y are what they are across it, each of a row of [`Self::ROW`]; `off` how far from the tube.
pub(super) struct Moments {
    pairs: [[f64; 5]; 3],
    across: [[f64; 4]; 2],
    along: [f64; 3],
    pairs_off: [[f64; 3]; 2],
    off: [f64; 2],
    /// The squares of `off`.
    pub(super) squares: f64,
}

impl Wall {
    /// Lines the points up.
    pub(super) fn line_up(&mut self) {
        self.packs.clear();
        for points in self.points.chunks(LANES) {
            let mut pack = Pack::default();
            for (lane, point) in points.iter().enumerate() {
                for axis in 0..3 {
                    pack.place[axis][lane] = point.position[axis];
                    pack.normal[axis][lane] = point.normal[axis];
                }
                pack.area[lane] = point.area;
            }
            self.packs.push(pack);
        }
    }

    /// Weighs all points (Tukey's biweight).
    pub(super) fn weigh(&mut self, look: &Look<'_>) -> Counted {
        let (mut area, mut fitting) = ([0.0; LANES], [0.0; LANES]);
        let mut offs = Classes([0.0; CLASSES]);
        let mut sectors = [0.0; SECTORS];
        let mut points = 0;
        self.weighed.clear();
        for pack in &self.packs {
            let (weighed, wall, fits) = look.weigh(pack);
            for lane in 0..LANES {
                area[lane] += wall[lane];
                fitting[lane] += fits[lane];
                if weighed.weight[lane] > 0.0 {
                    offs.add(weighed.off[lane].abs() / look.tolerance, wall[lane]);
                    let [x, y] = weighed.across;
                    sectors[sector(x[lane], y[lane])] += weighed.weight[lane];
                    points += 1;
                }
            }
            self.weighed.push(weighed);
        }
        Counted {
            points,
            area: area.iter().sum(),
            fitting: fitting.iter().sum(),
            median: look.tolerance * offs.median(),
            sectors,
        }
    }

    /// Sums over the points as they were weighed last.
    pub(super) fn moments(&self) -> Moments {
        let sums = &self.weighed;
        let pair = |a: usize, b: usize| {
            moments(sums, move |of, lane| {
                of.weight[lane] * of.across[a][lane] * of.across[b][lane]
            })
        };
        let across = |a: usize| moments(sums, move |of, lane| of.weight[lane] * of.across[a][lane]);
        let pair_off = |a: usize| {
            moments(sums, move |of, lane| {
                of.weight[lane] * of.across[a][lane] * of.off[lane]
            })
        };
        let [squares] = moments(sums, |of, lane| {
            of.weight[lane] * of.off[lane] * of.off[lane]
        });
        Moments {
            pairs: [pair(0, 0), pair(0, 1), pair(1, 1)],
            across: [across(0), across(1)],
            along: moments(sums, |of, lane| of.weight[lane]),
            pairs_off: [pair_off(0), pair_off(1)],
            off: moments(sums, |of, lane| of.weight[lane] * of.off[lane]),
            squares,
        }
    }
}

impl Look<'_> {
    /// Points as the tube sees them, their areas where they are wall, and of that what fits.
    #[inline]
    fn weigh(&self, pack: &Pack) -> (Weighed, Lanes, Lanes) {
        let Tube {
            point,
            tangent,
            bend,
            radius,
            taper,
            ..
        } = *self.tube;
        let [first, second] = self.axes;
        let [from, to] = self.window;
        let (per_unit, per_tolerance) = (self.unit.recip(), self.tolerance.recip());
        let (least, most) = (0.3 * radius, 1.7 * radius);
        let mut out = Weighed::default();
        let [mut straight, mut along, mut distance, mut outwards] = [[0.0; LANES]; 4];
        let [mut wall, mut fits] = [[0.0; LANES]; 2];
        let mut from_axis = [[0.0; LANES]; 3];
        // Short loops, of which a compiler makes a few instructions for all lanes each.
        for lane in 0..LANES {
            let x = pack.place[0][lane] - point.x;
            let y = pack.place[1][lane] - point.y;
            let z = pack.place[2][lane] - point.z;
            straight[lane] = x * tangent.x + y * tangent.y + z * tangent.z;
            // To the nearest point of the bent axis: exact enough after one step.
            let nearer = 1.0 - (x * bend.x + y * bend.y + z * bend.z);
            along[lane] = straight[lane] / if nearer > 0.3 { nearer } else { 0.3 };
        }
        for lane in 0..LANES {
            let half = along[lane] * along[lane] * 0.5;
            let to = |axis: usize| {
                pack.place[axis][lane]
                    - point[axis]
                    - along[lane] * tangent[axis]
                    - half * bend[axis]
            };
            let [x, y, z] = [to(0), to(1), to(2)];
            from_axis[0][lane] = x;
            from_axis[1][lane] = y;
            from_axis[2][lane] = z;
            distance[lane] = (x * x + y * y + z * z).sqrt();
            outwards[lane] =
                x * pack.normal[0][lane] + y * pack.normal[1][lane] + z * pack.normal[2][lane];
        }
        for lane in 0..LANES {
            let distance = distance[lane];
            let area = pack.area[lane];
            let area = if straight[lane] >= from { area } else { 0.0 };
            let area = if straight[lane] <= to { area } else { 0.0 };
            let area = if distance > least { area } else { 0.0 };
            let area = if distance < most { area } else { 0.0 };
            let is_outside = outwards[lane] > 0.4 * distance;
            wall[lane] = if is_outside { area } else { 0.0 };
        }
        for lane in 0..LANES {
            let off = (distance[lane] - radius - taper * along[lane]) * per_unit;
            let part = 1.0 - (off * per_tolerance) * (off * per_tolerance);
            let part = if part > 0.0 { part } else { 0.0 };
            fits[lane] = wall[lane] * part.sqrt();
            out.weight[lane] = wall[lane] * part * part;
            out.off[lane] = off;
            out.along[lane] = along[lane] * per_unit;
        }
        for lane in 0..LANES {
            let [x, y, z] = [from_axis[0][lane], from_axis[1][lane], from_axis[2][lane]];
            // What is on the axis is no wall.
            let distance = distance[lane];
            let per_distance = 1.0 / if distance > least { distance } else { least };
            out.across[0][lane] = (x * first.x + y * first.y + z * first.z) * per_distance;
            out.across[1][lane] = (x * second.x + y * second.y + z * second.z) * per_distance;
        }
        (out, wall, fits)
    }
}

/// The sum of what points have, and the sums of that times powers of how far along they are.
#[inline]
fn moments<const POWERS: usize>(
    weighed: &[Weighed],
    of: impl Fn(&Weighed, usize) -> f64,
) -> [f64; POWERS] {
    let mut sums = [[0.0; LANES]; POWERS];
    for pack in weighed {
        let mut parts = [0.0; LANES];
        for (lane, part) in parts.iter_mut().enumerate() {
            *part = of(pack, lane);
        }
        for sum in &mut sums {
            for lane in 0..LANES {
                sum[lane] += parts[lane];
                parts[lane] *= pack.along[lane];
            }
        }
    }
    sums.map(|lanes| lanes.iter().sum())
}

impl Moments {
    /// The normal equations of a tube's change: place across (2), direction (2), bend (2), radius, taper. Of the matrix the lower half.
    pub(super) fn equations(&self) -> ([[f64; 8]; 8], [f64; 8]) {
        // A point's row is x, y, xz, yz, xz²/2, yz²/2, 1, z: by column its axis (2: none), its power of z and its factor.
        const ROW: [(usize, usize, f64); 8] = [
            (0, 0, 1.0),
            (1, 0, 1.0),
            (0, 1, 1.0),
            (1, 1, 1.0),
            (0, 2, 0.5),
            (1, 2, 0.5),
            (2, 0, 1.0),
            (2, 1, 1.0),
        ];
        let product = |a: usize, b: usize, power: usize| match (a.min(b), a.max(b)) {
            (2, _) => self.along[power],
            (axis, 2) => self.across[axis][power],
            (one, other) => self.pairs[one + other][power],
        };
        let mut matrix = [[0.0; 8]; 8];
        let mut right = [0.0; 8];
        for (i, (a, m, p)) in ROW.into_iter().enumerate() {
            for (j, (b, n, q)) in ROW.into_iter().enumerate().take(i + 1) {
                matrix[i][j] = p * q * product(a, b, m + n);
            }
            right[i] = p * match a {
                2 => self.off[m],
                axis => self.pairs_off[axis][m],
            };
        }
        (matrix, right)
    }

    /// The sum of all weights, of how far along points are, and of the squares of that.
    pub(super) fn along(&self) -> [f64; 3] {
        self.along
    }
}

/// Weights of values between 0 and 1, counted in classes.
struct Classes([f64; CLASSES]);

impl Classes {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a number of classes"
    )]
    fn add(&mut self, value: f64, weight: f64) {
        self.0[((value * CLASSES as f64) as usize).min(CLASSES - 1)] += weight;
    }

    /// The median, as if values were spread evenly within their class.
    fn median(&self) -> f64 {
        let half = self.0.iter().sum::<f64>() / 2.0;
        let mut sum = 0.0;
        for (class, weight) in self.0.iter().enumerate() {
            if *weight > 0.0 && sum + weight >= half {
                return (class as f64 + (half - sum) / weight) / CLASSES as f64;
            }
            sum += weight;
        }
        f64::INFINITY
    }
}

/// The sector that a direction is in. (By its angle, the arcus tangent took a twentieth of all the time.)
fn sector(x: f64, y: f64) -> usize {
    let (long, short) = (x.abs().max(y.abs()), x.abs().min(y.abs()));
    let from_axis = TANGENTS.iter().filter(|tangent| short > **tangent * long);
    let from_axis = from_axis.count();
    let from_x = if y.abs() > x.abs() {
        5 - from_axis
    } else {
        from_axis
    };
    match (x < 0.0, y < 0.0) {
        (false, false) => from_x,
        (true, false) => 11 - from_x,
        (true, true) => 12 + from_x,
        (false, true) => 23 - from_x,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "tests")]
    use super::*;

    /// Points about a bent, tapered tube, some off it, some turned away, one on the axis.
    fn wall(count: u32) -> Wall {
        let points = (0..count).map(|number| {
            let n = f64::from(number);
            let round = n * 2.4;
            let along = (n * 0.61).sin();
            let far = if number == 0 {
                0.0
            } else {
                1.0 + 0.1 * (n * 1.7).sin()
            };
            let outwards = DVec3::new(round.cos(), round.sin(), 0.0);
            let side = if number % 7 == 3 { -1.0 } else { 1.0 };
            WallPoint {
                position: far * outwards + along * DVec3::Z,
                normal: side * outwards,
                area: 0.5 + 0.4 * (n * 0.9).cos(),
                number,
                is_middle: false,
            }
        });
        Wall {
            points: points.collect(),
            ..Wall::default()
        }
    }

    #[test]
    fn sums_are_those_of_the_points_one_by_one() {
        let tube = Tube {
            taper: 0.02,
            ..Tube::guess(
                DVec3::new(0.02, -0.03, 0.1),
                DVec3::new(0.03, 0.01, 1.0),
                DVec3::new(0.1, 0.05, 0.0),
                1.02,
            )
        };
        let across = tube.tangent.any_orthonormal_vector();
        let other = tube.tangent.cross(across);
        for count in [0, 1, 4, 97] {
            let mut wall = wall(count);
            wall.line_up();
            let look = Look {
                tube: &tube,
                axes: [across, other],
                window: [-0.7, 0.6],
                unit: 1.1,
                tolerance: 0.08,
            };
            let counted = wall.weigh(&look);
            let moments = wall.moments();
            let (mut matrix, mut right, mut squares) = ([[0.0; 8]; 8], [0.0; 8], 0.0);
            let (mut points, mut area, mut fitting) = (0, 0.0, 0.0);
            for point in &wall.points {
                let from = point.position - tube.point;
                let straight = from.dot(tube.tangent);
                let along = straight / (1.0 - tube.bend.dot(from)).max(0.3);
                let radial = from - along * tube.tangent - along * along / 2.0 * tube.bend;
                let distance = radial.length();
                let is_wall = (look.window[0]..=look.window[1]).contains(&straight)
                    && distance > 0.3 * tube.radius
                    && distance < 1.7 * tube.radius
                    && radial.dot(point.normal) > 0.4 * distance;
                if !is_wall {
                    continue;
                }
                area += point.area;
                let off = (distance - tube.radius - tube.taper * along) / look.unit;
                let part = 1.0 - (off / look.tolerance).powi(2);
                if part <= 0.0 {
                    continue;
                }
                points += 1;
                fitting += point.area * part.sqrt();
                let weight = point.area * part * part;
                let (x, y) = (radial.dot(across) / distance, radial.dot(other) / distance);
                let z = along / look.unit;
                let half = z * z / 2.0;
                let row = [x, y, x * z, y * z, x * half, y * half, 1.0, z];
                for i in 0..8 {
                    for j in 0..=i {
                        matrix[i][j] += weight * row[i] * row[j];
                    }
                    right[i] += weight * row[i] * off;
                }
                squares += weight * off * off;
            }
            assert_eq!(counted.points, points);
            assert!(count < 97 || (20..80).contains(&points), "{points}");
            let (found, found_right) = moments.equations();
            let pairs = found.as_flattened().iter().zip(matrix.as_flattened());
            let pairs = pairs.chain(found_right.iter().zip(&right)).chain([
                (&moments.squares, &squares),
                (&counted.area, &area),
                (&counted.fitting, &fitting),
            ]);
            for (found, expected) in pairs {
                assert!((found - expected).abs() < 1e-9, "{found} {expected}");
            }
        }
    }
}
