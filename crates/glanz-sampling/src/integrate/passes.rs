//! Integration in passes whose density learns.

use std::sync::Arc;

use crate::density::{AdaptiveDensity, Density, Floor, Learning, Scales, Weighting};
use crate::error::DensityError;
use crate::hash::combine;
use crate::integrate::estimate::Estimate;
use crate::integrate::plain::{Plan, run};
use crate::integrate::points::Sampling;

/// A pass: where it samples and learns, and how much.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pass<const D: usize> {
    /// Levels of the basis, one per axis; not coarser than those of the pass before.
    pub levels: [usize; D],
    /// Samples of a repetition, as in [`Plan`].
    pub samples: u32,
}

/// The passes, and how they learn and are put together.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptivePlan<const D: usize> {
    /// In their order; at least one. The first uses the constant density. Few samples early, but enough to learn from,
    /// and most at the end (@pietrek2001 section 2.5.1).
    pub passes: Vec<Pass<D>>,
    /// As in [`Plan`].
    pub repetitions: u32,
    /// As in [`Plan`].
    pub sampling: Sampling,
    /// As in [`Plan`].
    pub seed: u64,
    /// How small coefficients are raised.
    pub floor: Floor,
    /// Which samples a coefficient is learnt from.
    pub learning: Learning,
    /// How the estimates of the integral, and of coefficients on one scale, are put together.
    pub weighting: Weighting,
}

impl<const D: usize> AdaptivePlan<D> {
    /// Passes of independent samples with the document's floor, put together by samples.
    #[must_use]
    pub fn new(passes: Vec<Pass<D>>, seed: u64) -> Self {
        Self {
            passes,
            repetitions: 1,
            sampling: Sampling::Independent,
            seed,
            floor: Floor::default(),
            learning: Learning::default(),
            weighting: Weighting::default(),
        }
    }
}

/// What a pass found.
#[derive(Clone, Debug, PartialEq)]
pub struct PassResult<const D: usize> {
    /// Its levels.
    pub levels: [usize; D],
    /// The integral from its samples alone.
    pub estimate: Estimate,
    /// The density that it sampled.
    pub density: Density<D>,
    /// The coefficients on its levels of the approximation of the integrand that was learnt at its end; `None` if the
    /// integrand was 0 at all samples.
    pub approximation: Option<Vec<f64>>,
}

/// What all passes found.
#[derive(Clone, Debug)]
pub struct AdaptiveResult<const D: usize> {
    /// One by one.
    pub passes: Vec<PassResult<D>>,
    /// The integral from all passes.
    pub estimate: Estimate,
    /// The density as the last pass left it, ready for further ones.
    pub adaptive: AdaptiveDensity<D>,
}

/// The integral of `f` over [0, 1]^D in passes, each with the density that the one before has learnt, on its own scale.
///
/// # Errors
/// [`DensityError::Samples`], [`DensityError::Level`]; those of [`Density::from_approximation`].
///
/// # Source
/// @pietrek2001 sections 2.5 and 2.6.4.
pub fn integrate_adaptively<const D: usize>(
    scales: &Arc<Scales<D>>,
    plan: &AdaptivePlan<D>,
    mut f: impl FnMut(&[f64]) -> f64,
) -> Result<AdaptiveResult<D>, DensityError> {
    let first = plan.passes.first().ok_or(DensityError::Samples)?;
    let mut adaptive = AdaptiveDensity::try_new(scales.clone(), first.levels, plan.learning)?;
    let mut passes = Vec::with_capacity(plan.passes.len());
    for (index, pass) in plan.passes.iter().enumerate() {
        adaptive.refine(pass.levels)?;
        let density = adaptive.density().clone();
        let samples = Plan {
            samples: pass.samples,
            repetitions: plan.repetitions,
            sampling: plan.sampling,
            seed: combine(plan.seed, index as u64),
        };
        let estimate = run(&density, &samples, |sample| {
            let value = f(&sample.point);
            adaptive.record(sample, value);
            value
        })?;
        let approximation = adaptive.adapt(plan.floor, plan.weighting)?;
        passes.push(PassResult { levels: pass.levels, estimate, density, approximation });
    }
    let estimates: Vec<Estimate> = passes.iter().map(|p| p.estimate).collect();
    let estimate = Estimate::combine(&estimates, plan.weighting).ok_or(DensityError::Samples)?;
    Ok(AdaptiveResult { passes, estimate, adaptive })
}
