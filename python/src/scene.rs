//! A compiled scene.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyReadonlyArrayDyn};
use pyo3::exceptions::{PyIndexError, PyMemoryError, PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use shotline::accel;
use shotline::compile::{DynamicWorld, Options, SceneError, World, compile};
use shotline::counters::COUNTERS;
use shotline::math::Affine;
use shotline::query::batch::{
    self, BatchError, By, ClosestRows, CrossingRows, Fields, ObjectRows, Points, Run, SegmentRows,
};
use shotline::query::{Kinds, Overlaps, QueryError, Scope};
use shotline::ray::Span;
use shotline::scene::{Node, NodeId, Units};
use shotline::solid::mesh::WeldError;
use shotline_io::{Diagnostic, Document, Effect, Packed, PathPolicy, ReadOptions, Source, WriteError};

use crate::cancellation::batch_work;
use crate::hits::HitRows;
use crate::mesh::Mesh;
use crate::rays::{PointRows, RayRows};
use crate::tessellation::tessellated;

/// A number of rows.
type Rows<'py> = Bound<'py, PyArray2<f64>>;

/// A scene and its world; immutable.
#[pyclass(frozen, module = "shotline._native")]
#[derive(Debug)]
pub struct Scene {
    pub scene: Arc<shotline::scene::Scene>,
    pub world: Arc<World>,
    options: Options,
    /// The incrementally compiled scene, from which scenes with a moved node are made; built on first use.
    dynamic: OnceLock<DynamicWorld>,
}

/// The `RayQuery` of the Python half, read by attribute.
#[derive(FromPyObject)]
struct RayQuery<'py> {
    ray_count: usize,
    origins: PyReadonlyArrayDyn<'py, f64>,
    directions: Option<PyReadonlyArrayDyn<'py, f64>>,
    t_min: f64,
    t_max: f64,
    surfaces_only: bool,
    threads: usize,
    progress: Option<Py<PyAny>>,
    fields: Option<Vec<String>>,
}

impl RayQuery<'_> {
    /// The columns that are needed. `t` and the splits are not among [`Fields`]: they are always there.
    fn fields(&self) -> Fields {
        let Some(fields) = &self.fields else { return Fields::ALL };
        fields.iter().filter_map(|name| Fields::named(name)).fold(Fields::NONE, |all, column| all | column)
    }

    /// Runs a query over all rays.
    fn run<T: Send>(
        &self,
        py: Python,
        query: impl FnOnce(&RayRows, Scope, Run) -> Result<T, BatchError> + Send,
    ) -> PyResult<T> {
        let RayQuery { ray_count: count, origins, directions, threads, progress, .. } = self;
        let span = Span::new(self.t_min, self.t_max).map_err(|e| PyValueError::new_err(e.to_string()))?;
        let kinds = if self.surfaces_only { Kinds::Surfaces } else { Kinds::All };
        let scope = Scope { span, kinds };
        let rays = RayRows::new(*count, origins, directions.as_ref())?;
        let fields = self.fields();
        batch_work(py, *count, *threads, progress.as_ref(), |run| query(&rays, scope, Run { fields, ..run }))?
            .map_err(batch_error)
    }
}

/// The exception of a failed batch.
fn batch_error(error: BatchError) -> PyErr {
    if error == BatchError::OutOfMemory {
        return PyMemoryError::new_err(format!("{error}; cast fewer rays at a time"));
    }
    let message = match &error {
        BatchError::TooMany { .. } => {
            format!("{error}; cast fewer rays at a time, or ask for closest or count")
        }
        BatchError::World(inner) | BatchError::Query { error: inner, .. } => {
            format!("{error}; {}", help(inner))
        }
        _ => error.to_string(),
    };
    match &error {
        BatchError::Ray { row, .. } | BatchError::Point { row } | BatchError::Query { row, .. } => {
            row_error(*row, message)
        }
        _ => PyValueError::new_err(message),
    }
}

/// A ValueError about one row, whose number is its attribute `row`.
fn row_error(row: usize, message: String) -> PyErr {
    let error = PyValueError::new_err(message);
    // Python exceptions accept any attribute; if this one does not, the message still names the row.
    let _ = Python::attach(|py| error.value(py).setattr("row", row));
    error
}

