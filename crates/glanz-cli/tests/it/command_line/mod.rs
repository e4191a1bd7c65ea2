//! End-to-end tests of the commands: files, messages and exit codes.

mod bad_input;
mod bake;
mod bake_parts;
mod convert;
mod file_kinds;
mod file_list;
#[cfg(unix)]
mod file_safety;
mod file_uses;
mod illuminate;
mod illuminate_parts;
mod limits;
mod merge;
mod model;
mod optimize;
mod planning;
mod progress;
mod render;
mod same_bits;
mod scripts;
pub(crate) mod small_scene;
pub(crate) mod support;
mod tools;
mod view;
