//! A guide that learns while it guides.

use std::ops::Range;

use glanz_light::{Spectrum, Wavelengths};

use glanz_scene::description::PassLengths;

use super::Guide;
use super::grid::{GridRecord, GridSums};
use super::record::PathRecords;
use super::training_sums::TrainingSums;

/// The pass that a sample of a pixel belongs to, if passes double: 0; 1 to 3; 4 to 7; 8 to 15; and so on.
///
/// Every pass from the third on is a block of 2^k Sobol' points that begins at a multiple of 2^k, so each is well spread by
/// itself. The first tells how bright the scene is, the second learns without a guide.
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

/// The same for passes of these lengths. The first measures the brightness here, too; after the last comes one without end.
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

/// The sums of a pass, of the kind that its guide learns from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PassSums {
    Tree(TrainingSums),
    Grid(GridSums),
}

/// The guide of the pass under way, and what the pass has learnt so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Training {
    pub(crate) guide: Guide,
    pub(crate) sums: PassSums,
    /// A typical luminance of the picture, a power of two; `None` in the first pass, which learns nothing else.
    pub(crate) typical: Option<f64>,
}

impl Training {
    /// At the beginning, with a guide that knows nothing.
    pub(crate) fn new(guide: Guide) -> Self {
        let sums = match &guide {
            Guide::Tree(tree) => PassSums::Tree(tree.lessons()),
            Guide::Grid(grid) => PassSums::Grid(grid.sums()),
        };
        Self { guide, sums, typical: None }
    }

    /// The guide of the pass under way.
    #[must_use]
    pub fn guide(&self) -> &Guide {
        &self.guide
    }

    /// The pass that a sample of a pixel belongs to.
    pub(crate) fn pass(&self, sample: u32) -> Range<u32> {
        match self.passes() {
            Some(lengths) => listed(sample, &lengths),
            None => doubled(sample),
        }
    }

    /// The passes that learn, if they are listed.
    fn passes(&self) -> Option<PassLengths> {
        match &self.guide {
            Guide::Tree(_) => None,
            Guide::Grid(grid) => grid.settings().passes,
        }
    }

    /// Directions that the pass under way has learnt from; with a grid, also those of earlier passes that still count.
    #[must_use]
    pub fn records(&self) -> u64 {
        match &self.sums {
            PassSums::Tree(lessons) => lessons.records(),
            PassSums::Grid(sums) => sums.records(),
        }
    }

    /// Adds what a path found: its `records`, and all its light.
    pub(crate) fn learn(&self, records: &PathRecords, all: Spectrum, wavelengths: &Wavelengths) {
        let (Some(typical), PassSums::Tree(lessons)) = (self.typical, &self.sums) else { return };
        for record in &records.directions {
            lessons.add(record, all, wavelengths, typical);
        }
        for record in &records.lamps {
            lessons.add_lamp(record, typical);
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

    /// Ends a pass: what it learnt becomes the guide of the next. `brightness`: mean of the picture.
    pub(crate) fn finish_pass(&mut self, brightness: f64) {
        // Black pictures have no brightness; then any unit is as good.
        let known = brightness > 0.0 && brightness.is_finite();
        let exponent = if known { brightness.log2().floor().clamp(-100.0, 100.0) } else { 0.0 };
        let typical = exponent.exp2();
        if let Some(old) = self.typical.replace(typical) {
            (self.guide, self.sums) = match (&self.guide, &self.sums) {
                (Guide::Tree(tree), PassSums::Tree(lessons)) => {
                    let tree = tree.taught(lessons, old, if known { brightness } else { 0.0 });
                    let lessons = tree.lessons();
                    (Guide::Tree(tree), PassSums::Tree(lessons))
                }
                (Guide::Grid(grid), PassSums::Grid(sums)) => {
                    let (grid, sums) = grid.taught(sums, typical / old);
                    (Guide::Grid(grid), PassSums::Grid(sums))
                }
                // Guide and sums are made together.
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
    fn listed_passes_follow_the_sample_that_tells_the_brightness() {
        let lengths = PassLengths::new(&[2, 5]).unwrap();
        let passes: Vec<_> = [0, 1, 2, 3, 7, 8, 1000].iter().map(|&i| listed(i, &lengths)).collect();
        assert_eq!(passes, [0..1, 1..3, 1..3, 3..8, 3..8, 8..u32::MAX, 8..u32::MAX]);
    }
}
