//! How wide the events of hits are, many lines at a time: bounds that grow with `t`, as the plain path has them.

use crate::crossing::GROUPING;
use crate::math::HALF_ULP;
use crate::simd::Doubles;
use crate::solid::mesh::mesh_line::{RESOLVED, STEEPEST};
use crate::solid::mesh::plane::ENOUGH;

/// Three components of vectors, one for each lane.
pub(super) type Vectors<F> = [F; 3];

/// The first and the second three numbers of some rows.
#[inline(always)]
pub(super) fn load_halves<F: Doubles>(numbers: &[[f64; 6]], rows: &[usize]) -> [Vectors<F>; 2] {
    let load = |k: usize| F::from_fn(|lane| numbers[rows[lane]][k]);
    [[load(0), load(1), load(2)], [load(3), load(4), load(5)]]
}

/// [`super::super::mesh_line::MeshLine::event_width`] of exact lines. Not a closure, which would not be inlined into code
/// compiled for the instructions of `S`.
#[inline(always)]
pub(super) fn width<F: Doubles>(t: F, reach: F) -> F {
    let splat = F::splat;
    let worst = splat(1.001 * HALF_ULP) * t.abs() + splat(1.02 * ENOUGH) * (reach + t.abs());
    splat(2.0 * GROUPING) * worst
}

/// Bounds on the errors of some lines, after scaling.
pub(super) struct Errors<F: Doubles> {
    o: Vectors<F>,
    d: Vectors<F>,
}

impl<F: Doubles> Errors<F> {
    /// The errors of some rows, times the factors of origins and of directions.
    #[inline(always)]
    pub fn load(errors: &[[f64; 6]], rows: &[usize], [of_o, of_d]: [F; 2]) -> Errors<F> {
        let [o, d] = load_halves::<F>(errors, rows);
        Errors { o: [o[0] * of_o, o[1] * of_o, o[2] * of_o], d: [d[0] * of_d, d[1] * of_d, d[2] * of_d] }
    }

    /// Bounds on the errors of points at `t`, along the worst axis.
    #[inline(always)]
    fn at(&self, t: F) -> F {
        let t = t.abs();
        largest::<F>(&[self.o[0] + self.d[0] * t, self.o[1] + self.d[1] * t, self.o[2] + self.d[2] * t])
    }
}

/// The widths of events of some lines, some of which are not exact.
pub(super) struct Widths<F: Doubles> {
    errors: Errors<F>,
    /// Zero for lines that are exact, else negative.
    inexact: F,
    /// The largest component of each direction.
    longest: F,
    /// The least bound where it is resolved.
    resolved: F,
    reach: F,
    /// A mask of the lines whose bounds grow slowly, as [`super::super::mesh_line::MeshLine::event_width`] says, and whose
    /// numbers are finite. The widths of all others mean nothing.
    pub grow_slowly: u8,
}

impl<F: Doubles> Widths<F> {
    /// The widths of lines, given the largest component of each direction and the size of the mesh along its axis.
    #[inline(always)]
    pub fn of([o, d]: [&Vectors<F>; 2], errors: Errors<F>, [longest, size]: [F; 2], reach: F) -> Widths<F> {
        let splat = F::splat;
        let of_d = largest::<F>(&errors.d);
        // Zero, or NaN where a number is not finite.
        let zero =
            vanishing::<F>(o) + vanishing::<F>(d) + vanishing::<F>(&errors.o) + vanishing::<F>(&errors.d);
        let growth = splat(2.0 * HALF_ULP) + splat(2.0 * STEEPEST) * of_d + zero;
        Widths {
            inexact: splat(0.0) - largest::<F>(&errors.o).greater(of_d),
            longest,
            resolved: splat(RESOLVED) * (size / longest),
            reach,
            grow_slowly: growth.is_at_most(splat(1.0 / 16.0)),
            errors,
        }
    }

    /// [`super::super::mesh_line::MeshLine::event_width`].
    #[inline(always)]
    pub fn at(&self, t: F) -> F {
        let splat = F::splat;
        let of_line = splat(STEEPEST) * self.errors.at(t) / self.longest;
        let of_line = of_line.greater(self.resolved).where_negative(self.inexact, splat(0.0));
        width::<F>(t, self.reach) + splat(2.0 * GROUPING) * of_line
    }

    /// The largest distance from a plane at which the lines count as running in it.
    #[inline(always)]
    pub fn near(&self) -> F {
        F::splat(GROUPING) * self.errors.at(self.reach / self.longest)
    }
}

/// The largest of components that are not negative.
#[inline(always)]
fn largest<F: Doubles>(v: &Vectors<F>) -> F {
    v[0].greater(v[1]).greater(v[2])
}

/// Zero, or NaN if a component is not finite.
#[inline(always)]
fn vanishing<F: Doubles>(v: &Vectors<F>) -> F {
    let zero = F::splat(0.0);
    v[0] * zero + v[1] * zero + v[2] * zero
}
