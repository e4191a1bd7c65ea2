//! How far a film with passes is.

use crate::guide::Training;
use crate::settled::Blend;

/// The state of passes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Passes {
    /// What the samples of passes that are over weigh, all together.
    pub(crate) weight: f64,
    /// Their number per pixel.
    pub(crate) samples: u64,
    /// What one sample of the last of them weighs; 0 before.
    pub(crate) last: f64,
    /// The guide; `None` before the first sample and for integrators that do not learn.
    pub(crate) training: Option<Box<Training>>,
}

impl Passes {
    /// Number of the first sample after the pass that sample `sample` belongs to.
    pub(crate) fn end_of_pass(&self, sample: u32) -> u32 {
        self.training.as_ref().map_or(u32::MAX, |training| training.pass(sample).end)
    }

    /// Makes what the pass that is over learnt the guide of the next. `brightness`: mean of the picture.
    pub(crate) fn teach(&mut self, brightness: f64) {
        if let Some(training) = &mut self.training {
            training.finish_pass(brightness);
        }
    }

    /// Puts the pass that is over to those before: how, if its `precision` (one over the variance of a sample) is known. `total`: all
    /// samples of a pixel.
    pub(crate) fn settled(&mut self, total: u64, precision: Option<f64>) -> Option<Blend> {
        let weight = precision?.max(self.last);
        let count = total - self.samples;
        let blend = Blend { count, weight, settled: self.weight };
        self.weight += weight * count as f64;
        self.samples = total;
        self.last = weight;
        Some(blend)
    }

    /// How the samples of the pass under way count beside those of passes that are over. Without a `precision` of its own it
    /// counts as the last.
    pub(crate) fn blend(&self, total: u64, precision: Option<f64>) -> Blend {
        let borrowed = if self.last > 0.0 { self.last } else { 1.0 };
        let weight = precision.map_or(borrowed, |own| own.max(self.last));
        Blend { count: total - self.samples, weight, settled: self.weight }
    }
}
