//! A bark texture made by arithmetic: tileable in both directions, the same bytes on every machine.
//!
//! Plates between fissures are the cells of Worley noise, stretched along the trunk and bent by value noise; smaller plates
//! crack the large ones, and fibre, roughness and weathered patches lie over all. (Level lines of value noise alone make blots
//! where the noise is flat.) Only sums, products and square roots (each exactly rounded) are used, no sine or power: no
//! machine differs.

use std::sync::OnceLock;

use glam::Vec3;
use image::{Rgb, RgbImage, Rgba, RgbaImage};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::TreeError;

mod noise;
mod smaller;

use self::noise::{Lattice, plates, smooth};

/// Kinds of bark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Bark {
    /// Brown plates: any tree.
    #[default]
    Plain,
    /// Grey-brown plates that lift at their edges.
    Maple,
    /// Deep grey furrows.
    Oak,
    /// White, with dark lenticels across.
    Birch,
    /// Red-brown scales.
    Spruce,
    /// A net of pale ridges.
    Willow,
    /// Smooth grey-brown, lightly scaled.
    Apple,
    /// A green stalk.
    Stalk,
    /// Green ribs.
    Cactus,
}

impl Bark {
    /// All, in the order of their numbers in shaders.
    pub const ALL: [Self; 9] = [
        Self::Plain,
        Self::Maple,
        Self::Oak,
        Self::Birch,
        Self::Spruce,
        Self::Willow,
        Self::Apple,
        Self::Stalk,
        Self::Cactus,
    ];

    /// Its name in grammars.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Maple => "maple",
            Self::Oak => "oak",
            Self::Birch => "birch",
            Self::Spruce => "spruce",
            Self::Willow => "willow",
            Self::Apple => "apple",
            Self::Stalk => "stalk",
            Self::Cactus => "cactus",
        }
    }

    /// Knots in ten radii of old wood: stubs of branches that it has lost.
    #[must_use]
    pub fn knots(self) -> f32 {
        match self {
            Self::Plain | Self::Stalk | Self::Cactus => 0.0,
            Self::Maple | Self::Willow => 0.5,
            Self::Oak | Self::Apple => 0.8,
            Self::Birch => 0.4,
            Self::Spruce => 0.6,
        }
    }

    /// Whether its shoots end in domes, not in points.
    #[must_use]
    pub fn is_round_tipped(self) -> bool {
        self == Self::Cactus
    }

    /// Its pictures, painted once.
    #[must_use]
    pub fn maps(self) -> &'static BarkMaps {
        static PAINTED: [OnceLock<BarkMaps>; Bark::ALL.len()] =
            [const { OnceLock::new() }; Bark::ALL.len()];
        PAINTED[self as usize].get_or_init(|| maps(&self.params()))
    }

    /// Its pictures as [`BarkMaps::pngs`], packed once.
    ///
    /// # Errors
    /// As those.
    pub fn pngs(self) -> Result<&'static [Vec<u8>; 3], TreeError> {
        static PACKED: [OnceLock<[Vec<u8>; 3]>; Bark::ALL.len()] =
            [const { OnceLock::new() }; Bark::ALL.len()];
        let packed = &PACKED[self as usize];
        if let Some(pngs) = packed.get() {
            return Ok(pngs);
        }
        let pngs = self.maps().pngs()?;
        Ok(packed.get_or_init(|| pngs))
    }

    /// How it is painted.
    #[must_use]
    pub fn params(self) -> BarkParams {
        let plain = BarkParams::default();
        match self {
            Self::Plain => plain,
            Self::Maple => BarkParams {
                seed: 11,
                across: 5,
                along: 2,
                wander: 0.7,
                fissure: [62.0, 58.0, 54.0],
                ridge: [150.0, 144.0, 134.0],
                weathered: [172.0, 168.0, 158.0],
                ..plain
            },
            Self::Oak => BarkParams {
                seed: 23,
                across: 7,
                along: 2,
                wander: 1.3,
                relief: 1.5,
                fissure: [34.0, 29.0, 25.0],
                ridge: [118.0, 106.0, 92.0],
                weathered: [138.0, 132.0, 116.0],
                ..plain
            },
            Self::Birch => BarkParams {
                pattern: Pattern::Lenticels,
                seed: 31,
                across: 3,
                along: 9,
                wander: 0.5,
                relief: 0.5,
                fissure: [46.0, 40.0, 36.0],
                ridge: [226.0, 221.0, 210.0],
                weathered: [206.0, 186.0, 164.0],
                young: [104.0, 74.0, 56.0],
                ..plain
            },
            Self::Spruce => BarkParams {
                seed: 41,
                across: 9,
                along: 7,
                wander: 0.9,
                relief: 0.9,
                fissure: [52.0, 36.0, 30.0],
                ridge: [128.0, 98.0, 82.0],
                weathered: [146.0, 126.0, 110.0],
                young: [124.0, 92.0, 58.0],
                ..plain
            },
            Self::Willow => BarkParams {
                seed: 53,
                across: 5,
                along: 1,
                wander: 1.6,
                relief: 1.3,
                fissure: [62.0, 54.0, 42.0],
                ridge: [150.0, 136.0, 110.0],
                weathered: [168.0, 160.0, 134.0],
                young: [150.0, 140.0, 72.0],
                ..plain
            },
            Self::Apple => BarkParams {
                seed: 61,
                across: 6,
                along: 5,
                wander: 0.8,
                relief: 0.6,
                fissure: [70.0, 60.0, 54.0],
                ridge: [126.0, 112.0, 100.0],
                weathered: [150.0, 146.0, 130.0],
                young: [110.0, 70.0, 58.0],
                ..plain
            },
            Self::Stalk => BarkParams {
                pattern: Pattern::Fibres,
                seed: 71,
                across: 6,
                along: 1,
                wander: 0.2,
                relief: 0.2,
                fissure: [62.0, 92.0, 36.0],
                ridge: [96.0, 138.0, 54.0],
                weathered: [118.0, 148.0, 70.0],
                young: [104.0, 150.0, 60.0],
                roughness: [0.6, 0.5],
                ..plain
            },
            Self::Cactus => BarkParams {
                pattern: Pattern::Ribs,
                seed: 83,
                across: 16,
                along: 3,
                wander: 0.0,
                relief: 2.2,
                fissure: [40.0, 72.0, 38.0],
                ridge: [104.0, 146.0, 84.0],
                weathered: [140.0, 168.0, 116.0],
                young: [104.0, 150.0, 84.0],
                roughness: [0.7, 0.55],
                ..plain
            },
        }
    }
}

