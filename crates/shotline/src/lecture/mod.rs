//! What a lecture on ray intersections teaches and production code does in another way: kept for readers, and as oracles
//! for tests. Nothing outside of tests calls it.

pub mod normals;
pub mod polynomials;
pub mod roth;
pub mod surfaces;
