//! Builds the grid: chooses the cell size, and the cells that are subdivided.

use super::{Cell, Grid, MAX_CELLS, SubGrid};
use crate::aabb::Aabb;
use crate::accel::prim_ref::{PrimRef, bounding_box, partition_unbounded};
use crate::math::Vec3;

/// Cells per item in the outermost grid. Few: where items form surfaces most of the grid is empty, and rays should
/// cross that in large steps.
const ROOT_DENSITY: f64 = 0.02;
/// Cells per item in the subgrids of crowded cells.
const SUBGRID_DENSITY: f64 = 16.0;
/// A cell with more items becomes a subgrid.
const MAX_ITEMS: usize = 16;
/// Maximum number of nested grids, including the outermost.
const MAX_DEPTH: u32 = 6;
/// Maximum mean number of cells of a subgrid that an item lies in; above it the cells are made larger.
const MAX_SPREAD: usize = 6;
/// Maximum mean number of additional references to an item, over the whole grid. It bounds the memory.
const MAX_TOTAL_SPREAD: usize = 16;
/// Maximum number of references that a [`Cell`] can address, if each is a run of its own, preceded by its length.
const MAX_LISTED: usize = 1 << 30;

/// A crowded cell, to be made a subgrid if that has more than one cell.
struct Task {
    cell: usize,
    items: Vec<PrimRef>,
    depth: u32,
}

struct Builder {
    grid: Grid,
    /// The number of references that may still be added.
    spare: usize,
}

pub(super) fn build(boxes: &[Aabb]) -> Grid {
    let (items, unbounded) = partition_unbounded(boxes);
    let grid = Grid { subgrids: Vec::new(), cells: Vec::new(), runs: vec![0], unbounded };
    let spare = (items.len() * MAX_TOTAL_SPREAD).min(MAX_LISTED.saturating_sub(items.len()));
    let mut builder = Builder { grid, spare };
    if !items.is_empty() {
        builder.run(items);
    }
    builder.grid
}

impl Builder {
    fn run(&mut self, items: Vec<PrimRef>) {
        let subgrid = self.subgrid(&items, ROOT_DENSITY);
        let mut tasks = self.fill(subgrid, &items, 0);
        drop(items);
        while let Some(Task { cell, items, depth }) = tasks.pop() {
            let subgrid = self.subgrid(&items, SUBGRID_DENSITY);
            if subgrid.counts != [1; 3] {
                self.grid.cells[cell] = Cell::of_subgrid(self.grid.subgrids.len());
                tasks.extend(self.fill(subgrid, &items, depth));
            } else {
                self.grid.cells[cell] = self.list(items.iter().map(|b| b.item));
            }
        }
    }

    /// Appends the run of a cell.
    fn list(&mut self, items: impl ExactSizeIterator<Item = u32>) -> Cell {
        let cell = Cell(self.grid.runs.len() as u32);
        self.grid.runs.push(items.len() as u32);
        self.grid.runs.extend(items);
        cell
    }

    /// A subgrid around items, with `density` cells per item, or as many as the limits on references allow.
    fn subgrid(&self, items: &[PrimRef], density: f64) -> SubGrid {
        let bounds = bounding_box(items);
        let mut counts = resolution(bounds.size(), items.len() as f64 * density);
        loop {
            let step = bounds.size() / Vec3::from(counts.map(f64::from));
            let subgrid = SubGrid { bounds, step, counts, first_cell: self.grid.cells.len() };
            let listed: usize = items.iter().map(|b| volume(&subgrid.cells_of(&b.bounds))).sum();
            let more = listed - items.len();
            if counts == [1; 3] || (listed <= items.len() * MAX_SPREAD && more <= self.spare) {
                return subgrid;
            }
            counts = counts.map(|n| n.div_ceil(2));
        }
    }

    /// Adds a subgrid with its cells. Returns the crowded cells as tasks.
    fn fill(&mut self, subgrid: SubGrid, items: &[PrimRef], depth: u32) -> Vec<Task> {
        let cells = subgrid.counts.iter().map(|&n| n as usize).product();
        self.grid.subgrids.push(subgrid);
        self.grid.cells.resize(subgrid.first_cell + cells, Cell::EMPTY);
        let listed = CellLists::new(&subgrid, items, cells);
        self.spare -= listed.items.len() - items.len();
        let mut tasks = Vec::new();
        for cell in 0..cells {
            let inside = listed.of(cell);
            let index = subgrid.first_cell + cell;
            if inside.len() > MAX_ITEMS && depth + 1 < MAX_DEPTH {
                let bounds = subgrid.bounds_of(cell);
                let clip = |i: &u32| {
                    let PrimRef { bounds: whole, item } = items[*i as usize];
                    PrimRef { bounds: whole.intersection(&bounds), item }
                };
                let items = inside.iter().map(clip).collect();
                tasks.push(Task { cell: index, items, depth: depth + 1 });
            } else if !inside.is_empty() {
                self.grid.cells[index] = self.list(inside.iter().map(|&i| items[i as usize].item));
            }
        }
        tasks
    }
}