/// The errors of a scene that was made in Python. They name objects instead of locations, since the user never saw the
/// text of the scene.
fn scene_error(scene: &shotline::scene::Scene, errors: Vec<SceneError>) -> PyErr {
    let line = |error: SceneError| {
        let owner = error.node.and_then(|node| object_around(scene, node));
        let message = match owner {
            // Some messages begin with the object already.
            Some(name) if !error.message.contains(name) => format!("object '{name}': {}", error.message),
            _ => error.message,
        };
        error.hint.map_or(message.clone(), |hint| format!("{message}; {hint}"))
    };
    PyValueError::new_err(errors.into_iter().map(line).collect::<Vec<_>>().join("\n"))
}

/// The name of the first object whose shape contains a node.
fn object_around(scene: &shotline::scene::Scene, wanted: NodeId) -> Option<&str> {
    let mut seen = vec![false; scene.nodes.len()];
    let mut stack: Vec<(NodeId, Option<&str>)> = scene.objects.iter().rev().map(|&id| (id, None)).collect();
    while let Some((id, mut owner)) = stack.pop() {
        let node = scene.nodes.get(id.0 as usize)?;
        if let Node::Object { name, .. } = node {
            owner = Some(name);
        }
        if id == wanted {
            return owner;
        }
        if !std::mem::replace(&mut seen[id.0 as usize], true) {
            stack.extend(node.children().rev().map(|child| (child, owner)));
        }
    }
    None
}

/// How to avoid an error of a query.
fn help(error: &QueryError) -> &'static str {
    match error {
        QueryError::NotASolid { .. } => {
            "close the mesh (`shotline check` lists its defects) or ask for crossings"
        }
        QueryError::Overlap { .. } => {
            "give one of them a higher priority, or choose overlaps=\"priority\" or \"all\""
        }
        QueryError::TooMany { .. } => {
            "take a part of the ray with t_min and t_max, or ask for closest or count"
        }
        QueryError::TooLong { .. } => {
            "take a part of the ray with t_min and t_max, or place fewer parts in one another"
        }
        QueryError::OutOfMemory => "cast fewer rays at a time, or ask for closest or count",
        QueryError::Cancelled => "cast again",
    }
}

/// The exception of a failed write.
pub fn write_error(error: WriteError) -> PyErr {
    let message = error.to_string();
    match error {
        WriteError::Io { .. } => PyOSError::new_err(message),
        _ => PyValueError::new_err(message),
    }
}

/// Rows of three numbers as an array.
fn vectors(py: Python, rows: Vec<[f64; 3]>) -> PyResult<Bound<PyArray2<f64>>> {
    let count = rows.len();
    rows.into_flattened().into_pyarray(py).reshape([count, 3])
}

fn options(accel: Option<&str>) -> PyResult<Options> {
    let Some(name) = accel else { return Ok(Options::default()) };
    let known = accel::NAMES.iter().copied().find(|known| *known == name);
    let known = known.ok_or_else(|| {
        PyValueError::new_err(format!(
            "there is no accelerator {name:?}; the names are {}",
            accel::NAMES.join(", ")
        ))
    })?;
    Ok(Options { accel: Some(known) })
}

impl Scene {
    fn of(py: Python, document: Document, accel: Option<&str>) -> PyResult<Scene> {
        let options = options(accel)?;
        let world = py.detach(|| compile(&document.scene, options));
        let world = world.map_err(|errors| match document.source.path() {
            Some(_) => PyValueError::new_err(document.diagnostics(&errors).to_string()),
            None => scene_error(&document.scene, errors),
        })?;
        Ok(Scene {
            scene: Arc::new(document.scene),
            world: Arc::new(world),
            options,
            dynamic: OnceLock::new(),
        })
    }

