//! Pseudorandom bits from a number.

/// The output of SplitMix64 for a state (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number
/// generators"). The bits for different states look independent of each other.
pub fn split_mix64(state: u64) -> u64 {
    let z = state.wrapping_add(SPLIT_MIX64_STEP);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The increment of the state of SplitMix64 from one output to the next.
pub const SPLIT_MIX64_STEP: u64 = 0x9e37_79b9_7f4a_7c15;

#[cfg(test)]
mod tests {
    use super::*;

    /// The first outputs for the seed 1234567, as other implementations publish them.
    #[test]
    fn outputs_are_the_published_ones() {
        let states = [0, 1, 2].map(|i| 1234567u64.wrapping_add(SPLIT_MIX64_STEP.wrapping_mul(i)));
        assert_eq!(states.map(split_mix64), [6457827717110365317, 3203168211198807973, 9817491932198370423]);
    }
}
