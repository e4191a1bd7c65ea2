//! Conversion of errors and diagnostics of the engine to those of Python.

use std::io;
use std::path::Path;

use glanz::scene::{Diagnostic, Diagnostics};
use glanz::{Error, FileFault};
use pyo3::exceptions::{
    PyFileExistsError, PyFileNotFoundError, PyIsADirectoryError, PyOSError, PyPermissionError, PyValueError,
};
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::image::PyImage;

/// Names of the objects that wrote the lines of a scene built in code.
#[derive(Clone, Debug, Default)]
pub(crate) struct LineOrigins {
    /// Name of the text.
    pub(crate) file: String,
    /// Number of the first line of an object, ascending, and its name.
    pub(crate) objects: Vec<(u32, String)>,
}

impl LineOrigins {
    fn of(&self, diagnostic: &Diagnostic) -> Option<&str> {
        let line = diagnostic.location.filter(|_| diagnostic.file == self.file)?.line;
        let next = self.objects.partition_point(|(first, _)| *first <= line);
        self.objects.get(next.checked_sub(1)?).map(|(_, name)| name.as_str())
    }
}

/// A class of `glanz._errors`.
fn class<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyType>> {
    Ok(py.import("glanz._errors")?.getattr(name)?.cast_into()?)
}

/// A `glanz.GlanzError`.
pub(crate) fn failure(py: Python<'_>, message: String) -> PyErr {
    class(py, "GlanzError").map_or_else(|error| error, |class| PyErr::from_type(class, message))
}

/// The diagnostics as a list of `glanz.Diagnostic`.
pub(crate) fn diagnostics<'py>(
    py: Python<'py>,
    list: &Diagnostics,
    origins: &LineOrigins,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let class = class(py, "Diagnostic")?;
    let limit = list.limit().map(|limit| {
        format!("raise it with limits={{\"{}\": \"{}\"}}", limit.resource.name(), limit.suggestion())
    });
    let of = |diagnostic: &Diagnostic| {
        let help = if diagnostic.kind == "limit" { limit.clone() } else { None };
        let help = help.or_else(|| diagnostic.help.clone());
        let diagnostic = &Diagnostic { help, ..diagnostic.clone() };
        let place = diagnostic.location.map(|location| (location.line, location.column)).unzip();
        let Diagnostic { severity, file, message, help, .. } = diagnostic;
        let text = diagnostic.to_string();
        let object = origins.of(diagnostic);
        class.call1((severity.to_string(), file, place.0, place.1, message, help.as_deref(), text, object))
    };
    list.iter().map(of).collect()
}

/// Issues Python warnings at the line that calls.
pub(crate) fn warn(py: Python<'_>, texts: impl IntoIterator<Item = String>) -> PyResult<()> {
    warn_at(py, 1, texts)
}

/// Issues Python warnings at the line of a caller, 1 for the next one.
pub(crate) fn warn_at(py: Python<'_>, caller: u32, texts: impl IntoIterator<Item = String>) -> PyResult<()> {
    let (warn, category) = (py.import("warnings")?.getattr("warn")?, class(py, "GlanzWarning")?);
    texts.into_iter().try_for_each(|text| warn.call1((text, &category, caller)).map(drop))
}

/// The error as that of Python.
pub(crate) fn py_error(py: Python<'_>, error: Error, origins: &LineOrigins) -> PyErr {
    let message = match advice(&error) {
        Some(advice) => format!("{error}; {advice}"),
        None => error.to_string(),
    };
    match error {
        Error::Scene(list) => scene_error(py, &list, origins).unwrap_or_else(|error| error),
        Error::File { path, fault } => file_error(py, &path, fault, message),
        Error::Unsaved { picture, error } => {
            let error = py_error(py, *error, origins);
            // The picture is complete: it can still be saved.
            match Py::new(py, PyImage::of_picture(*picture)) {
                Ok(image) => error.value(py).setattr("image", image).map_or_else(|other| other, |()| error),
                Err(other) => other,
            }
        }
        Error::Film(_) | Error::Tessellation(_) => PyValueError::new_err(message),
        error if error.is_of_options() => PyValueError::new_err(message),
        _ => failure(py, message),
    }
}

