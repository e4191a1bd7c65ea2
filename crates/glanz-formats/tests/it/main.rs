//! Files that are read, good and bad, checked from outside.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot write its files has failed"
)]

mod confined;
mod documentation;
mod limits;
mod pbrt_errors;
mod pbrt_files;
mod pbrt_freeform;
mod pbrt_lowering;
mod pbrt_photometry;
mod pbrt_write;
mod step_shape;
