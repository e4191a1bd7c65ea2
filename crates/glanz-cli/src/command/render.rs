//! `glanz render`: from a scene to pictures.

use std::path::{Path, PathBuf};

use glanz::file::FileUses;
use glanz::job::{CancelFlag, JobEnd};
use glanz::transport::{AovSet, Film, FilmError, GuideSize, NoiseLevel};
use glanz::{Error, LoadedScene, Picture};
use glanz_terminal::CommandOutcome;
use glanz_terminal::interrupt;
use glanz_terminal::messages::{CommandError, Messages};
use serde::Serialize;

use crate::arguments::{RenderArguments, RenderCommandArguments};
use crate::command::turntable;
use crate::command_error::{command_error, memory_advice};
use crate::job::run_job;
use crate::outputs::{Outputs, default_path, joined};
use crate::report::{self, plural};
use crate::scene_file;

/// Renders the scene file.
///
/// # Errors
/// A scene, setting or file that is refused.
pub(crate) fn run(
    arguments: &RenderCommandArguments,
    messages: Messages,
) -> Result<CommandOutcome, CommandError> {
    let render = &arguments.render;
    let open = |cancel: &CancelFlag| scene_file::open_cut_model(arguments, cancel, messages);
    match arguments.turntable {
        Some(count) => {
            let scene = open(&interrupt::listen()?)?;
            let stem = picture_stem(Some(&arguments.model.scene), scene.name()).to_owned();
            turntable::run(scene, render, count, &stem, messages)
        }
        None => render_scene(render, Some(&arguments.model.scene), None, messages, open),
    }
}

/// The output of `--json`.
#[derive(Serialize)]
struct RenderReport {
    scene: String,
    outputs: Vec<String>,
    checkpoint: Option<String>,
    interrupted: bool,
    width: u32,
    height: u32,
    integrator: String,
    sampler: &'static str,
    seed: u64,
    threads: usize,
    /// Samples of each pixel of the picture; with a noise level, the largest number.
    samples_per_pixel: u64,
    /// Mean of the samples per pixel.
    mean_samples_per_pixel: f64,
    /// The noise level, a relative standard error.
    noise: Option<f64>,
    /// Whether noise was removed.
    denoised: bool,
    /// Numbers of the samples, as ranges.
    sample_ranges: String,
    /// Samples of this run, over all pixels.
    samples: u64,
    /// Wall time of the render loop.
    seconds: f64,
    rays: u64,
    rays_per_second: f64,
    /// Searches for hits on freeform surfaces that were given up.
    undecided: u64,
    peak_memory_bytes: Option<u64>,
    /// Size of the guide of an integrator that learns.
    guide: Option<GuideReport>,
    warnings: Vec<String>,
}

/// Size of the guide that a render has learnt.
#[derive(Serialize)]
struct GuideReport {
    cells: usize,
    /// Cells in which it draws directions.
    active: usize,
    leaves: usize,
    memory_bytes: usize,
}

impl GuideReport {
    fn of(film: &Film) -> Option<Self> {
        let GuideSize { cells, active, leaves, bytes } = film.training()?.guide().size();
        Some(Self { cells, active, leaves, memory_bytes: bytes })
    }
}

/// Renders the scene of `open`, which may be that of the file `scene_path`; to `default_output` or the file named in the scene, if the arguments name none.
///
/// # Errors
/// A scene, setting or file that is refused.
pub(crate) fn render_scene(
    arguments: &RenderArguments,
    scene_path: Option<&Path>,
    default_output: Option<&Path>,
    messages: Messages,
    open: impl FnOnce(&CancelFlag) -> Result<LoadedScene, CommandError>,
) -> Result<CommandOutcome, CommandError> {
    let cancel = interrupt::listen()?;
    // Everything that does not depend on the scene is checked before reading it, which may take long.
    let tone = arguments.tone.tone();
    let mut files = files(arguments, scene_path).map_err(command_error(messages))?;
    let named = Outputs::try_new(&arguments.output, tone, &mut files, messages)?;
    named.check_stream(arguments.job.verbosity)?;

    let scene = open(&cancel)?;
    files.add_inputs(scene.paths()).map_err(command_error(messages))?;
    let name = scene.name().to_owned();
    let film_name = scene.description().film.file_name.as_deref();
    let stem = Path::new(picture_stem(scene_path, &name));
    let default = || default_output.map_or_else(|| default_path(film_name, stem), PathBuf::from);
    // A part is of use in its checkpoint.
    let outputs = match arguments.output.is_empty() && arguments.part.part.is_none() {
        true => Outputs::try_new(&[default()], tone, &mut files, messages)?,
        false => named,
    };
    let options = arguments.options();
    let mut warnings: Vec<String> = scene.diagnostics().iter().map(|d| d.sentence()).collect();
    if options.aovs != AovSet::NONE && options.part.is_none() && !outputs.keep_channels() {
        let text = "--aov has no effect: only EXR files hold further channels";
        messages.warning(text);
        warnings.push(text.to_owned());
    }
    let rendered = run_job(scene, &arguments.job, cancel, messages, |scene, job| {
        scene.render().options(options).job(job).run()
    });
    let (picture, saved) = match rendered {
        Ok(picture) => (picture, Ok(())),
        Err(Error::Unsaved { picture, error }) => (*picture, Err(*error)),
        Err(Error::Interrupted(_)) => {
            messages.note("interrupted before the first pass; this picture was not written");
            return Ok(CommandOutcome::Interrupted);
        }
        Err(error) => return Err(render_failure(error, arguments, messages)),
    };
    let mut failures: Vec<CommandError> = saved.err().into_iter().map(command_error(messages)).collect();
    failures.extend(outputs.write(&picture, messages).err());
    joined(failures)?;
    warnings.extend(picture.warnings().iter().map(ToString::to_string));
    finish(&picture, &name, &outputs, arguments, warnings, messages)
}

