//! Adaptive densities of one to four dimensions.

use std::sync::Arc;

use glanz::sampling::density::{AdaptiveDensity, DensitySample, FittingMethod};
use glanz::sampling::integrate::IntegrationPlan;
use numpy::PyArrayDyn;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::integrate::{IntegralEstimate, record_pass};
use super::options;
use super::options::{MAX_LEVEL, PerAxis, analyses, check_size, method, pattern};
use crate::arguments::{Whole, value_error};
use crate::float_array::{FloatArray, ROWS_AT_ONCE, along_last, array, rows};

/// Points drawn from a density; see `glanz.sampling.DensitySamples`.
#[pyclass(name = "DensitySamples", module = "glanz.sampling", frozen, get_all)]
pub(crate) struct DensitySamples {
    points: Py<PyAny>,
    pdf: Py<PyAny>,
    functions: Py<PyAny>,
}

#[pymethods]
impl DensitySamples {
    #[new]
    #[pyo3(signature = (points, pdf, functions = None))]
    fn new(
        points: &Bound<'_, PyAny>,
        pdf: &Bound<'_, PyAny>,
        functions: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let numpy = points.py().import("numpy")?;
        let array =
            |values: &Bound<'_, PyAny>| Ok::<_, PyErr>(numpy.call_method1("asarray", (values,))?.unbind());
        let functions = functions.map_or_else(|| Ok(points.py().None()), array)?;
        Ok(Self { points: array(points)?, pdf: array(pdf)?, functions })
    }

    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.pdf.bind(py).len()
    }
}

/// A density of any of the possible dimensions.
#[derive(Clone)]
pub(super) enum AnyDensity {
    One(AdaptiveDensity<1>),
    Two(AdaptiveDensity<2>),
    Three(AdaptiveDensity<3>),
    Four(AdaptiveDensity<4>),
}

/// Evaluates an expression with the density of its dimension.
macro_rules! with_density {
    ($any:expr, $density:ident => $body:expr) => {
        match $any {
            AnyDensity::One($density) => $body,
            AnyDensity::Two($density) => $body,
            AnyDensity::Three($density) => $body,
            AnyDensity::Four($density) => $body,
        }
    };
}

macro_rules! any_density {
    ($($variant:ident($dimension:literal)),*) => {
        $(impl From<AdaptiveDensity<$dimension>> for AnyDensity {
            fn from(density: AdaptiveDensity<$dimension>) -> Self {
                Self::$variant(density)
            }
        })*
    };
}

any_density!(One(1), Two(2), Three(3), Four(4));

/// A density; see `glanz.sampling.AdaptiveDensity`.
#[pyclass(name = "AdaptiveDensity", module = "glanz.sampling")]
pub(crate) struct DensityObject {
    pub(super) density: AnyDensity,
    max_level: usize,
}

/// The constant density.
fn constant<const D: usize>(
    basis: &PerAxis<String>,
    levels: &PerAxis<Whole>,
    max_level: usize,
    fitting: &str,
) -> PyResult<AnyDensity>
where
    AnyDensity: From<AdaptiveDensity<D>>,
{
    let (scales, levels) = (analyses::<D>(basis, max_level)?, levels.levels()?);
    check_size(&scales, levels)?;
    Ok(AdaptiveDensity::try_new(Arc::new(scales), levels, method(fitting)?).map_err(value_error)?.into())
}

/// The error of a dimension without densities.
pub(super) fn no_dimension(dimension: u64) -> PyErr {
    PyValueError::new_err(format!("dimension is {dimension}; it must lie between 1 and 4"))
}

/// The points of an array of shape N x D.
fn points<'a, const D: usize>(array: &'a FloatArray<'_>) -> PyResult<&'a [[f64; D]]> {
    let values = array.of_shape(&[0, D], &format!("N x {D}"))?;
    Ok(values.as_chunks().0)
}

