//! An octree of cubic cells, each of which is whole or divided into eight.

use shotline::aabb::Aabb;
use shotline::math::Vec3;

/// The side of the whole octree, in units. Indices count units, so that corners of cells and middles of edges have whole numbers.
const WHOLE: u32 = 1 << 20;

/// How far the octree reaches beyond the lowest corner of the bounds, as parts of its side. The parts differ, so that planes of
/// usual models lie on no side of a cell.
const MARGIN: [f64; 3] = [0.0414, 0.0618, 0.0526];

/// The side of the octree divided by the longest side of the bounds: room for the margins on both sides.
const ROOM: f64 = 1.13;

/// The position of a point of the octree, in units.
pub type Index = [u32; 3];

/// A number for a point, which no other point has.
pub fn key(index: Index) -> u64 {
    index.into_iter().fold(0, |key, i| key << 21 | u64::from(i))
}

/// A cell.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Its lowest corner.
    pub low: Index,
    /// Its side.
    pub size: u32,
    /// The first of its eight parts; 0 if it is whole.
    parts: u32,
}

impl Cell {
    pub fn is_whole(&self) -> bool {
        self.parts == 0
    }

    /// One of its eight corners: bit `axis` of the number tells whether it is at the upper end along the axis.
    pub fn corner(&self, number: usize) -> Index {
        std::array::from_fn(|axis| self.low[axis] + ((number >> axis) as u32 & 1) * self.size)
    }

    /// Its twelve edges.
    pub fn edges(&self) -> impl Iterator<Item = Edge> + use<> {
        let cell = *self;
        let starts = (0..8).flat_map(|corner| (0..3).map(move |axis| (corner, axis)));
        starts.filter(|(corner, axis)| corner >> axis & 1 == 0).map(move |(corner, axis)| Edge {
            axis,
            start: cell.corner(corner),
            size: cell.size,
        })
    }
}

/// An edge of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    pub axis: usize,
    /// Its lower end.
    pub start: Index,
    pub size: u32,
}

impl Edge {
    pub fn end(&self) -> Index {
        self.at(self.size)
    }

    /// Its middle, which tells it from all other edges: the middle of another one has its lowest bits elsewhere.
    pub fn middle(&self) -> Index {
        self.at(self.size / 2)
    }

    /// Its two halves.
    pub fn halves(&self) -> [Edge; 2] {
        let size = self.size / 2;
        [Edge { size, ..*self }, Edge { size, start: self.middle(), ..*self }]
    }

    fn at(&self, offset: u32) -> Index {
        let mut index = self.start;
        index[self.axis] += offset;
        index
    }
}

/// The cells, of which the first is the whole.
#[derive(Debug)]
pub struct Octree {
    origin: Vec3,
    /// The length of a unit.
    unit: f64,
    pub cells: Vec<Cell>,
}

impl Octree {
    /// A whole cell around a box.
    pub fn around(bounds: &Aabb) -> Octree {
        let side = (bounds.max - bounds.min).max_element() * ROOM;
        let origin = bounds.min - Vec3::from_array(MARGIN) * side;
        let whole = Cell { low: [0; 3], size: WHOLE, parts: 0 };
        Octree { origin, unit: side / f64::from(WHOLE), cells: vec![whole] }
    }

    /// The length of so many units.
    pub fn length(&self, units: u32) -> f64 {
        f64::from(units) * self.unit
    }

    pub fn position(&self, index: Index) -> Vec3 {
        self.origin + Vec3::from_array(index.map(f64::from)) * self.unit
    }

    /// Divides a whole cell into eight.
    pub fn divide(&mut self, cell: u32) {
        let parts = self.cells.len() as u32;
        let whole = &mut self.cells[cell as usize];
        whole.parts = parts;
        let (cell, size) = (*whole, whole.size / 2);
        let part =
            |number: usize| std::array::from_fn(|axis| cell.low[axis] + (number >> axis & 1) as u32 * size);
        self.cells.extend((0..8).map(|number| Cell { low: part(number), size, parts: 0 }));
    }

    /// The whole cell that contains the unit whose lowest corner is given.
    pub fn cell_at(&self, index: Index) -> u32 {
        let mut number = 0;
        loop {
            let cell = &self.cells[number as usize];
            if cell.is_whole() {
                return number;
            }
            let half = cell.size / 2;
            let upper = |axis: usize| u32::from(index[axis] - cell.low[axis] >= half) << axis;
            number = cell.parts + upper(0) + upper(1) + upper(2);
        }
    }

    /// The whole cell that contains a position.
    pub fn cell_of(&self, position: Vec3) -> u32 {
        let units = ((position - self.origin) / self.unit).to_array();
        self.cell_at(units.map(|unit| (unit.max(0.0) as u32).min(WHOLE - 1)))
    }

    /// The whole cells around an edge that no cell divides, counter-clockwise seen against its axis; one that is on two sides of
    /// it stands twice.
    pub fn around_edge(&self, edge: &Edge) -> [u32; 4] {
        let (b, c) = ((edge.axis + 1) % 3, (edge.axis + 2) % 3);
        [(1, 1), (0, 1), (0, 0), (1, 0)].map(|(back_b, back_c)| {
            let mut index = edge.start;
            // The octree reaches beyond the surface, so there is a unit before.
            index[b] -= back_b;
            index[c] -= back_c;
            self.cell_at(index)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn divided() -> Octree {
        let mut octree = Octree::around(&Aabb::new(Vec3::ZERO, Vec3::ONE));
        octree.divide(0);
        octree.divide(8);
        octree.divide(16);
        octree
    }

    #[test]
    fn cells_contain_their_corners_and_middles() {
        let octree = divided();
        let whole = (0..).zip(&octree.cells).filter(|(_, cell)| cell.is_whole());
        let mut volume = 0.0;
        for (number, cell) in whole {
            volume += f64::from(cell.size).powi(3);
            assert_eq!(octree.cell_at(cell.low), number);
            assert_eq!(octree.cell_at(cell.corner(7).map(|i| i - 1)), number);
            assert_eq!(octree.cell_of(octree.position(cell.low.map(|i| i + cell.size / 2))), number);
        }
        assert_eq!(volume, f64::from(WHOLE).powi(3));
    }

    /// Each edge has another middle, and the middle of an edge that is halved is the end of its halves.
    #[test]
    fn edges_have_keys_of_their_own() {
        let octree = divided();
        let edges: Vec<Edge> = octree.cells.iter().flat_map(Cell::edges).collect();
        for one in &edges {
            for other in &edges {
                assert_eq!(key(one.middle()) == key(other.middle()), one == other);
            }
            let [first, second] = one.halves();
            assert_eq!((first.start, first.end(), second.end()), (one.start, second.start, one.end()));
        }
    }
}
