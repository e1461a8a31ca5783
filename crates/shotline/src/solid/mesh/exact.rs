//! Exact sums of products, for the few cases that rounding leaves undecided.
//!
//! Expansions after J. R. Shewchuk (1997, "Adaptive precision floating-point arithmetic and fast robust geometric
//! predicates"): a number is a sum of f64 components that do not overlap. A fused multiply-add splits products without
//! error. Results are exact as long as no component of a product underflows. Vectors are scaled to size 1 first, so
//! only components below 1e-300 of the whole are at risk.

use crate::math::{Dd, Real, Vec3, binary_exponent, two_prod, two_sum};

/// A vector of double-doubles.
pub(super) type Wide<T = f64> = [Dd<T>; 3];

/// `a - b` without error.
#[inline(always)]
pub(super) fn minus<T: Real>(a: impl Into<[T; 3]>, b: impl Into<[T; 3]>) -> Wide<T> {
    let (a, b) = (a.into(), b.into());
    // Not `from_fn`, which is not inlined where `T` is a vector register.
    [two_sum(a[0], -b[0]), two_sum(a[1], -b[1]), two_sum(a[2], -b[2])]
}

/// A vector of f64 as double-doubles.
pub(super) fn wide(v: Vec3) -> Wide {
    v.to_array().map(Dd::from)
}

/// The largest absolute value of the components.
pub(super) fn size(v: &Wide) -> f64 {
    v[0].hi.abs().max(v[1].hi.abs()).max(v[2].hi.abs())
}

/// Scales a vector to size 1 by a power of two, and returns the exponent of that power.
pub(super) fn unit_sized(v: &Wide) -> (Wide, i32) {
    let exponent = binary_exponent(size(v));
    let scale = |x: f64| libm::ldexp(x, -exponent);
    (v.map(|x| Dd { hi: scale(x.hi), lo: scale(x.lo) }), exponent)
}

/// The largest number of components of a sum. A determinant is six products of three double-doubles; each of the eight
/// products of their components has four components.
const MAX_COMPONENTS: usize = 6 * 8 * 4;

/// An exact sum: its components do not overlap, ascend in size, and are not zero.
#[derive(Clone, Debug)]
pub(super) struct Expansion {
    components: [f64; MAX_COMPONENTS],
    len: usize,
}

impl Expansion {
    const ZERO: Expansion = Expansion { components: [0.0; MAX_COMPONENTS], len: 0 };

    /// The determinant of three vectors, `u x v . w`.
    pub(super) fn determinant(u: &Wide, v: &Wide, w: &Wide) -> Expansion {
        let mut sum = Expansion::ZERO;
        for (i, component) in w.iter().enumerate() {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            sum.add_product(u[j], v[k], *component, 1.0);
            sum.add_product(u[k], v[j], *component, -1.0);
        }
        sum
    }

    /// A component of `u x v`.
    pub(super) fn minor(u: &Wide, v: &Wide, i: usize) -> Expansion {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let mut sum = Expansion::ZERO;
        sum.add_product(u[j], v[k], Dd::ONE, 1.0);
        sum.add_product(u[k], v[j], Dd::ONE, -1.0);
        sum
    }

    /// Adds `a b c`, with a sign.
    fn add_product(&mut self, a: Dd, b: Dd, c: Dd, sign: f64) {
        let components = |x: Dd| [x.hi, x.lo].into_iter().filter(|part| *part != 0.0);
        for (x, y) in components(a).flat_map(|x| components(b).map(move |y| (x, y))) {
            for (xy, z) in
                components(two_prod(sign * x, y)).flat_map(|xy| components(c).map(move |z| (xy, z)))
            {
                components(two_prod(xy, z)).for_each(|part| self.add(part));
            }
        }
    }

    /// Adds a number (Shewchuk's GROW-EXPANSION, without zeros).
    fn add(&mut self, x: f64) {
        let (mut carried, mut kept) = (x, 0);
        for i in 0..self.len {
            let sum = two_sum(carried, self.components[i]);
            carried = sum.hi;
            if sum.lo != 0.0 {
                self.components[kept] = sum.lo;
                kept += 1;
            }
        }
        if carried != 0.0 {
            self.components[kept] = carried;
            kept += 1;
        }
        self.len = kept;
    }

