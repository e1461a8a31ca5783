//! Conformance suites: one that every solid passes, one that every accelerator passes, what must hold of any world,
//! and random scenes.

pub mod accel;
pub mod agreement;
pub mod bytes;
pub mod membership;
pub mod moments;
pub mod random;
pub mod scene;
pub mod solid;
