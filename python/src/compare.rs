//! Differences between two pictures.

use std::path::PathBuf;

use glanz::light::compare::{RELATIVE_EPSILON, compare as compare_pixels};
use glanz::light::flip;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::image::PyImage;
use crate::image_array::image_array;

/// A picture as an image: an image, an array, or the path of a file.
fn image<'py>(picture: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyImage>> {
    let py = picture.py();
    if let Ok(image) = picture.cast::<PyImage>() {
        return Ok(image.clone());
    }
    let is_path = picture.is_instance_of::<PyString>() || picture.hasattr("__fspath__")?;
    let image =
        if is_path { PyImage::read(py, &picture.extract::<PathBuf>()?) } else { PyImage::of_array(picture) };
    Bound::new(py, image?)
}

/// Measures the differences of a picture from a reference, as ``glanz compare`` does.
///
/// Parameters
/// ----------
/// picture, reference
///     Images, arrays (see `Image`) or paths of picture files, of the same size. If one is a PNG file or has bytes, FLIP compares both as
///     displayed, otherwise as light at all relevant exposures.
///
/// Raises
/// ------
/// ValueError
///     For pictures of different sizes, or without a pixel that is finite in both.
#[pyfunction]
pub(crate) fn compare<'py>(
    picture: &Bound<'py, PyAny>,
    reference: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = picture.py();
    let (picture, reference) = (image(picture)?, image(reference)?);
    let (picture, reference) = (picture.get(), reference.get());
    let is_display = picture.is_display() || reference.is_display();
    let flip = if is_display { flip::ldr } else { flip::hdr };
    let (comparison, flip) = picture.with_pixels(py, |test| {
        reference.with_pixels(py, |reference| {
            let measured = py.detach(|| {
                let comparison = compare_pixels(test, reference, RELATIVE_EPSILON)?;
                flip(test, reference, flip::PIXELS_PER_DEGREE).map(|map| (comparison, map))
            });
            measured.map_err(|error| PyValueError::new_err(error.to_string()))
        })
    })?;
    let values = PyDict::new(py);
    values.set_item("rmse", comparison.rmse)?;
    values.set_item("relmse", comparison.relative_mse)?;
    values.set_item("display_rmse", comparison.clipped_rmse)?;
    values.set_item("max", comparison.max_error)?;
    values.set_item("max_at", comparison.max_at)?;
    values.set_item("flip", flip.mean)?;
    values.set_item("mean", comparison.mean_test.to_vec())?;
    values.set_item("reference_mean", comparison.mean_reference.to_vec())?;
    values.set_item("excluded_pixels", comparison.excluded_test + comparison.excluded_reference)?;
    values.set_item("flip_map", image_array(py, flip.errors, [flip.width, flip.height], 1)?)?;
    py.import("glanz._results")?.getattr("Comparison")?.call((), Some(&values))
}
