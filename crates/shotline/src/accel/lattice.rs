//! The structure over a lattice of items: nothing is stored, the cells that a ray meets are computed.
//!
//! All cells with one index along an axis share the faces of their boxes on that axis, so a ray is in them for one
//! interval of `t`. The traversal steps through the layers that the ray meets, in each through the rows that it meets
//! while it is in the layer, and in each of these through the cells: the idea of Amanatides and Woo (1987, "A fast voxel
//! traversal algorithm for ray tracing"), but without planes between cells, so boxes may overlap and still each is
//! proposed once. Each step makes the next one pending, so the cost is that of the cells met before the traversal ends.

use std::sync::Arc;

use super::{Accelerator, Child, QueueEntry};
use crate::aabb::{Aabb, BoxRay, Slope};
use crate::counters::Counters;
use crate::math::Lattice;
use crate::outline::Outline;

/// The cells of a lattice as items.
#[derive(Clone, Debug)]
pub struct LatticeIndex {
    lattice: Lattice,
    /// Contains the box of every item, shifted back by the place of its cell.
    bounds: Aabb,
    /// The cells without an item have the largest number.
    table: Option<Arc<[u32]>>,
}

/// The slabs between the boxes' faces along one axis, in the order in which a ray meets them.
struct Slabs<P> {
    slope: Slope,
    ascends: bool,
    /// The faces of a box that is not shifted: that at which the ray enters, and the other.
    near: f64,
    far: f64,
    count: u32,
    /// By how much the box with an index is shifted.
    place: P,
}

/// The part of a ray that is in some slabs.
#[derive(Clone, Copy)]
struct Stretch {
    enter: f64,
    exit: f64,
}

impl<P: Fn(u32) -> f64> Slabs<P> {
    fn new(ray: &BoxRay, axis: usize, bounds: &Aabb, count: u32, place: P) -> Slabs<P> {
        let slope = ray.slope(axis);
        let ascends = slope.ascends();
        let (low, high) = (bounds.min[axis], bounds.max[axis]);
        let (near, far) = if ascends { (low, high) } else { (high, low) };
        Slabs { slope, ascends, near, far, count, place }
    }

    /// The index along the axis of the `step`-th slab.
    fn index(&self, step: u32) -> u32 {
        if self.ascends { step } else { self.count - 1 - step }
    }

    fn enter(&self, step: u32) -> f64 {
        self.slope.earliest(self.near + (self.place)(self.index(step)))
    }

    fn exit(&self, step: u32) -> f64 {
        self.slope.latest(self.far + (self.place)(self.index(step)))
    }

    /// The part of a stretch that is in a slab.
    fn part(&self, step: u32, of: Stretch) -> Stretch {
        Stretch { enter: of.enter.max(self.enter(step)), exit: of.exit.min(self.exit(step)) }
    }

    /// The first slab that the ray has not left when a stretch begins, if it enters it before the stretch ends.
    fn first(&self, of: Stretch) -> Option<u32> {
        // Exits ascend.
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            if self.exit(middle) < of.enter { low = middle + 1 } else { high = middle }
        }
        self.reached(low, of)
    }

    /// The next slab, if the ray enters it before the stretch ends.
    fn next(&self, step: u32, of: Stretch) -> Option<u32> {
        self.reached(step + 1, of)
    }

    fn reached(&self, step: u32, of: Stretch) -> Option<u32> {
        (step < self.count && self.enter(step) <= of.exit).then_some(step)
    }
}

/// A step of a traversal: a layer, a row of it, or a cell of that. Each stands for those after it too.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Layer(u32),
    Row(u32, u32),
    Cell(u32, u32, u32),
}

impl LatticeIndex {
    /// A structure over the cells of a lattice. The box of each is in `bounds`, shifted by the place of the cell. Cells whose
    /// number in the table is the largest have no item.
    pub fn new(lattice: Lattice, bounds: Aabb, table: Option<Arc<[u32]>>) -> LatticeIndex {
        LatticeIndex { lattice, bounds, table }
    }

    fn layers(&self, ray: &BoxRay) -> Slabs<impl Fn(u32) -> f64> {
        Slabs::new(ray, 2, &self.bounds, self.lattice.layers(), |k| self.lattice.z(k))
    }

    fn rows(&self, ray: &BoxRay) -> Slabs<impl Fn(u32) -> f64> {
        Slabs::new(ray, 1, &self.bounds, self.lattice.rows(), |j| self.lattice.y(j))
    }

    fn cells(&self, ray: &BoxRay, row: u32) -> Slabs<impl Fn(u32) -> f64> {
        let row = self.lattice.row(row);
        Slabs::new(ray, 0, &self.bounds, row.count, move |i| row.x(i))
    }

    fn pack(&self, step: Step) -> u64 {
        let (rows, width) = (u64::from(self.lattice.rows()), u64::from(self.lattice.width()));
        let row = |k: u32, j: u32| u64::from(k) * rows + u64::from(j);
        match step {
            Step::Layer(k) => u64::from(k) << 2,
            Step::Row(k, j) => row(k, j) << 2 | 1,
            Step::Cell(k, j, i) => (row(k, j) * width + u64::from(i)) << 2 | 2,
        }
    }

