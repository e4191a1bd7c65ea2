//! `glanz bake`: from a scene to a model with light maps.

use std::path::Path;
use std::time::Instant;

use glanz::file::FileUses;
use glanz::job::{CancelFlag, JobPart};
use glanz::radiosity::bake::{BakeMethod, BakePart};
use glanz::{BakeOutcome, Error, LoadedScene, ModelFiles, page_path};
use glanz_terminal::messages::{CommandError, Messages};
use glanz_terminal::{CommandOutcome, interrupt};
use serde::Serialize;

use crate::arguments::BakeArguments;
use crate::command_error::command_error;
use crate::job::run_job;
use crate::report::{self, duration, plural};
use crate::scene_file;

/// More pages than the largest bake has: its 2^24 texels are 9 times as many with the margins of the smallest charts, which fill 2.25 pages of 8192 x 8192.
const MAX_PAGES: usize = 16;

/// The output of `--json`.
#[derive(Serialize)]
struct BakeReport {
    scene: String,
    outputs: Vec<String>,
    charts: usize,
    dark_charts: usize,
    texels: usize,
    side: u32,
    pages: usize,
    elements: usize,
    triangles: usize,
    tolerance: f64,
    checkpoint: Option<String>,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
    warnings: Vec<String>,
}

/// Bakes the scene file.
///
/// # Errors
/// A scene, setting or file that is refused.
pub(crate) fn run(arguments: &BakeArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    let method = arguments.method().map_err(CommandError::usage)?;
    let mut uses = files(arguments).map_err(command_error(messages))?;
    let cancel = interrupt::listen()?;
    let scene = scene_file::open(&arguments.scene.scene, &arguments.job.reading, &cancel, messages)?;
    uses.add_inputs(scene.paths()).map_err(command_error(messages))?;
    check_pages(arguments, &uses).map_err(command_error(messages))?;
    let warnings: Vec<String> = scene.diagnostics().iter().map(|d| d.sentence()).collect();
    match (&arguments.output, arguments.part.part) {
        (Some(output), _) => run_whole(arguments, output, (scene, cancel), method, uses, warnings, messages),
        (None, Some(part)) => run_part(arguments, part, (scene, cancel), method, warnings, messages),
        (None, None) => Ok(CommandOutcome::Done),
    }
}

/// The output of `--json` for a part.
#[derive(Serialize)]
struct BakePartReport {
    scene: String,
    part: String,
    direct_texels: usize,
    points: usize,
    checkpoint: Option<String>,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
    warnings: Vec<String>,
}

/// Bakes a part into its checkpoint.
fn run_part(
    arguments: &BakeArguments,
    part: JobPart,
    (scene, cancel): (LoadedScene, CancelFlag),
    method: BakeMethod,
    mut warnings: Vec<String>,
    messages: Messages,
) -> Result<CommandOutcome, CommandError> {
    let start = Instant::now();
    let baked = run_job(scene, &arguments.job, cancel, messages, |scene, job| {
        let bake = scene.bake().density(arguments.texels_per_metre).rays(arguments.rays).method(method);
        let part = BakePart { part, direct_only: arguments.direct_only };
        bake.job(job).run_part(part, arguments.light_in.as_deref())
    });
    let Some(light) = finished(baked, arguments, messages)? else { return Ok(CommandOutcome::Interrupted) };
    warnings.extend(light.warnings.iter().map(ToString::to_string));
    let [direct_texels, points] = light.amounts();
    let checkpoint = arguments.job.checkpoint.checkpoint.as_ref().map(|path| path.display().to_string());
    let seconds = start.elapsed().as_secs_f64();
    messages.note(&format!(
        "wrote {}: part {part}, direct light of {} and indirect light at {}, in {}",
        checkpoint.as_deref().unwrap_or_default(),
        plural(direct_texels as u64, "texel", "texels"),
        plural(points as u64, "point", "points"),
        duration(seconds),
    ));
    if arguments.job.verbosity.json {
        report::print(&BakePartReport {
            scene: arguments.scene.scene.display().to_string(),
            part: part.to_string(),
            direct_texels,
            points,
            checkpoint,
            seconds,
            peak_memory_bytes: report::peak_memory_bytes(),
            warnings,
        })?;
    }
    Ok(CommandOutcome::Done)
}