/// The items of each cell of a subgrid, as indices into the list given.
struct CellLists {
    ends: Vec<usize>,
    items: Vec<u32>,
}

impl CellLists {
    /// Sorts by counting.
    fn new(subgrid: &SubGrid, items: &[PrimRef], cells: usize) -> CellLists {
        let mut ends = vec![0; cells];
        for_each_cell(subgrid, items, |cell, _| ends[cell] += 1);
        let mut sum = 0;
        for end in &mut ends {
            (*end, sum) = (sum, sum + *end);
        }
        let mut listed = vec![0; sum];
        for_each_cell(subgrid, items, |cell, i| {
            listed[ends[cell]] = i;
            ends[cell] += 1;
        });
        CellLists { ends, items: listed }
    }

    fn of(&self, cell: usize) -> &[u32] {
        let start = if cell == 0 { 0 } else { self.ends[cell - 1] };
        &self.items[start..self.ends[cell]]
    }
}

fn for_each_cell(subgrid: &SubGrid, items: &[PrimRef], mut each: impl FnMut(usize, u32)) {
    let [_, down, back] = subgrid.strides();
    for (i, item) in (0..).zip(items) {
        let [x, y, z] = subgrid.cells_of(&item.bounds);
        for k in z.0..=z.1 {
            for j in y.0..=y.1 {
                let row = j as usize * down + k as usize * back;
                (x.0..=x.1).for_each(|cell| each(row + cell as usize, i));
            }
        }
    }
}

/// The first and the last cell along each axis.
type Range = [(u32, u32); 3];

fn volume(range: &Range) -> usize {
    range.iter().map(|(first, last)| (last - first + 1) as usize).product()
}

impl SubGrid {
    /// The cells that together contain a box. A box that ends at a plane does not extend beyond it.
    fn cells_of(&self, b: &Aabb) -> Range {
        [0, 1, 2].map(|axis| {
            let (low, high) = (b.min[axis], b.max[axis]);
            let mut first = self.guess(axis, low);
            while first > 0 && self.plane(axis, first) > low {
                first -= 1;
            }
            while first + 1 < self.counts[axis] && self.plane(axis, first + 1) <= low {
                first += 1;
            }
            let mut last = self.guess(axis, high).max(first);
            while last + 1 < self.counts[axis] && self.plane(axis, last + 1) < high {
                last += 1;
            }
            while last > first && self.plane(axis, last) >= high {
                last -= 1;
            }
            (first, last)
        })
    }

    fn bounds_of(&self, cell: usize) -> Aabb {
        let [x, y] = [self.counts[0] as usize, self.counts[1] as usize];
        let index = [cell % x, cell / x % y, cell / (x * y)].map(|i| i as u32);
        let corner = |more: u32| Vec3::from([0, 1, 2].map(|axis| self.plane(axis, index[axis] + more)));
        Aabb::new(corner(0), corner(1))
    }
}

/// The numbers of cubic cells along the axes that give about `cells` in total.
fn resolution(size: Vec3, cells: f64) -> [u32; 3] {
    let longest = size.max_element();
    if longest == 0.0 {
        return [1; 3];
    }
    // An axis that is shorter than a cell gets one cell; the total is reached along the others.
    let mut counts = [1; 3];
    let mut axes = vec![0, 1, 2];
    loop {
        let relative = |axis: usize| size[axis] / longest;
        let volume: f64 = axes.iter().map(|&axis| relative(axis)).product();
        let edge = (volume / cells).powf(1.0 / axes.len() as f64);
        let before = axes.len();
        axes.retain(|&axis| relative(axis) >= edge && relative(axis) > 0.0);
        if axes.len() < before && !axes.is_empty() {
            continue;
        }
        for axis in axes {
            counts[axis] = ((relative(axis) / edge).ceil() as u32).clamp(1, MAX_CELLS);
        }
        return counts;
    }
}
