//! The winding numbers of a mesh in the cells of a grid that no face meets: most points are in such a cell, so whether
//! the mesh contains them needs no line.
//!
//! Cells are padded: an empty cell has no face within [`PAD`] of it either. That is more than all rounding, both that of
//! the cells that a face meets and that of the cell that holds a point. So the point is farther from every hit of its
//! line than the rounding of any `t`, and the hits that the plain path finds ahead are those that are truly ahead of the
//! point. For a closed mesh their sum does not depend on the direction of the line, since each hit is decided exactly and
//! ties are broken as if the line were moved a little (`sheared_ray`): it is the winding number at the point, which is
//! off the surface. All points of connected empty cells have the same.

use super::mesh_line::{PowerOfTwoScale, Triangle};
use super::triangles::Triangles;
use crate::aabb::Aabb;
use crate::math::Vec3;

/// The padding, in cells.
const PAD: f64 = 1.0 / 256.0;

/// The largest number of cells along the mesh.
const FINEST: f64 = 128.0;
/// The smallest number of cells along the mesh, unless finer cells are too expensive.
const COARSEST: f64 = 16.0;

/// Cells must be larger than this fraction of the coordinates, which are up to 1 after scaling. So the corner of the
/// grid is rounded by less than a thousandth of a cell.
const SMALLEST_CELL: f64 = f64::from_bits((1023 - 40) << 52);

/// Meshes with smaller coordinates, other than zero, have no cells: exact signs may underflow, and the hits of a line
/// need not balance.
const SMALLEST_COORDINATE: f64 = 1e-100;

/// A cell that a face meets, or whose winding number is unknown.
const UNKNOWN: i8 = i8::MAX;
/// An empty cell that has not been visited.
const UNVISITED: i8 = i8::MIN;

/// The largest number of connected sets of empty cells that are examined, each by a line.
const MAX_REGIONS: usize = 4096;

/// The winding numbers in the cells of a grid around a closed mesh.
#[derive(Debug)]
pub(super) struct EmptyCells {
    grid: Grid,
    size: PowerOfTwoScale,
    /// By cell: the winding number, or [`UNKNOWN`].
    winding: Vec<i8>,
}

/// Cubic cells over the box of a mesh after scaling, with one more cell on each side.
#[derive(Clone, Copy, Debug)]
struct Grid {
    low: Vec3,
    /// Cells per unit of length.
    per_unit: f64,
    counts: [usize; 3],
}

impl Grid {
    /// A grid with so many cells along the longest side of a box; `None` if its cells are too small for their place.
    fn over(bounds: &Aabb, along: f64) -> Option<Grid> {
        let extent = bounds.size().max_element();
        let cell = extent / along;
        let is_valid = cell > SMALLEST_CELL * bounds.min.abs().max(bounds.max.abs()).max_element();
        let counts = (bounds.size() / cell).to_array().map(|count| count as usize + 3);
        let grid = Grid { low: bounds.min - cell, per_unit: along / extent, counts };
        (is_valid && cell > SMALLEST_COORDINATE).then_some(grid)
    }

    fn len(&self) -> usize {
        self.counts.iter().product()
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.counts[1] + j) * self.counts[0] + i
    }

    fn cell(&self, index: usize) -> [usize; 3] {
        let row = index / self.counts[0];
        [index % self.counts[0], row % self.counts[1], row / self.counts[1]]
    }

    /// The cell that holds a point, in cells from the corner; `None` if the point is outside of the grid.
    fn cell_at(&self, p: Vec3) -> Option<usize> {
        let counts = Vec3::from(self.counts.map(|count| count as f64));
        let is_in_grid = p.cmpge(Vec3::ZERO).all() && p.cmplt(counts).all();
        is_in_grid.then(|| self.index(p.to_array().map(|x| x as usize)))
    }

    fn centre(&self, index: usize) -> Vec3 {
        self.low + Vec3::from(self.cell(index).map(|i| i as f64 + 0.5)) / self.per_unit
    }

    /// The cells next to a cell.
    fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> {
        let (cell, counts) = (self.cell(index), self.counts);
        let strides = [1, counts[0], counts[0] * counts[1]];
        (0..3).flat_map(move |axis| {
            let before = (cell[axis] > 0).then(|| index - strides[axis]);
            let after = (cell[axis] + 1 < counts[axis]).then(|| index + strides[axis]);
            before.into_iter().chain(after)
        })
    }
}

/// The cells between two coordinates, in cells, with the padding.
fn between(low: f64, high: f64, count: usize) -> std::ops::Range<usize> {
    let last = count as f64 - 1.0;
    (low - PAD).clamp(0.0, last) as usize..(high + PAD).clamp(0.0, last) as usize + 1
}

