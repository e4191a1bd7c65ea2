//! Jobs from scene files to results.

#![cfg(all(feature = "formats", feature = "illumination"))]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot set up its scene has failed")]

mod illuminance;
#[cfg(feature = "viewer")]
mod lux_folder;
mod optimize;
mod texture_faults;
