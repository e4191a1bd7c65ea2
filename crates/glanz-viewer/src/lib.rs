//! A page that draws exact surfaces, and the local server behind it.
//!
//! `docs/viewer.md` says how the parts hang together and what goes between them.

pub mod model;
pub mod query;
pub mod server;
pub mod stream;
