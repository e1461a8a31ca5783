//! Triangles from arrays.

use std::sync::Arc;

use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use shotline::solid::mesh::{Topology, TriangleMesh, Weld};

/// Vertices and faces, checked once.
#[pyclass(frozen, module = "shotline._native")]
#[derive(Debug)]
pub struct Mesh {
    pub mesh: Arc<TriangleMesh>,
    topology: Topology,
    weld_note: Option<String>,
}

impl Mesh {
    pub fn of(mesh: Arc<TriangleMesh>) -> PyResult<Mesh> {
        let topology = Topology::of(&mesh).map_err(|e| PyValueError::new_err(e.to_string()))?;
        Ok(Mesh { mesh, topology, weld_note: None })
    }
}

#[pymethods]
impl Mesh {
    /// From arrays of shape (n, 3) and (m, 3), in C order.
    /// The vertices are welded first, if a distance or "auto" is given.
    #[new]
    fn new(
        vertices: PyReadonlyArray2<f64>,
        faces: PyReadonlyArray2<u32>,
        weld: Option<&str>,
    ) -> PyResult<Mesh> {
        let bad =
            |what: &str| PyValueError::new_err(format!("{what} must be a C-ordered array of shape (n, 3)"));
        let (points, _) = vertices.as_slice()?.as_chunks::<3>();
        let (corners, _) = faces.as_slice()?.as_chunks::<3>();
        if vertices.shape()[1] != 3 {
            return Err(bad("vertices"));
        }
        if faces.shape()[1] != 3 {
            return Err(bad("faces"));
        }
        let vertices = points.iter().map(|&p| p.into()).collect();
        let mesh = TriangleMesh::new(vertices, corners.to_vec());
        let wrong = |error: &dyn std::fmt::Display| PyValueError::new_err(error.to_string());
        let Some(weld) = weld else { return Mesh::of(Arc::new(mesh)) };
        let weld: Weld = weld.parse().map_err(|e| wrong(&e))?;
        let (mesh, welded) = mesh.welded(weld).map_err(|e| wrong(&e))?;
        let note = shotline_io::weld_note(weld, &welded).text;
        Ok(Mesh { weld_note: Some(note), ..Mesh::of(Arc::new(mesh))? })
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
