//! A grid of cubic cells, with finer grids in crowded cells.
//!
//! A ray marches from cell to cell (Amanatides and Woo 1987, "A fast voxel traversal algorithm for ray
//! tracing"). One size of cells suits no scene that is crowded in some place and empty in others, a teapot in a
//! stadium; so a crowded cell holds a grid of its own, around what is in it, and the user need not know
//! which scenes are of that kind.

mod build;
mod march;

use super::{Accelerator, Offer, Pending, Visit, Work};
use crate::aabb::{Aabb, BoxRay};
use crate::math::Vec3;
use march::March;

/// Cells along an axis, at most: places are packed into parts with so many bits for each axis.
const PLACE_BITS: u32 = 10;
const MAX_CELLS: u32 = 1 << PLACE_BITS;

/// Cells of one size in a box.
#[derive(Clone, Copy, Debug)]
struct Block {
    bounds: Aabb,
    /// Edge lengths of a cell.
    step: Vec3,
    counts: [u32; 3],
    /// Its first cell; x runs fastest, then y.
    first_cell: usize,
}

impl Block {
    /// The `i`-th plane across an axis, of `counts + 1`; they ascend, and the outer ones are those of the box.
    #[inline]
    fn plane(&self, axis: usize, i: u32) -> f64 {
        if i >= self.counts[axis] {
            self.bounds.max[axis]
        } else {
            (self.bounds.min[axis] + self.step[axis] * f64::from(i)).min(self.bounds.max[axis])
        }
    }

    /// The cell that holds a coordinate, or one beside it: a first guess.
    #[inline]
    fn guess(&self, axis: usize, x: f64) -> u32 {
        // NaN, from an axis without extent, becomes 0.
        let i = ((x - self.bounds.min[axis]) / self.step[axis]) as u32;
        i.min(self.counts[axis] - 1)
    }

    /// How far apart cells are that lie beside each other along an axis.
    fn strides(&self) -> [usize; 3] {
        [1, self.counts[0] as usize, self.counts[0] as usize * self.counts[1] as usize]
    }
}

/// What a cell holds: the place of a run of items, or the number of a finer grid. One small number, for rays pass
/// many cells and mostly wait for them to come from memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Cell(u32);

impl Cell {
    /// The run at 0 is empty.
    const EMPTY: Cell = Cell(0);
    /// Marks blocks.
    const BLOCK: u32 = 1 << 31;

    fn of_block(block: usize) -> Cell {
        Cell(block as u32 | Cell::BLOCK)
    }

    fn block(self) -> Option<u32> {
        (self.0 & Cell::BLOCK != 0).then_some(self.0 & !Cell::BLOCK)
    }
}

/// The grid.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// The first is the whole. None without items.
    blocks: Vec<Block>,
    cells: Vec<Cell>,
    /// Runs of items, each after its length.
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

    /// Offers the cells in which a ray is when it comes to a block.
    fn offer_block(&self, block: u32, ray: &BoxRay, out: &mut Vec<Pending>, work: &mut Work) {
        work.boxes += 1;
        let Some(march) = March::new(&self.blocks[block as usize], ray) else { return };
        let mut starts = Vec::new();
        let first = march.begin(&mut starts);
        for here in starts.into_iter().chain([first]) {
            out.push(Pending { t: march.enter(&here), what: Offer::Part(pack(block, here.place)) });
        }
    }

    /// How many blocks there are around one: found by looking for the cell that holds it, which is slow.
    fn depth(&self, block: u32) -> usize {
        let holder = self.cells.iter().position(|cell| cell.block() == Some(block));
        holder.map_or(0, |cell| {
            let around = self.blocks.partition_point(|b| b.first_cell <= cell) - 1;
            1 + self.depth(around as u32)
        })
    }

    /// Walks through the cells of a block and answers the limit.
    fn walk_block(
        &self,
        block: u32,
        ray: &BoxRay,
        mut limit: f64,
        work: &mut Work,
        visit: &mut Visit,
    ) -> f64 {
        work.boxes += 1;
        let Some(march) = March::new(&self.blocks[block as usize], ray) else { return limit };
        let mut aside = Vec::new();
        let mut next = Some(march.begin(&mut aside));
        while let Some(here) = next.or_else(|| aside.pop()) {
            next = None;
            if march.enter(&here) > limit {
                continue;
            }
            work.cells += 1;
            let cell = self.cells[here.cell];
            if let Some(inner) = cell.block() {
                limit = self.walk_block(inner, ray, limit, work, visit);
            } else if cell != Cell::EMPTY {
                limit = visit(self.items(cell), work);
            }
            next = march.next(&here, &mut aside);
        }
        limit
    }
}

