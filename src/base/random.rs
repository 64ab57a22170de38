//! Random numbers that are identical on every machine.

/// SplitMix64 generator (Steele, Lea and Flood 2014), whose only state is a counter.
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// Returns a generator; equal seeds give equal numbers.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns the next 64 bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number uniformly distributed in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns an integer in 0..n; n is at least 1.
    pub fn uniform_below(&mut self, n: usize) -> usize {
        // The bias of the remainder is n / 2^64: negligible.
        (self.next_u64() % n.max(1) as u64) as usize
    }

    /// Shuffles `items` (Fisher and Yates 1938).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        (1..items.len()).rev().for_each(|i| items.swap(i, self.uniform_below(i + 1)));
    }
}
