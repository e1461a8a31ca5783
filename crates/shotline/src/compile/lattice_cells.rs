//! The placements of a lattice, computed when they are needed.

use std::sync::Arc;

use crate::aabb::Aabb;
use crate::math::{Affine, HALF_ULP, Lattice, ShiftedTransform, Vec3};
use crate::scene::EMPTY_CELL;

/// What the cells of a lattice hold: a target under a chain of transforms.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    pub transform: ShiftedTransform,
    /// The box of the target, in the frame of the target.
    pub bounds: Aabb,
    /// The number of bodies below, counted once for every placement.
    pub path_count: u64,
    pub leaf_count: u64,
}

/// The cells of a lattice with what is placed in them.
#[derive(Clone, Debug)]
pub(crate) struct LatticeCells {
    pub lattice: Lattice,
    elements: Vec<ShiftedTransform>,
    /// The box of each element in a cell that is not shifted.
    boxes: Vec<Aabb>,
    paths: Paths,
}

/// The element of each cell, and the number of its first path.
#[derive(Clone, Debug)]
enum Paths {
    /// All cells hold the same element, which has this number of paths.
    Same(u64),
    Table {
        elements: Arc<[u32]>,
        first_paths: Vec<u64>,
    },
}

impl LatticeCells {
    /// The cells of a lattice with one element, or with those that a table chooses from.
    pub fn new(lattice: Lattice, elements: Vec<Element>, table: Option<Arc<[u32]>>) -> LatticeCells {
        let paths = match table {
            None => Paths::Same(elements[0].path_count),
            Some(table) => {
                let mut sum = 0;
                let first_paths = table.iter().map(|&element| {
                    let first = sum;
                    sum += elements.get(element as usize).map_or(0, |element| element.path_count);
                    first
                });
                Paths::Table { first_paths: first_paths.collect(), elements: table }
            }
        };
        let last = [lattice.width(), lattice.rows(), lattice.layers()].map(|count| count - 1);
        // The middle row of a hexagon is the longest, the second of a staggered lattice reaches farthest.
        let ends = [0, 1.min(last[1]), last[1] / 2, last[1]].map(|row| {
            let row_end = |i| lattice.offset([i, row, last[2]]).abs();
            row_end(0).max(row_end(lattice.row(row).count - 1))
        });
        let reach = ends.into_iter().fold(Vec3::ZERO, Vec3::max);
        let boxes = elements.iter().map(|element| padded(element, reach)).collect();
        let elements = elements.into_iter().map(|element| element.transform).collect();
        LatticeCells { lattice, elements, boxes, paths }
    }

    /// The number of cells.
    pub fn count(&self) -> u32 {
        self.lattice.cell_count() as u32
    }

    /// The element of a cell; `None` for an empty cell.
    #[inline]
    pub fn element(&self, cell: u32) -> Option<u32> {
        match &self.paths {
            Paths::Same(_) => Some(0),
            Paths::Table { elements, .. } => Some(elements[cell as usize]).filter(|&e| e != EMPTY_CELL),
        }
    }

    /// The number of paths of the level that come before a cell.
    #[inline]
    pub fn first_path(&self, cell: u32) -> u64 {
        match &self.paths {
            Paths::Same(each) => u64::from(cell) * each,
            Paths::Table { first_paths, .. } => first_paths[cell as usize],
        }
    }

    /// The cell that a path of the level leads to.
    pub fn cell_of_path(&self, path: u64) -> u32 {
        match &self.paths {
            Paths::Same(each) => (path / each) as u32,
            // Of cells with the same number, the last has the path: those before it have none.
            Paths::Table { first_paths, .. } => {
                (first_paths.partition_point(|&first| first <= path) - 1) as u32
            }
        }
    }

    /// The transform into a cell that holds an element.
    #[inline]
    pub fn local_from_parent(&self, cell: u32, element: u32) -> Affine {
        self.elements[element as usize].at(self.lattice.offset(self.lattice.indices(cell)))
    }

    /// The box of an element in a cell.
    #[inline]
    pub fn bounds(&self, cell: u32, element: u32) -> Aabb {
        let (b, shift) = (self.boxes[element as usize], self.lattice.offset(self.lattice.indices(cell)));
        Aabb { min: b.min + shift, max: b.max + shift }
    }

    /// A box around all elements in a cell that is not shifted.
    pub fn element_bounds(&self) -> Aabb {
        self.boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b))
    }

    /// A box around all cells that are not empty.
    pub fn all_bounds(&self) -> Aabb {
        let (b, lattice) = (self.element_bounds(), &self.lattice);
        if b.is_empty() {
            return b;
        }
        if let Some(table) = self.table() {
            let boxes = (0..).zip(table.iter()).filter(|(_, element)| **element != EMPTY_CELL);
            let boxes = boxes.map(|(cell, element)| self.bounds(cell, *element));
            return boxes.fold(Aabb::EMPTY, |all, b| all.union(&b));
        }
        let last = [lattice.rows() - 1, lattice.layers() - 1];
        // The longest row of a hexagon is in the middle, that of a staggered lattice is its second.
        let rows = [0, 1.min(last[0]), last[0] / 2, last[0]].map(|row| lattice.row(row));
        let low = rows.iter().map(|row| row.x(0)).fold(f64::INFINITY, f64::min);
        let high = rows.iter().map(|row| row.x(row.count - 1)).fold(f64::NEG_INFINITY, f64::max);
        Aabb {
            min: b.min + Vec3::new(low, lattice.y(0), lattice.z(0)),
            max: b.max + Vec3::new(high, lattice.y(last[0]), lattice.z(last[1])),
        }
    }

    /// The element of each cell; `None` where all have the same.
    pub fn table(&self) -> Option<&Arc<[u32]>> {
        match &self.paths {
            Paths::Same(_) => None,
            Paths::Table { elements, .. } => Some(elements),
        }
    }

    /// Bytes used.
    pub fn memory(&self) -> usize {
        let table = match &self.paths {
            Paths::Same(_) => 0,
            Paths::Table { elements, first_paths } => {
                size_of_val(&elements[..]) + size_of_val(first_paths.as_slice())
            }
        };
        size_of::<LatticeCells>()
            + self.elements.iter().map(ShiftedTransform::memory).sum::<usize>()
            + size_of_val(self.boxes.as_slice())
            + table
    }
}

/// The box of an element in a cell that is not shifted, widened by the rounding of a shift up to `reach`. So the boxes of
/// shifted cells are sums: they never overtake one another, and a traversal can compute the faces of a whole row at once.
fn padded(element: &Element, reach: Vec3) -> Aabb {
    let Element { transform, bounds, .. } = element;
    let b = bounds.transformed(&transform.parent_from_local(Vec3::ZERO));
    let size = |v: Vec3| Vec3::select(v.is_finite_mask(), v.abs(), Vec3::ZERO);
    let pad = 8.0 * HALF_ULP * (size(b.min).max(size(b.max)) + reach) + f64::MIN_POSITIVE;
    Aabb { min: b.min - pad, max: b.max + pad }
}