/// The light, or `None` and a note if the bake was interrupted.
fn finished<T>(
    baked: Result<T, Error>,
    arguments: &BakeArguments,
    messages: Messages,
) -> Result<Option<T>, CommandError> {
    match baked {
        Ok(light) => Ok(Some(light)),
        Err(Error::Interrupted(_)) => {
            messages.note(&interrupted(arguments));
            Ok(None)
        }
        Err(error) => Err(command_error(messages)(error)),
    }
}

/// Bakes everything and writes the model.
fn run_whole(
    arguments: &BakeArguments,
    output: &Path,
    (scene, cancel): (LoadedScene, CancelFlag),
    method: BakeMethod,
    mut uses: FileUses,
    mut warnings: Vec<String>,
    messages: Messages,
) -> Result<CommandOutcome, CommandError> {
    let start = Instant::now();
    let baked = run_job(scene, &arguments.job, cancel, messages, |scene, job| {
        let bake = scene.bake().density(arguments.texels_per_metre).rays(arguments.rays);
        bake.method(method).job(job).run()
    });
    let Some(outcome) = finished(baked, arguments, messages)? else { return Ok(CommandOutcome::Interrupted) };
    warnings.extend(outcome.warnings.iter().map(ToString::to_string));
    let model = arguments.model();
    let mut pages = (1..outcome.atlas.pages.len()).map(|page| page_path(output, page, model.irradiance));
    pages.try_for_each(|path| uses.add_output(&path)).map_err(command_error(messages))?;
    let files = outcome.save_with(output, &model).map_err(command_error(messages))?;
    let report = report_of(arguments, &outcome, &files, start, warnings);
    messages.note(&format!(
        "wrote {}: {} of light in {} of {} x {}, {}, in {}",
        report.outputs.join(", "),
        plural(report.texels as u64, "texel", "texels"),
        plural(report.pages as u64, "page", "pages"),
        report.side,
        report.side,
        plural(report.triangles as u64, "triangle", "triangles"),
        duration(report.seconds),
    ));
    if arguments.job.verbosity.json {
        report::print(&report)?;
    }
    Ok(CommandOutcome::Done)
}

/// The scene, and the files that are written; those that cannot be are refused.
fn files(arguments: &BakeArguments) -> Result<FileUses, Error> {
    let mut files = FileUses::default();
    files.add_input(scene_file::source(&arguments.scene.scene))?;
    files.add_inputs(&arguments.light_in)?;
    if let Some(output) = &arguments.output {
        glanz::check_model_path(output)?;
        files.add_output(output)?;
        files.add_output(&page_path(output, 0, arguments.model().irradiance))?;
    }
    arguments.job.checkpoint.add_to(&mut files)?;
    Ok(files)
}

/// Refuses inputs and outputs that a page of light might replace; the number of pages is known after the bake only.
fn check_pages(arguments: &BakeArguments, uses: &FileUses) -> Result<(), Error> {
    let Some(output) = &arguments.output else { return Ok(()) };
    let (irradiance, mut uses) = (arguments.model().irradiance, uses.clone());
    (1..MAX_PAGES).try_for_each(|number| uses.add_result(&page_path(output, number, irradiance)))
}

fn report_of(
    arguments: &BakeArguments,
    outcome: &BakeOutcome,
    files: &ModelFiles,
    start: Instant,
    warnings: Vec<String>,
) -> BakeReport {
    let (maps, atlas) = (&outcome.maps, &outcome.atlas);
    let checkpoint = arguments.job.checkpoint.checkpoint.as_ref();
    BakeReport {
        scene: arguments.scene.scene.display().to_string(),
        outputs: files.paths.iter().map(|path| path.display().to_string()).collect(),
        charts: maps.len(),
        dark_charts: maps.iter().filter(|map| map.is_dark()).count(),
        texels: maps.iter().map(|map| map.irradiance.len()).sum(),
        side: atlas.side,
        pages: atlas.pages.len(),
        elements: outcome.elements,
        triangles: files.triangles,
        tolerance: files.tolerance,
        checkpoint: checkpoint.map(|path| path.display().to_string()),
        seconds: start.elapsed().as_secs_f64(),
        peak_memory_bytes: report::peak_memory_bytes(),
        warnings,
    }
}

/// The note about an interruption.
fn interrupted(arguments: &BakeArguments) -> String {
    match &arguments.job.checkpoint.checkpoint {
        Some(path) => {
            format!(
                "interrupted; {} holds the light so far; the same command with --resume continues",
                path.display()
            )
        }
        None => "interrupted; nothing was written".to_owned(),
    }
}
