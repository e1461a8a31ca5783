//! Conformance suites for solids and for accelerators, properties that must hold in any world, random scenes, and
//! meshes that are difficult for rounding.

pub mod accel;
pub mod agreement;
pub mod bytes;
mod leaf;
pub mod membership;
pub mod meshes;
pub mod moments;
pub mod parts;
pub mod random;
pub mod scene;
pub mod solid;
