//! The implicit function of the torus along a line, with its derivatives and bounds on its rounding error.

use super::approach::{Approach, rounded};
use crate::math::{Dd, HALF_ULP, Vec3, two_prod, two_sum};

/// `f(tau) = (rho - R)^2 + z^2 - r^2` on the line `p + tau u`, with `rho^2 = x^2 + y^2`.
///
/// All signs are those of `f`, not of the quartic. `f` does not cancel for thin rings and has no zero inside a
/// spindle.
pub(super) struct TorusFunction<'a> {
    line: &'a Approach,
    p: Vec3,
    major: f64,
    minor: f64,
    minor_squared: Dd,
}

/// A point of the line with the quantities that everything else is computed from.
#[derive(Clone, Copy)]
pub(super) struct LinePoint {
    tau: f64,
    q: Vec3,
    rho: f64,
    /// `rho - R`.
    e: f64,
}

impl<'a> TorusFunction<'a> {
    #[inline(always)]
    pub fn new(line: &'a Approach, major: f64, minor: f64) -> TorusFunction<'a> {
        TorusFunction { line, p: rounded(&line.p), major, minor, minor_squared: two_prod(minor, minor) }
    }

    #[inline(always)]
    pub fn at(&self, tau: f64) -> LinePoint {
        let q = self.p + self.line.u * tau;
        // Positive, so that it can be a divisor. Next to the axis x / rho and y / rho become zero.
        let rho = (q.x * q.x + q.y * q.y).sqrt().max(1e-150);
        LinePoint { tau, q, rho, e: rho - self.major }
    }

    /// `f` in f64.
    #[inline(always)]
    pub fn value(&self, at: &LinePoint) -> f64 {
        at.e * at.e + at.q.z * at.q.z - self.minor * self.minor
    }

    /// A bound on the error of `value`: the weighted errors of `rho - R` and `z`, and those of the sums.
    #[inline(always)]
    pub fn value_error(&self, at: &LinePoint) -> f64 {
        let unit = 16.0 * HALF_ULP;
        let u = self.line.u.abs() * at.tau.abs() + self.p.abs();
        let size = u.x + u.y + u.z + self.major;
        let off = at.e.abs() + at.q.z.abs();
        unit * (size * (off + unit * size) + self.minor * self.minor)
    }

    /// `f` with twice the digits: every intermediate result is an f64 and its rounding error.
    #[inline(always)]
    pub fn wide_value(&self, tau: Dd) -> f64 {
        let [x, y, z] = std::array::from_fn(|i| {
            let (p, u) = (self.line.p[i], self.line.u[i]);
            let way = two_prod(tau.hi, u);
            let q = two_sum(p.hi, way.hi);
            Dd { hi: q.hi, lo: q.lo + (way.lo + tau.lo * u + p.lo) }
        });
        let rho2 = sum_of_squares(x, y);
        let rho = rho2.hi.sqrt();
        let rho_squared = two_prod(rho, rho);
        let rest = (rho2.hi - rho_squared.hi) + (rho2.lo - rho_squared.lo);
        let mut e = two_sum(rho, -self.major);
        e.lo += if rho > 0.0 { rest / (2.0 * rho) } else { 0.0 };
        let distance2 = sum_of_squares(e, z);
        (distance2.hi - self.minor_squared.hi) + (distance2.lo - self.minor_squared.lo)
    }

    /// A bound on the error of `wide_value`: the same sum with double-double rounding errors and a margin.
    #[inline(always)]
    pub fn wide_error(&self, at: &LinePoint) -> f64 {
        self.value_error(at) * (16.0 * HALF_ULP)
    }

    /// `f` with the correct sign. Uses double-double where f64 is not certain of the sign. Returns zero where
    /// double-double is not certain either, as where a line passes through the point at which a horn torus
    /// touches itself.
    #[inline(always)]
    pub fn signed_value(&self, tau: f64) -> f64 {
        let at = self.at(tau);
        let value = self.value(&at);
        if value.abs() > self.value_error(&at) {
            return value;
        }
        let wide = self.wide_value(Dd::from(tau));
        if wide.abs() > self.wide_error(&at) { wide } else { 0.0 }
    }

    /// `f'`.
    #[inline(always)]
    pub fn slope(&self, at: &LinePoint) -> f64 {
        2.0 * (at.e * (self.across(at) / at.rho) + at.q.z * self.line.u.z)
    }

    /// `rho' rho`.
    #[inline(always)]
    fn across(&self, at: &LinePoint) -> f64 {
        at.q.x * self.line.u.x + at.q.y * self.line.u.y
    }

    /// A bound on the rounding error of `slope`.
    #[inline(always)]
    pub fn slope_error(&self, at: &LinePoint) -> f64 {
        let size = self.p.abs().element_sum() + at.tau.abs() + self.major;
        32.0 * HALF_ULP * size * (1.0 + at.e.abs() / at.rho)
    }

    /// A bound on the second derivatives of the torus function in space, in any direction, up to a distance of
    /// half the distance to the axis.
    #[inline(always)]
    pub fn curvature_bound(&self, at: &LinePoint) -> f64 {
        2.0 + 4.0 * (at.e.abs() / at.rho + 0.5)
    }

    /// A bound on the change of `f` if the point moves by up to `by` in each component.
    #[inline(always)]
    pub fn perturbation_bound(&self, at: &LinePoint, by: Vec3) -> f64 {
        let outward = at.e.abs() / at.rho;
        let q = at.q.abs();
        let first = 2.0 * (outward * (q.x * by.x + q.y * by.y) + q.z * by.z);
        let curved = first + 2.0 * self.curvature_bound(at) * by.length_squared();
        // Next to the axis the curvature of f is unbounded, but rho changes by no more than the point moves.
        let across = by.x + by.y;
        curved.min((2.0 * at.e.abs() + across) * across + (2.0 * q.z + by.z) * by.z)
    }
}

/// `a^2 + b^2` with an error of the order of the square of an ulp.
#[inline(always)]
fn sum_of_squares(a: Dd, b: Dd) -> Dd {
    let (a2, b2) = (two_prod(a.hi, a.hi), two_prod(b.hi, b.hi));
    let sum = two_sum(a2.hi, b2.hi);
    let low = a.lo * (2.0 * a.hi + a.lo) + b.lo * (2.0 * b.hi + b.lo);
    Dd { hi: sum.hi, lo: sum.lo + (a2.lo + b2.lo + low) }
}
