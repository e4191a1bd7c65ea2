#![doc = include_str!("../README.md")]
//!
//! # Modules
//! - [`values`] parses the values of options, [`Verbosity`] holds the options that every command has;
//! - [`messages`] and [`progress`] write to the standard error stream, [`output`] to the standard output;
//! - `openjd` writes progress, status and failure for render farms;
//! - [`interrupt`] turns Ctrl-C, SIGTERM and SIGHUP into a flag;
//! - [`parse`] and [`exit_code`] are the two ends of a `main` function.

pub mod interrupt;
pub mod messages;
mod openjd;
pub mod output;
pub mod progress;
pub mod values;

use std::process::ExitCode;

use clap::{Args, Parser, ValueEnum};

use messages::{CommandError, Messages};

/// Exit code for wrong usage.
const WRONG_USAGE: u8 = 2;

/// Outcome of a command that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandOutcome {
    /// Everything was done.
    Done,
    /// Everything was done, and the tested condition does not hold.
    Refused,
    /// A signal ended the command early; its results so far are saved.
    Interrupted,
}

/// The options that control how much a command prints.
#[derive(Clone, Copy, Debug, Args)]
pub struct Verbosity {
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Print one JSON object at the end
    #[arg(long)]
    pub json: bool,
    /// Format of progress, status and failure: for people, or for a render farm as messages of Open Job Description on the
    /// standard output
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t, conflicts_with = "json")]
    progress: ProgressFormat,
}

/// Formats of progress, status and failure, without help texts, which would lengthen that of the command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressFormat {
    // On the standard error stream: a bar on a terminal, lines elsewhere.
    #[default]
    Auto,
    // Also on the standard output, in lines that begin with `openjd_`.
    #[value(name = "openjd")]
    OpenJobDescription,
}

impl Verbosity {
    /// Whether the standard output has messages for programs.
    #[must_use]
    pub fn is_for_programs(self) -> bool {
        self.json || self.progress == ProgressFormat::OpenJobDescription
    }

    /// Writer of messages with these settings.
    #[must_use]
    pub fn messages(self) -> Messages {
        Messages::new(self.quiet).with_format(self.progress)
    }
}

/// Prepares the process, and parses the command line.
///
/// # Errors
/// The exit code, after help, version or the fault has been printed.
pub fn parse<P: Parser>() -> Result<P, ExitCode> {
    interrupt::report_large_files_as_errors();
    P::try_parse().map_err(|error| {
        if error.use_stderr() {
            fail_of_usage(&error.to_string());
        }
        let _ = error.print();
        ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(WRONG_USAGE))
    })
}

/// Reports wrong usage to a render farm: the first line of the error. Nothing has been parsed.
fn fail_of_usage(error: &str) {
    let words: Vec<String> = std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
    if words.join("=").contains("=--progress=openjd") {
        let messages = Messages::new(false).with_format(ProgressFormat::OpenJobDescription);
        let line = error.lines().next().unwrap_or_default();
        openjd::fail(messages, line.strip_prefix("error: ").unwrap_or(line));
    }
}

/// The exit code of a command; prints the message of a failure.
#[must_use]
pub fn exit_code(messages: Messages, outcome: Result<CommandOutcome, CommandError>) -> ExitCode {
    match outcome {
        Ok(CommandOutcome::Done) => {
            openjd::progress(messages, 1.0);
            ExitCode::SUCCESS
        }
        Ok(CommandOutcome::Refused) => ExitCode::FAILURE,
        Ok(CommandOutcome::Interrupted) => {
            openjd::fail(messages, "interrupted by a signal");
            ExitCode::from(interrupt::exit_code())
        }
        // Nobody reads the rest: no error, as in `glanz info FILE | head`.
        Err(failure) if failure.is_closed_pipe => ExitCode::from(interrupt::CLOSED_PIPE),
        Err(failure) if failure.is_interrupted => {
            messages.note(&failure.message);
            openjd::fail(messages, "interrupted by a signal");
            ExitCode::from(interrupt::exit_code())
        }
        Err(failure) => {
            messages.error(&failure);
            if failure.usage { ExitCode::from(WRONG_USAGE) } else { ExitCode::FAILURE }
        }
    }
}
