//! Real roots of polynomials of low degree.

pub mod quadratic;
