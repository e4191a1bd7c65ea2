//! The process of a scene that a page has opened, for programs that embed the server and for its tests; `glanz view` runs itself.
//!
//! Its argument, if there is one, is the number of threads of a render; the default is all of the machine.

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

use glanz_viewer::server::{WorkerSettings, run_worker, worker_folder};

fn main() -> ExitCode {
    match run(std::env::args_os().nth(1)) {
        Ok(()) => ExitCode::SUCCESS,
        // The server reads it.
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "{error}");
            ExitCode::FAILURE
        }
    }
}

fn run(threads: Option<OsString>) -> Result<(), String> {
    let number = |text: OsString| {
        let parsed = text.to_str().and_then(|text| text.parse().ok());
        parsed.ok_or_else(|| format!("the number of threads must be a number, not {}", text.display()))
    };
    let threads = threads.map_or(Ok(0), number)?;
    let folder = worker_folder().ok_or("only the server of a viewer starts this program")?;
    run_worker(&folder, WorkerSettings { threads, ..WorkerSettings::default() })
        .map_err(|error| error.to_string())
}
