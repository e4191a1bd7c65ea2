//! Triangular Bézier patches.

use glanz::geometry::DVec3;
use glanz::geometry::bezier::TrianglePatch;
use numpy::PyArrayDyn;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::definition::Definition;
use super::surface::SurfaceObject;
use crate::arguments::value_error;
use crate::float_array::{FloatArray, array};

/// A triangular Bézier patch; see `glanz.geometry.BezierTriangle`.
#[pyclass(name = "BezierTriangle", module = "glanz.geometry", extends = SurfaceObject, frozen)]
pub(crate) struct BezierTriangleObject;

/// The patch of an object.
fn patch<'a>(object: &'a PyRef<'_, BezierTriangleObject>) -> PyResult<&'a TrianglePatch> {
    match &object.as_super().0.definition {
        Definition::Triangle(patch) => Ok(patch),
        _ => Err(PyValueError::new_err("the surface is no triangular patch")),
    }
}

#[pymethods]
impl BezierTriangleObject {
    #[new]
    #[pyo3(signature = (control_points, weights = None))]
    fn new(
        control_points: &Bound<'_, PyAny>,
        weights: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let points = FloatArray::new("control_points", control_points)?;
        let values = points.of_shape(&[0, 3], "(n + 1) (n + 2) / 2 x 3 for a degree n")?;
        let count = points.shape()[0];
        let degree = (1..=count).take_while(|n| (n + 1) * (n + 2) / 2 <= count).last().unwrap_or(1);
        let weights = weights.map(|weights| FloatArray::new("weights", weights)).transpose()?;
        let weights =
            weights.as_ref().map(|w| w.of_shape(&[count], "as many as control points")).transpose()?;
        let points: Vec<DVec3> = values.chunks_exact(3).map(DVec3::from_slice).collect();
        let patch = TrianglePatch::try_from_points(degree, &points, weights).map_err(value_error)?;
        Ok(PyClassInitializer::from(SurfaceObject::from(Definition::Triangle(patch))).add_subclass(Self))
    }

    #[getter]
    fn control_points<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let object = slf.borrow();
        let points = patch(&object)?.control_points();
        array(slf.py(), &[points.len(), 3], points.iter().flat_map(|p| (p.truncate() / p.w).to_array()))
    }

    #[getter]
    fn weights<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let object = slf.borrow();
        let points = patch(&object)?.control_points();
        array(slf.py(), &[points.len()], points.iter().map(|p| p.w))
    }

    #[getter]
    fn degree(slf: PyRef<'_, Self>) -> PyResult<usize> {
        Ok(patch(&slf)?.degree())
    }
}
