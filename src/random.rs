//! Random numbers that are the same in every run: for trial points, tests and reports.

/// xorshift64 (Marsaglia, J. Statistical Software 8 (2003) 14).
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// A sequence of its own for every `seed` but 0, which has none; seeds should be large, with bits all over.
    pub fn new(seed: u64) -> Self {
        Random(seed)
    }

    /// The next number in [0, 1).
    #[allow(clippy::should_implement_trait)] // there is no end to iterate to
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The next number in [low, high).
    pub fn within(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.next()
    }
}