    fn moved(&self, path: &str, matrix: Affine) -> Result<Scene, Vec<SceneError>> {
        let mut dynamic = match self.dynamic.get() {
            Some(dynamic) => dynamic.clone(),
            None => {
                let dynamic = DynamicWorld::new((*self.scene).clone(), self.options)?;
                self.dynamic.get_or_init(|| dynamic).clone()
            }
        };
        dynamic.place(path, matrix)?;
        let (scene, world) = (dynamic.scene().clone(), dynamic.world().clone());
        Ok(Scene { scene, world, options: self.options, dynamic: OnceLock::from(dynamic) })
    }
}

#[pymethods]
impl Scene {
    /// Builds a scene from the text of a scene file and the meshes that it names by index.
    #[staticmethod]
    fn parse(py: Python, text: String, meshes: Vec<PyRef<Mesh>>, accel: Option<&str>) -> PyResult<Scene> {
        let packed = Packed { text, meshes: meshes.iter().map(|m| m.mesh.clone()).collect() };
        let document = py.detach(|| packed.unpack()).map_err(|error| {
            let line = |diagnostic: Diagnostic| match diagnostic.help {
                Some(help) => format!("{}; {help}", diagnostic.message),
                None => diagnostic.message,
            };
            PyValueError::new_err(error.diagnostics.into_iter().map(line).collect::<Vec<_>>().join("\n"))
        })?;
        Scene::of(py, document, accel)
    }

    /// Reads a scene from a file. Also returns its notes, each with whether it changes the model.
    #[staticmethod]
    fn load(
        py: Python,
        path: PathBuf,
        accel: Option<&str>,
        allow_outside: bool,
        weld: Option<&str>,
        partial: bool,
        setup: Option<String>,
    ) -> PyResult<(Scene, Vec<(String, bool)>)> {
        let paths = if allow_outside { PathPolicy::Anywhere } else { PathPolicy::SceneFolder };
        let weld = weld.map(|weld| weld.parse().map_err(|e: WeldError| PyValueError::new_err(e.to_string())));
        let options = ReadOptions { paths, weld: weld.transpose()?, partial, setup };
        let document = py.detach(|| shotline_io::load_with(&path, options));
        let document = document.map_err(|e| PyValueError::new_err(e.to_string()))?;
        let notes = document.notes.iter().map(|n| (n.to_string(), n.effect == Effect::Changed)).collect();
        Ok((Scene::of(py, document, accel)?, notes))
    }

    /// Writes a file; returns what was lost and which other files were written.
    fn save(&self, py: Python, path: PathBuf) -> PyResult<Vec<String>> {
        let notes = py.detach(|| shotline_io::save(&path, &self.scene));
        notes.map_err(write_error)
    }

    /// The text of a scene file, and the meshes that it names by index.
    fn pack(&self, py: Python) -> PyResult<(String, Vec<Mesh>)> {
        let packed = py.detach(|| shotline_io::pack(&self.scene));
        let Packed { text, meshes } = packed.map_err(|e| PyValueError::new_err(e.to_string()))?;
        Ok((text, meshes.into_iter().map(Mesh::of).collect::<PyResult<_>>()?))
    }

    /// A scene in which the node that a path names has another transform, of 12 numbers.
    fn with_moved(&self, py: Python, path: &str, matrix: [f64; 12]) -> PyResult<Scene> {
        let moved = py.detach(|| self.moved(path, Affine::from_row_major(matrix)));
        moved.map_err(|errors| scene_error(&self.scene, errors))
    }

    /// The scene with its solids as meshes within a tolerance: see `tessellation`.
    fn to_mesh(&self, py: Python, tolerance: f64, threads: usize) -> PyResult<Scene> {
        let scene = tessellated(py, &self.scene, tolerance, threads)?;
        Scene::of(py, Document { scene, notes: Vec::new(), source: Source::default() }, self.options.accel)
    }

    fn object_names(&self) -> Vec<String> {
        self.world.object_names().to_vec()
    }

