//! Messages for the events of a job.

use std::ops::Range;

use glanz::formats::Diagnostics;
use glanz::{JobEvent, RenderPlan, ResumedState, Warning};
use glanz_terminal::messages::Messages;

use crate::report::{grouped, plural};

/// Prints the event of a job; `scene`: name of the scene.
pub(crate) fn note_event(event: JobEvent<'_>, scene: &str, messages: Messages) {
    match event {
        JobEvent::Warning(warning) => note_warning(warning, messages),
        JobEvent::NoCheckpoint(path) => {
            messages.note(&format!("{}: there is no checkpoint yet; starting anew", path.display()));
        }
        JobEvent::Resumed { path, state } => {
            messages.note(&format!("{}: {}", path.display(), resumed(state)));
        }
        JobEvent::RenderStarted(plan) => messages.note(&format!("rendering {scene}: {}", described(plan))),
        JobEvent::BakeStarted { density, elements } => {
            let elements = plural(elements as u64, "element", "elements");
            messages.note(&format!("baking {scene}: {density} texels per metre, {elements}"));
        }
        JobEvent::TessellationStarted { shapes } => {
            messages.note(&format!("converting {scene}: {}", plural(shapes as u64, "shape", "shapes")));
        }
        JobEvent::IlluminateStarted { receivers, cells } => {
            let receivers = plural(receivers as u64, "receiver", "receivers");
            let cells = plural(cells as u64, "cell", "cells");
            messages.note(&format!("{scene}: {receivers} with {cells}"));
        }
        JobEvent::CheckpointFailed(error) => messages.warning(&error.to_string()),
        _ => {}
    }
}

fn resumed(state: &ResumedState) -> String {
    match state {
        ResumedState::Samples(samples) => format!("continuing with samples {samples}"),
        ResumedState::Places(0) => "there is no indirect light yet".to_owned(),
        ResumedState::Places(places) => {
            format!("continuing with indirect light at {}", plural(*places as u64, "place", "places"))
        }
        ResumedState::AllLight => "all light is complete".to_owned(),
        ResumedState::Paths(count) => format!("continuing after {} paths", grouped(*count)),
        ResumedState::Particles(count) => format!("continuing after {} particles", grouped(*count)),
        ResumedState::Steps(count) => {
            format!("continuing after {}", plural((*count).into(), "step", "steps"))
        }
        _ => "continuing".to_owned(),
    }
}

/// Prints the warning of a job.
pub(crate) fn note_warning(warning: &Warning, messages: Messages) {
    match warning {
        Warning::Scene(diagnostic) => messages.diagnostic(diagnostic.severity, &diagnostic.to_string()),
        Warning::NoRays => messages.warning(&format!("{warning}, --room for example")),
        warning => messages.warning(&warning.to_string()),
    }
}

/// Prints all diagnostics of a scene, and the number of those that are not listed.
pub(crate) fn note_diagnostics(diagnostics: &Diagnostics, messages: Messages) {
    for diagnostic in diagnostics {
        messages.diagnostic(diagnostic.severity, &diagnostic.to_string());
    }
    for (severity, kind, count) in diagnostics.omitted() {
        messages
            .diagnostic(severity, &format!("{severity}: {count} more of the kind \"{kind}\" are not shown"));
    }
}

fn described(plan: &RenderPlan) -> String {
    let [width, height] = plan.identity.film.crop.size;
    let amount = match (plan.time_limit, &plan.samples) {
        (Some(limit), _) => format!("{} s", limit.as_secs_f64()),
        (None, Range { start: 0, end }) => format!("{} samples per pixel", grouped((*end).into())),
        (None, Range { start, end }) => format!("samples {start}..{end} of each"),
    };
    let (integrator, sampler) = (plan.identity.integrator.name(), plan.identity.sampler.name());
    let threads = if plan.threads == 1 { "thread" } else { "threads" };
    format!("{width} x {height} pixels, {amount}, {integrator}, {sampler}, {} {threads}", plan.threads)
}
