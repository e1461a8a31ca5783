//! Lengths of vectors and unit vectors, for vectors so large or small that their squares overflow or underflow.

use super::Vec3;
use super::power_of_two::power_of_two_near;

/// The sizes of vectors whose squares neither overflow nor underflow.
pub(crate) const UNIT_RANGE: [f64; 2] = [1e-100, 1e100];

/// The length of a vector.
pub fn length(v: Vec3) -> f64 {
    let unit = scale(v);
    (v / unit).length() * unit
}

/// The vector of length 1 in the direction of a vector; NaN for the zero vector.
pub fn unit(v: Vec3) -> Vec3 {
    (v / scale(v)).normalize()
}

/// A power of two near the largest component, so that division by it is exact; 1 where squares are in range.
fn scale(v: Vec3) -> f64 {
    let size = v.abs().max_element();
    if (UNIT_RANGE[0]..UNIT_RANGE[1]).contains(&size) || size == 0.0 || !size.is_finite() {
        1.0
    } else {
        power_of_two_near(size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_size_is_measured() {
        for power in [-1070, -1000, -600, -300, 0, 300, 600, 1000, 1020] {
            let size = libm::ldexp(1.0, power);
            assert_eq!(length(Vec3::new(3.0, 4.0, 0.0) * size), 5.0 * size, "2^{power}");
            assert_eq!(unit(Vec3::new(0.0, -2.0, 0.0) * size), Vec3::NEG_Y, "2^{power}");
        }
        assert_eq!(length(Vec3::ZERO), 0.0);
        assert!(unit(Vec3::ZERO).is_nan() && length(Vec3::NAN).is_nan());
    }
}
