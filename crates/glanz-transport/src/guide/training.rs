//! Training of a guide over the passes of a render.

use std::ops::Range;

use glanz_light::{Spectrum, Wavelengths};

use glanz_scene::description::PassLengths;

use super::Guide;
use super::grid::{GridRecord, GridSums};
use super::record::PathRecords;
use super::training_sums::TrainingSums;

/// The pass of a sample of a pixel, with passes of doubled length: 0; 1 to 3; 4 to 7; 8 to 15; and so on.
///
/// Every pass from the third on is a block of 2^k Sobol' points that begins at a multiple of 2^k, so that each is well distributed by
/// itself. The first pass measures the brightness of the scene, the second trains without a guide.
fn doubled(sample: u32) -> Range<u32> {
    match sample {
        0 => 0..1,
        1..4 => 1..4,
        _ => {
            let start = 1 << sample.ilog2();
            start..start.saturating_mul(2)
        }
    }
}

/// The pass of a sample, with passes of these lengths. The first pass measures the brightness here, too; the pass after the last is unlimited.
fn listed(sample: u32, lengths: &PassLengths) -> Range<u32> {
    let mut start = 0;
    for length in std::iter::once(1).chain(lengths.iter()) {
        if sample < start + length {
            return start..start + length;
        }
        start += length;
    }
    start..u32::MAX
}

/// The sums of a pass, of the kind of its guide.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PassSums {
    Tree(TrainingSums),
    Grid(GridSums),
}

/// The guide of the current pass, and the sums of the pass so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Training {
    pub(crate) guide: Guide,
    pub(crate) sums: PassSums,
    /// A typical luminance of the picture, a power of two; `None` in the first pass, which measures it.
    pub(crate) typical: Option<f64>,
}

impl Training {
    /// The initial state, with an untrained guide.
    pub(crate) fn new(guide: Guide) -> Self {
        let sums = match &guide {
            Guide::Tree(tree) => PassSums::Tree(tree.sums()),
            Guide::Grid(grid) => PassSums::Grid(grid.sums()),
        };
        Self { guide, sums, typical: None }
    }

    /// The guide of the current pass.
    #[must_use]
    pub fn guide(&self) -> &Guide {
        &self.guide
    }

    /// The pass of a sample of a pixel.
    pub(crate) fn pass(&self, sample: u32) -> Range<u32> {
        match self.passes() {
            Some(lengths) => listed(sample, &lengths),
            None => doubled(sample),
        }
    }

    /// The training passes, if they are listed.
    fn passes(&self) -> Option<PassLengths> {
        match &self.guide {
            Guide::Tree(_) => None,
            Guide::Grid(grid) => grid.settings().passes,
        }
    }

    /// Number of directions recorded in the current pass; with a grid, also those of earlier passes that still count.
    #[must_use]
    pub fn records(&self) -> u64 {
        match &self.sums {
            PassSums::Tree(sums) => sums.records(),
            PassSums::Grid(sums) => sums.records(),
        }
    }

    /// Adds the `records` of a path; `all`: the light of the path.
    pub(crate) fn learn(&self, records: &PathRecords, all: Spectrum, wavelengths: &Wavelengths) {
        let (Some(typical), PassSums::Tree(sums)) = (self.typical, &self.sums) else { return };
        for record in &records.directions {
            sums.add(record, all, wavelengths, typical);
        }
        for record in &records.light_groups {
            sums.add_light(record, typical);
        }
    }

    /// As [`Training::learn`], with a grid.
    pub(crate) fn learn_on_grid(&self, records: &[GridRecord], all: Spectrum, wavelengths: &Wavelengths) {
        let (Some(typical), Guide::Grid(grid), PassSums::Grid(sums)) =
            (self.typical, &self.guide, &self.sums)
        else {
            return;
        };
        if grid.is_finished() {
            return;
        }
        for record in records {
            sums.add(record, all, wavelengths, typical);
        }
    }

    /// Ends a pass: the guide of the next is fitted to its sums. `brightness`: mean of the picture.
    pub(crate) fn finish_pass(&mut self, brightness: f64) {
        // Black pictures have no brightness; any unit serves.
        let known = brightness > 0.0 && brightness.is_finite();
        let exponent = if known { brightness.log2().floor().clamp(-100.0, 100.0) } else { 0.0 };
        let typical = exponent.exp2();
        if let Some(old) = self.typical.replace(typical) {
            (self.guide, self.sums) = match (&self.guide, &self.sums) {
                (Guide::Tree(tree), PassSums::Tree(sums)) => {
                    let tree = tree.fitted(sums, old, if known { brightness } else { 0.0 });
                    let sums = tree.sums();
                    (Guide::Tree(tree), PassSums::Tree(sums))
                }
                (Guide::Grid(grid), PassSums::Grid(sums)) => {
                    let (grid, sums) = grid.fitted(sums, typical / old);
                    (Guide::Grid(grid), PassSums::Grid(sums))
                }
                // Guide and sums are always of the same kind.
                _ => return,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_in_one_pass() {
        let mut sample = 0;
        for length in [1, 3, 4, 8, 16, 32, 64, 128] {
            for i in sample..sample + length {
                assert_eq!(doubled(i), sample..sample + length);
            }
            sample += length;
        }
        assert_eq!(doubled((1 << 30) - 1), 1 << 29..1 << 30);
        assert_eq!(doubled(u32::MAX), 1 << 31..u32::MAX);
    }

    #[test]
    fn listed_passes_follow_the_sample_that_measures_the_brightness() {
        let lengths = PassLengths::new(&[2, 5]).unwrap();
        let passes: Vec<_> = [0, 1, 2, 3, 7, 8, 1000].iter().map(|&i| listed(i, &lengths)).collect();
        assert_eq!(passes, [0..1, 1..3, 1..3, 3..8, 3..8, 8..u32::MAX, 8..u32::MAX]);
    }
}
