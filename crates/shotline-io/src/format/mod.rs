//! The registry of file formats. A new format is a file beside this one, a `mod` and a line in the registry.

mod gdml;
mod gltf;
mod instances;
pub(crate) mod obj;
mod off;
mod ply;
pub(crate) mod scene_json;
mod stl;
mod three_mf;

use std::path::Path;
use std::sync::Arc;

use shotline::scene::Scene;
use shotline::solid::mesh::TriangleMesh;

use crate::diagnostic::RawDiagnostic;
use crate::document::Document;
use crate::error::{ReadError, WriteError};
use crate::mesh_file::{Encoded, MeshFile, NamedMesh};
use crate::options::ReadOptions;

/// A file format.
#[derive(Debug)]
pub struct Format {
    /// Its name.
    pub name: &'static str,
    /// File name extensions, without the point.
    pub extensions: &'static [&'static str],
    /// Whether some bytes look like this format; used where the file name has no known extension.
    pub detect: fn(&[u8]) -> bool,
    pub(crate) content: Content,
}

/// The bytes of a scene in a format, and notes on what is lost.
#[derive(Clone, Debug)]
pub(crate) struct WrittenScene {
    pub(crate) bytes: Vec<u8>,
    pub(crate) notes: Vec<String>,
}

/// Encodes a scene for a file of this name, which is not written yet.
pub(crate) type WriteScene = fn(&Path, &Scene) -> Result<WrittenScene, WriteError>;

/// Encodes a mesh.
pub(crate) type WriteMesh = fn(NamedMesh) -> Result<Encoded, WriteError>;

/// What a format holds.
#[derive(Debug)]
pub(crate) enum Content {
    /// Scenes.
    Scene {
        read: fn(&Path, Vec<u8>, MeshSource) -> Result<Document, ReadError>,
        write: WriteScene,
        /// Whether the file holds meshes itself. Otherwise it names their files.
        holds_meshes: bool,
        /// Whether it keeps which objects contain others.
        keeps_nesting: bool,
        /// The largest file that is read, in bytes.
        max_bytes: u64,
        /// Whether a file may hold several scenes, of which one is chosen by its name.
        has_setups: bool,
    },
    /// One mesh.
    Mesh {
        read: fn(&[u8]) -> Result<MeshFile, RawDiagnostic>,
        write: WriteMesh,
        keeps: Keeps,
        /// Whether it keeps every bit of a mesh, the numbers of its polygons included.
        is_lossless: bool,
    },
}

/// What a mesh format keeps of the objects whose faces it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keeps {
    /// Faces only.
    Nothing,
    /// The name of each object.
    Names,
    /// The names of each object and of its material. A file beside the mesh says what materials look like.
    NamesAndMaterials,
}

/// The source of the meshes that a scene names.
#[derive(Clone, Copy, Debug)]
pub(crate) enum MeshSource<'a> {
    /// Files in any mesh format.
    Files { read: fn(&Path) -> Result<MeshFile, ReadError>, options: &'a ReadOptions },
    /// Meshes in memory, named by their index.
    Given(&'a [Arc<TriangleMesh>]),
}

/// Every format. Contents are tried in this order.
pub static FORMATS: &[&Format] = &[
    &gltf::FORMAT,
    &scene_json::FORMAT,
    &gdml::FORMAT,
    &three_mf::FORMAT,
    &ply::FORMAT,
    &off::FORMAT,
    &stl::FORMAT,
    &obj::FORMAT,
];

impl Format {
    /// The format of a file name extension.
    pub fn of_file(path: &Path) -> Option<&'static Format> {
        by_extension(path)
    }

    /// Whether the format keeps which objects contain others.
    pub fn keeps_nesting(&self) -> bool {
        matches!(self.content, Content::Scene { keeps_nesting: true, .. })
    }
}

/// The format of a file name extension.
pub(crate) fn by_extension(path: &Path) -> Option<&'static Format> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    FORMATS.iter().copied().find(|f| f.extensions.contains(&extension.as_str()))
}

/// The format that some bytes look like.
pub(crate) fn by_content(bytes: &[u8]) -> Option<&'static Format> {
    FORMATS.iter().copied().find(|f| (f.detect)(bytes))
}

/// The extensions of all formats, for messages.
pub(crate) fn known_extensions() -> String {
    let all = FORMATS.iter().flat_map(|f| f.extensions);
    all.map(|e| format!(".{e}")).collect::<Vec<_>>().join(", ")
}

/// The names of the mesh formats, for messages: "PLY, OFF, STL or OBJ".
pub fn mesh_format_names() -> String {
    let is_mesh = |f: &&&Format| matches!(f.content, Content::Mesh { .. });
    let names: Vec<_> = FORMATS.iter().filter(is_mesh).map(|f| f.name).collect();
    match names.split_last() {
        Some((last, [])) => (*last).into(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
        None => String::new(),
    }
}

/// A format that keeps every bit of a mesh, and how it writes one.
pub(crate) fn lossless_mesh_format() -> Option<(&'static Format, WriteMesh)> {
    FORMATS.iter().find_map(|format| match format.content {
        Content::Mesh { write, is_lossless: true, .. } => Some((*format, write)),
        _ => None,
    })
}

/// The note of a format that holds only triangles, for a mesh that was triangulated from larger polygons.
fn lost_polygons(mesh: &TriangleMesh) -> Option<String> {
    let lost = "the numbers of the polygons that triangles were cut from are lost";
    let keeps =
        lossless_mesh_format().map_or(String::new(), |(format, _)| format!("; {} keeps them", format.name));
    (!mesh.polygons.is_empty()).then(|| format!("{lost}{keeps}"))
}

/// The note of a format that holds no attributes, for a mesh that has some.
fn lost_attributes(mesh: &TriangleMesh) -> Option<String> {
    let names: Vec<&str> = mesh.attributes.iter().map(|attribute| attribute.name.as_str()).collect();
    let keeps =
        lossless_mesh_format().map_or(String::new(), |(format, _)| format!("; {} keeps them", format.name));
    (!names.is_empty()).then(|| format!("attributes of corners are lost: {}{keeps}", names.join(", ")))
}