/// What lies between furrows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pattern {
    /// Plates, cracked.
    #[default]
    Plates,
    /// Smooth, with dark strokes across and torn patches.
    Lenticels,
    /// Fine fibres along.
    Fibres,
    /// Round ribs along.
    Ribs,
}

/// What the bark looks like. Lengths are in pixels or tiles of the texture; colours are sRGB, 0 to 255.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarkParams {
    /// Width and height in pixels, a power of two for mipmaps.
    pub size: u32,
    /// Which of many barks.
    pub seed: u32,
    /// What lies between furrows.
    pub pattern: Pattern,
    /// Noise cells across the tile, round the trunk.
    pub across: u32,
    /// Noise cells along the tile, up the trunk: fewer than `across` make long fissures.
    pub along: u32,
    /// How far the fissures wander, in cells.
    pub wander: f32,
    /// How deep furrows are, in parts of what is usual.
    pub relief: f32,
    /// At the bottom of a fissure.
    pub fissure: [f32; 3],
    /// Of the ridges.
    pub ridge: [f32; 3],
    /// Of weathered patches on ridges.
    pub weathered: [f32; 3],
    /// Of twigs too young for bark.
    pub young: [f32; 3],
    /// At the bottom of a fissure and on a ridge, 0 to 1.
    pub roughness: [f32; 2],
}

impl Default for BarkParams {
    fn default() -> Self {
        Self {
            size: 256,
            seed: 7,
            pattern: Pattern::Plates,
            across: 9,
            along: 1,
            wander: 0.8,
            relief: 0.8,
            fissure: [56.0, 44.0, 34.0],
            ridge: [136.0, 112.0, 90.0],
            weathered: [150.0, 136.0, 116.0],
            young: [112.0, 104.0, 78.0],
            roughness: [1.0, 0.8],
        }
    }
}

