//! Fitting of coefficients to samples of an integrand.

use std::sync::Arc;

use crate::basis::{TensorBasis, check_length};
use crate::density::DensitySample;
use crate::error::DensityError;

/// The substitute for the mean of the integrand under a basis function from which no sample was drawn.
///
/// # Source
/// @pietrek2001 section 2.4.2.3.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum MissingCoefficient {
    /// The integral ("global"): right on average, but much too large where the density is low because the integrand is low, which is
    /// where samples are missing.
    Constant,
    /// The mean of the neighbours along the axes ("local"); neighbours without samples get their own substitutes first.
    #[default]
    Neighbours,
}

/// The method of estimating a coefficient from samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FittingMethod {
    /// Coefficient j from the samples drawn from function j: (w_j / n_j) times the sum of f over them (@pietrek2001 equation 2.17;
    /// in more dimensions 2.21 and 2.22 without their division). One addition per sample. Functions without samples get
    /// substitutes.
    OwnSamples(MissingCoefficient),
    /// Coefficient j from all m samples: (1 / m) times the sum of f N_j / p. (degree + 1)^D additions per sample; a coefficient without
    /// samples is 0.
    AllSamples,
}

impl Default for FittingMethod {
    /// The method of document 003, with local substitutes for missing coefficients.
    fn default() -> Self {
        Self::OwnSamples(MissingCoefficient::default())
    }
}

/// Weights for combining estimates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Weighting {
    /// The numbers of samples (@pietrek2001 section 2.4.5): always unbiased.
    #[default]
    Samples,
    /// The inverse of the estimated variances: less variance if passes differ, but a bias that decreases with the number of samples,
    /// since variance and estimate are correlated. If a variance is unknown, the numbers of samples.
    InverseVariance,
}

/// Sums and counts of samples per basis function, from which the coefficients of an integrand are estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityFitter<const D: usize> {
    basis: Arc<TensorBasis<D>>,
    method: FittingMethod,
    sums: Vec<f64>,
    squares: Vec<f64>,
    counts: Vec<u64>,
    samples: u64,
    /// Sum of |f| / p.
    total: f64,
}

/// Estimates of the inner products of a function with the functions of a basis: its coefficients in the dual basis.
#[derive(Clone, Debug, PartialEq)]
pub struct DualEstimate {
    /// The inner products; without samples, those of the constant `integral` or of [`DualEstimate::fill_from_neighbours`].
    pub values: Vec<f64>,
    /// Variances of the values; infinite with fewer than two samples.
    pub variances: Vec<f64>,
    /// Number of samples for each value.
    pub counts: Vec<u64>,
    /// The integral of the function.
    pub integral: f64,
    /// Number of all samples.
    pub samples: u64,
}

impl<const D: usize> DensityFitter<D> {
    /// A fitter without samples.
    #[must_use]
    pub fn new(basis: Arc<TensorBasis<D>>, method: FittingMethod) -> Self {
        let n = basis.len();
        Self {
            basis,
            method,
            sums: vec![0.0; n],
            squares: vec![0.0; n],
            counts: vec![0; n],
            samples: 0,
            total: 0.0,
        }
    }

    /// Records the value of the integrand at `sample`, which was drawn from a density in the same basis.
    ///
    /// The absolute value is used (@pietrek2001 section 2.4.2.1). Returns `false` if the value is rejected: if it is not finite, or if
    /// the density or the function of the sample is invalid.
    pub fn record(&mut self, sample: &DensitySample<D>, value: f64) -> bool {
        let value = value.abs();
        let ratio = value / sample.pdf;
        let is_valid = sample.pdf > 0.0 && ratio.is_finite() && sample.function < self.counts.len();
        if !is_valid {
            return false;
        }
        self.samples += 1;
        self.total += ratio;
        self.counts[sample.function] += 1;
        match self.method {
            FittingMethod::OwnSamples(_) => {
                self.sums[sample.function] += value;
                self.squares[sample.function] += value * value;
            }
            FittingMethod::AllSamples => {
                let (sums, squares) = (&mut self.sums, &mut self.squares);
                self.basis.for_each_nonzero(&sample.point, |index, n| {
                    sums[index] += ratio * n;
                    squares[index] += (ratio * n) * (ratio * n);
                });
            }
        }
        true
    }

    /// Adds the samples of another fitter with the same basis and method.
    ///
    /// # Errors
    /// [`DensityError::Mismatch`].
    pub fn merge(&mut self, other: &Self) -> Result<(), DensityError> {
        let same_basis = Arc::ptr_eq(&self.basis, &other.basis) || self.basis == other.basis;
        if !same_basis || self.method != other.method {
            return Err(DensityError::Mismatch);
        }
        self.samples += other.samples;
        self.total += other.total;
        self.sums.iter_mut().zip(&other.sums).for_each(|(a, b)| *a += b);
        self.squares.iter_mut().zip(&other.squares).for_each(|(a, b)| *a += b);
        self.counts.iter_mut().zip(&other.counts).for_each(|(a, b)| *a += b);
        Ok(())
    }

