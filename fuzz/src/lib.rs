#![doc = include_str!("../README.md")]
//!
//! # Modules
//! [`targets`] is the table of everything that takes files. [`mutation`] makes mutants of its right files, [`campaign`] reads them one after the
//! other under the [`limits`], and keeps those with a new outcome as files to mutate. [`corpus`] replays the files that were read wrongly once, and [`minimize`] makes a
//! failing file smaller. The program `glanz-fuzz` has processes of its own for reading ([`worker`]), which may end in any way; [`progress`] shows
//! how far all of them are.

#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a program's own parts report to it by printing"
)]

pub mod campaign;
pub mod corpus;
pub mod limits;
pub mod measurement;
pub mod minimize;
pub mod mutation;
pub mod progress;
pub mod targets;
pub mod worker;
