//! `glanz render`: from a scene to pictures.

use std::path::Path;

use glanz_job::{CancelFlag, JobEnd, JobIdentity};
use glanz_light::PixelsError;
use glanz_scene::Scene;
use glanz_transport::{AovSet, Film, FilmError, GuideSize, Integrator, RenderError, RenderOutcome, render};
use serde::Serialize;

use crate::Ending;
use crate::arguments::{RenderArguments, RenderOptions};
use crate::baking;
use crate::checkpoint_file;
use crate::guide_file;
use crate::interrupt;
use crate::messages::{Failure, Messages};
use crate::outputs::{self, Outputs};
use crate::plan::Plan;
use crate::report::{self, plural};
use crate::saving::{SaveState, SavingProgress};
use crate::scene_file::{Input, SceneFile};

/// Renders the scene file.
///
/// # Errors
/// Why there is no picture.
pub(crate) fn run(arguments: &RenderArguments, messages: Messages) -> Result<Ending, Failure> {
    render_input(&Input::File(&arguments.scene), &arguments.options, None, messages)
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
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
    /// Samples that each pixel of the picture has.
    samples_per_pixel: u64,
    /// The same as ranges.
    sample_ranges: String,
    /// Samples that this run took, over all pixels.
    samples: u64,
    /// Wall time of the render loop.
    seconds: f64,
    rays: u64,
    rays_per_second: f64,
    /// Searches for hits on freeform surfaces that were given up.
    undecided: u64,
    peak_memory_bytes: Option<u64>,
    /// Of an integrator that learns.
    guide: Option<GuideReport>,
    warnings: Vec<String>,
}

/// How large the guide is that a render has learnt.
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

/// Renders `input` as `options` say; into `default_output`, or what the scene names, if they name no file.
///
/// # Errors
/// Why there is no picture.
pub(crate) fn render_input(
    input: &Input<'_>,
    options: &RenderOptions,
    default_output: Option<&Path>,
    messages: Messages,
) -> Result<Ending, Failure> {
    let cancel = interrupt::listen()?;
    // All that can be refused without the scene is refused before it is read, which may take long.
    let tone = outputs::tone(options.exposure, options.tone);
    let named = Outputs::try_new(&options.output, tone)?;
    checkpoint_file::check(options.checkpoint.as_deref(), options.resume)?;
    if let Some(path) = &options.guide_out {
        outputs::check_writable(path)?;
    }

    let mut file = SceneFile::read(input, options.strict, messages)?;
    let plan = Plan::new(options, &mut file)?;
    let outputs = match default_output {
        _ if !options.output.is_empty() => named,
        Some(path) => Outputs::try_new(&[path.to_owned()], tone)?,
        None => Outputs::try_new(&[outputs::default_path(file.film_name(), Path::new(input.name()))], tone)?,
    };
    if plan.identity.film.aovs != AovSet::NONE && !outputs.keep_channels() {
        file.warn("--aov has no effect: only EXR files hold further channels", messages);
    }
    let film = starting_film(&plan, options, messages)?;
    let scene = file.resolve(options.strict, messages)?;
    if cancel.is_cancelled() {
        messages.note("interrupted before rendering; nothing was written");
        return Ok(Ending::Interrupted);
    }

    messages.note(&format!("rendering {}: {plan}", input.name()));
    let mut light = None;
    if plan.identity.integrator.shows_stored_light() {
        baking::use_threads(options.threads)?;
        light = baking::stored(&scene, plan.light(options), &mut file, messages, &cancel)?;
        if light.is_none() {
            messages.note("interrupted before rendering; nothing was written");
            return Ok(Ending::Interrupted);
        }
    }
    let integrator = plan.integrator(light);
    let outcome = expose(&scene, integrator.as_ref(), &plan, options, film, messages, &cancel)?;
    let undecided = scene.undecided();
    finish(&Order { input, options, plan: &plan, outputs: &outputs, undecided }, file, &outcome, messages)
}

/// The film to go on with: that of the checkpoint, or an empty one.
fn starting_film(plan: &Plan, options: &RenderOptions, messages: Messages) -> Result<Film, Failure> {
    let empty = || Film::try_new(plan.identity.film).map_err(|error| film_failure(&error));
    let Some(path) = options.checkpoint.as_deref().filter(|_| options.resume) else { return empty() };
    if !path.exists() {
        messages.note(&format!("{}: there is no checkpoint yet, starting anew", path.display()));
        return empty();
    }
    let checkpoint = checkpoint_file::read(path)?;
    checkpoint.identity.check(&plan.identity).map_err(|mismatch| {
        Failure::new(format!("{}: {mismatch}", path.display()))
            .with_help("use the scene and the settings it was begun with, or another checkpoint file")
    })?;
    messages.note(&format!("{}: going on with samples {}", path.display(), checkpoint.film.samples()));
    Ok(checkpoint.film)
}

fn film_failure(error: &FilmError) -> Failure {
    let failure = Failure::new(format!("the picture cannot be rendered: {error}"));
    match error {
        FilmError::Size(..) | FilmError::Memory(_) => {
            failure.with_help("choose a smaller picture with --size")
        }
        _ => failure,
    }
}