    /// The sum as a double-double: its relative error is at most 1e-31, and its sign is exact.
    pub(super) fn value(&self) -> Dd {
        self.components[..self.len].iter().fold(Dd::ZERO, |sum, part| sum + Dd::from(*part))
    }

    /// Compares the sum to zero.
    pub(super) fn sign(&self) -> std::cmp::Ordering {
        // The other components are smaller than the last one's ulp, so the last has the sign of the sum.
        self.components[..self.len].last().map_or(std::cmp::Ordering::Equal, |part| part.total_cmp(&0.0))
    }
}

#[cfg(test)]
mod tests {
    use std::cmp::Ordering;

    use num_rational::BigRational;
    use num_traits::{Signed, Zero};

    use super::*;
    use crate::testkit::random::Random;

    fn exact(x: Dd) -> BigRational {
        BigRational::from_float(x.hi).unwrap() + BigRational::from_float(x.lo).unwrap()
    }

    /// Differences of random points with few bits or up to 53, far apart or close to each other.
    fn difference(random: &mut Random) -> Wide {
        let mut point = || {
            let size = 2f64.powi(random.below(60) as i32 - 30);
            let p = random.point(-size, size);
            if random.below(2) == 0 { (p * 4.0 / size).round() * size } else { p }
        };
        minus(point(), point())
    }

    #[test]
    fn determinants_have_the_sign_and_the_value_of_fractions() {
        let mut random = Random::new(3);
        let (mut zeros, mut lost) = (0, 0);
        for case in 0..2000 {
            let (u, mut v, mut w) =
                (difference(&mut random), difference(&mut random), difference(&mut random));
            if case % 4 == 0 {
                // A multiple, so that the determinant is zero.
                v = u.map(|x| Dd { hi: 4.0 * x.hi, lo: 4.0 * x.lo });
            }
            if case % 4 == 1 {
                // Nearly a multiple.
                w = u.map(|x| Dd { hi: x.hi * 0.5, lo: x.lo * 0.5 });
                w[case % 3] = two_sum(w[case % 3].hi, w[case % 3].hi * 2f64.powi(-70));
            }
            let term = |i: usize, j: usize, k: usize| exact(u[j]) * exact(v[k]) * exact(w[i]);
            let expected = (0..3)
                .map(|i| term(i, (i + 1) % 3, (i + 2) % 3) - term(i, (i + 2) % 3, (i + 1) % 3))
                .fold(BigRational::zero(), |sum, x| sum + x);
            let found = Expansion::determinant(&u, &v, &w);
            assert_eq!(found.sign(), expected.cmp(&BigRational::zero()), "{u:?} {v:?} {w:?}");
            let error = (exact(found.value()) - &expected).abs();
            assert!(error <= expected.abs() * BigRational::from_float(1e-31).unwrap());
            zeros += usize::from(expected.is_zero());
            let rounded = u[0].hi * (v[1].hi * w[2].hi - v[2].hi * w[1].hi)
                + u[1].hi * (v[2].hi * w[0].hi - v[0].hi * w[2].hi)
                + u[2].hi * (v[0].hi * w[1].hi - v[1].hi * w[0].hi);
            lost += usize::from(rounded.partial_cmp(&0.0) != Some(found.sign()));
        }
        assert!(zeros >= 500 && lost >= 200, "{zeros} {lost}");
    }

    #[test]
    fn unit_sized_vectors_differ_by_a_power_of_two() {
        let v = minus(Vec3::new(3e-200, 1e-210, 0.0), Vec3::new(1e-230, 0.0, 0.0));
        let (unit, exponent) = unit_sized(&v);
        assert!((0.5..1.0).contains(&size(&unit)));
        assert!((0..3).all(|i| libm::ldexp(unit[i].hi, exponent) == v[i].hi));
        assert_eq!(Expansion::ZERO.sign(), Ordering::Equal);
    }
}
