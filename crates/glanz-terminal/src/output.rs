//! Results on the standard output.

use std::io::Write;

use serde::Serialize;

use crate::messages::CommandError;

/// Prints `report` as one JSON object.
///
/// # Errors
/// If the stream is closed.
pub fn print(report: &impl Serialize) -> Result<(), CommandError> {
    let mut text = serde_json::to_string_pretty(report).map_err(|error| closed(&error))?;
    text.push('\n');
    print_text(&text)
}

/// Prints `text`.
///
/// # Errors
/// If the stream is closed.
pub fn print_text(text: &str) -> Result<(), CommandError> {
    let mut stream = std::io::stdout().lock();
    stream.write_all(text.as_bytes()).and_then(|()| stream.flush()).map_err(|error| closed(&error))
}

fn closed(error: &dyn std::fmt::Display) -> CommandError {
    CommandError::new(format!("standard output: {error}"))
}