/// Marks the cells of a grid that a face may meet. Returns how many cells and columns were visited.
fn mark(grid: &Grid, triangle: &Triangle, cells: &mut [i8]) -> usize {
    let corners = triangle.corners.map(|corner| (corner - grid.low) * grid.per_unit);
    let (low, high) =
        (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
    let range = |axis: usize| between(low[axis], high[axis], grid.counts[axis]);
    let (u, v) = (corners[1] - corners[0], corners[2] - corners[0]);
    let normal = u.cross(v);
    let size = normal.abs();
    let along = if size.z >= size.x && size.z >= size.y { 2 } else { usize::from(size.y >= size.x) };
    let across = [(along + 1) % 3, (along + 2) % 3];
    // The corners are rounded by less than 1e-13 cells. So the normal is off by less than 1e-10 times these products,
    // slopes by less than 1e-6, and depths, over the whole grid, by less than the padding.
    let (of_u, of_v) = (u.abs().max_element(), v.abs().max_element());
    let has_plane = of_u * of_v + of_u + of_v < 1e3 * size[along];
    let slope = across.map(|axis| -normal[axis] / normal[along]);
    let spread = (slope[0].abs() + slope[1].abs()) * (0.5 + PAD) + PAD;
    let mut visited = 0;
    for i in range(across[0]) {
        for j in range(across[1]) {
            let mut column = range(along);
            if has_plane {
                let depth = corners[0][along]
                    + (i as f64 + 0.5 - corners[0][across[0]]) * slope[0]
                    + (j as f64 + 0.5 - corners[0][across[1]]) * slope[1];
                let in_plane = between(depth - spread, depth + spread, grid.counts[along]);
                column = column.start.max(in_plane.start)..column.end.min(in_plane.end);
            }
            visited += 1 + column.len();
            for k in column {
                let mut cell = [0; 3];
                (cell[across[0]], cell[across[1]], cell[along]) = (i, j, k);
                cells[grid.index(cell)] = UNKNOWN;
            }
        }
    }
    visited
}

impl EmptyCells {
    /// Bytes used.
    pub(super) fn memory(&self) -> usize {
        size_of_val(self.winding.as_slice())
    }

    /// Finds the empty cells of a closed mesh, given its scaled triangles and their box. `winding` returns the winding
    /// number at a point before scaling. Returns `None` if the coordinates do not allow a grid.
    pub(super) fn of(
        triangles: &Triangles,
        size: PowerOfTwoScale,
        bounds: &Aabb,
        winding: impl Fn(Vec3) -> Option<i32>,
    ) -> Option<EmptyCells> {
        let is_small = |x: &f64| *x != 0.0 && x.abs() < SMALLEST_COORDINATE;
        if triangles.iter().flat_map(|t| t.corners).any(|v| v.to_array().iter().any(is_small)) {
            return None;
        }
        let (grid, cells) = marked(triangles, bounds)?;
        let winding = flooded(&grid, cells, |p| winding(size.unscale(p)));
        Some(EmptyCells { grid, size, winding })
    }

    /// The winding number at a point in the box of the mesh; `None` if the point is not in an empty cell, or has
    /// coordinates so small that exact signs may underflow.
    pub(super) fn winding_at(&self, p: Vec3) -> Option<i32> {
        let scaled = self.size.scale(p);
        let is_small = |(scaled, x): (f64, f64)| x != 0.0 && scaled.abs() < SMALLEST_COORDINATE;
        if scaled.to_array().into_iter().zip(p.to_array()).any(is_small) {
            return None;
        }
        let cell = self.grid.cell_at((scaled - self.grid.low) * self.grid.per_unit)?;
        Some(i32::from(self.winding[cell])).filter(|_| self.winding[cell] != UNKNOWN)
    }
}

/// A grid, with the cells that triangles may meet. The grid is coarser where triangles cross very many cells.
fn marked(triangles: &Triangles, bounds: &Aabb) -> Option<(Grid, Vec<i8>)> {
    let limit = (1 << 20) + 16 * triangles.len();
    let mut along = ((triangles.len() as f64).sqrt() / 8.0).round().clamp(COARSEST, FINEST);
    loop {
        let grid = Grid::over(bounds, along)?;
        let mut cells = vec![UNVISITED; grid.len()];
        let mut visited = 0;
        for triangle in triangles.iter() {
            visited += mark(&grid, &triangle, &mut cells);
            if visited > limit {
                break;
            }
        }
        if visited <= limit || along <= 1.0 {
            return Some((grid, cells));
        }
        along = (along / 2.0).floor();
    }
}

/// Computes the winding numbers of the empty cells: one for each connected set of them, since no face is between two
/// that are next to each other.
fn flooded(grid: &Grid, mut cells: Vec<i8>, winding: impl Fn(Vec3) -> Option<i32>) -> Vec<i8> {
    let mut open = Vec::new();
    let mut regions = 0;
    for first in 0..cells.len() {
        if cells[first] != UNVISITED {
            continue;
        }
        regions += 1;
        let known = if regions <= MAX_REGIONS { winding(grid.centre(first)) } else { None };
        let value = known.and_then(|w| i8::try_from(w).ok()).filter(|w| *w != UNVISITED).unwrap_or(UNKNOWN);
        cells[first] = value;
        open.push(first);
        while let Some(cell) = open.pop() {
            for next in grid.neighbours(cell) {
                if cells[next] == UNVISITED {
                    cells[next] = value;
                    open.push(next);
                }
            }
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::Affine;
    use crate::ray::{Line, Span};
    use crate::scratch::Scratch;
    use crate::solid::Solid;
    use crate::solid::mesh::shapes::{ball, cubes, ring};
    use crate::solid::mesh::winding::total;
    use crate::solid::mesh::{MeshSolid, TriangleMesh};
    use crate::testkit::random::Random;

    fn solid(mesh: TriangleMesh) -> MeshSolid {
        let solid = MeshSolid::new(Arc::new(mesh), "bvh").unwrap();
        solid.make_cells();
        solid
    }

    fn cells(solid: &MeshSolid) -> Option<&EmptyCells> {
        solid.empty_cells.get()?.as_ref()
    }

    /// The winding number by a line in any direction.
    fn by_a_line(solid: &MeshSolid, p: Vec3, random: &mut Random) -> i32 {
        let mut hits = Vec::new();
        let line = Line::exact(p, random.direction());
        solid.hits(&line, Span::FORWARD, &mut hits, &mut Scratch::default());
        -total(&hits)
    }

    /// Compares winding numbers of cells with those by lines. Returns the share of points that are in empty cells.
    fn compare(solid: &MeshSolid, random: &mut Random) -> f64 {
        let (cells, bounds) = (cells(solid).unwrap(), solid.bounds());
        let mut known = 0;
        for _ in 0..2_000 {
            let share =
                Vec3::new(random.number(-0.2, 1.2), random.number(-0.2, 1.2), random.number(-0.2, 1.2));
            let p = bounds.min + bounds.size() * share;
            if let Some(winding) = cells.winding_at(p) {
                assert_eq!(winding, by_a_line(solid, p, random), "{p}");
                known += 1;
            }
        }
        f64::from(known) / 2_000.0
    }

    #[test]
    fn cells_have_the_winding_numbers_of_lines() {
        let mut random = Random::new(11);
        let turn = Affine::rotation_xyz(Vec3::new(10.0, 20.0, 30.0));
        let inner = ball(3).moved(&Affine::scaling(Vec3::splat(0.5)));
        let overlapping = ball(3).moved(&Affine::translation(Vec3::new(0.7, 0.1, 0.2)));
        for mesh in [
            ball(1),
            ball(4),
            ring(40, 30),
            cubes(&[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 2]]),
            ball(3).with(&inner),
            ball(3).with(&inner.clone().inside_out()),
            ball(3).with(&overlapping).with(&inner),
            ball(4).inside_out(),
        ] {
            for affine in [Affine::IDENTITY, turn] {
                for scale in [1.0, 1e-200, 1e200] {
                    let placed = mesh.clone().moved(&affine).moved(&Affine::scaling(Vec3::splat(scale)));
                    let known = compare(&solid(placed), &mut random);
                    assert!(known > 0.3, "{known}");
                }
            }
        }
        // Far from the origin, and as thin as a cell.
        compare(&solid(ball(3).moved(&Affine::translation(Vec3::new(1e7, 0.0, -3e7)))), &mut random);
        compare(&solid(ball(3).moved(&Affine::scaling(Vec3::new(1.0, 1.0, 1e-9)))), &mut random);
    }

    /// Large faces from both sides, which enclose nothing. So many of them would be marked in too many small cells.
    #[test]
    fn cells_are_coarser_where_faces_cross_very_many() {
        let mut random = Random::new(12);
        let mut mesh = TriangleMesh::default();
        for i in 0..6_000 {
            mesh.vertices.extend([(); 3].map(|()| random.point(-1.0, 1.0)));
            let [a, b, c] = [3 * i, 3 * i + 1, 3 * i + 2];
            mesh.faces.extend([[a, b, c], [a, c, b]]);
        }
        let solid = solid(mesh);
        let counts = cells(&solid).unwrap().grid.counts;
        assert!(counts.iter().all(|count| *count < COARSEST as usize), "{counts:?}");
        compare(&solid, &mut random);
    }

    #[test]
    fn meshes_whose_coordinates_may_underflow_have_no_cells() {
        let mut mesh = ball(2);
        mesh.vertices[0].x = 1e-150;
        assert!(cells(&solid(mesh)).is_none());
        let far = ball(2).moved(&Affine::translation(Vec3::splat(1e14)));
        assert!(cells(&solid(far)).is_none());
    }
}
