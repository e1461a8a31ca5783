//! What a file format declares.

use std::path::Path;
use std::sync::Arc;

use shotline::solid::mesh::TriangleMesh;

use crate::document::Document;
use crate::error::{ReadError, WriteError};
use crate::fault::Fault;
use crate::note::Note;
use crate::weld::ReadOptions;

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
    Scene { read: fn(&Path, Vec<u8>, MeshSource) -> Result<Document, ReadError> },
    /// One mesh.
    Mesh {
        read: fn(&[u8]) -> Result<MeshFile, Fault>,
        write: fn(&TriangleMesh) -> Result<Encoded, WriteError>,
    },
}

/// Where a scene may find the mesh files that it names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reach {
    /// Below its own folder, links resolved: a scene from a stranger reads nothing else.
    #[default]
    Folder,
    /// Anywhere.
    Anywhere,
}

/// Where the meshes that a scene names come from.
#[derive(Clone, Copy, Debug)]
pub(crate) enum MeshSource<'a> {
    /// Files, read whatever their format.
    Files { read: fn(&Path) -> Result<MeshFile, ReadError>, options: ReadOptions },
    /// These, named by their number.
    Given(&'a [Arc<TriangleMesh>]),
}

/// A mesh as the bytes of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Encoded {
    pub(crate) bytes: Vec<u8>,
    /// What is lost, and what else a user may want to know.
    pub(crate) notes: Vec<String>,
}

/// What a format of triangles alone loses of a mesh that was cut from larger polygons.
pub(crate) fn lost_polygons(mesh: &TriangleMesh) -> Option<String> {
    let lost = !mesh.polygons.is_empty();
    lost.then(|| "the numbers of the polygons that triangles were cut from are lost; PLY keeps them".into())
}

impl From<Vec<u8>> for Encoded {
    fn from(bytes: Vec<u8>) -> Encoded {
        Encoded { bytes, notes: Vec::new() }
    }
}

/// A mesh as read.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MeshFile {
    pub(crate) mesh: TriangleMesh,
    /// What was passed over, dropped or repaired.
    pub(crate) notes: Vec<Note>,
}

impl MeshFile {
    /// The notes, with the name of the file.
    pub(crate) fn notes_of(&self, file: &str) -> impl Iterator<Item = Note> {
        self.notes.iter().map(move |note| note.clone().of_file(file))
    }
}
