//! The registry of file formats. Adding one is a file and a line here.

use std::path::Path;

use shotline::scene::{self, Node, Scene};
use shotline::solid::mesh::{TriangleMesh, Weld};

use crate::bytes::text_start;
use crate::document::{Document, Source};
use crate::error::ReadError;
use crate::fault::{At, Fault};
use crate::files::{read_regular, too_large};
use crate::format::{Content, Format, MeshFile, MeshSource};
use crate::weld::ReadOptions;
use crate::{obj, ply, scene_json, stl};

/// Every format, in the order in which contents are tried.
pub static FORMATS: &[&Format] = &[&scene_json::FORMAT, &ply::FORMAT, &stl::FORMAT, &obj::FORMAT];

/// The format of a file name ending.
pub(crate) fn by_extension(path: &Path) -> Option<&'static Format> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    FORMATS.iter().copied().find(|f| f.extensions.contains(&extension.as_str()))
}

/// The endings of all formats, for messages.
pub(crate) fn known_extensions() -> String {
    let all = FORMATS.iter().flat_map(|f| f.extensions);
    all.map(|e| format!(".{e}")).collect::<Vec<_>>().join(", ")
}

fn of_file(path: &Path, bytes: &[u8]) -> Result<&'static Format, ReadError> {
    let found = by_extension(path).or_else(|| FORMATS.iter().copied().find(|f| (f.detect)(bytes)));
    found.ok_or_else(|| {
        let unknown = Fault::file("is of no known format").help(format!("known are {}", known_extensions()));
        let fault = text_start(bytes).err().unwrap_or(unknown);
        ReadError::new(Some(path), &[], fault.into())
    })
}

/// Reads a scene, or a mesh as a scene of one object named after the file. A scene may name the mesh files below its
/// own folder.
///
/// # Errors
/// [`ReadError`] with everything that is wrong.
pub fn load(path: impl AsRef<Path>) -> Result<Document, ReadError> {
    load_with(path, ReadOptions::default())
}

/// Reads as [`load`] does, with options: the mesh files that the scene may name, and whether their vertices are welded.
///
/// # Errors
/// [`ReadError`] with everything that is wrong.
pub fn load_with(path: impl AsRef<Path>, options: impl Into<ReadOptions>) -> Result<Document, ReadError> {
    let path = path.as_ref();
    let bytes = read_regular(path, most_bytes(path))?;
    of_file(path, &bytes)?.read_with(path, bytes, options.into())
}

/// Reads bytes, such as those of standard input, as [`load_with`] reads a file; the format is found from the contents.
/// The name appears in messages and names the object of a mesh. Mesh files that a scene names are looked for in the
/// working folder.
///
/// # Errors
/// [`ReadError`] with everything that is wrong.
pub fn load_bytes(
    name: &Path,
    bytes: Vec<u8>,
    options: impl Into<ReadOptions>,
) -> Result<Document, ReadError> {
    let format = of_file(name, &bytes)?;
    if matches!(format.content, Content::Scene { .. }) && bytes.len() as u64 > scene_json::MAX_BYTES {
        return Err(ReadError::new(Some(name), &[], too_large(scene_json::MAX_BYTES).into()));
    }
    format.read_with(name, bytes, options.into())
}

impl Format {
    /// Reads bytes in this format as [`load`] does. The path need not exist: it names the object of a mesh, appears
    /// in messages, and the files that a scene names are looked for in its folder.
    ///
    /// # Errors
    /// [`ReadError`] with everything that is wrong.
    pub fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Document, ReadError> {
        self.read_with(path, bytes, ReadOptions::default())
    }

    fn read_with(&self, path: &Path, bytes: Vec<u8>, options: ReadOptions) -> Result<Document, ReadError> {
        match self.content {
            Content::Scene { read } => read(path, bytes, MeshSource::Files { read: read_mesh_file, options }),
            Content::Mesh { read, .. } => {
                let found = read(&bytes).map_err(|f| mesh_error(path, &bytes, f))?;
                Ok(mesh_document(path, found.welded(options.weld), options.weld))
            }
        }
    }
}

/// Reads a mesh.
///
/// # Errors
/// [`ReadError`] if it cannot be read, or is a scene.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<TriangleMesh, ReadError> {
    read_mesh_file(path.as_ref()).map(|found| found.mesh)
}

pub(crate) fn read_mesh_file(path: &Path) -> Result<MeshFile, ReadError> {
    let bytes = read_regular(path, most_bytes(path))?;
    match of_file(path, &bytes)?.content {
        Content::Mesh { read, .. } => read(&bytes).map_err(|f| mesh_error(path, &bytes, f)),
        Content::Scene { .. } => {
            let fault = Fault::file("is a scene, not a mesh").help("name a PLY, STL or OBJ file");
            Err(mesh_error(path, &bytes, fault))
        }
    }
}

fn mesh_error(path: &Path, bytes: &[u8], fault: Fault) -> ReadError {
    let help = match fault.at {
        At::Text(_) => "mend this line, or export the mesh again",
        At::Byte(_) | At::File => "the file may be damaged: copy it or export the mesh again",
    };
    ReadError::new(Some(path), bytes, fault.or_help(help).into())
}

fn mesh_document(path: &Path, found: MeshFile, weld: Option<Weld>) -> Document {
    let stem = path.file_stem().map_or("mesh".into(), |s| s.to_string_lossy());
    let name = path.file_name().map(|f| f.to_string_lossy().into_owned());
    let file = name.map(|name| scene::MeshFile { name, weld });
    let notes = found.notes_of(&path.display().to_string()).collect();
    let mut scene = Scene::default();
    let node = scene.add(Node::Mesh { mesh: found.mesh.into(), file });
    scene.add_object(&stem, None, node);
    Document { scene, notes, source: Source::opaque(path) }
}

/// The largest size of a file with this name.
fn most_bytes(path: &Path) -> u64 {
    match by_extension(path).map(|f| &f.content) {
        Some(Content::Scene { .. }) => scene_json::MAX_BYTES,
        _ => u64::MAX,
    }
}

/// Reads the text of a scene. Mesh files are looked for in the folder; without one, none can be named.
///
/// # Errors
/// [`ReadError`] with everything that is wrong.
pub fn parse_scene(text: impl Into<String>, folder: Option<&Path>) -> Result<Document, ReadError> {
    let meshes = MeshSource::Files { read: read_mesh_file, options: ReadOptions::default() };
    scene_json::parse(text.into(), None, folder, meshes)
}
