//! Integration with one density.

use crate::density::{Density, DensitySample};
use crate::error::DensityError;
use crate::integrate::estimate::{Estimate, Moments};
use crate::integrate::points::{Points, Sampling};

/// How many samples, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Samples of a repetition, at least 1; [`Sampling::Stratified`] rounds up.
    pub samples: u32,
    /// Repetitions with other random numbers, at least 1. Only their spread tells the variance of the mean where samples are
    /// not independent; 16 are a good number there, and 1 elsewhere.
    pub repetitions: u32,
    /// How samples are spread.
    pub sampling: Sampling,
    /// Other seeds give other numbers, the same seed the same.
    pub seed: u64,
}

/// The integral of `f` over [0, 1]^D, by samples from `density`; `f` gets D numbers.
///
/// Right (unbiased) if the density is 0 only where f is. Values that are not finite count as 0.
///
/// # Errors
/// [`DensityError::Samples`].
pub fn integrate<const D: usize>(
    density: &Density<D>,
    plan: &Plan,
    mut f: impl FnMut(&[f64]) -> f64,
) -> Result<Estimate, DensityError> {
    run(density, plan, |sample| f(&sample.point))
}

/// As [`integrate`], for a function that is told the whole sample.
pub(super) fn run<const D: usize>(
    density: &Density<D>,
    plan: &Plan,
    mut f: impl FnMut(&DensitySample<D>) -> f64,
) -> Result<Estimate, DensityError> {
    if plan.samples == 0 || plan.repetitions == 0 {
        return Err(DensityError::Samples);
    }
    let (mut primary, mut means) = (Moments::default(), Moments::default());
    for repetition in 0..plan.repetitions {
        let points = Points::new(plan.sampling, plan.seed, repetition, plan.samples, D);
        let mut sum = 0.0;
        for index in 0..points.count() {
            let sample = density.sample(&points.point(index));
            let value = f(&sample) / sample.pdf;
            let value = if value.is_finite() { value } else { 0.0 };
            primary.add(value);
            sum += value;
        }
        means.add(sum / f64::from(points.count()));
    }
    let primary_variance = primary.variance();
    let mean_variance = match plan.sampling {
        Sampling::Independent => primary_variance.map(|v| v / primary.count() as f64),
        Sampling::Stratified | Sampling::Sobol => means.variance().map(|v| v / f64::from(plan.repetitions)),
    };
    Ok(Estimate {
        samples: primary.count(),
        mean: primary.mean(),
        primary_variance: primary_variance.unwrap_or(0.0),
        mean_variance: mean_variance.unwrap_or(f64::INFINITY),
    })
}
