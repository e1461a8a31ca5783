//! Reads scenes and meshes, whatever their format.

use std::path::Path;

use shotline::scene::{self, Node, Scene};
use shotline::solid::mesh::TriangleMesh;

use crate::bytes::text_start;
use crate::diagnostic::RawDiagnostic;
use crate::document::{Document, Source};
use crate::error::ReadError;
use crate::files::{read_regular, too_large};
use crate::format::{
    Content, Format, MeshSource, by_content, by_extension, known_extensions, mesh_format_names, scene_json,
};
use crate::location::RawLocation;
use crate::material_files::{NamedMaterials, materials_of};
use crate::mesh_file::MeshFile;
use crate::note::Note;
use crate::options::ReadOptions;
use crate::parts::{Part, parts};

/// Reads a scene, or a mesh file as a scene: of one object named after the file, or of the objects, groups and materials that
/// the file names, where each bounds a solid of its own. A scene may name the mesh files below its own folder.
///
/// # Errors
/// [`ReadError`] with everything that is wrong.
pub fn load(path: impl AsRef<Path>) -> Result<Document, ReadError> {
    load_with(path, ReadOptions::default())
}

/// Reads as [`load`] does, with options: which mesh files the scene may name, and whether their vertices are welded.
///
/// # Errors
/// [`ReadError`] with everything that is wrong.
pub fn load_with(path: impl AsRef<Path>, options: impl Into<ReadOptions>) -> Result<Document, ReadError> {
    let path = path.as_ref();
    let bytes = read_regular(path, max_bytes(path))?;
    format_of(path, &bytes)?.read_with(path, bytes, options.into())
}

/// Reads bytes, such as those of standard input, as [`load_with`] reads a file; the contents determine the format.
/// The name appears in messages and names the object of a mesh. Mesh files that a scene names are looked up in the
/// working folder.
///
/// # Errors
/// [`ReadError`] with everything that is wrong.
pub fn load_bytes(
    name: &Path,
    bytes: Vec<u8>,
    options: impl Into<ReadOptions>,
) -> Result<Document, ReadError> {
    let format = format_of(name, &bytes)?;
    if let Content::Scene { max_bytes, .. } = format.content
        && bytes.len() as u64 > max_bytes
    {
        return Err(ReadError::new(Some(name), &[], too_large(max_bytes).into()));
    }
    format.read_with(name, bytes, options.into())
}

/// Reads a mesh.
///
/// # Errors
/// [`ReadError`] if it cannot be read, or is a scene.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<TriangleMesh, ReadError> {
    read_mesh_file(path.as_ref()).map(|found| found.mesh)
}

/// Reads the text of a scene. Mesh files are looked up in the folder; without one, the scene can name none.
///
/// # Errors
/// [`ReadError`] with everything that is wrong.
pub fn parse_scene(text: impl Into<String>, folder: Option<&Path>) -> Result<Document, ReadError> {
    let meshes = MeshSource::Files { read: read_mesh_file, options: &ReadOptions::default() };
    scene_json::parse(text.into(), None, folder, meshes)
}

impl Format {
    /// Reads bytes in this format as [`load`] does. The path need not exist: it names the object of a mesh, appears
    /// in messages, and its folder is where the files that a scene names are looked up.
    ///
    /// # Errors
    /// [`ReadError`] with everything that is wrong.
    pub fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Document, ReadError> {
        self.read_with(path, bytes, ReadOptions::default())
    }

    fn has_setups(&self) -> bool {
        matches!(self.content, Content::Scene { has_setups: true, .. })
    }

    fn read_with(&self, path: &Path, bytes: Vec<u8>, options: ReadOptions) -> Result<Document, ReadError> {
        if let (Some(setup), false) = (&options.setup, self.has_setups()) {
            let message = format!("has no setup '{setup}': a {} file has no setups", self.name);
            let diagnostic = RawDiagnostic::file(message).help("leave the setup out");
            return Err(ReadError::new(Some(path), &[], diagnostic.into()));
        }
        match self.content {
            Content::Scene { read, .. } => {
                read(path, bytes, MeshSource::Files { read: read_mesh_file, options: &options })
            }
            Content::Mesh { read, .. } => {
                let found = read(&bytes).map_err(|d| mesh_error(path, &bytes, d))?;
                Ok(mesh_document(path, found.welded(options.weld), &options))
            }
        }
    }
}

pub(crate) fn read_mesh_file(path: &Path) -> Result<MeshFile, ReadError> {
    let bytes = read_regular(path, max_bytes(path))?;
    match format_of(path, &bytes)?.content {
        Content::Mesh { read, .. } => read(&bytes).map_err(|d| mesh_error(path, &bytes, d)),
        Content::Scene { .. } => {
            let help = format!("name a {} file", mesh_format_names());
            let diagnostic = RawDiagnostic::file("is a scene, not a mesh").help(help);
            Err(mesh_error(path, &bytes, diagnostic))
        }
    }
}

/// The format of a file: by its name, or else by its contents.
fn format_of(path: &Path, bytes: &[u8]) -> Result<&'static Format, ReadError> {
    by_extension(path).or_else(|| by_content(bytes)).ok_or_else(|| {
        let help = format!("known are {}", known_extensions());
        let unknown = RawDiagnostic::file("is of no known format").help(help);
        let diagnostic = text_start(bytes).err().unwrap_or(unknown);
        ReadError::new(Some(path), &[], diagnostic.into())
    })
}

fn mesh_error(path: &Path, bytes: &[u8], diagnostic: RawDiagnostic) -> ReadError {
    let help = match diagnostic.location {
        RawLocation::Text(_) => "mend this line, or export the mesh again",
        RawLocation::Byte(_) | RawLocation::File => {
            "the file may be damaged: copy it or export the mesh again"
        }
    };
    ReadError::new(Some(path), bytes, diagnostic.or_help(help).into())
}

/// A scene of the objects of a mesh file.
fn mesh_document(path: &Path, found: MeshFile, options: &ReadOptions) -> Document {
    let stem = path.file_stem().map_or("mesh".into(), |s| s.to_string_lossy());
    let name = path.file_name().map(|f| f.to_string_lossy().into_owned());
    let NamedMaterials { materials, notes: not_read, files } =
        materials_of(path, &found.material_files, options.paths);
    let shown = path.display().to_string();
    let mut notes: Vec<Note> = found.notes_of(&shown).collect();
    let (parts, of_parts) = parts(found, &stem);
    notes.extend(not_read.into_iter().chain(of_parts).map(|note| note.of_file(&shown)));
    // Only a mesh that is the whole file can be read from it again.
    let file = name.filter(|_| parts.len() == 1).map(|name| scene::MeshFile { name, weld: options.weld });
    let mut scene = Scene::default();
    for Part { name, material, mesh } in parts {
        let node = scene.add(Node::Mesh { mesh: mesh.into(), file: file.clone() });
        scene.add_object(&name, material.as_deref(), node);
        if let Some(name) = material.filter(|name| scene.materials.iter().all(|(known, _)| known != name)) {
            let material = materials.get(&name).cloned().unwrap_or_default();
            scene.materials.push((name, material));
        }
    }
    Document { scene, notes, source: Source::opaque(path).with_files(files) }
}

/// The largest size of a file with this name.
fn max_bytes(path: &Path) -> u64 {
    match by_extension(path).map(|f| &f.content) {
        Some(Content::Scene { max_bytes, .. }) => *max_bytes,
        _ => u64::MAX,
    }
}
