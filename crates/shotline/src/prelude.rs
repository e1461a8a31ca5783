//! What it takes to build a scene and to cast rays at it: `use shotline::prelude::*`.

pub use crate::compile::World;
pub use crate::math::{Affine, Vec3};
pub use crate::query::{Caster, Hit, Overlaps, Segment};
pub use crate::ray::{Ray, Span};
pub use crate::scene::{Material, Scene, Units};
/// A [`Shape`] under the name of the most common shapes: `Solid::sphere(2.0)?`.
pub use crate::shape::Shape as Solid;
pub use crate::shape::{Object, Shape};
