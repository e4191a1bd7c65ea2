//! Adaptive densities, on one level or from coarse to fine.

use std::sync::Arc;

use crate::basis::{TensorBasis, map_axis};
use crate::density::{
    CoefficientFloor, Density, DensityFitter, DensitySample, DualEstimate, FittingMethod, MissingCoefficient,
    Weighting,
};
use crate::error::DensityError;
use crate::multiresolution::MultiResolution;

/// A tensor product of multiresolution analyses, one per axis of [0, 1]^D; they may differ.
#[derive(Clone, Debug, PartialEq)]
pub struct TensorMultiResolution<const D: usize> {
    analyses: [MultiResolution; D],
}

impl<const D: usize> TensorMultiResolution<D> {
    /// The product of these analyses, one per axis.
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

    /// Converts coefficients from levels `from` to levels `to`, none of which is coarser.
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

/// A density that is fitted to the integrand from its own samples.
///
/// Draw points with [`AdaptiveDensity::sample`] and record the values of the integrand with [`AdaptiveDensity::record`] (on several
/// threads, with one [`DensityFitter`] each). After each pass call [`AdaptiveDensity::fit`] and, for finer levels in the next pass,
/// [`AdaptiveDensity::refine`]. The estimator f / p is unbiased in every pass.
///
/// # Source
/// @pietrek2001 sections 2.4 (one level), 2.5 (from coarse to fine), 2.6 (several dimensions).
#[derive(Clone, Debug)]
pub struct AdaptiveDensity<const D: usize> {
    scales: Arc<TensorMultiResolution<D>>,
    levels: [usize; D],
    density: Density<D>,
    fitter: DensityFitter<D>,
    method: FittingMethod,
    /// Estimate from earlier passes on these levels.
    past: Option<DualEstimate>,
}

impl<const D: usize> AdaptiveDensity<D> {
    /// The constant density on these levels.
    ///
    /// # Errors
    /// [`DensityError::Level`]; those of [`TensorBasis::try_new`].
    pub fn try_new(
        scales: Arc<TensorMultiResolution<D>>,
        levels: [usize; D],
        method: FittingMethod,
    ) -> Result<Self, DensityError> {
        let basis = scales.basis(levels)?;
        let fitter = DensityFitter::new(basis.clone(), method);
        Ok(Self { scales, levels, density: Density::uniform(basis), fitter, method, past: None })
    }

    /// The levels, one per axis.
    #[must_use]
    pub fn levels(&self) -> [usize; D] {
        self.levels
    }

    /// The analyses of its bases.
    #[must_use]
    pub fn scales(&self) -> &Arc<TensorMultiResolution<D>> {
        &self.scales
    }

    /// The method of estimating coefficients.
    #[must_use]
    pub fn method(&self) -> FittingMethod {
        self.method
    }

    /// The current density.
    #[must_use]
    pub fn density(&self) -> &Density<D> {
        &self.density
    }

    /// The samples recorded since the last fit.
    #[must_use]
    pub fn fitter(&self) -> &DensityFitter<D> {
        &self.fitter
    }

    /// An empty fitter, for [`AdaptiveDensity::merge`].
    #[must_use]
    pub fn new_fitter(&self) -> DensityFitter<D> {
        DensityFitter::new(self.density.basis().clone(), self.method)
    }

    /// Adds the samples that another fitter on these levels recorded.
    ///
    /// # Errors
    /// [`DensityError::Mismatch`] if it has other levels.
    pub fn merge(&mut self, fitter: &DensityFitter<D>) -> Result<(), DensityError> {
        self.fitter.merge(fitter)
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

    /// As [`DensityFitter::record`].
    pub fn record(&mut self, sample: &DensitySample<D>, value: f64) -> bool {
        self.fitter.record(sample, value)
    }

    /// Fits the density to the samples of this and earlier passes on these levels, combined by `weighting`, and returns the
    /// coefficients of the approximation of the integrand before `floor` is applied.
    ///
    /// Without samples, or if the integrand was 0 at all of them, the density stays unchanged and the result is `None`.
    ///
    /// # Errors
    /// Those of [`Density::from_approximation`].
    pub fn fit(
        &mut self,
        floor: CoefficientFloor,
        weighting: Weighting,
    ) -> Result<Option<Vec<f64>>, DensityError> {
        let Some(new) = self.fitter.estimate() else { return Ok(None) };
        let estimate = match self.past.take() {
            Some(mut past) => {
                past.accumulate(&new, weighting)?;
                past
            }
            None => new,
        };
        self.fitter.clear();
        let basis = self.density.basis().clone();
        let mut filled = estimate.clone();
        if self.method == FittingMethod::OwnSamples(MissingCoefficient::Neighbours) {
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

    /// Converts the density to finer levels (none may be coarser). Estimates from passes on the old levels remain only in the
    /// density.
    ///
    /// # Errors
    /// [`DensityError::Level`].
    pub fn refine(&mut self, levels: [usize; D]) -> Result<(), DensityError> {
        if levels == self.levels {
            return Ok(());
        }
        let coefficients = self.scales.refine(self.density.coefficients(), self.levels, levels)?;
        let basis = self.scales.basis(levels)?;
        self.fitter = DensityFitter::new(basis.clone(), self.method);
        self.density = Density::try_new(basis, coefficients)?;
        self.levels = levels;
        self.past = None;
        Ok(())
    }
}
