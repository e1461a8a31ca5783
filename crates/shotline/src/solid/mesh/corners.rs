//! A first look at the corners of all faces.

use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::ParallelSlice;

use super::distribute::{CHUNK, divided};
use super::{MeshError, TriangleMesh};
use crate::aabb::Aabb;
use crate::math::Vec3;

/// What is known of the corners of faces that are all valid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corners {
    /// The box around them.
    pub(super) bounds: Aabb,
    /// Whether the corners of every face are at three different positions.
    pub(super) are_different: bool,
}

impl Corners {
    const NONE: Corners = Corners { bounds: Aabb::EMPTY, are_different: true };

    /// Looks at the corners of all faces.
    ///
    /// # Errors
    /// [`MeshError`] if there are too many faces, an index is out of range, or a corner is not finite.
    pub(super) fn of(mesh: &TriangleMesh) -> Result<Corners, MeshError> {
        if mesh.faces.len() >= u32::MAX as usize {
            return Err(MeshError::TooManyFaces { faces: mesh.faces.len() });
        }
        let of_chunk = |(chunk, faces): (usize, &[[u32; 3]])| {
            let mut found = Corners::NONE;
            for (face, corners) in (chunk * CHUNK..).zip(faces) {
                found.add(mesh, face, corners)?;
            }
            Ok(found)
        };
        let chunks = mesh.faces.par_chunks(CHUNK).enumerate().map(of_chunk);
        divided(mesh.faces.len(), || chunks.reduce(|| Ok(Corners::NONE), |a, b| Ok(a?.merged(b?))))
    }

    /// The largest coordinate, whatever its sign.
    pub(super) fn largest(&self) -> f64 {
        self.bounds.min.abs().max(self.bounds.max.abs()).max_element()
    }

    #[inline(always)]
    fn add(&mut self, mesh: &TriangleMesh, face: usize, corners: &[u32; 3]) -> Result<(), MeshError> {
        let count = mesh.vertices.len();
        let mut at = [Vec3::ZERO; 3];
        for (at, &vertex) in at.iter_mut().zip(corners) {
            match mesh.vertices.get(vertex as usize) {
                Some(position) if position.is_finite() => *at = *position,
                None => return Err(MeshError::VertexOutOfRange { face, vertex, count }),
                Some(&position) => {
                    return Err(MeshError::NotFinite { vertex: vertex as usize, face, position });
                }
            }
        }
        let [a, b, c] = at;
        self.are_different &= a != b && b != c && c != a;
        self.bounds = self.bounds.union(&Aabb::around(at));
        Ok(())
    }

    fn merged(self, other: Corners) -> Corners {
        Corners {
            bounds: self.bounds.union(&other.bounds),
            are_different: self.are_different && other.are_different,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::mesh::shapes::ring;

    #[test]
    fn the_box_is_around_the_corners_and_not_around_other_vertices() {
        let mut mesh = ring(200, 150);
        let used = Aabb::around(mesh.vertices.iter().copied());
        mesh.vertices.extend([Vec3::splat(9.0), Vec3::NAN]);
        assert_eq!(Corners::of(&mesh), Ok(Corners { bounds: used, are_different: true }));
        mesh.faces.push([1, 2, 1]);
        assert_eq!(Corners::of(&mesh), Ok(Corners { bounds: used, are_different: false }));
    }

    #[test]
    fn the_first_wrong_corner_is_named() {
        let mut mesh = ring(200, 150);
        let count = mesh.vertices.len();
        mesh.faces[40_000][2] = count as u32;
        mesh.faces[50_000][0] = u32::MAX;
        let expected = MeshError::VertexOutOfRange { face: 40_000, vertex: count as u32, count };
        assert_eq!(Corners::of(&mesh), Err(expected));
    }
}
