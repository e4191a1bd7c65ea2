//! The corpus, mutants of every target, and the program that reads them.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot start the program has failed"
)]

mod corpus;
mod mutants;
mod program;

use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

/// The output of the program with these arguments, and the folder in which it keeps files.
fn run(name: &str, arguments: &[&str]) -> (Output, PathBuf) {
    run_with_errors(name, arguments, Stdio::piped())
}

/// The same with this standard error stream.
fn run_with_errors(name: &str, arguments: &[&str], errors: Stdio) -> (Output, PathBuf) {
    let keep = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&keep);
    let mut command = Command::new(env!("CARGO_BIN_EXE_glanz-fuzz"));
    command.args(arguments).arg("--keep").arg(&keep).stderr(errors);
    (command.output().expect("the program starts"), keep)
}

fn text(output: &Output) -> String {
    let [out, error] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    format!("{out}{error}")
}
