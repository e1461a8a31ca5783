//! Methods from a lecture on ray intersections that production code replaces by others. They are kept for readers,
//! and as oracles for tests. Nothing outside of tests calls them.

pub mod normals;
pub mod polynomials;
pub mod roth;
pub mod surfaces;
