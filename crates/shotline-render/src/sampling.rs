//! The random numbers of samples: their positions in the pixel, on lamps and in the sky.

use shotline::math::split_mix64;

/// Where one sample of a pixel is, and its random numbers, each from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleNumbers {
    /// The position in the picture, in pixels across and down.
    pub position: [f64; 2],
    /// The position on a lamp.
    pub lamp: [f64; 2],
    /// The position in the sky.
    pub sky: [f64; 2],
}

/// The steps of the four-dimensional sequence that generalises the golden ratio (Roberts 2018): powers of
/// the inverse of the positive root of `x^5 = x + 1`.
const STEPS: [f64; 4] =
    [0.856_674_883_854_502_9, 0.733_891_856_627_126, 0.628_706_721_037_808_5, 0.538_597_257_223_612_6];

/// The samples of a pixel. A single sample is in the middle of the pixel, the lamp and the sky. More samples are
/// spread evenly (in the pixel they are a Hammersley set) and shifted by amounts that depend on the pixel alone:
/// neighbours differ, so that no pattern shows, and repeated runs are the same.
pub fn samples(column: u32, row: u32, count: u32) -> impl Iterator<Item = SampleNumbers> {
    let seed = split_mix64(u64::from(column) << 32 | u64::from(row));
    let shifts: [f64; 6] =
        std::array::from_fn(|axis| fraction((split_mix64(seed + axis as u64) >> 32) as u32));
    let position = move |[x, y]: [f64; 2]| [f64::from(column) + x, f64::from(row) + y];
    (0..count).map(move |i| {
        if count == 1 {
            return SampleNumbers { position: position([0.5; 2]), lamp: [0.5; 2], sky: [0.5; 2] };
        }
        let shifted = |x: f64, axis: usize| (x + shifts[axis]).fract();
        let step = |axis: usize| shifted(f64::from(i) * STEPS[axis - 2], axis);
        let across = (f64::from(i) + 0.5) / f64::from(count);
        let down = fraction(i.reverse_bits());
        SampleNumbers {
            position: position([shifted(across, 0), shifted(down, 1)]),
            lamp: [step(2), step(3)],
            sky: [step(4), step(5)],
        }
    })
}

fn fraction(bits: u32) -> f64 {
    f64::from(bits) / 2f64.powi(32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_is_in_the_middle() {
        let middle = SampleNumbers { position: [7.5, 9.5], lamp: [0.5; 2], sky: [0.5; 2] };
        assert_eq!(samples(7, 9, 1).collect::<Vec<_>>(), [middle]);
    }

    /// On each axis, taken as periodic, the samples have equal distances.
    #[test]
    fn samples_are_spread_evenly() {
        for (column, row) in [(0, 0), (3, 5), (799, 599)] {
            for (axis, start) in [column, row].map(f64::from).into_iter().enumerate() {
                let mut positions: Vec<f64> =
                    samples(column, row, 16).map(|s| s.position[axis] - start).collect();
                positions.sort_by(f64::total_cmp);
                assert!(positions.iter().all(|x| (0.0..1.0).contains(x)));
                assert!(positions.windows(2).all(|w| (w[1] - w[0] - 1.0 / 16.0).abs() < 1e-9));
            }
        }
    }

    #[test]
    fn lamps_and_sky_are_covered() {
        for pick in [|s: SampleNumbers| s.lamp, |s: SampleNumbers| s.sky] {
            let mut quarters = [0; 4];
            for [x, y] in samples(3, 4, 64).map(pick) {
                quarters[usize::from(x < 0.5) + 2 * usize::from(y < 0.5)] += 1;
            }
            assert!(quarters.iter().all(|n| (12..=20).contains(n)), "{quarters:?}");
        }
    }
}