impl Accelerator for Grid {
    fn start(&self, ray: &BoxRay, out: &mut Vec<Pending>, work: &mut Work) {
        let t = ray.span().t_min();
        out.extend(self.unbounded.iter().map(|&i| Pending { t, what: Offer::Item(i) }));
        if !self.blocks.is_empty() {
            self.offer_block(0, ray, out, work);
        }
    }

    /// A part is a cell: its contents are offered and the cells that the ray comes to from there. Empty cells
    /// are passed at once.
    fn open(&self, part: u64, _t: f64, ray: &BoxRay, out: &mut Vec<Pending>, work: &mut Work) {
        let (block, place) = unpack(part);
        let Some(march) = March::new(&self.blocks[block as usize], ray) else { return };
        let here = march.at(place);
        work.cells += 1;
        let cell = self.cells[here.cell];
        if let Some(inner) = cell.block() {
            self.offer_block(inner, ray, out, work);
        } else {
            let t = march.enter(&here);
            out.extend(self.items(cell).iter().map(|&i| Pending { t, what: Offer::Item(i) }));
        }
        let mut aside = Vec::new();
        let mut next = march.next(&here, &mut aside);
        while let Some(here) = next.or_else(|| aside.pop()) {
            next = None;
            let t = march.enter(&here);
            if t > ray.span().t_max() {
                continue;
            }
            if self.cells[here.cell] == Cell::EMPTY {
                work.cells += 1;
                next = march.next(&here, &mut aside);
            } else {
                out.push(Pending { t, what: Offer::Part(pack(block, here.place)) });
            }
        }
    }

    fn walk(&self, ray: &BoxRay, work: &mut Work, visit: &mut Visit) {
        let mut limit = ray.span().t_max();
        if !self.unbounded.is_empty() {
            limit = visit(&self.unbounded, work);
        }
        if !self.blocks.is_empty() {
            self.walk_block(0, ray, limit, work, visit);
        }
    }

    fn describe(&self, part: u64, ray: &BoxRay) -> String {
        let (block, place) = unpack(part);
        let counts = self.blocks[block as usize].counts;
        let along = |axis: usize| {
            let i = place[axis];
            (if ray.slope(axis).ascends() { i } else { counts[axis] - 1 - i }).to_string()
        };
        let ([x, y, z], [nx, ny, nz]) = ([0, 1, 2].map(along), counts);
        format!("cell {x},{y},{z} of {nx} x {ny} x {nz} at depth {}", self.depth(block))
    }

    fn repeats(&self) -> bool {
        true
    }

    fn memory(&self) -> usize {
        size_of_val(self.blocks.as_slice())
            + size_of_val(self.cells.as_slice())
            + size_of_val(self.runs.as_slice())
            + size_of_val(self.unbounded.as_slice())
    }
}

/// A block and a place in it as the number of a part.
fn pack(block: u32, place: [u32; 3]) -> u64 {
    place.iter().fold(u64::from(block), |part, &i| part << PLACE_BITS | u64::from(i))
}

fn unpack(part: u64) -> (u32, [u32; 3]) {
    let place = [2, 1, 0].map(|i| (part >> (i * PLACE_BITS)) as u32 % MAX_CELLS);
    ((part >> (3 * PLACE_BITS)) as u32, place)
}