/// A bark as three pictures of one size, tileable; x runs round the trunk, y along it.
#[derive(Clone, Debug, PartialEq)]
pub struct BarkMaps {
    /// sRGB colour, and in the fourth part the height: 0 in fissures, 255 on ridges.
    pub colour: RgbaImage,
    /// glTF's normal map: tangent space, +Y up the picture.
    pub normal: RgbImage,
    /// glTF's metallic-roughness map: roughness in green, metal (none) in blue, occlusion in red.
    pub roughness: RgbImage,
}

/// How steep a normal map is: heights of 0 to 1 across so many parts of the tile.
const STEEPNESS: f32 = 0.045;

/// Paints a bark.
#[must_use]
pub fn maps(params: &BarkParams) -> BarkMaps {
    let size = params.size.clamp(1, 4096);
    #[allow(clippy::cast_precision_loss, reason = "at most 4096")]
    let place = |pixel: u32| pixel as f32 / size as f32;
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to a byte"
    )]
    let byte = |part: f32| part.clamp(0.0, 255.0).round() as u8;
    let rows: Vec<Vec<([f32; 3], f32)>> = (0..size)
        .into_par_iter()
        .map(|y| (0..size).map(|x| params.spot(place(x), place(y))).collect())
        .collect();
    let height = |x: u32, y: u32| rows[(y % size) as usize][(x % size) as usize].1;
    let colour = RgbaImage::from_fn(size, size, |x, y| {
        let ([r, g, b], height) = rows[y as usize][x as usize];
        Rgba([r, g, b, 255.0 * height].map(byte))
    });
    #[allow(clippy::cast_precision_loss, reason = "at most 4096")]
    let steep = STEEPNESS * params.relief * size as f32;
    let normal = RgbImage::from_fn(size, size, |x, y| {
        let across = height(x + 1, y) - height(x + size - 1, y);
        let down = height(x, y + 1) - height(x, y + size - 1);
        let normal = Vec3::new(-across * steep * 0.5, down * steep * 0.5, 1.0).normalize();
        Rgb((normal * 127.5 + 127.5).to_array().map(byte))
    });
    let [low, high] = params.roughness;
    let roughness = RgbImage::from_fn(size, size, |x, y| {
        let height = height(x, y);
        let rough = low + height * (high - low);
        Rgb([0.45 + 0.55 * height, rough, 0.0].map(|part| byte(255.0 * part)))
    });
    BarkMaps {
        colour,
        normal,
        roughness,
    }
}

impl BarkMaps {
    /// The three pictures as PNG files: colour (without heights), normal, roughness.
    ///
    /// # Errors
    /// [`TreeError::Texture`] when the encoder fails, which it has no reason to.
    pub fn pngs(&self) -> Result<[Vec<u8>; 3], TreeError> {
        let colour = image::DynamicImage::from(self.colour.clone()).to_rgb8();
        let png = |picture: &RgbImage| {
            let mut bytes = Vec::new();
            picture
                .write_to(
                    &mut std::io::Cursor::new(&mut bytes),
                    image::ImageFormat::Png,
                )
                .map_err(|error| TreeError::Texture(error.to_string()))?;
            Ok::<_, TreeError>(bytes)
        };
        Ok([png(&colour)?, png(&self.normal)?, png(&self.roughness)?])
    }
}

