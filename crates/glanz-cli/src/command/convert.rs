//! `glanz convert`: from a scene or a model to triangles.

use std::time::Instant;

use glanz::file::FileUses;
use glanz::job::CancelFlag;
use glanz::{Error, JobEvent, JobOptions, LoadedScene, MeshOutcome, Warning, is_exact_path};
use glanz_terminal::messages::{CommandError, Messages};
use glanz_terminal::progress::Progress;
use glanz_terminal::{CommandOutcome, interrupt};
use serde::Serialize;

use crate::arguments::ConvertArguments;
use crate::command_error::command_error;
use crate::notes::note_event;
use crate::report::{self, duration, plural};
use crate::scene_file;

/// The output of `--json`.
#[derive(Serialize)]
struct ConvertReport {
    scene: String,
    outputs: Vec<String>,
    shapes: usize,
    triangles: usize,
    /// Metres.
    tolerance: f64,
    /// Largest measured distance, metres.
    deviation: f64,
    solids: usize,
    watertight_solids: usize,
    /// Shapes without triangles.
    left_out: usize,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
    warnings: Vec<String>,
}

/// Converts the file.
///
/// # Errors
/// A scene, setting or file that is refused.
pub(crate) fn run(arguments: &ConvertArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    let exact = is_exact_path(&arguments.output).map_err(command_error(messages))?;
    let mut files = FileUses::default();
    files.add_input(scene_file::source(&arguments.scene)).map_err(command_error(messages))?;
    files.add_output(&arguments.output).map_err(command_error(messages))?;
    if let Some(library) = glanz::material_path(&arguments.output) {
        files.add_output(&library).map_err(command_error(messages))?;
    }
    let start = Instant::now();
    let cancel = interrupt::listen()?;
    let scene = scene_file::open(&arguments.scene, &arguments.reading, &cancel, messages)?;
    files.add_inputs(scene.paths()).map_err(command_error(messages))?;
    let mut warnings: Vec<String> = scene.diagnostics().iter().map(|d| d.sentence()).collect();
    let interrupted = || {
        messages.note("interrupted; nothing was written");
        Ok(CommandOutcome::Interrupted)
    };
    if exact {
        if arguments.has_mesh_settings() {
            let text = "--tolerance and --angle have no effect: a .pbrt file has no triangles, but the exact surfaces";
            messages.warning(text);
            warnings.push(text.to_owned());
        }
        if cancel.is_cancelled() {
            return interrupted();
        }
        return write_exact(arguments, &scene, (start, warnings), messages);
    }
    let Some((outcome, resolved)) = triangles(arguments, &scene, cancel.clone(), messages)? else {
        return interrupted();
    };
    warnings.extend(resolved.iter().map(ToString::to_string));
    warnings.extend(faults(&outcome, messages));
    // What ends after the request is not written either.
    if cancel.is_cancelled() {
        return interrupted();
    }
    let paths = outcome.save(&arguments.output).map_err(command_error(messages))?;
    let solids = outcome.solids();
    let report = ConvertReport {
        scene: scene.name().to_owned(),
        outputs: paths.iter().map(|path| path.display().to_string()).collect(),
        shapes: outcome.shape_count(),
        triangles: outcome.tessellation().triangle_count(),
        tolerance: outcome.settings().deviation,
        deviation: outcome.tessellation().deviation,
        solids: solids.solids,
        watertight_solids: solids.watertight,
        left_out: outcome.tessellation().faults.iter().filter(|fault| fault.kind.is_omission()).count(),
        seconds: start.elapsed().as_secs_f64(),
        peak_memory_bytes: report::peak_memory_bytes(),
        warnings,
    };
    messages.note(&sentence(&report));
    if arguments.verbosity.json {
        report::print(&report)?;
    }
    Ok(CommandOutcome::Done)
}

