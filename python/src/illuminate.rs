//! Illuminance from Python.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use glanz::illumination::{AngleStep, FarFieldResolution, GridResolution, LuxMap, TraceGoal};
use glanz::job::JobEnd;
use glanz::math::DVec3;
use glanz::report::{Fact, FactValue};
use glanz::scene::description::MAX_RECEIVER_CELLS;
use glanz::{IlluminateMethod, IlluminateOptions, IlluminateOutcome, JobOptions, SavedRays};
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::{Whole, by_name, parsed, positive, seconds, value_error};
use crate::error::{LineOrigins, py_error, warn};
use crate::job::{JobArguments, run_job};
use crate::scene::PyScene;

/// Illuminance on the receivers of a scene.
#[pyclass(name = "Illumination", module = "glanz", frozen)]
pub(crate) struct PyIllumination {
    /// Shared, so that no lock is held while Python runs.
    outcome: Mutex<Arc<IlluminateOutcome>>,
    receivers: Py<PyDict>,
    integrated: Py<PyDict>,
}

/// Steps of gamma and of C, degrees.
#[derive(FromPyObject)]
enum AngleSteps {
    Both(f64),
    Each([f64; 2]),
}

impl AngleSteps {
    fn resolution(&self) -> PyResult<FarFieldResolution> {
        let [gamma, plane] = match *self {
            Self::Both(step) => [step, step],
            Self::Each(steps) => steps,
        };
        let step = |degrees| {
            AngleStep::try_new(degrees).map_err(|error| value_error(format!("resolution: {error}")))
        };
        Ok(FarFieldResolution::Steps { gamma: step(gamma)?, plane: step(plane)? })
    }
}

/// A map as `glanz.LuxMap`.
fn lux_map<'py>(py: Python<'py>, map: &LuxMap) -> PyResult<Bound<'py, PyAny>> {
    let shape = map.cells.map(|count| count as usize);
    let grid = |values: &[f64]| values.to_vec().into_pyarray(py).reshape([shape[1], shape[0]]);
    let positions: Vec<f64> = map.positions.iter().flat_map(|position| position.to_array()).collect();
    let summary = map.summary();
    let values = PyDict::new(py);
    values.set_item("name", &map.name)?;
    values.set_item("size", (map.size[0], map.size[1]))?;
    values.set_item("lux", grid(&map.lux)?)?;
    values.set_item("standard_errors", grid(&map.errors)?)?;
    values.set_item("areas", grid(&map.areas)?)?;
    values.set_item("positions", positions.into_pyarray(py).reshape([map.positions.len(), 3])?)?;
    values.set_item("minimum", summary.minimum)?;
    values.set_item("minimum_interval", <(f64, f64)>::from(summary.minimum_interval))?;
    values.set_item("mean", summary.mean)?;
    values.set_item("mean_interval", <(f64, f64)>::from(summary.mean_interval))?;
    values.set_item("maximum", summary.maximum)?;
    values.set_item("maximum_interval", <(f64, f64)>::from(summary.maximum_interval))?;
    values.set_item("u0", summary.u0)?;
    values.set_item("u0_interval", <(f64, f64)>::from(summary.u0_interval))?;
    values.set_item("u1", summary.u1)?;
    values.set_item("u1_interval", <(f64, f64)>::from(summary.u1_interval))?;
    values.set_item("area", summary.area)?;
    values.set_item("flux", summary.flux)?;
    py.import("glanz._results")?.getattr("LuxMap")?.call((), Some(&values))
}

/// The maps by the names of their receivers; a repeated name gets a number.
fn by_receiver(py: Python<'_>, maps: &[LuxMap]) -> PyResult<Py<PyDict>> {
    let dict = PyDict::new(py);
    for map in maps {
        let mut name = map.name.clone();
        let mut number = 2;
        while dict.contains(&name)? {
            name = format!("{} {number}", map.name);
            number += 1;
        }
        dict.set_item(name, lux_map(py, map)?)?;
    }
    Ok(dict.unbind())
}

