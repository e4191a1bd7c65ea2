//! Scenes that were read.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glanz::file::FileUses;
use glanz::formats::Options;
use glanz::job::{Resource, ResourceLimits};
use glanz::scene::studio::{SrgbColor, StudioSettings, StudioView};
use glanz::{LoadedScene, MeshSettings, is_exact_path};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyIsADirectoryError, PyValueError};
use pyo3::prelude::*;

use crate::arguments::{Whole, by_name, parsed};
use crate::error::{LineOrigins, diagnostics, os_error, py_error, warn, warn_at};
use crate::job::{JobArguments, check_process, run_job, run_reading};

/// A scene or a model that was read by `load` or `loads`; its jobs do not change it.
///
/// Jobs release the interpreter lock. Ctrl-C and exceptions of the progress function end them after the step under way, and what is done is
/// in the checkpoint, if there is one.
#[pyclass(name = "Scene", module = "glanz", frozen)]
pub(crate) struct PyScene {
    scene: LoadedScene,
    /// The text that it was read from, if it was not a file.
    text: Option<String>,
    pub(crate) origins: LineOrigins,
}

/// Arguments of reading.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct ReadArguments {
    strict: bool,
    edges: bool,
    view: Option<String>,
    up: Option<String>,
    background: Option<String>,
    ground: Option<bool>,
    material: Option<String>,
    section: Option<String>,
    limits: BTreeMap<String, String>,
}

impl ReadArguments {
    fn options(&self, folder: Option<PathBuf>) -> PyResult<Options> {
        let default = StudioSettings::default();
        let view = |name: &String| by_name(name, "view", StudioView::ALL.map(|view| (view, view.name())));
        let background = self.background.as_deref().map(|text| parsed::<SrgbColor>(text, "background"));
        let studio = StudioSettings {
            view: self.view.as_ref().map(view).transpose()?,
            up: self.up.as_deref().map(|text| parsed(text, "up")).transpose()?,
            background: background.transpose()?.unwrap_or(default.background),
            ground: self.ground.unwrap_or(default.ground),
            material: self.material.as_deref().map(|text| parsed(text, "material")).transpose()?,
            section: self.section.as_deref().map(|text| parsed(text, "section")).transpose()?,
            ..default
        };
        let limits = self.limits()?;
        Ok(Options { strict: self.strict, folder, studio, edges: self.edges, limits, ..Options::default() })
    }

    /// The limits of the machine with those that are given.
    fn limits(&self) -> PyResult<ResourceLimits> {
        let mut limits = ResourceLimits::default();
        for (name, value) in &self.limits {
            let resource =
                by_name(name, "limits", Resource::ALL.map(|resource| (resource, resource.name())))?;
            let set = limits.set(resource, value);
            set.map_err(|error| PyValueError::new_err(format!("limits: {name} is {value}; {error}")))?;
        }
        Ok(limits)
    }
}

/// The scene that was read, with Python warnings of its diagnostics.
fn opened(
    py: Python<'_>,
    scene: LoadedScene,
    text: Option<String>,
    origins: LineOrigins,
    arguments: &ReadArguments,
) -> PyResult<PyScene> {
    if arguments.section.is_some() && scene.studio_settings().is_none() {
        return Err(PyValueError::new_err(format!("section: {} is not a model", scene.name())));
    }
    let given = [
        ("view", arguments.view.is_some()),
        ("up", arguments.up.is_some()),
        ("background", arguments.background.is_some()),
        ("ground", arguments.ground.is_some()),
        ("material", arguments.material.is_some()),
    ];
    let names: Vec<&str> =
        given.into_iter().filter_map(|(name, is_given)| is_given.then_some(name)).collect();
    if !names.is_empty() && scene.studio_settings().is_none() {
        let names = names.join(", ");
        warn_at(
            py,
            2,
            [format!("{names}: only for models; a scene has its own camera, light and materials")],
        )?;
    }
    warn_at(py, 2, scene.diagnostics().iter().map(|diagnostic| diagnostic.sentence()))?;
    Ok(PyScene { scene, text, origins })
}

/// Reads a scene or model; `arguments`: those of [`ReadArguments`], by name.
#[pyfunction(name = "load")]
pub(crate) fn load(py: Python<'_>, path: PathBuf, arguments: &Bound<'_, PyAny>) -> PyResult<PyScene> {
    let arguments: ReadArguments = arguments.extract()?;
    let options = arguments.options(None)?;
    match std::fs::metadata(&path) {
        Err(error) => return Err(os_error(&path, &error)),
        Ok(found) if found.is_dir() => {
            return Err(PyIsADirectoryError::new_err(format!("{} is a folder, not a file", path.display())));
        }
        Ok(_) => {}
    }
    let origins = LineOrigins::default();
    let read = run_reading(py, &options.cancel, &origins, || glanz::open_with(&path, &options))?;
    opened(py, read, None, origins, &arguments)
}

