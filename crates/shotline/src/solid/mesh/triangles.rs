//! The scaled triangles of a mesh, made from its vertices when they are needed.

use std::sync::Arc;

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::TriangleMesh;
use super::corners::Corners;
use super::distribute::CHUNK;
use super::mesh_line::{PowerOfTwoScale, Triangle};
use crate::aabb::Aabb;
use crate::math::Vec3;

/// The faces with three different corners, numbered as items of an accelerator.
#[derive(Clone, Debug)]
pub(super) struct Triangles {
    mesh: Arc<TriangleMesh>,
    size: PowerOfTwoScale,
    /// The face of each item; `None` if every face is an item.
    faces: Option<Vec<u32>>,
}

impl Triangles {
    pub(super) fn of(mesh: Arc<TriangleMesh>, size: PowerOfTwoScale, corners: &Corners) -> Triangles {
        if corners.are_different && mesh.vertices.par_iter().with_min_len(CHUNK).all(|v| size.is_exact(*v)) {
            return Triangles { mesh, size, faces: None };
        }
        // Scaling may underflow, so that corners become equal.
        let is_triangle = |face: &u32| {
            let [a, b, c] = mesh.corners(*face).map(|v| size.scale(v));
            a != b && b != c && c != a
        };
        let all = (0..mesh.faces.len() as u32).into_par_iter().with_min_len(CHUNK);
        let faces = if all.clone().all(|face| is_triangle(&face)) {
            None
        } else {
            Some(all.filter(is_triangle).collect())
        };
        Triangles { mesh, size, faces }
    }

    pub(super) fn len(&self) -> usize {
        self.faces.as_ref().map_or(self.mesh.faces.len(), Vec::len)
    }

    /// The face of an item.
    pub(super) fn face(&self, item: u32) -> u32 {
        self.faces.as_ref().map_or(item, |faces| faces[item as usize])
    }

    /// The triangle of an item.
    pub(super) fn get(&self, item: u32) -> Triangle {
        self.of_face(self.face(item))
    }

    /// The triangle of a face.
    pub(super) fn of_face(&self, face: u32) -> Triangle {
        Triangle { corners: self.mesh.corners(face).map(|v| self.size.scale(v)), face }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Triangle> + '_ {
        (0..self.len() as u32).map(|item| self.get(item))
    }

    pub(super) fn par_iter(&self) -> impl IndexedParallelIterator<Item = Triangle> + '_ {
        (0..self.len() as u32).into_par_iter().with_min_len(CHUNK).map(|item| self.get(item))
    }

    /// The scaled vertices of the mesh, also those that no face uses.
    pub(super) fn vertices(&self) -> impl ParallelIterator<Item = Vec3> + '_ {
        self.mesh.vertices.par_iter().with_min_len(CHUNK).map(|v| self.size.scale(*v))
    }

    /// A box around the triangles before they are scaled, and one around the scaled ones.
    pub(super) fn bounds(&self, corners: &Corners) -> [Aabb; 2] {
        if self.faces.is_none() {
            let Aabb { min, max } = corners.bounds;
            return [corners.bounds, Aabb::new(self.size.scale(min), self.size.scale(max))];
        }
        let boxes = self.par_iter().map(|t| [Aabb::around(self.mesh.corners(t.face)), t.bounds()]);
        boxes.reduce(|| [Aabb::EMPTY; 2], |a, b| [a[0].union(&b[0]), a[1].union(&b[1])])
    }

    /// Whether the items are the same faces.
    pub(super) fn has_faces_of(&self, other: &Triangles) -> bool {
        self.len() == other.len() && self.faces == other.faces
    }

    /// Bytes used beyond the mesh.
    pub(super) fn memory(&self) -> usize {
        self.faces.as_ref().map_or(0, |faces| size_of_val(faces.as_slice()))
    }
}
