//! `glanz illuminate`: illuminance on receivers.

use std::path::{Path, PathBuf};

use glanz::file::FileUses;
use glanz::formats::Options;
use glanz::illumination::report::{LuxComparison, LuxReport};
use glanz::job::{CancelFlag, JobEnd};
use glanz::{Error, IlluminateOutcome};
use glanz_terminal::messages::{CommandError, Messages};
use glanz_terminal::{CommandOutcome, interrupt};
use serde::Serialize;

use crate::arguments::IlluminateArguments;
use crate::command::plan::planned_room;
use crate::command_error::command_error;
use crate::job::{run_job, run_named_job};
use crate::report;
use crate::scene_file;

/// The output of `--json`.
#[derive(Serialize)]
struct IlluminateReport<'a> {
    scenes: Vec<String>,
    outputs: Vec<String>,
    checkpoint: Option<String>,
    designs: Vec<&'a LuxReport>,
    peak_memory_bytes: Option<u64>,
    warnings: Vec<String>,
}

/// Illuminates the scene file.
///
/// # Errors
/// A scene, setting or file that is refused.
pub(crate) fn run(
    arguments: &IlluminateArguments,
    messages: Messages,
) -> Result<CommandOutcome, CommandError> {
    let cancel = interrupt::listen()?;
    let mut files = files(arguments).map_err(command_error(messages))?;
    let mut paths: Vec<&Path> = Vec::new();
    paths.extend(arguments.scene.as_deref().or(arguments.plan.luminaire.as_deref()));
    paths.extend(arguments.compare.as_deref());
    if paths.iter().filter(|path| scene_file::is_standard_input(path)).count() > 1 {
        return Err(CommandError::usage("--compare: the standard input is one scene only"));
    }
    if arguments.compare.is_some() {
        let options = arguments.job.reading.options(&cancel);
        add_named_files(&paths, &options, &mut files).map_err(command_error(messages))?;
    }
    let (mut names, mut outcomes, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
    for (path, number) in paths.iter().zip(0..) {
        let (scene, request) = match (&arguments.plan.luminaire, arguments.room.size()) {
            (Some(luminaire), Some(size)) => {
                let options = arguments.job.reading.options(&cancel);
                let (room, request) = planned_room(&arguments.plan, size, luminaire, options, messages)?;
                (room, Some(request))
            }
            _ => (scene_file::open(path, &arguments.job.reading, &cancel, messages)?, None),
        };
        files.add_inputs(scene.paths()).map_err(command_error(messages))?;
        let folder = result_folder(arguments, number, &mut files).map_err(command_error(messages))?;
        warnings.extend(scene.diagnostics().iter().map(|diagnostic| diagnostic.sentence()));
        names.push(scene.name().to_owned());
        let illuminated = run_job(scene, &arguments.job, cancel.clone(), messages, |scene, job| {
            let settings = arguments.plan.settings(arguments.seed);
            let mut builder = scene.illuminate().options(arguments.options()).planning(settings).job(job);
            if let Some(title) = &arguments.title {
                builder = builder.title(title);
            }
            if let Some(request) = request {
                builder = builder.plan(request);
            }
            if let Some(folder) = folder {
                builder = builder.check_results(folder, files.clone());
            }
            builder.ray_file(arguments.ray_file.is_some()).run()
        });
        let outcome = match illuminated {
            Ok(outcome) => outcome,
            Err(Error::Interrupted(_)) => {
                messages.note("interrupted; nothing was written");
                return Ok(CommandOutcome::Interrupted);
            }
            Err(error) => return Err(illuminate_failure(error, messages)),
        };
        outcomes.push(outcome);
    }
    let mut written = saved(arguments, &outcomes).map_err(command_error(messages))?;
    // After all other results, which its errors do not cost.
    let ray_file = match (outcomes.as_mut_slice(), names.as_slice()) {
        ([outcome], [name]) => saved_rays(arguments, name, outcome, &mut written, &cancel, messages),
        _ => Ok(JobEnd::Complete),
    };
    warnings.extend(outcomes.iter().flat_map(|outcome| &outcome.warnings).map(ToString::to_string));
    let written: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    let mut printed = Ok(());
    match (written.as_slice(), &arguments.job.checkpoint.checkpoint) {
        ([_, ..], _) => {
            if !messages.is_quiet() && !arguments.job.verbosity.json {
                printed = print_summary(&outcomes);
            }
            messages.note(&format!("wrote {}", listed(&written)));
        }
        ([], Some(checkpoint)) => messages.note(&part_note(checkpoint, &outcomes)),
        ([], None) => {}
    }
    if let (Some(path), Ok(JobEnd::Interrupted)) = (&arguments.ray_file, &ray_file) {
        messages.note(&format!("interrupted; {} was not written", path.display()));
    }
    let ray_file = ray_file.map_err(|error| {
        let failure = command_error(messages)(error);
        let message = format!("{}; the other results are saved: {}", failure.message, listed(&written));
        CommandError { message, ..failure }
    });
    if arguments.job.verbosity.json {
        printed = report::print(&IlluminateReport {
            scenes: paths.iter().map(|path| path.display().to_string()).collect(),
            outputs: written,
            checkpoint: arguments.job.checkpoint.checkpoint.as_ref().map(|path| path.display().to_string()),
            designs: outcomes.iter().map(|outcome| &outcome.report).collect(),
            peak_memory_bytes: report::peak_memory_bytes(),
            warnings,
        });
    }
    let ray_file = ray_file?;
    printed?;
    let is_interrupted =
        outcomes.iter().map(|outcome| outcome.end).chain([ray_file]).any(|end| end == JobEnd::Interrupted);
    Ok(if is_interrupted { CommandOutcome::Interrupted } else { CommandOutcome::Done })
}

/// The scenes, and the files that are written beside those in the folder of results; those that cannot be are refused.
fn files(arguments: &IlluminateArguments) -> Result<FileUses, Error> {
    let mut files = FileUses::default();
    let inputs = [&arguments.scene, &arguments.plan.luminaire, &arguments.compare];
    files.add_inputs(inputs.into_iter().flatten().map(|path| scene_file::source(path)))?;
    for path in &arguments.far_field {
        glanz::check_far_field_path(path)?;
        if arguments.output.is_some() {
            files.add_output(path)?;
        }
    }
    if let Some(path) = &arguments.ray_file {
        glanz::check_ray_path(path)?;
        files.add_output(path)?;
    }
    arguments.job.checkpoint.add_to(&mut files)?;
    Ok(files)
}

/// Adds the files that the scenes of a comparison name, before the first of them is calculated: results of one may be inputs of the other. Faults of a scene
/// are reported when it is read.
fn add_named_files(paths: &[&Path], options: &Options, files: &mut FileUses) -> Result<(), Error> {
    for path in paths.iter().filter(|path| !scene_file::is_standard_input(path)) {
        let Ok(list) = glanz::formats::list_files(path, options) else { continue };
        files.add_inputs(list.files.iter().filter(|file| file.exists).map(|file| &file.path))?;
    }
    Ok(())
}

/// The folder for the results of the scene of this number, if they are written. It is created.
fn result_folder(
    arguments: &IlluminateArguments,
    number: usize,
    files: &mut FileUses,
) -> Result<Option<PathBuf>, Error> {
    let Some(folder) = &arguments.output else { return Ok(None) };
    glanz::file::make_folder(folder)?;
    if arguments.compare.is_none() {
        return Ok(Some(folder.clone()));
    }
    let paths = glanz::comparison_paths(folder);
    if number == 0 {
        paths.iter().try_for_each(|path| files.add_result(path))?;
    }
    let own = glanz::comparison_folders(folder).into_iter().nth(number);
    own.as_deref().map_or(Ok(()), glanz::file::make_folder)?;
    Ok(own)
}

/// The error, with the option that causes it.
fn illuminate_failure(error: Error, messages: Messages) -> CommandError {
    let is_accuracy = matches!(error, Error::Accuracy { .. });
    let failure = command_error(messages)(error);
    if is_accuracy {
        CommandError { message: format!("--error: {}", failure.message), ..failure }
    } else {
        failure
    }
}

fn print_summary(outcomes: &[IlluminateOutcome]) -> Result<(), CommandError> {
    match outcomes {
        [a, b] => report::print_text(&LuxComparison::between(&a.report, &b.report).text()),
        _ => outcomes.iter().try_for_each(|outcome| report::print_text(&outcome.report.text())),
    }
}

/// The note about a part, which is in its checkpoint.
fn part_note(checkpoint: &Path, outcomes: &[IlluminateOutcome]) -> String {
    let tallies = outcomes.iter().filter_map(|outcome| outcome.tally.as_ref());
    let particles: u64 = tallies.map(|tally| tally.particles().total()).sum();
    let is_interrupted = outcomes.iter().any(|outcome| outcome.end == JobEnd::Interrupted);
    let start = if is_interrupted { "interrupted; " } else { "" };
    format!("{start}wrote {}: {}", checkpoint.display(), report::plural(particles, "particle", "particles"))
}

/// The files in a sentence.
fn listed(files: &[String]) -> String {
    match files {
        [] => "no files".to_owned(),
        [first] => first.clone(),
        [first, others @ ..] => {
            format!("{first} and {}", report::plural(others.len() as u64, "more file", "more files"))
        }
    }
}

/// Writes the ray file, if one is wanted, adds it to the files unless it has no rays, and its facts to the reports. `name`: that of the scene.
fn saved_rays(
    arguments: &IlluminateArguments,
    name: &str,
    outcome: &mut IlluminateOutcome,
    written: &mut Vec<PathBuf>,
    cancel: &CancelFlag,
    messages: Messages,
) -> Result<JobEnd, Error> {
    let Some(path) = arguments.ray_file.as_deref() else { return Ok(JobEnd::Complete) };
    if outcome.end == JobEnd::Interrupted {
        return Ok(JobEnd::Interrupted);
    }
    let end = run_named_job(name, &arguments.job, cancel.clone(), messages, |job| {
        outcome.save_ray_file(path, job)
    })?;
    if end == JobEnd::Complete {
        if outcome.rays.is_some_and(|count| count > 0) {
            written.push(path.to_owned());
        }
        arguments.output.as_ref().map_or(Ok(Vec::new()), |folder| outcome.save_reports(folder))?;
    }
    Ok(end)
}

/// Writes all files but the ray file; returns them. A part without a folder has none.
fn saved(arguments: &IlluminateArguments, outcomes: &[IlluminateOutcome]) -> Result<Vec<PathBuf>, Error> {
    let Some(folder) = arguments.output.as_deref() else { return Ok(Vec::new()) };
    match outcomes {
        [a, b] => glanz::save_comparison(folder, [a, b]),
        [outcome, ..] => {
            let mut written = outcome.save(folder)?;
            for path in &arguments.far_field {
                outcome.save_far_field(path)?;
                written.push(path.clone());
            }
            Ok(written)
        }
        [] => Ok(Vec::new()),
    }
}
