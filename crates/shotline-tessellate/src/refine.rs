//! Refines the cells of an octree until the mesh of a surface is within the tolerance.

use std::collections::BTreeMap;

use shotline::aabb::Aabb;
use shotline::math::Vec3;
use shotline::query::batch::BatchError;
use shotline::solid::mesh::TriangleMesh;

use crate::contour::{Contour, contour};
use crate::deviation::{self, Distances};
use crate::octree::{Cell, Octree};
use crate::samples::Samples;
use crate::shared_edges::with_two_triangles_an_edge;
use crate::surface::Surface;
use crate::surface_points::last_points;

/// How often the whole octree is divided before the first mesh.
const FIRST_LEVELS: usize = 3;

/// The part of the tolerance that measured distances may take: the distance is measured at points, and rises a little between them.
const SAFE: f64 = 0.9;

/// How many steps lead from a point of the surface to the mesh, where cells between them are looked for.
const STEPS_TO_MESH: u32 = 8;

/// The least size of a cell, in units of the octree.
const LEAST_SIZE: u32 = 4;

/// The most cells.
const MOST_CELLS: usize = 1 << 21;

/// A mesh within the tolerance.
#[derive(Debug, Default)]
pub struct Refined {
    pub mesh: TriangleMesh,
    /// The greatest distance between the mesh and the surface that was found.
    pub deviation: f64,
}

/// Where refining ended without a mesh within the tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Farthest {
    /// The greatest distance that was found, and where.
    pub distance: f64,
    pub place: Vec3,
}

/// Why there is no mesh.
#[derive(Debug)]
pub enum RefineError {
    /// The cells would be too many or too small.
    TooFine(Farthest),
    Batch(BatchError),
}

impl From<BatchError> for RefineError {
    fn from(error: BatchError) -> RefineError {
        RefineError::Batch(error)
    }
}

/// How far the work is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// The cells so far.
    pub cells: usize,
    /// The triangles of the mesh so far.
    pub triangles: usize,
    /// The distance of the mesh so far from the surface.
    pub deviation: f64,
}

/// The mesh of a surface within bounds, which is near all points of the surface that are given. It is empty if the object is.
pub fn refine(
    surface: &Surface,
    bounds: &Aabb,
    points: Vec<Vec3>,
    tolerance: f64,
    report: &mut dyn FnMut(State),
) -> Result<Refined, RefineError> {
    let mut work = Work::new(surface, bounds, points, tolerance)?;
    loop {
        let contour = contour(&work.octree, &work.samples);
        // Measured as it will be: flat pieces that are left out may be all there is of something thin.
        let mesh = with_two_triangles_an_edge(mesh(&contour));
        let far = work.far_cells(&contour, &mesh)?;
        report(State {
            cells: work.octree.cells.len(),
            triangles: mesh.faces.len(),
            deviation: far.farthest.distance,
        });
        if !far.cells.is_empty() {
            work.divide(&far)?;
        } else if !work.examines_all {
            work.examine_all();
        } else {
            return Ok(Refined { mesh, deviation: far.farthest.distance });
        }
    }
}

fn mesh(contour: &Contour) -> TriangleMesh {
    let faces = contour.polygons.iter().flat_map(|polygon| polygon.triangles().collect::<Vec<_>>()).collect();
    TriangleMesh::new(contour.vertices.clone(), faces)
}

/// The octree and what is known of the surface.
struct Work<'w> {
    surface: &'w Surface<'w>,
    octree: Octree,
    samples: Samples,
    distances: Distances,
    tolerance: f64,
    /// Which points of the surface are examined next: those that were far from the last mesh, and new ones.
    points: Vec<u32>,
    /// Whether these are all, as in the end.
    examines_all: bool,
    /// Points that are examined only then.
    last_points: Vec<Vec3>,
}

/// Cells in which the mesh is too far from the surface.
struct FarCells {
    /// With the greatest distance found in each.
    cells: BTreeMap<u32, f64>,
    farthest: Farthest,
}

impl FarCells {
    fn note(&mut self, distance: f64, place: Vec3) {
        if distance > self.farthest.distance {
            self.farthest = Farthest { distance, place };
        }
    }

    /// About how many more cells are needed. The distance of a mesh from a smooth surface falls with the square of the size of its cells,
    /// and each division of those that the surface passes through makes four of them. At edges and corners of the surface it is
    /// less, so this is to be believed only when most of the work is elsewhere; but then a tolerance that is out of reach is
    /// known long before.
    fn needed(&self, tolerance: f64) -> f64 {
        let of_cell = |distance: &f64| {
            let levels = (distance / tolerance).log(4.0).ceil().max(1.0);
            8.0 * (4.0_f64.powf(levels) - 1.0) / 3.0
        };
        self.cells.values().map(of_cell).sum()
    }

    fn add(&mut self, cell: u32, distance: f64) {
        let greatest = self.cells.entry(cell).or_default();
        *greatest = greatest.max(distance);
    }
}