impl PyIllumination {
    fn outcome(&self) -> Arc<IlluminateOutcome> {
        Arc::clone(&self.outcome.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Adds the facts of a ray file; only what another thread still uses is copied for it.
    fn add_rays(&self, rays: SavedRays) {
        let mut outcome = self.outcome.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::make_mut(&mut outcome).add_rays(rays);
    }
}

#[pymethods]
impl PyIllumination {
    /// The maps by receiver; names that occur several times get a number: ``desk``, ``desk 2``.
    #[getter]
    fn receivers(&self, py: Python<'_>) -> Py<PyDict> {
        self.receivers.clone_ref(py)
    }

    /// The maps by integration if the method was ``both``.
    #[getter]
    fn integrated(&self, py: Python<'_>) -> Py<PyDict> {
        self.integrated.clone_ref(py)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.receivers.bind(py).as_any().get_item(name)
    }

    fn __contains__(&self, py: Python<'_>, name: &Bound<'_, PyAny>) -> PyResult<bool> {
        self.receivers.bind(py).contains(name)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.receivers.bind(py).call_method0("__iter__")
    }

    fn __len__(&self, py: Python<'_>) -> usize {
        self.receivers.bind(py).len()
    }

    /// Emitted light and where it ended; None for an integration.
    #[getter]
    fn balance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(balance) = self.outcome().report.balance else { return Ok(None) };
        let values = PyDict::new(py);
        values.set_item("emitted", balance.emitted)?;
        values.set_item("absorbed_by_receivers", balance.absorbed_by_receivers)?;
        values.set_item("absorbed_elsewhere", balance.absorbed_elsewhere)?;
        values.set_item("escaped", balance.escaped)?;
        values.set_item("given_up", balance.given_up)?;
        values.set_item("closes_to", balance.closes_to())?;
        py.import("glanz._results")?.getattr("FluxBalance")?.call((), Some(&values)).map(Some)
    }

    /// Facts about the calculation as in report.json, with the unit at the end of a name: ``particles``, ``seconds``, ``relative_error``.
    #[getter]
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (dict, outcome) = (PyDict::new(py), self.outcome());
        for Fact { key, value, .. } in outcome.report.facts.iter() {
            match value {
                FactValue::Text(text) => dict.set_item(key, text)?,
                FactValue::Flag(flag) => dict.set_item(key, flag)?,
                FactValue::Count(number) | FactValue::Whole(number) => dict.set_item(key, number)?,
                FactValue::Number(number) | FactValue::Fraction(number) | FactValue::Seconds(number) => {
                    dict.set_item(key, number)?;
                }
                FactValue::Lengths([x, y, z]) => dict.set_item(key, (x, y, z))?,
            }
        }
        Ok(dict)
    }

    /// Warnings of the calculation.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.outcome().warnings.iter().map(ToString::to_string).collect()
    }

    /// Whether the goal was reached, rather than the time limit.
    #[getter]
    fn complete(&self) -> bool {
        self.outcome().end == JobEnd::Complete
    }

    /// The table of the results.
    fn summary(&self) -> String {
        self.outcome().report.text()
    }

    fn _repr_html_(&self) -> String {
        let text = self.summary().replace('&', "&amp;").replace('<', "&lt;");
        format!("<pre>{text}</pre>")
    }

    /// Writes the reports, and for each receiver table (CSV), numbers (EXR), false colours (PNG) and isolux lines (SVG); returns the paths.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<Vec<PathBuf>> {
        let saved = py.detach(|| self.outcome().save(&folder));
        saved.map_err(|error| py_error(py, error, &LineOrigins::default()))
    }

    /// Writes the candela distribution of all light that left the scene, .ldt or .ies, if ``far_field=True``. Interpolated between its angles,
    /// it has the flux of that light; `summary` has its peak, angles and errors.
    fn save_far_field(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let saved = py.detach(|| self.outcome().save_far_field(&path));
        saved.map_err(|error| py_error(py, error, &LineOrigins::default()))
    }

    /// Writes the rays of all particles that leave the scene, .tm25ray (IES TM-25), if ``ray_file=True``; they are traced once more for it. Returns the number of
    /// rays, which is in `facts`, too; if it is 0, no file is written.
    #[pyo3(signature = (path, *, threads=None, progress=None))]
    fn save_ray_file(
        &self,
        py: Python<'_>,
        path: PathBuf,
        threads: Option<Whole>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<u64> {
        let outcome = self.outcome();
        let job = JobArguments { threads, checkpoint: None, resume: false, progress };
        let rays = run_job(py, job, &LineOrigins::default(), move |job| outcome.write_ray_file(path, job))?;
        // A job that was cancelled has raised an exception.
        let Some(rays) = rays else { return Ok(0) };
        let (count, warnings) =
            (rays.count, rays.warnings.iter().map(ToString::to_string).collect::<Vec<_>>());
        self.add_rays(rays);
        warn(py, warnings)?;
        Ok(count)
    }

    /// One row for each cell of all receivers, see `LuxMap.to_pandas`.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let module = slf.py().import("glanz._results")?;
        module.call_method1("illumination_frame", (slf.get().receivers(slf.py()),))
    }

    fn __repr__(&self) -> String {
        let outcome = self.outcome();
        let maps = outcome.report.maps.iter().map(|map| {
            let summary = map.summary();
            format!("{:?} mean {:.4} lx, U0 {:.3}", map.name, summary.mean, summary.u0)
        });
        format!("<glanz.Illumination {}>", maps.collect::<Vec<_>>().join("; "))
    }
}

