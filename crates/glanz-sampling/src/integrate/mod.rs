//! Monte Carlo integration over the unit cube.
//!
//! - [`Estimate`]: an integral with the variances of a single sample and of the mean;
//! - [`IntegrationPlan`] and [`integrate`]: samples of one density, independent, stratified or quasi-Monte Carlo;
//! - [`AdaptivePlan`] and [`integrate_adaptively`]: passes, each with a density fitted to the samples of the previous one.
//!
//! # Source
//! @pietrek2001 sections 2.1 to 2.3, 2.5.1.

mod adaptive;
mod estimate;
mod sample_points;
mod single_density;
#[cfg(test)]
mod tests;

pub use adaptive::{
    AdaptivePlan, AdaptiveResult, IntegrationPass, PassResult, integrate_adaptively,
    integrate_adaptively_by_blocks,
};
pub use estimate::Estimate;
pub use sample_points::SamplingPattern;
pub use single_density::{IntegrationPlan, integrate, integrate_by_blocks};
