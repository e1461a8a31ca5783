//! Faces of a mesh file: checked against the number of vertices and cut into triangles.

use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;

use crate::format::MeshFile;

/// A vertex number as read: it may be anything.
pub(crate) type Corner = i64;

/// Faces being gathered.
pub(crate) struct Polygons {
    vertices: usize,
    triangles: Vec<[u32; 3]>,
    cut: usize,
}

impl Polygons {
    /// Faces between so many vertices.
    pub(crate) fn new(vertices: usize) -> Polygons {
        Polygons { vertices, triangles: Vec::new(), cut: 0 }
    }

    /// Adds a face; more than three corners are cut into a fan from the first. Vertices count from 0.
    pub(crate) fn add(&mut self, corners: &[Corner]) -> Result<(), String> {
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
        self.cut += usize::from(corners.len() > 3);
        Ok(())
    }

    /// The mesh.
    pub(crate) fn finish(self, vertices: Vec<Vec3>) -> MeshFile {
        MeshFile { mesh: TriangleMesh { vertices, faces: self.triangles }, polygons_cut: self.cut }
    }
}
