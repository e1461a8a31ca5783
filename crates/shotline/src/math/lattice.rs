//! Lattices: cells at equal distances, numbered by arithmetic, so that a billion of them need no memory.
//!
//! Cells lie in rows along x. Rows lie side by side along y and form a layer; layers lie along z. So a cell has three
//! indices, and a coordinate of its place depends on as few of them as possible.

use super::Vec3;

/// The largest number of cells of a lattice.
pub const MAX_CELLS: u64 = 1 << 31;

/// Where the cells of a lattice are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lattice {
    /// Rows of equal length. Cell `[i, j, k]` is shifted by `i`, `j` and `k` times the pitch along x, y and z.
    Rectangular {
        /// The numbers of cells along x, y and z.
        counts: [u32; 3],
        /// The distances between neighbours along x, y and z.
        pitch: [f64; 3],
        /// Whether every second row is shifted by half a pitch along x. Where the pitch along y is the root of 3/4 times
        /// that along x, each cell of a layer is then as far from its six neighbours.
        stagger: bool,
    },
    /// Rings of hexagonal cells around the z axis: the first ring is one cell at the origin, each further ring surrounds
    /// those before. Rows are those of the hexagon from its lowest y upwards.
    Hexagonal {
        /// The number of rings, with the cell in the middle.
        rings: u32,
        /// The distance between neighbours in a layer.
        pitch: f64,
        /// The number of layers.
        layers: u32,
        /// The distance between layers.
        height: f64,
    },
}

/// A row of cells in a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The number of its first cell, of those of the layer.
    pub first: u32,
    /// The number of its cells.
    pub count: u32,
    /// The x of its first cell, in pitches: a multiple of 1/2.
    start: f64,
    pitch: f64,
}

impl Row {
    /// The x of a cell of the row.
    #[inline]
    pub fn x(&self, i: u32) -> f64 {
        (f64::from(i) + self.start) * self.pitch
    }
}

impl Lattice {
    /// A rectangular lattice.
    pub fn rectangular(counts: [u32; 3], pitch: [f64; 3]) -> Lattice {
        Lattice::Rectangular { counts, pitch, stagger: false }
    }

    /// Why it is not a lattice: the name of a parameter, and what it must be.
    pub fn fault(&self) -> Option<(&'static str, String)> {
        // The numbers of cells, each with the distance between them.
        let axes = match *self {
            Lattice::Rectangular { counts, pitch, .. } => {
                [0, 1, 2].map(|axis| ("counts", counts[axis], "pitch", pitch[axis]))
            }
            Lattice::Hexagonal { rings, pitch, layers, height } => {
                let in_layer = ("rings", rings, "pitch", pitch);
                [in_layer, in_layer, ("layers", layers, "height", height)]
            }
        };
        if let Some((name, ..)) = axes.iter().find(|(_, count, ..)| *count == 0) {
            return Some((name, "must be at least 1".into()));
        }
        // One cell alone has no neighbour.
        let is_wrong = |count: u32, pitch: f64| {
            !pitch.is_finite() || (count > 1 && !(pitch > 0.0 && (pitch * f64::from(count)).is_finite()))
        };
        if let Some((_, _, name, _)) = axes.iter().find(|(_, count, _, pitch)| is_wrong(*count, *pitch)) {
            let must = "must be positive where there is more than one cell, and the last cell must be at a finite distance";
            return Some((name, must.into()));
        }
        let too_many = axes.iter().any(|(_, count, ..)| u64::from(*count) > MAX_CELLS)
            || self.layer_size() > MAX_CELLS
            || self.cell_count() > MAX_CELLS;
        too_many.then(|| (axes[0].0, format!("must give at most {MAX_CELLS} cells")))
    }

    /// The number of cells.
    pub fn cell_count(&self) -> u64 {
        self.layer_size().saturating_mul(u64::from(self.layers()))
    }

    /// The number of cells of a layer.
    fn layer_size(&self) -> u64 {
        match *self {
            Lattice::Rectangular { counts: [x, y, _], .. } => u64::from(x) * u64::from(y),
            Lattice::Hexagonal { rings, .. } => {
                let rings = u64::from(rings);
                (3 * rings).saturating_mul(rings.saturating_sub(1)).saturating_add(1)
            }
        }
    }

