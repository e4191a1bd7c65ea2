//! Joining of the checkpoints of parts.

use std::path::PathBuf;

use glanz::file::FileUses;
use glanz::{MergeOptions, MergeOutcome};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arguments::Whole;
use crate::error::{LineOrigins, failure, py_error, warn};
use crate::image::PyImage;
use crate::job::{JobArguments, run_job};

/// Joins checkpoints of disjoint samples into one picture, with the bits of one render of all samples. Files are read once; they take the
/// memory of one of them.
///
/// Parameters
/// ----------
/// paths
///     Checkpoints of renders with ``part`` or ``sample_range``.
/// partial
///     Whether parts that are missing or damaged are left out, with a warning, instead of being errors.
/// threads, progress
///     As for `Scene.render`.
///
/// Raises
/// ------
/// GlanzError
///     For parts of different pictures or with common samples, and for missing or damaged ones.
/// OSError
///     If a file cannot be read.
#[pyfunction]
#[pyo3(signature = (paths, *, partial=false, threads=None, progress=None))]
pub(crate) fn merge(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    partial: bool,
    threads: Option<Whole>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<PyImage> {
    match joined(
        py,
        &paths,
        MergeOptions { partial, picture: true, ..MergeOptions::default() },
        threads,
        progress,
    )? {
        MergeOutcome::Picture(picture) => Ok(PyImage::of_picture(*picture)),
        _ => Err(failure(py, "the parts are not of a picture".to_owned())),
    }
}

/// Joins checkpoints of parts of a picture, a calculation of illuminance or a bake into the file ``checkpoint``, from which the job is resumed.
///
/// Parameters and exceptions are those of `merge`. The whole and one part are in memory, sums of a picture that take more than half of it in temporary files.
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
    let failed = |error| py_error(py, error, &LineOrigins::default());
    let mut files = FileUses::default();
    files.add_inputs(&paths).and_then(|()| files.add_output(&checkpoint)).map_err(failed)?;
    // A running job would replace it by its own state.
    let _claim = glanz::file::claim_checkpoint(&checkpoint).map_err(failed)?;
    let outcome = joined(py, &paths, MergeOptions { partial, ..MergeOptions::default() }, threads, progress)?;
    py.detach(|| outcome.save_checkpoint(&checkpoint)).map_err(failed)
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
