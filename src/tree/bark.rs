//! A bark texture made by arithmetic: tileable in both directions, the same bytes on every machine.
//!
//! Plates between fissures are the cells of Worley noise, stretched along the trunk and bent by value noise; smaller plates
//! crack the large ones, and fibre, roughness and weathered patches lie over all. (Level lines of value noise alone make blots
//! where the noise is flat.) Only sums, products and square roots (each exactly rounded) are used, no sine or power: no
//! machine differs.

use image::{Rgb, RgbImage};

use super::TreeError;

/// What the bark looks like. Lengths are in pixels or tiles of the texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarkParams {
    /// Width and height in pixels, a power of two for mipmaps.
    pub size: u32,
    /// Which of many barks.
    pub seed: u32,
    /// Noise cells across the tile, round the trunk.
    pub across: u32,
    /// Noise cells along the tile, up the trunk: fewer than `across` make long fissures.
    pub along: u32,
    /// How far the fissures wander, in cells.
    pub wander: f32,
    /// sRGB colour at the bottom of a fissure.
    pub fissure: [f32; 3],
    /// sRGB colour of the ridges.
    pub ridge: [f32; 3],
    /// sRGB colour of weathered patches on ridges.
    pub weathered: [f32; 3],
}

impl Default for BarkParams {
    fn default() -> Self {
        Self {
            size: 256,
            seed: 7,
            across: 6,
            along: 2,
            wander: 1.1,
            fissure: [44.0, 32.0, 24.0],
            ridge: [136.0, 111.0, 88.0],
            weathered: [150.0, 136.0, 116.0],
        }
    }
}

/// Paints the bark: x runs round the trunk, y along it.
pub fn texture(params: &BarkParams) -> RgbImage {
    let size = params.size.clamp(1, 4096);
    #[allow(clippy::cast_precision_loss, reason = "at most 4096")]
    let place = |pixel: u32| pixel as f32 / size as f32;
    RgbImage::from_fn(size, size, |x, y| {
        let color = params.color(place(x), place(y));
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to a byte"
        )]
        Rgb(color.map(|part| part.clamp(0.0, 255.0).round() as u8))
    })
}

/// [`texture`] as a PNG file.
///
/// # Errors
/// [`TreeError::Texture`] when the encoder fails, which it has no reason to.
pub fn png(params: &BarkParams) -> Result<Vec<u8>, TreeError> {
    let mut bytes = Vec::new();
    texture(params)
        .write_to(
            &mut std::io::Cursor::new(&mut bytes),
            image::ImageFormat::Png,
        )
        .map_err(|error| TreeError::Texture(error.to_string()))?;
    Ok(bytes)
}

impl BarkParams {
    /// sRGB colour, 0 to 255, at a place of the tile, each 0 to 1.
    fn color(&self, u: f32, v: f32) -> [f32; 3] {
        let noise = |cells: [u32; 2], layer: u32, octaves: u32, u: f32, v: f32| {
            Lattice {
                cells,
                seed: self.seed.wrapping_add(layer),
            }
            .octaves(u, v, octaves)
        };
        let [across, along] = [self.across.max(1), self.along.max(1)];
        #[allow(clippy::cast_precision_loss, reason = "a few cells")]
        let [cell_u, cell_v] = [self.wander / across as f32, self.wander / along as f32];

        // Bend the plane, so that no fissure runs straight.
        let bent_u = u + cell_u * (noise([across, 3 * along], 1, 4, u, v) - 0.5);
        let bent_v = v + cell_v * (noise([across, along], 2, 3, u, v) - 0.5);

        // Plates between fissures; lesser plates crack the large ones.
        let large = plates([across, along], self.seed.wrapping_add(3), bent_u, bent_v);
        let small = plates(
            [2 * across, 3 * along],
            self.seed.wrapping_add(4),
            bent_u,
            bent_v,
        );
        let furrow = smooth((large * 2.6).min(1.0));
        let crack = smooth((small * 4.0).min(1.0));
        let rough = noise([8 * across, 5 * along], 5, 4, bent_u, bent_v) - 0.5;
        let fibre = noise([12 * across, 3 * along], 6, 3, bent_u, bent_v) - 0.5;
        let patch = noise([4, 3], 8, 4, u, v) - 0.5;

        let height = (furrow * (0.6 + 0.4 * crack) + 0.5 * rough * furrow).clamp(0.0, 1.0);
        let light = 0.86 + 0.55 * rough + 0.45 * fibre + 0.16 * height;
        let weather = smooth((patch * 3.0 + rough).clamp(0.0, 1.0)) * height;
        std::array::from_fn(|i| {
            let ridge = self.ridge[i] + weather * (self.weathered[i] - self.ridge[i]);
            (self.fissure[i] + height * (ridge - self.fissure[i])) * light
        })
    }
}

