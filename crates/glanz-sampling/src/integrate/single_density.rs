//! Integration with one density.

use crate::density::{Density, DensitySample};
use crate::error::DensityError;
use crate::integrate::estimate::{Estimate, RunningMoments};
use crate::integrate::sample_points::{SamplePoints, SamplingPattern};

/// Largest number of samples at which [`integrate_by_blocks`] evaluates an integrand at once.
pub(super) const BLOCK: usize = 4096;

/// Numbers of samples and their pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IntegrationPlan {
    /// Number of samples per repetition, at least 1; [`SamplingPattern::Stratified`] rounds up.
    pub samples: u32,
    /// Number of repetitions with different random numbers, at least 1. If samples are not independent, the variance of the mean is
    /// estimated from the repetitions, and 16 is a good number; otherwise 1 is.
    pub repetitions: u32,
    /// Pattern of the samples.
    pub sampling: SamplingPattern,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Integrates `f` over [0, 1]^D by samples from `density`; `f` takes a slice of D numbers.
///
/// Unbiased if the density is 0 only where f is 0. Values that are not finite count as 0.
///
/// # Errors
/// [`DensityError::Samples`].
pub fn integrate<const D: usize>(
    density: &Density<D>,
    plan: &IntegrationPlan,
    mut f: impl FnMut(&[f64]) -> f64,
) -> Result<Estimate, DensityError> {
    integrate_by_blocks(density, plan, |samples, values| {
        values.iter_mut().zip(samples).for_each(|(value, sample)| *value = f(&sample.point));
        Ok(())
    })
}

/// As [`integrate`], for an integrand that is evaluated at up to 4096 samples at once: `f` writes the value at each sample of the
/// first list to the second. The same bits as [`integrate`] for the same values.
///
/// # Errors
/// [`DensityError::Samples`]; those of `f`, with which the integration ends.
pub fn integrate_by_blocks<const D: usize, E: From<DensityError>>(
    density: &Density<D>,
    plan: &IntegrationPlan,
    mut f: impl FnMut(&[DensitySample<D>], &mut [f64]) -> Result<(), E>,
) -> Result<Estimate, E> {
    if plan.samples == 0 || plan.repetitions == 0 {
        return Err(DensityError::Samples.into());
    }
    let (mut primary, mut means) = (RunningMoments::default(), RunningMoments::default());
    let (mut samples, mut values) = (Vec::new(), Vec::new());
    for repetition in 0..plan.repetitions {
        let points = SamplePoints::new(plan.sampling, plan.seed, repetition, plan.samples, D);
        let mut sum = 0.0;
        for first in (0..points.count()).step_by(BLOCK) {
            let end = points.count().min(first.saturating_add(BLOCK as u32));
            samples.clear();
            samples.extend((first..end).map(|index| density.sample(&points.point(index))));
            values.clear();
            values.resize(samples.len(), 0.0);
            f(&samples, &mut values)?;
            for (sample, value) in samples.iter().zip(&values) {
                let value = value / sample.pdf;
                let value = if value.is_finite() { value } else { 0.0 };
                primary.add(value);
                sum += value;
            }
        }
        means.add(sum / f64::from(points.count()));
    }
    let primary_variance = primary.variance();
    let mean_variance = match plan.sampling {
        SamplingPattern::Independent => primary_variance.map(|v| v / primary.count() as f64),
        SamplingPattern::Stratified | SamplingPattern::Sobol => {
            means.variance().map(|v| v / f64::from(plan.repetitions))
        }
    };
    Ok(Estimate {
        samples: primary.count(),
        mean: primary.mean(),
        primary_variance: primary_variance.unwrap_or(0.0),
        mean_variance: mean_variance.unwrap_or(f64::INFINITY),
    })
}
