//! Low-discrepancy point sequences.

pub mod owen;
pub mod sobol;
