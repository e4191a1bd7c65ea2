//! Results on the standard output.

use std::io::{self, ErrorKind, Write};

use glanz_job::IoFault;
use serde::Serialize;

use crate::messages::CommandError;

/// Prints `report` as one JSON object.
///
/// # Errors
/// If the stream is closed.
pub fn print(report: &impl Serialize) -> Result<(), CommandError> {
    let mut text = serde_json::to_string_pretty(report)
        .map_err(|error| CommandError::new(format!("standard output: {error}")))?;
    text.push('\n');
    print_text(&text)
}

/// Prints `text`.
///
/// # Errors
/// If the stream is closed.
pub fn print_text(text: &str) -> Result<(), CommandError> {
    let mut stream = io::stdout().lock();
    stream.write_all(text.as_bytes()).and_then(|()| stream.flush()).map_err(|error| unwritten(&error))
}

/// The failure of writing to the standard output.
#[must_use]
pub fn unwritten(error: &io::Error) -> CommandError {
    let failure = CommandError::new(format!("standard output: {}", IoFault::sentence(error)));
    let is_closed_pipe = error.kind() == ErrorKind::BrokenPipe;
    CommandError { help: IoFault::of(error).map(|fault| fault.advice.to_owned()), is_closed_pipe, ..failure }
}
