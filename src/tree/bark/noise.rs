//! Noise that repeats at the edges of a tile: what barks are painted by. Only sums, products and square roots, so that no machine differs.

/// How far a place lies from the border of its plate, in cells: 0 on the border. Plates are the regions nearest to one random
/// point in each lattice cell (Worley's F2 − F1: SIGGRAPH 1996, "A Cellular Texture Basis Function"), periodic like [`Lattice`].
pub(super) fn plates(cells: [u32; 2], seed: u32, u: f32, v: f32) -> f32 {
    let points = [seed, seed ^ 0x5bd1_e995].map(|seed| Lattice { cells, seed });
    let (x, y) = (parted(u, cells[0]), parted(v, cells[1]));
    // Of cells two to the left and above to two to the right and below.
    let [columns, rows] = [(x.0, cells[0]), (y.0, cells[1])]
        .map(|(cell, cells)| [-2, -1, 0, 1, 2].map(|aside| wrap(cell + aside, cells)));
    let (mut nearest, mut second) = (f32::MAX, f32::MAX);
    let mut look = |right: usize, down: usize| {
        let [column, row] = [columns[right], rows[down]];
        let dx = ASIDE[right] + points[0].value(column, row) - x.1;
        let dy = ASIDE[down] + points[1].value(column, row) - y.1;
        let squared = dx * dx + dy * dy;
        second = second.min(nearest.max(squared));
        nearest = nearest.min(squared);
        second
    };
    let mut least = f32::MAX;
    for down in 1..4 {
        for right in 1..4 {
            least = look(right, down);
        }
    }
    // Farther out only where two points may be as far from here as that: their cells are.
    let [far_x, far_y] = [x.1, y.1].map(|here| [1.0 + here, 0.0, 0.0, 0.0, 2.0 - here]);
    for (down, far_y) in far_y.into_iter().enumerate() {
        for (right, far_x) in far_x.into_iter().enumerate() {
            let is_looked_at = (1..4).contains(&down) && (1..4).contains(&right);
            if !is_looked_at && SURE * (far_x * far_x + far_y * far_y) <= least {
                least = look(right, down);
            }
        }
    }
    second.sqrt() - nearest.sqrt()
}

/// Cells aside.
const ASIDE: [f32; 5] = [-2.0, -1.0, 0.0, 1.0, 2.0];
/// Less than what rounding adds to a square.
const SURE: f32 = 0.999;

/// The cell that a place of the tile is in, and how far in.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "a few hundred cells, and a place in or near the tile"
)]
fn parted(place: f32, cells: u32) -> (i32, f32) {
    let place = place * cells as f32;
    // Rounded towards zero, which is quicker than down.
    let whole = place as i32;
    let whole = whole - i32::from(whole as f32 > place);
    (whole, place - whole as f32)
}

/// The two cells between whose corners a place lies, and how near to the second.
#[inline]
fn corners(place: f32, cells: u32) -> ((u32, u32), f32) {
    let (cell, within) = parted(place, cells);
    let cell = wrap(cell, cells);
    let next = if cell + 1 == cells { 0 } else { cell + 1 };
    ((cell, next), smooth(within))
}

/// A cell's number, brought into the tile.
fn wrap(cell: i32, cells: u32) -> u32 {
    let cells = cells.cast_signed();
    // Most are in it or right beside it.
    let near = match cell {
        ..0 => cell + cells,
        _ if cell >= cells => cell - cells,
        _ => cell,
    };
    let is_in = (0..cells).contains(&near);
    let within = if is_in { near } else { near.rem_euclid(cells) };
    within.cast_unsigned()
}

/// Value noise that repeats after `cells` lattice cells in each direction of the unit tile.
#[derive(Clone, Copy)]
pub(super) struct Lattice {
    pub(super) cells: [u32; 2],
    pub(super) seed: u32,
}

