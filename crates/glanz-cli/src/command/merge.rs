//! `glanz merge`: parts of one picture, rendered apart, become the whole.

use std::path::Path;

use glanz_transport::{MergeError, merge};
use serde::Serialize;

use crate::Ending;
use crate::arguments::MergeArguments;
use crate::checkpoint_file;
use crate::messages::{Failure, Messages};
use crate::outputs::{self, Outputs};
use crate::report::{self, plural};

#[derive(Serialize)]
struct Report {
    outputs: Vec<String>,
    checkpoint: Option<String>,
    parts: usize,
    samples_per_pixel: u64,
    samples: String,
}

/// Joins the parts and writes the pictures.
///
/// # Errors
/// Why the parts do not go together, or a file cannot be read or written.
pub(crate) fn run(arguments: &MergeArguments, messages: Messages) -> Result<Ending, Failure> {
    let outputs = Outputs::try_new(&arguments.output, outputs::tone(arguments.exposure, arguments.tone))?;
    if let Some(path) = &arguments.checkpoint {
        outputs::check_writable(path)?;
    }
    let name =
        |part: usize| arguments.parts.get(part).map_or_else(String::new, |path| path.display().to_string());

    // Parts are read when it is their turn, so that two of them are in memory at a time; the first that cannot be
    // read ends the joining.
    let mut unreadable = None;
    let parts = arguments
        .parts
        .iter()
        .map_while(|path| checkpoint_file::read(path).map_err(|e| unreadable = Some(e)).ok());
    let merged = merge(parts);
    if let Some(failure) = unreadable {
        return Err(failure);
    }
    let whole = merged.map_err(|error| match error {
        MergeError::Picture { part, mismatch } => {
            Failure::new(format!("{} does not go with {}: {mismatch}", name(part), name(0)))
                .with_help("parts must be rendered from the same scene with the same settings")
        }
        MergeError::Overlap { first, second, samples } => {
            let (first, second, last) = (name(first), name(second), samples.end - 1);
            Failure::new(format!("{first} and {second} both have samples {} to {last}", samples.start))
                .with_help("give every part its own range with --samples A..B")
        }
        MergeError::Learning { part } => Failure::new(format!(
            "{} learnt its own guide while it was rendered: its samples build on one another",
            name(part)
        ))
        .with_help("learn a guide once with --guide-out, and render every part with --guide-in"),
        other => Failure::new(other.to_string()),
    })?;

    let pixels = whole.film.to_pixels().map_err(|error| Failure::new(error.to_string()))?;
    outputs.write(&pixels, &checkpoint_file::attributes(&whole.identity, &whole.film))?;
    if let Some(path) = &arguments.checkpoint {
        checkpoint_file::write(path, &whole.identity, &whole.film)?;
    }
    let samples = whole.film.samples();
    messages.note(&format!(
        "joined {} with samples {samples} into {}",
        plural(arguments.parts.len() as u64, "part", "parts"),
        outputs.names().join(", ")
    ));
    if arguments.talk.json {
        report::print(&Report {
            outputs: outputs.names(),
            checkpoint: arguments.checkpoint.as_deref().map(Path::display).map(|path| path.to_string()),
            parts: arguments.parts.len(),
            samples_per_pixel: samples.total(),
            samples: samples.to_string(),
        })?;
    }
    Ok(Ending::Done)
}
