//! Pictures with their arrays.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glanz::formats::image::{self, Encoding, Format};
use glanz::job::JobEnd;
use glanz::light::{Channel, Pixels, Tone};
use glanz::{Error, Picture, picture_format};
use numpy::{PyReadonlyArray3, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{IntoPyDict, PyBytes, PyDict};

use crate::arguments::tone as tone_of;
use crate::error::{LineOrigins, failure, os_error, py_error};
use crate::image_array::{array_name, array_place, image_array, interleaved, three_bands, triples};

/// A picture: rendered, joined from parts, read from a file, or made of an array.
///
/// Parameters
/// ----------
/// array
///     H x W x 3 or H x W: linear light of any type of float, or sRGB bytes (uint8).
///
/// Raises
/// ------
/// ValueError
///     If the array has another shape or no pixels.
/// TypeError
///     If its elements are neither floats nor uint8.
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
        let dtype = array.getattr("dtype")?;
        let is_display = dtype.getattr("name")?.extract::<String>()? == "uint8";
        if !is_display && dtype.getattr("kind")?.extract::<String>()? != "f" {
            return Err(PyTypeError::new_err(format!(
                "the array has elements of type {dtype}; it must have floats, which are linear light, or uint8, which is sRGB"
            )));
        }
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
            ImageSource::Picture(picture) => {
                work(&py.detach(|| picture.pixels()).map_err(|error| plain(py, error))?)
            }
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
                let bytes = image::write(pixels, picture_format(path)?, tone, &BTreeMap::new());
                let bytes =
                    bytes.map_err(|error| Error::File { path: path.to_owned(), fault: error.into() })?;
                glanz::file::write(path, &bytes)
            }
        }
    }
}

/// An error that is not at a place of a scene.
fn plain(py: Python<'_>, error: Error) -> PyErr {
    py_error(py, error, &LineOrigins::default())
}

#[pymethods]
impl PyImage {
    #[new]
    fn from_array(array: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::of_array(array)
    }

    /// Linear red, green and blue, H x W x 3, from the top left. Always the same array, which may be changed; `save` writes the picture as it
    /// was: make an ``Image`` of a changed array to save it.
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
        let Some(dtype) = dtype else {
            return if copy == Some(true) { array.call_method0("copy") } else { Ok(array) };
        };
        let options = [("copy", copy == Some(true))].into_py_dict(py)?;
        let converted = array.call_method("astype", (dtype,), Some(&options))?;
        if copy == Some(false) && !converted.is(&array) {
            return Err(PyValueError::new_err(
                "the picture has elements of float32: another type needs a copy",
            ));
        }
        Ok(converted)
    }

    /// Further channels by name: ``Albedo``, ``P`` (position, m), ``N`` and ``Ns`` (geometric and shading normal) and ``Variance`` are
    /// H x W x 3, ``uv`` is H x W x 2, ``Z`` (distance, m) and ``id`` (number of the shape, -1 for none) are H x W.
    #[getter]
    fn aovs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let aovs = self.aovs.get_or_try_init(py, || {
            let arrays = PyDict::new(py);
            let (width, height) = self.size();
            self.with_pixels(py, |pixels| {
                let is_more = |channel: &&Channel| !["R", "G", "B", "Y"].contains(&channel.name.as_str());
                let mut channels: Vec<&Channel> = pixels.channels().iter().filter(is_more).collect();
                channels.sort_by(|a, b| array_place(&a.name).cmp(&array_place(&b.name)));
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

    /// Standard error of each value of `array`, if rendered with ``variance=True``.
    #[getter]
    fn standard_error<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let variance = self.aovs(py)?.get_item("Variance")?;
        variance.map(|variance| py.import("numpy")?.call_method1("sqrt", (variance,))).transpose()
    }

    /// Pixels per row.
    #[getter]
    fn width(&self) -> u32 {
        self.size().0
    }

    /// Number of rows.
    #[getter]
    fn height(&self) -> u32 {
        self.size().1
    }

    /// Samples per pixel; None if not rendered.
    #[getter]
    fn samples(&self) -> Option<u64> {
        self.picture().map(|picture| picture.film().samples().total())
    }

    /// The samples as ranges, ends excluded.
    #[getter]
    fn sample_ranges(&self) -> Vec<(u32, u32)> {
        let ranges = self.picture().map(|picture| picture.film().samples().as_slice()).unwrap_or_default();
        ranges.iter().map(|range| (range.start, range.end)).collect()
    }

    /// Whether noise was removed.
    #[getter]
    fn denoised(&self) -> bool {
        self.picture().is_some_and(Picture::is_denoised)
    }

    /// Warnings of the render.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        let warnings = self.picture().map(Picture::warnings).unwrap_or_default();
        warnings.iter().map(ToString::to_string).collect()
    }

    /// Statistics of the render; None if not rendered, zeros if joined from parts.
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

    /// Writes the picture; the extension selects the format: .exr (all channels), .png, .hdr or .pfm.
    ///
    /// Parameters
    /// ----------
    /// path
    ///     The file, which is replaced as a whole.
    /// exposure
    ///     Stops by which PNG pictures are brightened.
    /// tone
    ///     Tone curve of PNG pictures: ``linear``, ``reinhard`` or ``filmic``.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For another extension or curve.
    /// OSError
    ///     If the file cannot be written.
    #[pyo3(signature = (path, *, exposure=0.0, tone="linear"))]
    fn save(&self, py: Python<'_>, path: PathBuf, exposure: f32, tone: &str) -> PyResult<()> {
        let tone = tone_of(exposure, tone)?;
        py.detach(|| self.write(&path, &tone)).map_err(|error| plain(py, error))
    }

    /// Writes the samples, to be resumed by `Scene.render` or joined by `merge`.
    fn save_checkpoint(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let picture = self.rendered()?;
        py.detach(|| picture.save_checkpoint(&path)).map_err(|error| plain(py, error))
    }

    /// Writes the guide that the integrator ``guided`` has learnt, for ``guide_input``.
    fn save_guide(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let picture = self.rendered()?;
        py.detach(|| picture.save_guide(&path)).map_err(|error| plain(py, error))
    }

    /// The picture as the bytes of a PNG file.
    #[pyo3(signature = (*, exposure=0.0, tone="linear"))]
    fn to_png<'py>(&self, py: Python<'py>, exposure: f32, tone: &str) -> PyResult<Bound<'py, PyBytes>> {
        let tone = tone_of(exposure, tone)?;
        let written = self.with_pixels(py, |pixels| {
            Ok(py.detach(|| image::write(pixels, Format::Png, &tone, &BTreeMap::new())))
        })?;
        Ok(PyBytes::new(py, &written.map_err(|error| failure(py, error.to_string()))?))
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

/// Reads a picture: OpenEXR, PNG, Radiance HDR, PFM, JPEG, TGA, BMP, QOI or PNM.
///
/// Raises
/// ------
/// OSError
///     If the file cannot be read.
/// GlanzError
///     If it is not a picture.
#[pyfunction]
pub(crate) fn read_image(py: Python<'_>, path: PathBuf) -> PyResult<PyImage> {
    PyImage::read(py, &path)
}
