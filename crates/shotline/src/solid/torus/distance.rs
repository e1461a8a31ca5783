//! The torus function along a line, with its derivatives and bounds for its rounding.

use super::approach::{Approach, rounded};
use crate::math::{Dd, HALF_ULP, Vec3, two_prod};

/// `f(tau) = (rho - R)^2 + z^2 - r^2` on the line `p + tau u`, with `rho^2 = x^2 + y^2`.
///
/// Every sign is that of `f`, not of the quartic: `f` does not cancel for thin rings and has no zero inside a
/// spindle.
pub(super) struct Distance<'a> {
    line: &'a Approach,
    p: Vec3,
    major: f64,
    minor: f64,
    minor_squared: Dd,
}

/// A point of the line, and what everything about it is computed from.
#[derive(Clone, Copy)]
pub(super) struct Place {
    tau: f64,
    q: Vec3,
    rho: f64,
    /// `rho - R`.
    e: f64,
}

impl<'a> Distance<'a> {
    pub fn new(line: &'a Approach, major: f64, minor: f64) -> Distance<'a> {
        Distance { line, p: rounded(&line.p), major, minor, minor_squared: two_prod(minor, minor) }
    }

    pub fn at(&self, tau: f64) -> Place {
        let q = self.p + self.line.u * tau;
        let rho = (q.x * q.x + q.y * q.y).sqrt();
        Place { tau, q, rho, e: rho - self.major }
    }

    /// `f` in double arithmetic.
    pub fn value(&self, at: &Place) -> f64 {
        at.e * at.e + at.q.z * at.q.z - self.minor * self.minor
    }

    /// A bound on the error of `value`: the errors of `rho - R` and `z` times their weight, and of the sums.
    pub fn value_error(&self, at: &Place) -> f64 {
        let unit = 16.0 * HALF_ULP;
        let u = self.line.u.abs() * at.tau.abs() + self.p.abs();
        let size = u.x + u.y + u.z + self.major;
        let off = at.e.abs() + at.q.z.abs();
        unit * (size * (off + unit * size) + self.minor * self.minor)
    }

    /// `f` in double-double arithmetic.
    pub fn wide_value(&self, tau: Dd) -> f64 {
        let q: [Dd; 3] = std::array::from_fn(|i| self.line.p[i] + tau * self.line.u[i]);
        let e = (q[0] * q[0] + q[1] * q[1]).sqrt() - Dd::from(self.major);
        (e * e + q[2] * q[2] - self.minor_squared).hi
    }

    /// A bound on the error of `wide_value`: the same sum with the roundings of double-double, with room.
    pub fn wide_error(&self, at: &Place) -> f64 {
        self.value_error(at) * (16.0 * HALF_ULP)
    }

    /// -1 inside, 1 outside, 0 on the surface; in double-double arithmetic where double is not sure.
    pub fn sign(&self, tau: f64) -> f64 {
        let at = self.at(tau);
        let mut value = self.value(&at);
        if value.abs() <= self.value_error(&at) {
            value = self.wide_value(Dd::from(tau));
        }
        if value == 0.0 { 0.0 } else { value.signum() }
    }

    /// `f'`.
    pub fn slope(&self, at: &Place) -> f64 {
        let u = self.line.u;
        2.0 * (at.outward() * (at.q.x * u.x + at.q.y * u.y) + at.q.z * u.z)
    }

    /// A bound on the rounding of `slope`.
    pub fn slope_error(&self, at: &Place) -> f64 {
        let size = self.p.abs().element_sum() + at.tau.abs() + self.major;
        32.0 * HALF_ULP * size * (1.0 + at.outward().abs())
    }

    /// `f''`.
    pub fn curvature(&self, at: &Place) -> f64 {
        let u = self.line.u;
        let flat = u.x * u.x + u.y * u.y;
        let radial = if at.rho > 0.0 { (at.q.x * u.x + at.q.y * u.y) / at.rho } else { 0.0 };
        2.0 * (radial * radial + u.z * u.z + at.outward() * (flat - radial * radial))
    }

    /// A bound on the second derivatives of the torus function in space, in any direction, as far around as
    /// half the distance to the axis.
    pub fn bend(&self, at: &Place) -> f64 {
        2.0 + 4.0 * (at.e.abs() / at.rho + 0.5)
    }

    /// What moving the point by up to `by`, in each component, can do to `f`.
    pub fn shaken(&self, at: &Place, by: Vec3) -> f64 {
        if by == Vec3::ZERO {
            return 0.0;
        }
        let outward = at.outward().abs();
        let q = at.q.abs();
        let first = 2.0 * (outward * (q.x * by.x + q.y * by.y) + q.z * by.z);
        first + 2.0 * self.bend(at) * by.length_squared()
    }
}

impl Place {
    /// `(rho - R) / rho`, the weight of x and y in the gradient; zero on the axis, where it has no limit.
    fn outward(&self) -> f64 {
        if self.rho > 0.0 { self.e / self.rho } else { 0.0 }
    }
}
