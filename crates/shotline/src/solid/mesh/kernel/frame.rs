//! The numbers of a mesh that every ray needs.

use crate::aabb::Aabb;
use crate::math::Vec3;
use crate::solid::mesh::mesh_line::PowerOfTwoScale;

/// The numbers of a mesh that every ray needs.
#[derive(Clone, Copy, Debug)]
pub(in crate::solid::mesh) struct MeshFrame {
    pub size: PowerOfTwoScale,
    pub scaled_bounds: Aabb,
    /// Whether the triangles are wound inward.
    pub is_inward: bool,
}

impl MeshFrame {
    /// The normal of a triangle, turned over if the mesh is wound inward.
    #[inline(always)]
    pub fn oriented(&self, normal: Vec3) -> Vec3 {
        if self.is_inward { -normal } else { normal }
    }
}
