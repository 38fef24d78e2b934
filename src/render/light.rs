//! What the stage is lit by: the numbers of each [`Light`], which all shaders read from the frame's block, so that none of them knows which light it is.
//!
//! Daylight's numbers are those that pictures were made with before there was a choice, to the bit.

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

use crate::world::scene::weather::Light;

/// `Light` of shaders/shared/frame.wgsl, where each is explained. Colours are linear.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct LightData {
    sun: Vec4,
    horizon: Vec4,
    toward_sun: Vec4,
    middle: Vec4,
    zenith: Vec4,
    glow: Vec4,
    halo: Vec4,
    disc: Vec4,
    above: Vec4,
    below: Vec4,
    fill: Vec4,
    fill_color: Vec4,
    rim: Vec4,
    rim_color: Vec4,
    floor: Vec4,
}

const _: () = assert!(
    size_of::<LightData>() == 240,
    "shaders/shared/frame.wgsl reads 240 bytes"
);

const fn color(red: f32, green: f32, blue: f32) -> Vec4 {
    Vec4::new(red, green, blue, 0.0)
}

/// A colour and a number.
const fn with(red: f32, green: f32, blue: f32, number: f32) -> Vec4 {
    Vec4::new(red, green, blue, number)
}

const DAY: LightData = LightData {
    // The sun's own half of a degree.
    sun: with(1.00, 0.90, 0.74, 0.0047),
    horizon: with(0.74, 0.80, 0.83, 0.006),
    // As far apart as taps of the map are anyway: on itself a tree is shaded sharply.
    toward_sun: with(0.0, 0.0, 0.0, 1.3),
    middle: color(0.33, 0.52, 0.74),
    zenith: color(0.115, 0.245, 0.50),
    glow: color(0.20, 0.155, 0.09),
    halo: color(0.55, 0.44, 0.28),
    disc: color(1.0, 0.95, 0.85),
    above: color(0.40, 0.47, 0.56),
    below: color(0.20, 0.19, 0.155),
    fill: Vec4::ZERO,
    fill_color: Vec4::ZERO,
    rim: Vec4::ZERO,
    rim_color: Vec4::ZERO,
    floor: Vec4::ZERO,
};

const EVENING: LightData = LightData {
    // Larger than it is: through the haze at the horizon.
    sun: with(2.30, 1.24, 0.50, 0.022),
    horizon: with(0.34, 0.30, 0.36, 0.008),
    toward_sun: with(0.70, 0.34, 0.06, 2.6),
    middle: color(0.15, 0.19, 0.34),
    zenith: color(0.035, 0.07, 0.18),
    glow: color(0.36, 0.18, 0.05),
    halo: color(0.70, 0.42, 0.16),
    disc: color(1.0, 0.80, 0.45),
    above: color(0.165, 0.215, 0.32),
    below: color(0.14, 0.115, 0.08),
    fill: Vec4::ZERO,
    fill_color: Vec4::ZERO,
    rim: Vec4::ZERO,
    rim_color: Vec4::ZERO,
    floor: Vec4::ZERO,
};

const STUDIO: LightData = LightData {
    sun: with(0.95, 0.92, 0.87, 0.16),
    // As bright as the floor: where one ends and the other begins is not seen.
    horizon: with(0.412, 0.408, 0.402, 0.0),
    toward_sun: with(0.0, 0.0, 0.0, 4.0),
    middle: color(0.30, 0.30, 0.30),
    zenith: color(0.13, 0.133, 0.137),
    glow: Vec4::ZERO,
    halo: Vec4::ZERO,
    disc: Vec4::ZERO,
    above: color(0.30, 0.305, 0.31),
    below: color(0.19, 0.185, 0.18),
    // From the other side and lower; then from behind and above.
    fill: color(0.80, 0.22, 0.56),
    fill_color: color(0.13, 0.14, 0.16),
    rim: color(0.46, 0.46, -0.76),
    rim_color: color(0.42, 0.42, 0.44),
    floor: with(0.34, 0.337, 0.333, 1.0),
};

impl LightData {
    pub(crate) fn of(light: Light) -> Self {
        match light {
            Light::Day => DAY,
            Light::Evening => EVENING,
            Light::Studio => STUDIO,
        }
    }
}

/// Towards the sun, or the studio's lamp; of any length.
pub(crate) fn sun(light: Light) -> Vec3 {
    match light {
        Light::Day => Vec3::new(0.62, 0.70, 0.36),
        Light::Evening => Vec3::new(-0.80, 0.27, -0.42),
        Light::Studio => Vec3::new(-0.52, 0.72, 0.46),
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    /// Degrees over the horizon.
    fn height(light: Light) -> f32 {
        sun(light).normalize().y.asin().to_degrees()
    }

    #[test]
    fn the_evening_sun_is_low_and_warm_and_its_sky_darker_and_bluer() {
        let [day, evening] = [Light::Day, Light::Evening].map(LightData::of);
        assert!((40.0..60.0).contains(&height(Light::Day)));
        assert!((8.0..18.0).contains(&height(Light::Evening)));
        // Red over blue.
        let warmth = |color: Vec4| color.x / color.z;
        assert!(warmth(evening.sun) > 3.0 * warmth(day.sun));
        let brightness = |color: Vec4| color.truncate().dot(Vec3::new(0.2126, 0.7152, 0.0722));
        assert!(brightness(evening.above) < 0.5 * brightness(day.above));
        assert!(warmth(evening.above) < warmth(day.above));
        assert!(brightness(evening.zenith) < 0.5 * brightness(day.zenith));
    }

    #[test]
    fn studio_light_is_neutral_large_and_comes_from_three_sides() {
        let studio = LightData::of(Light::Studio);
        for color in [studio.horizon, studio.zenith, studio.above, studio.floor] {
            let [low, high] = [
                color.truncate().min_element(),
                color.truncate().max_element(),
            ];
            assert!(high < 1.1 * low, "{color}");
        }
        let key = sun(Light::Studio).normalize();
        for other in [studio.fill, studio.rim] {
            let other = other.truncate();
            assert!((other.length() - 1.0).abs() < 0.02, "{other}");
            assert!(key.dot(other) < 0.5, "{other}");
        }
        assert!(studio.fill_color.length() < 0.5 * studio.sun.truncate().length());
        assert!(studio.sun.w > 5.0 * LightData::of(Light::Evening).sun.w);
        assert!(LightData::of(Light::Evening).sun.w > 3.0 * LightData::of(Light::Day).sun.w);
    }
}
