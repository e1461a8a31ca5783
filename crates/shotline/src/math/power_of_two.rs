//! Powers of two, for scaling without rounding.

use super::{Real, Vec3};

/// The `e` for which `2^(e-1) <= |x| < 2^e`.
#[inline(always)]
pub fn binary_exponent(x: f64) -> i32 {
    // The exponent field gives it, except for zero, subnormal numbers and numbers that are not finite.
    match (x.to_bits() >> 52) as i32 & 0x7ff {
        0 | 0x7ff => libm::frexp(x).1,
        field => field - 1022,
    }
}

/// `2^e` for the exponents `e` of normal numbers, -1022 to 1023.
#[inline(always)]
pub fn power_of_two(e: i32) -> f64 {
    f64::from_bits(((1023 + e) as u64) << 52)
}

/// The power of two at or below a positive normal number.
pub fn power_of_two_below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & f64::INFINITY.to_bits()).max(f64::MIN_POSITIVE)
}

/// A power of two within a factor of two of a positive finite number (kept inside the normal range).
pub fn power_of_two_near(x: f64) -> f64 {
    power_of_two(binary_exponent(x).clamp(-1000, 1000))
}

/// A power of two as two factors, so that the power itself may be out of range.
#[derive(Clone, Copy)]
pub struct PowerOfTwo(f64, f64);

impl PowerOfTwo {
    /// `2^exponent`.
    #[inline(always)]
    pub fn new(exponent: i32) -> PowerOfTwo {
        let power = |e: i32| power_of_two(e.clamp(-1022, 1023));
        let half = exponent / 2;
        PowerOfTwo(power(half), power(exponent - half))
    }

    /// The product with a number, or with that of each lane.
    #[inline(always)]
    pub fn times<T: Real>(self, x: T) -> T {
        x * T::splat(self.0) * T::splat(self.1)
    }

    /// The product with a vector.
    #[inline(always)]
    pub fn of(self, v: Vec3) -> Vec3 {
        v * self.0 * self.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_those_of_frexp() {
        for e in -1074..1024 {
            let x = libm::ldexp(1.0, e);
            for x in [x, 1.5 * x, x.next_down()] {
                assert_eq!(binary_exponent(x), libm::frexp(x).1, "{x:e}");
            }
        }
        for x in [0.0, f64::INFINITY] {
            assert_eq!(binary_exponent(x), libm::frexp(x).1);
        }
    }

    #[test]
    fn powers_are_those_of_ldexp() {
        for e in -1022..1024 {
            let power = libm::ldexp(1.0, e);
            assert_eq!((power_of_two(e), power_of_two_below(1.25 * power)), (power, power));
        }
        for e in -2000..2000 {
            assert_eq!(PowerOfTwo::new(e).times(1.0), libm::ldexp(1.0, e), "2^{e}");
        }
    }
}
