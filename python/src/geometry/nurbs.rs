//! NURBS surfaces and Bézier patches.

use glanz::geometry::spline::NurbsSurface;
use glanz::geometry::{DVec3, SurfaceError};
use numpy::PyArrayDyn;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::definition::Definition;
use super::surface::SurfaceObject;
use super::trims;
use crate::arguments::value_error;
use crate::float_array::{FloatArray, array};

/// A NURBS surface; see `glanz.geometry.Nurbs`.
#[pyclass(name = "Nurbs", module = "glanz.geometry", extends = SurfaceObject, subclass, frozen)]
pub(crate) struct NurbsObject;

/// A Bézier patch; see `glanz.geometry.BezierPatch`.
#[pyclass(name = "BezierPatch", module = "glanz.geometry", extends = NurbsObject, frozen)]
pub(crate) struct BezierPatchObject;

/// A net of control points with its weights.
struct ControlNet {
    counts: [usize; 2],
    points: Vec<DVec3>,
    weights: Option<Vec<f64>>,
}

impl ControlNet {
    fn new(control_points: &Bound<'_, PyAny>, weights: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let points = FloatArray::new("control_points", control_points)?;
        let values = points.of_shape(&[0, 0, 3], "n x m x 3")?;
        let counts = [points.shape()[0], points.shape()[1]];
        let weights = weights
            .map(|weights| {
                let weights = FloatArray::new("weights", weights)?;
                // 0 stands for any length, and a net without points is refused later.
                let values = weights.of_shape(&counts, "n x m, as many as control points")?;
                PyResult::Ok(values.to_vec())
            })
            .transpose()?;
        Ok(Self { counts, points: values.chunks_exact(3).map(DVec3::from_slice).collect(), weights })
    }

    fn spline(&self, knots: [Vec<f64>; 2]) -> PyResult<NurbsSurface> {
        let mut degrees = [0; 2];
        for axis in 0..2 {
            let (name, count, knots) = (["knots_u", "knots_v"][axis], self.counts[axis], knots[axis].len());
            degrees[axis] = knots.checked_sub(count + 1).filter(|degree| *degree > 0 && count > 0).ok_or_else(|| {
                PyValueError::new_err(format!(
                    "{name} has {knots} entries for {count} control points; there must be degree + 1 more knots than \
                     control points, and the degree is at least 1"
                ))
            })?;
        }
        NurbsSurface::try_from_points(degrees, knots, &self.points, self.weights.as_deref())
            .map_err(value_error)
    }
}

fn knots(name: &'static str, object: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    Ok(FloatArray::new(name, object)?.of_shape(&[0], "a list of numbers")?.to_vec())
}

fn initializer(definition: Definition) -> PyClassInitializer<NurbsObject> {
    PyClassInitializer::from(SurfaceObject::from(definition)).add_subclass(NurbsObject)
}

/// The spline surface of an object.
fn spline<'a>(object: &'a PyRef<'_, NurbsObject>) -> PyResult<&'a NurbsSurface> {
    match &object.as_super().0.definition {
        Definition::Nurbs(spline, _) => Ok(spline),
        _ => Err(PyValueError::new_err("the surface is no NURBS surface")),
    }
}

/// A changed copy of an untrimmed surface.
fn changed(
    object: &PyRef<'_, NurbsObject>,
    change: impl FnOnce(&NurbsSurface) -> Result<NurbsSurface, SurfaceError>,
) -> PyResult<Py<NurbsObject>> {
    if object.as_super().0.is_trimmed() {
        return Err(PyValueError::new_err(
            "the surface is trimmed; change one without trims, then trim the result",
        ));
    }
    let spline = change(spline(object)?).map_err(value_error)?;
    Py::new(object.py(), initializer(Definition::Nurbs(Box::new(spline), None)))
}

#[pymethods]
impl NurbsObject {
    #[new]
    #[pyo3(signature = (control_points, weights = None, knots_u = None, knots_v = None, trims = None))]
    fn new(
        control_points: &Bound<'_, PyAny>,
        weights: Option<&Bound<'_, PyAny>>,
        knots_u: Option<&Bound<'_, PyAny>>,
        knots_v: Option<&Bound<'_, PyAny>>,
        trims: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let net = ControlNet::new(control_points, weights)?;
        let (Some(knots_u), Some(knots_v)) = (knots_u, knots_v) else {
            return Err(pyo3::exceptions::PyTypeError::new_err(
                "knots_u and knots_v are missing; give both, or use BezierPatch for a surface without inner knots",
            ));
        };
        let spline = net.spline([knots("knots_u", knots_u)?, knots("knots_v", knots_v)?])?;
        let region = trims.map(trims::region).transpose()?;
        Ok(initializer(Definition::Nurbs(Box::new(spline), region)))
    }

    #[getter]
    fn control_points<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let object = slf.borrow();
        let spline = spline(&object)?;
        let (n, m) = spline.counts();
        let points = spline.control_points().iter().flat_map(|p| (p.truncate() / p.w).to_array());
        array(slf.py(), &[n, m, 3], points)
    }

    #[getter]
    fn weights<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let object = slf.borrow();
        let spline = spline(&object)?;
        let (n, m) = spline.counts();
        array(slf.py(), &[n, m], spline.control_points().iter().map(|p| p.w))
    }

    #[getter]
    fn knots_u<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let object = slf.borrow();
        let knots = spline(&object)?.knots_u().knots();
        array(slf.py(), &[knots.len()], knots.iter().copied())
    }

    #[getter]
    fn knots_v<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let object = slf.borrow();
        let knots = spline(&object)?.knots_v().knots();
        array(slf.py(), &[knots.len()], knots.iter().copied())
    }

    #[getter]
    fn degree(slf: PyRef<'_, Self>) -> PyResult<(usize, usize)> {
        let spline = spline(&slf)?;
        Ok((spline.knots_u().degree(), spline.knots_v().degree()))
    }

    fn transposed(slf: PyRef<'_, Self>) -> PyResult<Py<Self>> {
        changed(&slf, |spline| Ok(spline.transposed()))
    }

    fn restrict(slf: PyRef<'_, Self>, u: [f64; 2], v: [f64; 2]) -> PyResult<Py<Self>> {
        changed(&slf, |spline| spline.restrict([u, v]))
    }
}

#[pymethods]
impl BezierPatchObject {
    #[new]
    #[pyo3(signature = (control_points, weights = None))]
    fn new(
        control_points: &Bound<'_, PyAny>,
        weights: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let net = ControlNet::new(control_points, weights)?;
        let knots = net.counts.map(|count| [vec![0.0; count], vec![1.0; count]].concat());
        let spline = net.spline(knots)?;
        Ok(initializer(Definition::Nurbs(Box::new(spline), None)).add_subclass(Self))
    }
}
