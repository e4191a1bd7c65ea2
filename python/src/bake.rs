//! Light maps from Python.

use std::path::PathBuf;

use glanz::file::FileUses;
use glanz::formats::image::Format;
use glanz::light::{Spectrum, Wavelengths};
use glanz::radiosity::bake::{BakeMethod, BakePart};
use glanz::radiosity::reconstruct::Interpolation;
use glanz::{BakeBuilder, BakeOutcome, JobOptions, LoadedScene, ModelSettings};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::{Whole, by_name, parsed, positive, tone as tone_of};
use crate::error::{LineOrigins, py_error, warn};
use crate::image_array::image_array;
use crate::job::{JobArguments, run_job};
use crate::scene::PyScene;

/// Light on the surfaces of a scene, as baked.
#[pyclass(name = "LightMaps", module = "glanz", frozen)]
pub(crate) struct PyLightMaps(BakeOutcome);

/// Light of texels as an array of height x width x 3.
fn light_array<'py>(py: Python<'py>, light: &[Spectrum], size: [u32; 2]) -> PyResult<Bound<'py, PyAny>> {
    let wavelengths = Wavelengths::default();
    let rgb: Vec<[f32; 3]> = light.iter().map(|light| light.to_rgb(&wavelengths)).collect();
    image_array(py, rgb.into_flattened(), size, 3)
}

#[pymethods]
impl PyLightMaps {
    /// Irradiance of the texels of each page, S x S x 3, in units of radiance.
    #[getter]
    fn irradiance<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let atlas = &self.0.atlas;
        atlas.pages.iter().map(|page| light_array(py, &page.irradiance, [atlas.side; 2])).collect()
    }

    /// Radiance that leaves the texels of each page, S x S x 3.
    #[getter]
    fn radiance<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let atlas = &self.0.atlas;
        atlas.pages.iter().map(|page| light_array(py, &page.radiance, [atlas.side; 2])).collect()
    }

    /// Light of the parts of surfaces, the two sides of each adjacent.
    #[getter]
    fn charts<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let class = py.import("glanz._results")?.getattr("LightChart")?;
        let charts = self.0.maps.iter().zip(&self.0.atlas.slots).map(|(map, slot)| {
            let values = PyDict::new(py);
            let size = if map.is_dark() { [0, 0] } else { map.chart.size };
            values.set_item("shape", map.chart.shape)?;
            values.set_item("back", map.chart.back)?;
            values.set_item("hidden", map.is_hidden)?;
            values.set_item("page", slot.map(|slot| slot.page))?;
            values.set_item("corner", slot.map(|slot| (slot.corner[0], slot.corner[1])))?;
            values.set_item("irradiance", light_array(py, &map.irradiance, size)?)?;
            values.set_item("radiance", light_array(py, &map.radiance, size)?)?;
            class.call((), Some(&values))
        });
        charts.collect()
    }

    /// Number of elements that exchanged light.
    #[getter]
    fn elements(&self) -> usize {
        self.0.elements
    }

    /// Wall time.
    #[getter]
    fn seconds(&self) -> f64 {
        self.0.elapsed.as_secs_f64()
    }

    /// Warnings of the bake.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings.iter().map(ToString::to_string).collect()
    }

    /// Writes a model (.glb) that shows the light, and the irradiance beside it; returns the paths.
    ///
    /// Parameters
    /// ----------
    /// path
    ///     The model.
    /// tolerance
    ///     Largest distance of triangles from the surface, m; by default 0.001, or less in a small scene.
    /// exposure, tone
    ///     As for `Image.save`.
    /// lightmap
    ///     Format of the irradiance: ``exr`` or ``png``.
    #[pyo3(signature = (path, *, tolerance=None, exposure=0.0, tone="linear", lightmap="exr"))]
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        tolerance: Option<f64>,
        exposure: f32,
        tone: &str,
        lightmap: &str,
    ) -> PyResult<Vec<PathBuf>> {
        let settings = ModelSettings {
            tolerance: tolerance.map(|tolerance| positive(tolerance, "tolerance")).transpose()?,
            tone: tone_of(exposure, tone)?,
            irradiance: by_name(
                lightmap,
                "format of light maps",
                [(Format::Exr, "exr"), (Format::Png, "png")],
            )?,
        };
        let saved = py.detach(|| self.0.save_with(&path, &settings));
        saved.map(|files| files.paths).map_err(|error| py_error(py, error, &LineOrigins::default()))
    }

    fn __repr__(&self) -> String {
        let (charts, pages, side) = (self.0.maps.len(), self.0.atlas.pages.len(), self.0.atlas.side);
        format!("<glanz.LightMaps {charts} charts on {pages} pages of {side} x {side} texels>")
    }
}

