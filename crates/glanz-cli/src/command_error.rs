//! Conversion of errors of the engine into messages with advice.

use glanz::denoise::DenoiseError;
use glanz::formats::{Diagnostic, Diagnostics, Severity};
use glanz::illumination::optimize::OptimizeError;
use glanz::job::{BudgetError, CheckpointLockError, IoFault, LimitError};
use glanz::radiosity::bake::BakeError;
use glanz::transport::FilmError;
use glanz::{Error, FileFault, JoinError, PartKind};
use glanz_terminal::messages::{CommandError, Messages};

use crate::file_help::{is_guess, named};
use crate::notes::note_diagnostics;

/// Converts errors into messages with advice; the diagnostics of a scene are printed at once, with their places.
pub(crate) fn command_error(messages: Messages) -> impl Fn(Error) -> CommandError {
    move |error| {
        let ended = |diagnostics: &Diagnostics| diagnostics.end() == Some(BudgetError::Interrupted);
        if matches!(&error, Error::Interrupted(_)) || matches!(&error, Error::Scene(d) if ended(d)) {
            return CommandError::interrupted("interrupted; nothing was written");
        }
        if let Error::Scene(diagnostics) = &error {
            match diagnostics.limit() {
                Some(limit) => note_limit(diagnostics, limit, messages),
                None => note_diagnostics(diagnostics, messages),
            }
            let first = diagnostics.iter().find(|diagnostic| diagnostic.severity == Severity::Error);
            return CommandError::reported(first.map_or_else(String::new, Diagnostic::sentence));
        }
        let failure = if error.is_of_options() { CommandError::usage } else { CommandError::new };
        let failure = failure(error.to_string());
        match (advice(&error), &error) {
            (Some(help), _) => failure.with_help(help),
            // Another kind of file than the command takes.
            (None, Error::File { path, fault }) if fault.is_foreign() => named(failure, path, is_guess),
            (None, _) => failure,
        }
    }
}

/// Prints the place at which a limit was reached, with the option that raises it.
pub(crate) fn note_limit(diagnostics: &Diagnostics, limit: LimitError, messages: Messages) {
    let help = limit_help(limit);
    for diagnostic in diagnostics {
        let diagnostic = Diagnostic { help: Some(help.clone()), ..diagnostic.clone() };
        messages.diagnostic(diagnostic.severity, &diagnostic.to_string());
    }
}

/// The option that raises a limit.
pub(crate) fn limit_help(limit: LimitError) -> String {
    format!("raise it with {}", limit.option())
}

/// Advice on an error.
fn advice(error: &Error) -> Option<String> {
    let text = match error {
        Error::File { fault, .. } => return file_advice(fault),
        Error::NoScene { .. } => {
            "write a scene file with lights that names the model: Shape \"step\", \"iges\" or \"plymesh\" with \"string filename\" \"FILE\""
        }
        Error::NoModel { .. } => "triangles can be made of a scene: .glb, .obj or .ply",
        Error::NoGuide { .. } => "add --integrator guided",
        Error::NoStoredLight { .. } => "add --integrator radiosity",
        Error::NoiseOf { integrator: "guided" } => {
            "use a learnt guide with --guide-in, or add --integrator path"
        }
        Error::NoiseOf { .. } => "add --integrator path",
        Error::Branching { .. } => "add --integrator path or distributed, or leave out --branching",
        Error::SampleRange { range, sampler, .. } => {
            return Some(format!(
                "the sampler \"{sampler}\" divides the pixel by the number of samples: set --spp to {} or more",
                range.end
            ));
        }
        Error::SampleOrder { next, .. } => {
            return Some(format!("begin at {next}, or use a learnt guide with --guide-in"));
        }
        Error::Film(FilmError::Limit { needed, .. }) => return Some(memory_advice(*needed)),
        Error::Film(FilmError::Size(..) | FilmError::Memory(_)) => "choose a smaller picture with --size",
        Error::Guide(_) => "choose a smaller grid or scale with --guide",
        Error::OrderedParts => ORDERED_HELP,
        Error::PartGoal => "add --rays N, the number of the whole, and leave out --time and --error",
        Error::Indivisible { .. } => "leave out --part, or choose another --method",
        Error::NoFarField => "leave out --far-field, or choose another --method",
        Error::RayGoal => "add --rays N, and leave out --time, --error, --part and --method",
        Error::DirectRating => "leave out --method",
        Error::Join(error) => match &**error {
            JoinError::Whole(FilmError::Limit { needed, .. }) => {
                let limit = mebibytes(needed.saturating_mul(2));
                return Some(format!("raise it with --memory {limit} (half of it is for the film)"));
            }
            error => return join_advice(error).map(str::to_owned),
        },
        Error::Denoise(DenoiseError::NotFound { .. }) => {
            "install it (https://www.openimagedenoise.org, or the Python package pyoidn), and set OIDN_DIR to the folder that contains its folder lib (of pyoidn: site-packages/pyoidn/oidn)"
        }
        Error::Bake(BakeError::TooMany(..)) => "choose fewer with --texels-per-metre",
        Error::NoReceiver { .. } => {
            "mark shapes with \"string receiver\" \"NAME\", or add the walls of a box with --room X Y Z"
        }
        Error::Cells { .. } => "choose fewer with --cells or longer ones with --texel",
        Error::Optimize { error, .. } => {
            return match error.budget() {
                Some(BudgetError::Limit(limit)) => Some(limit_help(*limit)),
                Some(end) => end.help(),
                None => optimize_advice(error).map(str::to_owned),
            };
        }
        Error::Integrate(_) => "\"--method trace\" supports lights of every kind",
        _ => return None,
    };
    Some(text.to_owned())
}

