//! Real roots of polynomials up to degree 4, without any absolute tolerance.
//!
//! Linear and quadratic polynomials have closed forms. Cubics and quartics are cut into monotone pieces at the roots
//! of the derivative. Each piece with a change of sign contains one root, which bracketed Newton finds (C. Yuksel,
//! "High-Performance Polynomial Root Finding for Graphics", 2022). So no root is spurious, only tangent roots may be
//! lost (see below), and every search ends.
//!
//! Coefficients are given from the constant term upwards, `c[0] + c[1] x + c[2] x^2 + ...`; leading zeros
//! lower the degree, and a polynomial that is zero everywhere, or has a coefficient that is NaN or infinite,
//! has no roots here. Multiplying `x` or the polynomial by a power of two scales the roots exactly as long
//! as nothing underflows; coefficients that differ by more than about 2^900 lose digits.
//!
//! **Multiple roots.** Each root is returned once, whatever its multiplicity. A root of odd multiplicity is a change
//! of sign and is always found. At a root of even multiplicity the polynomial is tangent to zero. Such a root is
//! found if the value at the computed extremum is exactly zero; otherwise rounding makes it absent or a close pair.
//! For quadratics the sign of the discriminant is correct for all coefficients within range, so a double root is one
//! root. To distinguish a tangent root from a near miss, use the sign of a quantity that is better conditioned than
//! the polynomial, as the torus does.

mod newton;

pub use newton::{Piece, bracketed_newton};

use crate::math::{binary_exponent, difference_of_products};
use std::ops::Deref;

/// Up to four roots, distinct and ascending; used like a slice.
#[derive(Clone, Copy, Debug, Default)]
pub struct Roots {
    values: [f64; 4],
    count: usize,
}

impl Roots {
    fn push(&mut self, x: f64) {
        if self.last() != Some(&x) && self.count < 4 {
            self.values[self.count] = x;
            self.count += 1;
        }
    }

    /// The roots strictly between two numbers.
    fn within(&self, lo: f64, hi: f64) -> Roots {
        let mut out = Roots::default();
        self.iter().filter(|&&x| lo < x && x < hi).for_each(|&x| out.push(x));
        out
    }
}

impl Deref for Roots {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.values[..self.count]
    }
}

/// The root of `c[0] + c[1] x`.
pub fn linear(c: [f64; 2]) -> Roots {
    let mut out = Roots::default();
    let x = -c[0] / c[1];
    if x.is_finite() && c[1].is_finite() {
        // Adding zero turns -0 into 0.
        out.push(x + 0.0);
    }
    out
}

/// The roots of `c[0] + c[1] x + c[2] x^2`, each within a few ulps unless the discriminant's own
/// coefficients underflow.
pub fn quadratic(c: [f64; 3]) -> Roots {
    if c[2] == 0.0 {
        return linear([c[0], c[1]]);
    }
    let [c, half_b, a] = unit_sized([c[0], 0.5 * c[1], c[2]]);
    // Kahan's discriminant: its sign is that of the exact one.
    let discriminant = difference_of_products(half_b, half_b, a, c);
    let mut out = Roots::default();
    if discriminant < 0.0 || discriminant.is_nan() {
        return out;
    }
    // The larger root without cancellation, the smaller by Vieta.
    let w = -(half_b + discriminant.sqrt().copysign(half_b));
    let (x, y) = if w == 0.0 { (0.0, 0.0) } else { (w / a, c / w) };
    for root in [x.min(y), x.max(y)] {
        if root.is_finite() {
            out.push(root + 0.0);
        }
    }
    out
}

/// The roots of a cubic strictly between `lo` and `hi`. Newton stops at a step of `tolerance`, in units of `x`, or of
/// an ulp. It converges quadratically, so simple roots are far more accurate than the tolerance.
#[inline(always)]
pub fn cubic_between(c: [f64; 4], lo: f64, hi: f64, tolerance: f64) -> Roots {
    let c = unit_sized(c);
    let extrema = quadratic([c[1], 2.0 * c[2], 3.0 * c[3]]).within(lo, hi);
    sign_changes(&c, &extrema, lo, hi, tolerance)
}

/// The roots of a polynomial that is monotone between neighbours in `lo, knots.., hi`.
#[inline(always)]
pub(crate) fn sign_changes<const N: usize>(
    c: &[f64; N],
    knots: &[f64],
    lo: f64,
    hi: f64,
    tolerance: f64,
) -> Roots {
    let mut out = Roots::default();
    let sign = |x: f64| {
        let value = horner(c, x).0;
        if value == 0.0 { 0.0 } else { value.signum() }
    };
    let (mut from, mut from_sign) = (lo, sign(lo));
    for &to in knots.iter().chain([&hi]) {
        let to_sign = sign(to);
        if from_sign * to_sign < 0.0 {
            let piece = Piece { lo: from, hi: to, rising: from_sign < 0.0 };
            out.push(bracketed_newton(piece, 0.5 * from + 0.5 * to, tolerance, |x| horner(c, x)));
        } else if to_sign == 0.0 && to < hi {
            out.push(to);
        }
        (from, from_sign) = (to, to_sign);
    }
    out
}

/// Value and slope by Horner's rule.
#[inline(always)]
pub fn horner<const N: usize>(c: &[f64; N], x: f64) -> (f64, f64) {
    let (mut value, mut slope) = (c[N - 1], 0.0);
    for &coefficient in c[..N - 1].iter().rev() {
        slope = slope * x + value;
        value = value * x + coefficient;
    }
    (value, slope)
}

/// The coefficients divided by a power of two near the largest, so that products neither overflow nor, for ordinary
/// polynomials, underflow. Coefficients of ordinary size are returned unchanged. All are NaN if one of them is not
/// finite.
#[inline(always)]
pub(crate) fn unit_sized<const N: usize>(c: [f64; N]) -> [f64; N] {
    const ORDINARY: std::ops::Range<f64> = 1e-30..1e30;
    let largest = c.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if !c.iter().all(|x| x.is_finite()) {
        return [f64::NAN; N];
    }
    if ORDINARY.contains(&largest) {
        return c;
    }
    // In two factors, each of which is a normal number.
    let exponent = -binary_exponent(largest);
    let (half, rest) = (libm::ldexp(1.0, exponent / 2), libm::ldexp(1.0, exponent - exponent / 2));
    c.map(|x| x * half * rest)
}

/// A power of two that no root exceeds in magnitude: Fujiwara's bound `2 max |c[n-k] / c[n]|^(1/k)`, computed from
/// the exponents alone, so that it scales exactly and cannot overflow.
pub(crate) fn root_bound<const N: usize>(c: &[f64; N]) -> f64 {
    let exponent = |x: f64| binary_exponent(x);
    let lead = exponent(c[N - 1]);
    let ratio = |(i, &x): (usize, &f64)| {
        let k = (N - 1 - i) as i32;
        // |x / lead| < 2^(difference + 1), and its k-th root is rounded up.
        (x != 0.0).then(|| (exponent(x) - lead + 1).div_euclid(k) + 1)
    };
    let reach = c[..N - 1].iter().enumerate().filter_map(ratio).max().unwrap_or(0);
    libm::ldexp(1.0, (reach + 1).min(1023))
}

#[cfg(test)]
mod tests;