/// The name of a picture of the scene `name` from the file `scene`: the standard input has none.
fn picture_stem<'a>(scene: Option<&Path>, name: &'a str) -> &'a str {
    if scene.is_some_and(scene_file::is_standard_input) { "picture" } else { name }
}

/// The scene file, and those beside the pictures.
fn files(arguments: &RenderArguments, scene: Option<&Path>) -> Result<FileUses, Error> {
    let mut files = FileUses::default();
    let inputs =
        [scene.map(scene_file::source), arguments.guide_in.as_deref(), arguments.light_in.as_deref()];
    files.add_inputs(inputs.into_iter().flatten())?;
    arguments.job.checkpoint.add_to(&mut files)?;
    arguments.guide_out.as_deref().map_or(Ok(()), |path| files.add_output(path))?;
    Ok(files)
}

/// The error, with the option that causes it.
fn render_failure(error: Error, arguments: &RenderArguments, messages: Messages) -> CommandError {
    let option = match &error {
        Error::NoGuide { .. } => {
            let named = [
                ("--guide", arguments.guide.is_some()),
                ("--guide-in", arguments.guide_in.is_some()),
                ("--guide-out", arguments.guide_out.is_some()),
            ];
            named.into_iter().find(|(_, is_given)| *is_given).map(|(name, _)| name.to_owned())
        }
        Error::NoStoredLight { .. } => Some("--light-in".to_owned()),
        Error::LightSampling { .. } => Some("--samplelights off".to_owned()),
        Error::Branching { .. } => arguments.branching.map(|count| format!("--branching {count}")),
        Error::SampleRange { .. } | Error::SampleOrder { .. } => {
            arguments.samples.as_ref().map(|range| format!("--samples {}..{}", range.start, range.end))
        }
        Error::OrderedParts | Error::Parts { .. } => arguments.part.part.map(|part| format!("--part {part}")),
        Error::NoiseLevel { .. } | Error::NoiseOf { .. } => {
            arguments.noise.map(|level| format!("--noise {level}"))
        }
        Error::Denoise(_) => Some("--denoise".to_owned()),
        Error::Film(FilmError::Limit { .. }) => None,
        Error::Film(_) => arguments.size.map(|[width, height]| format!("--size {width}x{height}")),
        _ => None,
    };
    let memory = match &error {
        // What the scene leaves of the limit is too little by the difference.
        Error::Film(FilmError::Limit { needed, limit }) => {
            let whole = arguments.job.reading.limits().memory;
            Some(memory_advice(whole.saturating_add(needed.saturating_sub(*limit))))
        }
        _ => None,
    };
    let failure = command_error(messages)(error);
    let failure = CommandError { help: memory.or(failure.help), ..failure };
    match option {
        Some(option) => CommandError { message: format!("{option}: {}", failure.message), ..failure },
        None => failure,
    }
}

/// Reports the picture that was written.
fn finish(
    picture: &Picture,
    scene: &str,
    outputs: &Outputs,
    arguments: &RenderArguments,
    warnings: Vec<String>,
    messages: Messages,
) -> Result<CommandOutcome, CommandError> {
    let (identity, film, statistics) = (picture.identity(), picture.film(), picture.statistics());
    let [width, height] = identity.film.crop.size;
    let seconds = statistics.elapsed.as_secs_f64();
    let rays = statistics.counters.rays();
    let interrupted = statistics.end == JobEnd::Interrupted;
    let checkpoint = arguments.job.checkpoint.checkpoint.as_ref();
    let report = RenderReport {
        scene: scene.to_owned(),
        outputs: outputs.names(),
        checkpoint: checkpoint.map(|path| path.display().to_string()),
        interrupted,
        width,
        height,
        integrator: identity.integrator.to_string(),
        sampler: identity.sampler.name(),
        seed: identity.seed,
        threads: statistics.threads,
        samples_per_pixel: film.samples().total(),
        mean_samples_per_pixel: film.mean_samples(),
        noise: identity.film.noise.map(NoiseLevel::error),
        denoised: picture.is_denoised(),
        sample_ranges: film.samples().to_string(),
        samples: statistics.samples,
        seconds,
        rays,
        rays_per_second: if rays == 0 { 0.0 } else { rays as f64 / seconds },
        undecided: statistics.undecided,
        peak_memory_bytes: report::peak_memory_bytes(),
        guide: GuideReport::of(film),
        warnings,
    };
    let taken = plural(report.samples_per_pixel, "sample per pixel", "samples per pixel");
    let taken = match identity.film.noise {
        Some(_) => format!("up to {taken}, {:.0} on average", film.mean_samples()),
        None => taken,
    };
    let files = if report.outputs.is_empty() { report.checkpoint.as_slice() } else { &report.outputs };
    messages.note(&format!(
        "{}wrote {}: {taken} in {}, {:.1} million rays, {:.2} million a second",
        if interrupted { "interrupted; " } else { "" },
        files.join(", "),
        report::duration(report.seconds),
        report.rays as f64 / 1e6,
        report.rays_per_second / 1e6,
    ));
    if arguments.job.verbosity.json {
        report::print(&report)?;
    }
    Ok(if interrupted { CommandOutcome::Interrupted } else { CommandOutcome::Done })
}
