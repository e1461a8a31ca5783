//! Solids as meshes.

use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::prelude::*;
use shotline::query::batch::{BatchError, Run};
use shotline::scene::Scene;
use shotline_tessellate::{Settings, TessellateError, tessellate};

use crate::cancellation::work;

/// The scene with its solids as meshes within a tolerance.
pub fn tessellated(py: Python, scene: &Scene, tolerance: f64, threads: usize) -> PyResult<Scene> {
    let found = work(py, 0, threads, None, |run| {
        // Rows of several grids would be counted together.
        tessellate(scene, &Settings::new(tolerance), Run { progress: None, ..run }, &mut |_| {})
    })?;
    match found {
        Ok(found) => Ok(found.scene),
        Err(TessellateError::Batch(BatchError::OutOfMemory)) => {
            Err(PyMemoryError::new_err("the meshes do not fit"))
        }
        Err(error) => Err(PyValueError::new_err(error.to_string())),
    }
}
