//! Loops of trimming curves from Python.

use std::sync::Arc;

use glanz::geometry::trim::{TrimCurve, TrimRegion};
use glanz::geometry::{DVec2, DVec3};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::arguments::value_error;
use crate::float_array::FloatArray;

/// Degree, control points, weights and knots of a curve.
type CurveTuple<'py> = (usize, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// The region that loops of curves keep.
///
/// # Errors
/// `TypeError` for anything that is no loop, `ValueError` for loops that are not closed and for invalid curves.
pub(super) fn region(loops: &Bound<'_, PyAny>) -> PyResult<Arc<TrimRegion>> {
    let loops = loops.try_iter()?.map(|curves| trim_loop(&curves?)).collect::<PyResult<Vec<_>>>()?;
    if loops.is_empty() {
        return Err(PyValueError::new_err("there are no loops in trims; give None for a whole surface"));
    }
    Ok(Arc::new(loops_region(loops)?))
}

fn loops_region(loops: Vec<Vec<TrimCurve>>) -> PyResult<TrimRegion> {
    TrimRegion::try_from_curves(loops).map_err(value_error)
}

/// The curves of a loop: those of a list, or the edges of a polygon.
fn trim_loop(object: &Bound<'_, PyAny>) -> PyResult<Vec<TrimCurve>> {
    if let Ok(corners) = FloatArray::new("trims", object)
        && corners.shape().len() == 2
    {
        let mut corners = points(&corners)?;
        if corners.len() > 3 && corners.first() == corners.last() {
            corners.pop();
        }
        return Ok(vec![TrimCurve::try_polygon(&corners).map_err(value_error)?]);
    }
    object.try_iter()?.map(|curve| trim_curve(&curve?)).collect()
}

/// A curve: a polyline, or degree, control points, weights and knots.
fn trim_curve(object: &Bound<'_, PyAny>) -> PyResult<TrimCurve> {
    if let Ok((degree, control_points, weights, knots)) = object.extract::<CurveTuple<'_>>() {
        let control_points =
            points(&FloatArray::new("control points of a trimming curve", &control_points)?)?;
        let weights = if weights.is_none() {
            vec![1.0; control_points.len()]
        } else {
            FloatArray::new("weights of a trimming curve", &weights)?
                .of_shape(&[control_points.len()], "one per control point")?
                .to_vec()
        };
        let knots = FloatArray::new("knots of a trimming curve", &knots)?;
        let homogeneous: Vec<DVec3> = control_points
            .iter()
            .zip(weights)
            .map(|(point, weight)| (*point * weight).extend(weight))
            .collect();
        return TrimCurve::try_nurbs(degree, knots.of_shape(&[0], "a list of numbers")?, &homogeneous)
            .map_err(value_error);
    }
    let polyline = FloatArray::new("trims", object).map_err(|_| {
        PyTypeError::new_err(
            "a trimming curve must be a polyline (k x 2) or (degree, control points, weights, knots)",
        )
    })?;
    TrimCurve::try_polyline(&points(&polyline)?).map_err(value_error)
}

fn points(array: &FloatArray<'_>) -> PyResult<Vec<DVec2>> {
    let values = array.of_shape(&[0, 2], "k x 2")?;
    Ok(values.chunks_exact(2).map(DVec2::from_slice).collect())
}