#[pymethods]
impl PyScene {
    /// Computes the illuminance on receivers: shapes with the name of a receiver, and the walls of ``room``.
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    #[pyo3(signature = (*, method="auto", particles=None, time_limit=None, error=None, tolerance=0.01, daylight=false, room=None, cells=None, texel=None,
        far_field=false, resolution=None, ray_file=false, title=None, seed=None, max_depth=None, part=None, threads=None, checkpoint=None, resume=false, progress=None))]
    fn illuminate(
        &self,
        py: Python<'_>,
        method: &str,
        particles: Option<Whole>,
        time_limit: Option<f64>,
        error: Option<f64>,
        tolerance: f64,
        daylight: bool,
        room: Option<[f64; 3]>,
        cells: Option<Whole>,
        texel: Option<f64>,
        far_field: bool,
        resolution: Option<AngleSteps>,
        ray_file: bool,
        title: Option<String>,
        seed: Option<Whole>,
        max_depth: Option<Whole>,
        part: Option<String>,
        threads: Option<Whole>,
        checkpoint: Option<PathBuf>,
        resume: bool,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<PyIllumination> {
        let default = IlluminateOptions::default();
        let methods = [
            IlluminateMethod::Auto,
            IlluminateMethod::Trace,
            IlluminateMethod::Integrate,
            IlluminateMethod::Both,
        ];
        let methods = methods.map(|method| (method, method.name()));
        let cell_size = match (cells, texel) {
            (Some(_), Some(_)) => return Err(PyValueError::new_err("cells and texel exclude each other")),
            (Some(cells), None) => GridResolution::Longer(cells.within("cells", 1..=MAX_RECEIVER_CELLS)?),
            (None, Some(texel)) => GridResolution::Texel(positive(texel, "texel")?),
            (None, None) => default.resolution,
        };
        if particles.is_some_and(|particles| particles.0 == 0) {
            return Err(PyValueError::new_err("particles is 0; it must be at least 1"));
        }
        if part.is_some() && checkpoint.is_none() {
            return Err(PyValueError::new_err(
                "part needs a checkpoint, from which merge_checkpoints joins the parts",
            ));
        }
        let room = room.map(|sides| {
            sides.iter().try_for_each(|side| positive(*side, "a side of room").map(drop))?;
            Ok::<_, PyErr>(DVec3::from_array(sides))
        });
        if resolution.is_some() && !far_field {
            return Err(PyValueError::new_err("resolution needs far_field=True"));
        }
        let steps = resolution.map(|steps| steps.resolution()).transpose()?;
        let depth = max_depth.map(|depth| depth.within("max_depth", 1..=u32::MAX)).transpose()?;
        let options = IlluminateOptions {
            room: room.transpose()?,
            resolution: cell_size,
            method: by_name(method, "method", methods)?,
            goal: TraceGoal {
                particles: particles.map(|particles| particles.0),
                time: time_limit.map(|time| seconds(time, "time_limit")).transpose()?,
                error: error.map(|error| positive(error, "error")).transpose()?,
            },
            part: part.map(|part| parsed(&part, "part")).transpose()?,
            tolerance: positive(tolerance, "tolerance")?,
            daylight,
            far_field: far_field.then(|| steps.unwrap_or_default()),
            seed: seed.map_or(default.seed, |seed| seed.0),
            max_depth: depth.unwrap_or(default.max_depth),
        };
        let job = JobArguments { threads, checkpoint, resume, progress };
        let run = |job: JobOptions<'_>| {
            let mut builder = self.scene().illuminate().options(options).ray_file(ray_file).job(job);
            if let Some(title) = title {
                builder = builder.title(title);
            }
            builder.run()
        };
        let outcome = run_job(py, job, &self.origins, run)?;
        warn(py, outcome.warnings.iter().map(ToString::to_string))?;
        let receivers = by_receiver(py, &outcome.report.maps)?;
        let integrated = by_receiver(py, &outcome.integrated)?;
        let outcome = Mutex::new(Arc::new(outcome));
        Ok(PyIllumination { outcome, receivers, integrated })
    }
}
