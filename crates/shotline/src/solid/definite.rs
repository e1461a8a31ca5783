//! Bounding boxes and moments of the quadrics that are ellipsoids.

use std::f64::consts::PI;

use super::Moments;
use super::form::Form;
use crate::aabb::Aabb;
use crate::math::{Dd, HALF_ULP, Vec3};
use crate::region::{Quadratic, contract};

/// A bound on the error of a sum of products in double-double, relative to the sum of their magnitudes.
const DOUBT: f64 = 1e-30;

/// A matrix counts as definite only if the relative error of its determinant and minors is below this.
const DEFINITE: f64 = 1e-6;

/// An ellipsoid: the points `p` with `(p - centre)^T spread^-1 (p - centre) < 1`. If the quadric is independent
/// of one axis, it is a cylinder along that axis over an ellipse in the other two.
#[derive(Debug)]
struct Ellipsoid {
    centre: Vec3,
    spread: [[f64; 3]; 3],
    /// Half the size of its box, and a bound on the error of the box's centre.
    half: Vec3,
    doubt: Vec3,
    /// The axis of which the quadric is independent, if any.
    free: Option<usize>,
}

/// A number with the sum of the absolute values of its terms.
#[derive(Clone, Copy)]
struct WithMagnitude(Dd, f64);

impl WithMagnitude {
    fn error(self) -> f64 {
        DOUBT * self.1
    }
}

impl From<Dd> for WithMagnitude {
    fn from(x: Dd) -> WithMagnitude {
        WithMagnitude(x, x.hi.abs())
    }
}

impl std::ops::Add for WithMagnitude {
    type Output = WithMagnitude;
    fn add(self, other: WithMagnitude) -> WithMagnitude {
        WithMagnitude(self.0 + other.0, self.1 + other.1)
    }
}

impl std::ops::Sub for WithMagnitude {
    type Output = WithMagnitude;
    fn sub(self, other: WithMagnitude) -> WithMagnitude {
        WithMagnitude(self.0 - other.0, self.1 + other.1)
    }
}

impl std::ops::Mul for WithMagnitude {
    type Output = WithMagnitude;
    fn mul(self, other: WithMagnitude) -> WithMagnitude {
        WithMagnitude(self.0 * other.0, self.1 * other.1)
    }
}

/// Returns the box of the set where a form is negative: tight for ellipsoids and for all axis-aligned quadrics,
/// infinite where the set is unbounded.
pub(super) fn bounds(form: &Form) -> Aabb {
    let along_axes = contract(Aabb::EVERYTHING, &[Quadratic::new(form.quadric_matrix().rows)]);
    match ellipsoid(form) {
        EllipsoidTest::Ellipsoid(ellipsoid) => ellipsoid.bounds().intersection(&along_axes),
        EllipsoidTest::Nothing => Aabb::EMPTY,
        EllipsoidTest::Other => along_axes,
    }
}

/// Returns volume and moments of the set where a form is negative, if it is an ellipsoid or empty.
pub(super) fn moments(form: &Form) -> Option<Moments> {
    match ellipsoid(form) {
        EllipsoidTest::Ellipsoid(Ellipsoid { free: Some(_), .. }) | EllipsoidTest::Other => None,
        EllipsoidTest::Nothing => Some(Moments::EMPTY),
        EllipsoidTest::Ellipsoid(Ellipsoid { centre, spread: s, .. }) => {
            let minor = |i: usize, j: usize| s[1][i] * s[2][j] - s[1][j] * s[2][i];
            let squared = s[0][0] * minor(1, 2) - s[0][1] * minor(0, 2) + s[0][2] * minor(0, 1);
            let volume = 4.0 / 3.0 * PI * squared.max(0.0).sqrt();
            Some(Moments { volume, centroid: centre, second: s.map(|row| row.map(|x| volume * x / 5.0)) })
        }
    }
}

enum EllipsoidTest {
    Ellipsoid(Ellipsoid),
    Nothing,
    Other,
}

