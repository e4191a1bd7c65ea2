//! Rendering from Python.

use std::path::PathBuf;

use glanz::file::FileUses;
use glanz::sampling::SamplerKind;
use glanz::sampling::exact::MAX_TERMS;
use glanz::transport::{Aov, AovSet, BRANCHING_LIMIT, INTEGRATORS};
use glanz::{EdgeLines, JobOptions, MAX_LINE_WIDTH, RenderOptions};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arguments::{Whole, by_name, pair, parsed, positive, seconds};
use crate::error::{py_error, warn};
use crate::image::PyImage;
use crate::job::{JobArguments, run_job};
use crate::scene::PyScene;

/// Largest side of a picture, pixels.
const MAX_SIDE: u32 = 1 << 20;

/// Names of channels.
#[derive(FromPyObject)]
enum AovNames {
    One(String),
    Several(Vec<String>),
}

impl AovNames {
    fn set(&self) -> PyResult<AovSet> {
        let names = match self {
            Self::One(name) if name.eq_ignore_ascii_case("all") => return Ok(AovSet::ALL),
            Self::One(name) => std::slice::from_ref(name),
            Self::Several(names) => names,
        };
        names.iter().map(|name| by_name(name, "channel", Aov::ALL.map(|aov| (aov, aov.name())))).collect()
    }
}

/// Lines over a picture.
#[derive(FromPyObject)]
enum EdgeArgument {
    Switch(bool),
    Width(f64),
}

impl EdgeArgument {
    fn lines(&self) -> PyResult<Option<EdgeLines>> {
        match *self {
            Self::Switch(on) => Ok(on.then(EdgeLines::default)),
            Self::Width(width) if positive(width, "edges")? > MAX_LINE_WIDTH => Err(PyValueError::new_err(
                format!("edges is {width}; lines have at most {MAX_LINE_WIDTH} pixels"),
            )),
            Self::Width(width) => Ok(Some(EdgeLines { width: Some(width) })),
        }
    }
}

/// The sizes and numbers of a render.
struct SampleArguments {
    size: Option<[Whole; 2]>,
    seed: Option<Whole>,
    samples: Option<Whole>,
    sample_range: Option<[Whole; 2]>,
    part: Option<String>,
    branching: Option<Whole>,
}

impl SampleArguments {
    /// Fills the options with these numbers.
    fn fill(self, options: &mut RenderOptions) -> PyResult<()> {
        let contradictions = [
            (self.samples.is_some() && options.time_limit.is_some(), "samples and time_limit"),
            (self.sample_range.is_some() && options.time_limit.is_some(), "sample_range and time_limit"),
            (self.part.is_some() && options.time_limit.is_some(), "part and time_limit"),
            (options.guide_input.is_some() && options.guide_output.is_some(), "guide_input and guide_output"),
        ];
        if let Some((_, names)) = contradictions.into_iter().find(|(is_given, _)| *is_given) {
            return Err(PyValueError::new_err(format!("{names} exclude each other")));
        }
        options.size = self.size.map(|size| pair(size, "size", 1..=MAX_SIDE)).transpose()?;
        options.seed = self.seed.map(|seed| seed.0);
        options.samples = self.samples.map(|samples| samples.within("samples", 1..=MAX_TERMS)).transpose()?;
        let branching = self.branching.map(|number| number.within("branching", 1..=BRANCHING_LIMIT));
        options.branching = branching.transpose()?;
        let range = self.sample_range.map(|range| pair(range, "sample_range", 0..=MAX_TERMS)).transpose()?;
        if let Some([start, end]) = range.filter(|[start, end]| start >= end) {
            return Err(PyValueError::new_err(format!(
                "sample_range is ({start}, {end}); it must not be empty"
            )));
        }
        options.sample_range = range.map(|[start, end]| start..end);
        if let Some(part) = self.part {
            options.part = Some(parsed(&part, "part")?);
        }
        Ok(())
    }
}

#[pymethods]
impl PyScene {
    /// Renders. The picture has the bits of ``glanz render`` with the same settings; they do not depend on threads or interruptions.
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    #[pyo3(signature = (*, size=None, samples=None, integrator=None, sampler=None, seed=None, noise=None, sample_range=None, part=None,
        time_limit=None, light_sampling=None, spectral=false, branching=None, guide=None, guide_input=None, guide_output=None,
        light_input=None, aovs=None, variance=false, edges=None, denoise=false, threads=None, checkpoint=None, resume=false, progress=None))]
    fn render(
        &self,
        py: Python<'_>,
        size: Option<[Whole; 2]>,
        samples: Option<Whole>,
        integrator: Option<&str>,
        sampler: Option<&str>,
        seed: Option<Whole>,
        noise: Option<f64>,
        sample_range: Option<[Whole; 2]>,
        part: Option<String>,
        time_limit: Option<f64>,
        light_sampling: Option<bool>,
        spectral: bool,
        branching: Option<Whole>,
        guide: Option<&str>,
        guide_input: Option<PathBuf>,
        guide_output: Option<PathBuf>,
        light_input: Option<PathBuf>,
        aovs: Option<AovNames>,
        variance: bool,
        edges: Option<EdgeArgument>,
        denoise: bool,
        threads: Option<Whole>,
        checkpoint: Option<PathBuf>,
        resume: bool,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<PyImage> {
        let integrators = || INTEGRATORS.iter().map(|entry| (entry.name, entry.name));
        let samplers = || SamplerKind::ALL.into_iter().map(|kind| (kind, kind.name()));
        let aovs = aovs.map_or(Ok(AovSet::NONE), |names| names.set())?;
        let integrator = integrator.map(|name| by_name(name, "integrator", integrators())).transpose()?;
        let mut options = RenderOptions {
            integrator: integrator.map(str::to_owned),
            sampler: sampler.map(|name| by_name(name, "sampler", samplers())).transpose()?,
            noise,
            time_limit: time_limit.map(|time| seconds(time, "time_limit")).transpose()?,
            light_sampling,
            spectral,
            guide: guide.map(|guide| parsed(guide, "guide")).transpose()?,
            guide_input,
            guide_output,
            light_input,
            aovs: if variance { aovs.with(Aov::Variance) } else { aovs },
            edges: edges.map_or(Ok(None), |edges| edges.lines())?,
            denoise,
            ..RenderOptions::default()
        };
        SampleArguments { size, seed, samples, sample_range, part, branching }.fill(&mut options)?;
        let mut files = FileUses::default();
        files
            .add_inputs(self.paths())
            .and_then(|()| files.add_inputs(options.guide_input.iter().chain(&options.light_input)))
            .and_then(|()| checkpoint.as_deref().map_or(Ok(()), |path| files.add_checkpoint(path, resume)))
            .and_then(|()| options.guide_output.as_deref().map_or(Ok(()), |path| files.add_output(path)))
            .map_err(|error| py_error(py, error, &self.origins))?;
        let job = JobArguments { threads, checkpoint, resume, progress };
        let run = |job: JobOptions<'_>| self.scene().render().options(options).job(job).run();
        let picture = run_job(py, job, &self.origins, run)?;
        warn(py, picture.warnings().iter().map(ToString::to_string))?;
        Ok(PyImage::of_picture(picture))
    }
}
