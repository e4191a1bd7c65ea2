//! Measures of surfaces: curvatures, areas and nearest points.

use glanz::geometry::spline::AreaEstimate;
use glanz::geometry::{DVec3, SurfaceError};
use numpy::PyArrayDyn;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::definition::SurfaceState;
use crate::arguments::value_error;
use crate::float_array::{FloatArray, along_last, rows};

/// Queries after which signals are handled.
const QUERIES_AT_ONCE: usize = 64;

/// Default tolerance of nearest points, relative to the diagonal of the box around the surface.
const TOLERANCE: f64 = 1e-9;

/// Curvatures; see `glanz.geometry.Curvature`.
#[pyclass(name = "Curvature", module = "glanz.geometry", frozen, get_all)]
pub(crate) struct CurvatureArrays {
    gaussian: Py<PyAny>,
    mean: Py<PyAny>,
    principal: Py<PyAny>,
}

impl CurvatureArrays {
    /// Curvatures from rows of the Gaussian, the mean and both principal ones.
    pub(super) fn new(rows: &Bound<'_, PyArrayDyn<f64>>) -> PyResult<Self> {
        let principal = pyo3::types::PySlice::new(rows.py(), 2, 4, 1);
        Ok(Self {
            gaussian: along_last(rows, 0)?,
            mean: along_last(rows, 1)?,
            principal: along_last(rows, principal)?,
        })
    }
}

/// An area; see `glanz.geometry.Area`.
#[pyclass(name = "Area", module = "glanz.geometry", frozen, get_all)]
pub(crate) struct AreaObject {
    value: f64,
    error: f64,
}

impl From<AreaEstimate> for AreaObject {
    fn from(AreaEstimate { value, error }: AreaEstimate) -> Self {
        Self { value, error }
    }
}

#[pymethods]
impl AreaObject {
    fn __float__(&self) -> f64 {
        self.value
    }

    fn __repr__(&self) -> String {
        format!("Area(value={:?}, error={:?})", self.value, self.error)
    }
}

/// Nearest points; see `glanz.geometry.ClosestPoints`.
#[pyclass(name = "ClosestPoints", module = "glanz.geometry", frozen, get_all)]
pub(crate) struct ClosestPoints {
    uv: Py<PyAny>,
    points: Py<PyAny>,
    distance: Py<PyAny>,
    lower_bound: Py<PyAny>,
}

/// The point of a surface nearest to each of `points`.
///
/// # Errors
/// `ValueError` for the points, the tolerance, and surfaces without end; `KeyboardInterrupt`.
pub(super) fn closest_points(
    surface: &SurfaceState,
    points: &Bound<'_, PyAny>,
    tolerance: Option<f64>,
) -> PyResult<ClosestPoints> {
    let py = points.py();
    let points = FloatArray::new("points", points)?;
    let shape = points.shape();
    let Some((&3, shape)) = shape.split_last() else {
        points.of_shape(&[0, 3], "... x 3")?;
        return Err(PyValueError::new_err("points must be ... x 3"));
    };
    let queries = points.values()?;
    if let Some(index) = queries.iter().position(|x| !x.is_finite()) {
        return Err(PyValueError::new_err(format!(
            "point {} has the coordinate {}; it must be finite",
            index / 3,
            queries[index]
        )));
    }
    let tolerance = tolerance.unwrap_or_else(|| {
        (TOLERANCE * surface.bounds().diagonal().length()).clamp(f64::MIN_POSITIVE, f64::MAX)
    });
    let search = |query: DVec3| {
        let missing = SurfaceError::NotFinite { parameter: "nearest point", value: f64::NAN };
        surface.closest_point(query, tolerance)?.ok_or(missing)
    };
    // Errors depend on surface and tolerance alone.
    py.detach(|| search(surface.bounds().min.clamp(DVec3::MIN, DVec3::MAX))).map_err(value_error)?;
    let all = rows(py, shape, &[7], QUERIES_AT_ONCE, |i, values| {
        match search(DVec3::from_slice(&queries[3 * i..])) {
            Ok(found) => {
                let [x, y, z] = found.point.to_array();
                values.copy_from_slice(&[found.u, found.v, x, y, z, found.distance, found.lower_bound]);
            }
            Err(_) => values.fill(f64::NAN),
        }
    })?;
    let part = |start: isize, end: isize| along_last(&all, pyo3::types::PySlice::new(py, start, end, 1));
    Ok(ClosestPoints {
        uv: part(0, 2)?,
        points: part(2, 5)?,
        distance: along_last(&all, 5)?,
        lower_bound: along_last(&all, 6)?,
    })
}