fn expose(
    scene: &Scene,
    integrator: &dyn Integrator,
    plan: &Plan,
    options: &RenderOptions,
    film: Film,
    messages: Messages,
    cancel: &CancelFlag,
) -> Result<RenderOutcome, Failure> {
    let save = options.checkpoint.as_ref().map(|path| -> SaveState<'_, Film> {
        Box::new(|film| checkpoint_file::write(path, &plan.identity, film))
    });
    let mut sink = SavingProgress::start(save, cancel, messages);
    let outcome = render(scene, integrator, &plan.settings(), film, &mut sink, cancel);
    // The last checkpoint is still to come; only that has to succeed.
    let _ = sink.finish();
    outcome.map_err(|error| match error {
        RenderError::Order { next } => Failure::usage(format!(
            "--samples: the samples of \"guided\" build on those before; the next is {next}"
        ))
        .with_help("begin there, or give a guide that is not learnt at the same time with --guide-in"),
        RenderError::Guide(error) => {
            Failure::new(error.to_string()).with_help("give a smaller grid or scale with --guide")
        }
        error => Failure::new(format!("the render stopped: {error}")),
    })
}

/// What was asked for.
struct Order<'a> {
    input: &'a Input<'a>,
    options: &'a RenderOptions,
    plan: &'a Plan,
    outputs: &'a Outputs,
    /// Searches for hits that were given up.
    undecided: u64,
}

/// Writes what there is, and says so.
fn finish(
    order: &Order<'_>,
    mut file: SceneFile,
    outcome: &RenderOutcome,
    messages: Messages,
) -> Result<Ending, Failure> {
    let Order { options, plan, outputs, undecided, .. } = *order;
    let film = &outcome.film;
    let interrupted = outcome.end == JobEnd::Interrupted;
    if film.samples().is_empty() {
        messages.note("interrupted before the first pass; nothing was written");
        return Ok(Ending::Interrupted);
    }
    warn_of_rejects(film, &mut file, messages);
    if undecided > 0 {
        let rays = plural(undecided, "ray", "rays");
        file.warn(
            &format!("{rays} could not be decided against a freeform surface; a point may be missing"),
            messages,
        );
    }

    // The checkpoint first: it is what cannot be had again.
    let saved = match &options.checkpoint {
        Some(path) => checkpoint_file::write(path, &plan.identity, film),
        None => Ok(()),
    };
    let guide_saved = match (&options.guide_out, film.training()) {
        (Some(path), Some(training)) => guide_file::write(path, training.guide()),
        _ => Ok(()),
    };
    let pixels = film.to_pixels().map_err(|error: PixelsError| Failure::new(error.to_string()))?;
    outputs.write(&pixels, &checkpoint_file::attributes(&plan.identity, film))?;
    saved.and(guide_saved)?;

    let report = order.report(outcome, file.into_warnings());
    messages.note(&format!(
        "{}wrote {}: {} in {}, {:.1} million rays, {:.2} million a second",
        if interrupted { "interrupted; " } else { "" },
        report.outputs.join(", "),
        plural(report.samples_per_pixel, "sample per pixel", "samples per pixel"),
        report::duration(report.seconds),
        report.rays as f64 / 1e6,
        report.rays_per_second / 1e6,
    ));
    if options.talk.json {
        report::print(&report)?;
    }
    Ok(if interrupted { Ending::Interrupted } else { Ending::Done })
}

fn warn_of_rejects(film: &Film, file: &mut SceneFile, messages: Messages) {
    let rejects = film.rejects();
    if rejects.dropped > 0 {
        let samples = plural(rejects.dropped, "sample was", "samples were");
        file.warn(&format!("{samples} infinite or not a number and counted as black"), messages);
    }
    if rejects.cut > 0 {
        let samples = plural(rejects.cut, "sample was", "samples were");
        file.warn(&format!("{samples} too bright to be added up and cut"), messages);
    }
}

impl Order<'_> {
    fn report(&self, outcome: &RenderOutcome, warnings: Vec<String>) -> Report {
        let identity = &self.plan.identity;
        let [width, height] = identity.film.crop.size;
        let seconds = outcome.elapsed.as_secs_f64();
        let rays = outcome.counters.rays();
        Report {
            scene: self.input.name().to_owned(),
            outputs: self.outputs.names(),
            checkpoint: self.options.checkpoint.as_ref().map(|path| path.display().to_string()),
            interrupted: outcome.end == JobEnd::Interrupted,
            width,
            height,
            integrator: identity.integrator.to_string(),
            sampler: identity.sampler.name(),
            seed: identity.seed,
            threads: self.plan.threads,
            samples_per_pixel: outcome.film.samples().total(),
            sample_ranges: outcome.film.samples().to_string(),
            samples: outcome.samples,
            seconds,
            rays,
            rays_per_second: if rays == 0 { 0.0 } else { rays as f64 / seconds },
            undecided: self.undecided,
            peak_memory_bytes: report::peak_memory_bytes(),
            guide: GuideReport::of(&outcome.film),
            warnings,
        }
    }
}
