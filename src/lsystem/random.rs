//! Counter-based random numbers: a draw is a pure function of (seed, step, round, position, number of the draw),
//! so a string is the same on any number of threads and a step can be made again alone.
//!
//! The mixing is the finaliser of SplitMix64 (Steele, Lea, Flood 2014), once for each part of the key.

use super::chances::BITS;

/// Key of one rewriting pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassKey(u64);

/// The draws of one module in one pass. Making them costs nothing; drawing does.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Draws {
    pass: u64,
    position: u64,
    count: u64,
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

fn step_key(key: u64, part: u64) -> u64 {
    mix(key.wrapping_add(0x9e37_79b9_7f4a_7c15) ^ mix(part.wrapping_add(0x6a09_e667_f3bc_c909)))
}

impl PassKey {
    pub(crate) fn new(seed: u64, step: u32, round: u32) -> Self {
        Self(step_key(
            step_key(mix(seed), u64::from(step)),
            u64::from(round),
        ))
    }

    /// The draw that chooses among productions of the module at `position`: uniform in 0…2^53 − 1. It is a SplitMix64 of its own,
    /// one number for each position.
    #[inline]
    pub(crate) fn choice(self, position: usize) -> u64 {
        let gamma = 0x9e37_79b9_7f4a_7c15_u64;
        let position = (position as u64).wrapping_add(1);
        mix(self.0.wrapping_add(position.wrapping_mul(gamma))) >> (64 - BITS)
    }

    /// Draws of the module at `position`.
    pub(crate) fn at(self, position: usize) -> Draws {
        Draws {
            pass: self.0,
            position: position as u64,
            count: 0,
        }
    }
}

impl Draws {
    /// Uniform in [0, 1), 53 bits.
    #[expect(clippy::cast_precision_loss, reason = "53 bits fit an f64 exactly")]
    pub(crate) fn unit(&mut self) -> f64 {
        self.count += 1;
        let module = mix(self.pass ^ self.position.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let draw = mix(module.wrapping_add(self.count.wrapping_mul(0xd1b5_4a32_d192_ed03)));
        (draw >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Standard normal (Box and Muller 1958); two draws.
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_many_positions() {
        let key = PassKey::new(1, 2, 0);
        let n = 200_000;
        let (mut sum, mut squares, mut normal, mut normal_squares, mut product) =
            (0.0, 0.0, 0.0, 0.0, 0.0);
        for position in 0..n {
            let mut draws = key.at(position);
            let (a, b, z) = (draws.unit(), draws.unit(), draws.normal());
            sum += a;
            squares += a * a;
            product += (a - 0.5) * (b - 0.5);
            normal += z;
            normal_squares += z * z;
        }
        let n = f64::from(u32::try_from(n).unwrap_or(0));
        assert!((sum / n - 0.5).abs() < 0.003, "mean {}", sum / n);
        assert!(
            (squares / n - 1.0 / 3.0).abs() < 0.003,
            "second moment {}",
            squares / n
        );
        assert!(
            (product / n).abs() < 0.001,
            "covariance of two draws {}",
            product / n
        );
        assert!((normal / n).abs() < 0.01, "normal mean {}", normal / n);
        assert!(
            (normal_squares / n - 1.0).abs() < 0.015,
            "normal variance {}",
            normal_squares / n
        );
    }

    #[test]
    fn every_part_of_the_key_counts() {
        let draw = |seed, step, round, position| {
            PassKey::new(seed, step, round)
                .at(position)
                .unit()
                .to_bits()
        };
        let base = draw(1, 1, 1, 1);
        assert_eq!(base, draw(1, 1, 1, 1), "same key, same draw");
        for other in [
            draw(2, 1, 1, 1),
            draw(1, 2, 1, 1),
            draw(1, 1, 2, 1),
            draw(1, 1, 1, 2),
        ] {
            assert_ne!(base, other, "another key");
        }
    }

    #[test]
    fn moments_of_choices() {
        let n = 200_000;
        let unit = |key: PassKey, position| {
            let draw = key.choice(position);
            assert!(draw < 1 << BITS, "no more bits than asked for");
            draw as f64 / (1_u64 << BITS) as f64
        };
        // Of one pass, next to each other, and of two passes of one place.
        let (key, other) = (PassKey::new(1, 2, 1 << 31), PassKey::new(1, 3, 1 << 31));
        let (mut sum, mut squares, mut beside, mut after) = (0.0, 0.0, 0.0, 0.0);
        for position in 0..n {
            let draw = unit(key, position);
            sum += draw;
            squares += draw * draw;
            beside += (draw - 0.5) * (unit(key, position + 1) - 0.5);
            after += (draw - 0.5) * (unit(other, position) - 0.5);
        }
        let n = n as f64;
        for (name, found, expected, most) in [
            ("mean", sum / n, 0.5, 0.003),
            ("second moment", squares / n, 1.0 / 3.0, 0.003),
            ("covariance of neighbours", beside / n, 0.0, 0.001),
            ("covariance of passes", after / n, 0.0, 0.001),
        ] {
            assert!((found - expected).abs() < most, "{name} {found}");
        }
    }
}
