//! Pictures of bark with fewer pixels, for files that are to be small.
//!
//! Sides are halved, each pixel the mean of four, so that the tile still repeats without a seam; means and square roots alone, so no machine differs.

use std::sync::OnceLock;

use glam::Vec3;
use image::{ImageBuffer, Pixel};

use super::{Bark, BarkMaps};
use crate::tree::TreeError;

impl Bark {
    /// The same, with no more pixels a side than `most`, and as many as halving gives.
    ///
    /// # Errors
    /// As [`Self::pngs`].
    pub fn pngs_within(self, most: u32) -> Result<&'static [Vec<u8>; 3], TreeError> {
        /// Each side, from the whole picture's to a pixel.
        const HALVES: usize = 13;
        static PACKED: [[OnceLock<[Vec<u8>; 3]>; HALVES]; Bark::ALL.len()] =
            [const { [const { OnceLock::new() }; HALVES] }; Bark::ALL.len()];
        let (mut halves, mut side) = (0, self.maps().colour.width());
        while side > most.max(1) && halves + 1 < HALVES {
            (halves, side) = (halves + 1, side / 2);
        }
        if halves == 0 {
            return self.pngs();
        }
        let packed = &PACKED[self as usize][halves];
        if let Some(pngs) = packed.get() {
            return Ok(pngs);
        }
        let mut maps = self.maps().halved();
        for _ in 1..halves {
            maps = maps.halved();
        }
        let pngs = maps.pngs()?;
        Ok(packed.get_or_init(|| pngs))
    }
}

impl BarkMaps {
    /// With half as many pixels a side: each is the mean of four. A side of one pixel stays.
    #[must_use]
    pub fn halved(&self) -> Self {
        let flat = |normal: [f32; 3]| {
            let normal = Vec3::from(normal) - 127.5;
            (normal.normalize_or(Vec3::Z) * 127.5 + 127.5).to_array()
        };
        Self {
            colour: halved::<_, 4>(&self.colour, |mean| mean),
            normal: halved(&self.normal, flat),
            roughness: halved::<_, 3>(&self.roughness, |mean| mean),
        }
    }
}

/// A picture with half as many pixels a side, its means made something of.
fn halved<P, const N: usize>(
    picture: &ImageBuffer<P, Vec<u8>>,
    of: impl Fn([f32; N]) -> [f32; N],
) -> ImageBuffer<P, Vec<u8>>
where
    P: Pixel<Subpixel = u8>,
{
    let [width, height] = [picture.width(), picture.height()].map(|side| (side / 2).max(1));
    ImageBuffer::from_fn(width, height, |x, y| {
        let four = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]| {
            let across = (2 * x + right).min(picture.width() - 1);
            picture.get_pixel(across, (2 * y + down).min(picture.height() - 1))
        });
        let mean = std::array::from_fn(|part| {
            let sum: f32 = four
                .iter()
                .map(|pixel| f32::from(pixel.channels()[part]))
                .sum();
            sum / 4.0
        });
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 255, and `as` saturates"
        )]
        let bytes = of(mean).map(|part| part.round() as u8);
        *P::from_slice(&bytes)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::*;

    #[test]
    fn pictures_are_no_larger_than_asked_and_keep_their_mean() {
        let whole = Bark::Oak.maps();
        let half = whole.halved();
        assert_eq!(half.colour.dimensions(), (128, 128));
        let mean = |picture: &image::RgbImage| {
            let sum: f64 = picture.pixels().map(|pixel| f64::from(pixel.0[1])).sum();
            sum / f64::from(picture.width() * picture.height())
        };
        assert!((mean(&half.roughness) - mean(&whole.roughness)).abs() < 0.5);
        for normal in half.normal.pixels() {
            let normal = Vec3::from(normal.0.map(f32::from)) - 127.5;
            assert!((normal.length() - 127.5).abs() < 2.0);
        }
        for (most, side) in [
            (1000, 256),
            (256, 256),
            (255, 128),
            (64, 64),
            (1, 1),
            (0, 1),
        ] {
            for png in Bark::Oak.pngs_within(most).unwrap() {
                let picture = image::load_from_memory(png).unwrap();
                assert_eq!((picture.width(), picture.height()), (side, side));
            }
        }
    }
}
