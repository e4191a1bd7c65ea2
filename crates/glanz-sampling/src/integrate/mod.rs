//! Monte Carlo integration over the unit cube.
//!
//! - [`Estimate`]: an integral with its variances, which are told apart by name;
//! - [`Plan`] and [`integrate`]: samples of one density, independent, stratified or quasi-Monte Carlo;
//! - [`AdaptivePlan`] and [`integrate_adaptively`]: passes whose density learns from the one before.
//!
//! # Source
//! @pietrek2001 sections 2.1 to 2.3, 2.5.1.

mod estimate;
mod passes;
mod plain;
mod points;
#[cfg(test)]
mod tests;

pub use estimate::Estimate;
pub use passes::{AdaptivePlan, AdaptiveResult, Pass, PassResult, integrate_adaptively};
pub use plain::{Plan, integrate};
pub use points::Sampling;
