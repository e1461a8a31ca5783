//! Meshes as readers return them and as writers encode them.

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
