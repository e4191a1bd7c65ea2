//! Real roots of polynomials of low degree.

pub mod compensated;
pub mod isolate;
mod monotone;
pub mod quadratic;

pub use isolate::{MAX_DEGREE, Roots, roots, visit_roots};
