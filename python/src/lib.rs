//! The native half of the Python package: arrays in, arrays out. The Python half, `python/shotline`, defines names,
//! shapes and documentation.

mod cancellation;
mod hits;
mod measure;
mod mesh;
mod picture;
mod rays;
mod registry;
mod scene;
mod slice;
mod tessellation;
mod viewer;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line and returns its exit code.
#[pyfunction]
fn main(py: Python, argv: Vec<OsString>) -> u8 {
    py.detach(|| shotline_cli::main(argv))
}

#[pymodule]
mod _native {
    use numpy::{PyArray1, PyArrayMethods};
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::main;
    #[pymodule_export]
    use super::measure::measure;
    #[pymodule_export]
    use super::mesh::Mesh;
    #[pymodule_export]
    use super::picture::{develop, encode_png, expose, picture_camera, render, save_jpeg, save_png};
    #[pymodule_export]
    use super::registry::{accelerators, check_solid, compose, counters, kinds, units};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::slice::slice;
    #[pymodule_export]
    use super::viewer::Viewer;

    /// The first use of NumPy's C interface runs Python code to find it, and Ctrl-C during that would cause a panic. So
    /// the interface is used once here, on import.
    #[pymodule_init]
    fn init(module: &Bound<PyModule>) -> PyResult<()> {
        PyArray1::<f64>::zeros(module.py(), 0, false).try_readonly()?;
        Ok(())
    }

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
