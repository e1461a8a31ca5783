//! What a file format declares.

use std::path::Path;
use std::sync::Arc;

use shotline::solid::mesh::TriangleMesh;

use crate::document::Document;
use crate::error::{ReadError, WriteError};
use crate::fault::Fault;

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
    Files { read: fn(&Path) -> Result<MeshFile, ReadError>, reach: Reach },
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

impl From<Vec<u8>> for Encoded {
    fn from(bytes: Vec<u8>) -> Encoded {
        Encoded { bytes, notes: Vec::new() }
    }
}

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
