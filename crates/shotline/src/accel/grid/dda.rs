//! The march of a ray through the cells of a block.
//!
//! Amanatides and Woo add up the steps of `t`; here the `t` of each plane is worked out from the plane, with
//! its doubt: between `earliest` and `latest` the ray may be on either side. A cell is *met* if the interval
//! that its six planes leave is not empty, which is just what a test of its box would say. All cells that are
//! met are visited, each once. Along a ray in general position that is a chain; where it passes an edge or a
//! corner, or by, as near as rounding, all cells there are met.
//!
//! No item is lost: planes cut its box into pieces, one in each cell that it is listed in, and a `t` in the
//! interval of the box is in that of a piece (see [`Slope::earliest`](crate::aabb::Slope::earliest)), so in that of the piece's cell.
//!
//! Each met cell that is not met from the start is reached from one other: the one before it across the plane
//! that was passed last, and of several passed at the same `t` across that of the highest axis. That one is met
//! too: it shares the other two pairs of planes, and the interval of the pair only moves back to end at the
//! plane that is passed.

use super::SubGrid;
use crate::aabb::BoxRay;

/// A ray in a block.
pub(super) struct Dda<'a> {
    subgrid: &'a SubGrid,
    ray: &'a BoxRay,
    /// Where it comes in, or its span begins.
    start: f64,
    ascends: [bool; 3],
    strides: [usize; 3],
}

/// A cell that is met.
#[derive(Clone, Copy)]
pub(super) struct CellCursor {
    /// Its place along each axis, counted as the ray comes.
    pub coordinates: [u32; 3],
    /// Its number.
    pub cell: usize,
    axes: [AxisInterval; 3],
}

/// The interval that the planes of one axis leave.
#[derive(Clone, Copy, Default)]
struct AxisInterval {
    enter: f64,
    /// `earliest` and `latest` of the plane behind.
    leave: f64,
    exit: f64,
}

impl<'a> Dda<'a> {
    /// `None` if the ray passes by.
    #[inline]
    pub fn new(subgrid: &'a SubGrid, ray: &'a BoxRay) -> Option<Dda<'a>> {
        let (start, _) = ray.enter_exit(&subgrid.bounds)?;
        let ascends = [0, 1, 2].map(|axis| ray.slope(axis).ascends());
        Some(Dda { subgrid, ray, start, ascends, strides: subgrid.strides() })
    }

    /// Where the ray comes to a cell.
    #[inline]
    pub fn enter(&self, cursor: &CellCursor) -> f64 {
        let [x, y, z] = &cursor.axes;
        let last = if x.enter > y.enter { x.enter } else { y.enter };
        let last = if z.enter > last { z.enter } else { last };
        if last > self.start { last } else { self.start }
    }

    /// The cells met at the start: one, and all others on `frontier`.
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

    /// The first and last place along an axis where the ray can be at the start.
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

    /// The cell at a place.
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

    /// The cell to go on to; any others, where more than one is reached from here, on `frontier`.
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

    /// The cell behind the plane of an axis.
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

    /// The plane before a place.
    #[inline]
    fn plane(&self, axis: usize, coordinates: u32) -> f64 {
        let i = if self.ascends[axis] { coordinates } else { self.subgrid.counts[axis] - coordinates };
        self.subgrid.plane(axis, i)
    }
}
