//! Three numbers of each lane.

use crate::math::{Affine, UNIT_RANGE, Vec3};
use crate::simd::Doubles;

/// A vector of each lane.
pub(crate) type Vectors<F> = [F; 3];

/// The same vector in every lane.
#[inline(always)]
pub(crate) fn splat<F: Doubles>(v: Vec3) -> Vectors<F> {
    [F::splat(v.x), F::splat(v.y), F::splat(v.z)]
}

/// The number of each lane.
#[inline(always)]
pub(crate) fn gather<F: Doubles>(number: impl Fn(usize) -> f64) -> F {
    let mut numbers = [0.0; 8];
    for (lane, to) in numbers[..F::LANES].iter_mut().enumerate() {
        *to = number(lane);
    }
    F::load_some(&numbers, 0)
}

/// The vector of each lane.
#[inline(always)]
pub(crate) fn gather_vectors<F: Doubles>(vector: impl Fn(usize) -> Vec3) -> Vectors<F> {
    [gather(|lane| vector(lane).x), gather(|lane| vector(lane).y), gather(|lane| vector(lane).z)]
}

#[inline(always)]
pub(crate) fn add<F: Doubles>(a: Vectors<F>, b: Vectors<F>) -> Vectors<F> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn sub<F: Doubles>(a: Vectors<F>, b: Vectors<F>) -> Vectors<F> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The products of the components.
#[inline(always)]
pub(crate) fn mul<F: Doubles>(a: Vectors<F>, b: Vectors<F>) -> Vectors<F> {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

#[inline(always)]
pub(crate) fn scale<F: Doubles>(a: Vectors<F>, by: F) -> Vectors<F> {
    [a[0] * by, a[1] * by, a[2] * by]
}

#[inline(always)]
pub(crate) fn abs<F: Doubles>(a: Vectors<F>) -> Vectors<F> {
    [a[0].abs(), a[1].abs(), a[2].abs()]
}

/// The scalar product, summed as that of [`Vec3`].
#[inline(always)]
pub(crate) fn dot<F: Doubles>(a: Vectors<F>, b: Vectors<F>) -> F {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The largest component, of finite ones.
#[inline(always)]
pub(crate) fn largest<F: Doubles>(a: Vectors<F>) -> F {
    a[0].greater(a[1]).greater(a[2])
}

/// `a` in the lanes of a mask, else `b`.
#[inline(always)]
pub(crate) fn where_set<F: Doubles>(a: Vectors<F>, lanes: u8, b: Vectors<F>) -> Vectors<F> {
    [a[0].where_set(lanes, b[0]), a[1].where_set(lanes, b[1]), a[2].where_set(lanes, b[2])]
}

/// The row vectors `n S`, as [`Affine::covector`].
#[inline(always)]
pub(crate) fn covector<F: Doubles>(of: &Affine, n: [F; 3]) -> [F; 3] {
    let mut out = n;
    for (j, out) in out.iter_mut().enumerate() {
        let column = [F::splat(of.rows[0][j]), F::splat(of.rows[1][j]), F::splat(of.rows[2][j])];
        *out = dot(n, column);
    }
    out
}

/// The row vectors `n S`, with a matrix of each lane.
#[inline(always)]
pub(crate) fn covector_each<F: Doubles>(of: &[&Affine; 8], n: [F; 3]) -> [F; 3] {
    let mut out = n;
    for (j, out) in out.iter_mut().enumerate() {
        let column = [
            gather(|lane| of[lane].rows[0][j]),
            gather(|lane| of[lane].rows[1][j]),
            gather(|lane| of[lane].rows[2][j]),
        ];
        *out = dot(n, column);
    }
    out
}

/// The vectors of length 1, and the lanes in which they have the bits of [`unit`](crate::math::unit): those of an ordinary
/// size.
#[inline(always)]
pub(crate) fn units<F: Doubles>(v: [F; 3]) -> ([F; 3], u8) {
    let size = largest(abs(v));
    let ordinary = F::splat(UNIT_RANGE[0]).is_at_most(size) & size.is_less(F::splat(UNIT_RANGE[1]));
    (scale(v, F::splat(1.0) / dot(v, v).sqrt()), ordinary)
}
