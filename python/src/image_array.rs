//! Values of pictures in arrays.

use numpy::{IntoPyArray, PyArray3, PyArrayMethods, PyReadonlyArray3};
use pyo3::prelude::*;

/// Values of a picture, row by row, with `bands` values per pixel, as an array of height x width x bands, or height x width for one band.
pub(crate) fn image_array<'py>(
    py: Python<'py>,
    values: Vec<f32>,
    [width, height]: [u32; 2],
    bands: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let (height, width) = (height as usize, width as usize);
    let flat = values.into_pyarray(py);
    Ok(match bands {
        1 => flat.reshape([height, width])?.into_any(),
        _ => flat.reshape([height, width, bands])?.into_any(),
    })
}

/// The values of several planes, pixel by pixel.
pub(crate) fn interleaved(planes: &[&[f32]]) -> Vec<f32> {
    let len = planes.first().map_or(0, |plane| plane.len());
    let mut values = Vec::with_capacity(len * planes.len());
    for pixel in 0..len {
        values.extend(planes.iter().filter_map(|plane| plane.get(pixel)));
    }
    values
}

/// Name of the array to which a channel belongs: that of the channel without its component.
pub(crate) fn array_name(channel: &str) -> &str {
    match channel {
        "u" | "v" => "uv",
        name => name.rsplit_once('.').map_or(name, |(array, _)| array),
    }
}

/// The array of a channel, and the place of its component there: files sort channels by name, so that B comes before G and R.
pub(crate) fn array_place(channel: &str) -> (&str, usize) {
    let component = channel.rsplit_once('.').map_or(channel, |(_, component)| component);
    let place = ["R", "G", "B", "A"].iter().position(|name| *name == component);
    (array_name(channel), place.unwrap_or(0))
}

/// The array as height x width x 3 of a type, contiguous.
pub(crate) fn three_bands<'py, T: numpy::Element>(
    array: &Bound<'py, PyAny>,
    kind: &str,
    grey: bool,
) -> PyResult<PyReadonlyArray3<'py, T>> {
    let numpy = array.py().import("numpy")?;
    let array = match grey {
        true => numpy.call_method1("stack", (vec![array; 3], -1))?,
        false => array.clone(),
    };
    let array = numpy.call_method1("ascontiguousarray", (array, kind))?;
    Ok(array.cast::<PyArray3<T>>()?.try_readonly()?)
}

/// The values in groups of three.
pub(crate) fn triples<T: Copy>(values: &[T]) -> Vec<[T; 3]> {
    values.as_chunks().0.to_vec()
}