    fn unpack(&self, node: u64) -> Step {
        let (rows, width) = (u64::from(self.lattice.rows()), u64::from(self.lattice.width()));
        let number = node >> 2;
        let row = |number: u64| ((number / rows) as u32, (number % rows) as u32);
        match node & 3 {
            0 => Step::Layer(number as u32),
            1 => Step::Row(row(number).0, row(number).1),
            _ => {
                let (k, j) = row(number / width);
                Step::Cell(k, j, (number % width) as u32)
            }
        }
    }

    /// Makes a layer pending.
    fn push(&self, step: Step, t: f64, out: &mut Vec<QueueEntry>) {
        out.push(QueueEntry { t, child: Child::Node(self.pack(step)) });
    }

    /// Steps into a layer, and makes the next one pending.
    fn open_layer(&self, k: u32, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        let (layers, whole) = (self.layers(ray), whole(ray));
        if let Some(next) = layers.next(k, whole) {
            self.push(Step::Layer(next), layers.part(next, whole).enter, out);
        }
        let part = layers.part(k, whole);
        if let Some(j) = self.rows(ray).first(part) {
            self.open_row(k, j, ray, out, counters);
        }
    }

    fn open_row(&self, k: u32, j: u32, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        let (layers, rows) = (self.layers(ray), self.rows(ray));
        let in_layer = layers.part(k, whole(ray));
        if let Some(next) = rows.next(j, in_layer) {
            self.push(Step::Row(k, next), rows.part(next, in_layer).enter, out);
        }
        let in_row = rows.part(j, in_layer);
        if let Some(i) = self.cells(ray, rows.index(j)).first(in_row) {
            self.open_cells((k, j, i), in_row, ray, out, counters);
        }
    }

    /// Proposes the next cell of a row that has an item, and makes the one after it pending.
    fn open_cells(
        &self,
        (k, j, first): (u32, u32, u32),
        in_row: Stretch,
        ray: &BoxRay,
        out: &mut Vec<QueueEntry>,
        counters: &mut Counters,
    ) {
        let row = self.rows(ray).index(j);
        let (cells, layer) = (self.cells(ray, row), self.layers(ray).index(k));
        let mut next = Some(first);
        while let Some(i) = next {
            counters.cells += 1;
            next = cells.next(i, in_row);
            let cell = self.lattice.number([cells.index(i), row, layer]);
            if self.table.as_ref().is_some_and(|table| table[cell as usize] == u32::MAX) {
                continue;
            }
            out.push(QueueEntry { t: cells.part(i, in_row).enter, child: Child::Item(cell) });
            if let Some(next) = next {
                self.push(Step::Cell(k, j, next), cells.part(next, in_row).enter, out);
            }
            return;
        }
    }
}

fn whole(ray: &BoxRay) -> Stretch {
    Stretch { enter: ray.span().t_min(), exit: ray.span().t_max() }
}

impl Accelerator for LatticeIndex {
    fn roots(&self, ray: &BoxRay, out: &mut Vec<QueueEntry>, _counters: &mut Counters) {
        if self.bounds.is_empty() {
            return;
        }
        let (layers, whole) = (self.layers(ray), whole(ray));
        if let Some(first) = layers.first(whole) {
            self.push(Step::Layer(first), layers.part(first, whole).enter, out);
        }
    }

    fn expand(&self, node: u64, _t: f64, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        match self.unpack(node) {
            Step::Layer(k) => self.open_layer(k, ray, out, counters),
            Step::Row(k, j) => self.open_row(k, j, ray, out, counters),
            Step::Cell(k, j, i) => {
                let in_row = self.rows(ray).part(j, self.layers(ray).part(k, whole(ray)));
                self.open_cells((k, j, i), in_row, ray, out, counters);
            }
        }
    }

    fn describe(&self, node: u64, ray: &BoxRay) -> String {
        let (layers, rows) = (self.layers(ray), self.rows(ray));
        match self.unpack(node) {
            Step::Layer(k) => format!("layer {} of {}", layers.index(k), layers.count),
            Step::Row(k, j) => format!("row {} of layer {}", rows.index(j), layers.index(k)),
            Step::Cell(k, j, i) => {
                let row = rows.index(j);
                format!("cell {},{row},{}", self.cells(ray, row).index(i), layers.index(k))
            }
        }
    }

    fn outline(&self, node: u64, ray: &BoxRay) -> Option<Outline> {
        let (layers, rows) = (self.layers(ray), self.rows(ray));
        let Step::Cell(k, j, i) = self.unpack(node) else { return None };
        let row = rows.index(j);
        let cell = self.lattice.number([self.cells(ray, row).index(i), row, layers.index(k)]);
        let offset = self.lattice.offset(self.lattice.indices(cell));
        Some(Outline::Box(Aabb::new(self.bounds.min + offset, self.bounds.max + offset)))
    }

    fn has_duplicate_refs(&self) -> bool {
        false
    }

    fn memory(&self) -> usize {
        size_of::<LatticeIndex>()
    }
}
