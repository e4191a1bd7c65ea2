//! Results on the standard output.

use std::io::Write;

use serde::Serialize;

use crate::messages::Failure;

/// Prints `report` as one JSON object.
///
/// # Errors
/// If the stream is closed.
pub fn print(report: &impl Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(report).map_err(|error| closed(&error))?;
    text.push('\n');
    print_text(&text)
}

/// Prints `text`.
///
/// # Errors
/// If the stream is closed.
pub fn print_text(text: &str) -> Result<(), Failure> {
    let mut stream = std::io::stdout().lock();
    stream.write_all(text.as_bytes()).and_then(|()| stream.flush()).map_err(|error| closed(&error))
}

fn closed(error: &dyn std::fmt::Display) -> Failure {
    Failure::new(format!("standard output: {error}"))
}

/// A duration in words of the largest fitting unit: `3.2 s`, `4 min 05 s`, `2 h 10 min`.
#[must_use]
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_easy_to_read() {
        assert_eq!(duration(3.24), "3.2 s");
        assert_eq!(duration(245.2), "4 min 05 s");
        assert_eq!(duration(7800.0), "2 h 10 min");
    }
}
