//! The command line from end to end: the program as a user runs it, judged by its files, messages and exit codes.

mod bad_input;
mod bake;
mod illuminate;
mod render;
mod same_bits;
mod support;
mod tools;
mod view;
