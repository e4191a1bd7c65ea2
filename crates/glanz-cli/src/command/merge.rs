//! `glanz merge`: joins the separately rendered parts of a picture.

use std::path::Path;

use glanz::Error;
use glanz::file::FileUses;
use glanz::transport::MergeError;
use glanz_terminal::CommandOutcome;
use glanz_terminal::messages::{CommandError, Messages};
use serde::Serialize;

use crate::arguments::MergeArguments;
use crate::command_error::command_error;
use crate::outputs::Outputs;
use crate::report::{self, plural};

/// The output of `--json`.
#[derive(Serialize)]
struct MergeReport {
    outputs: Vec<String>,
    checkpoint: Option<String>,
    parts: usize,
    samples_per_pixel: u64,
    samples: String,
}

/// Joins the parts and writes the pictures.
///
/// # Errors
/// Parts that do not belong together, or a file that cannot be read or written.
pub(crate) fn run(arguments: &MergeArguments, messages: Messages) -> Result<CommandOutcome, CommandError> {
    let mut files = FileUses::default();
    files.add_inputs(&arguments.parts).map_err(command_error(messages))?;
    let outputs = Outputs::try_new(&arguments.output, arguments.tone.tone(), &mut files, messages)?;
    if let Some(path) = &arguments.checkpoint {
        files.add_output(path).map_err(command_error(messages))?;
    }
    let picture =
        glanz::merge(&arguments.parts).map_err(|error| merge_failure(error, arguments, messages))?;
    outputs.write(&picture)?;
    if let Some(path) = &arguments.checkpoint {
        picture.save_checkpoint(path).map_err(command_error(messages))?;
    }
    let samples = picture.film().samples();
    messages.note(&format!(
        "joined {} with samples {samples} into {}",
        plural(arguments.parts.len() as u64, "part", "parts"),
        outputs.names().join(", ")
    ));
    if arguments.verbosity.json {
        report::print(&MergeReport {
            outputs: outputs.names(),
            checkpoint: arguments.checkpoint.as_deref().map(Path::display).map(|path| path.to_string()),
            parts: arguments.parts.len(),
            samples_per_pixel: samples.total(),
            samples: samples.to_string(),
        })?;
    }
    Ok(CommandOutcome::Done)
}

/// The error, with the files that cause it.
fn merge_failure(error: Error, arguments: &MergeArguments, messages: Messages) -> CommandError {
    let name =
        |part: usize| arguments.parts.get(part).map_or_else(String::new, |path| path.display().to_string());
    let message = match &error {
        Error::Merge(MergeError::Picture { part, mismatch }) => {
            let (first, other) = (name(0), name(*part));
            Some(format!(
                "{first} and {other} are not parts of one picture: {} is {} in {first} and {} in {other}",
                mismatch.what, mismatch.wanted, mismatch.found
            ))
        }
        Error::Merge(MergeError::Film { part, error }) => {
            Some(format!("{} cannot be joined with {}: {error}", name(*part), name(0)))
        }
        Error::Merge(MergeError::Overlap { first, second, samples }) => {
            let (first, second, last) = (name(*first), name(*second), samples.end - 1);
            Some(format!("{first} and {second} both have samples {} to {last}", samples.start))
        }
        Error::Merge(MergeError::Ordered { part }) => Some(format!(
            "the samples of {} depend on earlier ones (a noise level, or a guide that was learnt during the render)",
            name(*part)
        )),
        _ => None,
    };
    let failure = command_error(messages)(error);
    match message {
        Some(message) => CommandError { message, ..failure },
        None => failure,
    }
}
