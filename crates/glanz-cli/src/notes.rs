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
        ResumedState::Samples { done, wanted: None } => format!("continuing after samples {done}"),
        ResumedState::Samples { done, wanted: Some(wanted) } => {
            let missing =
                done.missing(wanted.clone()).into_iter().map(|gap| u64::from(gap.end - gap.start)).sum();
            let unit = ["sample of each pixel", "samples of each pixel"];
            remaining(done.total(), u64::from(wanted.end - wanted.start), missing, unit)
        }
        ResumedState::Places(0) => "there is no indirect light yet".to_owned(),
        ResumedState::Places(places) => {
            format!("continuing with indirect light at {}", plural(*places as u64, "place", "places"))
        }
        ResumedState::AllLight => "all light is complete".to_owned(),
        ResumedState::Paths(done) => continued(*done, None, ["path", "paths"]),
        ResumedState::Particles { done, wanted } => continued(*done, *wanted, ["particle", "particles"]),
        ResumedState::Steps { done, wanted } => {
            continued((*done).into(), Some((*wanted).into()), ["step", "steps"])
        }
        _ => "continuing".to_owned(),
    }
}

/// How a job goes on that has done so many things of those wanted.
fn continued(done: u64, wanted: Option<u64>, [one, many]: [&str; 2]) -> String {
    match wanted {
        Some(wanted) => remaining(done, wanted, wanted.saturating_sub(done), [one, many]),
        None => format!("continuing after {}", plural(done, one, many)),
    }
}

/// How a job goes on that has done so many things, if `missing` of the `wanted` ones are left.
fn remaining(done: u64, wanted: u64, missing: u64, [one, many]: [&str; 2]) -> String {
    let has = plural(done, one, many);
    match missing {
        0 if done > wanted => format!(
            "it has {has}, more than the {} that are wanted; nothing is left to do, and the result has all {}",
            grouped(wanted),
            grouped(done)
        ),
        0 => format!("it has {has}, as many as are wanted; nothing is left to do"),
        missing => format!("continuing after {has} with {} more", grouped(missing)),
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
