//! Light that is counted: lux by particles, receivers, tallies.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot set up its scene has failed")]

mod closed_forms;
mod combined;
mod common;
mod far_field;
mod planning;
mod receivers;
mod tally;
