//! Overlaps of objects of equal priority, and contents that stick out of what contains them, found by rays: a search, so small
//! ones can be missed.

mod axis_ray;
mod extent;
mod leaf_pairs;
mod on_ray;
mod pairs;
mod sampling;

pub use axis_ray::axis_ray;
pub use extent::Extent;
pub use on_ray::{Conflict, conflicts_on_ray};
pub use pairs::ObjectPair;
pub use sampling::sample_world;