impl<'w> Work<'w> {
    fn new(
        surface: &'w Surface<'w>,
        bounds: &Aabb,
        points: Vec<Vec3>,
        tolerance: f64,
    ) -> Result<Work<'w>, BatchError> {
        let mut work = Work {
            surface,
            octree: Octree::around(bounds),
            samples: Samples::with_points(points),
            distances: Distances::default(),
            tolerance: SAFE * tolerance,
            points: Vec::new(),
            examines_all: false,
            last_points: last_points(bounds, tolerance, surface)?,
        };
        for _ in 0..FIRST_LEVELS {
            let whole: Vec<u32> =
                (0..).zip(&work.octree.cells).filter(|(_, c)| c.is_whole()).map(|(i, _)| i).collect();
            whole.into_iter().for_each(|cell| work.octree.divide(cell));
        }
        let cells: Vec<_> = work.octree.cells.iter().filter(|cell| cell.is_whole()).copied().collect();
        work.samples.add(&work.octree, &cells, surface)?;
        work.points = work.all_points();
        Ok(work)
    }

    fn all_points(&self) -> Vec<u32> {
        (0..self.samples.points.len() as u32).collect()
    }

    /// Examines all points next.
    fn examine_all(&mut self) {
        self.samples.points.append(&mut self.last_points);
        self.points = self.all_points();
        self.examines_all = true;
    }

    /// Cells around polygons that are too far from the surface, and cells with points of the surface that are too far from the mesh.
    fn far_cells(&mut self, contour: &Contour, mesh: &TriangleMesh) -> Result<FarCells, BatchError> {
        let mut far =
            FarCells { cells: BTreeMap::new(), farthest: Farthest { distance: 0.0, place: Vec3::ZERO } };
        let of_polygons = self.distances.of_polygons(&self.octree, contour, self.surface, self.tolerance)?;
        for (polygon, distance) in contour.polygons.iter().zip(of_polygons) {
            far.note(distance, polygon.around.crossing.position);
            if distance > self.tolerance {
                polygon.largest_cells(&self.octree).1.for_each(|cell| far.add(cell, distance));
            }
        }
        for cell in &contour.ends {
            let Cell { low, size, .. } = self.octree.cells[*cell as usize];
            let size = self.octree.length(size);
            if size > self.tolerance {
                far.note(size, self.octree.position(low));
                far.add(*cell, size);
            }
        }
        let points: Vec<Vec3> =
            self.points.iter().map(|point| self.samples.points[*point as usize]).collect();
        let nearest = deviation::nearest_points(mesh, &points, self.surface.run)?;
        let mut is_far = nearest.iter().map(|near| self.is_far(near)).collect::<Vec<bool>>().into_iter();
        self.points.retain(|_| is_far.next() == Some(true));
        for (point, near) in points.into_iter().zip(nearest) {
            self.add_far_point(point, near, &mut far);
        }
        Ok(far)
    }

    fn is_far(&self, near: &Option<(Vec3, f64)>) -> bool {
        near.is_none_or(|(_, distance)| distance > self.tolerance)
    }

    /// Notes a point of the surface and the point of the mesh that is nearest to it; if they are far from each other, also the cells
    /// in which the mesh is to become better.
    fn add_far_point(&self, point: Vec3, near: Option<(Vec3, f64)>, far: &mut FarCells) {
        let whole = self.octree.length(self.octree.cells[0].size);
        far.note(near.map_or(whole, |(_, distance)| distance), point);
        if !self.is_far(&near) {
            return;
        }
        let size = |cell: u32| self.octree.length(self.octree.cells[cell as usize].size);
        let cell = self.octree.cell_of(point);
        let of_point = size(cell);
        far.add(cell, near.map_or(of_point, |(_, distance)| distance.min(of_point)));
        // Something thin may lead from the mesh to the point, and be missed between larger cells.
        let Some((end, distance)) = near.filter(|(_, distance)| *distance > of_point) else { return };
        for step in 1..STEPS_TO_MESH {
            let between = point.lerp(end, f64::from(step) / f64::from(STEPS_TO_MESH));
            let cell = self.octree.cell_of(between);
            if size(cell) > of_point {
                far.add(cell, distance.min(size(cell)));
            }
        }
    }

    /// Divides cells, unless they are too small, or too many cells would be needed.
    fn divide(&mut self, far: &FarCells) -> Result<(), RefineError> {
        let is_too_small = |cell: &u32| self.octree.cells[*cell as usize].size <= LEAST_SIZE;
        let cells = self.octree.cells.len();
        let needed = far.needed(self.tolerance);
        let is_sure = cells > MOST_CELLS / 64 || needed > (16 * MOST_CELLS) as f64;
        if cells as f64 + needed > MOST_CELLS as f64 && is_sure || far.cells.keys().any(is_too_small) {
            return Err(RefineError::TooFine(far.farthest));
        }
        far.cells.keys().for_each(|cell| self.octree.divide(*cell));
        let parts = self.octree.cells[cells..].to_vec();
        let known = self.samples.points.len() as u32;
        self.samples.add(&self.octree, &parts, self.surface)?;
        self.points.extend(known..self.samples.points.len() as u32);
        self.examines_all = false;
        Ok(())
    }
}
