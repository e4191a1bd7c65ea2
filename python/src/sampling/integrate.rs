//! Integrals of Python functions.

use std::sync::Arc;

use glanz::sampling::DensityError;
use glanz::sampling::density::{AdaptiveDensity, DensitySample};
use glanz::sampling::integrate::{
    AdaptivePlan, Estimate, IntegrationPass, IntegrationPlan, integrate_adaptively_by_blocks,
    integrate_by_blocks,
};
use pyo3::prelude::*;

use super::density::{AnyDensity, DensityObject, no_dimension};
use super::options::{MAX_LEVEL, PerAxis, analyses, check_size, floor, method, pattern, weighting};
use crate::arguments::{Whole, value_error};
use crate::float_array::{FloatArray, array};

/// The levels and the number of samples of one pass.
type PassTuple = (PerAxis<Whole>, Whole);

/// An integral; see `glanz.sampling.Integral`.
#[pyclass(name = "Integral", module = "glanz.sampling", frozen, get_all)]
pub(crate) struct IntegralEstimate {
    mean: f64,
    standard_error: f64,
    primary_variance: f64,
    samples: u64,
}

impl From<Estimate> for IntegralEstimate {
    fn from(estimate: Estimate) -> Self {
        let Estimate { samples, mean, primary_variance, .. } = estimate;
        Self { mean, standard_error: estimate.standard_error(), primary_variance, samples }
    }
}

#[pymethods]
impl IntegralEstimate {
    fn __repr__(&self) -> String {
        let Self { mean, standard_error, primary_variance, samples } = self;
        format!(
            "Integral(mean={mean:?}, standard_error={standard_error:?}, primary_variance={primary_variance:?}, \
             samples={samples})"
        )
    }
}

/// An integral in passes; see `glanz.sampling.AdaptiveIntegral`.
#[pyclass(name = "AdaptiveIntegral", module = "glanz.sampling", frozen, get_all)]
pub(crate) struct AdaptiveEstimate {
    total: Py<IntegralEstimate>,
    passes: Vec<Py<IntegralEstimate>>,
    density: Py<DensityObject>,
}

/// An error of the integrator or of the integrand.
enum IntegrationError {
    Density(DensityError),
    Python(PyErr),
}

impl From<DensityError> for IntegrationError {
    fn from(error: DensityError) -> Self {
        Self::Density(error)
    }
}

impl From<PyErr> for IntegrationError {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<IntegrationError> for PyErr {
    fn from(error: IntegrationError) -> Self {
        match error {
            IntegrationError::Density(error) => value_error(error),
            IntegrationError::Python(error) => error,
        }
    }
}

/// A Python function of points, and the receiver of progress.
struct Integrand<'a, 'py> {
    function: &'a Bound<'py, PyAny>,
    progress: Option<&'a Bound<'py, PyAny>>,
    done: u64,
    total: u64,
}

impl Integrand<'_, '_> {
    /// Writes the values at these samples.
    fn evaluate<const D: usize>(&mut self, samples: &[DensitySample<D>], values: &mut [f64]) -> PyResult<()> {
        let py = self.function.py();
        py.check_signals()?;
        let points = array(py, &[samples.len(), D], samples.iter().flat_map(|sample| sample.point))?;
        let found = FloatArray::new("the values of the integrand", &self.function.call1((points,))?)?;
        values.copy_from_slice(found.of_length(samples.len(), "one number per point")?);
        self.done += samples.len() as u64;
        if let Some(progress) = self.progress {
            progress.call1((self.done, self.total))?;
        }
        Ok(())
    }
}

/// Arguments of an integration.
struct IntegrationArguments<'a> {
    basis: &'a PerAxis<String>,
    passes: &'a [PassTuple],
    max_level: usize,
    repetitions: u32,
    pattern: &'a str,
    seed: u64,
    floor: f64,
    method: &'a str,
    weighting: &'a str,
}

