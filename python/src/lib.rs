//! The native module of the Python package `glanz`: scenes, jobs and their results; surfaces; densities. The package re-exports it; values
//! without methods of the engine are dataclasses of the package (`glanz/_results.py`), which this module fills.

mod arguments;
mod bake;
mod compare;
mod error;
mod float_array;
mod geometry;
mod illuminate;
mod image;
mod image_array;
mod job;
mod merge;
mod render;
mod sampling;
mod scene;

use pyo3::prelude::*;

/// The native module; the package `glanz` re-exports it.
#[pymodule]
mod _glanz {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::bake::PyLightMaps;
    #[pymodule_export]
    use crate::compare::compare;
    #[pymodule_export]
    use crate::geometry::geometry;
    #[pymodule_export]
    use crate::illuminate::PyIllumination;
    #[pymodule_export]
    use crate::image::{PyImage, read_image};
    #[pymodule_export]
    use crate::merge::{merge, merge_checkpoints};
    #[pymodule_export]
    use crate::sampling::sampling;
    #[pymodule_export]
    use crate::scene::{PyScene, load, loads};

    /// Adds the version.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", glanz::job::current_version())
    }
}
