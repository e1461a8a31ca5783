//! The set where a polynomial of degree 2 is negative, with bounds on the rounding errors of its roots.

use crate::math::HALF_ULP;

/// The factor by which a discriminant must exceed its error. The roots are `2 sqrt(D) / a` apart, and each has an
/// error of about `error / (2 a sqrt(D))`. The gap is then 256 bounds wide; 16 would still make the roots
/// coincident.
pub(super) const SEPARATION: f64 = 64.0;

/// The polynomial `a x^2 + 2 b x + c`, with bounds on its rounding errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quadratic {
    pub a: f64,
    pub b: f64,
    pub c: f64,
    /// `b^2 - a c`, which may be more accurate than `a`, `b` and `c`.
    pub discriminant: f64,
    /// Sums of the absolute values of the terms of `a`, `b` and `c`.
    pub size: [f64; 3],
    /// The relative error of those terms. The error of `a` is at most `noise * size[0]`, and so on.
    pub noise: f64,
}

/// The set of parameters at which a polynomial is negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SignIntervals {
    Nowhere,
    Everywhere,
    Between(f64, f64),
    Outside(f64, f64),
    Before(f64),
    After(f64),
}

impl Quadratic {
    /// Whether rounding cannot have changed the number of roots. The leading coefficient and the discriminant
    /// must exceed their errors, the discriminant by enough to keep two roots many bounds apart. Coefficients
    /// without terms are exact zeros.
    pub fn is_certain(&self) -> bool {
        let [a, b, c] = self.size;
        if a == 0.0 {
            return self.b.abs() > self.noise * b || b == 0.0;
        }
        let doubt = 2.0 * self.b.abs() * b + self.a.abs() * c + self.c.abs() * a;
        self.a.abs() > self.noise * a && self.discriminant.abs() > SEPARATION * self.noise * doubt
    }

    /// Returns the set where the polynomial is negative. A double root bounds nothing.
    ///
    /// The root of larger magnitude is computed from a sum without cancellation, the other from the product of
    /// both (Forsythe 1966; Press et al., Numerical Recipes 5.6).
    pub fn negative(&self) -> SignIntervals {
        let Quadratic { a, b, c, .. } = *self;
        if a == 0.0 {
            return Quadratic::negative_half(b, c);
        }
        if self.discriminant <= 0.0 {
            return if a < 0.0 { SignIntervals::Everywhere } else { SignIntervals::Nowhere };
        }
        let q = -(b + self.discriminant.sqrt().copysign(b));
        let (x, y) = (q / a, c / q);
        let (low, high) = if x < y { (x, y) } else { (y, x) };
        if a > 0.0 { SignIntervals::Between(low, high) } else { SignIntervals::Outside(low, high) }
    }

    /// The set where `2 b x + c` is negative.
    fn negative_half(b: f64, c: f64) -> SignIntervals {
        let root = -c / (2.0 * b);
        if b > 0.0 {
            SignIntervals::Before(root)
        } else if b < 0.0 {
            SignIntervals::After(root)
        } else if c < 0.0 {
            SignIntervals::Everywhere
        } else {
            SignIntervals::Nowhere
        }
    }

    /// A bound on the error of the polynomial's value at a root due to rounding of the coefficients.
    pub fn residual(&self, root: f64) -> f64 {
        let [a, b, c] = self.size;
        self.noise * (c + root.abs() * (2.0 * b + root.abs() * a))
    }

    /// Bounds the distance from a root to the true root if the polynomial's value at the root is wrong by
    /// `residual`.
    ///
    /// The slope at a root is twice the square root of the discriminant. Near a tangent the slope vanishes and
    /// the curvature bounds the shift. While both roots exist, the result is the exact shift of a root of
    /// `a x^2 - slope x + residual`. Where they do not, it is the distance at which they have merged.
    pub fn root_err(&self, root: f64, residual: f64) -> f64 {
        let curvature = self.a.abs();
        // The final operations, from the discriminant to the root, are each rounded once.
        let arithmetic = 3.0 * HALF_ULP * root.abs();
        if curvature == 0.0 {
            return residual / (2.0 * self.b.abs()) + arithmetic;
        }
        let slope = 2.0 * self.discriminant.sqrt();
        let rest = slope * slope - 4.0 * curvature * residual;
        let shift =
            if rest > 0.0 { 2.0 * residual / (slope + rest.sqrt()) } else { (residual / curvature).sqrt() };
        shift + arithmetic
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact(a: f64, b: f64, c: f64) -> Quadratic {
        Quadratic { a, b, c, discriminant: b * b - a * c, size: [a.abs(), b.abs(), c.abs()], noise: 1e-15 }
    }

    #[test]
    fn every_sign_has_its_set() {
        assert_eq!(exact(1.0, 0.0, -4.0).negative(), SignIntervals::Between(-2.0, 2.0));
        assert_eq!(exact(-1.0, 0.0, 4.0).negative(), SignIntervals::Outside(-2.0, 2.0));
        assert_eq!(exact(1.0, 0.0, 4.0).negative(), SignIntervals::Nowhere);
        assert_eq!(exact(-1.0, 0.0, -4.0).negative(), SignIntervals::Everywhere);
        assert_eq!(exact(0.0, 1.0, -4.0).negative(), SignIntervals::Before(2.0));
        assert_eq!(exact(0.0, -1.0, -4.0).negative(), SignIntervals::After(-2.0));
        assert_eq!(exact(0.0, 0.0, -4.0).negative(), SignIntervals::Everywhere);
        assert_eq!(exact(0.0, 0.0, 0.0).negative(), SignIntervals::Nowhere);
    }

    #[test]
    fn touching_bounds_nothing() {
        assert_eq!(exact(1.0, 1.0, 1.0).negative(), SignIntervals::Nowhere);
        assert_eq!(exact(-1.0, 1.0, -1.0).negative(), SignIntervals::Everywhere);
        assert!(!exact(1.0, 1.0, 1.0).is_certain());
    }

    #[test]
    fn small_roots_keep_their_digits() {
        let SignIntervals::Between(low, high) = exact(1.0, -1e8, 1.0).negative() else { panic!("two roots") };
        assert_eq!(low, 5e-9);
        assert_eq!(high, 2e8);
    }

    #[test]
    fn errors_near_a_tangent_are_roots_not_infinities() {
        let tangent = exact(1.0, 0.0, -1e-20);
        let err = tangent.root_err(1e-10, 1e-16);
        assert!((0.9e-8..1.1e-8).contains(&err), "{err}");
    }
}
