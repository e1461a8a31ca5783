//! A small seeded random number generator, so that every run of a suite uses the same lines.

use crate::math::{SPLIT_MIX64_STEP, Vec3, split_mix64};

/// SplitMix64 (Steele, Lea, Flood 2014), sufficient for choosing test cases.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The generator with a given seed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// Any 64 bits.
    pub fn bits(&mut self) -> u64 {
        let bits = split_mix64(self.0);
        self.0 = self.0.wrapping_add(SPLIT_MIX64_STEP);
        bits
    }

    /// A number at least `low` and below `high`.
    pub fn number(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.bits() >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// An integer below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// Brings items into any order (Fisher and Yates 1938).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }

    /// A point in the cube from `low` to `high`.
    pub fn point(&mut self, low: f64, high: f64) -> Vec3 {
        Vec3::new(self.number(low, high), self.number(low, high), self.number(low, high))
    }

    /// A unit vector, uniform on the sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.point(-1.0, 1.0);
            if (1e-3..=1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }
}