/// The triangles with warnings that are printed; `None` if they were interrupted.
fn triangles(
    arguments: &ConvertArguments,
    scene: &LoadedScene,
    cancel: CancelFlag,
    messages: Messages,
) -> Result<Option<(MeshOutcome, Vec<Warning>)>, CommandError> {
    let mut progress = Progress::start(messages);
    let mut events = |event: JobEvent<'_>| note_event(event, scene.name(), messages);
    let options = JobOptions::default()
        .threads(arguments.threads.count())
        .cancel(cancel)
        .on_progress(&mut progress)
        .on_event(&mut events);
    let made = scene.tessellate(&arguments.mesh(), options);
    progress.finish();
    match made {
        Err(Error::Interrupted(_)) => Ok(None),
        made => made.map(Some).map_err(command_error(messages)),
    }
}

/// The output of `--json` for a scene file.
#[derive(Serialize)]
struct ExactReport {
    scene: String,
    outputs: [String; 1],
    seconds: f64,
    warnings: Vec<String>,
}

fn write_exact(
    arguments: &ConvertArguments,
    scene: &LoadedScene,
    (start, warnings): (Instant, Vec<String>),
    messages: Messages,
) -> Result<CommandOutcome, CommandError> {
    scene.save_exact(&arguments.output).map_err(command_error(messages))?;
    let output = arguments.output.display().to_string();
    let seconds = start.elapsed().as_secs_f64();
    messages.note(&format!("wrote {output}: exact surfaces, in {}", duration(seconds)));
    if arguments.verbosity.json {
        report::print(&ExactReport { scene: scene.name().to_owned(), outputs: [output], seconds, warnings })?;
    }
    Ok(CommandOutcome::Done)
}

/// Prints what is left out; returns the sentences.
fn faults(outcome: &MeshOutcome, messages: Messages) -> Vec<String> {
    let faults = outcome.tessellation().faults.iter().map(|fault| {
        let number = fault.shape + 1;
        let place = fault.location.map_or(String::new(), |location| format!(" (line {})", location.line));
        match fault.group {
            Some(group) => format!("shape {number} of group {}{place}: {}", group + 1, fault.kind),
            None => format!("shape {number}{place}: {}", fault.kind),
        }
    });
    let mut sentences: Vec<String> = faults.collect();
    if outcome.has_light_or_textures() {
        sentences.push("lights and textures are not converted".to_owned());
    }
    sentences.iter().for_each(|sentence| messages.warning(sentence));
    sentences
}

fn sentence(report: &ConvertReport) -> String {
    let ConvertReport { solids, watertight_solids, .. } = *report;
    let mut sentence = format!(
        "wrote {}: {} of {}, at most {} from the surface (tolerance {})",
        report.outputs.join(", "),
        plural(report.triangles as u64, "triangle", "triangles"),
        plural(report.shapes as u64, "shape", "shapes"),
        length(report.deviation),
        length(report.tolerance),
    );
    if solids > 0 {
        let solids = plural(solids as u64, "solid", "solids");
        sentence += &format!("; {watertight_solids} of {solids} watertight");
    }
    if report.left_out > 0 {
        sentence += &format!("; {} left out", plural(report.left_out as u64, "shape", "shapes"));
    }
    sentence + &format!(", in {}", duration(report.seconds))
}

/// A length with three digits, millimetres; below a nanometre with an exponent.
fn length(metres: f64) -> String {
    let mm = 1e3 * metres;
    if mm > 0.0 && mm < 1e-6 {
        return format!("{mm:.2e} mm");
    }
    let digits = if mm > 0.0 { (2.0 - mm.log10().floor()).max(0.0) as usize } else { 0 };
    format!("{mm:.digits$} mm")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_three_digits() {
        for (metres, expected) in [
            (0.0, "0 mm"),
            (3.4567e-17, "3.46e-14 mm"),
            (1.234e-9, "0.00000123 mm"),
            (5.2857e-5, "0.0529 mm"),
            (0.0125, "12.5 mm"),
            (12.3, "12300 mm"),
        ] {
            assert_eq!(length(metres), expected);
        }
    }
}
