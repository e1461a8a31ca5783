//! Meshes from arrays.

use std::sync::{Arc, OnceLock};

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use shotline::accel::DEFAULT;
use shotline::math::Vec3;
use shotline::solid::mesh::{Attribute, ClosestPoint, MeshError, MeshSolid, Topology, TriangleMesh, Weld};
use shotline_io::{Effect, mesh_of_polygons};

use crate::cancellation::batch_work;

/// Vertices and faces, checked once.
#[pyclass(frozen, module = "shotline._native")]
#[derive(Debug)]
pub struct Mesh {
    pub mesh: Arc<TriangleMesh>,
    topology: Topology,
    /// Made for the first nearest point.
    solid: OnceLock<Result<MeshSolid, MeshError>>,
    weld_note: Option<String>,
    /// What triangulating the faces changed.
    changes: Vec<String>,
}

/// Points, distances, faces, and weights of corners.
type Nearest<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray2<f64>>,
);

/// The name of an attribute, its values (k, width), and the values of the corners of each triangle, unless each vertex has one.
type GivenAttribute<'py> = (String, PyReadonlyArray2<'py, f64>, Option<PyReadonlyArray2<'py, u32>>);
type ReadAttribute<'py> = (String, Bound<'py, PyArray2<f64>>, Option<Bound<'py, PyArray2<u32>>>);

fn value_error(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

impl Mesh {
    pub fn of(mesh: Arc<TriangleMesh>) -> PyResult<Mesh> {
        let topology = Topology::of(&mesh).map_err(value_error)?;
        Ok(Mesh { mesh, topology, solid: OnceLock::new(), weld_note: None, changes: Vec::new() })
    }
}

#[pymethods]
impl Mesh {
    /// Builds a mesh from vertices of shape (n, 3) and the corners of the faces, one face after the other: three each, or
    /// as many as `sizes` says; such faces are triangulated. `polygons` holds for each triangle the number of the polygon
    /// it was cut from, `attributes` the values of vertices or corners. Finally the vertices are welded, if a distance or
    /// "auto" is given.
    #[new]
    fn new(
        py: Python,
        vertices: PyReadonlyArray2<f64>,
        corners: PyReadonlyArray1<u32>,
        sizes: Option<PyReadonlyArray1<u32>>,
        polygons: Option<PyReadonlyArray1<u32>>,
        attributes: Vec<GivenAttribute>,
        weld: Option<&str>,
    ) -> PyResult<Mesh> {
        let (points, _) = vertices.as_slice()?.as_chunks::<3>();
        if vertices.shape()[1] != 3 {
            return Err(value_error("vertices must be a C-ordered array of shape (n, 3)"));
        }
        let weld: Option<Weld> = weld.map(str::parse).transpose().map_err(value_error)?;
        let vertices: Vec<Vec3> = points.iter().map(|&p| p.into()).collect();
        let corners = corners.as_slice()?;
        let sizes = sizes.as_ref().map(|sizes| sizes.as_slice()).transpose()?;
        let polygons = polygons.map(|polygons| polygons.as_slice().map(<[u32]>::to_vec)).transpose()?;
        let attributes: Vec<Attribute> = attributes.into_iter().map(attribute).collect::<PyResult<_>>()?;
        py.detach(|| {
            let (mut mesh, changes) = match sizes {
                Some(sizes) => triangulate(vertices, corners, sizes)?,
                None => (triangles(vertices, corners)?, Vec::new()),
            };
            if let Some(polygons) = polygons {
                if polygons.len() != mesh.faces.len() {
                    return Err(value_error("polygons must have a number for each triangle"));
                }
                mesh.polygons = polygons;
            }
            if !attributes.is_empty() {
                mesh.attributes = attributes;
                mesh.check().map_err(value_error)?;
            }
            let Some(weld) = weld else { return Ok(Mesh { changes, ..Mesh::of(Arc::new(mesh))? }) };
            let had_faces = !mesh.faces.is_empty();
            let (mesh, welded) = mesh.welded(weld).map_err(value_error)?;
            if let (Weld::Within(within), true, true) = (weld, had_faces, mesh.faces.is_empty()) {
                return Err(value_error(MeshError::Collapsed { within }));
            }
            let note = shotline_io::weld_note(weld, &welded).text;
            Ok(Mesh { weld_note: Some(note), changes, ..Mesh::of(Arc::new(mesh))? })
        })
    }

    /// What triangulating the faces changed, as text.
    fn changes(&self) -> Vec<String> {
        self.changes.clone()
    }

    /// For each triangle the number of the polygon that it was cut from; None if every polygon is one triangle.
    fn polygons<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<u32>>> {
        let polygons = &self.mesh.polygons;
        (!polygons.is_empty()).then(|| polygons.clone().into_pyarray(py))
    }

    /// The attributes: the name, the values (k, width), and for each triangle the values of its corners, 4294967295 for none;
    /// None in place of these where value i is that of vertex i.
    fn attributes<'py>(&self, py: Python<'py>) -> PyResult<Vec<ReadAttribute<'py>>> {
        let read = |attribute: &Attribute| {
            let values = attribute.values.clone().into_pyarray(py);
            let corners = attribute
                .corners
                .as_ref()
                .map(|corners| corners.concat().into_pyarray(py).reshape([corners.len(), 3]));
            let values = values.reshape([attribute.rows(), attribute.width])?;
            Ok((attribute.name.clone(), values, corners.transpose()?))
        };
        self.mesh.attributes.iter().map(read).collect()
    }

    /// What welding did, as text.
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

    /// The numbers of vertices and faces.
    fn counts(&self) -> (usize, usize) {
        (self.mesh.vertices.len(), self.mesh.faces.len())
    }

    fn is_closed(&self) -> bool {
        self.topology.is_closed()
    }

    /// The nearest points of the mesh to points of shape (n, 3): their coordinates (n, 3), distances (n), faces (n), int32,
    /// and the weights of the corners (n, 3). NaN, infinity and -1 for points that have none.
    fn closest_points<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<f64>,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Nearest<'py>> {
        let (rows, _) = points.as_slice()?.as_chunks::<3>();
        let found = batch_work(py, rows.len(), threads, progress.as_ref(), |run| {
            let make = || MeshSolid::new(self.mesh.clone(), DEFAULT);
            let solid = self.solid.get_or_init(make).as_ref().map_err(ToString::to_string)?;
            let report = |steps| run.progress.iter().for_each(|progress| progress(steps));
            solid.closest_points(rows, run.threads, run.cancel, &report).map_err(|e| e.to_string())
        })?;
        let found = found.map_err(value_error)?;
        let vector = |get: fn(&ClosestPoint) -> [f64; 3]| {
            let numbers: Vec<f64> =
                found.iter().flat_map(|f| f.as_ref().map_or([f64::NAN; 3], get)).collect();
            numbers.into_pyarray(py).reshape([found.len(), 3])
        };
        let distances: Vec<f64> = found.iter().map(|f| f.map_or(f64::INFINITY, |f| f.distance)).collect();
        let faces: Vec<i32> = found.iter().map(|f| f.map_or(-1, |f| f.face as i32)).collect();
        let points = vector(|f| f.point.to_array())?;
        let weights = vector(|f| f.barycentric)?;
        Ok((points, distances.into_pyarray(py), faces.into_pyarray(py), weights))
    }

    /// Why the mesh is not closed; None if it is.
    fn why_open(&self) -> Option<String> {
        (!self.topology.is_closed()).then(|| self.topology.why_open())
    }
}

