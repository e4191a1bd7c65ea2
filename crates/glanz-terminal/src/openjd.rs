//! Messages of Open Job Description on the standard output, from which a render farm learns progress, status and failure.
//!
//! # Source
//! @openjd2023, "How Jobs Are Run", section "Stdout/Stderr Messages".

use std::io::Write;

use crate::ProgressFormat;
use crate::messages::Messages;

/// Reports that `fraction`, [0, 1], of the command is done.
pub(crate) fn progress(messages: Messages, fraction: f64) {
    if !messages.is_quiet() {
        send(messages, "progress", &format!("{:.1}", 100.0 * fraction.clamp(0.0, 1.0)));
    }
}

/// Reports what the command does.
pub(crate) fn status(messages: Messages, text: &str) {
    if !messages.is_quiet() {
        send(messages, "status", text);
    }
}

/// Reports why the command fails.
pub(crate) fn fail(messages: Messages, sentence: &str) {
    send(messages, "fail", sentence);
}

fn send(messages: Messages, kind: &str, text: &str) {
    if messages.format() == ProgressFormat::OpenJobDescription {
        // If this stream is closed, nobody listens.
        let _ = writeln!(std::io::stdout().lock(), "{}", line(kind, text));
    }
}

/// The message in one line, as its reader expects it.
fn line(kind: &str, text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    format!("openjd_{kind}: {}", words.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_is_one_line() {
        assert_eq!(line("fail", "a.pbrt:1:2: x\n  | y\n"), "openjd_fail: a.pbrt:1:2: x | y");
        assert_eq!(line("progress", "42.5"), "openjd_progress: 42.5");
    }
}
