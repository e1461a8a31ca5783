//! The quartic of lines and a torus, as the product of two quadratics.

use crate::math::HALF_ULP;
use crate::simd::Doubles;

/// A bound on the error of the quartic at the torus, whose size is at most 1, from the rounding of its coefficients: some
/// 450 half ulps.
const QUARTIC_ERROR: f64 = 1024.0 * HALF_ULP;

/// The most steps for the resolvent. Few lines need more than seven.
const STEPS: usize = 24;

/// What lines have in common with the torus, by their points closest to its centre.
pub(super) struct Chords<F> {
    /// The square of the distance of these points.
    pub distance2: F,
    /// Their height above the equator, and that gained per unit of length along the line.
    pub height: F,
    pub rise: F,
}

/// The roots of a quadratic: `middle` plus or minus the square root of `rest`.
pub(super) struct Half<F> {
    pub middle: F,
    pub rest: F,
}

impl<F: Doubles> Half<F> {
    /// The lanes in which it has two.
    #[inline(always)]
    pub fn has_roots(&self) -> u8 {
        F::splat(0.0).is_less(self.rest)
    }

    #[inline(always)]
    pub fn where_set(&self, lanes: u8, other: &Half<F>) -> Half<F> {
        Half {
            middle: self.middle.where_set(lanes, other.middle),
            rest: self.rest.where_set(lanes, other.rest),
        }
    }
}

/// How far from a root other roots of the quartic may be: `error / least`.
pub(super) struct Rivals<F> {
    pub error: F,
    pub least: F,
}

/// The quartic `(|q|^2 + R^2 - r^2)^2 - 4 R^2 rho^2`, at points at a signed distance from the closest approach, as the
/// product of two quadratics.
pub(super) struct Factors<F> {
    /// The lower one first.
    pub halves: [Half<F>; 2],
    /// A bound on the difference of the quartic and the product, at the torus.
    error: F,
}

impl<F: Doubles> Factors<F> {
    #[inline(always)]
    pub fn new(chords: &Chords<F>, major: F, minor: F, lanes: u8) -> Factors<F> {
        let (one, two, half) = (F::splat(1.0), F::splat(2.0), F::splat(0.5));
        let four_major2 = F::splat(4.0) * major * major;
        let Chords { distance2, height, rise } = *chords;
        let k = distance2 + (major - minor) * (major + minor);
        let a = two * k - four_major2 * rise.neg_mul_add(rise, one);
        let b = two * four_major2 * height * rise;
        let c = k.mul_sub(k, four_major2 * height.neg_mul_add(height, distance2));
        let reach = major + minor;
        let chord2 = (reach * reach - distance2).greater(F::splat(0.0));
        let four_c = F::splat(4.0) * c;
        let sum2 = resolvent_root(a, a.mul_sub(a, four_c), b * b, F::splat(4.0) * chord2, lanes);
        // The sum of the constant terms, and the square of their difference. Their difference times the sum of the lowest
        // roots is b: the larger of the two is computed by a root, and the other one by a quotient.
        let terms = a + sum2;
        let difference2 = terms.mul_sub(terms, four_c);
        let by_sum = difference2.is_less(sum2);
        let larger = sum2.where_set(by_sum, difference2).sqrt();
        let quotient = b / larger;
        let sum = larger.where_set(by_sum, quotient.abs());
        let difference = (-quotient).where_set(by_sum, larger.where_negative(b, -larger));
        let (low, high) = (half * (terms + difference), half * (terms - difference));
        let middle = half * sum;
        let square = middle * middle;
        let error = (terms - sum.mul_add(sum, a)).abs()
            + (sum * difference + b).abs()
            + low.mul_sub(high, c).abs()
            + F::splat(QUARTIC_ERROR);
        Factors {
            halves: [Half { middle: -middle, rest: square - low }, Half { middle, rest: square - high }],
            error,
        }
    }

    /// The lanes in which neither quadratic has a root, nor the quartic.
    #[inline(always)]
    pub fn certain_misses(&self) -> u8 {
        let [first, second] = self.least();
        F::splat(0.0).is_less(first) & F::splat(0.0).is_less(second) & self.error.is_less(first * second)
    }

    /// Lower bounds of the quadratics that have no roots.
    #[inline(always)]
    fn least(&self) -> [F; 2] {
        let error = F::splat(16.0 * HALF_ULP);
        [-self.halves[0].rest - error, -self.halves[1].rest - error]
    }

    /// The rivals of the roots of the quadratic that has roots, apart from half the distance of these. Where both have
    /// roots there are none, as a quartic has four at most.
    #[inline(always)]
    pub fn rivals(&self, has_first: u8, both: u8) -> Rivals<F> {
        let [first, second] = self.least();
        let least = second.where_set(has_first, first);
        Rivals {
            error: F::splat(0.0).where_set(both, F::splat(2.0) * self.error),
            least: F::splat(1.0).where_set(both, least),
        }
    }
}

/// The largest root of `y^3 + 2 a y^2 + c1 y - c0`, by Halley's method (1694): each lane by its own steps. They begin at
/// `start`, above the root, or at zero if it is the only one and the cubic bends the other way there; so they do not run
/// into stationary points. A wrong root shows in the error of the factors.
#[inline(always)]
fn resolvent_root<F: Doubles>(a: F, c1: F, c0: F, start: F, lanes: u8) -> F {
    let (zero, two) = (F::splat(0.0), F::splat(2.0));
    let c2 = two * a;
    let bend = (c2 * F::splat(-1.0 / 3.0)).greater(zero);
    let at_bend = (bend + c2).mul_add(bend, c1).mul_sub(bend, c0);
    let spread2 = bend.mul_sub(bend, c1 * F::splat(1.0 / 3.0));
    let is_single = (F::splat(4.0) * spread2 * spread2 * spread2).is_less(at_bend * at_bend);
    let mut y = zero.where_set(zero.is_less(at_bend) & is_single, start);
    let mut moving = lanes;
    for _ in 0..STEPS {
        let value = (y + c2).mul_add(y, c1).mul_sub(y, c0);
        let slope = F::splat(3.0).mul_add(y, two * c2).mul_add(y, c1);
        let half_turn = F::splat(3.0).mul_add(y, c2);
        let step = value * slope / value.neg_mul_add(half_turn, slope * slope);
        y = (y - step).greater(zero).where_set(moving, y);
        let small = F::splat(1e-5).mul_add(y, F::splat(1e-15));
        moving &= small.is_less(step.abs());
        if moving == 0 {
            break;
        }
    }
    y
}
