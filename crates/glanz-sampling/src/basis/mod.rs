//! Bases of functions on [0, 1], each function a scaled density.
//!
//! - [`UnitKnots`] and [`FunctionBasis`]: B-splines up to degree [`MAX_DEGREE`] on any knots, and Haar's orthonormal box functions:
//!   value, integral, sampling and its inverse for each function;
//! - [`GramMatrix`]: inner products, and with them the dual basis;
//! - [`refinement`] and [`ChangeOfBasis`]: conversion of coefficients between bases;
//! - [`TensorBasis`]: products of bases, one per axis;
//! - [`GaussLegendre`]: the quadrature behind the inner products.

mod change;
mod columns;
mod distributions;
mod functions;
mod gram;
mod knots;
mod quadrature;
mod tensor;

pub use change::{ChangeOfBasis, refinement};
pub use columns::BandedColumns;
pub use functions::FunctionBasis;
pub use gram::GramMatrix;
pub use knots::UnitKnots;
pub use quadrature::GaussLegendre;
pub use tensor::TensorBasis;

pub(crate) use gram::check_length;
pub(crate) use tensor::map_axis;

/// Highest degree of B-splines.
pub const MAX_DEGREE: usize = 7;
/// Largest number of functions that do not vanish at a point.
pub const ORDER: usize = MAX_DEGREE + 1;

/// Largest number below 1.
pub(crate) const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;
