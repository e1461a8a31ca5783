//! What it takes to build a scene and to cast rays at it: `use shotline::prelude::*`.
//!
//! ```
//! use shotline::prelude::*;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let shell = Solid::sphere(2.0)? - Solid::sphere(1.5)?;
//! let world = Scene::of([Object::new("shell", shell)]).compile()?;
//! let hit = Caster::new(&world).closest(&Ray::new(Vec3::ZERO, Vec3::X)?, Span::FORWARD)?;
//! assert_eq!(hit.map(|hit| hit.t), Some(1.5));
//! # Ok(())
//! # }
//! ```

pub use crate::compile::World;
pub use crate::math::{Affine, Vec3};
pub use crate::query::{Caster, Hit, Overlaps, Segment};
pub use crate::ray::{Ray, Span};
pub use crate::scene::{Material, Scene, Units};
/// A [`Shape`] under the name of the most common shapes: `Solid::sphere(2.0)?`.
pub use crate::shape::Shape as Solid;
pub use crate::shape::{Object, Shape};
