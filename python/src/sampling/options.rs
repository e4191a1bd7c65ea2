//! Names and numbers that choose bases, levels and methods.

use glanz::sampling::density::{
    CoefficientFloor, FittingMethod, MissingCoefficient, TensorMultiResolution, Weighting,
};
use glanz::sampling::integrate::SamplingPattern;
use glanz::sampling::multiresolution::MultiResolution;
use pyo3::Borrowed;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::arguments::{Whole, by_name, value_error};

/// Largest number of basis functions: their sums take about a gigabyte.
const MAX_FUNCTIONS: usize = 1 << 24;

/// Finest level of any basis.
pub(super) const MAX_LEVEL: u32 = 16;

/// One value for all axes, or one per axis.
pub(super) enum PerAxis<T> {
    One(T),
    Each(Vec<T>),
}

impl<'py, T: for<'a> FromPyObject<'a, 'py, Error = PyErr>> FromPyObject<'_, 'py> for PerAxis<T> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match object.extract::<T>() {
            Ok(one) => Ok(Self::One(one)),
            Err(error) if object.cast::<PyString>().is_ok() || object.try_iter().is_err() => Err(error),
            Err(_) => object.extract().map(Self::Each),
        }
    }
}

impl PerAxis<Whole> {
    /// The levels of `D` axes.
    ///
    /// # Errors
    /// `ValueError` for another number of them, and for levels that no basis has.
    pub(super) fn levels<const D: usize>(&self) -> PyResult<[usize; D]> {
        let mut levels = [0; D];
        for (level, given) in levels.iter_mut().zip(self.of_axes::<D>("levels")?) {
            *level = given.within("level", 0..=MAX_LEVEL)? as usize;
        }
        Ok(levels)
    }
}

impl<T: Clone> PerAxis<T> {
    /// The values of `D` axes.
    ///
    /// # Errors
    /// `ValueError` for another number of them.
    pub(super) fn of_axes<const D: usize>(&self, name: &str) -> PyResult<[T; D]> {
        match self {
            Self::One(value) => Ok(std::array::from_fn(|_| value.clone())),
            Self::Each(values) => values.clone().try_into().map_err(|_| {
                let count = values.len();
                PyValueError::new_err(format!("{name} has {count} entries; give one, or one per axis ({D})"))
            }),
        }
    }
}

/// The analysis of one axis.
fn analysis(name: &str, max_level: usize) -> PyResult<MultiResolution> {
    let degrees = [None, Some(0), Some(1), Some(2), Some(3), Some(4), Some(5), Some(6), Some(7)];
    let names =
        ["haar", "spline0", "spline1", "spline2", "spline3", "spline4", "spline5", "spline6", "spline7"];
    match by_name(name, "basis", degrees.into_iter().zip(names))? {
        None => MultiResolution::haar(max_level),
        Some(degree) => MultiResolution::bspline(degree, max_level),
    }
    .map_err(value_error)
}

/// The analyses of all axes.
///
/// # Errors
/// `ValueError` for names and levels.
pub(super) fn analyses<const D: usize>(
    basis: &PerAxis<String>,
    max_level: usize,
) -> PyResult<TensorMultiResolution<D>> {
    let mut all = Vec::with_capacity(D);
    for name in basis.of_axes::<D>("basis")? {
        all.push(analysis(&name, max_level)?);
    }
    let all = all.try_into().map_err(|_| PyValueError::new_err("basis must have one entry per axis"))?;
    Ok(TensorMultiResolution::new(all))
}

/// Checks the number of functions on these levels.
///
/// # Errors
/// `ValueError` for levels that are missing, and for too many functions.
pub(super) fn check_size<const D: usize>(
    scales: &TensorMultiResolution<D>,
    levels: [usize; D],
) -> PyResult<()> {
    let mut count = 1_usize;
    for (analysis, level) in scales.analyses().iter().zip(levels) {
        count = count.saturating_mul(analysis.basis(level).map_err(value_error)?.len());
    }
    if count > MAX_FUNCTIONS {
        return Err(PyValueError::new_err(format!(
            "levels {levels:?} have {count} functions; at most {MAX_FUNCTIONS} are possible"
        )));
    }
    Ok(())
}

/// The method of fitting.
pub(super) fn method(name: &str) -> PyResult<FittingMethod> {
    let all = [
        (FittingMethod::OwnSamples(MissingCoefficient::Neighbours), "own"),
        (FittingMethod::OwnSamples(MissingCoefficient::Constant), "own-constant"),
        (FittingMethod::AllSamples, "all"),
    ];
    by_name(name, "method", all)
}

/// The pattern of samples.
pub(super) fn pattern(name: &str) -> PyResult<SamplingPattern> {
    let all = [
        (SamplingPattern::Independent, "independent"),
        (SamplingPattern::Stratified, "stratified"),
        (SamplingPattern::Sobol, "sobol"),
    ];
    by_name(name, "pattern", all)
}

/// The weighting of passes.
pub(super) fn weighting(name: &str) -> PyResult<Weighting> {
    by_name(name, "weighting", [(Weighting::Samples, "samples"), (Weighting::InverseVariance, "variance")])
}

/// The lower bound on coefficients: a constant density of this value.
pub(super) fn floor(value: f64) -> PyResult<CoefficientFloor> {
    if (0.0..=1.0).contains(&value) {
        Ok(CoefficientFloor::Constant(value))
    } else {
        Err(PyValueError::new_err(format!("floor is {value}; it must lie between 0 and 1")))
    }
}
