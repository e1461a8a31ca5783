//! Where a line meets the plane of a triangle.
//!
//! `t = n . (a - o) / n . d` with the normal `n = (b - a) x (c - a)`. All differences are exact (a double-double
//! holds the difference of two f64), so neither the place of a mesh nor that of the ray's origin takes anything from
//! the result: what is left is the rounding of the products, which is relative to the triangle's own edges.

use super::exact::{Expansion, Wide, minus, size, unit_sized, wide};
use super::probe::Triangle;
use crate::math::{Dd, HALF_ULP, Vec3};
use crate::ray::Line;

/// Bounds the error of `n . w` in double-double, relative to the product of the sizes of both edges and of `w`.
///
/// A product of double-doubles is off by at most `2^-103` of itself and a sum by `2^-104`. With edges `u`, `v`: each of
/// the two products in a component of `n` is below `|u||v|`, so the component is off by `2^-101 |u||v|`. Each of the
/// three products with `w` is off by that times `|w|` and `2^-103` of `2 |u||v||w|`, each sum by `2^-104` of
/// `6 |u||v||w|`: together less than `2^-98 |u||v||w|`.
const PRODUCTS: f64 = f64::from_bits((1023 - 98) << 52);

/// Double-double is enough while its error is below this part of `n . d`; else the products are summed exactly.
/// Few lines come near: a needle of proportions `1e-6` seen at a slope of `1e-5` is still far from it.
const ENOUGH: f64 = f64::from_bits((1023 - 60) << 52);

/// Below this, parts of products may underflow.
const SMALL: f64 = f64::from_bits((1023 - 700) << 52);

/// The meeting of a line that passes through a triangle with the triangle's plane.
pub(super) struct Meeting {
    /// The parameter.
    pub(super) t: f64,
    /// A bound on its error, for the line and the triangle as they are given.
    pub(super) t_err: f64,
    /// `n`, up to a factor.
    normal: Vec3,
    /// `n . d`, up to the same factor.
    descent: f64,
}

impl Meeting {
    /// Of a line that is not parallel to the plane.
    #[inline]
    pub(super) fn of(triangle: &Triangle, line: &Line) -> Meeting {
        let [a, b, c] = triangle.corners;
        let (u, v, h) = (minus(b, a), minus(c, a), minus(a, line.o));
        let normal = cross(&u, &v);
        let (height, descent) = (dot(&normal, &h), dot(&normal, &wide(line.d)));
        // The direction is of size 1, so the errors of both are as the sizes of `h` and 1.
        let (area, depth) = (size(&u) * size(&v), size(&h));
        let doubt = PRODUCTS * area;
        if !(doubt <= ENOUGH * descent.hi.abs() && SMALL <= area * depth.min(1.0)) {
            return Meeting::exactly(&u, &v, &h, line);
        }
        let reciprocal = descent.recip();
        let t = (height * reciprocal).hi;
        // |height'/descent' - height/descent| <= (e_height + |t| e_descent) / |descent|.
        let products = doubt * (depth + t.abs()) * reciprocal.hi.abs();
        Meeting { t, t_err: rounding(t) + 1.01 * products, normal: normal_of(&normal), descent: descent.hi }
    }

    #[cold]
    fn exactly(u: &Wide, v: &Wide, h: &Wide, line: &Line) -> Meeting {
        let ((u, _), (v, _), (h, exponent)) = (unit_sized(u), unit_sized(v), unit_sized(h));
        let descent = Expansion::determinant(&u, &v, &wide(line.d)).value();
        let height = Expansion::determinant(&u, &v, &h).value();
        let t = libm::ldexp((height * descent.recip()).hi, exponent);
        Meeting { t, t_err: rounding(t), normal: normal_of(&cross(&u, &v)), descent: descent.hi }
    }

    /// What an error of the line does to `t`, given bounds on that of its direction and of its point at `t`.
    ///
    /// A line that is off by `e` at `t` meets the plane where `t` is less by `n.e / n.(d + d_err)`. Infinite or not a
    /// number if the line may be parallel to the plane.
    pub(super) fn t_err_of(&self, point_err: Vec3, d_err: Vec3) -> f64 {
        let steps = self.normal.abs() / self.descent.abs();
        point_err.dot(steps) / (1.0 - d_err.dot(steps)).max(0.0)
    }
}

/// A bound on what rounding to f64, and the last digits of double-double, do to a number.
pub(super) fn rounding(t: f64) -> f64 {
    1.001 * HALF_ULP * t.abs()
}

/// A bound on the error of [`Meeting::t`] near `t`, where no corner of a triangle is farther from the origin than
/// `reach` along any axis: that of [`Meeting::t_err`] where double-double is barely enough.
pub(super) fn worst_err(t: f64, reach: f64) -> f64 {
    rounding(t) + 1.02 * ENOUGH * (reach + t.abs())
}

fn normal_of(n: &Wide) -> Vec3 {
    Vec3::from(n.map(|x| x.hi))
}

fn cross(a: &Wide, b: &Wide) -> Wide {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: &Wide, b: &Wide) -> Dd {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
