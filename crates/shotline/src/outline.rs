//! The shapes of the parts of accelerators, for pictures of what a ray meets on its way.

use crate::aabb::Aabb;
use crate::math::Vec3;

/// The shape of a node or of an item, in the frame of its accelerator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// A box: of a node, of a cell or of an item.
    Box(Aabb),
    /// A bounding sphere.
    Sphere {
        /// Its centre.
        centre: Vec3,
        /// Its radius.
        radius: f64,
    },
    /// A plane that cuts space in two: the points `p` with `normal . p = height`.
    Plane {
        /// The normal, of any length.
        normal: Vec3,
        /// The product at points of the plane.
        height: f64,
    },
}
