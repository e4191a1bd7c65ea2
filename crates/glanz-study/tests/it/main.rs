//! The program from end to end, and claims of the documentation that take pictures to check.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test may fail, and says why"
)]

mod command_line;
#[path = "../../../glanz-cli/tests/it/command_line/support.rs"]
mod support;
mod unbiased;

/// The program under test.
const PROGRAM: &str = env!("CARGO_BIN_EXE_glanz-study");
