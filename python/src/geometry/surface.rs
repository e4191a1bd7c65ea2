//! The base of all surfaces.

use std::sync::Arc;

use glanz::geometry::DVec2;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::closest::{AreaObject, ClosestPoints, CurvatureArrays};
use super::definition::{Definition, SurfaceState};
use super::{closest, intersect};
use crate::arguments::{Whole, positive, value_error};
use crate::float_array::{FloatArray, ROWS_AT_ONCE, rows};

/// A surface; see `glanz.geometry.Surface`.
#[pyclass(name = "Surface", module = "glanz.geometry", subclass, frozen)]
pub(crate) struct SurfaceObject(pub(super) Arc<SurfaceState>);

impl From<Definition> for SurfaceObject {
    fn from(definition: Definition) -> Self {
        Self(Arc::new(definition.into()))
    }
}

/// Values at the parameters u, v, broadcast against each other: rows of shape `width`.
fn at_parameters<'py>(
    uv: [&Bound<'py, PyAny>; 2],
    width: &[usize],
    row: impl Fn(DVec2, &mut [f64]) + Sync,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let both = FloatArray::pair(["u", "v"], uv)?;
    let (u, v) = (both[0].values()?, both[1].values()?);
    rows(uv[0].py(), both[0].shape(), width, ROWS_AT_ONCE, |i, values| row(DVec2::new(u[i], v[i]), values))
}

#[pymethods]
impl SurfaceObject {
    fn evaluate<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        at_parameters([u, v], &[3], |uv, values| self.0.derivatives(uv, 0, values))
    }

    #[pyo3(signature = (u, v, order = Whole(1)))]
    fn derivatives<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        order: Whole,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let max = self.0.max_order();
        let order = order.within("order", 0..=max)? as usize;
        let width = [order + 1, order + 1, 3];
        at_parameters([u, v], &width, |uv, values| self.0.derivatives(uv, order, values))
    }

    fn normals<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        at_parameters([u, v], &[3], |uv, values| match self.0.normal(uv) {
            Some(normal) => values.copy_from_slice(&normal.to_array()),
            None => values.fill(f64::NAN),
        })
    }

    fn curvature(&self, u: &Bound<'_, PyAny>, v: &Bound<'_, PyAny>) -> PyResult<CurvatureArrays> {
        let all = at_parameters([u, v], &[4], |uv, values| match self.0.curvature(uv) {
            Some(found) => {
                let [low, high] = found.principal;
                values.copy_from_slice(&[found.gaussian, found.mean, low, high]);
            }
            None => values.fill(f64::NAN),
        })?;
        CurvatureArrays::new(&all)
    }

    fn contains<'py>(&self, u: &Bound<'py, PyAny>, v: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let [[u0, u1], [v0, v1]] = self.0.domain();
        let triangle = matches!(self.0.definition, Definition::Triangle(_));
        let kept = at_parameters([u, v], &[1], |uv, values| {
            let inside = uv.x >= u0 && uv.x <= u1 && uv.y >= v0 && uv.y <= v1;
            let inside = inside && (!triangle || uv.element_sum() <= 1.0);
            values.fill(f64::from(u8::from(inside && self.0.keeps(uv))));
        })?;
        kept.get_item((pyo3::types::PyEllipsis::get(kept.py()), 0))?.call_method1("astype", ("bool",))
    }

    #[pyo3(signature = (tolerance = 1e-9))]
    fn area(&self, py: Python<'_>, tolerance: f64) -> PyResult<AreaObject> {
        let tolerance = positive(tolerance, "tolerance")?;
        Ok(AreaObject::from(py.detach(|| self.0.area(tolerance)).map_err(value_error)?))
    }

    #[pyo3(signature = (points, tolerance = None))]
    fn closest_point(&self, points: &Bound<'_, PyAny>, tolerance: Option<f64>) -> PyResult<ClosestPoints> {
        closest::closest_points(&self.0, points, tolerance)
    }

    #[pyo3(signature = (origins, directions, all_roots = false, t_max = None))]
    fn intersect<'py>(
        &self,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        all_roots: bool,
        t_max: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        intersect::intersect(&self.0, [origins, directions], all_roots, t_max)
    }

    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let bounds = self.0.bounds();
        rows(py, &[2], &[3], ROWS_AT_ONCE, |i, values| {
            values.copy_from_slice(&[bounds.min, bounds.max][i].to_array());
        })
    }

    #[getter]
    fn domain(&self) -> ((f64, f64), (f64, f64)) {
        let [u, v] = self.0.domain();
        (u.into(), v.into())
    }

    #[getter]
    fn trimmed(&self) -> bool {
        self.0.is_trimmed()
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        let ([u, v], name) = (slf.get().0.domain(), slf.get_type().name()?);
        Ok(format!("<glanz.geometry.{name} over [{}, {}] x [{}, {}]>", u[0], u[1], v[0], v[1]))
    }
}
