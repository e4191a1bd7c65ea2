//! Pictures with their arrays.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glanz::formats::image::{self, Encoding, Format};
use glanz::job::JobEnd;
use glanz::light::{Channel, Pixels, Tone};
use glanz::{Error, Picture, picture_format};
use numpy::{IntoPyArray, PyArray3, PyArrayMethods, PyReadonlyArray3, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBytes, PyDict};

use crate::arguments::tone as tone_of;
use crate::error::{LineOrigins, failure, os_error, py_error};

/// A picture: rendered, joined, read from a file or made of an array.
#[pyclass(name = "Image", module = "glanz", frozen)]
pub(crate) struct PyImage {
    source: ImageSource,
    array: PyOnceLock<Py<PyAny>>,
    aovs: PyOnceLock<Py<PyDict>>,
}

/// Origin of the pixels.
enum ImageSource {
    Picture(Box<Picture>),
    Pixels { pixels: Pixels, is_display: bool },
}

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
fn interleaved(planes: &[&[f32]]) -> Vec<f32> {
    let len = planes.first().map_or(0, |plane| plane.len());
    let mut values = Vec::with_capacity(len * planes.len());
    for pixel in 0..len {
        values.extend(planes.iter().filter_map(|plane| plane.get(pixel)));
    }
    values
}

/// Name of the array to which a channel belongs: that of the channel without its component.
fn array_name(channel: &str) -> &str {
    match channel {
        "u" | "v" => "uv",
        name => name.rsplit_once('.').map_or(name, |(array, _)| array),
    }
}

impl PyImage {
    fn new(source: ImageSource) -> Self {
        Self { source, array: PyOnceLock::new(), aovs: PyOnceLock::new() }
    }

    pub(crate) fn of_picture(picture: Picture) -> Self {
        Self::new(ImageSource::Picture(Box::new(picture)))
    }

    /// The image of an array: H x W x 3 or H x W of light, or of sRGB bytes.
    pub(crate) fn of_array(array: &Bound<'_, PyAny>) -> PyResult<Self> {
        let py = array.py();
        let array = py.import("numpy")?.call_method1("asarray", (array,))?;
        let untyped = array.cast::<PyUntypedArray>()?;
        let shape = untyped.shape().to_vec();
        let (&[height, width] | &[height, width, 3]) = shape.as_slice() else {
            let message =
                format!("the array has the shape {shape:?}; it must be height x width x 3 or height x width");
            return Err(PyValueError::new_err(message));
        };
        let is_display = array.getattr("dtype")?.getattr("kind")?.extract::<String>()? == "u";
        let grey = shape.len() == 2;
        let size = [width, height].map(|side| u32::try_from(side).unwrap_or(0));
        let pixels = if is_display {
            let bytes: PyReadonlyArray3<'_, u8> = three_bands(&array, "uint8", grey)?;
            let bytes: Vec<[u8; 3]> = triples(bytes.as_slice()?);
            Pixels::try_from_srgb8(size[0], size[1], &bytes)
        } else {
            let light: PyReadonlyArray3<'_, f32> = three_bands(&array, "float32", grey)?;
            let light: Vec<[f32; 3]> = triples(light.as_slice()?);
            Pixels::try_from_rgb(size[0], size[1], &light)
        };
        let pixels = pixels.map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(Self::new(ImageSource::Pixels { pixels, is_display }))
    }

    pub(crate) fn read(py: Python<'_>, path: &Path) -> PyResult<Self> {
        let read = py.detach(|| {
            let bytes = std::fs::read(path).map_err(|error| os_error(path, &error))?;
            Ok::<_, PyErr>(image::read(&bytes, Some(path), Encoding::Srgb))
        })?;
        let read = read.map_err(|error| failure(py, format!("{}: {error}", path.display())))?;
        Ok(Self::new(ImageSource::Pixels { pixels: read.pixels, is_display: read.format == Format::Png }))
    }

    /// Whether the values are those of a display, so that differences are compared as displayed.
    pub(crate) fn is_display(&self) -> bool {
        matches!(self.source, ImageSource::Pixels { is_display: true, .. })
    }

    pub(crate) fn with_pixels<T>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&Pixels) -> PyResult<T>,
    ) -> PyResult<T> {
        match &self.source {
            ImageSource::Picture(picture) => work(&picture.pixels().map_err(|error| plain(py, error))?),
            ImageSource::Pixels { pixels, .. } => work(pixels),
        }
    }

    fn picture(&self) -> Option<&Picture> {
        match &self.source {
            ImageSource::Picture(picture) => Some(picture),
            ImageSource::Pixels { .. } => None,
        }
    }

    fn rendered(&self) -> PyResult<&Picture> {
        self.picture()
            .ok_or_else(|| PyValueError::new_err("only a rendered picture has a checkpoint or a guide"))
    }

    fn size(&self) -> (u32, u32) {
        match &self.source {
            ImageSource::Picture(picture) => picture.film().format().crop.size.into(),
            ImageSource::Pixels { pixels, .. } => (pixels.width(), pixels.height()),
        }
    }

    fn write(&self, path: &Path, tone: &Tone) -> Result<(), Error> {
        match &self.source {
            ImageSource::Picture(picture) => picture.save_with(path, tone),
            ImageSource::Pixels { pixels, .. } => {
                let bytes = image::write(pixels, picture_format(path)?, tone, &BTreeMap::new())?;
                glanz::file::write(path, &bytes)
            }
        }
    }
}

/// An error that is not at a place of a scene.
fn plain(py: Python<'_>, error: Error) -> PyErr {
    py_error(py, error, &LineOrigins::default())
}