/// Advice on a film that needs a limit of `memory` bytes.
pub(crate) fn memory_advice(memory: u64) -> String {
    format!("raise it with --memory {}, or choose a smaller picture with --size", mebibytes(memory))
}

/// Bytes, rounded up, as `--memory` reads them.
fn mebibytes(bytes: u64) -> String {
    format!("{}M", bytes.div_ceil(1 << 20))
}

fn optimize_advice(error: &OptimizeError) -> Option<&'static str> {
    Some(match error {
        OptimizeError::NoVariable => {
            "name what may change: \"string free\" \"P\" in a shape of control points"
        }
        OptimizeError::NoTarget => {
            "name what is wanted: \"string target\" \"even\" in a receiver, or \"collimation\" in a mirror"
        }
        OptimizeError::Light { .. } => "use surfaces of uniform radiance and point lights, without \"range\"",
        OptimizeError::NoReflection(_) => {
            "check that the lamps shine on a shape with the material \"mirror\" or a smooth \"conductor\""
        }
        OptimizeError::NoRectangle { .. } => {
            "use a \"plane\" with x and y, or a flat rectangular \"bilinearmesh\""
        }
        _ => return None,
    })
}

/// Advice on parts whose samples depend on one another.
const ORDERED_HELP: &str =
    "learn a guide once with --guide-out, render every part with --guide-in, and without --noise";

fn join_advice(error: &JoinError) -> Option<&'static str> {
    match error {
        JoinError::Identity { .. } => {
            Some("parts must be computed from the same scene with the same settings")
        }
        JoinError::Film { error: FilmError::Layout(_), .. } => {
            Some("render every part with the same --edges, or without")
        }
        JoinError::Overlap { .. } => Some(
            "compute every part with a number of its own, --part K/N, or samples of its own, --samples A..B",
        ),
        JoinError::Ordered { .. } => Some(ORDERED_HELP),
        JoinError::Contradiction { .. } => Some("compute both again, with the same program"),
        JoinError::NoPart { .. } => Some("parts are computed with --part K/N"),
        JoinError::Kinds { .. } => Some("join each kind by itself"),
        JoinError::NoPicture { kind: PartKind::Illuminance } => Some(
            "join them with --checkpoint WHOLE and without -o, then: glanz illuminate SCENE -o DIR --rays N --checkpoint WHOLE --resume",
        ),
        JoinError::NoPicture { .. } => Some(
            "join them with --checkpoint WHOLE and without -o, then: glanz bake SCENE -o FILE --checkpoint WHOLE --resume",
        ),
        JoinError::Missing(_) => Some("compute what is missing, or join what is there with --partial"),
        _ => None,
    }
}

fn file_advice(fault: &FileFault) -> Option<String> {
    let text = match fault {
        FileFault::Io(error) | FileFault::NotWritable(error) | FileFault::NotMade(error) => {
            IoFault::of(error)?.advice
        }
        FileFault::Lock(CheckpointLockError::Taken { .. }) => {
            "wait until it ends, or choose another checkpoint file; --resume continues from this one then"
        }
        FileFault::Lock(CheckpointLockError::Io(error)) => IoFault::of(error)?.advice,
        FileFault::NoFolder(_) => "create the folder first, or choose another",
        FileFault::Exists => "continue from it with --resume, or remove it to start anew",
        FileFault::Extension("pictures") => "the extension selects the format: .exr, .png, .hdr or .pfm",
        FileFault::Extension("scenes") => "the extension selects the format: .pbrt, .glb, .obj or .ply",
        FileFault::Extension("scene files") => "scene files are written as .pbrt",
        FileFault::Extension("models") => "models are written as .glb",
        FileFault::Extension("rays") => "rays are written as .tm25ray",
        FileFault::Extension("luminaires") => "candela distributions are written as .ldt or .ies",
        FileFault::Identity(_) => {
            "use the scene and the settings of the checkpoint, or another checkpoint file"
        }
        FileFault::GuideSettings { found, .. } => {
            return Some(format!("use the settings of the file: --guide {found}"));
        }
        FileFault::OtherLight(_) => "bake this scene with this program: glanz bake SCENE --checkpoint FILE",
        FileFault::UnfinishedLight => "finish it first: glanz bake SCENE --checkpoint FILE --resume",
        FileFault::OtherReceivers => "if the receivers are the walls of a room, add --room",
        FileFault::OtherLuxMap | FileFault::Json(_) => "choose the output folder of glanz illuminate",
        _ => return None,
    };
    Some(text.to_owned())
}
