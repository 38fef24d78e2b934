//! Random numbers that a seed and a number say, the same on every machine (SplitMix64; Steele, Lea and Flood 2014).

/// A row of random numbers.
pub(crate) struct Draws(u64);

impl Draws {
    /// The row of a seed that belongs to a number, such as that of a node or a candidate.
    pub(crate) fn new(seed: u64, number: u64) -> Self {
        let mut draws = Self(seed ^ number.wrapping_mul(0xD134_2543_DE82_EF95));
        draws.next();
        draws
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^ (bits >> 31)
    }

    /// Evenly between two numbers.
    pub(crate) fn uniform(&mut self, from: f64, to: f64) -> f64 {
        let part = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        from + part * (to - from)
    }
}
