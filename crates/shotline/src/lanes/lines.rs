//! Lines in lanes, with the bits of single lines.

use super::vector::{Vectors, abs, add, dot, gather, gather_vectors, scale, splat, where_set};
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

    /// The line of each lane, by number.
    #[inline(always)]
    pub fn each(lines: &[&Line; 8]) -> LineLanes<F> {
        LineLanes {
            o: gather_vectors(|lane| lines[lane].o),
            d: gather_vectors(|lane| lines[lane].d),
            o_err: gather_vectors(|lane| lines[lane].o_err),
            d_err: gather_vectors(|lane| lines[lane].d_err),
        }
    }

    /// The lines in a child's frame, as [`Line::in_frame`].
    #[inline(always)]
    pub fn in_frame(&self, local_from_parent: &Affine) -> LineLanes<F> {
        if local_from_parent.is_identity() {
            return *self;
        }
        let [x, y, z] = &local_from_parent.rows;
        self.transformed(&[splat_row(x), splat_row(y), splat_row(z)])
    }

    /// The line of each lane in the frame of a child of its own.
    #[inline(always)]
    pub fn in_frames(&self, local_from_parent: &[&Affine; 8]) -> LineLanes<F> {
        let mut still = 0;
        for (lane, frame) in local_from_parent.iter().enumerate() {
            still |= u8::from(frame.is_identity()) << lane;
        }
        if still == u8::MAX {
            return *self;
        }
        let frames = local_from_parent;
        let moved = self.transformed(&[each_row(frames, 0), each_row(frames, 1), each_row(frames, 2)]);
        if still == 0 { moved } else { self.where_set(still, &moved) }
    }

    #[inline(always)]
    fn transformed(&self, rows: &[[F; 4]; 3]) -> LineLanes<F> {
        let (mut out, o, d) = (*self, abs(self.o), abs(self.d));
        for (i, &[x, y, z, moved]) in rows.iter().enumerate() {
            let row: Vectors<F> = [x, y, z];
            let weights = abs(row);
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

#[inline(always)]
fn splat_row<F: Doubles>(row: &[f64; 4]) -> [F; 4] {
    [F::splat(row[0]), F::splat(row[1]), F::splat(row[2]), F::splat(row[3])]
}

/// A row of the matrix of each lane.
#[inline(always)]
fn each_row<F: Doubles>(of: &[&Affine; 8], i: usize) -> [F; 4] {
    [
        gather(|lane| of[lane].rows[i][0]),
        gather(|lane| of[lane].rows[i][1]),
        gather(|lane| of[lane].rows[i][2]),
        gather(|lane| of[lane].rows[i][3]),
    ]
}
