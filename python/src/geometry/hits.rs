//! Hits of rays.

use numpy::{PyArray1, PyArrayDyn};
use pyo3::prelude::*;

/// The closest hit of each ray; see `glanz.geometry.Hits`.
#[pyclass(name = "Hits", module = "glanz.geometry", frozen, get_all)]
pub(crate) struct RayHits {
    pub(super) hit: Py<PyArrayDyn<bool>>,
    pub(super) distance: Py<PyArrayDyn<f64>>,
    pub(super) uv: Py<PyArrayDyn<f64>>,
    pub(super) normal: Py<PyArrayDyn<f64>>,
    pub(super) undecided: Py<PyArrayDyn<bool>>,
}

/// All hits of each ray; see `glanz.geometry.AllHits`.
#[pyclass(name = "AllHits", module = "glanz.geometry", frozen, get_all)]
pub(crate) struct AllHits {
    pub(super) offsets: Py<PyArray1<i64>>,
    pub(super) ray: Py<PyArray1<i64>>,
    pub(super) distance: Py<PyArray1<f64>>,
    pub(super) uv: Py<PyArrayDyn<f64>>,
    pub(super) normal: Py<PyArrayDyn<f64>>,
    pub(super) undecided: Py<PyArrayDyn<bool>>,
}