impl BarkParams {
    /// sRGB colour, 0 to 255, and height, 0 to 1, at a place of the tile, each 0 to 1.
    fn spot(&self, u: f32, v: f32) -> ([f32; 3], f32) {
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
        let rough = noise([8 * across, 5 * along], 5, 4, bent_u, bent_v) - 0.5;
        let fibre = noise([12 * across, 3 * along], 6, 3, bent_u, bent_v) - 0.5;
        let patch = noise([4, 3], 8, 4, u, v) - 0.5;

        let (height, light) = match self.pattern {
            Pattern::Plates => {
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
                let height = furrow * (0.6 + 0.4 * crack) + 0.5 * rough * furrow;
                (height, 0.86 + 0.55 * rough + 0.45 * fibre + 0.16 * height)
            }
            Pattern::Lenticels => {
                // Short strokes across where a stretched noise is highest, and a few torn patches.
                let strokes = noise([2 * across, 5 * along], 3, 2, bent_u, bent_v);
                let stroke = smooth(((strokes - 0.66) * 9.0).clamp(0.0, 1.0));
                let torn = smooth(((patch + 0.35 * rough - 0.24) * 7.0).clamp(0.0, 1.0));
                let height = 1.0 - (0.75 * stroke).max(0.9 * torn) + 0.12 * rough;
                (height, 0.97 + 0.14 * rough + 0.08 * fibre)
            }
            Pattern::Fibres => (0.5 + fibre + 0.3 * rough, 0.98 + 0.2 * fibre),
            Pattern::Ribs => {
                #[allow(clippy::cast_precision_loss, reason = "a few ribs")]
                let phase = (u * across as f32).fract() - 0.5;
                let round = 1.0 - (2.0 * phase).powi(2);
                (round + 0.06 * rough, 0.9 + 0.25 * rough + 0.1 * round)
            }
        };
        let height = height.clamp(0.0, 1.0);
        let weather = smooth((patch * 3.0 + rough).clamp(0.0, 1.0)) * height;
        let colour = std::array::from_fn(|i| {
            let ridge = self.ridge[i] + weather * (self.weathered[i] - self.ridge[i]);
            (self.fissure[i] + height * (ridge - self.fissure[i])) * light
        });
        (colour, height)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]

    use super::*;

    /// The step from the last column (row) to the first is no larger than steps inside: no seam.
    #[test]
    fn the_texture_has_no_seam() {
        let image = maps(&BarkParams::default()).colour;
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
        let image = maps(&BarkParams::default()).colour;
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
    fn the_same_seed_gives_the_same_files_and_another_gives_others() {
        let [a, b] = [BarkParams::default(); 2].map(|params| maps(&params).pngs().unwrap());
        assert_eq!(a, b);
        let other = BarkParams {
            seed: 8,
            ..BarkParams::default()
        };
        assert_ne!(a, maps(&other).pngs().unwrap());
        let bytes: usize = a.iter().map(Vec::len).sum();
        assert!(bytes < 450_000, "{bytes} bytes in every GLB");
    }

    /// Each kind: no seam in any picture, normals of length 1 that point out, its own colour.
    #[test]
    fn every_bark_tiles_and_has_normals_of_unit_length() {
        let mut means = Vec::new();
        for bark in Bark::ALL {
            let BarkMaps {
                colour,
                normal,
                roughness,
            } = maps(&bark.params());
            let size = colour.width();
            assert!(size.is_power_of_two());
            let seam = |step: &dyn Fn(u32, u32) -> f64| {
                let most = (0..size - 1).map(|x| step(x, x + 1)).fold(0.0, f64::max);
                assert!(
                    step(size - 1, 0) <= 1.05 * most + 1.0,
                    "{bark:?} has a seam"
                );
            };
            let apart = |a: &[u8], b: &[u8]| {
                a.iter()
                    .zip(b)
                    .map(|(a, b)| f64::from(a.abs_diff(*b)))
                    .sum::<f64>()
            };
            seam(&|a, b| {
                (0..size)
                    .map(|y| apart(&colour.get_pixel(a, y).0, &colour.get_pixel(b, y).0))
                    .sum()
            });
            seam(&|a, b| {
                (0..size)
                    .map(|x| apart(&colour.get_pixel(x, a).0, &colour.get_pixel(x, b).0))
                    .sum()
            });
            seam(&|a, b| {
                (0..size)
                    .map(|y| apart(&normal.get_pixel(a, y).0, &normal.get_pixel(b, y).0))
                    .sum()
            });
            for pixel in normal.pixels() {
                let n = Vec3::from(pixel.0.map(f32::from)) / 127.5 - 1.0;
                assert!((n.length() - 1.0).abs() < 0.02 && n.z > 0.0, "{bark:?} {n}");
            }
            assert!(roughness.pixels().all(|p| p.0[1] > 100 && p.0[2] == 0));
            let mean: [f64; 3] = std::array::from_fn(|i| {
                colour.pixels().map(|p| f64::from(p.0[i])).sum::<f64>() / f64::from(size * size)
            });
            means.push(mean);
        }
        for (at, a) in means.iter().enumerate() {
            for b in &means[..at] {
                let apart: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
                assert!(apart > 12.0, "two barks of one colour: {a:?} {b:?}");
            }
        }
    }
}
