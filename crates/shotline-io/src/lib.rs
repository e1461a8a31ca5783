//! Files for shotline: scenes, meshes and arrays. The core knows no file; this crate knows no query.
//!
//! [`load`] reads a scene or a mesh, [`save()`] writes one. A [`Document`] keeps where everything stood, so that
//! what [`shotline::compile`] finds wrong is shown in the file. Every reader takes any bytes at all: what is
//! wrong with them is a [`ReadError`] that says where, and memory stays in proportion to the file.
//!
//! ```
//! let text = r#"{ "shotline": 1, "objects": [{ "node": { "kind": "sphere", "raduis": 2 } }] }"#;
//! let error = shotline_io::parse_scene(text, None).unwrap_err();
//! assert!(error.to_string().ends_with("help: did you mean 'radius'?"));
//! ```
#![deny(missing_docs)]

pub mod arrays;
mod bytes;
mod document;
mod error;
mod fault;
mod files;
mod format;
#[cfg(feature = "testkit")]
pub mod fuzz;
mod note;
mod obj;
mod packed;
mod ply;
mod polygon;
mod registry;
mod save;
mod scene_json;
mod stl;
mod suggest;
mod weld;
mod whole;

pub use document::{Document, Source};
pub use error::{Place, Problem, ReadError, Snippet, WriteError, system_words};
pub use format::{Format, Reach};
pub use note::{Effect, Note, Spot};
pub use packed::{Packed, pack};
pub use polygon::mesh_of_polygons;
pub use registry::{FORMATS, load, load_bytes, load_with, parse_scene, read_mesh};
pub use save::save;
pub use scene_json::{scene_schema, write_scene};
pub use weld::{ReadOptions, weld_note};
pub use whole::{Output, remove_unfinished, write_stream, write_whole};

/// The README's Rust example is compiled.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
