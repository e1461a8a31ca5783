//! Triangles from arrays.

use std::sync::Arc;

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use shotline::math::Vec3;
use shotline::solid::mesh::{MeshError, Topology, TriangleMesh, Weld};
use shotline_io::{Effect, mesh_of_polygons};

/// Vertices and faces, checked once.
#[pyclass(frozen, module = "shotline._native")]
#[derive(Debug)]
pub struct Mesh {
    pub mesh: Arc<TriangleMesh>,
    topology: Topology,
    weld_note: Option<String>,
    /// What was changed when faces were cut into triangles.
    changes: Vec<String>,
}

fn wrong(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

impl Mesh {
    pub fn of(mesh: Arc<TriangleMesh>) -> PyResult<Mesh> {
        let topology = Topology::of(&mesh).map_err(wrong)?;
        Ok(Mesh { mesh, topology, weld_note: None, changes: Vec::new() })
    }
}

#[pymethods]
impl Mesh {
    /// From vertices of shape (n, 3) and the corners of the faces, one face after the other: three each, or as many as
    /// `sizes` says, and then the faces are cut into triangles. `polygons` numbers the polygons that triangles were cut
    /// from. The vertices are welded at the end, if a distance or "auto" is given.
    #[new]
    fn new(
        py: Python,
        vertices: PyReadonlyArray2<f64>,
        corners: PyReadonlyArray1<u32>,
        sizes: Option<PyReadonlyArray1<u32>>,
        polygons: Option<PyReadonlyArray1<u32>>,
        weld: Option<&str>,
    ) -> PyResult<Mesh> {
        let (points, _) = vertices.as_slice()?.as_chunks::<3>();
        if vertices.shape()[1] != 3 {
            return Err(wrong("vertices must be a C-ordered array of shape (n, 3)"));
        }
        let weld: Option<Weld> = weld.map(str::parse).transpose().map_err(wrong)?;
        let vertices: Vec<Vec3> = points.iter().map(|&p| p.into()).collect();
        let corners = corners.as_slice()?;
        let sizes = sizes.as_ref().map(|sizes| sizes.as_slice()).transpose()?;
        let polygons = polygons.map(|polygons| polygons.as_slice().map(<[u32]>::to_vec)).transpose()?;
        py.detach(|| {
            let (mut mesh, changes) = match sizes {
                Some(sizes) => cut(vertices, corners, sizes)?,
                None => (triangles(vertices, corners)?, Vec::new()),
            };
            if let Some(polygons) = polygons {
                if polygons.len() != mesh.faces.len() {
                    return Err(wrong("polygons must have a number for each triangle"));
                }
                mesh.polygons = polygons;
            }
            let Some(weld) = weld else { return Ok(Mesh { changes, ..Mesh::of(Arc::new(mesh))? }) };
            let had_faces = !mesh.faces.is_empty();
            let (mesh, welded) = mesh.welded(weld).map_err(wrong)?;
            if let (Weld::Within(within), true, true) = (weld, had_faces, mesh.faces.is_empty()) {
                return Err(wrong(MeshError::Collapsed { within }));
            }
            let note = shotline_io::weld_note(weld, &welded).text;
            Ok(Mesh { weld_note: Some(note), changes, ..Mesh::of(Arc::new(mesh))? })
        })
    }

    /// What was changed when faces were cut into triangles, in words.
    fn changes(&self) -> Vec<String> {
        self.changes.clone()
    }

    /// For each triangle the number of the polygon that it was cut from; None where these are the numbers of the triangles.
    fn polygons<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<u32>>> {
        let polygons = &self.mesh.polygons;
        (!polygons.is_empty()).then(|| polygons.clone().into_pyarray(py))
    }

    /// What welding did, in words.
    fn weld_note(&self) -> Option<&str> {
        self.weld_note.as_deref()
    }

    /// The vertices, a copy.
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let flat: Vec<f64> = self.mesh.vertices.iter().flat_map(|v| v.to_array()).collect();
        flat.into_pyarray(py).reshape([self.mesh.vertices.len(), 3])
    }

    /// The faces, a copy.
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        self.mesh.faces.concat().into_pyarray(py).reshape([self.mesh.faces.len(), 3])
    }

    /// How many vertices and faces there are.
    fn counts(&self) -> (usize, usize) {
        (self.mesh.vertices.len(), self.mesh.faces.len())
    }

    fn is_closed(&self) -> bool {
        self.topology.is_closed()
    }

    /// Why it is not closed.
    fn why_open(&self) -> Option<String> {
        (!self.topology.is_closed()).then(|| self.topology.why_open())
    }
}

fn triangles(vertices: Vec<Vec3>, corners: &[u32]) -> PyResult<TriangleMesh> {
    let (faces, rest) = corners.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(wrong("faces must have three corners each"));
    }
    Ok(TriangleMesh::new(vertices, faces.to_vec()))
}

/// Triangles cut from faces of so many corners, with what was changed.
fn cut(vertices: Vec<Vec3>, corners: &[u32], sizes: &[u32]) -> PyResult<(TriangleMesh, Vec<String>)> {
    if sizes.iter().map(|size| u64::from(*size)).sum::<u64>() != corners.len() as u64 {
        return Err(wrong("the sizes of the faces must add up to the number of corners"));
    }
    let mut rest = corners;
    let faces = sizes.iter().map(|size| {
        let (face, after) = rest.split_at(*size as usize);
        rest = after;
        face
    });
    let (mesh, notes) = mesh_of_polygons(vertices, faces).map_err(wrong)?;
    let changes = notes.iter().filter(|note| note.effect == Effect::Changed).map(ToString::to_string);
    Ok((mesh, changes.collect()))
}
