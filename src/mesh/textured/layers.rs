//! Images of a model as layers of one size, each with its mip levels.

use std::sync::atomic::{AtomicBool, Ordering};

use image::RgbaImage;
use image::imageops::{FilterType, resize};
use rayon::prelude::*;

use crate::mesh::paint::Pixels;
use crate::mesh::srgb::{LINEAR, byte};

/// How much of a model's images is shown.
#[derive(Clone, Copy, Debug)]
pub struct LayerLimits {
    /// Layers at most.
    pub count: u32,
    /// Width and height of a layer.
    pub side_px: u32,
    /// Bytes of all layers with their mip levels.
    pub bytes: u64,
}

impl Default for LayerLimits {
    /// What every device of Vulkan 1.1 takes (256 layers), sides as most have them, and one image of 8,192 × 8,192.
    fn default() -> Self {
        Self {
            count: 256,
            side_px: 8_192,
            bytes: 384 << 20,
        }
    }
}

impl LayerLimits {
    /// A size, halved until so many layers of it fit.
    fn fitting(&self, mut size_px: [u32; 2], layers: usize) -> [u32; 2] {
        let layers = u64::try_from(layers).unwrap_or(u64::MAX);
        while size_px.iter().any(|side| *side > self.side_px)
            || chain_bytes(size_px).saturating_mul(layers) > self.bytes
        {
            if size_px == [1, 1] {
                break;
            }
            size_px = half(size_px);
        }
        size_px
    }

    /// An image, made smaller where it alone would be too large for its share of so many.
    pub(super) fn fitted(&self, pixels: Pixels, images: usize) -> Pixels {
        let most = usize::try_from(self.count).unwrap_or(usize::MAX);
        let size_px = self.fitting(pixels.size_px, images.min(most));
        stretched(pixels, size_px)
    }
}

/// Images one behind the other, all of one size.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layers {
    /// Width and height.
    pub size_px: [u32; 2],
    /// How many there are; 0: no material has an image.
    pub count: u32,
    /// Red, green, blue (sRGB) and alpha, row after row from the top: layer after layer, each with all its mip levels, the largest first.
    pub texels: Vec<u8>,
}

/// A mip level of a layer, and where its texels are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which layer.
    pub layer: u32,
    /// Which of its mip levels.
    pub level: u32,
    /// Width and height.
    pub size_px: [u32; 2],
    /// Its bytes.
    pub bytes: std::ops::Range<usize>,
}

impl Layers {
    /// One image with its mip levels.
    #[must_use]
    pub fn of(image: Pixels) -> Self {
        let mut layers = Self {
            size_px: image.size_px,
            count: 1,
            texels: Vec::new(),
        };
        layers.push(image);
        layers
    }

    /// Adds a level and all smaller ones.
    fn push(&mut self, mut level: Pixels) {
        self.texels.extend_from_slice(&level.rgba);
        while level.size_px != [1, 1] {
            level = halved(&level);
            self.texels.extend_from_slice(&level.rgba);
        }
    }

    /// Stretches all images to the largest one's size, and makes mip levels. `None` when somebody asked to stop.
    pub(super) fn new(
        images: Vec<Pixels>,
        limits: &LayerLimits,
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let largest = images.iter().fold([0, 0], |[width, height], image| {
            [width.max(image.size_px[0]), height.max(image.size_px[1])]
        });
        let size_px = limits.fitting(largest, images.len().max(1));
        let mut layers = Self {
            size_px,
            count: u32::try_from(images.len()).unwrap_or(u32::MAX),
            texels: Vec::new(),
        };
        for image in images {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            layers.push(stretched(image, size_px));
        }
        Some(layers)
    }

    /// How many mip levels each layer has.
    #[must_use]
    pub fn levels(&self) -> u32 {
        chain(self.size_px).map(|_| 1).sum()
    }

    /// All mip levels of all layers, in the order of the texels.
    pub fn parts(&self) -> impl Iterator<Item = Part> {
        let mut first = 0;
        let levels = (0..self.count).flat_map(|layer| {
            let sizes = (0..).zip(chain(self.size_px));
            sizes.map(move |(level, size_px)| (layer, level, size_px))
        });
        levels.map(move |(layer, level, size_px)| {
            let bytes = first..first + usize::try_from(bytes_of(size_px)).unwrap_or(usize::MAX);
            first = bytes.end;
            Part {
                layer,
                level,
                size_px,
                bytes,
            }
        })
    }
}

