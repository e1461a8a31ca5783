//! Meshes as readers return them and as writers encode them.

use std::ops::Range;

use shotline::solid::mesh::{TriangleMesh, Weld};

use crate::note::Note;
use crate::weld::weld_note;

/// Faces of a file that belong together: those from a polygon on, up to the next section.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Section {
    /// The number of the first polygon.
    pub(crate) first: u32,
    /// The name of the object; empty if it has none.
    pub(crate) name: String,
    /// The name of the material; empty if it has none.
    pub(crate) material: String,
}

/// A mesh as read.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MeshFile {
    pub(crate) mesh: TriangleMesh,
    /// The objects and materials of its faces, by the number of the first polygon; empty if the file has none.
    pub(crate) sections: Vec<Section>,
    /// The names of the files that define the materials.
    pub(crate) material_files: Vec<String>,
    /// What was skipped, dropped or repaired.
    pub(crate) notes: Vec<Note>,
}

impl MeshFile {
    /// The notes, with the name of the file.
    pub(crate) fn notes_of(&self, file: &str) -> impl Iterator<Item = Note> {
        self.notes.iter().map(move |note| note.clone().of_file(file))
    }

    /// The mesh with vertices welded, and a note of what that did.
    pub(crate) fn welded(mut self, weld: Option<Weld>) -> MeshFile {
        let Some(weld) = weld else { return self };
        // A mesh that cannot be welded is not valid; the compiler reports it, with the node that uses it.
        if let Ok((mesh, welded)) = self.mesh.welded(weld) {
            self.mesh = mesh;
            self.notes.push(weld_note(weld, &welded));
        }
        self
    }
}

/// Faces that belong to an object, up to those of the next.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ObjectFaces {
    /// The first face.
    pub(crate) first: usize,
    pub(crate) name: String,
    pub(crate) material: Option<String>,
}

/// A mesh to be written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NamedMesh<'a> {
    pub(crate) mesh: &'a TriangleMesh,
    /// The objects of its faces, in ascending order; names may stand several times. None if the mesh is no scene.
    pub(crate) objects: &'a [ObjectFaces],
    /// The name of the file that defines the materials.
    pub(crate) materials_file: Option<&'a str>,
}

impl<'a> NamedMesh<'a> {
    /// A mesh by itself.
    pub(crate) fn unnamed(mesh: &'a TriangleMesh) -> NamedMesh<'a> {
        NamedMesh { mesh, objects: &[], materials_file: None }
    }

    /// The faces of each object, by their numbers. Without objects, all faces belong to one that is `None`.
    pub(crate) fn runs(&self) -> Vec<(Option<&'a ObjectFaces>, Range<usize>)> {
        let ends = self.objects.iter().skip(1).map(|next| next.first).chain([self.mesh.faces.len()]);
        match self.objects {
            [] => vec![(None, 0..self.mesh.faces.len())],
            objects => {
                objects.iter().zip(ends).map(|(object, end)| (Some(object), object.first..end)).collect()
            }
        }
    }
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
