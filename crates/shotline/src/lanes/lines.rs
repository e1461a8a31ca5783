//! Lines in lanes, with the bits of single lines.

use super::vector::{Vectors, abs, add, dot, scale, splat, where_set};
#[cfg(test)]
use crate::math::Vec3;
use crate::math::{Affine, HALF_ULP};
use crate::ray::Line;
use crate::simd::Doubles;

/// A line of each lane, as [`Line`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineLanes<F> {
    pub o: [F; 3],
    pub d: [F; 3],
    pub o_err: [F; 3],
    pub d_err: [F; 3],
}

impl<F: Doubles> LineLanes<F> {
    /// The line of each lane.
    #[cfg(test)]
    pub fn from_fn(line: impl Fn(usize) -> Line) -> LineLanes<F> {
        let number = |of: fn(&Line) -> Vec3, axis: usize| F::from_fn(|lane| of(&line(lane))[axis]);
        let vector = |of: fn(&Line) -> Vec3| [number(of, 0), number(of, 1), number(of, 2)];
        LineLanes {
            o: vector(|line| line.o),
            d: vector(|line| line.d),
            o_err: vector(|line| line.o_err),
            d_err: vector(|line| line.d_err),
        }
    }

    /// The same line in every lane.
    #[inline(always)]
    pub fn splat(line: &Line) -> LineLanes<F> {
        LineLanes { o: splat(line.o), d: splat(line.d), o_err: splat(line.o_err), d_err: splat(line.d_err) }
    }

    /// The lines of `self` in the lanes of a mask, else those of `other`.
    #[inline(always)]
    pub fn where_set(&self, lanes: u8, other: &LineLanes<F>) -> LineLanes<F> {
        LineLanes {
            o: where_set(self.o, lanes, other.o),
            d: where_set(self.d, lanes, other.d),
            o_err: where_set(self.o_err, lanes, other.o_err),
            d_err: where_set(self.d_err, lanes, other.d_err),
        }
    }

    /// The points at `t`.
    #[inline(always)]
    pub fn at(&self, t: F) -> [F; 3] {
        add(self.o, scale(self.d, t))
    }

    /// The lines in a child's frame, as [`Line::in_frame`].
    #[inline(always)]
    pub fn in_frame(&self, local_from_parent: &Affine) -> LineLanes<F> {
        if local_from_parent.is_identity() {
            return *self;
        }
        let (mut out, o, d) = (*self, abs(self.o), abs(self.d));
        for i in 0..3 {
            let m = &local_from_parent.rows[i];
            let row: Vectors<F> = [F::splat(m[0]), F::splat(m[1]), F::splat(m[2])];
            let (weights, moved) = (abs(row), F::splat(m[3]));
            out.o[i] = dot(row, self.o) + moved;
            out.d[i] = dot(row, self.d);
            let o_err = F::splat(5.0 * HALF_ULP) * (dot(weights, o) + moved.abs());
            let d_err = F::splat(4.0 * HALF_ULP) * dot(weights, d);
            // Weighed, errors of zero are zero.
            out.o_err[i] = o_err + dot(weights, self.o_err);
            out.d_err[i] = d_err + dot(weights, self.d_err);
        }
        out
    }
}
