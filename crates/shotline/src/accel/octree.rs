//! An octree: crowded cells are cut into octants at their centre (Glassner 1984, "Space subdivision for fast ray
//! tracing").
//!
//! A cell is shrunk to its contents before it is cut. So rays skip empty space at once, and a crowd of items that is
//! small relative to its surroundings is reached in one step.

use super::prim_ref::{PrimRef, bounding_box, measure, partition_unbounded};
use super::{Accelerator, Child, QueueEntry, Visitor, display};
use crate::aabb::{Aabb, BoxRay};
use crate::counters::Counters;
use crate::math::Vec3;
use crate::outline::Outline;

/// Maximum number of nested cells, including the root.
const MAX_DEPTH: usize = 24;
/// Cells of at most this many items are not cut.
const MAX_LEAF: usize = 4;
/// The cost of visiting a cell, in units of an item test.
const CELL_COST: f64 = 1.0;
/// Maximum mean number of references to an item. It bounds the memory.
const MAX_SPREAD: usize = 8;
/// A traversal leaves up to seven cells on its stack at each depth.
const MAX_STACK: usize = 7 * MAX_DEPTH + 1;

/// A cell, shrunk to its contents.
#[derive(Clone, Copy, Debug)]
struct Cell {
    bounds: Aabb,
    /// Index of the first of its adjacent children, or of the first item in `items`.
    first: u32,
    /// Number of children, up to eight; 0 for a leaf.
    children: u32,
    /// Number of items of a leaf.
    count: u32,
}

/// The tree.
#[derive(Clone, Debug)]
pub(super) struct Octree {
    /// The root is the first. Empty if there are no bounded items.
    cells: Vec<Cell>,
    items: Vec<u32>,
    /// Items without finite bounds, proposed first.
    unbounded: Vec<u32>,
}

/// A cell to cut or to keep as a leaf. Cuts in its subtree may add at most `spare` references.
struct Task {
    cell: usize,
    items: Vec<PrimRef>,
    depth: usize,
    spare: usize,
}

impl Octree {
    pub(super) fn build(boxes: &[Aabb]) -> Octree {
        let (items, unbounded) = partition_unbounded(boxes);
        let mut tree = Octree { cells: Vec::new(), items: Vec::new(), unbounded };
        let mut tasks = Vec::new();
        if !items.is_empty() {
            tree.cells.push(new_leaf(bounding_box(&items)));
            let spare = items.len() * (MAX_SPREAD - 1);
            tasks.push(Task { cell: 0, items, depth: 0, spare });
        }
        while let Some(task) = tasks.pop() {
            tree.split_or_keep(task, &mut tasks);
        }
        tree
    }

    fn split_or_keep(&mut self, Task { cell, items, depth, spare }: Task, tasks: &mut Vec<Task>) {
        let bounds = self.cells[cell].bounds;
        if items.len() > MAX_LEAF && depth + 1 < MAX_DEPTH {
            let children = cut(&bounds, &items);
            let listed: usize = children.iter().map(Vec::len).sum();
            let more = listed - items.len();
            if more <= spare && is_worth_splitting(&bounds, &items, &children) {
                self.cells[cell].first = self.cells.len() as u32;
                self.cells[cell].children = children.len() as u32;
                for items in children {
                    let cell = self.cells.len();
                    self.cells.push(new_leaf(bounding_box(&items)));
                    let spare = (spare - more) * items.len() / listed;
                    tasks.push(Task { cell, items, depth: depth + 1, spare });
                }
                return;
            }
        }
        self.cells[cell].first = self.items.len() as u32;
        self.cells[cell].count = items.len() as u32;
        self.items.extend(items.iter().map(|b| b.item));
    }

    fn leaf_items(&self, cell: &Cell) -> &[u32] {
        &self.items[cell.first as usize..][..cell.count as usize]
    }

    fn children(&self, cell: &Cell) -> std::ops::Range<u32> {
        cell.first..cell.first + cell.children
    }

    fn enter(&self, cell: u32, ray: &BoxRay) -> Option<f64> {
        ray.enter_exit(&self.cells[cell as usize].bounds).map(|(enter, _)| enter)
    }

    /// Queues a cell that is entered at `t`, or its items if it is a leaf.
    fn push_children(&self, index: u32, t: f64, out: &mut Vec<QueueEntry>) {
        let cell = &self.cells[index as usize];
        if cell.children > 0 {
            out.push(QueueEntry { t, child: Child::Node(u64::from(index)) });
        } else {
            out.extend(self.leaf_items(cell).iter().map(|&i| QueueEntry { t, child: Child::Item(i) }));
        }
    }
}