/// Reads a scene from a text; `origins`: first lines and names of the objects that wrote it.
#[pyfunction]
pub(crate) fn loads(
    py: Python<'_>,
    text: String,
    name: String,
    folder: Option<PathBuf>,
    origins: Vec<(u32, String)>,
    arguments: &Bound<'_, PyAny>,
) -> PyResult<PyScene> {
    let arguments: ReadArguments = arguments.extract()?;
    let options = arguments.options(folder)?;
    let origins = LineOrigins { file: name.clone(), objects: origins };
    let read = run_reading(py, &options.cancel, &origins, || glanz::open_str(&name, &text, &options))?;
    opened(py, read, Some(text), origins, &arguments)
}

impl PyScene {
    /// The scene, for a job, which consumes it.
    pub(crate) fn scene(&self) -> LoadedScene {
        self.scene.clone()
    }

    /// All files that were read.
    pub(crate) fn paths(&self) -> &[PathBuf] {
        self.scene.paths()
    }
}

#[pymethods]
impl PyScene {
    /// Name of the file or text.
    #[getter]
    fn name(&self) -> &str {
        self.scene.name()
    }

    /// The text of a scene that was read by `loads`.
    #[getter]
    fn text(&self) -> Option<&str> {
        self.text.as_deref()
    }

    /// Paths of all files that were read.
    #[getter]
    fn files(&self) -> Vec<&Path> {
        self.scene.paths().iter().map(PathBuf::as_path).collect()
    }

    /// Width and height of the film, pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.scene.description().film.resolution.into()
    }

    /// Samples per pixel.
    #[getter]
    fn samples(&self) -> u32 {
        self.scene.description().sampler.samples_per_pixel
    }

    /// Whether camera and light are those of a studio, which `render` adds.
    #[getter]
    fn is_model(&self) -> bool {
        self.scene.studio_settings().is_some()
    }

    /// Warnings of reading, with file, line and column.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.scene.diagnostics().iter().map(|diagnostic| diagnostic.sentence()).collect()
    }

    /// The same with their parts.
    #[getter]
    fn diagnostics<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        diagnostics(py, self.scene.diagnostics(), &self.origins)
    }

    /// Smallest and largest coordinates of the surfaces, m, 2 x 3.
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        check_process(py)?;
        let resolved = py.detach(|| self.scene().resolve().map(|(scene, _)| scene.bounds()));
        let bounds = resolved.map_err(|error| py_error(py, error, &self.origins))?;
        [bounds.min.to_array(), bounds.max.to_array()].concat().into_pyarray(py).reshape([2, 3])
    }

    /// Writes the surfaces as triangles (.glb, .obj, .ply), or exactly (.pbrt) for models and scenes that were read from a text.
    /// Files that such a text names relative to a folder are not found from another one.
    ///
    /// Returns
    /// -------
    /// The paths of the files.
    #[pyo3(signature = (path, *, threads=None, progress=None))]
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        threads: Option<Whole>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Vec<PathBuf>> {
        let failed = |error| py_error(py, error, &self.origins);
        let mut files = FileUses::default();
        files.add_inputs(self.scene.paths()).and_then(|()| files.add_output(&path)).map_err(failed)?;
        if is_exact_path(&path).map_err(failed)? {
            let written = py.detach(|| match &self.text {
                Some(text) if !self.is_model() => glanz::file::write(&path, text.as_bytes()),
                _ => self.scene.save_exact(&path),
            });
            return written.map(|()| vec![path]).map_err(failed);
        }
        let job = JobArguments { threads, checkpoint: None, resume: false, progress };
        let (paths, warnings) = run_job(py, job, &self.origins, |job| {
            let (mesh, warnings) = self.scene.tessellate(&MeshSettings::default(), job)?;
            Ok((mesh.save(&path)?, warnings))
        })?;
        warn(py, warnings.iter().map(ToString::to_string))?;
        Ok(paths)
    }

    fn __repr__(&self) -> String {
        let (width, height) = self.size();
        let (kind, name) = (if self.is_model() { "model" } else { "scene" }, self.name());
        let shapes = self.scene.description().world.shapes.len();
        let warnings = match self.scene.diagnostics().iter().count() {
            0 => String::new(),
            count => format!(", {count} warnings"),
        };
        format!(
            "<glanz.Scene {name:?}: {kind}, {width} x {height}, {} samples per pixel, {shapes} shapes of the world{warnings}>",
            self.samples()
        )
    }
}
