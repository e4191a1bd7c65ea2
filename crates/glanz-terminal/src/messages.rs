//! Notes, warnings and errors on the standard error stream.

use std::io::{IsTerminal, Write};

use glanz_scene::Severity;

use crate::{ProgressFormat, openjd};

/// Writer of messages with its settings.
#[derive(Clone, Copy, Debug)]
pub struct Messages {
    quiet: bool,
    colour: bool,
    is_terminal: bool,
    format: ProgressFormat,
}

const RED: &str = "\x1b[1;31m";
const YELLOW: &str = "\x1b[1;33m";
const CYAN: &str = "\x1b[1;36m";
const PLAIN: &str = "\x1b[0m";

/// Escape sequence that moves to the beginning of a terminal's line and clears it.
pub(crate) const CLEAR_LINE: &str = "\r\x1b[2K";

impl Messages {
    /// Messages to the standard error stream, errors only if `quiet`; coloured on a terminal unless the variable
    /// `NO_COLOR` is set to something.
    pub fn new(quiet: bool) -> Self {
        let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        let is_terminal = std::io::stderr().is_terminal();
        Self { quiet, colour: is_terminal && !refused, is_terminal, format: ProgressFormat::Auto }
    }

    /// The same with progress, status and failure in this format, too.
    pub(crate) fn with_format(self, format: ProgressFormat) -> Self {
        Self { format, ..self }
    }

    /// The format of progress, status and failure.
    pub(crate) fn format(self) -> ProgressFormat {
        self.format
    }

    /// Whether only errors are printed.
    pub fn is_quiet(self) -> bool {
        self.quiet
    }

    /// Prints a note; for a render farm it is the status instead.
    pub fn note(self, text: &str) {
        match self.format {
            _ if self.quiet => {}
            ProgressFormat::Auto => self.print("", "", text),
            ProgressFormat::OpenJobDescription => openjd::status(self, text),
        }
    }

    /// Prints a warning: something was repaired or left out.
    pub fn warning(self, text: &str) {
        if !self.quiet {
            self.print(YELLOW, "warning: ", text);
        }
    }

    /// Prints a message about the scene, which begins with its severity.
    pub fn diagnostic(self, severity: Severity, text: &str) {
        let (colour, label) = match severity {
            Severity::Error => (RED, "error: "),
            Severity::Warning if self.quiet => return,
            Severity::Warning => (YELLOW, "warning: "),
        };
        self.print(colour, label, text.strip_prefix(label).unwrap_or(text).trim_end());
    }

    /// Prints an error and its help.
    pub fn error(self, failure: &CommandError) {
        openjd::fail(self, &failure.message);
        if !failure.is_printed {
            self.print(RED, "error: ", &failure.message);
        }
        if let Some(help) = &failure.help {
            self.print(CYAN, "  help: ", help);
        }
    }

    fn print(self, colour: &str, label: &str, text: &str) {
        let (on, off) = if self.colour && !label.is_empty() { (colour, PLAIN) } else { ("", "") };
        // A progress bar may be in the line.
        let clear = if self.is_terminal { CLEAR_LINE } else { "" };
        // If this stream is closed, errors cannot be reported.
        let _ = writeln!(std::io::stderr().lock(), "{clear}{on}{label}{off}{text}");
    }
}

/// Error of a command as a message with advice.
#[derive(Debug)]
pub struct CommandError {
    /// The fault and its place.
    pub message: String,
    /// Advice on the error.
    pub help: Option<String>,
    /// Whether the command line is invalid, rather than its execution.
    pub usage: bool,
    /// Whether the fault has been printed already.
    pub is_printed: bool,
    /// Whether the reader of the standard output has closed it, of which nothing is printed.
    pub is_closed_pipe: bool,
    /// Whether a signal ended the command before it had a result.
    pub is_interrupted: bool,
}

impl CommandError {
    /// An error of the execution.
    pub fn new(message: impl Into<String>) -> Self {
        let message = message.into();
        Self {
            message,
            help: None,
            usage: false,
            is_printed: false,
            is_closed_pipe: false,
            is_interrupted: false,
        }
    }

    /// An error that has been printed already.
    pub fn reported(message: impl Into<String>) -> Self {
        Self { is_printed: true, ..Self::new(message) }
    }

    /// The end of a command by a signal, before it had a result.
    pub fn interrupted(message: impl Into<String>) -> Self {
        Self { is_interrupted: true, ..Self::new(message) }
    }

    /// An invalid command line.
    pub fn usage(message: impl Into<String>) -> Self {
        Self { usage: true, ..Self::new(message) }
    }

    /// The same with advice.
    pub fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }
}