fn attribute((name, values, corners): GivenAttribute) -> PyResult<Attribute> {
    let width = values.shape()[1];
    let corners = match &corners {
        Some(corners) if corners.shape()[1] == 3 => Some(corners.as_slice()?.as_chunks::<3>().0.to_vec()),
        Some(_) => return Err(value_error("the corners of an attribute must have shape (m, 3)")),
        None => None,
    };
    Ok(Attribute { name, width, values: values.as_slice()?.to_vec(), corners })
}

fn triangles(vertices: Vec<Vec3>, corners: &[u32]) -> PyResult<TriangleMesh> {
    let (faces, rest) = corners.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(value_error("faces must have three corners each"));
    }
    Ok(TriangleMesh::new(vertices, faces.to_vec()))
}

/// Triangulates faces with the given numbers of corners; also returns what that changed.
fn triangulate(vertices: Vec<Vec3>, corners: &[u32], sizes: &[u32]) -> PyResult<(TriangleMesh, Vec<String>)> {
    if sizes.iter().map(|size| u64::from(*size)).sum::<u64>() != corners.len() as u64 {
        return Err(value_error("the sizes of the faces must add up to the number of corners"));
    }
    let mut rest = corners;
    let faces = sizes.iter().map(|size| {
        let (face, after) = rest.split_at(*size as usize);
        rest = after;
        face
    });
    let (mesh, notes) = mesh_of_polygons(vertices, faces).map_err(value_error)?;
    let changes = notes.iter().filter(|note| note.effect == Effect::Changed).map(ToString::to_string);
    Ok((mesh, changes.collect()))
}
