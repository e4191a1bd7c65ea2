//! Choices by weight and piecewise constant densities.

pub mod alias;
pub mod grid;
pub mod piecewise_constant;
pub mod windowed;

pub use alias::AliasTable;
pub use grid::PiecewiseConstant2;
pub use piecewise_constant::PiecewiseConstant1;
pub use windowed::{GridWindow, WindowedPiecewiseConstant2};

/// Invalid weights.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WeightsError {
    /// There are no weights.
    #[error("there are no weights; at least one is needed")]
    Empty,
    /// A weight is negative, infinite or NaN.
    #[error("weight {index} is {value}; it must be finite and not negative")]
    Weight {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// All weights are zero, or their sum is infinite.
    #[error("the sum of the weights is {0}; it must be positive and finite")]
    Sum(f64),
    /// The number of weights is not the product of the sides, or more than 2^32 - 1.
    #[error("there are {found} weights; a table of {width} x {height} is needed")]
    Length {
        /// Weights given.
        found: usize,
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
}

/// A random choice by weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscreteChoice {
    /// Index of the chosen element.
    pub index: usize,
    /// Probability of this choice.
    pub probability: f64,
    /// A number that is uniform in [0, 1) and independent of the choice.
    pub xi: f64,
}

/// Largest number below 1.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

fn checked_sum(weights: &[f64]) -> Result<f64, WeightsError> {
    if weights.is_empty() {
        return Err(WeightsError::Empty);
    }
    if let Some((index, &value)) = weights.iter().enumerate().find(|(_, w)| !(w.is_finite() && **w >= 0.0)) {
        return Err(WeightsError::Weight { index, value });
    }
    let sum: f64 = weights.iter().sum();
    if sum > 0.0 && sum.is_finite() { Ok(sum) } else { Err(WeightsError::Sum(sum)) }
}
