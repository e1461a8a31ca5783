//! Computes where a line meets the plane of a triangle.
//!
//! `t = n . (a - o) / n . d` with the normal `n = (b - a) x (c - a)`. All differences are exact (a double-double holds
//! the difference of two f64), so neither the position of the mesh nor that of the ray's origin costs accuracy. What
//! remains is the rounding of the products, which is relative to the triangle's own edges.

use super::exact::{Expansion, Wide, minus, size, unit_sized, wide};
use crate::math::{Dd, HALF_ULP, Real, Vec3};
use crate::ray::Line;

/// Bounds the error of `n . w` in double-double, relative to the product of the sizes of both edges and of `w`.
///
/// A product of double-doubles is off by at most `2^-103` of itself and a sum by `2^-104`. With edges `u`, `v`: each of
/// the two products in a component of `n` is below `|u||v|`, so the component is off by `2^-101 |u||v|`. Each of the
/// three products with `w` is off by that times `|w|` and `2^-103` of `2 |u||v||w|`, each sum by `2^-104` of
/// `6 |u||v||w|`: together less than `2^-98 |u||v||w|`.
pub(super) const PRODUCTS: f64 = f64::from_bits((1023 - 98) << 52);

/// Double-double suffices while its error is below this fraction of `n . d`; otherwise the products are summed exactly.
/// Few lines come near: a needle of proportions `1e-6` seen at a slope of `1e-5` is still far from it.
pub(super) const ENOUGH: f64 = f64::from_bits((1023 - 60) << 52);

/// Below this, components of products may underflow.
pub(super) const SMALL: f64 = f64::from_bits((1023 - 700) << 52);

/// The intersection of a line with the plane of a triangle that it passes through.
pub(super) struct PlaneHit {
    /// The parameter.
    pub(super) t: f64,
    /// A bound on its error, for the line and the triangle as they are given.
    pub(super) t_err: f64,
    /// `n`, up to a factor.
    normal: Vec3,
    /// `n . d`, up to the same factor.
    descent: f64,
}

impl PlaneHit {
    /// Computes the intersection for a line that is not parallel to the plane.
    #[inline]
    pub(super) fn of(corners: &[Vec3; 3], line: &Line) -> PlaneHit {
        let [a, b, c] = *corners;
        let (u, v, h) = (minus(b, a), minus(c, a), minus(a, line.o));
        let normal = cross(&u, &v);
        let (height, descent) = (dot(&normal, &h), dot(&normal, &wide(line.d)));
        // The direction has size 1, so the errors of both are proportional to the sizes of `h` and 1.
        let (area, depth) = (size(&u) * size(&v), size(&h));
        let doubt = PRODUCTS * area;
        // An origin on the plane must give exactly 0, so the sign of the height has to be certain.
        let certain = doubt <= ENOUGH * descent.hi.abs() && doubt * depth < height.hi.abs();
        if !certain || area * depth.min(1.0) < SMALL {
            return PlaneHit::exactly(&u, &v, &h, line);
        }
        let reciprocal = descent.recip();
        let t = (height * reciprocal).hi;
        // |height'/descent' - height/descent| <= (e_height + |t| e_descent) / |descent|.
        let products = doubt * (depth + t.abs()) * reciprocal.hi.abs();
        PlaneHit { t, t_err: rounding(t) + 1.01 * products, normal: normal_of(&normal), descent: descent.hi }
    }

    #[cold]
    fn exactly(u: &Wide, v: &Wide, h: &Wide, line: &Line) -> PlaneHit {
        let ((u, _), (v, _), (h, exponent)) = (unit_sized(u), unit_sized(v), unit_sized(h));
        let descent = Expansion::determinant(&u, &v, &wide(line.d)).value();
        let height = Expansion::determinant(&u, &v, &h).value();
        let t = libm::ldexp((height * descent.recip()).hi, exponent);
        PlaneHit { t, t_err: rounding(t), normal: accurate_cross(&u, &v), descent: descent.hi }
    }

    /// Returns the error of `t` that is due to the line, given bounds on the errors of its direction and of its point
    /// at `t`.
    ///
    /// A line that is off by `e` at `t` meets the plane where `t` is less by `n.e / n.(d + d_err)`. The result is
    /// infinite or NaN if the line may be parallel to the plane.
    pub(super) fn t_err_of(&self, point_err: Vec3, d_err: Vec3) -> f64 {
        let steps = self.normal.abs() / self.descent.abs();
        point_err.dot(steps) / (1.0 - d_err.dot(steps)).max(0.0)
    }
}

/// A bound on the error of a number from rounding to f64 and from the last digits of double-double.
pub(super) fn rounding(t: f64) -> f64 {
    1.001 * HALF_ULP * t.abs()
}

/// A bound on the error of [`PlaneHit::t`] near `t`, if no corner of a triangle is farther from the origin than `reach`
/// along any axis: it is [`PlaneHit::t_err`] where double-double barely suffices.
pub(super) fn worst_err(t: f64, reach: f64) -> f64 {
    rounding(t) + 1.02 * ENOUGH * (reach + t.abs())
}

