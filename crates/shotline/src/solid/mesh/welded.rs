//! A mesh with its exactly coincident vertices welded.

use rayon::slice::ParallelSliceMut;

use super::TriangleMesh;
use crate::math::Vec3;

/// Returns for each vertex the first vertex at exactly the same position.
pub(super) fn first_at(vertices: &[Vec3]) -> Vec<u32> {
    // Adding zero turns -0.0 into 0.0.
    let key = |v: &Vec3| v.to_array().map(|x| (x + 0.0).to_bits());
    let mut sorted: Vec<([u64; 3], u32)> = vertices.iter().map(key).zip(0..).collect();
    sorted.par_sort_unstable();
    let mut first = vec![0; vertices.len()];
    for same in sorted.chunk_by(|a, b| a.0 == b.0) {
        same.iter().for_each(|(_, vertex)| first[*vertex as usize] = same[0].1);
    }
    first
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
