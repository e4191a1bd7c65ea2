//! The process of a scene that a page has opened, for programs that embed the server and for its tests; `glanz view` runs itself.

use std::process::ExitCode;

use glanz_viewer::server::{WorkerSettings, run_worker, worker_folder};

fn main() -> ExitCode {
    let settings = WorkerSettings { threads: 2, ..WorkerSettings::default() };
    match worker_folder().map(|folder| run_worker(&folder, settings)) {
        Some(Ok(())) => ExitCode::SUCCESS,
        // There is nobody to report to but the server, which reports that the process has ended.
        Some(Err(_)) | None => ExitCode::FAILURE,
    }
}
