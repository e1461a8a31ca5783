//! Where in a pixel the samples fall.

/// The places of a pixel's samples, from 0 to 1 across and down. One sample is in the middle; more are a
/// Hammersley set (every row and column of the pixel cut in `count` has one), moved by an amount that
/// depends on the pixel alone: neighbours differ, so that no pattern shows, and runs do not.
pub fn places(column: u32, row: u32, count: u32) -> impl Iterator<Item = [f64; 2]> {
    let seed = mix(u64::from(column) << 32 | u64::from(row));
    let shift = [fraction(seed as u32), fraction((seed >> 32) as u32)];
    (0..count).map(move |i| {
        if count == 1 {
            return [0.5, 0.5];
        }
        let x = (f64::from(i) + 0.5) / f64::from(count) + shift[0];
        let y = fraction(i.reverse_bits()) + shift[1];
        [x.fract(), y.fract()]
    })
}

fn fraction(bits: u32) -> f64 {
    f64::from(bits) / 2f64.powi(32)
}

/// The finalizer of SplitMix64 (Steele, Lea and Flood 2014).
fn mix(seed: u64) -> u64 {
    let z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_is_in_the_middle() {
        assert_eq!(places(7, 9, 1).collect::<Vec<_>>(), [[0.5, 0.5]]);
    }

    /// Cut in as many columns as samples, the pixel has one in each; also in rows for a power of two.
    #[test]
    fn samples_are_stratified() {
        for (column, row) in [(0, 0), (3, 5), (799, 599)] {
            for axis in 0..2 {
                // The shift moves the strata along with it, so distances around the pixel are what is even.
                let mut at: Vec<f64> = places(column, row, 16).map(|p| p[axis]).collect();
                at.sort_by(f64::total_cmp);
                assert!(at.iter().all(|x| (0.0..1.0).contains(x)));
                for pair in at.windows(2) {
                    assert!((pair[1] - pair[0] - 1.0 / 16.0).abs() < 1e-9);
                }
            }
        }
    }
}
