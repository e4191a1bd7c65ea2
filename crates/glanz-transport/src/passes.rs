//! Progress of a film with passes.

use crate::guide::Training;
use crate::weighted_sums::PassWeights;

/// The state of passes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Passes {
    /// Total weight of the samples of finished passes.
    pub(crate) weight: f64,
    /// Number of samples per pixel of finished passes.
    pub(crate) samples: u64,
    /// Weight of one sample of the last finished pass; 0 before the first.
    pub(crate) last: f64,
    /// The training state; `None` before the first sample and for integrators that do not learn.
    pub(crate) training: Option<Box<Training>>,
}

impl Passes {
    /// Number of the first sample after the pass of sample `sample`.
    pub(crate) fn end_of_pass(&self, sample: u32) -> u32 {
        self.training.as_ref().map_or(u32::MAX, |training| training.pass(sample).end)
    }

    /// Fits the guide of the next pass from the finished one. `brightness`: mean of the picture.
    pub(crate) fn fit_guide(&mut self, brightness: f64) {
        if let Some(training) = &mut self.training {
            training.finish_pass(brightness);
        }
    }

    /// Merges the finished pass with earlier ones by its `precision` (reciprocal variance of a sample), if known. `total`: all
    /// samples of a pixel.
    pub(crate) fn settled(&mut self, total: u64, precision: Option<f64>) -> Option<PassWeights> {
        let weight = precision?.max(self.last);
        let count = total - self.samples;
        let blend = PassWeights { count, weight, settled: self.weight };
        self.weight += weight * count as f64;
        self.samples = total;
        self.last = weight;
        Some(blend)
    }

    /// Weights of the samples of the current pass and of finished passes. Without a known `precision` the current pass has the weight of the
    /// last one.
    pub(crate) fn blend(&self, total: u64, precision: Option<f64>) -> PassWeights {
        let borrowed = if self.last > 0.0 { self.last } else { 1.0 };
        let weight = precision.map_or(borrowed, |own| own.max(self.last));
        PassWeights { count: total - self.samples, weight, settled: self.weight }
    }
}
