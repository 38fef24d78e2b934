//! How much of the sky a place in a crown sees: the leaves of a tree as a cloud on a grid of cells.
//!
//! Leaf area per cell is optical depth (a random leaf stops half of the light that its area meets: Monsi and Saeki 1953, G = 1/2). One sweep from the
//! top layer down adds it up along each of nine directions, straight up and towards eight neighbours of the layer above; what arrives is
//! the mean of exp(−depth), weighted as a level ground would be lit. Cells times nine, whatever the number of leaves. Who asks at the leaves themselves
//! ([`Light::on_each`]) is spared the exponentials of all cells without any: they take longer than the sweep, and most of a crown's cells are empty.

use glam::{UVec3, Vec3};

/// Cells along the longest side.
const CELLS: f32 = 40.0;

/// The depth by which leaves of one cell shade each other at most, at which an eighth of the light is left: however many there are, those on top are lit. A cell is told
/// as one, and so all of it.
const OWN_SHADE: f32 = 1.5;

/// Directions: steps to a neighbour's column for each layer up.
const DIRECTIONS: [[isize; 2]; 9] = [
    [0, 0],
    [1, 0],
    [-1, 0],
    [0, 1],
    [0, -1],
    [1, 1],
    [1, -1],
    [-1, 1],
    [-1, -1],
];

/// Light on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    low: Vec3,
    cell: f32,
    size: UVec3,
    /// 0 (dark) to 1 (open sky), x fastest, then z, then y.
    arrives: Vec<f32>,
}

impl Light {
    /// The light among leaves: where they are, and the area of each in square metres. None where there are none.
    #[must_use]
    pub fn among(leaves: &[(Vec3, f32)]) -> Option<Self> {
        let mut light = Self::depths(leaves)?;
        let all = vec![true; light.arrives.len()];
        light.sweep(&all);
        Some(light)
    }

    /// What of the sky's light reaches each of the leaves among which it is, 0 to 1: what [`Self::at`] says of them.
    #[must_use]
    pub fn on_each(leaves: &[(Vec3, f32)]) -> Vec<f32> {
        let Some(mut light) = Self::depths(leaves) else {
            return vec![1.0; leaves.len()];
        };
        let mut asked = vec![false; light.arrives.len()];
        for (place, _) in leaves {
            if let Some(cell) = asked.get_mut(light.cell_of(*place)) {
                *cell = true;
            }
        }
        light.sweep(&asked);
        leaves.iter().map(|(place, _)| light.at(*place)).collect()
    }

    /// The grid with each cell's own depth, through which no light has come yet.
    fn depths(leaves: &[(Vec3, f32)]) -> Option<Self> {
        let (low, high) = leaves.iter().filter(|(place, _)| place.is_finite()).fold(
            (Vec3::INFINITY, Vec3::NEG_INFINITY),
            |(low, high), (place, _)| (low.min(*place), high.max(*place)),
        );
        let longest = (high - low).max_element();
        if !longest.is_finite() || longest < 0.0 {
            return None;
        }
        // A leaf must not darken its own cell: none is smaller than the largest leaf is wide.
        let widest = leaves
            .iter()
            .fold(0.0_f32, |most, (_, area)| most.max(*area))
            .sqrt();
        let cell = (longest / CELLS).max(2.0 * widest.min(1e6)).max(1e-6);
        let size = ((high - low) / cell).floor().as_uvec3() + UVec3::ONE;
        let mut light = Self {
            low,
            cell,
            size,
            arrives: vec![0.0; (size.x * size.y * size.z) as usize],
        };
        for (place, area) in leaves {
            let at = light.cell_of(*place);
            if let Some(depth) = light.arrives.get_mut(at) {
                *depth += 0.5 * area.max(0.0) / (cell * cell);
            }
        }
        Some(light)
    }

    /// What of the sky's light reaches a place, 0 to 1; above the leaves all of it, beside and below them what reaches the nearest cell.
    #[must_use]
    pub fn at(&self, place: Vec3) -> f32 {
        #[allow(clippy::cast_precision_loss, reason = "some tens of cells")]
        let top = self.low.y + self.size.y as f32 * self.cell;
        if place.y >= top {
            return 1.0;
        }
        self.arrives
            .get(self.cell_of(place))
            .copied()
            .unwrap_or(1.0)
    }

    /// The cell of a place, the nearest one where it lies outside.
    fn cell_of(&self, place: Vec3) -> usize {
        let last = (self.size - UVec3::ONE).as_vec3();
        // What is left of the point is cut off.
        let at = ((place - self.low) / self.cell).clamp(Vec3::ZERO, last);
        let at = at.as_uvec3();
        ((at.y * self.size.z + at.z) * self.size.x + at.x) as usize
    }

