//! The traversal of the cells of a subgrid by a ray.
//!
//! Amanatides and Woo add up steps of `t`. Here the `t` of each plane is computed from the plane, with its error:
//! between `earliest` and `latest` the ray may be on either side. A cell is *met* if the interval between its six
//! planes is not empty, exactly as in a test of its box. Every met cell is visited once. A ray in general position
//! meets a chain of cells; where it passes an edge or a corner within rounding, it meets all cells around it.
//!
//! No item is lost. The planes cut its box into pieces, one in each cell that lists the item. A `t` in the interval
//! of the box is in that of a piece (see [`Slope::earliest`](crate::aabb::Slope::earliest)), and so in that of the
//! piece's cell.
//!
//! Every met cell that is not met at the start is reached from exactly one other cell: its neighbour across the plane
//! that the ray crossed last. If the ray crossed several planes at the same `t`, that of the highest axis counts. The
//! neighbour is met too: it has the same planes on the other two axes, and on this axis its interval is the one
//! before, which ends at the plane crossed.

use super::SubGrid;
use crate::aabb::BoxRay;

/// A ray in a subgrid.
pub(super) struct Dda<'a> {
    subgrid: &'a SubGrid,
    ray: &'a BoxRay,
    /// The `t` at which the ray enters the subgrid or its span begins.
    start: f64,
    ascends: [bool; 3],
    strides: [usize; 3],
}

/// A cell that the ray meets.
#[derive(Clone, Copy)]
pub(super) struct CellCursor {
    /// Its index along each axis, counted in the direction of the ray.
    pub coordinates: [u32; 3],
    /// Its index among the cells of the grid.
    pub cell: usize,
    axes: [AxisInterval; 3],
}

/// The interval between the two planes of a cell on one axis.
#[derive(Clone, Copy, Default)]
struct AxisInterval {
    enter: f64,
    /// `earliest` and `latest` of the far plane.
    leave: f64,
    exit: f64,
}

impl<'a> Dda<'a> {
    /// Returns `None` if the ray misses the subgrid.
    #[inline]
    pub fn new(subgrid: &'a SubGrid, ray: &'a BoxRay) -> Option<Dda<'a>> {
        let (start, _) = ray.enter_exit(&subgrid.bounds)?;
        let ascends = [0, 1, 2].map(|axis| ray.slope(axis).ascends());
        Some(Dda { subgrid, ray, start, ascends, strides: subgrid.strides() })
    }

    /// The `t` at which the ray enters a cell.
    #[inline]
    pub fn enter(&self, cursor: &CellCursor) -> f64 {
        let [x, y, z] = &cursor.axes;
        let last = if x.enter > y.enter { x.enter } else { y.enter };
        let last = if z.enter > last { z.enter } else { last };
        if last > self.start { last } else { self.start }
    }

    /// Returns one of the cells met at the start, and pushes the others on `frontier`.
    pub fn begin(&self, frontier: &mut Vec<CellCursor>) -> CellCursor {
        let ranges = [0, 1, 2].map(|axis| self.first_and_last(axis));
        let [x, y, z] = ranges;
        for i in x.0..=x.1 {
            for j in y.0..=y.1 {
                for k in z.0..=z.1 {
                    if (i, j, k) != (x.0, y.0, z.0) {
                        frontier.push(self.at([i, j, k]));
                    }
                }
            }
        }
        self.at([x.0, y.0, z.0])
    }

    /// The first and the last index along an axis at which the ray can be at the start.
    fn first_and_last(&self, axis: usize) -> (u32, u32) {
        let count = self.subgrid.counts[axis];
        let cell = self.subgrid.guess(axis, self.ray.coordinate(axis, self.start));
        let mut last = if self.ascends[axis] { cell } else { count - 1 - cell };
        while last + 1 < count && self.enters(axis, last + 1) <= self.start {
            last += 1;
        }
        while last > 0 && self.enters(axis, last) > self.start {
            last -= 1;
        }
        let mut first = last;
        while first > 0 && self.ray.slope(axis).latest(self.plane(axis, first)) >= self.start {
            first -= 1;
        }
        (first, last)
    }

    /// The cell with given coordinates.
    pub fn at(&self, coordinates: [u32; 3]) -> CellCursor {
        let mut cursor =
            CellCursor { coordinates, cell: self.subgrid.first_cell, axes: [AxisInterval::default(); 3] };
        for (axis, i) in coordinates.into_iter().enumerate() {
            let along = if self.ascends[axis] { i } else { self.subgrid.counts[axis] - 1 - i };
            cursor.cell += along as usize * self.strides[axis];
            cursor.axes[axis] = self.axis_interval(axis, i, self.enters(axis, i));
        }
        cursor
    }

    /// Returns the next cell. If more than one is reached from this cell, pushes the others on `frontier`.
    #[inline]
    pub fn next(&self, cursor: &CellCursor, frontier: &mut Vec<CellCursor>) -> Option<CellCursor> {
        let mut next = None;
        for (axis, a, b) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            let leave = cursor.axes[axis].leave;
            let [a, b] = [(a, &cursor.axes[a]), (b, &cursor.axes[b])];
            let is_met = leave <= a.1.exit && leave <= b.1.exit;
            let is_last = |(other, axis_interval): (usize, &AxisInterval)| {
                axis_interval.enter < leave || (axis_interval.enter == leave && other < axis)
            };
            if is_met
                && leave > self.start
                && is_last(a)
                && is_last(b)
                && cursor.coordinates[axis] + 1 < self.subgrid.counts[axis]
            {
                frontier.extend(next.replace(self.step(cursor, axis)));
            }
        }
        next
    }

    /// The cell beyond the far plane of an axis.
    #[inline]
    fn step(&self, cursor: &CellCursor, axis: usize) -> CellCursor {
        let mut next = *cursor;
        next.coordinates[axis] += 1;
        if self.ascends[axis] {
            next.cell += self.strides[axis];
        } else {
            next.cell -= self.strides[axis];
        }
        next.axes[axis] = self.axis_interval(axis, next.coordinates[axis], cursor.axes[axis].leave);
        next
    }

    #[inline]
    fn axis_interval(&self, axis: usize, coordinates: u32, enter: f64) -> AxisInterval {
        let behind = self.plane(axis, coordinates + 1);
        AxisInterval {
            enter,
            leave: self.ray.slope(axis).earliest(behind),
            exit: self.ray.slope(axis).latest(behind),
        }
    }

    #[inline]
    fn enters(&self, axis: usize, coordinates: u32) -> f64 {
        self.ray.slope(axis).earliest(self.plane(axis, coordinates))
    }

    /// The plane at which the ray enters the cells with an index along an axis.
    #[inline]
    fn plane(&self, axis: usize, coordinates: u32) -> f64 {
        let i = if self.ascends[axis] { coordinates } else { self.subgrid.counts[axis] - coordinates };
        self.subgrid.plane(axis, i)
    }
}
