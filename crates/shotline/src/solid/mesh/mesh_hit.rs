//! A hit of a ray with a mesh, in world coordinates.

use crate::crossing::Crossing;
use crate::math::Vec3;

/// A hit of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshHit {
    /// The number of the ray in its block.
    pub row: u32,
    pub crossing: Crossing,
    /// Whether it is known to be off the edges of the triangle: its barycentric coordinates are larger than
    /// [`INSET`](super::kernel::INSET) / 2.
    pub is_off_edges: bool,
    /// The unit normal of the triangle in world coordinates: [`crate::solid::Solid::normal`] under the transforms of the
    /// block.
    pub normal: Vec3,
    /// Whether the ray runs against the normal.
    pub is_against: bool,
}
