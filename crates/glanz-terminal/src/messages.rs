//! What people read: notes, warnings and errors, on the standard error stream.

use std::io::{IsTerminal, Write};

use glanz_scene::Severity;

/// Where messages go, and how.
#[derive(Clone, Copy, Debug)]
pub struct Messages {
    quiet: bool,
    colour: bool,
    is_terminal: bool,
}

const RED: &str = "\x1b[1;31m";
const YELLOW: &str = "\x1b[1;33m";
const CYAN: &str = "\x1b[1;36m";
const PLAIN: &str = "\x1b[0m";

/// Goes to the beginning of the line of a terminal and clears it.
pub(crate) const CLEAR_LINE: &str = "\r\x1b[2K";

impl Messages {
    /// Messages to the standard error stream, errors only if `quiet`; coloured on a terminal unless the variable
    /// `NO_COLOR` is set to something.
    pub fn new(quiet: bool) -> Self {
        let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        let is_terminal = std::io::stderr().is_terminal();
        Self { quiet, colour: is_terminal && !refused, is_terminal }
    }

    /// Whether only errors are said.
    pub fn is_quiet(self) -> bool {
        self.quiet
    }

    /// Something worth knowing.
    pub fn note(self, text: &str) {
        if !self.quiet {
            self.say("", "", text);
        }
    }

    /// Something that was mended or left out.
    pub fn warning(self, text: &str) {
        if !self.quiet {
            self.say(YELLOW, "warning: ", text);
        }
    }

    /// A message about the scene, which begins with its severity.
    pub fn diagnostic(self, severity: Severity, text: &str) {
        let (colour, label) = match severity {
            Severity::Error => (RED, "error: "),
            Severity::Warning if self.quiet => return,
            Severity::Warning => (YELLOW, "warning: "),
        };
        self.say(colour, label, text.strip_prefix(label).unwrap_or(text).trim_end());
    }

    /// Why the command failed, with `help` on what to do about it.
    pub fn error(self, failure: &CommandError) {
        if !failure.message.is_empty() {
            self.say(RED, "error: ", &failure.message);
        }
        if let Some(help) = &failure.help {
            self.say(CYAN, "  help: ", help);
        }
    }

    fn say(self, colour: &str, label: &str, text: &str) {
        let (on, off) = if self.colour && !label.is_empty() { (colour, PLAIN) } else { ("", "") };
        // A progress bar may be in the line.
        let clear = if self.is_terminal { CLEAR_LINE } else { "" };
        // Nobody is left to report to if this stream is closed.
        let _ = writeln!(std::io::stderr().lock(), "{clear}{on}{label}{off}{text}");
    }
}

/// Why a command failed, as sentences.
#[derive(Debug)]
pub struct CommandError {
    /// What is wrong, and where; empty if that was said already.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
    /// Whether the command line asked for something impossible, rather than that something went wrong.
    pub usage: bool,
}

impl CommandError {
    /// Something went wrong.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), help: None, usage: false }
    }

    /// Something went wrong, and it was said what.
    pub fn reported() -> Self {
        Self::new("")
    }

    /// The command line asks for something impossible.
    pub fn usage(message: impl Into<String>) -> Self {
        Self { usage: true, ..Self::new(message) }
    }

    /// The same with an advice.
    pub fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }
}
