//! The native half of the Python package: arrays in, arrays out. Names, shapes and documentation are the business of
//! the Python half, `python/shotline`.

mod measure;
mod mesh;
mod picture;
mod rays;
mod registry;
mod scene;
mod waiting;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line and answers its exit code.
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
    use super::picture::{develop, encode_png, expose, render, save_png};
    #[pymodule_export]
    use super::registry::{accelerators, check_solid, compose, counters, kinds, units};
    #[pymodule_export]
    use super::scene::Scene;
    /// NumPy's interfaces are looked up when first used, which runs Python, and Ctrl-C in the middle of it would be a
    /// panic. So they are used here, where nobody waits for anything yet.
    #[pymodule_init]
    fn init(module: &Bound<PyModule>) -> PyResult<()> {
        PyArray1::<f64>::zeros(module.py(), 0, false).try_readonly()?;
        Ok(())
    }

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
