#![doc = include_str!("../README.md")]
//!
//! `docs/viewer.md` in the repository describes the parts and the messages between them.

mod leaf_ranges;
pub mod model;
pub mod query;
pub mod server;
pub mod stream;
