//! Tests of surfaces through the public interface.

// A test may fail by unwrapping and prints its figures; `!(a < b)` holds for NaN, which must be a fault.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::neg_cmp_op_on_partial_ord,
    unreachable_pub
)]

mod contract;
mod degenerate_rays;
mod place;
mod seam;
mod zoo;
