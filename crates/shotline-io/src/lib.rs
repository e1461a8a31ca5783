//! Files for shotline: scenes, meshes and arrays. The core knows no file; this crate knows no query.
//!
//! [`load`] reads a scene or a mesh, [`save`] writes one. A [`Document`] keeps where everything stood, so that
//! what [`shotline::compile`] finds wrong is shown in the file. Every reader takes any bytes at all: what is
//! wrong with them is a [`ReadError`] that says where, and memory stays in proportion to the file.
#![deny(missing_docs)]

pub mod arrays;
mod bytes;
mod document;
mod error;
mod fault;
mod format;
mod obj;
mod ply;
mod polygon;
mod save;
mod scene_json;
mod stl;
mod suggest;
mod whole;

pub use document::{Document, Source};
pub use error::{Place, Problem, ReadError, Snippet, WriteError};
pub use format::{FORMATS, Format, load, read_mesh};
pub use save::save;
pub use scene_json::{parse_scene, scene_schema, write_scene};
pub use whole::{Output, write_whole};