    /// The unit of length.
    fn units(&self) -> Option<&'static str> {
        self.scene.units.map(Units::name)
    }

    /// The attenuation coefficients of the materials, where they have any.
    fn attenuations(&self) -> Vec<Option<f64>> {
        self.scene.materials.iter().map(|(_, material)| material.mu).collect()
    }

    fn material_names(&self) -> Vec<String> {
        self.world.material_names().to_vec()
    }

    fn surface_name(&self, surface: u32) -> PyResult<String> {
        named(self.world.surface_name(surface), "surface", surface.into())
    }

    fn path_name(&self, path: u64) -> PyResult<String> {
        named(self.world.path_name(path), "path", path)
    }

    /// The matrix of a path, 12 numbers.
    fn path_transform(&self, path: u64) -> PyResult<[f64; 12]> {
        let matrix = self.world.path_transform(path).ok_or_else(|| no_such("path", path))?;
        Ok(std::array::from_fn(|i| matrix.rows[i / 4][i % 4]))
    }

    /// The weights of the corners of triangles at hits, (n, 3). NaN where that is no triangle of a mesh.
    fn barycentric<'py>(&self, py: Python<'py>, hits: HitRows) -> PyResult<Rows<'py>> {
        hits.barycentric(&self.world)?.into_pyarray(py).reshape([hits.len(), 3])
    }

    /// The values of an attribute at hits, (n, width), NaN where there is none.
    fn interpolate<'py>(&self, py: Python<'py>, hits: HitRows, name: &str) -> PyResult<Rows<'py>> {
        let (values, width) = hits.interpolate(&self.world, name)?;
        values.into_pyarray(py).reshape([hits.len(), width])
    }

    fn path_count(&self) -> u64 {
        self.world.path_count()
    }

    /// The least and the greatest corner.
    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let bounds = self.world.bounds();
        (bounds.min.to_array(), bounds.max.to_array())
    }

    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let stats = self.world.stats();
        let out = PyDict::new(py);
        out.set_item("nodes", stats.nodes)?;
        out.set_item("objects", stats.objects)?;
        out.set_item("leaves", stats.leaves)?;
        out.set_item("virtual_leaves", stats.virtual_leaves)?;
        out.set_item("memory_bytes", stats.memory_bytes)?;
        out.set_item("condition", stats.condition)?;
        Ok(out)
    }

    fn closest<'py>(&self, py: Python<'py>, rays: RayQuery<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let fields = rays.fields();
        let rows = rays.run(py, |rays, scope, run| batch::closest(&self.world, rays, scope, run))?;
        let ClosestRows { t, normal, object, surface, primitive, path, entering, t_err } = rows;
        (
            t.into_pyarray(py),
            fields.contains(Fields::NORMAL).then(|| vectors(py, normal)).transpose()?,
            fields.contains(Fields::OBJECT).then(|| object.into_pyarray(py)),
            fields.contains(Fields::SURFACE).then(|| surface.into_pyarray(py)),
            fields.contains(Fields::PRIMITIVE).then(|| primitive.into_pyarray(py)),
            fields.contains(Fields::PATH).then(|| path.into_pyarray(py)),
            fields.contains(Fields::ENTERING).then(|| entering.into_pyarray(py)),
            fields.contains(Fields::T_ERR).then(|| t_err.into_pyarray(py)),
        )
            .into_pyobject(py)
    }

    fn any<'py>(&self, py: Python<'py>, rays: RayQuery<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let rows = rays.run(py, |rays, scope, run| batch::any(&self.world, rays, scope, run))?;
        Ok(rows.into_pyarray(py))
    }

    fn count<'py>(&self, py: Python<'py>, rays: RayQuery<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let rows = rays.run(py, |rays, scope, run| batch::count(&self.world, rays, scope, run))?;
        Ok(rows.into_pyarray(py))
    }

    fn crossings<'py>(&self, py: Python<'py>, rays: RayQuery<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let fields = rays.fields();
        let rows = rays.run(py, |rays, scope, run| batch::crossings(&self.world, rays, scope, run))?;
        let CrossingRows { ray_splits, t, normal, entering, object, surface, primitive, path, kind, t_err } =
            rows;
        (
            ray_splits.into_pyarray(py),
            t.into_pyarray(py),
            fields.contains(Fields::NORMAL).then(|| vectors(py, normal)).transpose()?,
            fields.contains(Fields::ENTERING).then(|| entering.into_pyarray(py)),
            fields.contains(Fields::OBJECT).then(|| object.into_pyarray(py)),
            fields.contains(Fields::SURFACE).then(|| surface.into_pyarray(py)),
            fields.contains(Fields::PRIMITIVE).then(|| primitive.into_pyarray(py)),
            fields.contains(Fields::PATH).then(|| path.into_pyarray(py)),
            fields.contains(Fields::KIND).then(|| kind.into_pyarray(py)),
            fields.contains(Fields::T_ERR).then(|| t_err.into_pyarray(py)),
        )
            .into_pyobject(py)
    }

    fn segments<'py>(
        &self,
        py: Python<'py>,
        rays: RayQuery<'py>,
        overlaps: &str,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let overlaps = overlap_policy(overlaps)?;
        let rows =
            rays.run(py, |rays, scope, run| batch::segments(&self.world, rays, scope.span, overlaps, run))?;
        let SegmentRows { ray_splits, t_in, t_out, length, material, object, path, overlaps } = rows;
        (
            ray_splits.into_pyarray(py),
            t_in.into_pyarray(py),
            t_out.into_pyarray(py),
            length.into_pyarray(py),
            material.into_pyarray(py),
            object.into_pyarray(py),
            path.into_pyarray(py),
            overlaps,
        )
            .into_pyobject(py)
    }

    /// Lengths, (rays, columns), and the number of overlaps.
    fn thickness<'py>(
        &self,
        py: Python<'py>,
        rays: RayQuery<'py>,
        by: &str,
        overlaps: &str,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, u64)> {
        let overlaps = overlap_policy(overlaps)?;
        let count = rays.ray_count;
        let by = match by {
            "material" => By::Material,
            "object" => By::Object,
            _ => {
                let message = format!("by is {by:?}, but must be \"material\" or \"object\"");
                return Err(PyValueError::new_err(message));
            }
        };
        let found = rays
            .run(py, |rays, scope, run| batch::thickness(&self.world, rays, scope.span, by, overlaps, run))?;
        let shape = [count, found.columns];
        Ok((found.lengths.into_pyarray(py).reshape(shape)?, found.overlaps))
    }

    /// The work of finding the closest crossing, (rays, counters).
    fn cost<'py>(&self, py: Python<'py>, rays: RayQuery<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let count = rays.ray_count;
        let costs = rays.run(py, |rays, scope, run| batch::cost(&self.world, rays, scope, run))?;
        costs.into_pyarray(py).reshape([count, COUNTERS.len()])
    }

    /// Whether points of shape (n, 3) are inside.
    fn contains<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let rows = PointRows::new(&points)?;
        let inside = batch_work(py, rows.len(), threads, progress.as_ref(), |run| {
            batch::contains(&self.world, &rows, run)
        })?;
        Ok(inside.map_err(batch_error)?.into_pyarray(py))
    }

    /// The objects that hold points of shape (n, 3): splits, objects.
    fn objects_containing<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let rows = PointRows::new(&points)?;
        let found = batch_work(py, rows.len(), threads, progress.as_ref(), |run| {
            batch::objects_containing(&self.world, &rows, run)
        })?;
        let ObjectRows { point_splits, object } = found.map_err(batch_error)?;
        (point_splits.into_pyarray(py), object.into_pyarray(py)).into_pyobject(py)
    }
}

/// The policy for overlapping objects.
pub fn overlap_policy(name: &str) -> PyResult<Overlaps> {
    match name {
        "error" => Ok(Overlaps::Error),
        "priority" => Ok(Overlaps::Priority),
        "all" => Ok(Overlaps::All),
        _ => Err(PyValueError::new_err(format!(
            "overlaps is {name:?}, but must be \"error\", \"priority\" or \"all\""
        ))),
    }
}

fn no_such(what: &str, number: u64) -> PyErr {
    PyIndexError::new_err(format!("the scene has no such {what}: {number}"))
}

fn named(name: String, what: &str, number: u64) -> PyResult<String> {
    if name.is_empty() { Err(no_such(what, number)) } else { Ok(name) }
}
