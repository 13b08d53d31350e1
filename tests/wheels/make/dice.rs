//! Pseudo-random numbers, the same on every machine.

/// A linear congruential generator (Knuth's MMIX constants), of which the upper 53 bits are used.
pub struct Dice(u64);

impl Dice {
    /// The generator for wheel `index` of `seed`, independent of other wheels.
    pub fn new(seed: u64, index: u64) -> Self {
        let mut dice =
            Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ index.wrapping_mul(0xd1b5_4a32_d192_ed03));
        // The first numbers are discarded, because neighbouring seeds give similar ones.
        (0..8).for_each(|_| {
            dice.roll();
        });
        dice
    }

    /// Uniform in [0, 1).
    pub fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.roll()
    }

    /// Uniform on a logarithmic scale.
    pub fn sized(&mut self, from: f64, to: f64) -> f64 {
        self.between(from.ln(), to.ln()).exp()
    }

    /// A uniform integer from `from` to `to`, inclusive.
    pub fn whole(&mut self, from: usize, to: usize) -> usize {
        from + ((to - from + 1) as f64 * self.roll()) as usize
    }

    pub fn chance(&mut self, probability: f64) -> bool {
        self.roll() < probability
    }
}
