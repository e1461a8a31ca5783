//! Dual contouring: a vertex for each part of the surface in a cell, and a polygon around each crossing of an edge with the surface.
//! The mesh is closed, whatever the surface is: it bounds what is inside along the edges.

use shotline::math::Vec3;

use crate::components::{EdgeCrossing, EdgeCrossings};
use crate::octree::{Cell, Octree};
use crate::quadratic_error::QuadraticError;
use crate::samples::Samples;

/// The cosine of the angle between the normals of the two sides of something thin, at most.
const NEARLY_OPPOSITE: f64 = -0.98;

/// The mesh of a surface.
#[derive(Debug, Default)]
pub struct Contour {
    pub vertices: Vec<Vec3>,
    /// For each vertex the sum of the normals of its part of the surface.
    pub normals: Vec<Vec3>,
    pub polygons: Vec<Polygon>,
    /// Cells within which the two sides of something thin, which an edge crosses, are joined: it ends there, nobody knows where.
    pub ends: Vec<u32>,
}

/// One or two triangles around a crossing.
#[derive(Debug)]
pub struct Polygon {
    pub around: EdgeCrossing,
    /// Counter-clockwise seen from outside. If the second is empty, its corners are equal.
    pub faces: [[u32; 3]; 2],
}

impl Polygon {
    /// The triangles, without an empty one.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.faces.iter().copied().filter(|[a, b, _]| a != b)
    }

    /// Those of its cells that are largest, and their size.
    pub fn largest_cells(&self, octree: &Octree) -> (u32, impl Iterator<Item = u32>) {
        let size = |cell: u32| octree.cells[cell as usize].size;
        let cells = self.around.cells;
        let largest = cells.into_iter().map(size).max().unwrap_or_default();
        (largest, cells.into_iter().filter(move |cell| size(*cell) == largest))
    }
}

/// The mesh of a surface that crosses edges of an octree.
pub fn contour(octree: &Octree, samples: &Samples) -> Contour {
    let crossings = EdgeCrossings::of(octree, samples);
    let (parts, count) = crossings.parts(octree, samples);
    let (vertices, normals) = vertices(octree, &crossings.all, &parts, count);
    let ends = ends(&crossings.all, &parts);
    let pairs = crossings.all.into_iter().zip(&parts);
    let polygons =
        pairs.map(|(around, parts)| Polygon { around, faces: faces(&vertices, &around, *parts) }).collect();
    Contour { vertices, normals, polygons, ends }
}

/// The cells within which neighbours on one edge are of one part, although their normals are nearly opposite: where these are not,
/// their planes tell where the surface is.
fn ends(crossings: &[EdgeCrossing], parts: &[[u32; 4]]) -> Vec<u32> {
    let is_thin = |pair: &[EdgeCrossing]| {
        pair[0].edge == pair[1].edge && pair[0].crossing.normal.dot(pair[1].crossing.normal) < NEARLY_OPPOSITE
    };
    let pairs = crossings.windows(2).zip(parts.windows(2)).filter(|(pair, _)| is_thin(pair));
    let of_pair = |(pair, parts): (&[EdgeCrossing], &[[u32; 4]])| {
        let same = (0..4).filter(|side| parts[0][*side] == parts[1][*side]);
        same.map(|side| pair[0].cells[side]).collect::<Vec<u32>>()
    };
    pairs.flat_map(of_pair).collect()
}

/// The point of least error of each part of the surface, and the sum of its normals.
fn vertices(
    octree: &Octree,
    crossings: &[EdgeCrossing],
    parts: &[[u32; 4]],
    count: usize,
) -> (Vec<Vec3>, Vec<Vec3>) {
    let mut errors = vec![QuadraticError::default(); count];
    let mut cells = vec![0; count];
    for (around, parts) in crossings.iter().zip(parts) {
        for side in 0..4 {
            let part = parts[side] as usize;
            cells[part] = around.cells[side];
            // A cell on two sides of the edge has the same part on both.
            if parts[side] != parts[(side + 1) % 4] {
                errors[part].add(around.crossing.position, around.crossing.normal);
            }
        }
    }
    let vertex =
        |(error, cell): (&QuadraticError, &u32)| vertex(octree, &octree.cells[*cell as usize], error);
    (errors.iter().zip(&cells).map(vertex).collect(), errors.iter().map(|error| error.normals).collect())
}

/// The point of least error in a cell. It may lie in a neighbour, where an edge or a corner reaches between the corners of cells;
/// farther away it is the nearest point of the cell.
fn vertex(octree: &Octree, cell: &Cell, error: &QuadraticError) -> Vec3 {
    let (low, size) = (octree.position(cell.low), Vec3::splat(octree.length(cell.size)));
    let point = error.minimum();
    let is_near = point.cmpge(low - size).all() && point.cmple(low + 2.0 * size).all();
    if is_near { point } else { point.clamp(low, low + size) }
}

/// The triangles between the vertices of the parts around a crossing.
fn faces(vertices: &[Vec3], around: &EdgeCrossing, mut parts: [u32; 4]) -> [[u32; 3]; 2] {
    if around.crossing.entering {
        parts.reverse();
    }
    if let Some(twice) = (0..4).find(|side| parts[*side] == parts[(side + 1) % 4]) {
        parts.rotate_left(twice + 1);
        let [a, b, c, _] = parts;
        return [[a, b, c], [a; 3]];
    }
    cut(vertices, parts, around.crossing.normal)
}

/// Cuts a quad along the diagonal that leaves both triangles nearest to the normal of the surface.
fn cut(vertices: &[Vec3], [a, b, c, d]: [u32; 4], of_surface: Vec3) -> [[u32; 3]; 2] {
    let normal = |triangle: [u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let fit = |triangles: [[u32; 3]; 2]| {
        let [first, second] = triangles.map(normal);
        let along = if of_surface.is_finite() { of_surface } else { (first + second).normalize_or_zero() };
        first.dot(along).min(second.dot(along))
    };
    let (one, other) = ([[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]);
    if fit(other) > fit(one) { other } else { one }
}
