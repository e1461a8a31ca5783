//! The registry of file formats. Adding one is a file and a line here.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use shotline::scene::{Node, Scene};
use shotline::solid::mesh::TriangleMesh;

use crate::document::{Document, Source};
use crate::error::{Place, ReadError, WriteError};
use crate::fault::Fault;
use crate::{obj, ply, scene_json, stl};

/// Every format, in the order in which contents are tried.
pub static FORMATS: &[&Format] = &[&scene_json::FORMAT, &ply::FORMAT, &stl::FORMAT, &obj::FORMAT];

/// A file format.
#[derive(Debug)]
pub struct Format {
    /// Its name.
    pub name: &'static str,
    /// File name endings, without the point.
    pub extensions: &'static [&'static str],
    /// Whether some bytes look like it; asked where the ending of the file name tells nothing.
    pub detect: fn(&[u8]) -> bool,
    pub(crate) content: Content,
}

/// What a format holds.
#[derive(Debug)]
pub(crate) enum Content {
    /// Scenes.
    Scene { read: fn(&Path, Vec<u8>) -> Result<Document, ReadError> },
    /// One mesh.
    Mesh {
        read: fn(&[u8]) -> Result<MeshFile, Fault>,
        write: fn(&TriangleMesh) -> Result<Written, WriteError>,
    },
}

/// The bytes of a file, and what was lost on the way.
pub(crate) type Written = (Vec<u8>, Option<String>);

/// A mesh as read.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MeshFile {
    pub(crate) mesh: TriangleMesh,
    /// How many faces had more than three corners and were cut into triangles from their first corner.
    pub(crate) polygons_cut: usize,
}

impl MeshFile {
    /// What a user may want to know.
    pub(crate) fn note(&self) -> Option<String> {
        match self.polygons_cut {
            0 => None,
            1 => Some("1 polygon was cut into triangles".into()),
            n => Some(format!("{n} polygons were cut into triangles")),
        }
    }
}

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
        let fault = Fault::file("is of no known format").help(format!("known are {}", known_extensions()));
        ReadError::new(Some(path), &[], fault.into())
    })
}

/// Reads a scene, or a mesh as a scene of one object named after the file.
///
/// # Errors
/// [`ReadError`] with everything that is wrong.
pub fn load(path: impl AsRef<Path>) -> Result<Document, ReadError> {
    let path = path.as_ref();
    let bytes = read_regular(path)?;
    of_file(path, &bytes)?.read(path, bytes)
}

impl Format {
    /// Reads bytes in this format as [`load`] does. The path need not exist: it names the object of a mesh, appears
    /// in messages, and the files that a scene names are looked for in its folder.
    ///
    /// # Errors
    /// [`ReadError`] with everything that is wrong.
    pub fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Document, ReadError> {
        match self.content {
            Content::Scene { read } => read(path, bytes),
            Content::Mesh { read, .. } => {
                let found = read(&bytes).map_err(|f| ReadError::new(Some(path), &bytes, f.into()))?;
                Ok(mesh_document(path, found))
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
    let bytes = read_regular(path)?;
    let error = |fault: Fault| ReadError::new(Some(path), &bytes, fault.into());
    match of_file(path, &bytes)?.content {
        Content::Mesh { read, .. } => read(&bytes).map_err(error),
        Content::Scene { .. } => Err(error(Fault::file("is a scene, not a mesh"))),
    }
}

fn mesh_document(path: &Path, found: MeshFile) -> Document {
    let stem = path.file_stem().map_or("mesh".into(), |s| s.to_string_lossy());
    let file = path.file_name().map(|f| f.to_string_lossy().into_owned());
    let notes = found.note().map(|note| format!("{}: {note}", path.display())).into_iter().collect();
    let mut scene = Scene::default();
    let node = scene.add(Node::Mesh { mesh: found.mesh.into(), file });
    scene.add_object(&stem, None, node);
    Document { scene, notes, source: Source::new(Some(path), String::new(), Vec::new()) }
}

/// The bytes of a regular file: a pipe or a device could keep the reader waiting for ever.
pub(crate) fn read_regular(path: &Path) -> Result<Vec<u8>, ReadError> {
    let io = |e: std::io::Error| ReadError::io(path, &e);
    let refuse = |why: &str| Err(ReadError::new(Some(path), &[], Fault::file(why).into()));
    if !std::fs::metadata(path).map_err(io)?.is_file() {
        return refuse("is not a regular file");
    }
    let mut file = File::open(path).map_err(io)?;
    // Asked again of what was opened, in case it was exchanged in between.
    let metadata = file.metadata().map_err(io)?;
    if !metadata.is_file() {
        return refuse("is not a regular file");
    }
    let scene = by_extension(path).is_some_and(|f| matches!(f.content, Content::Scene { .. }));
    if scene && metadata.len() > scene_json::MAX_BYTES {
        return refuse(&format!("is larger than {} MiB", scene_json::MAX_BYTES >> 20));
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(io)?;
    Ok(bytes)
}

impl ReadError {
    /// The first problem on one line, for a file that another file names.
    pub(crate) fn brief(&self, file: &str) -> String {
        let Some(first) = self.problems.first() else { return file.to_string() };
        match &first.place {
            Place::Text { line, column, .. } => format!("{file}:{line}:{column}: {}", first.message),
            Place::Byte(offset) => format!("{file}: byte {offset}: {}", first.message),
            Place::File => format!("{file} {}", first.message),
        }
    }
}