fn integrate_in<const D: usize>(
    mut integrand: Integrand<'_, '_>,
    arguments: &IntegrationArguments<'_>,
) -> PyResult<AdaptiveEstimate>
where
    AnyDensity: From<AdaptiveDensity<D>>,
{
    let py = integrand.function.py();
    let scales = Arc::new(analyses::<D>(arguments.basis, arguments.max_level)?);
    let mut passes = Vec::with_capacity(arguments.passes.len());
    let sampling = pattern(arguments.pattern)?;
    for (levels, samples) in arguments.passes {
        let (levels, samples) = (levels.levels()?, samples.within("samples", 1..=u32::MAX)?);
        check_size(&scales, levels)?;
        passes.push(IntegrationPass { levels, samples });
        let points = u64::from(sampling.count(samples, D)) * u64::from(arguments.repetitions);
        integrand.total = integrand.total.saturating_add(points);
    }
    let plan = AdaptivePlan {
        passes,
        repetitions: arguments.repetitions,
        sampling,
        seed: arguments.seed,
        floor: floor(arguments.floor)?,
        method: method(arguments.method)?,
        weighting: weighting(arguments.weighting)?,
    };
    let found = integrate_adaptively_by_blocks(&scales, &plan, |samples, values| {
        integrand.evaluate(samples, values).map_err(IntegrationError::from)
    })?;
    let passes = found.passes.iter().map(|pass| Py::new(py, IntegralEstimate::from(pass.estimate)));
    Ok(AdaptiveEstimate {
        total: Py::new(py, IntegralEstimate::from(found.estimate))?,
        passes: passes.collect::<PyResult<_>>()?,
        density: Py::new(py, DensityObject::of(found.adaptive, arguments.max_level))?,
    })
}

#[pyfunction]
#[pyo3(signature = (
    integrand, dimension, passes, *, basis = None, max_level = Whole(8), repetitions = Whole(1), pattern = "independent", seed = Whole(1),
    floor = 0.1, method = "own", weighting = "samples", progress = None
))]
#[expect(clippy::too_many_arguments, reason = "they are the keywords of the Python function")]
pub(crate) fn integrate(
    integrand: &Bound<'_, PyAny>,
    dimension: Whole,
    passes: Vec<PassTuple>,
    basis: Option<PerAxis<String>>,
    max_level: Whole,
    repetitions: Whole,
    pattern: &str,
    seed: Whole,
    floor: f64,
    method: &str,
    weighting: &str,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<AdaptiveEstimate> {
    let basis = basis.unwrap_or_else(|| PerAxis::One(String::from("spline1")));
    let arguments = IntegrationArguments {
        basis: &basis,
        passes: &passes,
        max_level: max_level.within("max_level", 0..=MAX_LEVEL)? as usize,
        repetitions: repetitions.within("repetitions", 1..=u32::MAX)?,
        pattern,
        seed: seed.0,
        floor,
        method,
        weighting,
    };
    let integrand = Integrand { function: integrand, progress, done: 0, total: 0 };
    match dimension.0 {
        1 => integrate_in::<1>(integrand, &arguments),
        2 => integrate_in::<2>(integrand, &arguments),
        3 => integrate_in::<3>(integrand, &arguments),
        4 => integrate_in::<4>(integrand, &arguments),
        other => Err(no_dimension(other)),
    }
}

/// One pass: the integral by samples of the density, which are recorded.
pub(super) fn record_pass<const D: usize>(
    density: &mut AdaptiveDensity<D>,
    function: &Bound<'_, PyAny>,
    plan: &IntegrationPlan,
) -> PyResult<IntegralEstimate> {
    let mut integrand = Integrand { function, progress: None, done: 0, total: u64::from(plan.samples) };
    let drawn = density.density().clone();
    let estimate = integrate_by_blocks(&drawn, plan, |samples, values| {
        integrand.evaluate(samples, values)?;
        for (sample, value) in samples.iter().zip(values) {
            density.record(sample, *value);
        }
        Ok::<(), IntegrationError>(())
    })?;
    Ok(estimate.into())
}