/// Draws a point for each row of `xi`.
fn draw<const D: usize>(
    density: &AdaptiveDensity<D>,
    xi: &FloatArray<'_>,
    py: Python<'_>,
) -> PyResult<DensitySamples> {
    let numbers = points::<D>(xi)?;
    if let Some(value) = numbers.as_flattened().iter().find(|x| !(0.0..1.0).contains(*x)) {
        return Err(PyValueError::new_err(format!("xi contains {value}; all numbers must lie in [0, 1)")));
    }
    let all = rows(py, &[numbers.len()], &[D + 2], ROWS_AT_ONCE, |i, values| {
        let DensitySample { point, pdf, function } = density.sample(&numbers[i]);
        values[..D].copy_from_slice(&point);
        values[D..].copy_from_slice(&[pdf, function as f64]);
    })?;
    let part = pyo3::types::PySlice::new(py, 0, D as isize, 1);
    let functions = along_last(&all, D + 1)?.call_method1(py, "astype", ("int64",))?;
    Ok(DensitySamples { points: along_last(&all, part)?, pdf: along_last(&all, D)?, functions })
}

/// Records values at samples; returns the number of accepted ones.
fn record<const D: usize>(
    density: &mut AdaptiveDensity<D>,
    samples: &DensitySamples,
    values: &Bound<'_, PyAny>,
    py: Python<'_>,
) -> PyResult<usize> {
    let at = FloatArray::new("points", samples.points.bind(py))?;
    let at = points::<D>(&at)?;
    let (count, form) = (at.len(), "one number per point");
    let pdf = FloatArray::new("pdf", samples.pdf.bind(py))?;
    let (pdf, values) = (pdf.of_length(count, form)?, FloatArray::new("values", values)?);
    let values = values.of_length(count, form)?;
    let functions = samples.functions.bind(py);
    let functions = if functions.is_none() { None } else { Some(FloatArray::new("functions", functions)?) };
    let functions = functions.as_ref().map(|functions| functions.of_length(count, form)).transpose()?;
    if functions.is_none() && density.method() != FittingMethod::AllSamples {
        return Err(PyValueError::new_err(
            "the samples have no functions; draw them with sample(), or choose the method \"all\"",
        ));
    }
    if let Some(value) = at.as_flattened().iter().find(|x| !(0.0..=1.0).contains(*x)) {
        return Err(PyValueError::new_err(format!("points contain {value}; coordinates must lie in [0, 1]")));
    }
    let invalid = |n: &&f64| !(**n >= 0.0 && n.fract() == 0.0);
    if let Some(value) = functions.unwrap_or_default().iter().find(invalid) {
        return Err(PyValueError::new_err(format!(
            "functions contain {value}; they must be whole numbers from 0"
        )));
    }
    let accepted = (0..count).filter(|&i| {
        let function = functions.map_or(0.0, |functions| functions[i]) as usize;
        density.record(&DensitySample { point: at[i], pdf: pdf[i], function }, values[i])
    });
    Ok(accepted.count())
}

#[pymethods]
impl DensityObject {
    #[new]
    #[pyo3(signature = (dimension, basis = None, levels = None, *, max_level = Whole(8), method = "own"))]
    fn new(
        dimension: Whole,
        basis: Option<PerAxis<String>>,
        levels: Option<PerAxis<Whole>>,
        max_level: Whole,
        method: &str,
    ) -> PyResult<Self> {
        let max_level = max_level.within("max_level", 0..=MAX_LEVEL)? as usize;
        let basis = basis.unwrap_or_else(|| PerAxis::One(String::from("spline1")));
        let levels = levels.unwrap_or(PerAxis::One(Whole(0)));
        let density = match dimension.0 {
            1 => constant::<1>(&basis, &levels, max_level, method)?,
            2 => constant::<2>(&basis, &levels, max_level, method)?,
            3 => constant::<3>(&basis, &levels, max_level, method)?,
            4 => constant::<4>(&basis, &levels, max_level, method)?,
            other => return Err(no_dimension(other)),
        };
        Ok(Self { density, max_level })
    }

    #[getter]
    fn dimension(&self) -> usize {
        with_density!(&self.density, density => density.levels().len())
    }

