//! Triangle meshes. Closed meshes are solids, others are surfaces.
//!
//! [`TriangleMesh`] is plain data, [`Topology`] reports its defects, and [`MeshSolid`] intersects it with rays. On
//! demand [`MeshSolid`] also computes what takes longer (`inverted_shells`, `self_intersections`, `moments`). Whether a
//! line passes through a triangle is decided exactly (`sheared_ray`, `exact`), so two triangles always agree about the
//! edge that they share. `plane` and `mesh_line` compute where; `winding` turns hits into crossings.

mod attribute;
mod closest_point;
mod contacts;
mod containment;
mod corners;
mod distribute;
mod doubt;
mod edge_report;
mod edges;
mod effort;
mod empty_cells;
mod exact;
mod face_sides;
mod index;
mod intersections;
mod inverted_shells;
pub(crate) mod kernel;
mod mesh_hit;
mod mesh_line;
mod moments;
mod nearest;
mod obb;
mod pairs;
mod patches;
mod plane;
mod self_intersections;
mod separation;
mod sheared_ray;
mod shells;
mod solid;
mod stop;
mod tally;
mod tetrahedra;
mod topology;
mod triangle_point;
mod triangles;
mod weld;
mod welded;
mod winding;

#[cfg(test)]
mod bounds_tests;
#[cfg(test)]
mod exact_tests;
#[cfg(test)]
mod refit_tests;
#[cfg(test)]
pub(crate) mod shapes;
#[cfg(test)]
mod tests;

use crate::math::Vec3;

pub use attribute::{Attribute, NO_ROW};
pub use closest_point::ClosestPoint;
pub use doubt::Doubt;
pub(crate) use mesh_hit::MeshHit;
pub use moments::Enclosed;
pub(crate) use moments::tetrahedron;
pub use patches::Winding;
pub use solid::MeshSolid;
pub use stop::Cancelled;
pub use tally::{Edge, Intersection, Tally};
pub use topology::Topology;
pub use weld::{Weld, WeldError, Welded};
pub(crate) use winding::{hits_to_crossings, step};

/// Vertices and triangles. The corners of a triangle are counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// The vertices. Those that no face uses may have any value, even NaN.
    pub vertices: Vec<Vec3>,
    /// Three vertex indices per triangle.
    pub faces: Vec<[u32; 3]>,
    /// For each triangle the index, from 0, of the polygon in its file that it was cut from. Empty where triangle and
    /// polygon indices are the same. No query depends on it.
    pub polygons: Vec<u32>,
    /// Values at the corners of the triangles, such as colours; no two of one name.
    pub attributes: Vec<Attribute>,
}

impl TriangleMesh {
    /// Creates a mesh whose triangles are not cut from polygons.
    pub fn new(vertices: Vec<Vec3>, faces: Vec<[u32; 3]>) -> TriangleMesh {
        TriangleMesh { vertices, faces, ..TriangleMesh::default() }
    }

    /// Checks what every mesh must have: a face, corners that exist and are finite, and attributes that fit.
    ///
    /// # Errors
    /// [`MeshError`] says which face or vertex is wrong. An open mesh is not an error: see [`Topology`].
    pub fn check(&self) -> Result<(), MeshError> {
        corners::Corners::of(self)?;
        let is_triangle = |[a, b, c]: [Vec3; 3]| a != b && b != c && c != a;
        let has_triangle = (0..self.faces.len()).any(|face| is_triangle(self.corners(face as u32)));
        if !has_triangle {
            return Err(MeshError::Empty);
        }
        self.attributes.iter().try_for_each(|attribute| attribute.check(self))
    }

    /// Returns the polygon of the file that a face was cut from, counted from 0.
    pub fn polygon(&self, face: u32) -> u32 {
        self.polygons.get(face as usize).copied().unwrap_or(face)
    }

    /// The number of faces or of vertices, if there are more of them.
    fn elements(&self) -> usize {
        self.faces.len().max(self.vertices.len())
    }

    /// Returns the three corners of a face.
    ///
    /// # Panics
    /// If there is no such face, or it uses a vertex that does not exist.
    pub fn corners(&self, face: u32) -> [Vec3; 3] {
        self.faces[face as usize].map(|v| self.vertices[v as usize])
    }
}

/// Why vertices and faces do not form a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// There is no face with three different corners.
    #[error("the mesh has no face with three different corners; give at least one triangle")]
    Empty,
    /// Welding has left no face with three different corners.
    #[error(
        "after welding within {within} the mesh has no face with three different corners; choose a smaller distance"
    )]
    Collapsed {
        /// The distance within which vertices were welded.
        within: f64,
    },
    /// There are more faces than can be numbered.
    #[error("the mesh has {faces} faces, but at most {} are possible; split it into several", u32::MAX)]
    TooManyFaces {
        /// How many there are.
        faces: usize,
    },
    /// A face uses a vertex that does not exist.
    #[error(
        "face {face} names vertex {vertex}, but there are only {count} vertices, numbered from 0; \
         correct the index or remove the face"
    )]
    VertexOutOfRange {
        /// The face, from 0.
        face: usize,
        /// The index of the vertex.
        vertex: u32,
        /// The number of vertices.
        count: usize,
    },
    /// A corner of a face has a coordinate that is not finite.
    #[error(
        "vertex {vertex} is ({}, {}, {}), but coordinates must be finite where a face uses them, and face {face} uses \
         it; correct the vertex or remove it with its faces",
        position.x, position.y, position.z
    )]
    NotFinite {
        /// The vertex, from 0.
        vertex: usize,
        /// The first face that uses it, from 0.
        face: usize,
        /// The given coordinates.
        position: Vec3,
    },
    /// An attribute does not fit the vertices or the triangles.
    #[error("attribute '{name}' does not fit the mesh: {why}")]
    Attribute {
        /// The name of the attribute.
        name: String,
        /// What does not fit.
        why: String,
    },
    /// There is no accelerator of this name.
    #[error("there is no accelerator '{name}'; the names are {}", crate::accel::NAMES.join(", "))]
    UnknownAccelerator {
        /// The requested name.
        name: String,
    },
}
