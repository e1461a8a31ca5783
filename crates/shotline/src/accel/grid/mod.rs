//! A grid of cubic cells, with finer grids in crowded cells.
//!
//! A ray steps from cell to cell (Amanatides and Woo 1987, "A fast voxel traversal algorithm for ray tracing"). No
//! single cell size suits a scene that is crowded in one region and empty elsewhere, such as a teapot in a stadium. A
//! crowded cell therefore holds a grid of its own around its contents. The user need not know which scenes need this.

mod build;
mod dda;

use super::{Accelerator, Child, QueueEntry, Visitor};
use crate::aabb::{Aabb, BoxRay};
use crate::counters::Counters;
use crate::math::Vec3;
use crate::outline::Outline;
use dda::Dda;

/// Bits for each coordinate of a cell in a node number. They limit the number of cells along an axis.
const COORDINATE_BITS: u32 = 10;
const MAX_CELLS: u32 = 1 << COORDINATE_BITS;

/// A box divided into cells of one size.
#[derive(Clone, Copy, Debug)]
struct SubGrid {
    bounds: Aabb,
    /// Edge lengths of a cell.
    step: Vec3,
    counts: [u32; 3],
    /// Index of its first cell; x runs fastest, then y.
    first_cell: usize,
}

impl SubGrid {
    /// The `i`-th of `counts + 1` planes perpendicular to an axis. They ascend, and the outer ones are faces of the
    /// box.
    #[inline]
    fn plane(&self, axis: usize, i: u32) -> f64 {
        if i >= self.counts[axis] {
            self.bounds.max[axis]
        } else {
            (self.bounds.min[axis] + self.step[axis] * f64::from(i)).min(self.bounds.max[axis])
        }
    }

    /// The cell that contains a coordinate, or a neighbour of that cell: a first guess.
    #[inline]
    fn guess(&self, axis: usize, x: f64) -> u32 {
        // NaN, from an axis without extent, becomes 0.
        let i = ((x - self.bounds.min[axis]) / self.step[axis]) as u32;
        i.min(self.counts[axis] - 1)
    }

    /// The difference between the indices of neighbouring cells along each axis.
    fn strides(&self) -> [usize; 3] {
        [1, self.counts[0] as usize, self.counts[0] as usize * self.counts[1] as usize]
    }
}

/// The contents of a cell: the position of a run of items, or the index of a finer grid. It is one small number
/// because rays pass many cells and mostly wait for memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Cell(u32);

impl Cell {
    /// The run at 0 is empty.
    const EMPTY: Cell = Cell(0);
    /// The bit that marks the index of a finer grid.
    const SUBGRID: u32 = 1 << 31;

    fn of_subgrid(subgrid: usize) -> Cell {
        Cell(subgrid as u32 | Cell::SUBGRID)
    }

    fn subgrid(self) -> Option<u32> {
        (self.0 & Cell::SUBGRID != 0).then_some(self.0 & !Cell::SUBGRID)
    }
}

/// The grid.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// The first one contains all bounded items. Empty if there are none.
    subgrids: Vec<SubGrid>,
    cells: Vec<Cell>,
    /// Runs of items, each preceded by its length.
    runs: Vec<u32>,
    /// Items without finite bounds, proposed first.
    unbounded: Vec<u32>,
}

impl Grid {
    pub(super) fn build(boxes: &[Aabb]) -> Grid {
        build::build(boxes)
    }

    fn items(&self, cell: Cell) -> &[u32] {
        let run = &self.runs[cell.0 as usize..];
        &run[1..][..run[0] as usize]
    }

    /// Queues the cells in which a ray is when it enters a subgrid.
    fn push_start_cells(
        &self,
        subgrid: u32,
        ray: &BoxRay,
        out: &mut Vec<QueueEntry>,
        counters: &mut Counters,
    ) {
        counters.boxes += 1;
        let Some(dda) = Dda::new(&self.subgrids[subgrid as usize], ray) else { return };
        let mut starts = Vec::new();
        let first = dda.begin(&mut starts);
        for cursor in starts.into_iter().chain([first]) {
            out.push(QueueEntry {
                t: dda.enter(&cursor),
                child: Child::Node(pack(subgrid, cursor.coordinates)),
            });
        }
    }

    /// The number of the subgrid of a node, and the indices of its cell there along the axes.
    fn subgrid_and_cell(&self, node: u64, ray: &BoxRay) -> (u32, [u32; 3]) {
        let (subgrid, steps) = unpack(node);
        let counts = self.subgrids[subgrid as usize].counts;
        let index = |axis: usize| {
            // Steps are counted along the ray.
            let step = steps[axis];
            if ray.slope(axis).ascends() { step } else { counts[axis] - 1 - step }
        };
        (subgrid, [0, 1, 2].map(index))
    }

