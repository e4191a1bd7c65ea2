//! Joining of the checkpoints of parts.

use std::path::PathBuf;

use glanz::{MergeOptions, MergeOutcome};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arguments::Whole;
use crate::error::{LineOrigins, failure, py_error, warn};
use crate::image::PyImage;
use crate::job::{JobArguments, run_job};

/// Joins the parts of a picture.
#[pyfunction]
#[pyo3(signature = (paths, *, partial=false, threads=None, progress=None))]
pub(crate) fn merge(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    partial: bool,
    threads: Option<Whole>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<PyImage> {
    match joined(py, &paths, MergeOptions { partial, picture: true }, threads, progress)? {
        MergeOutcome::Picture(picture) => Ok(PyImage::of_picture(*picture)),
        _ => Err(failure(py, "the parts are not of a picture".to_owned())),
    }
}

/// Joins the parts of any job into a checkpoint.
#[pyfunction]
#[pyo3(signature = (paths, checkpoint, *, partial=false, threads=None, progress=None))]
pub(crate) fn merge_checkpoints(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    checkpoint: PathBuf,
    partial: bool,
    threads: Option<Whole>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<()> {
    let outcome = joined(py, &paths, MergeOptions { partial, picture: false }, threads, progress)?;
    let saved = py.detach(|| outcome.save_checkpoint(&checkpoint));
    saved.map_err(|error| py_error(py, error, &LineOrigins::default()))
}

fn joined(
    py: Python<'_>,
    paths: &[PathBuf],
    options: MergeOptions,
    threads: Option<Whole>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<MergeOutcome> {
    if paths.is_empty() {
        return Err(PyValueError::new_err("there are no parts to join; name at least one checkpoint"));
    }
    let job = JobArguments { threads, checkpoint: None, resume: false, progress };
    let outcome = run_job(py, job, &LineOrigins::default(), |job| glanz::merge(paths, options, job))?;
    warn(py, outcome.warnings().iter().map(ToString::to_string))?;
    Ok(outcome)
}
