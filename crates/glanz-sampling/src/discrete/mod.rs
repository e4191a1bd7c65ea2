//! Choosing among many by weight.

pub mod alias;
pub mod cumulative;
pub mod grid;

pub use alias::AliasTable;
pub use cumulative::PiecewiseConstant1;
pub use grid::PiecewiseConstant2;

/// Why weights cannot be chosen by.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WeightsError {
    /// There is none.
    #[error("there are no weights")]
    Empty,
    /// A weight is negative, infinite or not a number.
    #[error("weight {index} is {value}, it has to be a number of at least 0")]
    Weight {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// All are zero, or so large that their sum is infinite.
    #[error("the weights sum to {0}, nothing can be chosen")]
    Sum(f64),
    /// The number of weights is not the product of the sides, or more than 2^32 - 1.
    #[error("{found} weights do not fill a table of {width} x {height}")]
    Length {
        /// Weights given.
        found: usize,
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
}

/// A choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// What was chosen.
    pub index: usize,
    /// The probability of this choice.
    pub probability: f64,
    /// A number that is again uniform in [0, 1), whatever was chosen.
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
