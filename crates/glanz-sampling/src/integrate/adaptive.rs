//! Integration in passes with adaptive densities.

use std::sync::Arc;

use crate::density::{
    AdaptiveDensity, CoefficientFloor, Density, DensitySample, FittingMethod, TensorMultiResolution,
    Weighting,
};
use crate::error::DensityError;
use crate::hash::combine;
use crate::integrate::estimate::Estimate;
use crate::integrate::sample_points::SamplingPattern;
use crate::integrate::single_density::{IntegrationPlan, integrate_by_blocks};

/// The levels and the number of samples of one pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IntegrationPass<const D: usize> {
    /// Levels of the basis, one per axis; not coarser than those of the previous pass.
    pub levels: [usize; D],
    /// Number of samples per repetition, as in [`IntegrationPlan`].
    pub samples: u32,
}

/// The passes of an adaptive integration, and the parameters of the fits.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptivePlan<const D: usize> {
    /// The passes in order, at least one. The first uses the constant density. Early passes need few samples, but enough to fit the
    /// density; the last passes should have most of them (@pietrek2001 section 2.5.1).
    pub passes: Vec<IntegrationPass<D>>,
    /// As in [`IntegrationPlan`].
    pub repetitions: u32,
    /// As in [`IntegrationPlan`].
    pub sampling: SamplingPattern,
    /// As in [`IntegrationPlan`].
    pub seed: u64,
    /// Lower bound on coefficients.
    pub floor: CoefficientFloor,
    /// Method of estimating coefficients.
    pub method: FittingMethod,
    /// Weights for combining the estimates of the integral, and of coefficients on the same levels.
    pub weighting: Weighting,
}

impl<const D: usize> AdaptivePlan<D> {
    /// Passes of independent samples with the default floor and method, combined by their numbers of samples.
    #[must_use]
    pub fn new(passes: Vec<IntegrationPass<D>>, seed: u64) -> Self {
        Self {
            passes,
            repetitions: 1,
            sampling: SamplingPattern::Independent,
            seed,
            floor: CoefficientFloor::default(),
            method: FittingMethod::default(),
            weighting: Weighting::default(),
        }
    }
}

/// Result of a pass.
#[derive(Clone, Debug, PartialEq)]
pub struct PassResult<const D: usize> {
    /// Levels of the pass.
    pub levels: [usize; D],
    /// The integral from its samples alone.
    pub estimate: Estimate,
    /// The density that was sampled.
    pub density: Density<D>,
    /// The coefficients, on the levels of the pass, of the approximation of the integrand fitted at its end; `None` if the integrand
    /// was 0 at all samples.
    pub approximation: Option<Vec<f64>>,
}

/// Result of all passes.
#[derive(Clone, Debug)]
pub struct AdaptiveResult<const D: usize> {
    /// Results of the single passes.
    pub passes: Vec<PassResult<D>>,
    /// The integral from all passes.
    pub estimate: Estimate,
    /// The density after the last pass, ready for further passes.
    pub adaptive: AdaptiveDensity<D>,
}

/// Integrates `f` over [0, 1]^D in passes, each with a density fitted to the samples of the previous passes, on its own levels.
///
/// # Errors
/// [`DensityError::Samples`], [`DensityError::Level`]; those of [`Density::from_approximation`].
///
/// # Source
/// @pietrek2001 sections 2.5 and 2.6.4.
pub fn integrate_adaptively<const D: usize>(
    scales: &Arc<TensorMultiResolution<D>>,
    plan: &AdaptivePlan<D>,
    mut f: impl FnMut(&[f64]) -> f64,
) -> Result<AdaptiveResult<D>, DensityError> {
    integrate_adaptively_by_blocks(scales, plan, |samples, values| {
        values.iter_mut().zip(samples).for_each(|(value, sample)| *value = f(&sample.point));
        Ok(())
    })
}

/// As [`integrate_adaptively`], for an integrand that is evaluated at many samples at once, as by [`integrate_by_blocks`].
///
/// # Errors
/// Those of [`integrate_adaptively`]; those of `f`, with which the integration ends.
pub fn integrate_adaptively_by_blocks<const D: usize, E: From<DensityError>>(
    scales: &Arc<TensorMultiResolution<D>>,
    plan: &AdaptivePlan<D>,
    mut f: impl FnMut(&[DensitySample<D>], &mut [f64]) -> Result<(), E>,
) -> Result<AdaptiveResult<D>, E> {
    let first = plan.passes.first().ok_or(DensityError::Samples)?;
    let mut adaptive = AdaptiveDensity::try_new(scales.clone(), first.levels, plan.method)?;
    let mut passes = Vec::with_capacity(plan.passes.len());
    for (index, pass) in plan.passes.iter().enumerate() {
        adaptive.refine(pass.levels)?;
        let density = adaptive.density().clone();
        let pass_plan = IntegrationPlan {
            samples: pass.samples,
            repetitions: plan.repetitions,
            sampling: plan.sampling,
            seed: combine(plan.seed, index as u64),
        };
        let estimate = integrate_by_blocks(&density, &pass_plan, |samples, values| {
            f(samples, values)?;
            for (sample, value) in samples.iter().zip(values) {
                adaptive.record(sample, *value);
            }
            Ok::<(), E>(())
        })?;
        let approximation = adaptive.fit(plan.floor, plan.weighting)?;
        passes.push(PassResult { levels: pass.levels, estimate, density, approximation });
    }
    let estimates: Vec<Estimate> = passes.iter().map(|p| p.estimate).collect();
    let estimate = Estimate::combine(&estimates, plan.weighting).ok_or(DensityError::Samples)?;
    Ok(AdaptiveResult { passes, estimate, adaptive })
}
