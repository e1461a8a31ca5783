//! shotline finds where rays cross solids: **every** crossing, in order, entering or exiting.
#![deny(missing_docs)]

pub mod aabb;
pub mod accel;
pub mod compile;
pub mod crossing;
pub mod csg;
pub mod math;
pub mod query;
pub mod ray;
pub mod roots;
pub mod scene;
pub mod solid;
#[cfg(any(test, feature = "testkit"))]
pub mod testkit;
