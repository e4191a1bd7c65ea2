//! End-to-end tests of the program.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test may fail, and prints figures with `--nocapture`"
)]

mod bake_points;
mod bake_reference;
mod command_line;
#[cfg(unix)]
mod failures;
mod viewer;

/// The program under test.
const PROGRAM: &str = env!("CARGO_BIN_EXE_glanz");
