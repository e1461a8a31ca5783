//! A mesh with its exactly coincident vertices welded.

use std::collections::HashMap;

use super::TriangleMesh;
use crate::math::Vec3;

/// Returns for each vertex the first vertex at exactly the same position.
pub(super) fn first_at(vertices: &[Vec3]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(vertices.len());
    // Adding zero turns -0.0 into 0.0.
    let key = |v: &Vec3| v.to_array().map(|x| (x + 0.0).to_bits());
    (0..).zip(vertices).map(|(i, v)| *first.entry(key(v)).or_insert(i)).collect()
}

/// A face whose vertices are each the first at their position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub(super) number: u32,
    pub(super) corners: [u32; 3],
}

/// Returns the faces with corners at three different positions.
pub(super) fn welded(mesh: &TriangleMesh, first_at: &[u32]) -> Vec<Face> {
    let face =
        |(number, corners): (u32, &[u32; 3])| Face { number, corners: corners.map(|v| first_at[v as usize]) };
    (0..).zip(&mesh.faces).map(face).filter(|f| has_three_corners(&f.corners)).collect()
}

/// Whether no two corners coincide.
pub(super) fn has_three_corners([a, b, c]: &[u32; 3]) -> bool {
    a != b && b != c && c != a
}
