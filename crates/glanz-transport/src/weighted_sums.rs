//! Passes that differ in variance, put together.
//!
//! Passes of an integrator that learns become better and better. A sample of a pass counts a = 1 / s, where s is the mean
//! variance of the pass's samples over the whole picture: that makes the variance of the sum least (@muller2019). What is
//! over is kept as sums that have these weights in them.
//!
//! Estimates of s are poor where light is rare: a pass that misses a bright speck seems to be good. Therefore no sample
//! counts less than one of an earlier pass. An outlier in a pass takes the advantage from it, no more; if all goes wrong
//! every sample counts the same, as without passes.
//!
//! The weights come from the samples that they weigh, so the sum is not without bias in the strict sense. But s is a mean over all pixels:
//! each of N moves the weights by about 1 / N of themselves, and its own value by that much of its error, nothing that could be
//! measured. Passes whose variance is not known (fewer than two samples per pixel, or 4096 in all, or no variance) count as one
//! with the next.

use crate::pixel::PixelValue;

/// Samples of all pixels that tell a variance.
pub(crate) const FEWEST_SAMPLES: u64 = 4096;

/// Weights with which the samples of one pass are added to those of others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PassWeights {
    /// Samples of the pass, per pixel.
    pub(crate) count: u64,
    /// Weight of one sample.
    pub(crate) weight: f64,
    /// Weight of all samples of the passes that are over.
    pub(crate) settled: f64,
}

impl PassWeights {
    /// One pass and no other.
    pub(crate) fn plain(count: u64) -> Self {
        Self { count, weight: 1.0, settled: 0.0 }
    }
}

/// Weighted sums of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct WeightedSums {
    radiance: [f64; 3],
    /// Of the signs.
    divisor: f64,
    /// Of the squared deviations, with squared weights: variance of `radiance`.
    variance: [f64; 3],
}

impl WeightedSums {
    /// The sums in a fixed order.
    pub(crate) fn values_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        self.radiance.iter_mut().chain([&mut self.divisor]).chain(&mut self.variance)
    }

    /// Adds a pass: its sum of signs, and sum and squared deviations of each band.
    pub(crate) fn add(&mut self, divisor: f64, bands: &[(f64, f64); 3], blend: &PassWeights) {
        for (i, &(sum, deviation)) in bands.iter().enumerate() {
            self.radiance[i] += blend.weight * sum;
            self.variance[i] += blend.weight * blend.weight * spread(deviation, blend);
        }
        self.divisor += blend.weight * divisor;
    }

    /// Mean and variance of the mean per band, together with a pass that goes on.
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

/// Variance of a pass's sum. A single sample says nothing of it: infinite, or what the weight says if there were passes before.
fn spread(deviation: f64, blend: &PassWeights) -> f64 {
    match blend.count {
        0 => 0.0,
        1 if blend.settled > 0.0 => 1.0 / blend.weight,
        1 => f64::INFINITY,
        n => deviation * (n as f64 / (n - 1) as f64),
    }
}
