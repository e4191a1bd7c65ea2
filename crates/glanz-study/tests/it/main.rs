//! Claims of the documentation that take pictures to check.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test may fail, and says why"
)]

mod unbiased;