fn new_leaf(bounds: Aabb) -> Cell {
    Cell { bounds, first: 0, children: 0, count: 0 }
}

/// The contents of the octants of a box that are not empty. A box that ends at the middle does not extend beyond it.
fn cut(bounds: &Aabb, items: &[PrimRef]) -> Vec<Vec<PrimRef>> {
    let middle = bounds.centre();
    let mut children = vec![Vec::new(); 8];
    for b in items {
        let above = b.bounds.max.cmpgt(middle).bitmask();
        let below = b.bounds.min.cmplt(middle).bitmask() | !above;
        for (eighth, child) in (0..8).zip(&mut children) {
            if eighth & !above == 0 && !eighth & !below & 7 == 0 {
                let clipped = b.bounds.intersection(&octant(middle, eighth));
                child.push(PrimRef { bounds: clipped, item: b.item });
            }
        }
    }
    children.retain(|child| !child.is_empty());
    children
}

/// The octant of space on one side of the middle along each axis: above it where the bit of the axis is set.
fn octant(middle: Vec3, bits: u32) -> Aabb {
    let mut octant = Aabb::EVERYTHING;
    for axis in 0..3 {
        let end = if bits >> axis & 1 == 1 { &mut octant.min } else { &mut octant.max };
        end[axis] = middle[axis];
    }
    octant
}

/// Whether visiting the children is cheaper than testing all items (MacDonald and Booth 1990).
fn is_worth_splitting(bounds: &Aabb, items: &[PrimRef], children: &[Vec<PrimRef>]) -> bool {
    let measure = measure(bounds);
    let cost: f64 = children.iter().map(|p| measure(&bounding_box(p)) * (p.len() as f64 + CELL_COST)).sum();
    cost < measure(bounds) * items.len() as f64
}

impl Accelerator for Octree {
    fn roots(&self, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        let t = ray.span().t_min();
        out.extend(self.unbounded.iter().map(|&i| QueueEntry { t, child: Child::Item(i) }));
        if !self.cells.is_empty() {
            counters.boxes += 1;
            if let Some(t) = self.enter(0, ray) {
                self.push_children(0, t, out);
            }
        }
    }

    /// A node is a cell with children.
    fn expand(&self, node: u64, _t: f64, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        let cell = &self.cells[node as usize];
        counters.cells += 1;
        counters.boxes += u64::from(cell.children);
        for child in self.children(cell) {
            if let Some(t) = self.enter(child, ray) {
                self.push_children(child, t, out);
            }
        }
    }

    fn traverse(&self, ray: &BoxRay, counters: &mut Counters, visit: &mut Visitor) {
        let mut limit = ray.span().t_max();
        if !self.unbounded.is_empty() {
            limit = visit(&self.unbounded, counters);
        }
        if self.cells.is_empty() {
            return;
        }
        counters.boxes += 1;
        let Some(t) = self.enter(0, ray) else { return };
        let mut stack = [(0.0, 0); MAX_STACK];
        stack[0] = (t, 0);
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (t, index) = stack[height];
            if t > limit {
                continue;
            }
            let cell = &self.cells[index as usize];
            counters.cells += 1;
            if cell.children == 0 {
                limit = visit(self.leaf_items(cell), counters);
                continue;
            }
            counters.boxes += u64::from(cell.children);
            let base = height;
            for child in self.children(cell) {
                let Some(t) = self.enter(child, ray) else { continue };
                // Insertion sort, with the nearest child on top.
                let mut slot = height;
                while slot > base && stack[slot - 1].0 < t {
                    stack[slot] = stack[slot - 1];
                    slot -= 1;
                }
                stack[slot] = (t, child);
                height += 1;
            }
        }
    }

    fn describe(&self, node: u64, _ray: &BoxRay) -> String {
        let cell = &self.cells[node as usize];
        format!("cell {}, cut into {}", display::box_of(&cell.bounds), cell.children)
    }

    fn outline(&self, node: u64, _ray: &BoxRay) -> Option<Outline> {
        Some(Outline::Box(self.cells[node as usize].bounds))
    }

    fn has_duplicate_refs(&self) -> bool {
        true
    }

    fn memory(&self) -> usize {
        size_of_val(self.cells.as_slice())
            + size_of_val(self.items.as_slice())
            + size_of_val(self.unbounded.as_slice())
    }
}
