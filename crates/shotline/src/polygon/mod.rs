//! Polygons: their triangulation, and where they cross themselves. All signs are exact.

mod crossing;
mod ear_clipping;
#[cfg(any(test, feature = "testkit"))]
pub mod invariants;
mod projection;
mod reflex_vertices;
mod ring;
#[cfg(test)]
mod tests;

pub use ear_clipping::{Triangulation, triangulate};
pub(crate) use ring::{Ring, RingError};
