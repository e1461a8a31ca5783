//! Sines and cosines of angles in degrees, to more digits than f64 has.

use super::Dd;

/// Degrees to radians: pi / 180 to 106 bits.
const RADIANS: Dd = Dd { hi: 0.017453292519943295, lo: 2.9486522708701687e-19 };

/// The sine and the cosine of an angle in degrees, to 1e-31; exact at multiples of 90.
pub fn sin_cos_degrees_wide(degrees: f64) -> (Dd, Dd) {
    // Remainders are exact, however many turns there are.
    let turn = libm::remainder(degrees, 360.0);
    let rest = libm::remainder(turn, 90.0);
    let quarter = ((turn - rest) / 90.0).rem_euclid(4.0) as u8;
    let (s, c) = sin_cos(RADIANS * Dd::from(rest));
    match quarter {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Uses the Taylor series, for angles of at most pi / 4.
fn sin_cos(x: Dd) -> (Dd, Dd) {
    let square = x * x;
    let series = |first: Dd, from: u32| {
        let (mut sum, mut term) = (first, first);
        for n in (from..28).step_by(2) {
            term = -(term * square * Dd::from(f64::from((n + 1) * (n + 2))).recip());
            sum = sum + term;
        }
        sum
    };
    (series(x, 1), series(Dd::ONE, 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarters_are_exact_and_the_rest_is_on_the_circle() {
        for k in -9..9_i32 {
            let (s, c) = sin_cos_degrees_wide(f64::from(k) * 90.0);
            let expected = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][k.rem_euclid(4) as usize];
            assert_eq!((s.hi, c.hi, s.lo, c.lo), (expected.0, expected.1, 0.0, 0.0));
        }
        for degrees in [1e-9, 30.0, 45.0, 100.1, 359.9999, -12345.678] {
            let (s, c) = sin_cos_degrees_wide(degrees);
            let off = s * s + c * c - Dd::ONE;
            assert!(off.hi.abs() < 1e-30, "{degrees}: {off:?}");
            assert!((s.hi - degrees.to_radians().sin()).abs() < 1e-12);
            assert!((c.hi - degrees.to_radians().cos()).abs() < 1e-12);
        }
        // However many turns: 1e17 is 280 more than a multiple of 360, and 1e20 too.
        for degrees in [1e17, 1e20] {
            assert_eq!(sin_cos_degrees_wide(degrees), sin_cos_degrees_wide(280.0));
        }
        let (s, _) = sin_cos_degrees_wide(30.0);
        assert!((s - Dd::from(0.5)).hi.abs() < 1e-31, "{s:?}");
    }
}
