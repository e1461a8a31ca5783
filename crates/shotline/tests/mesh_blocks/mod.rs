//! Random worlds of a few placed meshes, difficult rays, and the comparison of the kernel with the plain path.

pub mod cases;
pub mod compare;
pub mod meshes;
pub mod rays;
pub mod worlds;
