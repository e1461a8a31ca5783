//! Dual contouring: a vertex in each cell that the surface passes through, and two triangles around each edge that crosses it.
//! The mesh bounds the cells around the points that are inside, so that it is closed, whatever the surface is.

use std::collections::HashMap;

use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;

use crate::crossed_edges::CrossedEdge;
use crate::grid::Grid;
use crate::quadratic_error::QuadraticError;

/// The mesh of a surface that crosses edges of a grid.
pub fn contour(grid: &Grid, edges: &[CrossedEdge]) -> TriangleMesh {
    let mut cells = Cells { grid, numbers: HashMap::new(), errors: Vec::new(), corners: Vec::new() };
    let quads: Vec<[u32; 4]> = edges.iter().map(|edge| cells.around(edge)).collect();
    let vertices = cells.vertices();
    let mut faces = Vec::with_capacity(2 * quads.len());
    for (edge, quad) in edges.iter().zip(quads) {
        faces.extend(cut(&vertices, quad, edge));
    }
    TriangleMesh::new(vertices, faces)
}

/// The cells with a vertex.
struct Cells<'g> {
    grid: &'g Grid,
    /// The vertex of each cell.
    numbers: HashMap<usize, u32>,
    errors: Vec<QuadraticError>,
    /// The lowest point of each cell.
    corners: Vec<[usize; 3]>,
}

impl Cells<'_> {
    /// The vertices of the cells around an edge, counter-clockwise seen from outside, to which its crossing is added.
    fn around(&mut self, edge: &CrossedEdge) -> [u32; 4] {
        let (b, c) = ((edge.axis + 1) % 3, (edge.axis + 2) % 3);
        let mut quad = [(1, 1), (0, 1), (0, 0), (1, 0)].map(|(back_b, back_c)| {
            let mut cell = edge.start;
            // The grid reaches beyond the surface, so there is a cell before.
            cell[b] -= back_b;
            cell[c] -= back_c;
            let vertex = self.vertex(cell);
            self.errors[vertex as usize].add(edge.position, edge.normal);
            vertex
        });
        if edge.entering {
            quad.reverse();
        }
        quad
    }

    fn vertex(&mut self, cell: [usize; 3]) -> u32 {
        let (errors, corners) = (&mut self.errors, &mut self.corners);
        *self.numbers.entry(self.grid.number(cell)).or_insert_with(|| {
            errors.push(QuadraticError::default());
            corners.push(cell);
            (errors.len() - 1) as u32
        })
    }

    /// The point of least error of each cell. It may lie in a neighbour, where an edge or a corner reaches between the points of
    /// the grid; farther away it is the nearest point of the cell.
    fn vertices(&self) -> Vec<Vec3> {
        let step = Vec3::splat(self.grid.step);
        let vertex = |(error, corner): (&QuadraticError, &[usize; 3])| {
            let low = self.grid.position(Vec3::from_array(corner.map(|i| i as f64)));
            let point = error.minimum();
            let is_near = point.cmpge(low - step).all() && point.cmple(low + 2.0 * step).all();
            if is_near { point } else { point.clamp(low, low + step) }
        };
        self.errors.iter().zip(&self.corners).map(vertex).collect()
    }
}

/// Cuts a quad along the diagonal that leaves both triangles nearest to the normal of the surface.
fn cut(vertices: &[Vec3], [a, b, c, d]: [u32; 4], edge: &CrossedEdge) -> [[u32; 3]; 2] {
    let normal = |triangle: [u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let fit = |triangles: [[u32; 3]; 2]| {
        let [first, second] = triangles.map(normal);
        let along = if edge.normal.is_finite() { edge.normal } else { (first + second).normalize_or_zero() };
        first.dot(along).min(second.dot(along))
    };
    let (one, other) = ([[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]);
    if fit(other) > fit(one) { other } else { one }
}
