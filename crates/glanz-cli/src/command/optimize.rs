//! `glanz optimize`: inverse design.

use std::time::Instant;

use glanz::illumination::optimize::{OptimizeOutcome, TargetMeasure};
use glanz::job::JobEnd;
use glanz::report::number::significant;
use glanz::{Error, FileFault};
use glanz_terminal::messages::{CommandError, Messages};
use glanz_terminal::{CommandOutcome, interrupt};
use serde::Serialize;

use crate::arguments::OptimizeArguments;
use crate::command_error::command_error;
use crate::job::run_job;
use crate::report;
use crate::scene_file;

/// The output of `--json`.
#[derive(Serialize)]
struct OptimizeReport<'a> {
    scene: String,
    output: String,
    merit: [f64; 2],
    targets_before: &'a [TargetMeasure],
    targets: &'a [TargetMeasure],
    displacements_m: &'a [f64],
    by_gradient: bool,
    rays: usize,
    steps: u32,
    evaluations: u64,
    seconds: f64,
    complete: bool,
}

/// Moves the free numbers of the scene file.
///
/// # Errors
/// A scene, setting or file that is refused.
pub(crate) fn run(arguments: &OptimizeArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    let cancel = interrupt::listen()?;
    let mut files = glanz::file::FileUses::default();
    let (path, output) = (&arguments.scene, &arguments.output);
    if scene_file::is_standard_input(path) {
        return Err(CommandError::usage(
            "optimize changes the numbers of a scene file, not of the standard input",
        ));
    }
    check_output(arguments, &mut files).map_err(command_error(messages))?;
    let scene = scene_file::open(path, &arguments.job.reading, &cancel, messages)?;
    files.add_inputs(scene.paths()).map_err(command_error(messages))?;
    let start = Instant::now();
    let optimized = run_job(scene, &arguments.job, cancel, messages, |scene, job| {
        scene.optimize().settings(arguments.settings()).job(job).run()
    });
    let optimized = optimized.map_err(command_error(messages))?;
    optimized.save(output).map_err(command_error(messages))?;
    if optimized.scene_has_changed() {
        messages.warning(&format!(
            "{} has changed since it was read; {} has what was read, with the numbers found for that",
            path.display(),
            output.display()
        ));
    }
    let outcome = optimized.outcome();
    if arguments.job.verbosity.json {
        report::print(&OptimizeReport {
            scene: path.display().to_string(),
            output: output.display().to_string(),
            merit: outcome.merit,
            targets_before: &outcome.measures[0],
            targets: &outcome.measures[1],
            displacements_m: &outcome.displacements,
            by_gradient: outcome.by_gradient,
            rays: outcome.rays,
            steps: outcome.iterations,
            evaluations: outcome.evaluations,
            seconds: start.elapsed().as_secs_f64(),
            complete: outcome.end == JobEnd::Complete,
        })?;
    } else if !messages.is_quiet() {
        report::print_text(&summary(outcome))?;
    }
    let is_interrupted = outcome.end == JobEnd::Interrupted;
    let start = if is_interrupted { "interrupted; " } else { "" };
    messages.note(&format!("{start}wrote {}", output.display()));
    Ok(if is_interrupted { CommandOutcome::Interrupted } else { CommandOutcome::Done })
}

/// Refuses an output that cannot be written or is no scene file.
fn check_output(arguments: &OptimizeArguments, files: &mut glanz::file::FileUses) -> Result<(), Error> {
    let output = &arguments.output;
    files.add_input(&arguments.scene)?;
    if !glanz::is_exact_path(output)? {
        return Err(Error::File { path: output.clone(), fault: FileFault::Extension("scene files") });
    }
    files.add_output(output)?;
    arguments.job.checkpoint.add_to(files)
}

/// What was reached, one line for each target.
fn summary(outcome: &OptimizeOutcome) -> String {
    let mut lines = vec![format!(
        "merit {} after {} with {}; it was {}",
        significant(outcome.merit[1]),
        report::plural(outcome.iterations.into(), "step", "steps"),
        report::plural(outcome.rays as u64, "ray", "rays"),
        significant(outcome.merit[0])
    )];
    for (number, (before, after)) in (1..).zip(outcome.measures[0].iter().zip(&outcome.measures[1])) {
        lines.push(format!("target {number}: {}; it was {}", words(after), words(before)));
    }
    lines.join("\n") + "\n"
}

fn words(measure: &TargetMeasure) -> String {
    match *measure {
        TargetMeasure::Distribution { deviation, share } => format!(
            "{} % of the reflected light on the receiver, {} % rms difference from the wanted distribution",
            significant(100.0 * share),
            significant(100.0 * deviation)
        ),
        TargetMeasure::Flux { share } => {
            format!("{} % of the light of the lamps on the receiver", significant(100.0 * share))
        }
        TargetMeasure::Collimation { angle } => {
            format!("rms angle of {} rad to the wanted direction", significant(angle))
        }
    }
}
