//! The meshes that a scene names: files below its folder, each read once, or meshes in memory.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use shotline::scene;
use shotline::solid::mesh::{TriangleMesh, Weld};

use crate::error::ReadError;
use crate::format::MeshSource;
use crate::mesh_file::MeshFile;
use crate::note::Note;
use crate::options::ReadOptions;
use crate::paths::{Refusal, resolve};

/// The meshes of one scene.
pub(super) enum Meshes<'a> {
    Files(MeshFiles),
    /// Meshes in memory, named by their index.
    Given(&'a [Arc<TriangleMesh>]),
}

impl<'a> Meshes<'a> {
    /// File names are relative to the folder; without one the scene can name no files.
    pub(super) fn of(folder: Option<&Path>, source: MeshSource<'a>) -> Meshes<'a> {
        match source {
            MeshSource::Given(meshes) => Meshes::Given(meshes),
            MeshSource::Files { read, options } => Meshes::Files(MeshFiles {
                folder: folder.map(Into::into),
                reader: read,
                options: options.clone(),
                read: HashMap::new(),
                notes: Vec::new(),
            }),
        }
    }

    /// The mesh that a node names, welded if the node says so.
    pub(super) fn load(&mut self, name: &str, weld: Option<Weld>) -> Result<Arc<TriangleMesh>, Refusal> {
        match self {
            Meshes::Files(files) => files.load(name, weld),
            Meshes::Given(meshes) => {
                let mesh = name.parse().ok().and_then(|i: usize| meshes.get(i).cloned());
                let welded = |mesh: Arc<TriangleMesh>| match weld.map(|weld| mesh.welded(weld)) {
                    Some(Ok((welded, _))) => Arc::new(welded),
                    _ => mesh,
                };
                mesh.map(welded).ok_or_else(|| Refusal {
                    why: format!("there is no mesh '{name}'"),
                    help: format!("{} meshes are given, and named by their numbers from 0", meshes.len()),
                })
            }
        }
    }

    /// The file of a mesh, if it has one, and how the mesh was welded.
    pub(super) fn file(&self, name: &str, weld: Option<Weld>) -> Option<scene::MeshFile> {
        let Meshes::Files(files) = self else { return None };
        Some(scene::MeshFile { name: name.to_owned(), weld: files.weld(weld) })
    }

    /// The notes of all files read.
    pub(super) fn into_notes(self) -> Vec<Note> {
        if let Meshes::Files(files) = self { files.notes } else { Vec::new() }
    }
}

/// Mesh files.
pub(super) struct MeshFiles {
    folder: Option<PathBuf>,
    reader: fn(&Path) -> Result<MeshFile, ReadError>,
    options: ReadOptions,
    /// By path and by how the mesh is welded.
    read: HashMap<(PathBuf, Option<u64>), Result<Arc<TriangleMesh>, Refusal>>,
    notes: Vec<Note>,
}

fn refuse<T>(why: impl Into<String>, help: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal::new(why, help))
}

impl MeshFiles {
    /// The mesh of a file, by its name in the scene.
    fn load(&mut self, file: &str, weld: Option<Weld>) -> Result<Arc<TriangleMesh>, Refusal> {
        let weld = self.weld(weld);
        // `u64::MAX` are the bits of a NaN, which no distance has.
        let bits =
            weld.map(|weld| if let Weld::Within(distance) = weld { distance.to_bits() } else { u64::MAX });
        let path = self.resolve(file)?;
        let key = (path, bits);
        if let Some(known) = self.read.get(&key) {
            return known.clone();
        }
        let mesh = match (self.reader)(&key.0) {
            Ok(found) => {
                let found = found.welded(weld);
                self.notes.extend(found.notes_of(file));
                Ok(Arc::new(found.mesh))
            }
            Err(error) => refuse(
                format!("this mesh cannot be read: {}", error.brief(file)),
                "mend the file or name another one",
            ),
        };
        self.read.insert(key, mesh.clone());
        mesh
    }

    /// How to weld a mesh: as its node says, or else as the options say.
    fn weld(&self, of_node: Option<Weld>) -> Option<Weld> {
        of_node.or(self.options.weld)
    }

    /// The path of a file, links resolved, if the path policy allows it.
    fn resolve(&self, file: &str) -> Result<PathBuf, Refusal> {
        match &self.folder {
            Some(folder) => resolve(folder, folder, file, self.options.paths),
            None => {
                refuse("this scene has no folder in which to look for files", "read the scene from a file")
            }
        }
    }
}
