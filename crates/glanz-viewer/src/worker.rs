//! The process of a scene that a page has opened, for programs that embed the server and for its tests; `glanz view` runs itself.
//!
//! Its argument, if there is one, is the number of threads of a render; the default, and 0, is all of the machine.

use std::ffi::OsString;
use std::io::{self, Write};
use std::process::ExitCode;

use glanz_viewer::server::{WorkerError, WorkerSettings, run_worker, worker_folder};

fn main() -> ExitCode {
    match run(std::env::args_os().skip(1)) {
        Ok(()) => ExitCode::SUCCESS,
        // The server reads it.
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: impl Iterator<Item = OsString>) -> Result<(), WorkerError> {
    let threads = threads(arguments)?;
    let folder = worker_folder().ok_or_else(|| {
        io::Error::other("there is no task; it is started by a server for a file that a page opens")
    })?;
    run_worker(&folder, WorkerSettings { threads, ..WorkerSettings::default() })
}

/// The number of threads among the arguments.
fn threads(mut arguments: impl Iterator<Item = OsString>) -> io::Result<usize> {
    let Some(argument) = arguments.next() else { return Ok(0) };
    if let Some(more) = arguments.next() {
        let message = format!("the argument {more:?} is one too many; the only one is the number of threads");
        return Err(io::Error::other(message));
    }
    argument.to_str().and_then(|text| text.parse().ok()).ok_or_else(|| {
        let expected = "it must be a whole number, 0 for as many as the machine has";
        io::Error::other(format!("the number of threads is {argument:?}; {expected}"))
    })
}
