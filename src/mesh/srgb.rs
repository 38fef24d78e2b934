//! The eye's measure of light and the linear one (IEC 61966-2-1), by tables.

use std::sync::LazyLock;

/// What bytes of sRGB are in linear light, 65535 for 1.
pub(super) static LINEAR: LazyLock<[u16; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| short(linear(byte as f64 / 255.0))));

/// The bytes that are nearest to linear light.
static BYTES: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let byte = |light: u16| (from_linear(f64::from(light) / 65_535.0) * 255.0).round();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 255"
    )]
    let of = |light: u16| byte(light) as u8;
    (0..=u16::MAX).map(of).collect()
});

/// The byte of sRGB that is nearest to linear light.
pub(super) fn byte(light: u16) -> u8 {
    BYTES.get(usize::from(light)).copied().unwrap_or_default()
}

/// A colour's bytes as linear light, opaque.
pub fn light(bytes: [u8; 3]) -> [f32; 4] {
    #[expect(clippy::cast_possible_truncation, reason = "0 to 1")]
    let [red, green, blue] = bytes.map(|byte| linear(f64::from(byte) / 255.0) as f32);
    [red, green, blue, 1.0]
}

/// What a part of sRGB is in linear light.
pub(super) fn linear(part: f64) -> f64 {
    if part <= 0.040_45 {
        part / 12.92
    } else {
        ((part + 0.055) / 1.055).powf(2.4)
    }
}

fn from_linear(light: f64) -> f64 {
    if light <= 0.003_130_8 {
        light * 12.92
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    }
}

/// A part of one in 16 bits.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "0 to 65535; not a number is 0"
)]
pub(super) fn short(part: f64) -> u16 {
    (part.clamp(0.0, 1.0) * 65_535.0).round() as u16
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    #[test]
    fn bytes_come_back() {
        for of in 0..=u8::MAX {
            assert_eq!(byte(LINEAR[usize::from(of)]), of);
        }
        assert_eq!((LINEAR[0], LINEAR[255]), (0, 65_535));
        // Half of the light is more than half for the eye.
        assert_eq!(byte(32_768), 188);
    }
}
