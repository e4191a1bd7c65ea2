#![doc = include_str!("../README.md")]
//!
//! # Modules
//! - [`values`] parses the values of options, [`Verbosity`] holds the options that every command has;
//! - [`messages`] and [`progress`] write to the standard error stream, [`output`] to the standard output;
//! - [`interrupt`] turns Ctrl-C and SIGTERM into a flag;
//! - [`parse`] and [`exit_code`] are the two ends of a `main` function.

pub mod interrupt;
pub mod messages;
pub mod output;
pub mod progress;
pub mod values;

use std::process::ExitCode;

use clap::{Args, Parser};

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
}

/// Parses the command line.
///
/// # Errors
/// The exit code, after help, version or the fault has been printed.
pub fn parse<P: Parser>() -> Result<P, ExitCode> {
    P::try_parse().map_err(|error| {
        let _ = error.print();
        ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(WRONG_USAGE))
    })
}

/// The exit code of a command; prints the message of a failure.
#[must_use]
pub fn exit_code(messages: Messages, outcome: Result<CommandOutcome, CommandError>) -> ExitCode {
    match outcome {
        Ok(CommandOutcome::Done) => ExitCode::SUCCESS,
        Ok(CommandOutcome::Refused) => ExitCode::FAILURE,
        Ok(CommandOutcome::Interrupted) => ExitCode::from(interrupt::EXIT_CODE),
        Err(failure) => {
            messages.error(&failure);
            if failure.usage { ExitCode::from(WRONG_USAGE) } else { ExitCode::FAILURE }
        }
    }
}