/// Returns the ellipsoid where a form is negative, computed with the adjugate `adj` and the determinant `det` of
/// its matrix `M`. With half the linear part `l` and the constant `k`, the centre is `-adj l / det` and the
/// spread is `adj (l adj l - k det) / det^2`.
fn ellipsoid(form: &Form) -> EllipsoidTest {
    let ([xx, yy, zz], [yz, xz, xy]) = (form.square, form.cross.unwrap_or_default());
    let mut m = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let is_free = |i: usize| m[i].iter().chain([&form.linear[i]]).all(|x| x.hi == 0.0);
    let free = (0..3).find(|&i| is_free(i));
    if let Some(i) = free {
        // A diagonal entry of its own does not affect the other two axes.
        m[i][i] = Dd::ONE;
    }
    let m = |i: usize, j: usize| WithMagnitude::from(m[i % 3][j % 3]);
    let adjugate: [[WithMagnitude; 3]; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| m(i + 1, j + 1) * m(i + 2, j + 2) - m(i + 1, j + 2) * m(i + 2, j + 1))
    });
    let det = m(0, 0) * adjugate[0][0] + m(0, 1) * adjugate[0][1] + m(0, 2) * adjugate[0][2];
    let sure = |x: WithMagnitude| x.0.hi > 0.0 && x.error() < DEFINITE * x.0.hi;
    if !(sure(m(0, 0)) && sure(adjugate[2][2]) && sure(det)) {
        return EllipsoidTest::Other;
    }
    let l = form.linear.map(WithMagnitude::from);
    let moved: [WithMagnitude; 3] =
        std::array::from_fn(|i| adjugate[i][0] * l[0] + adjugate[i][1] * l[1] + adjugate[i][2] * l[2]);
    let within =
        l[0] * moved[0] + l[1] * moved[1] + l[2] * moved[2] - WithMagnitude::from(form.constant) * det;
    // `Form` is exact except for underflow.
    let error = within.error() + f64::MIN_POSITIVE;
    if within.0.hi + error < 0.0 {
        return EllipsoidTest::Nothing;
    }
    let (square, relative) = (within.0.hi + error, 1.0 + 2.0 * det.error() / det.0.hi);
    // The axis of which the quadric is independent has no proportion.
    let shrink = Vec3::select(form.shrink.cmpeq(Vec3::ZERO), Vec3::ONE, form.shrink);
    let half = |i: usize| {
        let entry = adjugate[i][i].0.hi + adjugate[i][i].error();
        entry.sqrt() * square.sqrt() / det.0.hi * relative / shrink[i]
    };
    let doubt = |i: usize| {
        let off = moved[i].error() + moved[i].0.hi.abs() * (relative - 1.0);
        off / det.0.hi / shrink[i]
    };
    let (half, doubt) = (Vec3::new(half(0), half(1), half(2)), Vec3::new(doubt(0), doubt(1), doubt(2)));
    let over = det.0.recip();
    let centre = Vec3::from_array(moved.map(|x| -(x.0 * over).hi)) / shrink + form.centre;
    let spread = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let entry = (adjugate[i][j].0 * over) * (within.0 * over);
            if within.0.hi > 0.0 { entry.hi / shrink[i] / shrink[j] } else { 0.0 }
        })
    });
    let finite = centre.is_finite() && half.is_finite() && doubt.is_finite();
    if finite {
        EllipsoidTest::Ellipsoid(Ellipsoid { centre, spread, half, doubt, free })
    } else {
        EllipsoidTest::Other
    }
}

impl Ellipsoid {
    fn bounds(&self) -> Aabb {
        let pad =
            self.doubt + (self.half + self.centre.abs()) * (16.0 * HALF_ULP) + Vec3::splat(f64::MIN_POSITIVE);
        let mut b = Aabb::new(self.centre - self.half - pad, self.centre + self.half + pad);
        if let Some(axis) = self.free {
            (b.min[axis], b.max[axis]) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        b
    }
}
