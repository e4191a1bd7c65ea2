//! Values of arguments, with errors that name the argument.

use std::ops::RangeInclusive;
use std::time::Duration;

use glanz::light::{Tone, ToneCurve};
use pyo3::Borrowed;
use pyo3::exceptions::{PyOverflowError, PyValueError};
use pyo3::prelude::*;

/// A whole number from 0 to 2^64 - 1; others are `ValueError`s.
#[derive(Clone, Copy)]
pub(crate) struct Whole(pub(crate) u64);

impl<'py> FromPyObject<'_, 'py> for Whole {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        object.extract().map(Self).map_err(|error: PyErr| {
            if error.is_instance_of::<PyOverflowError>(object.py()) {
                return PyValueError::new_err(format!(
                    "{} is not a whole number from 0 to 2^64 - 1",
                    *object
                ));
            }
            error
        })
    }
}

impl Whole {
    /// The number as an argument `name` in `range`.
    pub(crate) fn within(self, name: &str, range: RangeInclusive<u32>) -> PyResult<u32> {
        u32::try_from(self.0).ok().filter(|number| range.contains(number)).ok_or_else(|| {
            let (start, end) = (range.start(), range.end());
            PyValueError::new_err(format!("{name} is {}; it must be from {start} to {end}", self.0))
        })
    }
}

/// An error of an argument.
pub(crate) fn value_error(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Two whole numbers as an argument `name`, each in `range`.
pub(crate) fn pair(numbers: [Whole; 2], name: &str, range: RangeInclusive<u32>) -> PyResult<[u32; 2]> {
    let [first, second] = numbers;
    Ok([first.within(name, range.clone())?, second.within(name, range)?])
}

/// A positive, finite number as an argument `name`.
pub(crate) fn positive(number: f64, name: &str) -> PyResult<f64> {
    if number > 0.0 && number.is_finite() {
        return Ok(number);
    }
    Err(PyValueError::new_err(format!("{name} is {number}; it must be positive and finite")))
}

/// A time as an argument `name`, seconds.
pub(crate) fn seconds(number: f64, name: &str) -> PyResult<Duration> {
    let time = Duration::try_from_secs_f64(positive(number, name)?);
    time.map_err(|_| PyValueError::new_err(format!("{name} is {number} seconds, which is too long")))
}

/// The value of an argument `what` by its name.
pub(crate) fn by_name<T: Copy>(
    name: &str,
    what: &str,
    values: impl IntoIterator<Item = (T, &'static str)>,
) -> PyResult<T> {
    let mut names = Vec::new();
    for (value, own) in values {
        if own.eq_ignore_ascii_case(name) {
            return Ok(value);
        }
        names.push(format!("{own:?}"));
    }
    Err(PyValueError::new_err(format!("there is no {what} {name:?}; choose one of {}", names.join(", "))))
}

/// The value of a text as an argument `name`.
pub(crate) fn parsed<T: std::str::FromStr<Err: std::fmt::Display>>(text: &str, name: &str) -> PyResult<T> {
    text.parse().map_err(|error| PyValueError::new_err(format!("{name} is {text:?}: {error}")))
}

/// Exposure, stops, and tone curve.
pub(crate) fn tone(exposure: f32, curve: &str) -> PyResult<Tone> {
    let curves =
        [(ToneCurve::Linear, "linear"), (ToneCurve::Reinhard, "reinhard"), (ToneCurve::Filmic, "filmic")];
    if !exposure.is_finite() {
        return Err(PyValueError::new_err(format!("exposure is {exposure}; it must be finite")));
    }
    Ok(Tone { exposure_stops: exposure, curve: by_name(curve, "tone curve", curves)? })
}