impl Lattice {
    /// Octaves of halving size and weight, 0 to 1 with mean 1/2.
    pub(super) fn octaves(self, u: f32, v: f32, octaves: u32) -> f32 {
        let (mut sum, mut weights, mut weight) = (0.0, 0.0, 1.0);
        let mut layer = self;
        for _ in 0..octaves {
            sum += weight * layer.at(u, v);
            weights += weight;
            weight *= 0.5;
            layer = Self {
                cells: layer.cells.map(|cells| cells * 2),
                seed: layer.seed.wrapping_mul(31).wrapping_add(17),
            };
        }
        sum / weights
    }

    /// One octave, 0 to 1.
    fn at(self, u: f32, v: f32) -> f32 {
        // (Arrays are mapped out of line here.)
        let (x, right) = corners(u, self.cells[0]);
        let (y, down) = corners(v, self.cells[1]);
        let top = blend(self.value(x.0, y.0), self.value(x.1, y.0), right);
        let bottom = blend(self.value(x.0, y.1), self.value(x.1, y.1), right);
        blend(top, bottom, down)
    }

    /// The random value of a lattice point, 0 to 1: a hash of seed and place (rounds of xor-shift and multiply).
    fn value(self, x: u32, y: u32) -> f32 {
        let mut bits = self.seed ^ x.wrapping_mul(0x9E37_79B9) ^ y.wrapping_mul(0x85EB_CA6B);
        for factor in [0x7FEB_352D_u32, 0x846C_A68B] {
            bits = (bits ^ (bits >> 16)).wrapping_mul(factor);
        }
        #[allow(clippy::cast_precision_loss, reason = "24 bits fit f32 exactly")]
        let value = (bits >> 8) as f32 / 16_777_216.0;
        value
    }
}

fn blend(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}

/// 0 to 1 with level ends in slope and curvature.
pub(super) fn smooth(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_sign_loss,
        reason = "tests"
    )]
    use super::*;

    #[test]
    fn noise_repeats_at_the_edges_of_the_tile() {
        let lattice = Lattice {
            cells: [5, 3],
            seed: 11,
        };
        for i in 0..=32 {
            let t = i as f32 / 32.0;
            assert!((lattice.octaves(0.0, t, 4) - lattice.octaves(1.0, t, 4)).abs() < 1e-4);
            assert!((lattice.octaves(t, 0.0, 4) - lattice.octaves(t, 1.0, 4)).abs() < 1e-4);
        }
    }

    /// As if all cells were looked at.
    #[test]
    fn plates_are_those_of_the_two_nearest_points() {
        for (seed, cells) in (77..).zip([[6, 7], [1, 1], [2, 9], [12, 21]]) {
            let points = [seed, seed ^ 0x5bd1_e995].map(|seed| Lattice { cells, seed });
            for at in 0..4_000_u32 {
                let [u, v] =
                    [0.754_877_7, 0.569_840_3].map(|step: f32| (at as f32 * step) % 1.4 - 0.2);
                let [x, y] =
                    [(u, cells[0]), (v, cells[1])].map(|(place, cells)| place * cells as f32);
                let mut distances = Vec::new();
                for down in -2..=2_i32 {
                    for right in -2..=2_i32 {
                        let cell = |place: f32, aside: i32| place.floor() as i32 + aside;
                        let inside = |cell: i32, cells: u32| cell.rem_euclid(cells as i32) as u32;
                        let column = inside(cell(x, right), cells[0]);
                        let row = inside(cell(y, down), cells[1]);
                        let dx = right as f32 + points[0].value(column, row) - (x - x.floor());
                        let dy = down as f32 + points[1].value(column, row) - (y - y.floor());
                        distances.push((dx * dx + dy * dy).sqrt());
                    }
                }
                distances.sort_by(f32::total_cmp);
                assert_eq!(
                    plates(cells, seed, u, v),
                    distances[1] - distances[0],
                    "{cells:?} {u} {v}"
                );
            }
        }
    }
}
