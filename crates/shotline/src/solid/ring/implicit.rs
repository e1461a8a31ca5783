//! The implicit function of the torus along lines, with its derivatives and bounds on its rounding error.

use crate::lanes::vector::{Vectors, abs, dot, scale};
use crate::math::{Dd, HALF_ULP, Real, two_prod, two_sum};
use crate::simd::Doubles;

/// `f(tau) = (rho - R)^2 + z^2 - r^2` on the line `p + tau u`, with `rho^2 = x^2 + y^2`. Of one line, or of one in
/// each lane.
///
/// All signs are those of `f`, not of the quartic. `f` does not cancel for thin rings and has no zero inside a
/// spindle.
pub(in crate::solid) struct TorusFunction<F> {
    p: [Dd<F>; 3],
    u: Vectors<F>,
    major: F,
    minor: F,
    minor_squared: Dd<F>,
}

/// A point of the line with the quantities that everything else is computed from.
#[derive(Clone, Copy)]
pub(in crate::solid) struct LinePoint<F> {
    tau: F,
    q: Vectors<F>,
    rho: F,
    per_rho: F,
    /// `rho - R`.
    e: F,
    /// `|e| / rho`.
    outward: F,
}

impl<F: Doubles> TorusFunction<F> {
    #[inline(always)]
    pub fn new(p: [Dd<F>; 3], u: Vectors<F>, major: F, minor: F) -> TorusFunction<F> {
        TorusFunction { p, u, major, minor, minor_squared: two_prod(minor, minor) }
    }

    #[inline(always)]
    pub fn minor(&self) -> F {
        self.minor
    }

    #[inline(always)]
    pub fn at(&self, tau: F) -> LinePoint<F> {
        let (p, u) = (rounded(&self.p), self.u);
        let q = [u[0].mul_add(tau, p[0]), u[1].mul_add(tau, p[1]), u[2].mul_add(tau, p[2])];
        // Positive, so that it can be a divisor. Next to the axis x / rho and y / rho become zero.
        let rho = (q[0] * q[0] + q[1] * q[1]).sqrt().greater(F::splat(1e-150));
        let (per_rho, e) = (F::splat(1.0) / rho, rho - self.major);
        LinePoint { tau, q, rho, per_rho, e, outward: e.abs() * per_rho }
    }

    /// `f` in f64.
    #[inline(always)]
    pub fn value(&self, at: &LinePoint<F>) -> F {
        at.e * at.e + at.q[2] * at.q[2] - self.minor * self.minor
    }

    /// A bound on the error of `value`: the weighted errors of `rho - R` and `z`, and those of the sums.
    #[inline(always)]
    pub fn value_error(&self, at: &LinePoint<F>) -> F {
        let unit = F::splat(16.0 * HALF_ULP);
        let (p, way) = (abs(rounded(&self.p)), scale(abs(self.u), at.tau.abs()));
        let size = (way[0] + p[0]) + (way[1] + p[1]) + (way[2] + p[2]) + self.major;
        let off = at.e.abs() + at.q[2].abs();
        unit * (size * (off + unit * size) + self.minor * self.minor)
    }

    /// `f` with twice the digits: every intermediate result is an f64 and its rounding error.
    #[inline(always)]
    pub fn wide_value(&self, tau: Dd<F>) -> F {
        let rho2 = sum_of_squares(self.wide(0, tau), self.wide(1, tau));
        let rho = rho2.hi.sqrt();
        let zero = F::splat(0.0);
        let rest = (remainder(rho2, rho) / (F::splat(2.0) * rho)).where_set(zero.is_less(rho), zero);
        self.wide_value_from(rho, rest, self.wide(2, tau))
    }

    /// As [`TorusFunction::wide_value`], from a point that is not next to the axis, without another root and quotient.
    #[inline(always)]
    pub fn wide_value_at(&self, at: &LinePoint<F>) -> F {
        let tau = Dd::from(at.tau);
        let rho2 = sum_of_squares(self.wide(0, tau), self.wide(1, tau));
        let half = F::splat(0.5) * at.per_rho;
        let rest = remainder(rho2, at.rho) * half;
        // The rest of the series of the root is less than the rounding errors.
        self.wide_value_from(at.rho, rest - rest * rest * half, self.wide(2, tau))
    }

