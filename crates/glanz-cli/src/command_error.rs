//! Errors of the engine as sentences with advice.

use glanz::radiosity::bake::BakeError;
use glanz::transport::{FilmError, MergeError};
use glanz::{Error, FileFault};
use glanz_terminal::messages::{CommandError, Messages};

use crate::notes::note_diagnostics;

/// Makes sentences of errors; those of a scene are printed at once, with their places.
pub(crate) fn command_error(messages: Messages) -> impl Fn(Error) -> CommandError {
    move |error| {
        if let Error::Scene(diagnostics) = &error {
            note_diagnostics(diagnostics, messages);
            return CommandError::reported();
        }
        let failure = if is_usage(&error) { CommandError::usage } else { CommandError::new };
        let failure = failure(error.to_string());
        match advice(&error) {
            Some(help) => failure.with_help(help),
            None => failure,
        }
    }
}

/// Whether the command line asks for something impossible.
fn is_usage(error: &Error) -> bool {
    match error {
        Error::NoGuide { .. }
        | Error::NoStoredLight { .. }
        | Error::LightSampling { .. }
        | Error::SampleRange { .. }
        | Error::SampleOrder { .. }
        | Error::Accuracy { .. } => true,
        Error::File { fault, .. } => matches!(fault, FileFault::Extension(_)),
        _ => false,
    }
}

/// What to do about an error.
fn advice(error: &Error) -> Option<String> {
    let text = match error {
        Error::File { fault, .. } => return file_advice(fault),
        Error::NoGuide { .. } => "add --integrator guided",
        Error::NoStoredLight { .. } => "add --integrator radiosity",
        Error::SampleRange { range, sampler, .. } => {
            return Some(format!(
                "the sampler \"{sampler}\" divides the pixel by their number: give --spp {} or more",
                range.end
            ));
        }
        Error::SampleOrder { next, .. } => {
            return Some(format!("begin at {next}, or give a guide that does not learn with --guide-in"));
        }
        Error::Film(FilmError::Size(..) | FilmError::Memory(_)) => "choose a smaller picture with --size",
        Error::Guide(_) => "give a smaller grid or scale with --guide",
        Error::Merge(MergeError::Picture { .. }) => {
            "parts must be rendered from the same scene with the same settings"
        }
        Error::Merge(MergeError::Overlap { .. }) => "give every part its own range with --samples A..B",
        Error::Merge(MergeError::Learning { .. }) => {
            "learn a guide once with --guide-out, and render every part with --guide-in"
        }
        Error::Bake(BakeError::TooMany(..)) => "choose fewer with --texels-per-metre",
        Error::NoReceiver { .. } => {
            "give shapes \"string receiver\" \"NAME\", or add the walls of a box with --room X Y Z"
        }
        Error::Cells { .. } => "ask for fewer with --cells or longer ones with --texel",
        Error::Integrate(_) => "\"--method trace\" takes lights of every kind",
        _ => return None,
    };
    Some(text.to_owned())
}

fn file_advice(fault: &FileFault) -> Option<String> {
    let text = match fault {
        FileFault::NoFolder(_) => "make the folder first, or name another",
        FileFault::Exists => "continue from it with --resume, or remove it to start anew",
        FileFault::Extension("pictures") => "the extension selects the format: .exr, .png, .hdr or .pfm",
        FileFault::Extension("models") => "models are written as .glb",
        FileFault::Extension("luminaires") => "candela distributions are written as .ldt or .ies",
        FileFault::Identity(_) => {
            "use the scene and the settings it was begun with, or another checkpoint file"
        }
        FileFault::GuideSettings { found, .. } => {
            return Some(format!("give the guide of its file: --guide {found}"));
        }
        FileFault::OtherLight(_) => "bake this scene with this program: glanz bake SCENE --checkpoint FILE",
        FileFault::UnfinishedLight => "finish it first: glanz bake SCENE --checkpoint FILE --resume",
        FileFault::OtherReceivers => "for the walls of a room, add --room",
        FileFault::OtherLuxMap | FileFault::Json(_) => "give the folder that glanz illuminate wrote with -o",
        _ => return None,
    };
    Some(text.to_owned())
}
