//! The guide's pictures: compared with what the program draws now, or drawn anew (`UPDATE_SNAPSHOTS=1`).

use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{RgbImage, imageops};

/// What lies between two stills, pixels.
const GAP: u32 = 4;

/// Stills beside each other.
pub(super) fn strip(stills: &[RgbImage]) -> RgbImage {
    let count = u32::try_from(stills.len()).unwrap();
    let (width, height) = stills[0].dimensions();
    let white = image::Rgb([255; 3]);
    let mut strip = RgbImage::from_pixel(count * (width + GAP) - GAP, height, white);
    for (n, still) in (0..).zip(stills) {
        imageops::replace(&mut strip, still, n * i64::from(width + GAP), 0);
    }
    strip
}

/// Pixels that are clearly of another colour.
pub(super) fn far(one: &RgbImage, other: &RgbImage) -> usize {
    assert_eq!(one.dimensions(), other.dimensions());
    let pairs = one.pixels().zip(other.pixels());
    let far = |a: &image::Rgb<u8>, b: &image::Rgb<u8>| (0..3).any(|n| a.0[n].abs_diff(b.0[n]) > 32);
    pairs.filter(|(a, b)| far(a, b)).count()
}

/// Compares with the guide's picture, or draws it anew.
pub(super) fn compare(name: &str, strip: &RgbImage) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs/src/images")
        .join(format!("{name}.png"));
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some_and(|value| value == "1") {
        save(&file, strip);
    }
    let shown = image::open(&file).unwrap().to_rgb8();
    let far = far(strip, &shown);
    let part = strip.pixels().len() / 50;
    assert!(far < part, "{name}: {far} pixels are not as in the guide");
}

/// In steps of four, which nobody sees, a picture takes less than half the room.
fn save(file: &Path, strip: &RgbImage) {
    const MOST_BYTES: u64 = 150_000;
    let mut coarse = strip.clone();
    for byte in coarse.iter_mut() {
        *byte = (*byte & 0b1111_1100) | 0b10;
    }
    let into = std::fs::File::create(file).unwrap();
    let png = PngEncoder::new_with_quality(into, CompressionType::Best, FilterType::Adaptive);
    coarse.write_with_encoder(png).unwrap();
    let bytes = std::fs::metadata(file).unwrap().len();
    assert!(bytes <= MOST_BYTES, "{}: {bytes} bytes", file.display());
}