/// The array as height x width x 3 of a type, contiguous.
fn three_bands<'py, T: numpy::Element>(
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
    Ok(array.cast::<PyArray3<T>>()?.readonly())
}

fn triples<T: Copy>(values: &[T]) -> Vec<[T; 3]> {
    values.as_chunks().0.to_vec()
}

#[pymethods]
impl PyImage {
    #[new]
    fn from_array(array: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::of_array(array)
    }

    #[getter]
    fn array<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let array = self.array.get_or_try_init(py, || {
            let rgb = self.with_pixels(py, |pixels| {
                pixels.to_rgb().ok_or_else(|| PyValueError::new_err("the picture has no colours"))
            })?;
            let (width, height) = self.size();
            image_array(py, rgb.into_flattened(), [width, height], 3).map(Bound::unbind)
        })?;
        Ok(array.bind(py).clone())
    }

    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let array = self.array(py)?;
        let array = match dtype {
            Some(dtype) => array.call_method1("astype", (dtype,))?,
            None => array,
        };
        if copy == Some(true) { array.call_method0("copy") } else { Ok(array) }
    }

    #[getter]
    fn aovs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let aovs = self.aovs.get_or_try_init(py, || {
            let arrays = PyDict::new(py);
            let (width, height) = self.size();
            self.with_pixels(py, |pixels| {
                let is_more = |channel: &&Channel| !["R", "G", "B", "Y"].contains(&channel.name.as_str());
                let channels: Vec<&Channel> = pixels.channels().iter().filter(is_more).collect();
                for group in channels.chunk_by(|a, b| array_name(&a.name) == array_name(&b.name)) {
                    let planes: Vec<&[f32]> = group.iter().map(|channel| channel.values.as_slice()).collect();
                    let array = image_array(py, interleaved(&planes), [width, height], planes.len())?;
                    arrays.set_item(group.first().map(|channel| array_name(&channel.name)), array)?;
                }
                Ok(())
            })?;
            Ok::<_, PyErr>(arrays.unbind())
        })?;
        Ok(aovs.bind(py).clone())
    }

    #[getter]
    fn standard_error<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let variance = self.aovs(py)?.get_item("Variance")?;
        variance.map(|variance| py.import("numpy")?.call_method1("sqrt", (variance,))).transpose()
    }

    #[getter]
    fn width(&self) -> u32 {
        self.size().0
    }

    #[getter]
    fn height(&self) -> u32 {
        self.size().1
    }

    #[getter]
    fn samples(&self) -> Option<u64> {
        self.picture().map(|picture| picture.film().samples().total())
    }

    #[getter]
    fn sample_ranges(&self) -> Vec<(u32, u32)> {
        let ranges = self.picture().map(|picture| picture.film().samples().as_slice()).unwrap_or_default();
        ranges.iter().map(|range| (range.start, range.end)).collect()
    }

    #[getter]
    fn denoised(&self) -> bool {
        self.picture().is_some_and(Picture::is_denoised)
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        let warnings = self.picture().map(Picture::warnings).unwrap_or_default();
        warnings.iter().map(ToString::to_string).collect()
    }

    #[getter]
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(picture) = self.picture() else { return Ok(None) };
        let (statistics, identity) = (picture.statistics(), picture.identity());
        let end = match statistics.end {
            JobEnd::Complete => "complete",
            JobEnd::TimeUp => "time",
            JobEnd::Interrupted => "interrupted",
        };
        let values = PyDict::new(py);
        values.set_item("end", end)?;
        values.set_item("seconds", statistics.elapsed.as_secs_f64())?;
        values.set_item("rays", statistics.counters.rays())?;
        values.set_item("samples", statistics.samples)?;
        values.set_item("undecided", statistics.undecided)?;
        values.set_item("threads", statistics.threads)?;
        values.set_item("integrator", identity.integrator.to_string())?;
        values.set_item("sampler", identity.sampler.name())?;
        values.set_item("seed", identity.seed)?;
        py.import("glanz._results")?.getattr("RenderStatistics")?.call((), Some(&values)).map(Some)
    }

    #[pyo3(signature = (path, *, exposure=0.0, tone="linear"))]
    fn save(&self, py: Python<'_>, path: PathBuf, exposure: f32, tone: &str) -> PyResult<()> {
        let tone = tone_of(exposure, tone)?;
        py.detach(|| self.write(&path, &tone)).map_err(|error| plain(py, error))
    }

    fn save_checkpoint(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let picture = self.rendered()?;
        py.detach(|| picture.save_checkpoint(&path)).map_err(|error| plain(py, error))
    }

    fn save_guide(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let picture = self.rendered()?;
        py.detach(|| picture.save_guide(&path)).map_err(|error| plain(py, error))
    }

    #[pyo3(signature = (*, exposure=0.0, tone="linear"))]
    fn to_png<'py>(&self, py: Python<'py>, exposure: f32, tone: &str) -> PyResult<Bound<'py, PyBytes>> {
        let tone = tone_of(exposure, tone)?;
        let written = self.with_pixels(py, |pixels| {
            Ok(py.detach(|| image::write(pixels, Format::Png, &tone, &BTreeMap::new())))
        })?;
        Ok(PyBytes::new(py, &written.map_err(|error| plain(py, error.into()))?))
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.to_png(py, 0.0, "linear")
    }

    fn __repr__(&self) -> String {
        let (width, height) = self.size();
        let samples =
            self.samples().map_or_else(String::new, |samples| format!(", {samples} samples per pixel"));
        format!("<glanz.Image {width} x {height}{samples}>")
    }
}

/// Reads a picture file.
#[pyfunction]
pub(crate) fn read_image(py: Python<'_>, path: PathBuf) -> PyResult<PyImage> {
    PyImage::read(py, &path)
}
