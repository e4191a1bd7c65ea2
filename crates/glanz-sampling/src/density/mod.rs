//! Densities on the unit cube, in bases of functions, that learn from the samples taken with them.
//!
//! - [`Density`]: coefficients that are not negative in a [`TensorBasis`](crate::basis::TensorBasis), normalised; its
//!   value, samples, exact variance of an estimator;
//! - [`Floor`]: how an approximation, which may be negative, is made a density;
//! - [`Learner`] and [`DualEstimate`]: the coefficients of an integrand from the samples that integrate it;
//! - [`Scales`] and [`AdaptiveDensity`]: density and learner together, on one scale or from coarse to fine.
//!
//! Drawing a point and the density at it allocate nothing. In 003 the samples of 2.21 and 2.22 are divided by the density;
//! as they follow p_jk already, the integral of f N_j N_k would come out wrong then. Here they are not.
//!
//! # Source
//! @pietrek2001 sections 2.4 to 2.6.

mod adaptive;
mod coefficients;
mod floor;
mod learn;
#[cfg(test)]
mod tests;

pub use adaptive::{AdaptiveDensity, Scales};
pub use coefficients::{Density, DensitySample};
pub use floor::Floor;
pub use learn::{DualEstimate, Learner, Learning, Missing, Weighting};
