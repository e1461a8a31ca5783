//! Pictures of shotline worlds: a camera, lights, a registry of looks, and a film that develops to PNG.
//!
//! The one way in is [`render()`]. It asks the world nothing that any other caller could not ask: closest
//! crossings, occlusion and segments, all through [`shotline::query::Caster`].
//!
//! A picture is the same, bit for bit, for any number of threads.
#![deny(missing_docs)]

pub mod animation;
pub mod backdrop;
pub mod camera;
pub mod color;
pub mod error;
mod film;
mod finish;
pub mod framing;
mod heat;
pub mod image;
mod lettering;
pub mod light;
mod look;
mod movie;
mod png;
pub mod render;
mod sampling;
mod sight;
mod still;

pub use animation::{Animation, AnimationError, animate};
pub use backdrop::Backdrop;
pub use error::RenderError;
pub use film::{Exposure, Sample};
pub use image::Image;
pub use light::Lighting;
pub use look::{LOOKS, Look, look};
pub use movie::Movie;
pub use png::{encode_bytes, encode_png};
pub use render::{Settings, develop, expose, render, view};
pub use sight::Coherence;
