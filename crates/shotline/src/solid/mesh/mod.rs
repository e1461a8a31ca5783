//! Triangle meshes: closed ones are solids, others surfaces.

use crate::math::Vec3;

/// Vertices and triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// The vertices.
    pub vertices: Vec<Vec3>,
    /// Three vertex numbers a triangle.
    pub faces: Vec<[u32; 3]>,
}
