//! Arrays of numbers from Python, and arrays for Python.

use numpy::{Element, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyEllipsis, PyTuple};
use rayon::prelude::*;

/// Rows of cheap values after which signals are handled.
pub(crate) const ROWS_AT_ONCE: usize = 1 << 17;

/// Numbers that one thread computes at once; fewer are computed without other threads.
const PARALLEL_ROWS: usize = 256;

/// A C-contiguous array of `f64`: that of the caller if it is one, a converted copy otherwise.
pub(crate) struct FloatArray<'py> {
    name: &'static str,
    array: PyReadonlyArrayDyn<'py, f64>,
}

impl<'py> FloatArray<'py> {
    /// The numbers of `object`, which is called `name` in messages.
    ///
    /// # Errors
    /// `TypeError` unless they are real numbers, `ValueError` for lists of unequal lengths.
    pub(crate) fn new(name: &'static str, object: &Bound<'py, PyAny>) -> PyResult<Self> {
        let py = object.py();
        let numpy = py.import("numpy")?;
        let options = [
            ("casting", "same_kind".into_pyobject(py)?.into_any()),
            ("copy", false.into_pyobject(py)?.to_owned().into_any()),
        ];
        let found = numpy.call_method1("asarray", (object,))?;
        let numbers =
            found.call_method("astype", ("float64",), Some(&options.into_py_dict(py)?)).map_err(|error| {
                if !error.is_instance_of::<PyTypeError>(py) {
                    return error;
                }
                let kind = found.getattr("dtype").map(|kind| kind.to_string()).unwrap_or_default();
                PyTypeError::new_err(format!("{name} is an array of {kind}; it must be one of real numbers"))
            })?;
        let contiguous = numpy.call_method1("require", (numbers, py.None(), ["C", "A"]))?;
        Ok(Self { name, array: contiguous.cast_into::<PyArrayDyn<f64>>()?.try_readonly()? })
    }

    /// Both arrays, with one shape: that which numpy broadcasts them to.
    ///
    /// # Errors
    /// As [`FloatArray::new`]; `ValueError` if they have no common shape.
    pub(crate) fn pair(names: [&'static str; 2], objects: [&Bound<'py, PyAny>; 2]) -> PyResult<[Self; 2]> {
        let [a, b] = [Self::new(names[0], objects[0])?, Self::new(names[1], objects[1])?];
        if a.shape() == b.shape() {
            return Ok([a, b]);
        }
        let numpy = a.array.py().import("numpy")?;
        let both = numpy.call_method1("broadcast_arrays", (&*a.array, &*b.array)).map_err(|_| {
            let (one, other) = (Shape(a.shape()), Shape(b.shape()));
            PyValueError::new_err(format!(
                "{} has shape {one}, {} has {other}; they must broadcast to one shape",
                a.name, b.name
            ))
        })?;
        Ok([Self::new(names[0], &both.get_item(0)?)?, Self::new(names[1], &both.get_item(1)?)?])
    }

    pub(crate) fn shape(&self) -> &[usize] {
        self.array.shape()
    }

    /// The numbers, the last axis fastest.
    ///
    /// # Errors
    /// None: the array is contiguous.
    pub(crate) fn values(&self) -> PyResult<&[f64]> {
        Ok(self.array.as_slice()?)
    }

    /// The numbers of a list of this length.
    ///
    /// # Errors
    /// `ValueError` with `form`, the shape in words.
    pub(crate) fn of_length(&self, length: usize, form: &str) -> PyResult<&[f64]> {
        if self.shape() == [length] { self.values() } else { Err(self.wrong_shape(form)) }
    }

    fn wrong_shape(&self, form: &str) -> PyErr {
        let (name, shape) = (self.name, Shape(self.shape()));
        PyValueError::new_err(format!("{name} has shape {shape}; it must be {form}"))
    }

    /// The numbers, if the shape is that of `expected`, in which 0 stands for any length.
    ///
    /// # Errors
    /// `ValueError` with `form`, the shape in words.
    pub(crate) fn of_shape(&self, expected: &[usize], form: &str) -> PyResult<&[f64]> {
        let shape = self.shape();
        let fits = |(&found, &length): (&usize, &usize)| length == 0 || found == length;
        if shape.len() == expected.len() && shape.iter().zip(expected).all(fits) {
            return self.values();
        }
        Err(self.wrong_shape(form))
    }
}

/// A shape as Python writes it.
struct Shape<'a>(&'a [usize]);

impl std::fmt::Display for Shape<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let lengths: Vec<String> = self.0.iter().map(usize::to_string).collect();
        let comma = if lengths.len() == 1 { "," } else { "" };
        write!(f, "({}{comma})", lengths.join(", "))
    }
}

/// A new array of zeros. Its pages are mapped when they are written, by the threads that do.
///
/// # Errors
/// `MemoryError`.
pub(crate) fn zeros<'py, T: Element>(
    py: Python<'py>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let shape = PyTuple::new(py, shape)?;
    let array = py.import("numpy")?.call_method1("zeros", (shape, T::get_dtype(py)))?;
    Ok(array.cast_into()?)
}

/// A new array of shape `shape` x `width`, whose rows `row` writes on all threads, from the position of the row.
///
/// `rows_at_once`: number of rows after which signals are handled.
///
/// # Errors
/// `MemoryError`, `KeyboardInterrupt`.
pub(crate) fn rows<'py>(
    py: Python<'py>,
    shape: &[usize],
    width: &[usize],
    rows_at_once: usize,
    row: impl Fn(usize, &mut [f64]) + Sync,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let array = zeros(py, &[shape, width].concat())?;
    let width: usize = width.iter().product();
    let mut written = array.try_readwrite()?;
    for (part, rows) in written.as_slice_mut()?.chunks_mut(rows_at_once * width).enumerate() {
        py.check_signals()?;
        let first = part * rows_at_once;
        py.detach(|| {
            let count = rows.len() / width;
            if count < PARALLEL_ROWS && rows_at_once > PARALLEL_ROWS {
                rows.chunks_exact_mut(width).enumerate().for_each(|(i, values)| row(first + i, values));
            } else {
                let rows = rows.par_chunks_exact_mut(width).enumerate();
                rows.for_each(|(i, values)| row(first + i, values));
            }
        });
    }
    drop(written);
    Ok(array)
}

/// A new array of numbers with this shape.
///
/// # Errors
/// `MemoryError`.
pub(crate) fn array<'py>(
    py: Python<'py>,
    shape: &[usize],
    values: impl Iterator<Item = f64>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let array = zeros(py, shape)?;
    let mut written = array.try_readwrite()?;
    written.as_slice_mut()?.iter_mut().zip(values).for_each(|(place, value)| *place = value);
    drop(written);
    Ok(array)
}

/// The part of an array with this index, or these, along its last axis.
///
/// # Errors
/// `IndexError`.
pub(crate) fn along_last<'py>(
    array: &Bound<'py, PyArrayDyn<f64>>,
    index: impl IntoPyObject<'py>,
) -> PyResult<Py<PyAny>> {
    let py = array.py();
    Ok(array.get_item((PyEllipsis::get(py), index))?.unbind())
}
