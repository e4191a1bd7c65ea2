//! Light that is counted: lux by particles, receivers, tallies.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot set up its scene has failed")]

mod cie171;
mod closed_forms;
mod combined;
mod common;
mod daylight;
mod far_field;
mod finish;
mod planning;
mod receivers;
mod tally;