    /// Turns depths by cell into light by cell, in those cells that are asked for.
    fn sweep(&mut self, asked: &[bool]) {
        let [width, depth] = [self.size.x as usize, self.size.z as usize];
        let layer = || DIRECTIONS.map(|_| Layer::new(width, depth));
        let (mut above, mut here) = (layer(), layer());
        let ways = DIRECTIONS.map(|[dx, dz]| steps_up(dx, dz));
        let weights: f32 = ways.iter().map(|way| 1.0 / way).sum();
        let mut light = vec![0.0_f32; width];
        // Those of a row that are asked for.
        let mut wanted: Vec<usize> = Vec::with_capacity(width);
        let layers = self.arrives.chunks_exact_mut(width * depth);
        for (cells, asked) in layers.zip(asked.chunks_exact(width * depth)).rev() {
            let rows = cells.chunks_exact_mut(width).zip(asked.chunks_exact(width));
            for (z, (own, asked)) in rows.enumerate() {
                light.fill(0.0);
                wanted.clear();
                if asked.iter().fold(false, |any, asked| any | asked) {
                    wanted.extend((0..width).filter(|x| asked[*x]));
                }
                // All of the row, which is several cells at once: an early end is guessed wrong.
                let is_bare = own.iter().fold(true, |all, d| all & (*d == 0.0));
                let ways = DIRECTIONS.iter().zip(ways);
                for (([dx, dz], way), (above, here)) in ways.zip(above.iter().zip(&mut here)) {
                    let row = z.wrapping_add_signed(*dz).wrapping_add(1);
                    // Half of the rows have nothing above them.
                    if is_bare && above.is_clear[row] {
                        here.clear(z + 1);
                        if !wanted.is_empty() {
                            light.iter_mut().for_each(|light| *light += 1.0 / way);
                        }
                        continue;
                    }
                    let from = above.row(row, *dx);
                    here.is_clear[z + 1] = false;
                    for ((own, before), into) in own.iter().zip(from).zip(here.own_row(z + 1)) {
                        *into = before + way * own;
                    }
                    for &x in &wanted {
                        // Half of a cell's own leaves lie over its middle.
                        let through = from[x] + way * (0.5 * own[x]).min(OWN_SHADE);
                        let arrives = if through > 0.0 { (-through).exp() } else { 1.0 };
                        light[x] += arrives / way;
                    }
                }
                for &x in &wanted {
                    own[x] = light[x] / weights;
                }
            }
            std::mem::swap(&mut above, &mut here);
        }
    }
}

/// Depths along one direction in the cells of a layer, with nothing all around, so that every cell has eight neighbours.
struct Layer {
    width: usize,
    depths: Vec<f32>,
    /// Of each row whether it is known that all in it is 0.
    is_clear: Vec<bool>,
}

impl Layer {
    fn new(width: usize, depth: usize) -> Self {
        Self {
            width,
            depths: vec![0.0; (width + 2) * (depth + 2)],
            is_clear: vec![true; depth + 2],
        }
    }

    /// The cells of a row, so many beside its own.
    fn row(&self, row: usize, aside: isize) -> &[f32] {
        let first = row * (self.width + 2) + 1;
        &self.depths[first.wrapping_add_signed(aside)..][..self.width]
    }

    fn own_row(&mut self, row: usize) -> &mut [f32] {
        &mut self.depths[row * (self.width + 2) + 1..][..self.width]
    }

    fn clear(&mut self, row: usize) {
        if !std::mem::replace(&mut self.is_clear[row], true) {
            self.own_row(row).fill(0.0);
        }
    }
}