    #[getter]
    fn levels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyTuple>> {
        with_density!(&self.density, density => pyo3::types::PyTuple::new(py, density.levels()))
    }

    #[getter]
    fn max_level(&self) -> usize {
        self.max_level
    }

    #[getter]
    fn coefficients<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        with_density!(&self.density, density => {
            let density = density.density();
            array(py, &density.basis().shape(), density.coefficients().iter().copied())
        })
    }

    /// Number of samples since the last fit.
    #[getter]
    fn recorded(&self) -> u64 {
        with_density!(&self.density, density => density.fitter().samples())
    }

    fn sample(&self, xi: &Bound<'_, PyAny>) -> PyResult<DensitySamples> {
        let (py, xi) = (xi.py(), FloatArray::new("xi", xi)?);
        with_density!(&self.density, density => draw(density, &xi, py))
    }

    fn pdf<'py>(&self, x: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (py, x) = (x.py(), FloatArray::new("x", x)?);
        with_density!(&self.density, density => {
            let x = points(&x)?;
            let all = rows(py, &[x.len()], &[1], ROWS_AT_ONCE, |i, values| {
                let unknown = x[i].iter().any(|x| x.is_nan());
                values.fill(if unknown { f64::NAN } else { density.pdf(&x[i]) });
            })?;
            Ok(along_last(&all, 0)?.into_bound(py))
        })
    }

    fn record(&mut self, samples: &DensitySamples, values: &Bound<'_, PyAny>) -> PyResult<usize> {
        let py = values.py();
        with_density!(&mut self.density, density => record(density, samples, values, py))
    }

    #[pyo3(signature = (integrand, samples = Whole(4096), *, repetitions = Whole(1), pattern = "independent", seed = Whole(1)))]
    fn integrate(
        slf: &Bound<'_, Self>,
        integrand: &Bound<'_, PyAny>,
        samples: Whole,
        repetitions: Whole,
        pattern: &str,
        seed: Whole,
    ) -> PyResult<IntegralEstimate> {
        let plan = IntegrationPlan {
            samples: samples.within("samples", 1..=u32::MAX)?,
            repetitions: repetitions.within("repetitions", 1..=u32::MAX)?,
            sampling: self::pattern(pattern)?,
            seed: seed.0,
        };
        // A copy, so that the integrand may use the density, and an exception leaves no samples.
        let mut density = slf.try_borrow()?.density.clone();
        let found = with_density!(&mut density, density => record_pass(density, integrand, &plan))?;
        slf.try_borrow_mut()?.density = density;
        Ok(found)
    }

    #[pyo3(signature = (floor = 0.1, weighting = "samples"))]
    fn fit<'py>(
        &mut self,
        py: Python<'py>,
        floor: f64,
        weighting: &str,
    ) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        let (floor, weighting) = (options::floor(floor)?, options::weighting(weighting)?);
        with_density!(&mut self.density, density => {
            let fitted = py.detach(|| density.fit(floor, weighting)).map_err(value_error)?;
            let shape = density.density().basis().shape();
            fitted.map(|values| array(py, &shape, values.into_iter())).transpose()
        })
    }

    fn refine(&mut self, py: Python<'_>, levels: PerAxis<Whole>) -> PyResult<()> {
        with_density!(&mut self.density, density => {
            let levels = levels.levels()?;
            check_size(density.scales(), levels)?;
            py.detach(|| density.refine(levels)).map_err(value_error)
        })
    }

    fn copy(&self) -> Self {
        Self { density: self.density.clone(), max_level: self.max_level }
    }

    fn __repr__(&self) -> String {
        with_density!(&self.density, density => {
            format!("<glanz.sampling.AdaptiveDensity on levels {:?}>", density.levels())
        })
    }
}

impl DensityObject {
    /// The density after an integration.
    pub(super) fn of<const D: usize>(density: AdaptiveDensity<D>, max_level: usize) -> Self
    where
        AnyDensity: From<AdaptiveDensity<D>>,
    {
        Self { density: density.into(), max_level }
    }
}
