//! A line relative to its closest approach.
//!
//! Expanded about a far origin, the coefficients of the quartic lose all their digits, and no root finder can
//! recover them. So the line first gets a nearby origin, without rounding error.

use crate::math::{Dd, PowerOfTwo, Vec3, binary_exponent, two_prod};
use crate::ray::Line;
use crate::solid::ring::implicit::rounded;

/// The line `p + tau u` in units of the solid's size, with `p` near the point closest to the centre.
pub(super) struct Approach {
    /// The new origin, accurate to about 100 bits.
    pub p: [Dd; 3],
    /// The direction: the line's, scaled by a power of two so that its longest component is between 1/2 and 1.
    pub u: Vec3,
    /// `u . u`.
    pub uu: f64,
    /// Minus the `tau` of the line's own origin.
    shift: Dd,
    /// The factor that converts `shift + tau` to `t`.
    t_unit: PowerOfTwo,
}

impl Approach {
    /// Moves the origin of a line close to the centre of a solid whose size has the given binary exponent.
    #[inline(always)]
    pub fn new(line: &Line, size_exponent: i32) -> Approach {
        let direction_exponent = binary_exponent(line.d.abs().max_element());
        let u = PowerOfTwo::new(-direction_exponent).of(line.d);
        let o = PowerOfTwo::new(-size_exponent).of(line.o);
        let uu = u.length_squared();
        let mut p = o.to_array().map(Dd::from);
        let mut shift = Dd::ZERO;
        // Any f64 near the closest approach will do, as p is computed to match it. From extremely far away the
        // nearest f64 is not near, so the move is repeated.
        for _ in 0..3 {
            let step = -Vec3::from(rounded(&p)).dot(u) / uu;
            p = std::array::from_fn(|i| p[i] + two_prod(step, u[i]));
            shift = shift + Dd::from(step);
            if Vec3::from(rounded(&p)).dot(u).abs() < 1e-6 {
                break;
            }
        }
        Approach { p, u, uu, shift, t_unit: PowerOfTwo::new(size_exponent - direction_exponent) }
    }

    /// Converts `tau` to the line's own parameter, rounded once.
    #[inline(always)]
    pub fn t(&self, tau: Dd) -> f64 {
        self.t_unit.times((self.shift + tau).hi)
    }

    /// The magnitude of `shift + tau`, to which an ulp of `t` is relative, in units of `tau`.
    #[inline(always)]
    pub fn reach(&self, tau: f64) -> f64 {
        (self.shift.hi + tau).abs()
    }

    /// Converts a difference of `tau` to a difference of `t`.
    #[inline(always)]
    pub fn t_length(&self, tau: f64) -> f64 {
        self.t_unit.times(tau)
    }
}