/// How long the way through one layer is, in cells.
fn steps_up(dx: isize, dz: isize) -> f32 {
    #[allow(clippy::cast_precision_loss, reason = "1, 2 or 3")]
    let squares = (1 + dx * dx + dz * dz) as f32;
    squares.sqrt()
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_precision_loss,
        clippy::cast_sign_loss,
        reason = "tests"
    )]
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn it_is_darker_below_leaves_and_open_beside_them() {
        // A flat roof of leaves over empty space.
        let mut leaves = Vec::new();
        for x in 0..40 {
            for z in 0..40 {
                leaves.push((Vec3::new(x as f32, 10.0, z as f32) * 0.1, 0.02));
            }
        }
        leaves.push((Vec3::new(2.0, 0.0, 2.0), 0.0));
        let light = Light::among(&leaves).unwrap();
        let [under, edge] = [[2.0, 0.1, 2.0], [0.0, 0.1, 0.0]].map(|p| light.at(Vec3::from(p)));
        // Area index 2: half of it stops light, so straight down exp(−1) arrives, aside less, and from beside the roof more.
        assert!(
            under < edge && (0.2..0.6).contains(&under),
            "{under} {edge}"
        );
        assert!(light.at(Vec3::new(2.0, 20.0, 2.0)) > light.at(Vec3::new(2.0, 0.9, 2.0)));
    }

    proptest! {
        /// What arrives in each cell is what its nine rays to the sky say, one by one.
        #[test]
        fn as_each_ray_says(
            [x, y, z] in prop::array::uniform3(1_u32..6),
            depths in prop::collection::vec(prop_oneof![Just(0.0_f32), 0.0_f32..2.0, 2.0_f32..1e6], 125),
        ) {
            let size = UVec3::new(x, y, z);
            let count = (x * y * z) as usize;
            let mut light = Light { low: Vec3::ZERO, cell: 1.0, size, arrives: depths[..count].to_vec() };
            light.sweep(&vec![true; count]);
            let depth = |at: [i32; 3]| {
                let inside = at.iter().zip(size.to_array()).all(|(at, size)| (0..size as i32).contains(at));
                let [x, y, z] = at.map(|at| at as usize);
                if inside { depths[(y * size.z as usize + z) * size.x as usize + x] } else { 0.0 }
            };
            for at in 0..count {
                let [across, deep] = [size.x as usize, size.z as usize];
                let place = [at % across, at / across / deep, at / across % deep].map(|at| at as i32);
                let own = (0.5 * depth(place)).min(OWN_SHADE);
                let (mut sum, mut weights) = (0.0, 0.0);
                for [dx, dz] in DIRECTIONS.map(|way| way.map(|step| step as i32)) {
                    let way = ((1 + dx * dx + dz * dz) as f32).sqrt();
                    let up = |step: i32| depth([place[0] + step * dx, place[1] + step, place[2] + step * dz]);
                    let through: f32 = own + (1..size.y as i32).map(up).sum::<f32>();
                    sum += (-way * through).exp() / way;
                    weights += 1.0 / way;
                }
                prop_assert!((light.arrives[at] - sum / weights).abs() < 1e-5);
            }
        }
    }

    proptest! {
        /// Who asks at the leaves alone is told the same, bit for bit.
        #[test]
        fn on_each_leaf_as_in_its_cell(
            places in prop::collection::vec(prop::array::uniform3(-3.0_f32..3.0), 0..60),
            areas in prop::collection::vec(prop_oneof![Just(0.0_f32), 0.0_f32..0.1], 60),
        ) {
            let leaves: Vec<_> = places.into_iter().map(Vec3::from).zip(areas).collect();
            let light = Light::among(&leaves);
            let at = |(place, _): &(Vec3, f32)| light.as_ref().map_or(1.0, |light| light.at(*place));
            prop_assert_eq!(Light::on_each(&leaves), leaves.iter().map(at).collect::<Vec<_>>());
        }
    }

    #[test]
    fn more_leaves_let_less_light_through_and_none_let_all() {
        let of = |area: f32| {
            let leaves: Vec<_> = (0..1000)
                .map(|i| {
                    let [x, y, z] = [i % 10, i / 10 % 10, i / 100].map(|n| n as f32 * 0.1);
                    (Vec3::new(x, y, z), area)
                })
                .collect();
            Light::among(&leaves)
                .unwrap()
                .at(Vec3::new(0.45, 0.0, 0.45))
        };
        assert!((of(0.0) - 1.0).abs() < 1e-6);
        assert!(of(0.001) > of(0.003) && of(0.003) > of(0.01));
        assert_eq!(Light::among(&[]), None);
        let one = Light::among(&[(Vec3::ONE, 1.0)]).unwrap();
        assert!((0.0..1.0).contains(&one.at(Vec3::ONE)));
    }

    #[test]
    fn what_is_on_top_is_lit_however_much_there_is() {
        for area in [0.01, 1.0, 1e4] {
            let leaves: Vec<_> = (0..20).map(|y| (Vec3::Y * y as f32, area)).collect();
            let light = Light::on_each(&leaves);
            assert!(light[19] > 0.1, "{area}: {light:?}");
            let darker = light.iter().zip(&light[1..]).all(|(low, high)| low <= high);
            assert!(darker, "{area}: {light:?}");
        }
    }

    #[test]
    fn hostile_places_are_no_panic() {
        let light = Light::among(&[(Vec3::NAN, 1.0), (Vec3::ZERO, f32::NAN), (Vec3::Y, 1.0)]);
        let light = light.unwrap();
        for place in [Vec3::NAN, Vec3::INFINITY, Vec3::splat(-1e30)] {
            assert!((0.0..=1.0).contains(&light.at(place)), "{place}");
        }
        assert!(
            Light::among(&[(Vec3::splat(f32::MAX), 1.0), (Vec3::splat(f32::MIN), 1.0)]).is_none()
        );
    }
}
