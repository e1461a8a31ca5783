//! The viewer of scenes that are in memory.

use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use shotline_cli::ShowError;

use crate::scene::Scene;

/// A page that shows a scene until it is closed.
#[pyclass(module = "shotline._native", frozen)]
pub struct Viewer {
    viewer: shotline_cli::Viewer,
}

#[pymethods]
impl Viewer {
    /// Starts to show a scene.
    #[new]
    fn new(py: Python, scene: PyRef<Scene>, port: u16) -> PyResult<Viewer> {
        let described = (*scene.scene).clone();
        let shown = py.detach(|| shotline_cli::show(described, port));
        match shown {
            Ok(viewer) => Ok(Viewer { viewer }),
            Err(ShowError::Scene(why)) => Err(PyValueError::new_err(why)),
            Err(ShowError::Listen(error)) => Err(PyOSError::new_err(error.to_string())),
        }
    }

    /// The address of the page.
    fn url(&self) -> String {
        self.viewer.url()
    }

    /// Ends it.
    fn close(&self) {
        self.viewer.stop();
    }
}
