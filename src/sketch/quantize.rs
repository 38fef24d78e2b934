//! The grid on which everything drawn lies: 0.1 mm and 0.001°.
//!
//! Two runtimes report one hand movement with different last bits. Rounded to a grid far below
//! what a hand can hold still, both give the same document and so the same file, byte for byte.
//! Rounding twice changes nothing, and −0 becomes 0, because the two are written differently.

use glam::{DVec3, Vec3};

/// Steps of the grid in a metre.
const PER_METRE: f64 = 1e4;
/// Steps of the grid of radii in a metre.
const RADII_PER_METRE: f64 = 1e6;
/// Steps of the grid in a degree.
const PER_DEGREE: f64 = 1e3;

/// A length in metres on the grid of 0.1 mm. Infinite and NaN stay what they are.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    reason = "rounding to the nearest f32 is meant"
)]
pub fn coordinate(metres: f32) -> f32 {
    ((f64::from(metres) * PER_METRE).round() / PER_METRE) as f32 + 0.0
}

/// A point in metres on the grid of 0.1 mm.
#[must_use]
pub fn point(metres: Vec3) -> Vec3 {
    Vec3::new(
        coordinate(metres.x),
        coordinate(metres.y),
        coordinate(metres.z),
    )
}

/// A point of the grid in f64, where 0.3 is 0.3 and not the f32 beside it.
#[must_use]
pub fn exact(metres: Vec3) -> DVec3 {
    (metres.as_dvec3() * PER_METRE).round() / PER_METRE
}

/// A radius in metres on a finer grid, of a thousandth of a millimetre: twigs are thin.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    reason = "rounding to the nearest f32 is meant"
)]
pub fn radius(metres: f32) -> f32 {
    ((f64::from(metres) * RADII_PER_METRE).round() / RADII_PER_METRE) as f32 + 0.0
}

/// A radius of the grid in f64, as [`exact`].
#[must_use]
pub fn exact_radius(metres: f32) -> f64 {
    (f64::from(metres) * RADII_PER_METRE).round() / RADII_PER_METRE
}

/// An angle in degrees on the grid of 0.001°.
#[must_use]
pub fn angle_deg(degrees: f64) -> f64 {
    (degrees * PER_DEGREE).round() / PER_DEGREE + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn known_values() {
        for (found, expected) in [
            (0.123_44, 0.1234),
            (0.123_46, 0.1235),
            (-0.000_01, 0.0),
            (-0.5, -0.5),
            (999.999_9, 999.999_9),
        ] {
            let on_grid = coordinate(found);
            assert_eq!(on_grid.to_bits(), f32::to_bits(expected), "{found}");
        }
        assert_eq!(
            angle_deg(180.0 * (3.0 - 5.0_f64.sqrt())),
            super::super::GOLDEN_DEG,
            "golden"
        );
        assert!(
            coordinate(f32::NAN).is_nan(),
            "NaN is for the checks to find"
        );
    }

    proptest! {
        #[test]
        fn rounding_twice_changes_nothing(x in -2000.0_f32..2000.0, a in -1e6_f64..1e6) {
            let once = coordinate(x);
            prop_assert_eq!(coordinate(once).to_bits(), once.to_bits());
            prop_assert!((once - x).abs() <= 1.3e-4);
            let thin = radius(x);
            prop_assert_eq!(radius(thin).to_bits(), thin.to_bits());
            prop_assert_eq!(angle_deg(angle_deg(a)).to_bits(), angle_deg(a).to_bits());
        }
    }
}
