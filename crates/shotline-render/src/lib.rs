//! Pictures of shotline worlds: a camera, lights, a registry of looks (render modes), and a film that develops to PNG and JPEG.
//!
//! [`render()`] makes a picture. It uses the public queries of [`shotline::query::batch::BatchCaster`] only: closest
//! crossings, occlusion and segments, and where objects contain others, what is visible first. Rays of the same kind are cast together: those from the camera, those to each lamp,
//! those of each reflection.
//!
//! A picture is the same, bit for bit, for any number of threads.
#![deny(missing_docs)]

pub mod animation;
pub mod background;
pub mod camera;
pub mod clip_plane;
pub mod color;
mod edges;
pub mod error;
mod exposure;
mod film;
pub mod framing;
mod hatch;
mod heat_map;
pub mod image;
mod jpeg;
pub mod light;
mod look;
mod movie;
mod opacity;
mod picture_in_steps;
mod png;
mod ray_picture;
pub mod render;
mod sampling;
mod settings;
pub mod slice;
mod surface_material;
mod temporal_cache;
mod text;
mod tile;
mod tracer;
mod vertex_colors;
mod viewpoint;
mod visible_part;

pub use animation::{Animation, AnimationError, animate};
pub use background::Background;
pub use clip_plane::{ClipPlane, InvalidClipPlane};
pub use error::RenderError;
pub use exposure::{Exposure, Sample};
pub use image::Image;
pub use jpeg::{JpegError, encode_jpeg, encode_jpeg_bytes};
pub use light::Lighting;
pub use look::{LOOKS, Look, look};
pub use movie::Movie;
pub use opacity::{InvalidOpacity, Opacities};
pub use picture_in_steps::{PictureInSteps, camera_of, visible_subject};
pub use png::{encode_bytes, encode_png};
pub use ray_picture::{RayDrawing, RayMark, render_ray};
pub use render::{develop, expose, render, view};
pub use settings::Settings;
pub use tracer::Coherence;
pub use viewpoint::{StandardView, Viewpoint};