    /// Removes all samples.
    pub fn clear(&mut self) {
        self.sums.fill(0.0);
        self.squares.fill(0.0);
        self.counts.fill(0);
        self.samples = 0;
        self.total = 0.0;
    }

    /// Number of recorded samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The basis.
    #[must_use]
    pub fn basis(&self) -> &Arc<TensorBasis<D>> {
        &self.basis
    }

    /// The estimates of the inner products with the functions of the basis; `None` without samples.
    #[must_use]
    pub fn estimate(&self) -> Option<DualEstimate> {
        if self.samples == 0 {
            return None;
        }
        let integral = self.total / self.samples as f64;
        let weights = self.basis.weights();
        let mut estimate = DualEstimate {
            values: Vec::with_capacity(weights.len()),
            variances: Vec::with_capacity(weights.len()),
            counts: self.counts.clone(),
            integral,
            samples: self.samples,
        };
        for (j, w) in weights.iter().enumerate() {
            let (scale, count) = match self.method {
                FittingMethod::OwnSamples(_) => (*w, self.counts[j]),
                FittingMethod::AllSamples => (1.0, self.samples),
            };
            if count == 0 {
                estimate.values.push(integral * w);
                estimate.variances.push(f64::INFINITY);
                continue;
            }
            let n = count as f64;
            let mean = self.sums[j] / n;
            estimate.values.push(scale * mean);
            let spread = if count > 1 {
                (self.squares[j] / n - mean * mean).max(0.0) / (n - 1.0)
            } else {
                f64::INFINITY
            };
            estimate.variances.push(scale * scale * spread);
        }
        if self.method == FittingMethod::AllSamples {
            estimate.counts.fill(self.samples);
        }
        Some(estimate)
    }
}

impl DualEstimate {
    /// Combines this estimate with another one of the same inner products.
    ///
    /// # Errors
    /// [`DensityError::Length`].
    pub fn accumulate(&mut self, new: &Self, weighting: Weighting) -> Result<(), DensityError> {
        check_length(&new.values, self.values.len())?;
        for j in 0..self.values.len() {
            let samples = [self.counts[j] as f64, new.counts[j] as f64];
            let variances = [self.variances[j], new.variances[j]];
            let known = variances.iter().all(|v| v.is_finite() && *v > 0.0);
            let by_variance = weighting == Weighting::InverseVariance && known;
            let [a, b] = if by_variance { variances.map(f64::recip) } else { samples };
            let sum = a + b;
            if sum > 0.0 {
                let [a, b] = [a / sum, b / sum];
                self.values[j] = a * self.values[j] + b * new.values[j];
                // An infinite variance of weight 0 does not count.
                let weighted = |weight: f64, v: f64| if weight > 0.0 { weight * weight * v } else { 0.0 };
                self.variances[j] = weighted(a, variances[0]) + weighted(b, variances[1]);
            }
            self.counts[j] += new.counts[j];
        }
        let all = (self.samples + new.samples) as f64;
        self.integral = (self.samples as f64 * self.integral + new.samples as f64 * new.integral) / all;
        self.samples += new.samples;
        Ok(())
    }

    /// Gives functions without samples the average mean value of their neighbours along the axes, in rounds of increasing distance
    /// from functions with samples.
    ///
    /// # Errors
    /// [`DensityError::Length`] if `basis` has another number of functions.
    pub fn fill_from_neighbours<const D: usize>(
        &mut self,
        basis: &TensorBasis<D>,
    ) -> Result<(), DensityError> {
        check_length(&self.values, basis.len())?;
        let weights = basis.weights();
        let mut known: Vec<bool> = self.counts.iter().map(|&c| c > 0).collect();
        let mut unknown: Vec<usize> = (0..known.len()).filter(|&j| !known[j]).collect();
        while !unknown.is_empty() && unknown.len() < known.len() {
            // A round uses only values known before it, so that the result does not depend on the order.
            let mut substitutes = Vec::new();
            unknown.retain(|&j| {
                let (mut sum, mut count) = (0.0, 0.0);
                for_each_neighbour(basis, j, |k| {
                    if known[k] {
                        sum += self.values[k] / weights[k];
                        count += 1.0;
                    }
                });
                if count > 0.0 {
                    substitutes.push((j, weights[j] * sum / count));
                }
                count == 0.0
            });
            for (j, value) in substitutes {
                self.values[j] = value;
                known[j] = true;
            }
        }
        Ok(())
    }
}

/// Calls `visit` with the neighbours of function `j` along each axis.
fn for_each_neighbour<const D: usize>(basis: &TensorBasis<D>, j: usize, mut visit: impl FnMut(usize)) {
    let mut stride = 1;
    for axis in basis.axes().iter().rev() {
        let position = j / stride % axis.len();
        if position > 0 {
            visit(j - stride);
        }
        if position + 1 < axis.len() {
            visit(j + stride);
        }
        stride *= axis.len();
    }
}