    /// The number of subgrids around a subgrid. This is slow: it searches for the cell that holds the subgrid.
    fn depth(&self, subgrid: u32) -> usize {
        let holder = self.cells.iter().position(|cell| cell.subgrid() == Some(subgrid));
        holder.map_or(0, |cell| {
            let around = self.subgrids.partition_point(|b| b.first_cell <= cell) - 1;
            1 + self.depth(around as u32)
        })
    }

    /// Traverses the cells of a subgrid. Returns the limit for `t`.
    fn traverse_subgrid(
        &self,
        subgrid: u32,
        ray: &BoxRay,
        mut limit: f64,
        counters: &mut Counters,
        visit: &mut Visitor,
    ) -> f64 {
        counters.boxes += 1;
        let Some(dda) = Dda::new(&self.subgrids[subgrid as usize], ray) else { return limit };
        let mut frontier = Vec::new();
        let mut next = Some(dda.begin(&mut frontier));
        while let Some(cursor) = next.or_else(|| frontier.pop()) {
            next = None;
            if dda.enter(&cursor) > limit {
                continue;
            }
            counters.cells += 1;
            let cell = self.cells[cursor.cell];
            if let Some(inner) = cell.subgrid() {
                limit = self.traverse_subgrid(inner, ray, limit, counters, visit);
            } else if cell != Cell::EMPTY {
                limit = visit(self.items(cell), counters);
            }
            next = dda.next(&cursor, &mut frontier);
        }
        limit
    }
}

impl Accelerator for Grid {
    fn roots(&self, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        let t = ray.span().t_min();
        out.extend(self.unbounded.iter().map(|&i| QueueEntry { t, child: Child::Item(i) }));
        if !self.subgrids.is_empty() {
            self.push_start_cells(0, ray, out, counters);
        }
    }

    /// A node is a cell. Queues its contents, and the cells that the ray reaches from it; skips empty cells at once.
    fn expand(&self, node: u64, _t: f64, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        let (subgrid, coordinates) = unpack(node);
        let Some(dda) = Dda::new(&self.subgrids[subgrid as usize], ray) else { return };
        let cursor = dda.at(coordinates);
        counters.cells += 1;
        let cell = self.cells[cursor.cell];
        if let Some(inner) = cell.subgrid() {
            self.push_start_cells(inner, ray, out, counters);
        } else {
            let t = dda.enter(&cursor);
            out.extend(self.items(cell).iter().map(|&i| QueueEntry { t, child: Child::Item(i) }));
        }
        let mut frontier = Vec::new();
        let mut next = dda.next(&cursor, &mut frontier);
        while let Some(cursor) = next.or_else(|| frontier.pop()) {
            next = None;
            let t = dda.enter(&cursor);
            if t > ray.span().t_max() {
                continue;
            }
            if self.cells[cursor.cell] == Cell::EMPTY {
                counters.cells += 1;
                next = dda.next(&cursor, &mut frontier);
            } else {
                out.push(QueueEntry { t, child: Child::Node(pack(subgrid, cursor.coordinates)) });
            }
        }
    }

    fn traverse(&self, ray: &BoxRay, counters: &mut Counters, visit: &mut Visitor) {
        let mut limit = ray.span().t_max();
        if !self.unbounded.is_empty() {
            limit = visit(&self.unbounded, counters);
        }
        if !self.subgrids.is_empty() {
            self.traverse_subgrid(0, ray, limit, counters, visit);
        }
    }

    fn describe(&self, node: u64, ray: &BoxRay) -> String {
        let (number, [x, y, z]) = self.subgrid_and_cell(node, ray);
        let [nx, ny, nz] = self.subgrids[number as usize].counts;
        format!("cell {x},{y},{z} of {nx} x {ny} x {nz} at depth {}", self.depth(number))
    }

    fn outline(&self, node: u64, ray: &BoxRay) -> Option<Outline> {
        let (number, cell) = self.subgrid_and_cell(node, ray);
        let subgrid = &self.subgrids[number as usize];
        let corner = |step: u32| Vec3::from([0, 1, 2].map(|axis| subgrid.plane(axis, cell[axis] + step)));
        Some(Outline::Box(Aabb::new(corner(0), corner(1))))
    }

    fn has_duplicate_refs(&self) -> bool {
        true
    }

    fn memory(&self) -> usize {
        size_of_val(self.subgrids.as_slice())
            + size_of_val(self.cells.as_slice())
            + size_of_val(self.runs.as_slice())
            + size_of_val(self.unbounded.as_slice())
    }
}

/// Packs a subgrid and the coordinates of a cell into a node number.
fn pack(subgrid: u32, coordinates: [u32; 3]) -> u64 {
    coordinates.iter().fold(u64::from(subgrid), |node, &i| node << COORDINATE_BITS | u64::from(i))
}

fn unpack(node: u64) -> (u32, [u32; 3]) {
    let coordinates = [2, 1, 0].map(|i| (node >> (i * COORDINATE_BITS)) as u32 % MAX_CELLS);
    ((node >> (3 * COORDINATE_BITS)) as u32, coordinates)
}
