//! What it takes to build a scene and to cast rays at it: `use shotline::prelude::*`.

pub use crate::compile::World;
pub use crate::math::{Affine, Vec3};
pub use crate::query::{Caster, Hit, Overlaps, Segment};
pub use crate::ray::{Ray, Span};
pub use crate::scene::{Material, Scene, Units};
pub use crate::shape::{Object, Shape};
