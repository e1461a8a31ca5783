//! Volume, mass, centroid and inertia of objects.

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use shotline::measure::{Measure, Method, Settings, measure as measured};

use crate::cancellation::work;
use crate::scene::{Scene, overlap_policy};

/// The `MeasureSettings` of the Python half, read by attribute.
#[derive(FromPyObject)]
pub struct MeasureSettings {
    rays: usize,
    seed: u64,
    /// Whether to use closed forms where there are any.
    closed_forms: bool,
    overlaps: String,
    objects: Option<Vec<u32>>,
}

/// Columns with a row for each object: object; volume, mass, centroid and inertia, each followed by its error; exact,
/// bounds and rays.
#[pyfunction]
pub fn measure<'py>(
    py: Python<'py>,
    scene: PyRef<'py, Scene>,
    settings: MeasureSettings,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyTuple>> {
    let MeasureSettings { rays, seed, closed_forms, overlaps, objects } = settings;
    let method = if closed_forms { Method::Best } else { Method::Rays };
    let count = objects.as_ref().map_or(scene.world.object_names().len(), Vec::len);
    let settings = Settings { rays, seed, method, overlaps: overlap_policy(&overlaps)?, objects };
    let (world, described) = (&*scene.world, &*scene.scene);
    let total = rays.saturating_mul(count);
    let found =
        work(py, total, threads, progress.as_ref(), |run| measured(world, described, &settings, run))?;
    columns(py, &found.map_err(|e| PyValueError::new_err(e.to_string()))?)
}

fn columns<'py>(py: Python<'py>, rows: &[Measure]) -> PyResult<Bound<'py, PyTuple>> {
    let n = rows.len();
    let one = |of: &dyn Fn(&Measure) -> f64| rows.iter().map(of).collect::<Vec<f64>>().into_pyarray(py);
    let many =
        |of: &dyn Fn(&Measure) -> Vec<f64>| rows.iter().flat_map(of).collect::<Vec<f64>>().into_pyarray(py);
    let mass = |m: &Measure| m.mass.map_or((f64::NAN, f64::NAN), |e| (e.value, e.std_error));
    let corners = |m: &Measure| [m.bounds.min.to_array(), m.bounds.max.to_array()].concat();
    (
        rows.iter().map(|m| m.object as i32).collect::<Vec<_>>().into_pyarray(py),
        one(&|m| m.volume.value),
        one(&|m| m.volume.std_error),
        one(&|m| mass(m).0),
        one(&|m| mass(m).1),
        many(&|m| m.centroid.map(|e| e.value).to_vec()).reshape([n, 3])?,
        many(&|m| m.centroid.map(|e| e.std_error).to_vec()).reshape([n, 3])?,
        many(&|m| m.inertia.concat().iter().map(|e| e.value).collect()).reshape([n, 3, 3])?,
        many(&|m| m.inertia.concat().iter().map(|e| e.std_error).collect()).reshape([n, 3, 3])?,
        rows.iter().map(|m| m.exact).collect::<Vec<_>>().into_pyarray(py),
        many(&corners).reshape([n, 2, 3])?,
        rows.iter().map(|m| m.rays as i64).collect::<Vec<_>>().into_pyarray(py),
    )
        .into_pyobject(py)
}
