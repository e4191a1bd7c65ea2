//! Weighted sums of passes of different variance.
//!
//! The variance of a learning integrator decreases from pass to pass. A sample of a pass has the weight a = 1 / s, where s is the mean
//! variance of the pass's samples over the whole picture, which minimises the variance of the sum (@muller2019). Finished
//! passes are stored as weighted sums.
//!
//! Estimates of s are poor where light is rare: a pass that misses a bright spot appears to be good. Therefore no sample
//! has a smaller weight than one of an earlier pass. An outlier in a pass removes its advantage, no more; in the worst case
//! all samples have the same weight, as without passes.
//!
//! The weights depend on the samples themselves, so that the sum is not strictly unbiased. But s is a mean over all pixels:
//! each of N pixels changes the weights by about 1 / N, and its own value by this fraction of its error, which is too small to be
//! measured. Passes of unknown variance (fewer than two samples per pixel, fewer than 4096 in all, or no variance) are combined
//! with the next.

use crate::pixel::PixelValue;

/// Smallest number of samples over all pixels for an estimate of the variance.
pub(crate) const FEWEST_SAMPLES: u64 = 4096;

/// Weights for adding the samples of one pass to those of others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PassWeights {
    /// Samples of the pass, per pixel.
    pub(crate) count: u64,
    /// Weight of one sample.
    pub(crate) weight: f64,
    /// Total weight of all samples of finished passes.
    pub(crate) settled: f64,
}

impl PassWeights {
    /// The weights of a single pass.
    pub(crate) fn plain(count: u64) -> Self {
        Self { count, weight: 1.0, settled: 0.0 }
    }
}

/// Weighted sums of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct WeightedSums {
    radiance: [f64; 3],
    /// Sum of the signs.
    divisor: f64,
    /// Sum of the squared deviations, with squared weights: the variance of `radiance`.
    variance: [f64; 3],
}

impl WeightedSums {
    /// The sums in a fixed order.
    pub(crate) fn values_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        self.radiance.iter_mut().chain([&mut self.divisor]).chain(&mut self.variance)
    }

    /// Adds a pass: its sum of signs, and for each band the sum and the sum of squared deviations.
    pub(crate) fn add(&mut self, divisor: f64, bands: &[(f64, f64); 3], blend: &PassWeights) {
        for (i, &(sum, deviation)) in bands.iter().enumerate() {
            self.radiance[i] += blend.weight * sum;
            self.variance[i] += blend.weight * blend.weight * spread(deviation, blend);
        }
        self.divisor += blend.weight * divisor;
    }

    /// Mean and variance of the mean per band, together with the current pass.
    pub(crate) fn with(&self, divisor: f64, bands: &[(f64, f64); 3], blend: &PassWeights) -> [PixelValue; 3] {
        let mut all = *self;
        all.add(divisor, bands, blend);
        let weight = blend.settled + blend.weight * blend.count as f64;
        let divisor = all.divisor.max(0.25 * weight);
        std::array::from_fn(|i| {
            if weight <= 0.0 {
                return PixelValue { mean: 0.0, variance: f64::INFINITY };
            }
            PixelValue { mean: all.radiance[i] / divisor, variance: all.variance[i] / (divisor * divisor) }
        })
    }
}

/// Variance of a pass's sum. For a single sample it is infinite, or that of its weight after earlier passes.
fn spread(deviation: f64, blend: &PassWeights) -> f64 {
    match blend.count {
        0 => 0.0,
        1 if blend.settled > 0.0 => 1.0 / blend.weight,
        1 => f64::INFINITY,
        n => deviation * (n as f64 / (n - 1) as f64),
    }
}