    /// The number of layers.
    pub fn layers(&self) -> u32 {
        match *self {
            Lattice::Rectangular { counts, .. } => counts[2],
            Lattice::Hexagonal { layers, .. } => layers,
        }
    }

    /// The number of rows of a layer.
    pub fn rows(&self) -> u32 {
        match *self {
            Lattice::Rectangular { counts, .. } => counts[1],
            Lattice::Hexagonal { rings, .. } => 2 * rings - 1,
        }
    }

    /// The number of cells of the longest row.
    pub fn width(&self) -> u32 {
        match *self {
            Lattice::Rectangular { counts, .. } => counts[0],
            Lattice::Hexagonal { rings, .. } => 2 * rings - 1,
        }
    }

    /// A row of each layer.
    #[inline]
    pub fn row(&self, j: u32) -> Row {
        match *self {
            Lattice::Rectangular { counts, pitch, stagger } => {
                let start = if stagger && j % 2 == 1 { 0.5 } else { 0.0 };
                Row { first: j * counts[0], count: counts[0], start, pitch: pitch[0] }
            }
            Lattice::Hexagonal { rings, pitch, .. } => {
                let count = rings + j.min(2 * rings - 2 - j);
                Row { first: hexagon_cells(rings, j), count, start: -0.5 * f64::from(count - 1), pitch }
            }
        }
    }

    /// The y of a row.
    #[inline]
    pub fn y(&self, j: u32) -> f64 {
        match *self {
            Lattice::Rectangular { pitch, .. } => f64::from(j) * pitch[1],
            Lattice::Hexagonal { rings, pitch, .. } => {
                (f64::from(j) - f64::from(rings - 1)) * (pitch * ROOT_OF_3_4)
            }
        }
    }

    /// The z of a layer.
    #[inline]
    pub fn z(&self, k: u32) -> f64 {
        match *self {
            Lattice::Rectangular { pitch, .. } => f64::from(k) * pitch[2],
            Lattice::Hexagonal { height, .. } => f64::from(k) * height,
        }
    }

    /// By how much a cell is shifted.
    #[inline]
    pub fn offset(&self, [i, j, k]: [u32; 3]) -> Vec3 {
        Vec3::new(self.row(j).x(i), self.y(j), self.z(k))
    }

    /// The number of a cell: x runs fastest, then y, then z.
    #[inline]
    pub fn number(&self, [i, j, k]: [u32; 3]) -> u32 {
        k * self.layer_size() as u32 + self.row(j).first + i
    }

    /// The indices of a cell in its row, of the row in its layer, and of the layer.
    #[inline]
    pub fn indices(&self, number: u32) -> [u32; 3] {
        let layer = self.layer_size() as u32;
        let (k, rest) = (number / layer, number % layer);
        let j = match *self {
            Lattice::Rectangular { counts, .. } => rest / counts[0],
            Lattice::Hexagonal { .. } => {
                let (mut low, mut high) = (0, self.rows());
                while high - low > 1 {
                    let middle = low + (high - low) / 2;
                    if self.row(middle).first <= rest { low = middle } else { high = middle }
                }
                low
            }
        };
        [rest - self.row(j).first, j, k]
    }

    /// A cell as it is called: its indices along the axes with several cells, as in `3,4`.
    pub fn cell_name(&self, number: u32) -> String {
        let indices = self.indices(number);
        let counts = [self.width(), self.rows(), self.layers()];
        let named = (0..3).filter(|&axis| counts[axis] > 1).map(|axis| indices[axis].to_string());
        let named: Vec<String> = named.collect();
        if named.is_empty() { "0".into() } else { named.join(",") }
    }
}

/// The height of a triangle with sides of length 1, half of the root of 3.
const ROOT_OF_3_4: f64 = 0.866_025_403_784_438_6;

