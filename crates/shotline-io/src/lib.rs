//! Files for shotline: scenes, meshes and arrays. The core reads no files; this crate makes no queries.
//!
//! [`load()`] reads a scene or a mesh, [`save()`] writes one. A [`Document`] keeps the location of each node, so that
//! errors of [`shotline::compile`] are shown in the file. Every reader accepts any bytes: it reports what is wrong
//! with them as a [`ReadError`] with locations, and uses memory in proportion to the file.
//!
//! ```
//! let text = r#"{ "shotline": 1, "objects": [{ "node": { "kind": "sphere", "raduis": 2 } }] }"#;
//! let error = shotline_io::parse_scene(text, None).unwrap_err();
//! assert!(error.to_string().ends_with("help: did you mean 'radius'?"));
//! ```
#![deny(missing_docs)]

mod append;
pub mod arrays;
mod atomic_write;
mod bytes;
mod corner_values;
mod diagnostic;
mod document;
mod error;
mod files;
mod format;
#[cfg(feature = "testkit")]
pub mod fuzz;
mod joined;
mod json;
mod lines;
mod load;
mod location;
mod losses;
mod material_files;
mod mesh_file;
mod note;
mod options;
mod packed;
mod parts;
mod paths;
mod placed;
mod polygon;
mod save;
mod suggest;
mod unique_names;
mod weld;
mod xml;

pub use atomic_write::{Output, atomic_write, remove_unfinished, write_stream};
pub use diagnostic::Diagnostic;
pub use document::{Document, Source};
pub use error::{ReadError, WriteError, os_error_message};
pub use format::scene_json::{scene_schema, write_scene};
pub use format::{FORMATS, Format, mesh_format_names};
pub use load::{load, load_bytes, load_with, parse_scene, read_mesh};
pub use location::{Location, Snippet};
pub use note::{Effect, Note, Spot};
pub use options::{PathPolicy, ReadOptions};
pub use packed::{Packed, pack};
pub use polygon::mesh_of_polygons;
pub use save::save;
pub use suggest::nearest_name;
pub use weld::weld_note;

/// The Rust examples of the README and of the quick start are run.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
#[doc = include_str!("../../../docs/quick-start.md")]
struct Pages;