/// Returns the normal of a triangle. Its length is arbitrary, but not zero if the triangle has an area. It is accurate
/// to a few ulps even where the triangle is narrow and products of `f64` cancel.
pub(super) fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    let (u, v) = (b - a, c - a);
    let (n, area) = (u.cross(v), u.abs().max_element() * v.abs().max_element());
    if area > SMALL && n.abs().max_element() > area / 64.0 {
        return n;
    }
    accurate_cross(&unit_sized(&minus(b, a)).0, &unit_sized(&minus(c, a)).0)
}

/// `u x v` of vectors of size 1.
fn accurate_cross(u: &Wide, v: &Wide) -> Vec3 {
    let n = cross(u, v);
    if size(&n) > ENOUGH {
        return normal_of(&n);
    }
    Vec3::from([0, 1, 2].map(|i| Expansion::minor(u, v, i).value().hi))
}

fn normal_of(n: &Wide) -> Vec3 {
    Vec3::from(n.map(|x| x.hi))
}

/// `a x b` in double-double.
#[inline(always)]
pub(super) fn cross<T: Real>(a: &Wide<T>, b: &Wide<T>) -> Wide<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a . b` in double-double.
#[inline(always)]
pub(super) fn dot<T: Real>(a: &Wide<T>, b: &Wide<T>) -> Dd<T> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use num_rational::BigRational;
    use num_traits::{Signed, ToPrimitive, Zero};

    use super::*;
    use crate::testkit::random::Random;

    fn number(x: f64) -> BigRational {
        BigRational::from_float(x).unwrap()
    }

    /// `n . (p - q)` for the normal of a triangle, exactly.
    fn exact_dot(corners: &[Vec3; 3], p: Vec3, q: Vec3) -> BigRational {
        let minus = |a: Vec3, b: Vec3| [0, 1, 2].map(|i| number(a[i]) - number(b[i]));
        let [a, b, c] = *corners;
        let (u, v, w) = (minus(b, a), minus(c, a), minus(p, q));
        (0..3).fold(BigRational::zero(), |sum, i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            sum + (&u[j] * &v[k] - &u[k] * &v[j]) * &w[i]
        })
    }

    /// A triangle about one unit long, with the given width and distance from the origin.
    fn needle(random: &mut Random, narrow: f64, far: f64) -> [Vec3; 3] {
        let a = random.point(-1.0, 1.0) + random.direction() * far;
        let (along, across) = (random.direction(), random.direction());
        [a, a + along, a + along * random.number(-1.0, 1.0) + across * narrow]
    }

    #[test]
    fn normals_of_needles_are_square_to_their_edges() {
        let mut random = Random::new(5);
        for _ in 0..2_000 {
            let (narrow, far) = (10f64.powf(random.number(-15.0, 0.0)), 10f64.powf(random.number(-3.0, 3.0)));
            let triangle = needle(&mut random, narrow, far);
            let found = normal(triangle);
            let expected = Vec3::from([Vec3::X, Vec3::Y, Vec3::Z].map(|axis| {
                let exact = exact_dot(&triangle, axis, Vec3::ZERO);
                exact.numer().to_f64().unwrap() / exact.denom().to_f64().unwrap()
            }));
            if expected != Vec3::ZERO {
                let off = found.normalize() - expected.normalize();
                assert!(off.length() < 1e-13, "{triangle:?} {found} {expected}");
            }
        }
    }

    /// The bound holds and is that of rounding `t`, however narrow the triangle is, however far it is from the origin,
    /// and wherever the line begins.
    #[test]
    fn bounds_are_of_the_size_of_the_rounding() {
        let mut random = Random::new(4);
        let (mut exact_ones, mut compared) = (0, 0);
        for case in 0..6_000 {
            let (narrow, far) = (10f64.powf(random.number(-14.0, 0.0)), 10f64.powf(random.number(-3.0, 8.0)));
            let triangle = needle(&mut random, narrow, far);
            let [a, b, c] = triangle;
            let (v, w) = (random.number(0.0, 1.0), random.number(0.0, 1.0));
            let p = a + (b - a) * v + (c - a) * w;
            let d = match case % 3 {
                0 => random.direction(),
                1 => (b - a) + random.direction() * 10f64.powf(random.number(-12.0, 0.0)),
                _ => random.direction() * 1e-3 + (c - a),
            };
            let d = d / d.abs().max_element() * 0.75;
            let o = match case % 4 {
                0 => p,
                1 => a,
                _ => p - d * 10f64.powf(random.number(-9.0, 6.0)),
            };
            let descent = exact_dot(&triangle, d, Vec3::ZERO);
            if descent.is_zero() {
                continue;
            }
            let exact = exact_dot(&triangle, a, o) / descent;
            let found = PlaneHit::of(&triangle, &Line::exact(o, d));
            let error = (number(found.t) - &exact).abs();
            assert!(error <= number(found.t_err), "{triangle:?} {o:?} {d:?} {} {}", found.t, found.t_err);
            let reach = triangle.into_iter().map(|v| (v - o).abs().max_element()).fold(0.0, f64::max);
            assert!(found.t_err <= worst_err(found.t, reach), "{triangle:?} {o:?} {d:?}");
            assert_eq!(found.t == 0.0, exact.is_zero(), "{triangle:?} {o:?} {d:?}");
            exact_ones += usize::from(found.t_err == rounding(found.t));
            compared += 1;
        }
        assert!(compared > 5_800 && exact_ones > 300, "{compared} {exact_ones}");
    }
}
