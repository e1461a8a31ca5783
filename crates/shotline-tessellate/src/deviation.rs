//! How far a mesh is from the surface that it stands for, both ways: from points of its polygons to the surface, and from points
//! of the surface to the mesh.

use std::collections::HashMap;
use std::sync::Arc;

use shotline::accel::DEFAULT;
use shotline::math::Vec3;
use shotline::query::batch::{BatchError, Run};
use shotline::ray::Ray;
use shotline::solid::mesh::{MeshSolid, TriangleMesh};

use crate::contour::{Contour, Polygon};
use crate::octree::{Octree, key};
use crate::surface::Surface;

/// Directions of no symmetry, in which a surface is looked for where it is not along normals.
const DIRECTIONS: [[f64; 3]; 6] = [
    [0.61, 0.37, 0.7],
    [-0.72, 0.53, 0.45],
    [0.31, -0.87, 0.38],
    [0.83, 0.21, -0.52],
    [-0.18, 0.95, -0.26],
    [0.09, 0.28, 0.96],
];

/// Points of a triangle, by the weights of its corners. They are near corners and sides but not on them, where the surface may have
/// an edge that a ray along a normal grazes.
const WEIGHTS: [[f64; 3]; 7] = [
    [1.0, 1.0, 1.0],
    [30.0, 1.0, 1.0],
    [1.0, 30.0, 1.0],
    [1.0, 1.0, 30.0],
    [15.0, 15.0, 2.0],
    [2.0, 15.0, 15.0],
    [15.0, 2.0, 15.0],
];

/// A point of a polygon.
struct Probe {
    point: Vec3,
    /// How far the surface is looked for.
    reach: f64,
    /// Where it is expected: along the normal of the triangle, or that of the surface nearby, since a line along the former may
    /// graze an edge of the surface.
    normals: [Vec3; 2],
    polygon: u32,
}

/// The edge that a polygon is around, and the number of its crossing there.
type Place = (u64, usize);

/// The distances of polygons from a surface, which are kept for those that stay as they are.
#[derive(Debug, Default)]
pub struct Distances {
    /// By the crossing that a polygon is around: its corners, and its distance.
    known: HashMap<Place, ([Vec3; 6], f64)>,
}

impl Distances {
    /// The greatest distance of points of each polygon from the surface; at most twice the size of its cells. The distance
    /// along any line is at least the distance, so lines are cast until one is within the tolerance.
    pub fn of_polygons(
        &mut self,
        octree: &Octree,
        contour: &Contour,
        surface: &Surface,
        tolerance: f64,
    ) -> Result<Vec<f64>, BatchError> {
        let places: Vec<(Place, [Vec3; 6])> =
            contour.polygons.iter().map(|polygon| place(contour, polygon)).collect();
        let known = |(place, corners): &(Place, [Vec3; 6])| match self.known.get(place) {
            Some((of_corners, distance)) if of_corners == corners => Some(*distance),
            _ => None,
        };
        let found: Vec<Option<f64>> = places.iter().map(known).collect();
        let changed = (0..).zip(&contour.polygons).filter(|(polygon, _)| found[*polygon as usize].is_none());
        let probes: Vec<Probe> =
            changed.flat_map(|(number, polygon)| probes(octree, contour, number, polygon)).collect();
        let mut distances: Vec<f64> = found.into_iter().map(|known| known.unwrap_or(0.0)).collect();
        for (probe, distance) in probes.iter().zip(distances_of(&probes, surface, tolerance)?) {
            let greatest = &mut distances[probe.polygon as usize];
            *greatest = greatest.max(distance);
        }
        self.known =
            places.iter().zip(&distances).map(|((place, corners), far)| (*place, (*corners, *far))).collect();
        Ok(distances)
    }
}

/// Where a polygon is, and the corners of its triangles.
fn place(contour: &Contour, polygon: &Polygon) -> (Place, [Vec3; 6]) {
    let [first, second] = polygon.faces;
    let corner = |i: usize| contour.vertices[[first, second][i / 3][i % 3] as usize];
    ((key(polygon.around.edge.middle()), polygon.around.ordinal), std::array::from_fn(corner))
}

/// Points of a polygon. Triangles without area have none.
fn probes<'c>(
    octree: &Octree,
    contour: &'c Contour,
    number: u32,
    polygon: &'c Polygon,
) -> impl Iterator<Item = Probe> + use<'c> {
    let reach = 2.0 * octree.length(polygon.largest_cells(octree).0);
    polygon.triangles().flat_map(move |triangle| {
        let [a, b, c] = triangle.map(|vertex| contour.vertices[vertex as usize]);
        let near = triangle.map(|vertex| contour.normals[vertex as usize]);
        let normal = (b - a).cross(c - a).try_normalize();
        normal.into_iter().flat_map(move |normal| {
            WEIGHTS.map(|[u, v, w]| Probe {
                point: (a * u + b * v + c * w) / (u + v + w),
                reach,
                normals: [normal, (near[0] * u + near[1] * v + near[2] * w).normalize_or(normal)],
                polygon: number,
            })
        })
    })
}

/// The distance of each probe from the surface; at most its reach.
fn distances_of(probes: &[Probe], surface: &Surface, tolerance: f64) -> Result<Vec<f64>, BatchError> {
    let mut distances: Vec<f64> = probes.iter().map(|probe| probe.reach).collect();
    for attempt in 0..2 + DIRECTIONS.len() {
        let far: Vec<usize> = (0..probes.len()).filter(|number| distances[*number] > tolerance).collect();
        if far.is_empty() {
            break;
        }
        let along = |number: &usize| {
            let Probe { point, reach, normals, .. } = &probes[*number];
            let other = || Vec3::from_array(DIRECTIONS[attempt - 2]).normalize();
            let direction = normals.get(attempt).copied().unwrap_or_else(other) * *reach;
            Ray::new(*point - direction, direction * 2.0)
        };
        surface.cast(&far, along, |number, line| {
            let reach = probes[*number].reach;
            let found = line.crossings.iter().map(|crossing| (2.0 * crossing.t - 1.0).abs() * reach);
            distances[*number] = found.fold(distances[*number], f64::min);
        })?;
    }
    Ok(distances)
}

/// The nearest points of a mesh to points of its surface, with their distances; `None` if the mesh has no triangle.
pub fn nearest_points(
    mesh: &TriangleMesh,
    points: &[Vec3],
    run: Run,
) -> Result<Vec<Option<(Vec3, f64)>>, BatchError> {
    let Ok(solid) = MeshSolid::new(Arc::new(mesh.clone()), DEFAULT) else {
        return Ok(vec![None; points.len()]);
    };
    let rows: Vec<[f64; 3]> = points.iter().map(|point| point.to_array()).collect();
    let found = solid.closest_points(&rows, run.threads, run.cancel, &|_| {});
    let found = found.map_err(|_| BatchError::Cancelled)?;
    Ok(found.into_iter().map(|near| near.map(|near| (near.point, near.distance))).collect())
}
