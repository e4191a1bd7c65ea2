//! The coefficients of an integrand from samples.

use std::sync::Arc;

use crate::basis::{TensorBasis, check_length};
use crate::density::DensitySample;
use crate::error::DensityError;

/// What stands for the mean of the integrand under a function from which no sample was drawn.
///
/// # Source
/// @pietrek2001 section 2.4.2.3.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Missing {
    /// The integral ("global"): right on average, but far too much where the density is low because the integrand is, which is
    /// where samples are missing.
    Constant,
    /// The mean over the neighbours along the axes; those that miss samples too ask theirs first ("local").
    #[default]
    Neighbours,
}

/// Which samples a coefficient is learnt from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Learning {
    /// Coefficient j from the samples drawn from function j: (w_j / n_j) times the sum of f over them (@pietrek2001 equation
    /// 2.17; in more dimensions 2.21 and 2.22 without their division). One addition a sample. Functions from which none was
    /// drawn get their coefficients otherwise.
    OwnSamples(Missing),
    /// Coefficient j from all m samples: (1 / m) times the sum of f N_j / p. (degree + 1)^D additions a sample, and a
    /// coefficient without samples is 0.
    AllSamples,
}

impl Default for Learning {
    /// The document's, with its local way for missing coefficients.
    fn default() -> Self {
        Self::OwnSamples(Missing::default())
    }
}

/// How estimates are put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Weighting {
    /// By their numbers of samples (@pietrek2001 section 2.4.5): always unbiased.
    #[default]
    Samples,
    /// By the inverse of their estimated variances: less variance where passes differ, at the price of a bias that falls with
    /// the number of samples, as variance and estimate know each other. Where a variance is not known, by samples.
    InverseVariance,
}

/// Gathers what samples tell about the coefficients of an integrand: sums and counts, one per function.
#[derive(Clone, Debug, PartialEq)]
pub struct Learner<const D: usize> {
    basis: Arc<TensorBasis<D>>,
    learning: Learning,
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
    /// The inner products; those without samples are the ones of the constant `integral`, unless
    /// [`DualEstimate::fill_from_neighbours`] gave them others.
    pub values: Vec<f64>,
    /// Variances of the values; infinite where less than two samples tell of it.
    pub variances: Vec<f64>,
    /// Samples behind each value.
    pub counts: Vec<u64>,
    /// The integral of the function.
    pub integral: f64,
    /// All samples.
    pub samples: u64,
}

impl<const D: usize> Learner<D> {
    /// A learner that knows nothing yet.
    #[must_use]
    pub fn new(basis: Arc<TensorBasis<D>>, learning: Learning) -> Self {
        let n = basis.len();
        Self {
            basis,
            learning,
            sums: vec![0.0; n],
            squares: vec![0.0; n],
            counts: vec![0; n],
            samples: 0,
            total: 0.0,
        }
    }

    /// Learns that the integrand is `value` at `sample`, drawn from a density in the same basis.
    ///
    /// What is learnt is the absolute value (@pietrek2001 section 2.4.2.1). Returns whether it was: not if it is not finite,
    /// or the density or the function of the sample cannot be.
    pub fn record(&mut self, sample: &DensitySample<D>, value: f64) -> bool {
        let value = value.abs();
        let ratio = value / sample.pdf;
        if !ratio.is_finite() || sample.function >= self.counts.len() {
            return false;
        }
        self.samples += 1;
        self.total += ratio;
        self.counts[sample.function] += 1;
        match self.learning {
            Learning::OwnSamples(_) => {
                self.sums[sample.function] += value;
                self.squares[sample.function] += value * value;
            }
            Learning::AllSamples => {
                let (sums, squares) = (&mut self.sums, &mut self.squares);
                self.basis.for_each_nonzero(&sample.point, |index, n| {
                    sums[index] += ratio * n;
                    squares[index] += (ratio * n) * (ratio * n);
                });
            }
        }
        true
    }

    /// Adds what another learner knows, of the same basis and kind.
    ///
    /// # Errors
    /// [`DensityError::Mismatch`].
    pub fn merge(&mut self, other: &Self) -> Result<(), DensityError> {
        let same_basis = Arc::ptr_eq(&self.basis, &other.basis) || self.basis == other.basis;
        if !same_basis || self.learning != other.learning {
            return Err(DensityError::Mismatch);
        }
        self.samples += other.samples;
        self.total += other.total;
        self.sums.iter_mut().zip(&other.sums).for_each(|(a, b)| *a += b);
        self.squares.iter_mut().zip(&other.squares).for_each(|(a, b)| *a += b);
        self.counts.iter_mut().zip(&other.counts).for_each(|(a, b)| *a += b);
        Ok(())
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.sums.fill(0.0);
        self.squares.fill(0.0);
        self.counts.fill(0);
        self.samples = 0;
        self.total = 0.0;
    }

    /// Samples learnt from.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The basis.
    #[must_use]
    pub fn basis(&self) -> &Arc<TensorBasis<D>> {
        &self.basis
    }

    /// What is known of the inner products with the functions of the basis; `None` without samples.
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
            let (scale, count) = match self.learning {
                Learning::OwnSamples(_) => (*w, self.counts[j]),
                Learning::AllSamples => (1.0, self.samples),
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
        if self.learning == Learning::AllSamples {
            estimate.counts.fill(self.samples);
        }
        Some(estimate)
    }
}

impl DualEstimate {
    /// Puts a further estimate of the same inner products to this one.
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
                let part = |share: f64, v: f64| if share > 0.0 { share * share * v } else { 0.0 };
                self.variances[j] = part(a, variances[0]) + part(b, variances[1]);
            }
            self.counts[j] += new.counts[j];
        }
        let all = (self.samples + new.samples) as f64;
        self.integral = (self.samples as f64 * self.integral + new.samples as f64 * new.integral) / all;
        self.samples += new.samples;
        Ok(())
    }

    /// Gives functions without samples the mean value under the function that those next to them along the axes have, on
    /// average; the further from samples, the later.
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
            // All of a round look at what was known before it: the result does not depend on their order.
            let mut found = Vec::new();
            unknown.retain(|&j| {
                let (mut sum, mut count) = (0.0, 0.0);
                for_each_neighbour(basis, j, |k| {
                    if known[k] {
                        sum += self.values[k] / weights[k];
                        count += 1.0;
                    }
                });
                if count > 0.0 {
                    found.push((j, weights[j] * sum / count));
                }
                count == 0.0
            });
            for (j, value) in found {
                self.values[j] = value;
                known[j] = true;
            }
        }
        Ok(())
    }
}

/// Calls `visit` with the functions one step from function `j` along an axis.
fn for_each_neighbour<const D: usize>(basis: &TensorBasis<D>, j: usize, mut visit: impl FnMut(usize)) {
    let mut stride = 1;
    for axis in basis.axes().iter().rev() {
        let place = j / stride % axis.len();
        if place > 0 {
            visit(j - stride);
        }
        if place + 1 < axis.len() {
            visit(j + stride);
        }
        stride *= axis.len();
    }
}
