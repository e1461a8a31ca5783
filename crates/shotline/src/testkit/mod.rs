//! Conformance suites: one that every solid passes, one that every accelerator passes, what must hold of any world,
//! random scenes, and meshes that are hard on rounding.

pub mod accel;
pub mod agreement;
pub mod bytes;
mod leaf;
pub mod membership;
pub mod meshes;
pub mod moments;
pub mod random;
pub mod scene;
pub mod solid;