/// How far a place lies from the border of its plate, in cells: 0 on the border. Plates are the regions nearest to one random
/// point in each lattice cell (Worley's F2 − F1: SIGGRAPH 1996, "A Cellular Texture Basis Function"), periodic like [`Lattice`].
fn plates(cells: [u32; 2], seed: u32, u: f32, v: f32) -> f32 {
    let points = [seed, seed ^ 0x5bd1_e995].map(|seed| Lattice { cells, seed });
    let [x, y] = [(u, cells[0]), (v, cells[1])].map(|(place, cells)| {
        #[allow(clippy::cast_precision_loss, reason = "a few cells")]
        let place = place * cells as f32;
        (place.floor(), place - place.floor())
    });
    let (mut nearest, mut second) = (f32::MAX, f32::MAX);
    for down in [-2.0_f32, -1.0, 0.0, 1.0, 2.0] {
        for right in [-2.0_f32, -1.0, 0.0, 1.0, 2.0] {
            let [column, row] = [(x.0 + right, cells[0]), (y.0 + down, cells[1])]
                .map(|(cell, cells)| wrap(cell, cells));
            let dx = right + points[0].value(column, row) - x.1;
            let dy = down + points[1].value(column, row) - y.1;
            let distance = (dx * dx + dy * dy).sqrt();
            second = second.min(nearest.max(distance));
            nearest = nearest.min(distance);
        }
    }
    second - nearest
}

/// A cell's number, brought into the tile.
fn wrap(cell: f32, cells: u32) -> u32 {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "a place in or near the tile"
    )]
    let index = cell as i32;
    index.rem_euclid(cells.cast_signed()).cast_unsigned()
}

/// Value noise that repeats after `cells` lattice cells in each direction of the unit tile.
#[derive(Clone, Copy)]
struct Lattice {
    cells: [u32; 2],
    seed: u32,
}

impl Lattice {
    /// Octaves of halving size and weight, 0 to 1 with mean 1/2.
    fn octaves(self, u: f32, v: f32, octaves: u32) -> f32 {
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
        let [(x, right), (y, down)] =
            [(u, self.cells[0]), (v, self.cells[1])].map(|(place, cells)| {
                #[allow(clippy::cast_precision_loss, reason = "a few hundred cells")]
                let place = place * cells as f32;
                let cell = wrap(place.floor(), cells);
                ((cell, (cell + 1) % cells), smooth(place - place.floor()))
            });
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
fn smooth(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]

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

    /// The step from the last column (row) to the first is no larger than steps inside: no seam.
    #[test]
    fn the_texture_has_no_seam() {
        let image = texture(&BarkParams::default());
        let size = image.width();
        let step = |a: (u32, u32), b: (u32, u32)| {
            let [a, b] = [a, b].map(|(x, y)| image.get_pixel(x, y).0);
            (0..3).map(|i| f64::from(a[i].abs_diff(b[i]))).sum::<f64>()
        };
        let column = |x: u32| {
            (0..size)
                .map(|y| step((x, y), ((x + 1) % size, y)))
                .sum::<f64>()
        };
        let row = |y: u32| {
            (0..size)
                .map(|x| step((x, y), (x, (y + 1) % size)))
                .sum::<f64>()
        };
        let most = |inside: &dyn Fn(u32) -> f64| (0..size - 1).map(inside).fold(0.0, f64::max);
        assert!(
            column(size - 1) <= most(&column),
            "a seam runs up the trunk"
        );
        assert!(row(size - 1) <= most(&row), "a seam runs round the trunk");
    }

    /// Bark: brown, darker in fissures, changing faster round the trunk than along it.
    #[test]
    fn it_looks_like_bark_in_numbers() {
        let image = texture(&BarkParams::default());
        let pixels = f64::from(image.width() * image.height());
        let mean = |i: usize| image.pixels().map(|p| f64::from(p.0[i])).sum::<f64>() / pixels;
        let [red, green, blue] = [mean(0), mean(1), mean(2)];
        assert!(
            red > green && green > blue && red - blue < 70.0,
            "{red} {green} {blue}"
        );
        assert!((60.0..150.0).contains(&red));
        let dark = image.pixels().filter(|p| p.0[0] < 70).count() as f64 / pixels;
        assert!((0.05..0.5).contains(&dark), "{dark} of it is fissure");
        let change = |dx: u32, dy: u32| {
            let size = image.width();
            image
                .enumerate_pixels()
                .map(|(x, y, p)| {
                    f64::from(
                        p.0[0].abs_diff(image.get_pixel((x + dx) % size, (y + dy) % size).0[0]),
                    )
                })
                .sum::<f64>()
        };
        assert!(
            change(4, 0) > 1.4 * change(0, 4),
            "fissures run along the trunk"
        );
    }

    #[test]
    fn the_same_seed_gives_the_same_file_and_another_gives_another() {
        let [a, b] = [BarkParams::default(); 2].map(|params| png(&params).unwrap());
        assert_eq!(a, b);
        assert_ne!(
            a,
            png(&BarkParams {
                seed: 8,
                ..BarkParams::default()
            })
            .unwrap()
        );
        assert!(a.len() < 200_000, "{} bytes in every GLB", a.len());
    }
}
