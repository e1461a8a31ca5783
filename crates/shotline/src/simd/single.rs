//! The operations on one float64 number, so that a kernel written for lanes also takes a single line.

use super::{Doubles, UPPER_HALF};

/// The exponent field of a number.
pub(super) const EXPONENT: u64 = 0x7ff << 52;

impl Doubles for f64 {
    const LANES: usize = 1;
    type Array = [f64; 1];

    #[inline(always)]
    fn load(from: &[f64; 1]) -> f64 {
        from[0]
    }

    #[inline(always)]
    fn from_fn(number: impl Fn(usize) -> f64) -> f64 {
        number(0)
    }

    #[inline(always)]
    fn load_some(from: &[f64; 8], first: usize) -> f64 {
        from[first]
    }

    #[inline(always)]
    fn store(self) -> [f64; 1] {
        [self]
    }

    #[inline(always)]
    fn store_rows(columns: [f64; 8], mut row: impl FnMut(usize, [f64; 8])) {
        row(0, columns);
    }

    #[inline(always)]
    fn store_singles(columns: [f64; 8], mut row: impl FnMut(usize, [f32; 8])) {
        row(0, columns.map(|x| x as f32));
    }

    #[inline(always)]
    fn to_single(self) -> f64 {
        f64::from(self as f32)
    }

    #[inline(always)]
    fn power_below_one(self) -> f64 {
        f64::from_bits((2045_u64 << 52).wrapping_sub(self.to_bits() & EXPONENT))
    }

    #[inline(always)]
    fn mul_sub(self, factor: f64, subtrahend: f64) -> f64 {
        self.mul_add(factor, -subtrahend)
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: f64, summand: f64) -> f64 {
        (-self).mul_add(factor, summand)
    }

    #[inline(always)]
    fn lesser(self, other: f64) -> f64 {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn greater(self, other: f64) -> f64 {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn where_negative(self, sign: f64, other: f64) -> f64 {
        if sign.is_sign_negative() { self } else { other }
    }

    #[inline(always)]
    fn where_set(self, lanes: u8, other: f64) -> f64 {
        if lanes & 1 == 1 { self } else { other }
    }

    #[inline(always)]
    fn upper_half(self) -> f64 {
        f64::from_bits(self.to_bits() & UPPER_HALF)
    }

    #[inline(always)]
    fn is_less(self, other: f64) -> u8 {
        u8::from(self < other)
    }

    #[inline(always)]
    fn is_at_most(self, other: f64) -> u8 {
        u8::from(self <= other)
    }
}
