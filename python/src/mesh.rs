//! Triangles from arrays.

use std::sync::Arc;

use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use shotline::solid::mesh::{Topology, TriangleMesh};

/// Vertices and faces, checked once.
#[pyclass(frozen, module = "shotline._native")]
#[derive(Debug)]
pub struct Mesh {
    pub mesh: Arc<TriangleMesh>,
    topology: Topology,
}

impl Mesh {
    pub fn of(mesh: Arc<TriangleMesh>) -> PyResult<Mesh> {
        let topology = Topology::of(&mesh).map_err(|e| PyValueError::new_err(e.to_string()))?;
        Ok(Mesh { mesh, topology })
    }
}

#[pymethods]
impl Mesh {
    /// From arrays of shape (n, 3) and (m, 3), in C order.
    #[new]
    fn new(vertices: PyReadonlyArray2<f64>, faces: PyReadonlyArray2<u32>) -> PyResult<Mesh> {
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
        Mesh::of(Arc::new(TriangleMesh::new(vertices, corners.to_vec())))
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
