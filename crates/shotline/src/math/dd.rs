//! Double-double numbers: unevaluated sums of two f64 with about 106 bits.
//!
//! Error-free transformations after Dekker (1971) and Knuth; the product uses a fused multiply-add, which
//! gives the same bits in hardware and in software. Used where a sign or the last bit matters, never in a
//! loop over boxes.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, or a vector of numbers on which all operations work lane by lane.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The same number in every lane.
    fn splat(x: f64) -> Self;

    /// `self * factor + summand`, rounded once.
    fn mul_add(self, factor: Self, summand: Self) -> Self;
}

impl Real for f64 {
    #[inline(always)]
    fn splat(x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn mul_add(self, factor: f64, summand: f64) -> f64 {
        f64::mul_add(self, factor, summand)
    }
}

/// An unevaluated sum `hi + lo` with `|lo|` at most half an ulp of `hi`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dd<T = f64> {
    /// The number rounded to f64.
    pub hi: T,
    /// The rest after rounding.
    pub lo: T,
}

/// `a + b` without error.
#[inline(always)]
pub fn two_sum<T: Real>(a: T, b: T) -> Dd<T> {
    let hi = a + b;
    let t = hi - a;
    Dd { hi, lo: (a - (hi - t)) + (b - t) }
}

/// `a + b` without error, given `|a| >= |b|`.
#[inline(always)]
pub fn quick_two_sum<T: Real>(a: T, b: T) -> Dd<T> {
    let hi = a + b;
    Dd { hi, lo: b - (hi - a) }
}

/// `a * b` without error (barring underflow of the low part).
#[inline(always)]
pub fn two_prod<T: Real>(a: T, b: T) -> Dd<T> {
    let hi = a * b;
    Dd { hi, lo: a.mul_add(b, -hi) }
}

/// The sum of numbers, accumulated in double-double and rounded once.
pub fn sum(numbers: impl IntoIterator<Item = f64>) -> f64 {
    numbers.into_iter().fold(Dd::ZERO, |sum, x| sum + Dd::from(x)).hi
}

/// `a * b - c * d` within 1.5 ulp (Kahan; Jeannerod, Louvet, Muller 2013).
#[inline(always)]
pub fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let cd = c * d;
    let error = c.mul_add(-d, cd);
    a.mul_add(b, -cd) + error
}

impl Dd {
    /// Zero.
    pub const ZERO: Dd = Dd { hi: 0.0, lo: 0.0 };

    /// One.
    pub const ONE: Dd = Dd { hi: 1.0, lo: 0.0 };

    /// The square root; zero for arguments that are not positive.
    #[inline(always)]
    pub fn sqrt(self) -> Dd {
        if self.hi <= 0.0 {
            return Dd::ZERO;
        }
        let root = self.hi.sqrt();
        let rest = (self - two_prod(root, root)).hi;
        quick_two_sum(root, rest / (2.0 * root))
    }
}

impl<T: Real> Dd<T> {
    /// The quotient `1 / self`.
    #[inline(always)]
    pub fn recip(self) -> Dd<T> {
        let first = T::splat(1.0) / self.hi;
        let rest = Dd::from(T::splat(1.0)) - self * first;
        two_sum(first, rest.hi * first)
    }
}

impl<T: Real> From<T> for Dd<T> {
    #[inline(always)]
    fn from(hi: T) -> Dd<T> {
        Dd { hi, lo: T::splat(0.0) }
    }
}

impl<T: Real> Neg for Dd<T> {
    type Output = Dd<T>;
    #[inline(always)]
    fn neg(self) -> Dd<T> {
        Dd { hi: -self.hi, lo: -self.lo }
    }
}

impl<T: Real> Add for Dd<T> {
    type Output = Dd<T>;
    #[inline(always)]
    fn add(self, other: Dd<T>) -> Dd<T> {
        let high = two_sum(self.hi, other.hi);
        let low = two_sum(self.lo, other.lo);
        let sum = quick_two_sum(high.hi, high.lo + low.hi);
        quick_two_sum(sum.hi, sum.lo + low.lo)
    }
}

impl<T: Real> Sub for Dd<T> {
    type Output = Dd<T>;
    #[inline(always)]
    fn sub(self, other: Dd<T>) -> Dd<T> {
        self + -other
    }
}

impl<T: Real> Mul for Dd<T> {
    type Output = Dd<T>;
    #[inline(always)]
    fn mul(self, other: Dd<T>) -> Dd<T> {
        let p = two_prod(self.hi, other.hi);
        quick_two_sum(p.hi, p.lo + (self.hi * other.lo + self.lo * other.hi))
    }
}

impl<T: Real> Mul<T> for Dd<T> {
    type Output = Dd<T>;
    #[inline(always)]
    fn mul(self, other: T) -> Dd<T> {
        let p = two_prod(self.hi, other);
        quick_two_sum(p.hi, p.lo + self.lo * other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sums_and_products_lose_nothing(a in -1e6..1e6f64, b in -1e-6..1e-6f64) {
            let s = two_sum(a, b);
            prop_assert_eq!(s.hi, a + b);
            prop_assert_eq!((Dd { hi: s.hi, lo: s.lo } - Dd::from(a)).hi, b);
            let p = two_prod(a, b);
            // The exact product of two 53-bit numbers has 106 bits: high and low part hold all of them.
            prop_assert_eq!(p.hi, a * b);
            prop_assert!(p.lo.abs() <= f64::EPSILON * p.hi.abs());
        }

        #[test]
        fn roots_and_reciprocals_undo(a in 1e-6..1e6f64) {
            let root = Dd::from(a).sqrt();
            prop_assert!((root * root - Dd::from(a)).hi.abs() <= 1e-30 * a);
            let one = Dd::from(a).recip() * a;
            prop_assert!((one - Dd::from(1.0)).hi.abs() <= 1e-30);
        }
    }

    #[test]
    fn difference_of_products_keeps_the_cancelled_bits() {
        let a = 1.0 + f64::EPSILON;
        // (1 + e)^2 - (1 + 2e) * 1 = e^2, which plain evaluation rounds to zero.
        assert_eq!(difference_of_products(a, a, 1.0 + 2.0 * f64::EPSILON, 1.0), f64::EPSILON * f64::EPSILON);
    }
}
