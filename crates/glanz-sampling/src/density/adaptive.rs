//! Densities that follow an integrand, on one scale or from coarse to fine.

use std::sync::Arc;

use crate::basis::{TensorBasis, map_axis};
use crate::density::{Density, DensitySample, DualEstimate, Floor, Learner, Learning, Missing, Weighting};
use crate::error::DensityError;
use crate::multiresolution::MultiResolution;

/// The multiresolution analyses of the axes of [0, 1]^D; they may differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Scales<const D: usize> {
    analyses: [MultiResolution; D],
}

impl<const D: usize> Scales<D> {
    /// These analyses, one per axis.
    #[must_use]
    pub fn new(analyses: [MultiResolution; D]) -> Self {
        Self { analyses }
    }

    /// The analyses.
    #[must_use]
    pub fn analyses(&self) -> &[MultiResolution; D] {
        &self.analyses
    }

    /// The tensor product basis on these levels, one per axis.
    ///
    /// # Errors
    /// [`DensityError::Level`]; those of [`TensorBasis::try_new`].
    pub fn basis(&self, levels: [usize; D]) -> Result<Arc<TensorBasis<D>>, DensityError> {
        let mut axes = Vec::with_capacity(D);
        for (analysis, level) in self.analyses.iter().zip(levels) {
            axes.push(analysis.basis(level)?.clone());
        }
        let axes = axes.try_into().map_err(|_| DensityError::Mismatch)?;
        Ok(Arc::new(TensorBasis::try_new(axes)?))
    }

    /// The coefficients on levels `to` of the function with these coefficients on levels `from`, none of which is finer.
    ///
    /// # Errors
    /// [`DensityError::Level`], [`DensityError::Length`].
    pub fn refine(
        &self,
        coefficients: &[f64],
        from: [usize; D],
        to: [usize; D],
    ) -> Result<Vec<f64>, DensityError> {
        let mut shape = [0; D];
        for (a, analysis) in self.analyses.iter().enumerate() {
            shape[a] = analysis.basis(from[a])?.len();
        }
        crate::basis::check_length(coefficients, shape.iter().product())?;
        let mut refined = coefficients.to_vec();
        for (a, analysis) in self.analyses.iter().enumerate() {
            let mut failed = Ok(());
            refined = map_axis(&refined, &shape, a, |line| {
                analysis.refine(line, from[a], to[a]).unwrap_or_else(|error| {
                    failed = Err(error);
                    line.to_vec()
                })
            });
            failed?;
            shape[a] = analysis.basis(to[a])?.len();
        }
        Ok(refined)
    }
}

/// A density that learns the integrand it samples.
///
/// Draw points with [`AdaptiveDensity::sample`], tell the integrand's values with [`AdaptiveDensity::record`] (or, from
/// several threads, with a [`Learner`] for each), and after each pass [`AdaptiveDensity::adapt`] and, for a finer scale in
/// the next one, [`AdaptiveDensity::refine`]. Estimates f / p are unbiased in every pass.
///
/// # Source
/// @pietrek2001 sections 2.4 (one scale), 2.5 (from coarse to fine), 2.6 (several dimensions).
#[derive(Clone, Debug)]
pub struct AdaptiveDensity<const D: usize> {
    scales: Arc<Scales<D>>,
    levels: [usize; D],
    density: Density<D>,
    learner: Learner<D>,
    learning: Learning,
    /// What earlier passes on this scale have learnt.
    past: Option<DualEstimate>,
}

impl<const D: usize> AdaptiveDensity<D> {
    /// The constant density on these levels.
    ///
    /// # Errors
    /// [`DensityError::Level`]; those of [`TensorBasis::try_new`].
    pub fn try_new(
        scales: Arc<Scales<D>>,
        levels: [usize; D],
        learning: Learning,
    ) -> Result<Self, DensityError> {
        let basis = scales.basis(levels)?;
        let learner = Learner::new(basis.clone(), learning);
        Ok(Self { scales, levels, density: Density::uniform(basis), learner, learning, past: None })
    }

    /// The levels, one per axis.
    #[must_use]
    pub fn levels(&self) -> [usize; D] {
        self.levels
    }

    /// The density as it is now.
    #[must_use]
    pub fn density(&self) -> &Density<D> {
        &self.density
    }

    /// What was recorded since the last adaption.
    #[must_use]
    pub fn learner(&self) -> &Learner<D> {
        &self.learner
    }

    /// A learner for [`AdaptiveDensity::learn_from`].
    #[must_use]
    pub fn new_learner(&self) -> Learner<D> {
        Learner::new(self.density.basis().clone(), self.learning)
    }

    /// Adds what a learner of this scale recorded.
    ///
    /// # Errors
    /// [`DensityError::Mismatch`] if it is of another scale.
    pub fn learn_from(&mut self, learner: &Learner<D>) -> Result<(), DensityError> {
        self.learner.merge(learner)
    }

    /// As [`Density::pdf`].
    #[inline]
    #[must_use]
    pub fn pdf(&self, x: &[f64; D]) -> f64 {
        self.density.pdf(x)
    }

    /// As [`Density::sample`].
    #[inline]
    #[must_use]
    pub fn sample(&self, xi: &[f64; D]) -> DensitySample<D> {
        self.density.sample(xi)
    }

    /// As [`Learner::record`].
    pub fn record(&mut self, sample: &DensitySample<D>, value: f64) -> bool {
        self.learner.record(sample, value)
    }

    /// Makes the density of what was learnt in this and earlier passes on this scale, which are put together by
    /// `weighting`; returns the coefficients of the approximation of the integrand, as they were before the floor.
    ///
    /// The density stays as it is, and `None` is returned, if nothing was learnt or the integrand was 0 everywhere.
    ///
    /// # Errors
    /// Those of [`Density::from_approximation`].
    pub fn adapt(&mut self, floor: Floor, weighting: Weighting) -> Result<Option<Vec<f64>>, DensityError> {
        let Some(new) = self.learner.estimate() else { return Ok(None) };
        let estimate = match self.past.take() {
            Some(mut past) => {
                past.accumulate(&new, weighting)?;
                past
            }
            None => new,
        };
        self.learner.clear();
        let basis = self.density.basis().clone();
        let mut filled = estimate.clone();
        if self.learning == Learning::OwnSamples(Missing::Neighbours) {
            filled.fill_from_neighbours(&basis)?;
        }
        self.past = Some(estimate);
        let DualEstimate { values: mut approximation, integral: mean, .. } = filled;
        if mean <= 0.0 {
            return Ok(None);
        }
        basis.to_primary(&mut approximation)?;
        self.density = Density::from_approximation(basis, approximation.clone(), mean, floor)?;
        Ok(Some(approximation))
    }

    /// Goes on with the same density on finer levels (none may be coarser); what was learnt on the old ones is in the
    /// density only.
    ///
    /// # Errors
    /// [`DensityError::Level`].
    pub fn refine(&mut self, levels: [usize; D]) -> Result<(), DensityError> {
        if levels == self.levels {
            return Ok(());
        }
        let coefficients = self.scales.refine(self.density.coefficients(), self.levels, levels)?;
        let basis = self.scales.basis(levels)?;
        self.learner = Learner::new(basis.clone(), self.learning);
        self.density = Density::try_new(basis, coefficients)?;
        self.levels = levels;
        self.past = None;
        Ok(())
    }
}