fn scene_error(py: Python<'_>, list: &Diagnostics, origins: &LineOrigins) -> PyResult<PyErr> {
    let list = diagnostics(py, list, origins)?;
    Ok(PyErr::from_value(class(py, "SceneError")?.call1((list,))?))
}

/// The error of a file as `OSError` or one of its subclasses.
pub(crate) fn os_error(path: &Path, error: &io::Error) -> PyErr {
    match error.raw_os_error() {
        Some(number) => {
            let text = error.to_string();
            let text = text.split(" (os error").next().unwrap_or_default().to_owned();
            // On Windows, where the number is not an errno, Python takes the fourth argument; elsewhere it ignores it.
            PyOSError::new_err((number, text, path.as_os_str().to_owned(), number))
        }
        None => PyOSError::new_err(format!("{}: {error}", path.display())),
    }
}

fn file_error(py: Python<'_>, path: &Path, fault: FileFault, message: String) -> PyErr {
    match fault {
        FileFault::Io(error) | FileFault::NotWritable(error) | FileFault::NotMade(error) => {
            os_error(path, &error)
        }
        FileFault::NoFolder(_) => PyFileNotFoundError::new_err(message),
        FileFault::IsFolder => PyIsADirectoryError::new_err(message),
        FileFault::ReadOnly => PyPermissionError::new_err(message),
        FileFault::Exists => PyFileExistsError::new_err(message),
        FileFault::Extension(_) | FileFault::IsInput | FileFault::IsOutput | FileFault::NotRegular => {
            PyValueError::new_err(message)
        }
        _ => failure(py, message),
    }
}

/// Advice on an error.
fn advice(error: &Error) -> Option<&'static str> {
    Some(match error {
        Error::NoScene { .. } => "load a scene with lights that names the model in a shape",
        Error::NoModel { .. } => "choose .glb, .obj or .ply, which are made of triangles",
        Error::NoGuide { .. } => "choose integrator=\"guided\"",
        Error::NoStoredLight { .. } => "choose integrator=\"radiosity\"",
        Error::NoiseOf { .. } => "choose integrator=\"path\"",
        Error::Branching { .. } => "choose integrator=\"path\" or \"distributed\"",
        Error::OrderedParts => {
            "learn a guide first, with guide_output, and render parts with guide_input; leave out noise"
        }
        Error::Parts { .. } => "choose fewer parts or more samples",
        Error::PartGoal => "set particles",
        Error::SampleRange { .. } => "set samples to the end of the range or more",
        Error::NoReceiver { .. } => "give shapes the name of a receiver, or add walls with room=(x, y, z)",
        Error::Cells { .. } => "choose fewer cells or longer texels",
        Error::Integrate(_) => "method=\"trace\" supports lights of every kind",
        Error::Denoise(_) => {
            "pip install pyoidn, and set OIDN_DIR to its folder pyoidn/oidn, if the library is not found"
        }
        Error::RayGoal => "set particles, without time_limit, error and part",
        Error::NoRayFile => "pass ray_file=True to illuminate",
        Error::NoFarField => "pass far_field=True to illuminate, and another method than \"integrate\"",
        Error::File { fault, .. } => match fault {
            FileFault::NoFolder(_) => "create the folder first",
            FileFault::Exists => "pass resume=True to continue from it, or remove it",
            FileFault::Extension("pictures") => "the extension selects the format: .exr, .png, .hdr or .pfm",
            FileFault::Extension("scenes") => "the extension selects the format: .pbrt, .glb, .obj or .ply",
            FileFault::Extension("models") => "models are written as .glb",
            FileFault::Extension("rays") => "rays are written as .tm25ray",
            FileFault::Extension("luminaires") => "candela distributions are written as .ldt or .ies",
            FileFault::Identity(_) => "use the scene and the settings of the checkpoint, or another file",
            _ => return None,
        },
        _ => return None,
    })
}