    #[inline(always)]
    fn wide_value_from(&self, rho: F, rest: F, z: Dd<F>) -> F {
        let mut e = two_sum(rho, -self.major);
        e.lo = e.lo + rest;
        let distance2 = sum_of_squares(e, z);
        (distance2.hi - self.minor_squared.hi) + (distance2.lo - self.minor_squared.lo)
    }

    /// A coordinate of the point at `tau`.
    #[inline(always)]
    fn wide(&self, axis: usize, tau: Dd<F>) -> Dd<F> {
        let (p, u) = (self.p[axis], self.u[axis]);
        let way = two_prod(tau.hi, u);
        let q = two_sum(p.hi, way.hi);
        Dd { hi: q.hi, lo: q.lo + (way.lo + tau.lo * u + p.lo) }
    }

    /// A bound on the error of `wide_value`: the same sum with double-double rounding errors and a margin.
    #[inline(always)]
    pub fn wide_error(&self, at: &LinePoint<F>) -> F {
        self.value_error(at) * F::splat(16.0 * HALF_ULP)
    }

    /// `f'`.
    #[inline(always)]
    pub fn slope(&self, at: &LinePoint<F>) -> F {
        F::splat(2.0) * (at.e * (self.across(at) * at.per_rho) + at.q[2] * self.u[2])
    }

    /// `rho' rho`.
    #[inline(always)]
    fn across(&self, at: &LinePoint<F>) -> F {
        at.q[0] * self.u[0] + at.q[1] * self.u[1]
    }

    /// A bound on the rounding error of `slope`.
    #[inline(always)]
    pub fn slope_error(&self, at: &LinePoint<F>) -> F {
        let p = abs(rounded(&self.p));
        let size = p[0] + p[1] + p[2] + at.tau.abs() + self.major;
        F::splat(32.0 * HALF_ULP) * size * (F::splat(1.0) + at.outward)
    }

    /// A bound on the second derivatives of the torus function in space, in any direction, up to a distance of
    /// half the distance to the axis.
    #[inline(always)]
    pub fn curvature_bound(&self, at: &LinePoint<F>) -> F {
        F::splat(2.0) + F::splat(4.0) * (at.outward + F::splat(0.5))
    }

    /// A bound on the change of `f` if the point moves by up to `by` in each component.
    #[inline(always)]
    pub fn perturbation_bound(&self, at: &LinePoint<F>, by: Vectors<F>) -> F {
        let (two, q) = (F::splat(2.0), abs(at.q));
        // Next to the axis the curvature of f is unbounded, but rho changes by no more than the point moves.
        let across = by[0] + by[1];
        let at_axis = (two * at.e.abs() + across) * across + (two * q[2] + by[2]) * by[2];
        self.perturbation_bound_off_axis(at, by).lesser(at_axis)
    }

    /// As [`TorusFunction::perturbation_bound`], for less than half the distance from the axis.
    #[inline(always)]
    pub fn perturbation_bound_off_axis(&self, at: &LinePoint<F>, by: Vectors<F>) -> F {
        let (two, q) = (F::splat(2.0), abs(at.q));
        let first = two * (at.outward * (q[0] * by[0] + q[1] * by[1]) + q[2] * by[2]);
        first + two * self.curvature_bound(at) * dot(by, by)
    }
}

impl TorusFunction<f64> {
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
}

/// `a - b^2`, for `b` near the root of `a`.
#[inline(always)]
fn remainder<F: Real>(a: Dd<F>, b: F) -> F {
    let square = two_prod(b, b);
    (a.hi - square.hi) + (a.lo - square.lo)
}

/// Double-double coordinates rounded to f64.
#[inline(always)]
pub(in crate::solid) fn rounded<F: Real>(p: &[Dd<F>; 3]) -> [F; 3] {
    [p[0].hi, p[1].hi, p[2].hi]
}

/// `a^2 + b^2` with an error of the order of the square of an ulp.
#[inline(always)]
fn sum_of_squares<F: Real>(a: Dd<F>, b: Dd<F>) -> Dd<F> {
    let (a2, b2) = (two_prod(a.hi, a.hi), two_prod(b.hi, b.hi));
    let sum = two_sum(a2.hi, b2.hi);
    let two = F::splat(2.0);
    let low = a.lo * (two * a.hi + a.lo) + b.lo * (two * b.hi + b.lo);
    Dd { hi: sum.hi, lo: sum.lo + (a2.lo + b2.lo + low) }
}
