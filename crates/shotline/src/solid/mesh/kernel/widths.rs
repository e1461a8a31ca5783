//! How wide the events of hits are, four lines at a time: bounds that grow with `t`, as the plain path has them.

use crate::crossing::GROUPING;
use crate::math::{HALF_ULP, Real};
use crate::simd::{F64x4, Simd};
use crate::solid::mesh::mesh_line::{RESOLVED, STEEPEST};
use crate::solid::mesh::plane::ENOUGH;

/// Three components of four vectors.
pub(super) type Vectors<S> = [<S as Simd>::F64; 3];

/// [`super::super::mesh_line::MeshLine::event_width`] of exact lines. Not a closure, which would not be inlined into code
/// compiled for the instructions of `S`.
#[inline(always)]
pub(super) fn width<S: Simd>(t: S::F64, reach: S::F64) -> S::F64 {
    let splat = <S::F64 as Real>::splat;
    let worst = splat(1.001 * HALF_ULP) * t.abs() + splat(1.02 * ENOUGH) * (reach + t.abs());
    splat(2.0 * GROUPING) * worst
}

/// Bounds on the errors of four lines, after scaling.
pub(super) struct Errors<S: Simd> {
    o: Vectors<S>,
    d: Vectors<S>,
}

impl<S: Simd> Errors<S> {
    /// The errors of four rows, times the factors of origins and of directions.
    #[inline(always)]
    pub fn load(errors: &[[f64; 6]], rows: [usize; 4], [of_o, of_d]: [S::F64; 2]) -> Errors<S> {
        let four = [&errors[rows[0]], &errors[rows[1]], &errors[rows[2]], &errors[rows[3]]];
        let load = |k: usize| S::F64::load(&[four[0][k], four[1][k], four[2][k], four[3][k]]);
        Errors {
            o: [load(0) * of_o, load(1) * of_o, load(2) * of_o],
            d: [load(3) * of_d, load(4) * of_d, load(5) * of_d],
        }
    }

    /// Bounds on the errors of points at `t`, along the worst axis.
    #[inline(always)]
    fn at(&self, t: S::F64) -> S::F64 {
        let t = t.abs();
        largest::<S>(&[self.o[0] + self.d[0] * t, self.o[1] + self.d[1] * t, self.o[2] + self.d[2] * t])
    }
}

/// The widths of events of four lines, some of which are not exact.
pub(super) struct Widths<S: Simd> {
    errors: Errors<S>,
    /// Zero for lines that are exact, else negative.
    inexact: S::F64,
    /// The largest component of each direction.
    longest: S::F64,
    /// The least bound where it is resolved.
    resolved: S::F64,
    reach: S::F64,
    /// A mask of the lines whose bounds grow slowly, as [`super::super::mesh_line::MeshLine::event_width`] says, and whose
    /// numbers are finite. The widths of all others mean nothing.
    pub grow_slowly: u8,
}

impl<S: Simd> Widths<S> {
    /// The widths of lines, given the largest component of each direction and the size of the mesh along its axis.
    #[inline(always)]
    pub fn of(
        [o, d]: [&Vectors<S>; 2],
        errors: Errors<S>,
        [longest, size]: [S::F64; 2],
        reach: S::F64,
    ) -> Widths<S> {
        let splat = <S::F64 as Real>::splat;
        let of_d = largest::<S>(&errors.d);
        // Zero, or NaN where a number is not finite.
        let zero =
            vanishing::<S>(o) + vanishing::<S>(d) + vanishing::<S>(&errors.o) + vanishing::<S>(&errors.d);
        let growth = splat(2.0 * HALF_ULP) + splat(2.0 * STEEPEST) * of_d + zero;
        Widths {
            inexact: splat(0.0) - largest::<S>(&errors.o).greater(of_d),
            longest,
            resolved: splat(RESOLVED) * (size / longest),
            reach,
            grow_slowly: growth.is_at_most(splat(1.0 / 16.0)),
            errors,
        }
    }

    /// [`super::super::mesh_line::MeshLine::event_width`].
    #[inline(always)]
    pub fn at(&self, t: S::F64) -> S::F64 {
        let splat = <S::F64 as Real>::splat;
        let of_line = splat(STEEPEST) * self.errors.at(t) / self.longest;
        let of_line = of_line.greater(self.resolved).where_negative(self.inexact, splat(0.0));
        width::<S>(t, self.reach) + splat(2.0 * GROUPING) * of_line
    }

    /// The largest distance from a plane at which the lines count as running in it.
    #[inline(always)]
    pub fn near(&self) -> S::F64 {
        <S::F64 as Real>::splat(GROUPING) * self.errors.at(self.reach / self.longest)
    }
}

/// The largest of components that are not negative.
#[inline(always)]
fn largest<S: Simd>(v: &Vectors<S>) -> S::F64 {
    v[0].greater(v[1]).greater(v[2])
}

/// Zero, or NaN if a component is not finite.
#[inline(always)]
fn vanishing<S: Simd>(v: &Vectors<S>) -> S::F64 {
    let zero = <S::F64 as Real>::splat(0.0);
    v[0] * zero + v[1] * zero + v[2] * zero
}
