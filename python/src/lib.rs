//! The native module of the Python package `glanz`.

use pyo3::prelude::*;

/// The native module; the package `glanz` re-exports it.
#[pymodule]
mod _glanz {
    use pyo3::prelude::*;

    /// Adds the version.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", glanz::job::current_version())
    }
}