/// Density of the light maps, and number of rays.
struct BakeArguments {
    density: f64,
    rays: Option<u32>,
}

impl BakeArguments {
    fn try_new(density: f64, rays: Option<Whole>) -> PyResult<Self> {
        let rays = rays.map(|rays| rays.within("rays", 16..=65_536)).transpose()?;
        Ok(Self { density: positive(density, "density")?, rays })
    }

    fn builder<'a>(&self, scene: LoadedScene) -> BakeBuilder<'a> {
        let bake = scene.bake().density(self.density);
        match self.rays {
            Some(rays) => bake.rays(rays),
            None => bake,
        }
    }
}

#[pymethods]
impl PyScene {
    /// Computes light maps by radiosity: all materials count as diffuse.
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    #[pyo3(signature = (*, density=50.0, rays=None, method="gather", interpolation=None, threads=None, checkpoint=None, resume=false,
        progress=None))]
    fn bake(
        &self,
        py: Python<'_>,
        density: f64,
        rays: Option<Whole>,
        method: &str,
        interpolation: Option<&str>,
        threads: Option<Whole>,
        checkpoint: Option<PathBuf>,
        resume: bool,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<PyLightMaps> {
        let settings = BakeArguments::try_new(density, rays)?;
        let interpolations = || Interpolation::ALL.into_iter().map(|method| (method, method.name()));
        let interpolation =
            interpolation.map(|name| by_name(name, "interpolation", interpolations())).transpose()?;
        let radiosity = BakeMethod::Radiosity {
            reconstruction: interpolation.unwrap_or(Interpolation::NaturalNeighbour),
        };
        let method = by_name(method, "method", [(BakeMethod::Gather, "gather"), (radiosity, "radiosity")])?;
        if method == BakeMethod::Gather && interpolation.is_some() {
            return Err(PyValueError::new_err("interpolation: only for method=\"radiosity\""));
        }
        let job = JobArguments { threads, checkpoint, resume, progress };
        let run = |job: JobOptions<'_>| settings.builder(self.scene()).method(method).job(job).run();
        let outcome = run_job(py, job, &self.origins, run)?;
        warn(py, outcome.warnings.iter().map(ToString::to_string))?;
        Ok(PyLightMaps(outcome))
    }

    /// Computes a part of a bake by ``gather``. `merge_checkpoints` joins all parts into a checkpoint, from which ``bake(checkpoint=...,
    /// resume=True)`` makes the light maps of one bake.
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    #[pyo3(signature = (part, checkpoint, *, density=50.0, rays=None, direct_only=false, light_input=None, threads=None, resume=false,
        progress=None))]
    fn bake_part(
        &self,
        py: Python<'_>,
        part: &str,
        checkpoint: PathBuf,
        density: f64,
        rays: Option<Whole>,
        direct_only: bool,
        light_input: Option<PathBuf>,
        threads: Option<Whole>,
        resume: bool,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        if direct_only && light_input.is_some() {
            return Err(PyValueError::new_err("direct_only and light_input exclude each other"));
        }
        let part = BakePart { part: parsed(part, "part")?, direct_only };
        let settings = BakeArguments::try_new(density, rays)?;
        let mut files = FileUses::default();
        files
            .add_inputs(self.paths().iter().chain(&light_input))
            .and_then(|()| files.add_checkpoint(&checkpoint, resume))
            .map_err(|error| py_error(py, error, &self.origins))?;
        let job = JobArguments { threads, checkpoint: Some(checkpoint), resume, progress };
        let light = run_job(py, job, &self.origins, |job| {
            settings.builder(self.scene()).job(job).run_part(part, light_input.as_deref())
        })?;
        warn(py, light.warnings.iter().map(ToString::to_string))
    }
}
