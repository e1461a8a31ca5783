//! Faces of a mesh file: checked against the number of vertices and cut into triangles.

use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;

use crate::fault::At;
use crate::format::MeshFile;
use crate::note::{Effect, NoteKind, Notes};

/// A vertex number as read: it may be anything.
pub(crate) type Corner = i64;

const CUT: NoteKind = NoteKind {
    name: "polygons_cut",
    effect: Effect::Kept,
    one: "1 polygon was cut into triangles",
    many: "# polygons were cut into triangles",
};

/// Faces being gathered.
pub(crate) struct Polygons {
    vertices: usize,
    triangles: Vec<[u32; 3]>,
    notes: Notes,
}

impl Polygons {
    /// Faces between so many vertices.
    pub(crate) fn new(vertices: usize, notes: Notes) -> Polygons {
        Polygons { vertices, triangles: Vec::new(), notes }
    }

    /// Adds a face; more than three corners are cut into a fan from the first. Vertices count from 0.
    pub(crate) fn add(&mut self, corners: &[Corner], at: At) -> Result<(), String> {
        let [first, middle @ .., _] = corners else { return Err("has no corners".into()) };
        if middle.is_empty() {
            return Err(format!("has only {} corners", corners.len()));
        }
        let vertex = |corner: Corner| {
            let inside = usize::try_from(corner).is_ok_and(|c| c < self.vertices);
            let number = u32::try_from(corner).ok().filter(|_| inside);
            number.ok_or_else(|| format!("names vertex {corner}, but there are {}", self.vertices))
        };
        let first = vertex(*first)?;
        for pair in corners[1..].windows(2) {
            self.triangles.push([first, vertex(pair[0])?, vertex(pair[1])?]);
        }
        if corners.len() > 3 {
            self.notes.add(&CUT, at);
        }
        Ok(())
    }

    /// The mesh, of a file of these bytes.
    pub(crate) fn finish(self, vertices: Vec<Vec3>, bytes: &[u8]) -> MeshFile {
        MeshFile { mesh: TriangleMesh::new(vertices, self.triangles), notes: self.notes.finish(bytes) }
    }
}
