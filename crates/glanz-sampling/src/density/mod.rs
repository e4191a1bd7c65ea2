//! Densities on the unit cube in bases of functions, fitted to the samples drawn from them.
//!
//! - [`Density`]: normalized nonnegative coefficients in a [`TensorBasis`](crate::basis::TensorBasis); value, samples, exact variance
//!   of an estimator;
//! - [`CoefficientFloor`]: the lower bound that makes an approximation, which may be negative, a density;
//! - [`DensityFitter`] and [`DualEstimate`]: the coefficients of an integrand from its samples;
//! - [`TensorMultiResolution`] and [`AdaptiveDensity`]: density and fitter together, on one level or from coarse to fine.
//!
//! Drawing a point and evaluating the density do not allocate. In document 003 the samples of 2.21 and 2.22 are divided by the
//! density; here they are not, since they already follow p_jk, and the integral of f N_j N_k would be wrong otherwise.
//!
//! # Source
//! @pietrek2001 sections 2.4 to 2.6.

mod adaptive;
mod coefficient_floor;
mod coefficients;
mod fitter;
#[cfg(test)]
mod tests;

pub use adaptive::{AdaptiveDensity, TensorMultiResolution};
pub use coefficient_floor::CoefficientFloor;
pub use coefficients::{Density, DensitySample};
pub use fitter::{DensityFitter, DualEstimate, FittingMethod, MissingCoefficient, Weighting};