fn half(size_px: [u32; 2]) -> [u32; 2] {
    size_px.map(|side| (side / 2).max(1))
}

/// The sizes of an image's mip levels.
fn chain(size_px: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    std::iter::successors(Some(size_px), |size| {
        size.iter().any(|side| *side > 1).then(|| half(*size))
    })
}

fn bytes_of([width, height]: [u32; 2]) -> u64 {
    4 * u64::from(width) * u64::from(height)
}

fn chain_bytes(size_px: [u32; 2]) -> u64 {
    chain(size_px).map(bytes_of).sum()
}

/// An image of another size.
fn stretched(pixels: Pixels, size_px: [u32; 2]) -> Pixels {
    if pixels.size_px == size_px {
        return pixels;
    }
    // Halving keeps every texel; what is left is not much.
    let next = half(pixels.size_px);
    if next[0] >= size_px[0] && next[1] >= size_px[1] && next != pixels.size_px {
        return stretched(halved(&pixels), size_px);
    }
    let [width, height] = pixels.size_px;
    let Some(image) = RgbaImage::from_raw(width, height, pixels.rgba) else {
        return Pixels {
            size_px,
            rgba: vec![u8::MAX; usize::try_from(bytes_of(size_px)).unwrap_or_default()],
        };
    };
    let [width, height] = size_px;
    Pixels {
        size_px,
        rgba: resize(&image, width, height, FilterType::Triangle).into_raw(),
    }
}

/// Which texels a coarser one covers along an axis, and how much of each: two, or three where their number is odd (Guthe and Heckbert 2005,
/// "Non-Power-of-Two Mipmap Creation").
fn taps(at: u32, finer: u32, coarser: u32) -> [(u32, f32); 3] {
    let last = finer - 1;
    let tap = |offset: u32| (2 * at + offset).min(last);
    #[expect(clippy::cast_precision_loss, reason = "sides of images")]
    let [at, finer_side, coarser_side] = [at, finer, coarser].map(|n| n as f32);
    if finer == 1 {
        [(0, 1.0), (0, 0.0), (0, 0.0)]
    } else if finer.is_multiple_of(2) {
        [(tap(0), 0.5), (tap(1), 0.5), (last, 0.0)]
    } else {
        [
            (tap(0), (coarser_side - at) / finer_side),
            (tap(1), coarser_side / finer_side),
            (tap(2), (at + 1.0) / finer_side),
        ]
    }
}

/// The next mip level, averaged in linear light: averaged bytes would be too dark.
fn halved(pixels: &Pixels) -> Pixels {
    let [width, height] = pixels.size_px;
    let size_px = half(pixels.size_px);
    let (texels, _) = pixels.rgba.as_chunks::<4>();
    let across: Vec<_> = (0..size_px[0])
        .map(|x| taps(x, width, size_px[0]))
        .collect();
    let row = |y: u32| {
        let down = taps(y, height, size_px[1]);
        across.iter().flat_map(move |across| {
            let mut sums = [0.0_f32; 4];
            for (y, tall) in down {
                let first = y as usize * width as usize;
                for (x, wide) in across {
                    let share = tall * wide;
                    let Some([red, green, blue, alpha]) = texels.get(first + *x as usize) else {
                        continue;
                    };
                    let light = |of: &u8| f32::from(LINEAR[usize::from(*of)]);
                    sums[0] += share * light(red);
                    sums[1] += share * light(green);
                    sums[2] += share * light(blue);
                    sums[3] += share * f32::from(*alpha);
                }
            }
            let [red, green, blue, alpha] = sums.map(|sum| sum.round());
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "averages of such numbers; `as` saturates"
            )]
            let texel = [
                byte(red as u16),
                byte(green as u16),
                byte(blue as u16),
                alpha as u8,
            ];
            texel
        })
    };
    Pixels {
        size_px,
        rgba: (0..size_px[1]).into_par_iter().flat_map_iter(row).collect(),
    }
}
