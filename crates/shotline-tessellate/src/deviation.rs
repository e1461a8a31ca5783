//! How far a mesh is from the surface that it stands for.

use std::sync::Arc;

use shotline::accel::DEFAULT;
use shotline::compile::World;
use shotline::math::Vec3;
use shotline::query::batch::{self, BatchError, Fields, Run};
use shotline::ray::{Ray, Span};
use shotline::solid::mesh::{MeshSolid, TriangleMesh};

use crate::crossed_edges::of_object;

/// The greatest distance of a mesh from the surface of an object, both ways: from points of its triangles to the surface, and from
/// points of the surface to the mesh. It is a bound for these points; distances beyond `reach` are `reach`.
pub fn deviation(
    surface: &Surface,
    mesh: &TriangleMesh,
    points: &[Vec3],
    reach: f64,
    tolerance: f64,
) -> Result<f64, BatchError> {
    let mut probes: Vec<(Vec3, Vec3)> = probes(mesh).collect();
    let mut distances = surface.distances(&probes, reach)?;
    // The distance along any line is at least the distance. A line along a normal may graze an edge of the surface.
    for direction in DIRECTIONS.map(Vec3::from_array) {
        let far: Vec<usize> = (0..probes.len()).filter(|i| distances[*i] > tolerance).collect();
        if far.is_empty() {
            break;
        }
        probes.iter_mut().for_each(|probe| probe.1 = direction.normalize());
        let again: Vec<(Vec3, Vec3)> = far.iter().map(|i| probes[*i]).collect();
        for (i, distance) in far.iter().zip(surface.distances(&again, reach)?) {
            distances[*i] = distances[*i].min(distance);
        }
    }
    let to_surface = distances.into_iter().fold(0.0, f64::max);
    Ok(to_surface.max(distance_to_mesh(mesh, points, surface.run)?))
}

/// Directions of no symmetry, in which a surface is looked for where it is not along the normal.
const DIRECTIONS: [[f64; 3]; 6] = [
    [0.61, 0.37, 0.7],
    [-0.72, 0.53, 0.45],
    [0.31, -0.87, 0.38],
    [0.83, 0.21, -0.52],
    [-0.18, 0.95, -0.26],
    [0.09, 0.28, 0.96],
];

/// The surface of an object of a world.
pub struct Surface<'w> {
    pub world: &'w World,
    pub object: u32,
    pub run: Run<'w>,
}

impl Surface<'_> {
    /// How far the surface is from points, along a direction from each and back; `reach` at most.
    fn distances(&self, probes: &[(Vec3, Vec3)], reach: f64) -> Result<Vec<f64>, BatchError> {
        let ray = |(point, direction): &(Vec3, Vec3)| Ray::new(*point - *direction * reach, *direction);
        // Points of a mesh are finite, and directions are not zero.
        let rays: Vec<Ray> = probes.iter().filter_map(|probe| ray(probe).ok()).collect();
        let span = Span::new(0.0, 2.0 * reach).unwrap_or(Span::FORWARD);
        let fields = Fields::NORMAL | Fields::OBJECT | Fields::ENTERING;
        let rows = batch::crossings(self.world, &rays, span, Run { fields, ..self.run })?;
        let distance = |ray| {
            let surfaces = of_object(&rows, ray, self.object);
            let distances = surfaces.iter().filter(|crossing| !crossing.normal.is_nan());
            distances.map(|crossing| (crossing.t - reach).abs()).fold(reach, f64::min)
        };
        Ok((0..rays.len()).map(distance).collect())
    }
}

/// The greatest distance from points to a mesh; infinite if it has no triangle.
fn distance_to_mesh(mesh: &TriangleMesh, points: &[Vec3], run: Run) -> Result<f64, BatchError> {
    let Ok(solid) = MeshSolid::new(Arc::new(mesh.clone()), DEFAULT) else {
        return Ok(if points.is_empty() { 0.0 } else { f64::INFINITY });
    };
    let rows: Vec<[f64; 3]> = points.iter().map(|point| point.to_array()).collect();
    let found = solid.closest_points(&rows, run.threads, run.cancel, &|_| {});
    let found = found.map_err(|_| BatchError::Cancelled)?;
    Ok(found.iter().map(|near| near.map_or(f64::INFINITY, |near| near.distance)).fold(0.0, f64::max))
}

/// Points of a mesh and directions in which the surface is expected. Triangles without area have none, and vertices and sides
/// neither: at an edge of the surface a ray along a normal grazes it.
fn probes(mesh: &TriangleMesh) -> impl Iterator<Item = (Vec3, Vec3)> {
    let weights = [[1.0, 1.0, 1.0], [4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]];
    let corners = (0..).take(mesh.faces.len()).map(|face| mesh.corners(face));
    corners.flat_map(move |[a, b, c]| {
        let normal = (b - a).cross(c - a).try_normalize();
        let point = move |[u, v, w]: [f64; 3]| (a * u + b * v + c * w) / (u + v + w);
        normal.into_iter().flat_map(move |normal| weights.map(|weights| (point(weights), normal)))
    })
}
