//! Times that the phases of a bake are expected to take.

use super::direct_light::{self, DirectRuns};
use super::gather::FinalGather;
use super::lookup::SurfaceIndex;
use super::progress::BakeProgress;
use super::{BakeMethod, BakeSettings};
use crate::charts::Chart;
use crate::elements::Elements;

/// Usual number of points at which indirect light is gathered, per texel of the charts that light reaches.
const POINTS_PER_TEXEL: f64 = 0.6;

/// Usual number of elements of the hierarchical solver per texel of the charts that light reaches.
const ELEMENTS_PER_TEXEL: f64 = 0.12;

/// Usual times of the phases of elements and of texels, relative to that of the rays of elements.
const TIME_OF_ELEMENTS: f64 = 0.8;
const TIME_OF_TEXELS: f64 = 0.5;

/// Expected times of the phases after that of direct light.
#[derive(Clone, Copy, Debug)]
pub(super) struct PhaseTimes {
    method: BakeMethod,
    /// Seconds of the phase of elements, if their number is known.
    elements: f64,
    /// Seconds per element, and per point of the final gather.
    per_element: f64,
    per_point: f64,
    /// Share of the points that are gathered.
    share: f64,
}

impl PhaseTimes {
    /// By trials without light: rays take the same time. `share`: the share of the points that are gathered, (0, 1].
    pub(super) fn new(
        elements: &Elements<'_>,
        index: &SurfaceIndex,
        charts: &[Chart],
        settings: &BakeSettings,
        share: f64,
    ) -> Self {
        let dark = direct_light::maps(charts, &DirectRuns::new());
        let trial = FinalGather::new(elements, index, charts, &dark, settings);
        let [per_element, per_point] = trial.trial_times();
        let count = elements.list.len() as f64;
        Self { method: settings.method, elements: per_element * count, per_element, per_point, share }
    }

    /// Expects times for a number of texels on charts that light reaches.
    pub(super) fn expect(&self, lit_texels: f64, progress: &mut BakeProgress<'_>) {
        match self.method {
            BakeMethod::Gather => {
                progress.expect(2, self.elements);
                progress.expect(3, self.share * POINTS_PER_TEXEL * lit_texels * self.per_point);
            }
            BakeMethod::Radiosity { .. } => {
                let rays = ELEMENTS_PER_TEXEL * lit_texels * self.per_element;
                progress.expect(2, TIME_OF_ELEMENTS * rays);
                progress.expect(3, rays);
                progress.expect(4, TIME_OF_TEXELS * rays);
            }
        }
    }
}
