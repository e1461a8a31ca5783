//! Mesh files named by a scene: found below the scene's folder, read once each.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use shotline::solid::mesh::TriangleMesh;

use crate::format::{MeshSource, Reach};

/// The meshes of one scene.
pub(super) struct MeshFiles {
    folder: Option<PathBuf>,
    source: MeshSource,
    read: HashMap<PathBuf, Result<Arc<TriangleMesh>, Refusal>>,
    /// What a user may want to know about the files.
    pub(super) notes: Vec<String>,
}

/// Why a mesh file is not used.
#[derive(Clone, Debug)]
pub(super) struct Refusal {
    pub(super) why: String,
    pub(super) help: String,
}

fn refuse<T>(why: impl Into<String>, help: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal { why: why.into(), help: help.into() })
}

impl MeshFiles {
    /// Files named relative to a folder; without one there are none.
    pub(super) fn of(folder: Option<&Path>, source: MeshSource) -> MeshFiles {
        MeshFiles { folder: folder.map(Into::into), source, read: HashMap::new(), notes: Vec::new() }
    }

    /// The mesh of a file named as in the scene.
    pub(super) fn load(&mut self, file: &str) -> Result<Arc<TriangleMesh>, Refusal> {
        let path = self.found(file)?;
        if let Some(known) = self.read.get(&path) {
            return known.clone();
        }
        let mesh = match (self.source.read)(&path) {
            Ok(found) => {
                self.notes.extend(found.note().map(|note| format!("{file}: {note}")));
                Ok(Arc::new(found.mesh))
            }
            Err(error) => refuse(
                format!("this mesh cannot be read: {}", error.brief(file)),
                "mend the file or name another one",
            ),
        };
        self.read.insert(path, mesh.clone());
        mesh
    }

    /// The file's true path, links resolved, if it lies within reach.
    fn found(&self, file: &str) -> Result<PathBuf, Refusal> {
        const INSIDE: &str = "copy it into the folder of the scene file and name it relative to that; \
                              or, if you trust the scene, allow it: --allow-outside, Reach::Anywhere";
        let Some(folder) = &self.folder else {
            return refuse(
                "this scene has no folder in which to look for files",
                "read the scene from a file",
            );
        };
        let confined = self.source.reach == Reach::Folder;
        let drive = file.as_bytes().get(1) == Some(&b':') && file.as_bytes()[0].is_ascii_alphabetic();
        if confined && (drive || file.starts_with(['/', '\\']) || Path::new(file).is_absolute()) {
            return refuse("the path of this file is absolute", INSIDE);
        }
        let found = folder.canonicalize().and_then(|f| Ok((folder.join(file).canonicalize()?, f)));
        match found {
            Err(error) => {
                refuse(format!("'{file}' cannot be opened: {error}"), "paths are relative to the scene file")
            }
            Ok((path, folder)) if confined && !path.starts_with(&folder) => {
                refuse("this file lies outside of the scene's folder", INSIDE)
            }
            Ok((path, _)) => Ok(path),
        }
    }
}
