//! Conformance suites: one that every solid passes, one that every accelerator passes, and random scenes.

pub mod accel;
pub mod random;
pub mod scene;
pub mod solid;
