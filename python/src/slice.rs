//! Slices as arrays.

use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use shotline::query::ConflictKind;
use shotline_render::slice::{Area, ColorBy, Slice, SlicePlane, area_within_enclosures, regions};

use crate::cancellation::work;
use crate::scene::Scene;

/// The `SliceSettings` of the Python half, read by attribute.
#[derive(FromPyObject)]
pub struct SliceSettings {
    plane: String,
    area: Option<[f64; 4]>,
    size: Option<(u32, u32)>,
    by: String,
}

impl SliceSettings {
    fn resolve(&self) -> PyResult<(shotline_render::slice::SliceSettings, ColorBy)> {
        let refuse = |message: String| PyValueError::new_err(message);
        let plane: SlicePlane =
            self.plane.parse().map_err(|e| refuse(format!("plane is {:?}: {e}", self.plane)))?;
        let area = match self.area {
            Some([u0, v0, u1, v1]) => Some(Area::new([u0, v0], [u1, v1]).map_err(|e| refuse(e.to_string()))?),
            None => None,
        };
        let choices = [ColorBy::Object, ColorBy::Material, ColorBy::Instance];
        let by = choices.into_iter().find(|by| by.name() == self.by);
        let by = by.ok_or_else(|| refuse(format!("by is {:?}: object, material or instance", self.by)))?;
        Ok((shotline_render::slice::SliceSettings { plane, area, size: self.size }, by))
    }
}

/// What owns each pixel of a plane: the arrays of objects, materials, paths and overlaps; the area, the origin and the axes;
/// the pairs that overlap, and the regions with their colours.
#[pyfunction]
pub fn slice<'py>(
    py: Python<'py>,
    scene: PyRef<'py, Scene>,
    settings: SliceSettings,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyTuple>> {
    let (mut settings, by) = settings.resolve()?;
    let (world, described) = (&*scene.world, &*scene.scene);
    let (plane, size) = (settings.plane, settings.size);
    settings.area = settings.area.or_else(|| area_within_enclosures(described, &plane, size));
    // The number of rows, which progress is reported in; where no size is given it is not known before.
    let rows = settings.size.map_or(0, |(_, height)| height as usize);
    let found = work(py, rows, threads, progress.as_ref(), |run| {
        let slice = shotline_render::slice::slice(world, &settings, run)?;
        let regions = regions(&slice, world, described, by);
        Ok((slice, regions))
    })?;
    let (slice, regions) = found
        .map_err(|error: shotline_render::slice::SliceError| PyValueError::new_err(error.to_string()))?;
    let regions: Vec<_> =
        regions.into_iter().map(|r| (r.number, r.name, r.color.map(u32::from), r.area)).collect();
    let pair = |pair: &shotline_render::slice::PairInConflict| {
        let kind = if pair.kind == ConflictKind::Overlap { "overlap" } else { "protrusion" };
        let at = slice.point(pair.at).to_array();
        (kind, pair.first, pair.second, pair.pixels, at, pair.text(world))
    };
    let pairs: Vec<_> = slice.pairs.iter().map(pair).collect();
    let plane = slice.plane;
    let frame = (
        [slice.area.min[0], slice.area.min[1], slice.area.max[0], slice.area.max[1]],
        plane.at(0.0, 0.0).to_array(),
        plane.u().to_array(),
        plane.v().to_array(),
        plane.axis_names().map(String::from),
        plane.to_string(),
    );
    let Slice { width, height, object, material, path, overlap, .. } = slice;
    let shape = [height as usize, width as usize];
    let object: Bound<PyArray2<i32>> = object.into_pyarray(py).reshape(shape)?;
    let material: Bound<PyArray2<i32>> = material.into_pyarray(py).reshape(shape)?;
    let path: Bound<PyArray2<i64>> = path.into_pyarray(py).reshape(shape)?;
    let overlap: Bound<PyArray2<i32>> = overlap.into_pyarray(py).reshape(shape)?;
    (object, material, path, overlap, frame, pairs, regions).into_pyobject(py)
}