/// The number of cells in the first `j` rows of a hexagon.
#[inline]
fn hexagon_cells(rings: u32, j: u32) -> u32 {
    // Up to the middle, rows have `rings`, `rings + 1`, ... cells; above it the same in reverse.
    let below = |j: u64| (j * u64::from(rings) + j * j.saturating_sub(1) / 2) as u32;
    if j < rings {
        below(u64::from(j))
    } else {
        let all = 3 * u64::from(rings) * u64::from(rings - 1) + 1;
        all as u32 - below(u64::from(2 * rings - 1 - j))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some() -> Vec<Lattice> {
        let hexagonal = |rings, layers| Lattice::Hexagonal { rings, pitch: 1.5, layers, height: 4.0 };
        vec![
            Lattice::rectangular([3, 4, 5], [1.0, 2.0, 0.1]),
            Lattice::rectangular([1, 1, 1], [0.0; 3]),
            Lattice::Rectangular { counts: [4, 3, 2], pitch: [1.0, 0.9, 2.0], stagger: true },
            hexagonal(1, 1),
            hexagonal(2, 1),
            hexagonal(5, 3),
        ]
    }

    #[test]
    fn cells_are_numbered_row_by_row_and_layer_by_layer() {
        for lattice in some() {
            let mut next = 0;
            for k in 0..lattice.layers() {
                for j in 0..lattice.rows() {
                    for i in 0..lattice.row(j).count {
                        assert_eq!(lattice.number([i, j, k]), next, "{lattice:?}");
                        assert_eq!(lattice.indices(next), [i, j, k], "{lattice:?}");
                        next += 1;
                    }
                }
            }
            assert_eq!(u64::from(next), lattice.cell_count(), "{lattice:?}");
            assert_eq!(lattice.fault(), None);
        }
    }

    #[test]
    fn cells_of_a_hexagon_have_neighbours_at_the_pitch() {
        let lattice = Lattice::Hexagonal { rings: 4, pitch: 1.5, layers: 1, height: 0.0 };
        let all: Vec<Vec3> =
            (0..lattice.cell_count() as u32).map(|n| lattice.offset(lattice.indices(n))).collect();
        assert_eq!(all.len(), 37);
        assert_eq!(all[18], Vec3::ZERO);
        let near = |a: &Vec3| all.iter().filter(|b| ((*a - **b).length() - 1.5).abs() < 1e-12).count();
        let neighbours: Vec<usize> = all.iter().map(near).collect();
        assert_eq!(neighbours.iter().filter(|&&n| n == 6).count(), 19);
        assert_eq!(neighbours.iter().filter(|&&n| n == 3).count(), 6);
        assert!(all.iter().all(|a| a.length() < 4.6));
    }

    #[test]
    fn cells_are_named_by_the_axes_with_several() {
        let name = |counts: [u32; 3], cell| Lattice::rectangular(counts, [1.0; 3]).cell_name(cell);
        assert_eq!(name([3, 4, 5], 13), "1,0,1");
        assert_eq!(name([1, 4, 1], 3), "3");
        assert_eq!(name([1, 1, 1], 0), "0");
    }

    #[test]
    fn what_is_not_a_lattice_is_told() {
        let fault = |lattice: Lattice| lattice.fault().map(|(name, _)| name);
        assert_eq!(fault(Lattice::rectangular([0, 1, 1], [1.0; 3])), Some("counts"));
        assert_eq!(fault(Lattice::rectangular([2, 1, 1], [0.0; 3])), Some("pitch"));
        assert_eq!(fault(Lattice::rectangular([2, 1, 1], [1.0, 0.0, 0.0])), None);
        assert_eq!(fault(Lattice::rectangular([2, 1, 1], [1e308, 0.0, 0.0])), Some("pitch"));
        assert_eq!(fault(Lattice::rectangular([2, 1, 1], [f64::NAN, 0.0, 0.0])), Some("pitch"));
        assert_eq!(fault(Lattice::rectangular([u32::MAX; 3], [1.0; 3])), Some("counts"));
        assert_eq!(fault(Lattice::rectangular([1 << 16, 1 << 16, 1], [1.0; 3])), Some("counts"));
        let hexagonal = |rings| Lattice::Hexagonal { rings, pitch: 1.0, layers: 1, height: 0.0 };
        assert_eq!(fault(hexagonal(0)), Some("rings"));
        assert_eq!(fault(hexagonal(1 << 31)), Some("rings"));
        assert_eq!(fault(hexagonal(26_000)), None);
    }
}
