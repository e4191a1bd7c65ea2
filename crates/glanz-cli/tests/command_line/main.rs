//! The command line from end to end: the program as a user runs it, judged by its files, messages and exit codes.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test may fail")]

mod bad_input;
mod bake;
mod illuminate;
mod render;
mod same_bits;
mod support;
mod tools;
mod view;
