//! The process of a scene that a page has opened, for programs that embed the server and for its tests; `glanz view` runs itself.
//!
//! Its argument, if there is one, is the number of threads of a render; the default is all of the machine.

use std::io::Write;
use std::process::ExitCode;

use glanz_viewer::server::{WorkerSettings, run_worker, worker_folder};

fn main() -> ExitCode {
    let threads = std::env::args().nth(1).and_then(|threads| threads.parse().ok()).unwrap_or(0);
    let settings = WorkerSettings { threads, ..WorkerSettings::default() };
    match worker_folder().map(|folder| run_worker(&folder, settings)) {
        Some(Ok(())) => ExitCode::SUCCESS,
        // The server reads it.
        Some(Err(error)) => {
            let _ = writeln!(std::io::stderr(), "{error}");
            ExitCode::FAILURE
        }
        None => ExitCode::FAILURE,
    }
}
