//! The program `glanz-study`: runs a study and writes its report.

mod arguments;
mod command;

use std::process::ExitCode;

use glanz_terminal::{exit_code, parse};

use arguments::StudyArguments;

fn main() -> ExitCode {
    let arguments: StudyArguments = match parse() {
        Ok(arguments) => arguments,
        Err(code) => return code,
    };
    let messages = arguments.verbosity.messages();
    exit_code(messages, command::run(&arguments, messages))
}
